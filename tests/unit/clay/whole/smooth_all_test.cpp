// Whole pieces evened out.

#include "clay/whole/smooth_all.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::clayVolume;
using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

Grid half() {
  Grid grid;
  grid.voxelMm = 0.5;
  return grid;
}

Version ball(const std::shared_ptr<Store>& store, const Vec3d& centre, double radius) {
  return makeSphere(store, half(), centre, radius);
}

TEST(SmoothAll, KeepsTheVolumeOfASphereAndRoundsABox) {
  const auto store = Store::make();
  const Version sphere = ball(store, Vec3d::Zero(), 20);  // 40 voxels
  const double before = clayVolume(sphere);
  const Version smooth = smoothAll(sphere, 1, true, 2), shrunk = smoothAll(sphere, 1, false, 2);
  std::printf("one pass over a sphere of 40 voxels: volume %+.5f %% kept, %+.5f %% not\n",
              100 * (clayVolume(smooth) / before - 1), 100 * (clayVolume(shrunk) / before - 1));
  EXPECT_NEAR(clayVolume(smooth) / before, 1, 1e-4);
  EXPECT_LT(clayVolume(shrunk) / before, 1 - 1e-4);
  EXPECT_LT(errorAgainst(smooth, [](const Vec3d& p) { return p.norm() - 20; }).surfaceMax, 0.02);
  const Version block = makeBlock(store, half(), Vec3d::Zero(), Vec3d(16, 16, 16), 0);
  const Version round = smoothAll(block, 4, false, 2);
  Sampler was(block), is(round);
  EXPECT_GT(is.trilinear(half().toVoxel(Vec3d(7.8, 7.8, 7.8))),
            was.trilinear(half().toVoxel(Vec3d(7.8, 7.8, 7.8))) + 0.5);
  EXPECT_NEAR(is.trilinear(half().toVoxel(Vec3d(8, 0, 0))), 0, 0.05);
  expectClosed(round);
  expectProperBand(round, 1.1);
  EXPECT_THROW((void)smoothAll(block, 0, false), Error);
}

// Four passes read four voxels farther than one: what lies beside the surface keeps its slope.
TEST(SmoothAll, LeavesDistancesOfALargeSphere) {
  const auto store = Store::make();
  const Version smooth = smoothAll(ball(store, Vec3d::Zero(), 20), 4, false, 2);
  double sum = 0, squares = 0, most = -1e9, least = 1e9;
  uint64_t count = 0;
  smooth.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      const double exact = (smooth.grid().toWorld(at.toVec3d()).norm() - 20) / smooth.grid().voxelMm;
      if (std::abs(exact) > 1.2) continue;
      const double off = brick.phi(v) - exact;
      sum += off, squares += off * off, ++count;
      most = std::max(most, off), least = std::min(least, off);
    }
  });
  const double mean = sum / double(count), spread = std::sqrt(squares / double(count) - mean * mean);
  std::printf("four passes over a sphere of 40 voxels: smaller by %.4f voxel, %.5f RMS beside that, %.4f to %.4f\n",
              mean, spread, least - mean, most - mean);
  EXPECT_GT(mean, 0);
  EXPECT_LT(most - least, 0.01);
}

