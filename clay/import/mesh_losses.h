#pragma once
// What clay has, or has not, beside the mesh that it was made of.

#include "clay/base/work_part.h"
#include "clay/import/mesh_repair.h"
#include "clay/store/version.h"

namespace argil::clay {

struct MeshLosses {
  /// Bodies and cavities below kSpeckVoxels that were no body of the mesh, but what sampling left of something thinner
  /// than a voxel: they were removed. None where they are more than a 20th of the clay.
  uint64_t specks = 0;
  double speckMm3 = 0;  ///< Of them together.
  uint64_t bodies = 0;  ///< Of the clay, without them.
  uint64_t cavities = 0;
  double meshMm3 = 0;  ///< Volume of a sound mesh of one body; else 0: bodies may overlap.
  double clayMm3 = 0;  ///< Volume within the clay's surface in Grade::fine; 0 where meshMm3 is.
  /// Area of the mesh with no clay near, or with clay of no thickness: both sides of walls thinner than a voxel.
  double lostMm2 = 0;
  double lostThickMm = 0;          ///< Thickness of the mesh there, median; 0 where there is no opposite side.
  Vec3d lostAtMm = Vec3d::Zero();  ///< The middle of it.
};

inline constexpr double kSpeckVoxels = 64;

/// Takes specks out of `version`, which was made of `repaired` (in voxels of its grid), and looks at the rest. Cost:
/// O(bricks + triangles), and a search tree over the triangles where there is something small.
[[nodiscard]] MeshLosses takeSpecks(Version& version, const RepairedMesh& repaired, const WorkPart& part);

}  // namespace argil::clay
