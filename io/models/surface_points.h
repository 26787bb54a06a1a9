#pragma once
// The points of a surface as renderers have them. For this module's files.

#include <array>
#include <cstdint>
#include <vector>

#include "io/models/model_file.h"

namespace argil::io {

/// A vertex where colours or normals jump from triangle to triangle becomes several points.
struct SurfacePoints {
  std::vector<uint32_t> vertex;                    ///< Of each point; empty: points are the vertices.
  std::vector<Colour> colours;                     ///< One a point, or empty.
  std::vector<std::array<float, 3>> normals;       ///< One a point, of unit length, outwards; or empty.
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Of points; empty with `vertex`.
  [[nodiscard]] size_t count(const ModelObject& object) const {
    return vertex.empty() ? object.mesh.positions.size() : vertex.size();
  }
};

enum class Normals : uint8_t {
  none,
  /// The mean of the triangles around a vertex, apart for those that an edge sharper than kCreaseDegrees divides.
  creased,
  joined,  ///< The same, with vertices in one place taken as one: for meshes whose colours part their vertices.
};
inline constexpr double kCreaseDegrees = 40;

/// Memory while it works: 12 bytes a triangle and 4 a vertex beside what it returns, 12 a triangle and 16 a point.
/// Throws Error beyond 1 431 655 765 triangles. N. Max, Weights for Computing Vertex Normals from Facet Normals (1999).
[[nodiscard]] SurfacePoints pointsOf(const ModelObject& object, Normals normals);

}  // namespace argil::io
