// Faces that coincide: joined they are gone, cut they leave no film.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/field/thin_parts.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/cut.h"
#include "clay/whole/offset.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/seam_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::expectAsOne;
using testing::expectOneBody;
using testing::measured;

Grid gridOf(double voxelMm, const Vec3d& origin = Vec3d::Zero()) {
  Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = origin;
  return grid;
}

Version rejoined(const Version& whole, const Divider& divider, ThinParts* gone = nullptr) {
  const Version first = cut(whole, divider, true, whole.store()), second = cut(whole, divider, false, Store::make());
  return combine(first, second, Combination::join, {.gone = gone});
}

// A block cut along planes on voxels, between them and slanted.
TEST(Seam, BlockCutInTwoIsWholeAgain) {
  for (const double voxel : {1.0, 0.5, 0.25}) {
    const Version block = makeBlock(Store::make(), gridOf(voxel), Vec3d::Zero(), {20, 20, 20}, 0);
    for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(1, 1, 0), Vec3d(1, 2, 3), Vec3d(-3, 1, 0.2)}) {
      for (const double at : {0.0, 0.3 * voxel, 0.5 * voxel, 0.9}) {
        SCOPED_TRACE(::testing::Message() << voxel << " mm, " << normal.transpose() << ", at " << at);
        ThinParts gone;
        expectOneBody(rejoined(block, PlaneDivider(at * normal.normalized(), normal), &gone), 2400, 8000);
        if (normal == Vec3d(0, 0, 1)) {
          EXPECT_NEAR(gone.seamArea * voxel * voxel / 400, 1, 0.05);
        }
      }
    }
  }
  // As small as ten voxels.
  const Version small = makeBlock(Store::make(), gridOf(1), Vec3d::Zero(), {10, 10, 10}, 0);
  expectOneBody(rejoined(small, PlaneDivider(Vec3d::Zero(), {0, 0, 1})), 600, 1000);
}

// A cap that is lower than a voxel holds no voxel: its volume is told (a spherical cap, πh²(3r − h)/3).
TEST(Seam, CapsThatNoVoxelHoldsAreTold) {
  for (const double voxel : {1.0, 0.5}) {
    const double radius = 12 * voxel;
    for (const double height : {0.9, 0.7, 0.4, 0.15}) {
      SCOPED_TRACE(::testing::Message() << voxel << " mm, " << height << " voxels high");
      const double h = height * voxel;
      // The cut lies on voxels; a block beside the ball has a half on either side.
      const Version ball = makeSphere(Store::make(), gridOf(voxel), {0, 0, h - radius}, radius),
                    block = makeBlock(Store::make(), gridOf(voxel), {40 * voxel, 0, 0}, Vec3d::Constant(20 * voxel), 0),
                    both = combine(ball, block, Combination::join);
      ThinParts gone;
      const Version upper = cut(both, PlaneDivider(Vec3d::Zero(), {0, 0, 1}), false, Store::make(), nullptr, 0, &gone);
      EXPECT_EQ(bodyVolumes(upper).size(), 1u);
      const double cap = std::numbers::pi * h * h * (3 * radius - h) / 3;
      EXPECT_NEAR(gone.betweenVoxels * std::pow(voxel, 3) / cap, 1, 0.05);
      ThinParts below;
      (void)cut(both, PlaneDivider(Vec3d::Zero(), {0, 0, 1}), true, Store::make(), nullptr, 0, &below);
      EXPECT_EQ(below.betweenVoxels, 0);
    }
    // Looks at higher caps, of which never more is told than went.
    for (const double height : {1.2, 1.5, 2.5, 4.0}) {
      const double h = height * voxel;
      ThinParts gone;
      const Version held = cut(makeSphere(Store::make(), gridOf(voxel), {0, 0, h - radius}, radius),
                               PlaneDivider(Vec3d::Zero(), {0, 0, 1}), false, Store::make(), nullptr, 0, &gone);
      const double cap = std::numbers::pi * h * h * (3 * radius - h) / 3;
      EXPECT_LE(gone.betweenVoxels * std::pow(voxel, 3), 1.02 * (cap - measured(held).volume)) << height;
    }
  }
}

