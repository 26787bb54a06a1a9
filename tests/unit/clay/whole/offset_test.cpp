// Thicker, thinner, hollow: against spheres and boxes whose offsets are known.

#include "clay/whole/offset.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/resample.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

Grid gridOf(double voxelMm) {
  Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = Vec3d(0.3, -0.2, 0.1);
  return grid;
}

double ball(const Vec3d& p, double r) {
  return p.norm() - r;
}
double box(const Vec3d& p, const Vec3d& half, double round) {
  const Vec3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
}

TEST(Offset, SphereAnyDistance) {
  const Version sphere = makeSphere(Store::make(), gridOf(0.5), Vec3d::Zero(), 15);  // 30 voxels
  for (const double mm : {0.2, 3.3, 12.0, -1.0, -12.0}) {
    const Version moved = offset(sphere, mm, 2);
    const auto error = errorAgainst(moved, [&](const Vec3d& p) { return ball(p, 15 + mm); });
    std::printf("sphere of 30 voxels moved by %g voxels: %s\n", mm / 0.5, error.text().c_str());
    EXPECT_LT(error.surfaceMax, 0.05) << mm;
    EXPECT_LT(error.bandMax, 0.06) << mm;
    expectProperBand(moved, 1.1);
    expectClosed(moved);
  }
}

TEST(Offset, BoxOutwardsGetsRoundInwardsStaysSharp) {
  const Vec3d half(12, 9, 7);
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), 2 * half, 0);
  for (const double mm : {0.4, 7.0, -2.0}) {
    const Version moved = offset(block, mm, 2);
    const auto exact = [&](const Vec3d& p) { return mm > 0 ? box(p, half, mm) : box(p, half.array() + mm, 0); };
    const auto error = errorAgainst(moved, exact);
    std::printf("box moved by %g voxels: %s\n", mm / 0.5, error.text().c_str());
    // Outwards an edge is read through its rounding. Inwards the field beyond a sharp edge is a bound; the surface is
    // exact.
    EXPECT_LT(error.surfaceRms, 0.02) << mm;
    EXPECT_LT(error.surfaceMax, mm > 0 ? 0.15 : 0.3) << mm;
    expectProperBand(moved, 1.2);
    expectClosed(moved);
  }
}

TEST(Offset, ThereAndBackOnASmoothShape) {
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), Vec3d(30, 24, 20), 8);
  const Version back = offset(offset(block, 3, 2), -3, 2);
  const auto error = errorAgainst(back, [](const Vec3d& p) { return box(p, Vec3d(7, 4, 2), 8); });
  std::printf("rounded block 6 voxels out and back: %s\n", error.text().c_str());
  EXPECT_LT(error.surfaceMax, 0.1);
}

// What is farther off than an offset looks is band off, and not a last digit less, as (3 + 99 / 7) - 99 / 7 is in
// floats: then all space around would be within the band (a painted ball of 29 voxels moved by 99 took minutes).
TEST(Offset, FarAwayIsOutsideOfTheBand) {
  const Version sphere = makeSphere(Store::make(), gridOf(0.5), Vec3d::Zero(), 15);
  for (const double voxels : {99.0 / 7, 14.7, 11.3, 9.7, 6.1, -99.0 / 7, -14.7, -11.3, -9.7, -6.1}) {
    const Version moved = offset(sphere, 0.5 * voxels, 2);
    int almost = 0;
    BrickValues room;
    moved.forEachBrick([&](const Brick& brick) {
      for (const float phi : brick.values(room)) almost += std::abs(phi) < 3 && std::abs(phi) > 3 - 2e-6f;
    });
    EXPECT_LT(almost, 4) << voxels;
  }
}

TEST(Offset, SameBitsOnAnyThreads) {
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), Vec3d(30, 24, 20), 0);
  EXPECT_EQ(offset(block, 2.3, 1).hash(), offset(block, 2.3, 3).hash());
  EXPECT_NE(offset(block, 2.3, 1).hash(), offset(block, 2.2, 1).hash());
}

TEST(Offset, RefusesNothingLeftAndTooFar) {
  const Version sphere = makeSphere(Store::make(), gridOf(0.5), Vec3d::Zero(), 8);
  EXPECT_THROW((void)offset(sphere, -9), Error);
  EXPECT_THROW((void)offset(sphere, 1e5), Error);
  EXPECT_THROW((void)offset(sphere, std::nan("")), Error);
  EXPECT_THROW((void)offset(Version::empty(Store::make(), gridOf(0.5)), 1), Error);
}

