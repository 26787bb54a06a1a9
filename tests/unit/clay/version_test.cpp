#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/mesh_samples.h"
#include "tests/unit/clay/clay_checks.h"

namespace argil::clay {
namespace {

std::array<float, kBrickVoxels> constantBrick(float value) {
  std::array<float, kBrickVoxels> phi;
  phi.fill(value);
  return phi;
}

void collectAll(const std::shared_ptr<Store>& store) {
  while (store->collect()) {
  }
}

TEST(Version, EmptyIsOutsideEverywhere) {
  const Version v = Version::empty(Store::make(), Grid{});
  EXPECT_EQ(v.find({0, 0, 0}), Slot(Tile::outside));
  EXPECT_EQ(v.find({kBrickReach + 100, 0, 0}), Slot(Tile::outside));
  EXPECT_EQ(v.stats().bricks, 0u);
}

TEST(Version, GridOutOfRangeIsRefused) {
  const auto store = Store::make();
  for (const double voxel : {0.0, 9e-4, 1.1e3, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    Grid grid;
    grid.voxelMm = voxel;
    EXPECT_THROW(Version::empty(store, grid), Error) << voxel;
  }
  Grid far;
  far.originMm = {0, 1.1e6, 0};
  EXPECT_THROW(Version::empty(store, far), Error);
  Grid band;
  band.band = 1;
  EXPECT_THROW(Version::empty(store, band), Error);
}

TEST(Version, AnEditLeavesItsBaseAsItWas) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  const uint64_t before = base.hash();
  Editor editor(base);
  editor.setVoxels({4, 0, 0}, constantBrick(1));
  const Version next = editor.commit();
  EXPECT_EQ(base.hash(), before);
  EXPECT_NE(next.hash(), before);
  EXPECT_GT(next.id(), base.id());
  EXPECT_EQ(next.find({4, 0, 0}).brick()->phi(0), 1);
}

TEST(Version, UntouchedBricksAreShared) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  Editor editor(base);
  editor.setVoxels({4, 0, 0}, constantBrick(1));
  const Version next = editor.commit();
  uint64_t different = 0;
  Version::forEachDifference(base, next, [&](Coord c, Slot, Slot) {
    EXPECT_EQ(c, (Coord{4, 0, 0}));
    ++different;
  });
  EXPECT_EQ(different, 1u);
}

TEST(Version, CanonicalWhateverThePath) {
  const auto store = Store::make();
  const Version base = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  // There and back again, by way of bricks, tiles and whole blocks.
  Editor there(base);
  for (int x = -3; x < 3; ++x) there.setVoxels({x, 0, 0}, constantBrick(0.5f));
  const Version middle = there.commit();
  Editor back(middle);
  for (int x = -3; x < 3; ++x) {
    const Slot old = base.find({x, 0, 0});
    if (old.isTile())
      back.setTile({x, 0, 0}, old.tile());
    else
      back.setVoxels({x, 0, 0}, testing::valuesOf(*old.brick()));
  }
  const Version again = back.commit();
  EXPECT_EQ(again.hash(), base.hash());
  EXPECT_EQ(again.stats().bricks, base.stats().bricks);
  EXPECT_EQ(again.stats().nodes, base.stats().nodes);
}

TEST(Version, BrickOutOfBandBecomesATileAndNodesCollapse) {
  const auto store = Store::make();
  const Version empty = Version::empty(store, Grid{});
  Editor editor(empty);
  editor.setVoxels({1, 2, 3}, constantBrick(1));
  const Version one = editor.commit();
  EXPECT_EQ(one.stats().bricks, 1u);
  EXPECT_EQ(one.stats().nodes, static_cast<uint64_t>(kTreeLevels));
  Editor undo(one);
  undo.setVoxels({1, 2, 3}, constantBrick(100));
  const Version none = undo.commit();
  EXPECT_EQ(none.stats().bricks, 0u);
  EXPECT_EQ(none.stats().nodes, 0u);
  EXPECT_EQ(none.hash(), empty.hash());
}

TEST(Version, ValuesAreClampedAndZeroIsOutside) {
  Editor editor(Version::empty(Store::make(), Grid{}));
  auto phi = constantBrick(-0.0f);
  phi[1] = -7;
  phi[2] = 1e30f;
  editor.setVoxels({0, 0, 0}, phi);
  const Version v = editor.commit();
  const Brick& brick = *v.find({0, 0, 0}).brick();
  EXPECT_FALSE(std::signbit(brick.phi(0)));
  EXPECT_EQ(brick.phi(1), -3);
  EXPECT_EQ(brick.phi(2), 3);
  EXPECT_EQ(brick.inside[0], 2u);
}

TEST(Editor, RefusesNotANumberAndOutOfReach) {
  Editor editor(Version::empty(Store::make(), Grid{}));
  auto phi = constantBrick(0);
  phi[100] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(editor.setVoxels({0, 0, 0}, phi), Error);
  EXPECT_THROW(editor.setTile({kBrickReach, 0, 0}, Tile::inside), Error);
  EXPECT_EQ(editor.commit().stats().bricks, 0u);
}

TEST(Editor, WithoutChangeCommitsTheBase) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  Editor editor(base);
  editor.setVoxels({4, 0, 0}, testing::valuesOf(*base.find({4, 0, 0}).brick()));
  EXPECT_EQ(editor.commit(), base);
}

