// Islands and hollows, layer by layer: shapes whose answers are known, and random ones beside a plain flood.

#include "clay/field/slice_sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <queue>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

constexpr double kVoxel = 0.5;

Grid grid() {
  Grid grid;
  grid.voxelMm = kVoxel;
  return grid;
}
Version block(const Vec3d& middle, const Vec3d& edges) {
  return makeBlock(Store::make(), grid(), middle, edges, 0);
}
Version sphere(const Vec3d& middle, double radius) {
  return makeSphere(Store::make(), grid(), middle, radius);
}
Version joined(const Version& a, const Version& b) {
  return combine(a, b, Combination::join);
}
Version without(const Version& a, const Version& b) {
  return combine(a, b, Combination::cut);
}
SliceReport swept(const Version& version) {
  return sweepSlices(version, WorkPart(nullptr));
}

TEST(SliceSweep, ABallHasNothing) {
  const SliceReport report = swept(sphere({3, 1, 50}, 12));
  EXPECT_TRUE(report.islands.empty());
  EXPECT_TRUE(report.traps.empty());
  EXPECT_GT(report.runs, 1000u);
  EXPECT_EQ(swept(Version::empty(Store::make(), grid())).runs, 0u);
}

TEST(SliceSweep, ACupHoldsWhatFitsBelowItsRim) {
  // 20 × 20 × 20 mm, with 14 × 14 mm from z = −6 up.
  const Version cup = without(block({0, 0, 0}, {20, 20, 20}), block({0, 0, 5}, {14, 14, 22}));
  const SliceReport report = swept(cup);
  EXPECT_TRUE(report.islands.empty());
  ASSERT_EQ(report.traps.size(), 1u);
  const Trap& trap = report.traps[0];
  EXPECT_FALSE(trap.closed);
  EXPECT_NEAR(trap.volumeMm3, 14 * 14 * 16, 14 * 14 * kVoxel + 4 * 14 * 16 * kVoxel);
  EXPECT_NEAR(trap.at.z(), -6, kVoxel);
  EXPECT_NEAR(trap.spillsMm, 10, 1.01 * kVoxel);
  // With a hole in its bottom it holds nothing; with one in its side, what is below that.
  EXPECT_TRUE(swept(without(cup, block({0, 0, -8}, {3, 3, 10}))).traps.empty());
  const SliceReport half = swept(without(cup, block({8, 0, 3}, {10, 3, 3})));
  ASSERT_EQ(half.traps.size(), 1u);
  EXPECT_NEAR(half.traps[0].spillsMm, 1.5, 1.01 * kVoxel);
  EXPECT_NEAR(half.traps[0].volumeMm3, 14 * 14 * 7.5, 14 * 14 * kVoxel + 4 * 14 * 7.5 * kVoxel);
}

TEST(SliceSweep, AClosedHollowIsFoundWithItsVolume) {
  const SliceReport report = swept(without(sphere({0, 0, 0}, 12), sphere({0, 0, 1}, 6)));
  ASSERT_EQ(report.traps.size(), 1u);
  EXPECT_TRUE(report.traps[0].closed);
  EXPECT_NEAR(report.traps[0].volumeMm3, 4.0 / 3 * M_PI * 216, 20);
  EXPECT_NEAR(report.traps[0].at.z(), -5, kVoxel);
}

TEST(SliceSweep, WhatBeginsInTheAirIsAnIsland) {
  // A gallows: a post, a beam, and a knob that hangs from its end to 4 mm above the bed.
  const Version post = block({0, 0, 10}, {4, 4, 20}), beam = block({8, 0, 18}, {20, 4, 4}),
                knob = block({14, 0, 11}, {4, 4, 14});
  const SliceReport report = swept(joined(joined(post, beam), knob));
  ASSERT_EQ(report.islands.size(), 1u);
  EXPECT_NEAR(report.islands[0].at.z(), 4, kVoxel);
  EXPECT_NEAR(report.islands[0].aloneMm, 12, 2 * kVoxel);
  EXPECT_TRUE(report.traps.empty());
  // Two feet are no islands; a body of its own is one.
  EXPECT_TRUE(swept(joined(joined(post, beam), block({14, 0, 9}, {4, 4, 18}))).islands.empty());
  const SliceReport two = swept(joined(post, sphere({20, 0, 15}, 3)));
  ASSERT_EQ(two.islands.size(), 1u);
  EXPECT_NEAR(two.islands[0].at.z(), 12, kVoxel);
  EXPECT_EQ(two.islands[0].aloneMm, 0);
}