// What is worked on together is nothing that the clay knows of, and by how many not even its last bit.
TEST(SmoothAll, DoesTheSameWhereverThePieceLies) {
  for (const Precision precision : {Precision::float32, Precision::fixed16}) {
    const auto store = Store::make(precision);
    Version clay = makeBlock(store, half(), Vec3d(1, 2, 3), Vec3d(50, 40, 30), 0);
    for (const Vec3d& at : {Vec3d(26, 3, 4), Vec3d(-9, 20, 8), Vec3d(4, -7, 18)})
      clay = combine(clay, ball(store, at, 9), Combination::cut);
    clay = combine(clay, ball(store, Vec3d(-20, -16, 14), 2), Combination::join);
    const Version smooth = smoothAll(clay, 6, false, 1);
    EXPECT_EQ(smoothAll(clay, 6, false, 3).hash(), smooth.hash());
    for (const Coord bricks : {Coord{5, 0, 0}, Coord{-3, 9, 14}}) {
      Editor editor(Version::empty(Store::make(precision), half()));
      clay.forEachBrick([&](const Brick& brick) {
        BrickValues room;
        editor.setVoxels(brick.coord + bricks, brick.values(room));
      });
      for (int i = 0; i < 8000; ++i)
        if (const Coord at{i / 400 - 10, i / 20 % 20 - 10, i % 20 - 10}; clay.find(at) == Slot(Tile::inside))
          editor.setTile(at + bricks, Tile::inside);
      const Version there = smoothAll(editor.commit(), 6, false, 2);
      uint64_t count = 0;
      float worst = 0;
      smooth.forEachBrick([&](const Brick& brick) {
        BrickValues one, other;
        const Slot slot = there.find(brick.coord + bricks);
        ASSERT_FALSE(slot.isTile());
        const BrickValues &here = brick.values(one), &moved = slot.values(other, 3);
        // Distances that are on their way to the last bit when the passes end know where a block of bricks ends.
        for (int v = 0; v < kBrickVoxels; ++v) worst = std::max(worst, std::abs(here[v] - moved[v]));
        ++count;
      });
      EXPECT_EQ(there.stats().bricks, count);
      EXPECT_GT(count, 500u);
      EXPECT_LT(worst, precision == Precision::float32 ? 2e-6f : 3e-4f);
    }
  }
}

// So much that the surface has to move farther than the band's end forgives.
TEST(SmoothAll, KeepsTheVolumeOfASmallBall) {
  const Version small = ball(Store::make(), Vec3d::Zero(), 4);  // 8 voxels
  const double before = clayVolume(small);
  const Version shrunk = smoothAll(small, 12, false, 2), kept = smoothAll(small, 12, true, 2);
  EXPECT_LT(clayVolume(shrunk) / before, 0.95);
  EXPECT_NEAR(clayVolume(kept) / before, 1, 2e-4);
  EXPECT_LT(errorAgainst(kept, [](const Vec3d& p) { return p.norm() - 4; }).surfaceMax, 0.05);
  expectProperBand(kept, 1.1);
}

// Voxels from `from`, inside, along an axis to the surface.
double surfaceFrom(const Version& clay, const Vec3d& fromMm, int axis) {
  const Sampler field(clay);
  Vec3d at = clay.grid().toVoxel(fromMm);
  double low = 0, high = 100;
  while (high - low > 1e-5) {
    const double middle = (low + high) / 2;
    Sampler mine = field;
    (mine.trilinear(at + middle * Vec3d::Unit(axis)) < 0 ? low : high) = middle;
  }
  return low;
}

// Repeated means move a surface by its mean curvature: after n of them a ball of radius r has √(r² − n), voxels, and a
// plate is as thick as before, as long as it is thicker than the band on both sides.
TEST(SmoothAll, MovesSurfacesByTheirCurvature) {
  const auto store = Store::make();
  struct Case {
    double size, off;
  };
  for (const int passes : {4, 10, 25}) {
    for (const Case ofBall : {Case{8, 0.03}, Case{12, 0.02}, Case{40, 0.006}}) {
      const Version smooth = smoothAll(ball(store, Vec3d::Zero(), ofBall.size / 2), passes, false, 2);
      const double exact = std::sqrt(ofBall.size * ofBall.size - passes);
      for (int axis = 0; axis < 3; ++axis) {
        const double off = surfaceFrom(smooth, Vec3d::Zero(), axis) - exact;
        if (axis == 0) std::printf("%d passes, ball of %g voxels: off by %.4f\n", passes, ofBall.size, off);
        EXPECT_NEAR(off, 0, ofBall.off) << passes << " " << ofBall.size;
      }
    }
    for (const Case plate : {Case{6, 0.03}, Case{8, 0.02}, Case{10, 1e-3}}) {
      const Version smooth =
          smoothAll(makeBlock(store, half(), Vec3d::Zero(), Vec3d(40, plate.size / 2, 40), 0), passes, false, 2);
      const double thicker = 2 * (surfaceFrom(smooth, Vec3d::Zero(), 1) - plate.size / 2);
      std::printf("%d passes, plate of %g voxels: thicker by %.4f\n", passes, plate.size, thicker);
      EXPECT_NEAR(thicker / 2, 0, plate.off) << passes << " " << plate.size;
    }
  }
}

