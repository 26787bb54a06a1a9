#pragma once
// Which cells of a closed surface are one face, as a CAD program would count them: creases part faces.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// Triangles or quads, and what is beside each across its sides.
struct SurfaceCells {
  size_t sides = 3;                      ///< 3 or 4.
  std::vector<uint32_t> corners;         ///< Vertices, `sides` a cell, counter-clockwise.
  std::vector<uint32_t> across;          ///< The cell beyond the side from a corner to the next.
  std::vector<float> lengths;            ///< Of those sides, mm.
  std::vector<float> areas;              ///< Of cells, mm².
  std::vector<Eigen::Vector3f> normals;  ///< Of cells, length 1; slivers have that of what lies beside them.

  [[nodiscard]] size_t count() const { return areas.size(); }
  /// Cost: a sort of all sides. Throws Error where a side has no partner that goes the other way.
  template <size_t Sides>
  SurfaceCells(const std::vector<Vec3d>& positions, const std::vector<std::array<uint32_t, Sides>>& cells);
};

/// The face of each cell, by the number of one of its cells. `bent`: which sides are creases, in the order of
/// `across`, the same from both cells. Faces begin where no crease is near and grow until they meet, so that two that
/// meet through a short gap of a crease stay two; borders of which less than kMostlyBent is crease are none. What is
/// narrower than `leastWidth` mm goes to the face that it shares most with.
[[nodiscard]] std::vector<uint32_t> facesOf(const SurfaceCells& cells, const std::vector<bool>& bent,
                                            double leastWidth);

/// Faces become connected, of kFewCells cells and more, without cells that have all sides but one in another. `face`:
/// any numbers, UINT32_MAX where none is known; at the end as facesOf().
void tidyFaces(const SurfaceCells& cells, std::vector<uint32_t>& face);

inline constexpr double kMostlyBent = 0.6;
inline constexpr uint32_t kFewCells = 4;

}  // namespace argil::clay
