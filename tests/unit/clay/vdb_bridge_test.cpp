#include "clay/store/vdb_bridge.h"

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay_checks.h"

namespace argil::clay {
namespace {

Version there(const Version& version) {
  return fromVdb(version.store(), version.grid(), toVdb(version));
}

TEST(VdbBridge, KeepsEveryBit) {
  const auto store = Store::make();
  Grid grid;
  grid.originMm = {-3, 5, 7};
  const Version sphere = makeSphere(store, grid, {0.3, -0.2, 0.1}, 20.3);
  const Version block = makeBlock(store, grid, {40, -30, 10}, {50, 30, 20}, 2);
  EXPECT_EQ(there(sphere).hash(), sphere.hash());
  EXPECT_EQ(there(block).hash(), block.hash());
  EXPECT_NE(sphere.hash(), block.hash());
}

TEST(VdbBridge, KeepsALargeInterior) {
  // Inside tiles of 8 and 128 voxels across, on both sides of zero.
  const auto store = Store::make();
  Grid grid;
  grid.voxelMm = 1;
  grid.band = 2;
  const Version block = makeBlock(store, grid, {-500, 1200, 90}, {700, 600, 620}, 0);
  const Version back = there(block);
  EXPECT_EQ(back.hash(), block.hash());
  EXPECT_EQ(back.stats().bricks, block.stats().bricks);
  EXPECT_EQ(back.stats().nodes, block.stats().nodes);
  EXPECT_EQ(testing::clayVolume(back), testing::clayVolume(block));
}

TEST(VdbBridge, KeepsNothingAsNothing) {
  const Version empty = Version::empty(Store::make(), Grid{});
  EXPECT_EQ(there(empty).hash(), empty.hash());
}

TEST(VdbBridge, StopsWhenCancelled) {
  const auto store = Store::make();
  const Version sphere = makeSphere(store, Grid{}, {0, 0, 0}, 10);
  const VdbGrid grid = toVdb(sphere);
  Job job;
  job.cancel();
  EXPECT_THROW((void)toVdb(sphere, &job), Cancelled);
  EXPECT_THROW((void)fromVdb(store, sphere.grid(), grid, &job), Cancelled);
}

}  // namespace
}  // namespace argil::clay
