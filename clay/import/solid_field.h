#pragma once
// The narrow band around the solid that triangles bound, whatever holes, fins and overlaps they have.

#include "clay/import/mesh_repair.h"
#include "clay/store/vdb_bridge.h"

namespace argil::clay {

struct SolidField {
  VdbGrid grid;  ///< Signed distance in voxels, narrow band on both sides of the whole surface, tiles signed.
  uint64_t bandVoxels = 0;
  uint64_t insideVoxels = 0;  ///< Those of them that are inside.
  uint64_t closingEdges = 0;  ///< Voxel edges that cross the surface that closes holes.
  double closedArea = 0;      ///< Area of that surface, voxels²: within 5 % for holes of 20 voxels and more.
  /// Voxels of the band whose nearest triangle does not bound the solid, beside closed holes apart.
  uint64_t droppedVoxels = 0;
};

/// Inside is where the winding number of the mesh (positions in voxels) exceeds a half. Distances are exact to the
/// triangles that bound the inside; to the surface that closes holes and beside folds of overlapping bodies they are
/// first order. Steps, tolerances and their reasons: NOTES.md, "Steps". Runs on the calling TBB arena's threads.
[[nodiscard]] SolidField solidField(const RepairedMesh& repaired, float band, Job* job = nullptr);

}  // namespace argil::clay
