#pragma once
// How thick the walls of a mesh are: what voxels of a size would lose, known before clay is made.

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// Of points spread evenly over the surface.
struct WallThickness {
  /// Where there is an opposite side, ascending: the inscribed ball that touches there, up to 1 % too large.
  std::vector<double> wallsMm;
  /// Volume of the smallest body that has one: below some voxels across it is rounded off, and goes.
  double leastBodyMm3 = HUGE_VAL;
  size_t points = 0;  ///< Looked at; where there is no opposite side (a convex edge, a sheet) is no wall.

  /// Part of the surface, 0 to 1, that bounds walls thinner than this: voxels of that size lose them, or parts of them.
  [[nodiscard]] double shareThinner(double mm) const;
  /// A voxel, in mm to two digits, that keeps the walls: two of them across all but the thinnest thousandth, six across
  /// the smallest body; 0 when there is no wall. Knife edges count by their area: they are thin at any voxel size.
  [[nodiscard]] double keepingVoxelMm() const;
};

/// A place on a mesh, the way out of it, and the area for which it stands.
struct SurfacePlace {
  Vec3d at, outwards;
  double area = 1;
};
/// Returns the median, by area, of the thickness of the mesh's walls at these places, measured as wallThickness() does;
/// 0 where no place has an opposite side. Takes a search tree over the triangles.
[[nodiscard]] double medianThickness(const TriangleMesh& mesh, std::span<const SurfacePlace> places);

inline constexpr size_t kWallPoints = 20000;

/// Of a mesh in mm: the inside is where its faces point away from (all are taken the other way where its volume is
/// negative); faces within other bodies are no walls. At least one triangle with an area, or nothing is found. Results
/// do not depend on `threads` (0: all cores). Throws Cancelled. Cost: a search tree over the triangles and about 20
/// searches a point: 0.5 s, and 0.3 s for each million triangles.
[[nodiscard]] WallThickness wallThickness(const TriangleMesh& mesh, const WorkPart& part, size_t points = kWallPoints,
                                          int threads = 0);

}  // namespace argil::clay