TEST(Seam, CurveCutIsWholeAgain) {
  for (const double voxel : {1.0, 0.5, 0.25}) {
    const Version block = makeBlock(Store::make(), gridOf(voxel, {0.1, 0.2, 0.3}), Vec3d::Zero(), {20, 16, 12}, 0);
    CurveDivider::Curve wave;
    for (int i = 0; i <= 40; ++i) wave.pointsMm.emplace_back(-12 + 0.6 * i, 0, 3 * std::sin(0.4 * i));
    wave.direction = Vec3d::UnitY();
    CurveDivider::Curve corner{{{-12, 0, 1}, {0.2, 0, 1}, {0.2, 0, 12}}, Vec3d::UnitY(), false, 0};
    CurveDivider::Curve closed{{{-4, -3, 0}, {5, -3, 0}, {5, 4, 0}, {-4, 4, 0}}, Vec3d::UnitZ(), true, 0};
    for (const auto& curve : {wave, corner, closed}) expectAsOne(rejoined(block, CurveDivider(curve)), block);
  }
}

TEST(Seam, PlugPutBackIsWholeAgain) {
  for (const double voxel : {1.0, 0.5, 0.25}) {
    const Grid grid = gridOf(voxel);
    const Version block = makeBlock(Store::make(), grid, Vec3d::Zero(), {20, 20, 20}, 0);
    const Version plugs[] = {
        makeCylinder(Store::make(), grid, {0, 0, 5}, 5, 10), makeCylinder(Store::make(), grid, {0.3, 1.1, 0}, 4.3, 20),
        makeSphere(Store::make(), grid, {3, 2, 1}, 6), makeBlock(Store::make(), grid, {5, 5, 5}, {10, 10, 10}, 0),
        makeCone(Store::make(), grid, {0, 0, 5}, 6, 3, 10)};
    for (const Version& plug : plugs) {
      SCOPED_TRACE(::testing::Message() << voxel << " mm, plug " << &plug - plugs);
      expectAsOne(combine(combine(block, plug, Combination::cut), plug, Combination::join), block);
    }
  }
}

TEST(Seam, StackedPiecesAreOne) {
  for (const double voxel : {1.0, 0.5, 0.25}) {
    const Grid grid = gridOf(voxel);
    const Version below = makeBlock(Store::make(), grid, {0, 0, 5}, {20, 20, 10}, 0);
    for (const double lift : {0.0, 0.2 * voxel}) {
      SCOPED_TRACE(::testing::Message() << voxel << " mm, apart by " << lift);
      // Sides in one plane; a smaller one on top; a cylinder.
      expectOneBody(
          combine(below, makeBlock(Store::make(), grid, {0, 0, 15 + lift}, {20, 20, 10}, 0), Combination::join),
          2400 + 80 * lift, 8000 + 400 * lift);
      expectOneBody(combine(below, makeBlock(Store::make(), grid, {1, 2, 13 + lift}, {9, 8, 6}, 0), Combination::join),
                    1600 + 2 * 17 * (6 + lift), 4000 + 72 * (6 + lift));
      expectOneBody(combine(below, makeCylinder(Store::make(), grid, {0, 0, 13 + lift}, 6, 6), Combination::join),
                    1600 + 12 * std::numbers::pi * (6 + lift), 4000 + 36 * std::numbers::pi * (6 + lift), 0.005,
                    0.0015);
    }
    // What is farther apart than the rule stays apart.
    const Version apart =
        combine(below, makeBlock(Store::make(), grid, {0, 0, 15 + 1.3 * voxel}, {20, 20, 10}, 0), Combination::join);
    EXPECT_EQ(bodyVolumes(apart).size(), 2u);
  }
}

// What lies between faces that coincide is no material.
TEST(Seam, CutsAndIntersectionsLeaveNoFilm) {
  for (const double voxel : {1.0, 0.5, 0.25}) {
    const Grid grid = gridOf(voxel, {0.1 * voxel, 0, 0.3 * voxel});
    const Version block = makeBlock(Store::make(), grid, Vec3d::Zero(), {20, 20, 20}, 0),
                  upper = makeBlock(Store::make(), grid, {0, 0, 10}, {20, 20, 20}, 0),
                  above = makeBlock(Store::make(), grid, {0, 0, 20}, {20, 20, 20}, 0);
    expectAsOne(combine(block, upper, Combination::cut), makeBlock(Store::make(), grid, {0, 0, -5}, {20, 20, 10}, 0));
    expectAsOne(combine(block, upper, Combination::intersect),
                makeBlock(Store::make(), grid, {0, 0, 5}, {20, 20, 10}, 0));
    EXPECT_EQ(combine(block, above, Combination::intersect).stats().bricks, 0u);
    EXPECT_EQ(combine(block, above, Combination::cut).stats().bricks, block.stats().bricks);
    // Cut flush with a face, and by less than the rule below it.
    for (const double below : {0.0, 0.2 * voxel}) {
      EXPECT_EQ(cut(block, PlaneDivider({0, 0, 10 - below}, {0, 0, 1}), false, Store::make()).stats().bricks, 0u);
      const Vec3d slanted(1, 2, 3);
      const Version half = cut(block, PlaneDivider(Vec3d::Zero(), slanted), true, Store::make());
      EXPECT_EQ(cut(half, PlaneDivider(-below * slanted.normalized(), slanted), false, Store::make()).stats().bricks,
                0u);
    }
  }
}

