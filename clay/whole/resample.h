#pragma once
// The same clay on another grid.

#include <Eigen/Geometry>

#include "clay/base/job.h"
#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

/// `version`, moved by `pose` (its mm to the result's), as a full narrow band on `grid`, in a store of its own. `pose`
/// may be a reflection too. Where voxels come to lie on voxels every bit is kept; anything else is read by cubic
/// splines from distances that are measured farther than the band where the new voxels are larger, in steps of at most
/// twice the voxel. Channels are those of the old clay at the place, colours between voxels by their nearness.
/// `threads`: 0 for all cores; it does not change the result. Throws Error for a bad grid, a pose that is not finite
/// and a piece that would be out of reach or finer than 2^30 voxels of band, Cancelled. Cost follows the surface, in
/// the voxels of the finer of both.
[[nodiscard]] Version resample(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose, int threads = 0,
                               Job* job = nullptr);
[[nodiscard]] Version resample(const Version& version, const Grid& grid, const Eigen::Isometry3d& pose, int threads,
                               const WorkPart& part);

/// How far two surfaces lie apart.
struct ResampleError {
  double lostRmsMm = 0, lostMaxMm = 0;    ///< From points of the first's surface to the second's.
  double addedRmsMm = 0, addedMaxMm = 0;  ///< From points of the second's to the first's.
  uint64_t points = 0;                    ///< So many were looked at, on both.
  double voxelMm = 0;                     ///< Of the second: divide by it for voxels.
  [[nodiscard]] double rmsMm() const { return std::max(lostRmsMm, addedRmsMm); }
  [[nodiscard]] double maxMm() const { return std::max(lostMaxMm, addedMaxMm); }
};

/// Measured where voxel edges cross the surfaces, at a million points on each at most, as the other's distance there; a
/// point that lies beyond its band counts as the band. Cancelled.
[[nodiscard]] ResampleError resampleError(const Version& before, const Version& after, const Eigen::Isometry3d& pose,
                                          int threads, const WorkPart& part);

}  // namespace argil::clay
