// Distances beyond the band while a stroke goes on.

#include "clay/field/wide_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"

namespace argil::clay {
namespace {

constexpr double kRadius = 40;  // voxels
const Vec3d kMiddle(0.3, 0.2, 0.1);

Version ball() {
  Grid grid;
  return makeSphere(Store::make(), grid, kMiddle * grid.voxelMm, kRadius * grid.voxelMm);
}

// Bricks that come within `reach` of the ball's surface, sorted.
std::vector<Coord> around(double reach) {
  std::vector<Coord> bricks;
  for (int x = -10; x < 10; ++x)
    for (int y = -10; y < 10; ++y)
      for (int z = -10; z < 10; ++z) {
        const Vec3d middle = (Coord{x, y, z} * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
        if (std::abs((middle - kMiddle).norm() - kRadius) < reach + 7) bricks.push_back({x, y, z});
      }
  return bricks;
}

struct Errors {
  double distance = 0, foot = 0;  // at most, voxels
  size_t known = 0;
};
Errors errorsOf(const WideDistance& wide, const std::vector<Coord>& bricks, int side) {
  Errors errors;
  WideDistance::Feet room;
  for (const Coord coord : bricks) {
    const WideDistance::Block* block = wide.find(coord);
    if (!block) continue;
    const WideDistance::Feet& feet = wide.feet(coord, room);
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (!((block->known[i >> 6] >> (i & 63)) & 1)) continue;
      const Vec3d place = (coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d() - kMiddle;
      const double expected = side * (place.norm() - kRadius);
      if (expected < -2) continue;  // behind the surface there is the band alone
      ++errors.known;
      errors.distance = std::max(errors.distance, std::abs(static_cast<double>(block->u[i]) - expected));
      const Vec3d foot(feet.foot[i], feet.foot[kBrickVoxels + i], feet.foot[2 * kBrickVoxels + i]);
      errors.foot = std::max(errors.foot, std::abs((place + foot).norm() - kRadius));
    }
  }
  return errors;
}

TEST(WideDistance, OfABallOnBothSidesWithItsNearestPoints) {
  for (const int side : {1, -1}) {
    WideDistance wide(ball(), side);
    const std::vector<Coord> bricks = around(16);
    wide.extend(bricks, 16).finish();
    const Errors errors = errorsOf(wide, bricks, side);
    EXPECT_GT(errors.known, 200'000u);
    EXPECT_LT(errors.distance, 0.1) << side;
    EXPECT_LT(errors.foot, 0.3) << side;
  }
}

// However it was come by: farther step by step, part after part, or after it was forgotten.
TEST(WideDistance, FartherStepByStepIsAsAtOnce) {
  const Version clay = ball();
  const std::vector<Coord> bricks = around(16);
  WideDistance once(clay, 1), stepwise(clay, 1), halves(clay, 1), again(clay, 1), aside(clay, 1);
  once.extend(bricks, 16).finish();
  for (const float reach : {6.0f, 8.0f, 12.0f, 16.0f}) stepwise.extend(bricks, reach).finish();
  const auto half = bricks.begin() + static_cast<ptrdiff_t>(bricks.size() / 2);
  halves.extend(std::vector(bricks.begin(), half), 16).finish();
  halves.extend(bricks, 16).finish();
  again.extend(bricks, 12).finish();
  again.keepOnly(std::vector(half, bricks.end()));
  again.extend(bricks, 16).finish();
  // What is asked for again goes on in bricks beside it that are not.
  const std::vector<Coord> part(bricks.begin(), half);
  aside.extend(bricks, 6).finish();
  aside.extend(part, 16).finish();
  for (const auto& [what, other] :
       {std::pair("step by step", &stepwise), {"halves", &halves}, {"again", &again}, {"aside", &aside}}) {
    size_t known = 0, differ = 0;
    for (const Coord coord : other == &aside ? part : bricks) {
      const WideDistance::Block *a = once.find(coord), *b = other->find(coord);
      ASSERT_EQ(a == nullptr, b == nullptr);
      if (!a) continue;
      for (int i = 0; i < kBrickVoxels; ++i) {
        if (!((a->known[i >> 6] >> (i & 63)) & 1)) continue;
        ++known;
        differ += !((b->known[i >> 6] >> (i & 63)) & 1) || !(std::abs(a->u[i] - b->u[i]) < 0.01f);
      }
    }
    EXPECT_LE(differ, other == &aside ? known / 1000 : 0) << what << " of " << known;
  }
}

// Feet are the same whether they are kept or not, also after what is beside them was solved farther.
TEST(WideDistance, FeetThatAreKeptAreAsThoseThatAreNot) {
  const Version clay = ball();
  const std::vector<Coord> bricks = around(16);
  const std::vector<Coord> few(bricks.begin() + 300, bricks.begin() + 500);
  WideDistance kept(clay, 1), fresh(clay, 1);
  WideDistance::Feet roomA, roomB;
  size_t compared = 0;
  for (const float reach : {6.0f, 10.0f, 16.0f}) {
    for (WideDistance* each : {&kept, &fresh}) each->extend(bricks, reach).finish();
    kept.keepFeetOf(few);
    for (const Coord coord : few) {
      if (!kept.find(coord)) continue;
      const WideDistance::Feet &a = kept.feet(coord, roomA), &b = fresh.feet(coord, roomB);
      EXPECT_NE(&a, &roomA);
      compared += std::equal(std::begin(a.foot), std::end(a.foot), std::begin(b.foot));
      ASSERT_TRUE(std::equal(std::begin(a.foot), std::end(a.foot), std::begin(b.foot)));
    }
  }
  EXPECT_GT(compared, 300u);
}

// What is known is not solved again: where a stroke rises, most of its bricks lie below.
TEST(WideDistance, BricksThatAreKnownAreNotSolvedAgain) {
  const Version clay = ball();
  const std::vector<Coord> bricks = around(24);
  WideDistance wide(clay, 1);
  for (const float reach : {8.0f, 16.0f, 24.0f}) {
    wide.extend(bricks, reach).finish();
    size_t open = 0;
    for (const Coord coord : bricks) {
      const WideDistance::Block* block = wide.find(coord);
      if (!block) continue;
      EXPECT_EQ(block->solvedTo, reach);
      const Vec3d middle = (coord * kBrickEdge).toVec3d() + Vec3d::Constant(3.5) - kMiddle;
      // A brick reaches 6.1 voxels from its middle.
      if (middle.norm() - kRadius < static_cast<double>(reach) - 7) open += block->open;
    }
    EXPECT_EQ(open, 0u) << reach;
  }
}

// Redistancing leaves what differs from the band by less than its tolerance: such a voxel far from the surface, left by
// an earlier stroke, is not where a distance begins.
TEST(WideDistance, WhatIsLeftAtTheBandsEndIsNoSource) {
  for (const float left : {2.91f, 2.98f, 2.999f}) {
    Editor editor(ball());
    for (const Vec3d& way : {Vec3d(1, 0, 0), Vec3d(0, 1, 1), Vec3d(-1, 2, 1)}) {
      const Vec3d place = kMiddle + (kRadius + 7) * way.normalized();
      const Coord voxel{static_cast<int32_t>(std::round(place.x())), static_cast<int32_t>(std::round(place.y())),
                        static_cast<int32_t>(std::round(place.z()))};
      BrickValues room;
      const BrickValues& was = editor.find(voxel >> kBrickBits).values(room, 3);
      float values[kBrickVoxels];
      for (int i = 0; i < kBrickVoxels; ++i) values[i] = was[i];
      values[Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7)] = left;
      editor.setVoxels(voxel >> kBrickBits, values);
    }
    const std::vector<Coord> bricks = around(18);
    WideDistance wide(editor.commit(), 1);
    wide.extend(bricks, 16).finish();
    const Errors errors = errorsOf(wide, bricks, 1);
    EXPECT_GT(errors.known, 100000u);
    EXPECT_LE(errors.distance, 0.1) << left;
  }
}

}  // namespace
}  // namespace argil::clay
