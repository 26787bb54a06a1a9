#include "clay/whole/ways_out.h"

#include "clay/field/region_work.h"
#include "clay/whole/resample.h"

namespace argil::clay {

std::vector<Neck> narrowWaysOut(const Version& version, double radiusMm, int threads, const WorkPart& part) {
  threads = threadCount(threads);
  Grid grid = version.grid();
  if (!(radiusMm > kMostNeckVoxels * grid.voxelMm)) return narrowNecks(version, radiusMm, threads, part);
  grid.voxelMm = radiusMm / kResampledNeckVoxels;
  const Version coarse = resample(version, grid, Eigen::Isometry3d::Identity(), threads, part.part(0, 0.5));
  return narrowNecks(coarse, radiusMm, threads, part.part(0.5, 1));
}

}  // namespace argil::clay