TEST(Shell, WallIsAsThickAsAsked) {
  const Version sphere = makeSphere(Store::make(), gridOf(0.5), Vec3d::Zero(), 15);
  for (const auto& [inner, outer] : {std::pair{2.0, 0.0}, {0.0, 1.5}, {1.0, 1.0}, {6.0, 5.0}}) {
    const Version wall = shell(sphere, inner, outer, 2);
    const auto error = errorAgainst(wall, [inner = inner, outer = outer](const Vec3d& p) {
      return std::max(ball(p, 15 + outer), -ball(p, 15 - inner));
    });
    std::printf("wall of %g + %g voxels: %s\n", inner / 0.5, outer / 0.5, error.text().c_str());
    EXPECT_LT(error.surfaceMax, 0.1);
    expectProperBand(wall, 1.1);
    expectClosed(wall, 2);
  }
  EXPECT_THROW((void)shell(sphere, 0.5, 0.2), Error);
  EXPECT_THROW((void)shell(sphere, 16, 0), Error);
}

// A ball with a pin and a plate, which are thicker than two walls: without a least width they hold slits.
TEST(Shell, HollowsThatAreTooNarrowStaySolid) {
  const Grid grid = gridOf(0.5);
  const Version clay = combine(combine(makeSphere(Store::make(), grid, Vec3d::Zero(), 15),
                                       makeRod(Store::make(), grid, {0, 0, 10}, {0, 0, 30}, 2.8), Combination::join),
                               makeBlock(Store::make(), grid, {0, 0, -16}, {40, 40, 5.3}, 0), Combination::join);
  const auto airAt = [](const Version& wall, const Vec3d& mm) {
    Sampler sampler(wall);
    const Vec3d v = wall.grid().toVoxel(mm).array().round();
    return sampler.voxel(Coord{int32_t(v.x()), int32_t(v.y()), int32_t(v.z())}) > 0;
  };
  const Version all = shell(clay, 2, 0, 2), wide = shell(clay, 2, 0, 2, nullptr, 3);
  for (const Vec3d& within : {Vec3d(0, 0, 22), Vec3d(16, 16, -16)}) {
    EXPECT_TRUE(airAt(all, within)) << within.transpose();
    EXPECT_FALSE(airAt(wide, within)) << within.transpose();
  }
  // The ball is as hollow as before, with a wall as thick.
  for (const Version& wall : {all, wide}) {
    EXPECT_TRUE(airAt(wall, Vec3d::Zero()));
    EXPECT_TRUE(airAt(wall, {12.4, 0, 0}));
    EXPECT_FALSE(airAt(wall, {13.6, 0, 0}));
    expectProperBand(wall, 1.1);
    expectClosed(wall, 2);
  }
  // As wide as it can be, and no wider.
  EXPECT_NO_THROW((void)shell(clay, 2, 0, 2, nullptr, 25));
  EXPECT_THROW((void)shell(clay, 2, 0, 2, nullptr, 27), Error);
  EXPECT_THROW((void)shell(clay, 2, 0, 2, nullptr, std::nan("")), Error);
  EXPECT_THROW((void)shell(clay, 2, 0, 2, nullptr, -1), Error);
}

// What goes inwards and out again comes too far beside the sharp edges of a hollow.
TEST(Shell, NoWallIsThinnerForNarrowHollows) {
  const Grid grid = gridOf(0.25);
  const Version block = makeBlock(Store::make(), grid, Vec3d::Zero(), {30, 24, 20}, 0);
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.5, Vec3d(1, 2, 3).normalized()));
  const Version wedge = combine(block, resample(block, grid, turn, 2), Combination::intersect);
  const Version all = shell(wedge, 2.4, 0, 2), wide = shell(wedge, 2.4, 0, 2, nullptr, 4);
  Sampler sampler(all);
  float least = 1;
  wide.forEachBrick([&](const Brick& brick) {
    BrickValues room;
    const float* phi = brick.values(room);
    for (int i = 0; i < 512; ++i) {
      if (phi[i] < 0) continue;
      least = std::min(
          least, sampler.voxel({brick.coord.x * 8 + i / 64, brick.coord.y * 8 + i / 8 % 8, brick.coord.z * 8 + i % 8}));
    }
  });
  std::printf("by %.3f voxels at most\n", -least);
  EXPECT_GT(least, -0.05);
}

}  // namespace
}  // namespace argil::clay
