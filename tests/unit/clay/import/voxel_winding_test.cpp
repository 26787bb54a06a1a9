#include "clay/import/voxel_winding.h"

#include <gtest/gtest.h>

#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

constexpr uint64_t kSeed = 3;

TEST(VoxelWinding, IsTheWindingNumberOfTheOpenMeshAlone) {
  // Two balls that overlap, each with faces missing here and there: many rims, some of them touching.
  TriangleMesh mesh = testing::icosphere({20, 20, 20}, 12.3, 3);
  testing::append(mesh, testing::icosphere({31.7, 22, 19}, 9.1, 3));
  std::mt19937_64 random(kSeed);
  std::erase_if(mesh.triangles, [&](const auto&) { return random() % 7 == 0; });
  const RepairedMesh repaired = repairMesh(mesh);
  ASSERT_GT(repaired.openEdges.size(), 100u);
  const VoxelWinding voxels(repaired);
  EXPECT_TRUE(voxels.open());
  const WindingNumber winding(repaired.mesh);
  double worst = 0;
  for (int i = 0; i < 3000; ++i) {
    const Coord v{int32_t(random() % 48), int32_t(random() % 40), int32_t(random() % 40)};
    worst = std::max(worst, std::abs(voxels.at(v) - winding.exact(v.toVec3d())));
  }
  EXPECT_LE(worst, 0.01) << "seed " << kSeed;
}

// Of a soup, whose rims are all there is, the numbers of whole bricks are found together.
TEST(VoxelWinding, BricksOfASoupHaveTheNumbersOfTheirVoxels) {
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(0, 60), edge(-15, 15);
  TriangleMesh mesh;
  for (uint32_t i = 0; i < 60; ++i) {
    const Vec3d middle(place(random), place(random), place(random));
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(middle + Vec3d(edge(random), edge(random), edge(random)));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const RepairedMesh repaired = repairMesh(mesh);
  const VoxelWinding voxels(repaired);
  ASSERT_TRUE(voxels.mostlyRims());
  EXPECT_FALSE(VoxelWinding(repairMesh(testing::icosphere({20, 20, 20}, 12.3, 3))).mostlyRims());
  const WindingNumber winding(repaired.mesh);
  double worst = 0;
  for (int i = 0; i < 40; ++i) {
    const Coord first{8 * int32_t(random() % 9) - 8, 8 * int32_t(random() % 9) - 8, 8 * int32_t(random() % 9) - 8};
    std::array<float, 512> numbers;
    voxels.fill(first, numbers);
    for (int v = 0; v < 512; ++v) {
      const Coord at = first + Coord{v / 64, v / 8 % 8, v % 8};
      worst = std::max(worst, std::abs(double(numbers[size_t(v)]) - winding.exact(at.toVec3d())));
    }
  }
  EXPECT_LE(worst, 0.02) << "seed " << kSeed;
}

TEST(VoxelWinding, IsAnIntegerWithoutHoles) {
  const VoxelWinding voxels(repairMesh(testing::icosphere({20, 20, 20}, 12.3, 3)));
  EXPECT_FALSE(voxels.open());
  EXPECT_EQ(voxels.at({20, 20, 20}), 1.0f);
  EXPECT_EQ(voxels.at({40, 20, 20}), 0.0f);
}

TEST(VoxelWinding, IsSmoothAcrossARimOnVoxelPlanes) {
  TriangleMesh mesh = testing::box({4, 4, 4}, {20, 20, 20});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // without the face z = 20
  const VoxelWinding voxels(repairMesh(mesh));
  for (int x = 6; x < 19; ++x) {
    for (int y = 6; y < 19; ++y) EXPECT_NEAR(voxels.at({x, y, 20}), 0.5, 0.01) << x << ' ' << y;
  }
}

}  // namespace
}  // namespace argil::clay
