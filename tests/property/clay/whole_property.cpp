// Whole-piece operations on random clay: what every result must be.

#include <gtest/gtest.h>

#include <random>

#include "clay/boolean.h"
#include "clay/loose_parts.h"
#include "clay/mirror.h"
#include "clay/offset.h"
#include "clay/primitives.h"
#include "clay/resample.h"
#include "clay/smooth_all.h"
#include "clay/store.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole_checks.h"

namespace argil::clay {
namespace {

Version randomClay(std::mt19937_64& random, const std::shared_ptr<Store>& store) {
  std::uniform_real_distribution<double> u(-1, 1);
  Version clay = makeSphere(store, Grid{}, Vec3d(u(random), u(random), u(random)) * 4, 8 + 2 * u(random));
  for (int i = 0; i < 4; ++i) {
    const Vec3d at = Vec3d(u(random), u(random), u(random)) * 9;
    const Version other = i % 2 ? makeBlock(store, Grid{}, at, Vec3d(7, 8, 9) + 3 * Vec3d(u(random), u(random), u(random)), 0)
                                : makeSphere(store, Grid{}, at, 4.5 + 2 * u(random));
    clay = combine(clay, other, random() % 3 == 0 ? Combination::cut : Combination::join);
  }
  return clay;
}

// Equal content has equal bits, whatever path led there: written anew it is the same.
void expectCanonical(const Version& version) {
  Editor editor(Version::empty(Store::make(), version.grid()));
  version.forEachBrick([&](const Brick& brick) { editor.setVoxels(brick.coord, testing::valuesOf(brick)); });
  uint64_t bricks = 0;
  const Version again = editor.commit();
  version.forEachBrick([&](const Brick& brick) {
    ++bricks;
    const Brick* other = again.find(brick.coord).brick();
    ASSERT_NE(other, nullptr);
    ASSERT_TRUE(std::ranges::equal(testing::valuesOf(brick), testing::valuesOf(*other)));
    ASSERT_TRUE(std::equal(std::begin(brick.inside), std::end(brick.inside), other->inside));
  });
  EXPECT_EQ(again.stats().bricks, bricks);
}

TEST(WholePieces, ResultsAreClosedBandsOnRandomClay) {
  constexpr uint64_t kSeed = 20261120;
  std::printf("seed %lu\n", static_cast<unsigned long>(kSeed));
  std::mt19937_64 random(kSeed);
  double steepest = 0;
  for (int i = 0; i < 6; ++i) {
    const auto store = Store::make();
    const Version clay = randomClay(random, store), other = randomClay(random, store);
    std::uniform_real_distribution<double> u(-1, 1);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(u(random) * 3, Vec3d(u(random), u(random), u(random)).normalized()));
    Grid grid;
    grid.voxelMm = 0.5 * std::exp2(u(random));
    std::vector<Version> results{combine(clay, other, static_cast<Combination>(i % 3)), offset(clay, 1 + 3 * std::abs(u(random)), 2), shell(clay, 0.8, 0.8, 2),
                                 resample(clay, grid, pose, 2), mirrorHalf(clay, Vec3d(u(random), 0, 0), Vec3d(1, u(random), 0), 2), smoothAll(clay, 2, true, 2),
                                 fillVoids(clay).version, removeCrumbs(clay, 5).version};
    const std::vector<Version> parts = splitParts(clay);
    results.insert(results.end(), parts.begin(), parts.end());
    for (size_t k = 0; k < results.size(); ++k) {
      SCOPED_TRACE(::testing::Message() << "clay " << i << " result " << k);
      if (results[k].stats().bricks == 0) continue;
      const auto faults = testing::bandFaults(results[k]);
      steepest = std::max(steepest, faults.steepest);
      EXPECT_EQ(faults.besideTile, 0u);
      EXPECT_LE(faults.steepest, 1.1);
      testing::expectClosed(results[k], 0);
      expectCanonical(results[k]);
    }
  }
  std::printf("steepest difference between neighbours: %.3f voxel\n", steepest);
}

}  // namespace
}  // namespace argil::clay