TEST(Seam, WallsThickerThanTheRuleStay) {
  for (const double voxel : {0.5, 0.25}) {
    const Grid grid = gridOf(voxel);
    const Version block = makeBlock(Store::make(), grid, Vec3d::Zero(), {20, 20, 20}, 0);
    for (const double wall : {0.5 * voxel, voxel, 1.7 * voxel}) {
      // In the middle of the wall there are voxels.
      const Grid shifted = gridOf(voxel, {0, 0, wall / 2});
      const Version thick = makeBlock(Store::make(), shifted, Vec3d::Zero(), {20, 20, 20}, 0),
                    tool = makeBlock(Store::make(), shifted, {0, 0, 10 + wall}, {40, 40, 20}, 0);
      ThinParts gone;
      const Version sheet =
          combine(combine(thick, tool, Combination::cut),
                  makeBlock(Store::make(), shifted, {0, 0, -10}, {40, 40, 20}, 0), Combination::cut, {.gone = &gone});
      expectOneBody(sheet, 2 * 400 + 80 * wall, 400 * wall, 0.1, 0.1);
      EXPECT_EQ(gone.clayVoxels, 0u);
    }
  }
}

TEST(Seam, OffsetsLeaveNoFilms) {
  for (const double voxel : {1.0, 0.5}) {
    const Grid grid = gridOf(voxel);
    const Version plate = makeBlock(Store::make(), grid, Vec3d::Zero(), {30, 24, 8}, 0),
                  ball = makeSphere(Store::make(), grid, Vec3d::Zero(), 10),
                  rod = makeCylinder(Store::make(), grid, Vec3d::Zero(), 5, 30);
    for (const double more : {-0.1, 0.0, 0.1}) {
      SCOPED_TRACE(::testing::Message() << voxel << " mm, by " << more);
      EXPECT_THROW((void)offset(plate, -4 - more * voxel), Error);
      EXPECT_THROW((void)offset(ball, -10 - more * voxel), Error);
      EXPECT_THROW((void)offset(rod, -5 - more * voxel), Error);
      EXPECT_THROW((void)shell(plate, 4 + more * voxel, 0), Error);
      EXPECT_THROW((void)shell(ball, 10 + more * voxel, 0), Error);
    }
    // Of a plate with a boss the plate goes, and is counted.
    const Version both = combine(plate, makeBlock(Store::make(), grid, {0, 0, 4}, {16, 16, 20}, 0), Combination::join);
    ThinParts gone;
    const Version left = offset(both, -4, 2, nullptr, &gone);
    EXPECT_EQ(bodyVolumes(left).size(), 1u);
    // The boss alone would be 8 × 8 × 12 mm; where the plate meets it there is more, by less than a ring 4 mm wide and
    // high.
    const double volume = measured(left).volume;
    EXPECT_GT(volume, 0.995 * 768);
    EXPECT_LT(volume, 768 + 4 * 8 * 4 * 4);
    EXPECT_GT(gone.clayVoxels, 100u);
    // A slot closes when the surface comes outwards.
    const Version slotted = combine(makeBlock(Store::make(), grid, Vec3d::Zero(), {30, 24, 20}, 0),
                                    makeBlock(Store::make(), grid, {0, 0, 10}, {4, 60, 20}, 0), Combination::cut);
    const Version closed = offset(slotted, 2);
    EXPECT_EQ(bodyVolumes(closed).size(), 1u);
    EXPECT_EQ(fillVoids(closed).count, 0u);
  }
}

}  // namespace
}  // namespace argil::clay