// The same by a flood over every voxel, from the outside, the lowest rim first.
struct Flood {
  explicit Flood(const Version& version) {
    constexpr int kHalf = 40;
    const auto inside = [&](int x, int y, int z) {
      const Coord brick{x >> 3, y >> 3, z >> 3};
      BrickValues scratch;
      return version.find(brick).values(scratch, version.grid().band)[(x & 7) * 64 + (y & 7) * 8 + (z & 7)] < 0;
    };
    constexpr int kEdges = 2 * kHalf;
    const auto index = [](int x, int y, int z) {
      return size_t((x + kHalf) * kEdges + y + kHalf) * kEdges + size_t(z + kHalf);
    };
    std::vector<int> spills(size_t(kEdges) * kEdges * kEdges, 1 << 20);
    std::vector<bool> clay(spills.size());
    for (int x = -kHalf; x < kHalf; ++x)
      for (int y = -kHalf; y < kHalf; ++y)
        for (int z = -kHalf; z < kHalf; ++z) clay[index(x, y, z)] = inside(x, y, z);
    using Entry = std::pair<int, std::array<int, 3>>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    spills[index(-kHalf, -kHalf, -kHalf)] = -kHalf;
    queue.push({-kHalf, {-kHalf, -kHalf, -kHalf}});
    while (!queue.empty()) {
      const auto [level, at] = queue.top();
      queue.pop();
      if (level > spills[index(at[0], at[1], at[2])]) continue;
      for (int side = 0; side < 6; ++side) {
        std::array<int, 3> next = at;
        next[size_t(side / 2)] += side % 2 == 0 ? 1 : -1;
        if (*std::min_element(next.begin(), next.end()) < -kHalf ||
            *std::max_element(next.begin(), next.end()) >= kHalf)
          continue;
        const size_t i = index(next[0], next[1], next[2]);
        const int spill = std::max(level, next[2]);
        if (clay[i] || spill >= spills[i]) continue;
        spills[i] = spill;
        queue.push({spill, next});
      }
    }
    for (int x = -kHalf; x < kHalf; ++x)
      for (int y = -kHalf; y < kHalf; ++y)
        for (int z = -kHalf; z < kHalf; ++z) {
          const size_t i = index(x, y, z);
          if (clay[i]) continue;
          closed += spills[i] == 1 << 20;
          held += spills[i] > z && spills[i] != 1 << 20;
        }
  }
  uint64_t held = 0, closed = 0;
};

TEST(SliceSweep, HoldsAsMuchAsAFloodSays) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-10, 10), size(2, 6);
  uint64_t held = 0, closed = 0;
  for (int round = 0; round < 20; ++round) {
    Version clay = block({0, 0, 0}, {24, 24, 24});
    for (int i = 0; i < 14; ++i)
      clay = without(clay, sphere({place(random), place(random), place(random)}, size(random)));
    for (int i = 0; i < 3; ++i)
      clay = joined(clay, sphere({place(random), place(random), place(random)}, 0.5 * size(random)));
    const SliceReport report = sweepSlices(clay, WorkPart(nullptr), 1, 1);
    const Flood flood(clay);
    double open = 0, shut = 0;
    for (const Trap& trap : report.traps) (trap.closed ? shut : open) += trap.volumeMm3;
    const double voxel = kVoxel * kVoxel * kVoxel;
    EXPECT_EQ(std::llround(open / voxel), int64_t(flood.held)) << round;
    EXPECT_EQ(std::llround(shut / voxel), int64_t(flood.closed)) << round;
    held += flood.held;
    closed += flood.closed;
  }
  EXPECT_GT(held, 10000u);
  EXPECT_GT(closed, 1000u);
}

}  // namespace
}  // namespace argil::clay
