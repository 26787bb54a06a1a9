#include "clay/brush/trail.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace argil::clay {
namespace {

bool has(const std::vector<Coord>& bricks, Coord brick) {
  return std::find(bricks.begin(), bricks.end(), brick) != bricks.end();
}

TEST(Trail, ABrickIsDueOnceAndAfterTheLastStampThatTouchedIt) {
  Trail trail;
  const Coord a{0, 0, 0}, b{5, 0, 0};
  trail.touch(1, {b, a, b});
  trail.touch(2, {b});
  trail.follow(1);
  EXPECT_EQ(trail.due(), 1u) << "b was touched again";
  EXPECT_TRUE(trail.waits(a) && trail.waits(b));
  EXPECT_EQ(trail.take(10).bricks, std::vector{a});
  EXPECT_FALSE(trail.waits(a));
  EXPECT_TRUE(trail.waits(b));
  trail.follow(2);
  EXPECT_EQ(trail.take(10).bricks, std::vector{b});
  EXPECT_EQ(trail.due(), 0u);
  trail.follow(9);
  EXPECT_EQ(trail.due(), 0u);
}

TEST(Trail, NeighboursThatWereSolvedAreSolvedAgainAndThoseThatTrailAreNot) {
  Trail trail;
  const Coord first{0, 0, 0}, beside{1, 1, 1}, far{2, 1, 1};
  trail.touch(1, {first});
  trail.follow(1);
  (void)trail.take(1);
  trail.touch(2, {beside});
  trail.touch(3, {far});
  trail.follow(2);
  const Trail::Work work = trail.take(1);
  EXPECT_EQ(work.bricks, (std::vector{first, beside})) << "far trails yet, the others around were never touched";
  trail.follow(3);
  EXPECT_EQ(trail.take(1).bricks, (std::vector{beside, far}));
}

// However many are taken at a time.
TEST(Trail, InLotsAllAreTaken) {
  for (const size_t most : {size_t(1), size_t(3), size_t(100)}) {
    Trail trail;
    std::vector<Coord> wall;
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 4; ++y) wall.push_back({x, y, 0});
    trail.touch(1, wall);
    trail.follow(1);
    ASSERT_EQ(trail.due(), wall.size());
    std::vector<Coord> seen;
    for (size_t left = trail.due(); left > 0; left = trail.due()) {
      const Trail::Work work = trail.take(most);
      EXPECT_EQ(trail.due(), left - std::min(most, left));
      EXPECT_TRUE(std::is_sorted(work.bricks.begin(), work.bricks.end()));
      EXPECT_EQ(work.bricks.size(), work.renew.size());
      for (const Coord c : work.bricks) {
        EXPECT_FALSE(trail.waits(c));
        if (!has(seen, c)) seen.push_back(c);
      }
    }
    EXPECT_EQ(seen.size(), wall.size()) << most;
  }
}

TEST(Trail, WhatDriftsAVoxelIsSolvedAtOnce) {
  Trail trail;
  const Coord brick{3, 4, 5};
  EXPECT_FALSE(trail.change(brick, 0.75f, Renew::slopes));
  EXPECT_FALSE(trail.change(brick, 0.25f, Renew::none)) << "a voxel exactly";
  EXPECT_TRUE(trail.change(brick, 0.125f, Renew::impossible));
  const Trail::Work work = trail.takeNow({brick});
  EXPECT_EQ(work.bricks.size(), kBricksAround);
  for (size_t i = 0; i < work.bricks.size(); ++i)
    EXPECT_EQ(work.renew[i], work.bricks[i] == brick ? Renew::slopes : Renew::none) << "the most that it called for";
  EXPECT_FALSE(trail.change(brick, 1, Renew::none)) << "it begins anew";
  // Being due ends a drift as well.
  EXPECT_FALSE(trail.change({9, 9, 9}, 1, Renew::all));
  trail.touch(1, {{9, 9, 9}});
  trail.follow(1);
  EXPECT_EQ(trail.take(1).renew, std::vector{Renew::all});
  EXPECT_FALSE(trail.change({9, 9, 9}, 1, Renew::none));
}

}  // namespace
}  // namespace argil::clay
