// Corners of three faces in the grade that is seen at once.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid(double voxelMm) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}

// How far the corners of a box lie off a surface at most, voxels.
double cornersOff(const Version& version, const Vec3d& middle, const Vec3d& size) {
  Surface surface(true, Grade::crisp);
  surface.update(version);
  const TriangleMesh mesh = surface.toMesh();
  EXPECT_TRUE(checkTopology(mesh).solid());
  const NearestTriangle tree(mesh);
  double most = 0;
  for (unsigned k = 0; k < 8; ++k) {
    const Vec3d side((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
    most = std::max(most, tree.nearest(middle + 0.5 * side.cwiseProduct(size)).squared);
  }
  return std::sqrt(most) / version.grid().voxelMm;
}

// Whether faces lie on planes of the grid, halfway between two, or anywhere.
TEST(Corners, OfABlockAreWhereTheyAre) {
  const Vec3d size(20, 16, 12);
  for (const double voxel : {0.37, 0.4, 0.5, 1.0})
    for (const Vec3d& middle : {Vec3d(0, 0, 0), Vec3d(0.25, 0.5, 6), Vec3d(0.13, 0.27, 0.41), Vec3d(-0.31, 0.09, 0.77)})
      EXPECT_LT(cornersOff(makeBlock(Store::make(), grid(voxel), middle, size, 0), middle, size), 0.15)
          << voxel << " at " << middle.transpose();
}

// Inner corners: a block is cut out of a ball.
TEST(Corners, OfAHollowAreWhereTheyAre) {
  const Vec3d size(16, 14, 12);
  for (const Vec3d& middle : {Vec3d(0, 0, 0), Vec3d(0.13, 0.27, 0.41), Vec3d(-0.31, 0.09, 0.77)}) {
    const Version hollow = combine(makeSphere(Store::make(), grid(0.5), Vec3d::Zero(), 20),
                                   makeBlock(Store::make(), grid(0.5), middle, size, 0), Combination::cut);
    EXPECT_LT(cornersOff(hollow, middle, size), 0.15) << middle.transpose();
  }
}

}  // namespace
}  // namespace argil::clay
