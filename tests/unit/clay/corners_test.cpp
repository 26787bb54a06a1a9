// Corners of three faces in the grade that is seen at once.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/import/mesh_to_clay.h"
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

// How far some corners lie off a surface at most, voxels.
double cornersOff(const Version& version, const std::vector<Vec3d>& corners) {
  Surface surface(true, Grade::crisp);
  surface.update(version);
  const TriangleMesh mesh = surface.toMesh();
  EXPECT_TRUE(checkTopology(mesh).solid());
  const NearestTriangle tree(mesh);
  double most = 0;
  for (const Vec3d& each : corners) most = std::max(most, tree.nearest(each).squared);
  return std::sqrt(most) / version.grid().voxelMm;
}
std::vector<Vec3d> cornersOf(const Vec3d& middle, const Vec3d& size) {
  std::vector<Vec3d> corners;
  for (unsigned k = 0; k < 8; ++k)
    corners.push_back(
        middle + 0.5 * Vec3d((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1).cwiseProduct(size));
  return corners;
}

// How far vertices near the corners of a block lie off it at most, voxels.
double verticesOff(const Version& block, const Vec3d& middle, const Vec3d& size) {
  Surface surface(false, Grade::crisp);
  surface.update(block);
  double most = 0;
  for (const Vec3d& each : surface.toMesh().positions) {
    const Vec3d beyond = (each - middle).cwiseAbs() - 0.5 * size;
    if (beyond.minCoeff() > -4 * block.grid().voxelMm) most = std::max(most, std::abs(beyond.maxCoeff()));
  }
  return most / block.grid().voxelMm;
}

// Whether faces lie on planes of the grid, halfway between two, or anywhere.
TEST(Corners, OfABlockAreWhereTheyAre) {
  const Vec3d size(20, 16, 12);
  for (const double voxel : {0.37, 0.4, 0.5, 1.0})
    for (const Vec3d& middle :
         {Vec3d(0, 0, 0), Vec3d(0.25, 0.5, 6), Vec3d(0.13, 0.27, 0.41), Vec3d(-0.31, 0.09, 0.77)}) {
      const Version block = makeBlock(Store::make(), grid(voxel), middle, size, 0);
      EXPECT_LT(cornersOff(block, cornersOf(middle, size)), 0.15) << voxel << " at " << middle.transpose();
      EXPECT_LT(verticesOff(block, middle, size), 0.15) << voxel << " at " << middle.transpose();
    }
}

// As a mesh that comes in anyhow turned.
TEST(Corners, OfATurnedBlockAreNear) {
  TriangleMesh block;
  block.positions = cornersOf(Vec3d::Zero(), {20, 16, 12});
  block.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                     {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  for (int k = 0; k < 6; ++k) {
    TriangleMesh turned = block;
    const Eigen::AngleAxisd by(0.3 + 0.7 * k, Vec3d(1, 0.3 * k, 0.5).normalized());
    for (Vec3d& each : turned.positions) each = by * each;
    const Version version = meshToClay(Store::make(), turned, ImportOptions{.grid = grid(0.5)}, nullptr).version;
    EXPECT_LT(cornersOff(version, turned.positions), 0.4) << k;
  }
}

// Inner corners: a block is cut out of a ball.
TEST(Corners, OfAHollowAreWhereTheyAre) {
  const Vec3d size(16, 14, 12);
  for (const Vec3d& middle : {Vec3d(0, 0, 0), Vec3d(0.13, 0.27, 0.41), Vec3d(-0.31, 0.09, 0.77)}) {
    const Version hollow = combine(makeSphere(Store::make(), grid(0.5), Vec3d::Zero(), 20),
                                   makeBlock(Store::make(), grid(0.5), middle, size, 0), Combination::cut);
    EXPECT_LT(cornersOff(hollow, cornersOf(middle, size)), 0.15) << middle.transpose();
  }
}

}  // namespace
}  // namespace argil::clay
