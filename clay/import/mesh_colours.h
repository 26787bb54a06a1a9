#pragma once
// The colours of a mesh become those of the clay that was made of it.

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "clay/base/work_part.h"
#include "clay/mesh/triangle_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

using MeshColour = std::array<uint8_t, 3>;  ///< sRGB.

/// Colours of a mesh: one a vertex, blended over the triangles, or one a triangle, or any at each of its points. The
/// spans must outlive their use.
struct MeshColours {
  std::span<const MeshColour> vertices = {};
  std::span<const MeshColour> triangles = {};  ///< Go before `vertices`.
  /// Gives the colour, and how much of it covers the piece's own, at a point of a triangle as shares of its corners;
  /// goes before the others. Any number of threads.
  std::function<std::array<uint8_t, 4>(size_t triangle, const Vec3d& shares)> at = {};
};

/// The same clay in a new version: every voxel of the band has the colour of the mesh's nearest point, which covers the
/// piece's own. `mesh`, in mm, has a triangle at least. Throws Error when there is not one colour for each vertex, or
/// triangle; Cancelled. `threads` (1 to 64) change nothing in the result. Cost: a search for each voxel of the band,
/// about 1 µs; four bytes a voxel of memory that stay. Any thread.
[[nodiscard]] Version withMeshColours(const Version& version, const TriangleMesh& mesh, const MeshColours& colours,
                                      const WorkPart& part, int threads = 0);

}  // namespace argil::clay
