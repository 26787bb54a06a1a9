#include "clay/import/winding_columns.h"

#include <gtest/gtest.h>

#include "clay/import/mesh_repair.h"
#include "clay/mesh/winding_number.h"
#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

constexpr uint64_t kSeed = 11;

TEST(WindingColumns, CountsWhatAVoxelLiesIn) {
  TriangleMesh mesh = testing::icosphere({20, 20, 20}, 9.3, 3);
  testing::append(mesh, testing::box({18, 18, 18}, {40, 22, 22}));  // on voxel planes
  const WindingColumns columns(mesh);
  EXPECT_EQ(columns.at({20, 20, 25}), 1);
  EXPECT_EQ(columns.at({20, 20, 20}), 2);
  EXPECT_EQ(columns.at({35, 20, 20}), 1);
  EXPECT_EQ(columns.at({35, 20, 30}), 0);
  EXPECT_EQ(columns.at({-1000, 20, 20}), 0);
  EXPECT_EQ(columns.at({1000, 20, 20}), 0);
  EXPECT_TRUE(WindingColumns(TriangleMesh{}).column(0, 0).empty());
}

TEST(WindingColumns, AgreesWithSolidAngles) {
  TriangleMesh mesh;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(10, 40), size(2, 9);
  for (int i = 0; i < 12; ++i)
    testing::append(mesh, testing::icosphere({place(random), place(random), place(random)}, size(random), 2));
  const WindingColumns columns(mesh);
  const WindingNumber winding(mesh);
  int most = 0;
  for (int i = 0; i < 3000; ++i) {
    const Coord v{int32_t(random() % 50), int32_t(random() % 50), int32_t(random() % 50)};
    ASSERT_EQ(columns.at(v), int(std::lround(winding.exact(v.toVec3d()))))
        << "seed " << kSeed << " voxel " << v.x << ' ' << v.y << ' ' << v.z;
    most = std::max(most, columns.at(v));
  }
  EXPECT_GE(most, 2) << "the bodies were meant to overlap";
}

TEST(WindingColumns, EveryColumnOfAClosedMeshSumsToZero) {
  // Corners, edges and faces on voxels and on each other's planes: nothing may slip between two faces.
  TriangleMesh mesh;
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 30; ++i) {
    const auto at = [&] { return double(random() % 20); };
    const Vec3d low(at(), at(), at());
    testing::append(mesh, testing::box(low, low + Vec3d(1 + at(), 1 + at(), 1 + at())));
  }
  testing::append(mesh, testing::icosphere({15, 15, 15}, 8, 2));
  const WindingColumns columns(mesh);
  for (int x = -1; x < 45; ++x) {
    for (int y = -1; y < 45; ++y) {
      const auto column = columns.column(x, y);
      if (!column.empty()) {
        ASSERT_EQ(column.front().above, 0) << x << ' ' << y;
      }
    }
  }
}

}  // namespace
}  // namespace argil::clay
