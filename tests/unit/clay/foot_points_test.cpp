#include "clay/field/foot_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace argil::clay {
namespace {

// A level set through voxels a step within the rim is that of the cells before them: what lies around the field, here
// no numbers at all, is not read.
TEST(FootPoints, ReadNothingBeyondTheField) {
  const Coord size{12, 11, 13};
  const size_t all = voxelIndex(size, {size.x, 0, 0}), around = voxelIndex(size, {3, 0, 0});
  for (int axis = 0; axis < 3; ++axis)
    for (const int from : {1, static_cast<int>(size.toVec3d()[axis]) - 2}) {
      std::vector<float> field(all + 2 * around, std::numeric_limits<float>::quiet_NaN());
      float* const phi = field.data() + around;
      for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y)
          for (int z = 0; z < size.z; ++z) {
            const Coord v{x, y, z};
            phi[voxelIndex(size, v)] = static_cast<float>(v.toVec3d()[axis] - from);
          }
      const float side = from == 1 ? 1 : -1;  // cells on the other one have no voxel around them
      FootPoints points;
      points.make({phi, size, 100, side, 0},
                  {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}, {8, 8, 0}, {8, 0, 8}, {0, 8, 8}, {8, 8, 8}});
      int found = 0, looked = 0;
      for (const int x : {0, 8})
        for (const int y : {0, 8})
          for (const int z : {0, 8}) {
            const Coord low{x, y, z};
            if (!points.approach(low, 30)) continue;
            ++found;
            float distance[kBrickVoxels];
            points.measure(~uint64_t{0}, distance);
            for (int i = 0; i < kBrickVoxels; ++i) {
              const Coord v = low + Coord{i >> 6, i >> 3 & 7, i & 7};
              Vec3d inwards = v.toVec3d().cwiseMin(size.toVec3d() - v.toVec3d());
              inwards[axis] = 4;
              if (inwards.minCoeff() < 4) continue;  // beside the points of the rim
              const double there = side * (v.toVec3d()[axis] - from);
              if (there < 0) continue;
              ++looked;
              ASSERT_NEAR(distance[i], there, 1e-3)
                  << "axis " << axis << " at " << from << ", voxel " << v.x << " " << v.y << " " << v.z;
            }
          }
      EXPECT_GT(looked, 100);
      EXPECT_EQ(found, 8) << "axis " << axis << " at " << from << " side " << side;
    }
}

}  // namespace
}  // namespace argil::clay