TEST(Editor, AbandonedGivesAllBack) {
  const auto store = Store::make();
  const Version base = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  const auto before = store->usage();
  {
    Editor editor(base);
    for (int x = -4; x < 4; ++x) editor.setVoxels({x, 1, 1}, constantBrick(1));
    editor.setBlock({0, 0, 0}, 1, Tile::inside);
  }
  EXPECT_EQ(store->usage().bricks, before.bricks);
  EXPECT_EQ(store->usage().nodes, before.nodes);
}

TEST(Editor, BlockReplacesWhatStood) {
  const auto store = Store::make();
  const Version base = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  Editor editor(base);
  for (int level = 1; level <= kTreeLevels; ++level) editor.setBlock({0, 0, 0}, level, Tile::outside);
  const Version v = editor.commit();
  EXPECT_EQ(v.hash(), Version::empty(store, Grid{}).hash());
  EXPECT_EQ(v.stats().bricks, 0u);
}

// A random walk through versions, undo and branches: what is live is always what a walk over the held versions finds.
TEST(Store, FreesExactlyWhatNoHeldVersionUses) {
  const uint64_t seed = 20261120;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  std::vector<Version> held{makeSphere(store, Grid{}, Vec3d::Zero(), 15)};
  std::vector<uint64_t> hashes{held[0].hash()};
  for (int step = 0; step < 400; ++step) {
    const size_t from = random() % held.size();
    Editor editor(held[from]);
    for (int i = 0; i < 5; ++i) {
      const Coord c{static_cast<int>(random() % 20) - 10, static_cast<int>(random() % 20) - 10,
                    static_cast<int>(random() % 20) - 10};
      if (random() % 3 == 0)
        editor.setTile(c, random() % 2 ? Tile::inside : Tile::outside);
      else
        editor.setVoxels(c, constantBrick(static_cast<float>(random() % 100) / 100));
    }
    held.push_back(editor.commit());
    hashes.push_back(held.back().hash());
    while (held.size() > 6) {
      const auto drop = static_cast<ptrdiff_t>(random() % held.size());
      held.erase(held.begin() + drop);
      hashes.erase(hashes.begin() + drop);
    }
    store->collect(random() % 50);
    for (size_t i = 0; step % 40 == 0 && i < held.size(); ++i) ASSERT_EQ(held[i].hash(), hashes[i]) << "step " << step;
  }
  // One straight line left: nothing but its own bricks may be live.
  held.resize(1);
  collectAll(store);
  EXPECT_EQ(store->usage().versions, 1u);
  EXPECT_EQ(store->usage().bricks, held[0].stats().bricks);
  EXPECT_EQ(store->usage().nodes, held[0].stats().nodes);
  EXPECT_EQ(held[0].hash(), hashes[0]);
  held.clear();
  collectAll(store);
  EXPECT_EQ(store->usage().bricks, 0u);
  EXPECT_EQ(store->usage().nodes, 0u);
  EXPECT_EQ(store->usage().versions, 0u);
}

TEST(Store, CollectsInBoundedSteps) {
  const auto store = Store::make();
  Version v = makeSphere(store, Grid{}, Vec3d::Zero(), 40);
  const uint64_t bricks = v.stats().bricks;
  v = Version();
  ASSERT_TRUE(store->collect(100));
  EXPECT_GE(store->usage().bricks, bricks - 200);
  collectAll(store);
  EXPECT_EQ(store->usage().bricks, 0u);
}

TEST(Version, MemoryABrickStaysInBudget) {
  const Version v = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 100);  // 200 voxels: 3 M active
  EXPECT_LE(static_cast<double>(v.stats().bytes()) / static_cast<double>(v.stats().bricks), 2.2 * 1024);
}

TEST(Primitives, SphereHoldsExactDistances) {
  Grid grid;
  grid.originMm = {10, -20, 30};
  const Vec3d centre(12.3, -18.1, 33.3);
  const Version v = makeSphere(Store::make(), grid, centre, 20);
  v.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; i += 37) {
      const Vec3d p = grid.toWorld((brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d());
      const double exact = std::clamp(((p - centre).norm() - 20) / grid.voxelMm, -3.0, 3.0);
      ASSERT_NEAR(brick.phi(i), exact, 1e-5);
    }
  });
  EXPECT_EQ(v.find({0, 0, 0}), Slot(Tile::inside));
}

TEST(Primitives, BlockWithoutRoomIsRefused) {
  EXPECT_THROW(makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {10, 10, 10}, 6), Error);
  EXPECT_THROW(makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {0.1, 10, 10}, 0), Error);
  EXPECT_THROW(makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 1e6), Error);
  for (const double at : {1e6, std::nan("")}) {
    const auto made = [&] { (void)makeSphere(Store::make(), Grid{}, Vec3d(0, 0, at), 10); };
    EXPECT_NE(samples::errorOf(made).find("set the grid's origin near it"), std::string::npos) << at;
  }
}

// Within its brick each mesh is the same: where the bricks are tells the two surfaces apart.
TEST(SurfaceHash, TellsWhereTheBricksAre) {
  const auto hashAt = [](double x) {
    Grid grid;
    grid.voxelMm = 1;
    Surface surface;
    surface.update(makeSphere(Store::make(), grid, Vec3d::Constant(64) + x * Vec3d::UnitX(), 10));
    return surface.hash();
  };
  EXPECT_EQ(hashAt(0), hashAt(0));
  EXPECT_NE(hashAt(0), hashAt(64 * kBrickEdge));
}

}  // namespace
}  // namespace argil::clay