TEST(SmoothAll, PaintChangesNoShape) {
  const auto store = Store::make();
  const Version plain = combine(makeBlock(store, half(), Vec3d::Zero(), Vec3d(45, 20, 15), 0),
                                ball(store, Vec3d(-20, 0, 0), 9), Combination::join);
  Editor editor(plain);
  plain.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> values;
    values.fill(static_cast<uint8_t>(brick.coord.x + 100));
    editor.setChannel(Channel::red, brick.coord, values);
  });
  const Version one = smoothAll(plain, 10, false, 2), other = smoothAll(editor.commit(), 10, false, 2);
  one.forEachBrick([&](const Brick& brick) {
    BrickValues room, otherRoom;
    const Slot slot = other.find(brick.coord);
    ASSERT_FALSE(slot.isTile());
    EXPECT_EQ(std::memcmp(brick.values(room), slot.values(otherRoom, 3), sizeof room), 0);
  });
}

// Paint that says where on a ball it is: what comes into the band has that of the place beside it.
TEST(SmoothAll, WhatComesIntoTheBandHasThePaintBesideIt) {
  const Version plain = ball(Store::make(), Vec3d::Zero(), 10);  // 20 voxels
  const auto heightOf = [](Coord voxel) { return 100 + 60 * std::asin(voxel.toVec3d().normalized().z()); };
  Editor editor(plain);
  const auto voxelOf = [](const Brick& brick, int v) {
    return brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
  };
  plain.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> values{};
    for (int v = 0; v < kBrickVoxels; ++v)
      if (std::abs(brick.phi(v)) < 3)
        values[size_t(v)] = static_cast<uint8_t>(std::lround(heightOf(voxelOf(brick, v))));
    editor.setChannel(Channel::red, brick.coord, values);
  });
  const Version painted = editor.commit(), smooth = smoothAll(painted, 20, false, 2);
  uint64_t fresh = 0;
  double worst = 0;
  smooth.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (!(std::abs(brick.phi(v)) < 3)) continue;
      const Coord at = voxelOf(brick, v);
      fresh += painted.find(Channel::red, brick.coord).value(v) == 0;
      worst = std::max(worst, std::abs(smooth.find(Channel::red, brick.coord).value(v) - heightOf(at)));
    }
  });
  EXPECT_GT(fresh, 1000u);
  // A voxel is 3 of 100 there.
  EXPECT_LT(worst, 6) << fresh;
}

// Between looks distances are solved only where means are none: it does not matter, beside clay whose band is so wide
// that nothing is cut off.
TEST(SmoothAll, EdgesAreAsWithAWideBand) {
  const auto made = [](float band) {
    Grid grid = half();
    grid.band = band;
    const auto store = Store::make();
    const Version block = makeBlock(store, grid, Vec3d(0.15, 0.1, 0.05), Vec3d(45, 20, 15), 0);
    const Version bitten = combine(block, makeSphere(store, grid, Vec3d(7.5, 2.6, 7.5), 4), Combination::cut);
    return combine(bitten, makeSphere(store, grid, Vec3d(-20, 0, 0), 9), Combination::join);
  };
  struct Case {
    float band;
    int passes;
    double rms, most;
  };
  for (const auto [band, passes, rmsBound, mostBound] :
       {Case{3, 8, 0.008, 0.035}, Case{3, 10, 0.008, 0.035}, Case{3, 16, 0.008, 0.035}, Case{2, 10, 0.014, 0.06}}) {
    const Version narrow = smoothAll(made(band), passes, false, 2), wide = smoothAll(made(8), passes, false, 2);
    Sampler field(narrow);
    double worst = 0, squares = 0;
    uint64_t count = 0;
    wide.forEachBrick([&](const Brick& brick) {
      BrickValues wideRoom, room;
      const BrickValues &exact = brick.values(wideRoom), &now = field.slot(brick.coord).values(room, band);
      for (int v = 0; v < kBrickVoxels; ++v) {
        if (std::abs(exact[v]) > 1) continue;
        const double off = std::abs(now[v] - exact[v]);
        worst = std::max(worst, off);
        squares += off * off;
        ++count;
      }
    });
    const double rms = std::sqrt(squares / double(count));
    std::printf("%d passes with a band of %g, beside one of 8: %.4f voxel RMS, %.4f at most\n", passes, band, rms,
                worst);
    EXPECT_GT(count, 10000u);
    EXPECT_LT(rms, rmsBound);
    EXPECT_LT(worst, mostBound);
  }
}

}  // namespace
}  // namespace argil::clay
