// Two clays become one: against distances that are known.

#include "clay/boolean.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clay/primitives.h"
#include "clay/resample.h"
#include "clay/store.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole_checks.h"

namespace argil::clay {
namespace {

using testing::clayVolume;
using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

const Vec3d kOther(9, 8, 0);  // the spheres meet at about a right angle

Version sphere(const std::shared_ptr<Store>& store, const Vec3d& centre, double radius, double voxel = 0.5) {
  Grid grid;
  grid.voxelMm = voxel;
  return makeSphere(store, grid, centre, radius);
}

double lens(double d, double r, double s) {  // volume of what two spheres share
  return M_PI * std::pow(r + s - d, 2) * (d * d + 2 * d * (r + s) - 3 * std::pow(r - s, 2)) / (12 * d);
}

TEST(Boolean, TwoSpheres) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 12), b = sphere(store, kOther, 8);
  const double shared = lens(kOther.norm(), 12, 8), ball = 4.0 / 3 * M_PI;
  const auto da = [](const Vec3d& p) { return p.norm() - 12; };
  const auto db = [](const Vec3d& p) { return (p - kOther).norm() - 8; };
  const struct {
    Combination how;
    std::function<double(const Vec3d&)> exact;
    double volume;
  } cases[] = {{Combination::join, [&](const Vec3d& p) { return std::min(da(p), db(p)); }, ball * (1728 + 512) - shared},
               {Combination::cut, [&](const Vec3d& p) { return std::max(da(p), -db(p)); }, ball * 1728 - shared},
               {Combination::intersect, [&](const Vec3d& p) { return std::max(da(p), db(p)); }, shared}};
  for (const auto& each : cases) {
    const Version result = combine(a, b, each.how);
    // Beside a sign change nothing was changed.
    uint64_t crossing = 0;
    result.forEachBrick([&](const Brick& brick) {
      for (int v = 0; v < kBrickVoxels; ++v) {
        if ((v & 7) == 7 || (brick.phi(v) < 0) == (brick.phi(v + 1) < 0)) continue;
        const Coord at = brick.coord * 8 + Coord{v >> 6, (v >> 3) & 7, v & 7};
        EXPECT_NEAR(brick.phi(v), each.exact(result.grid().toWorld(at.toVec3d())) / 0.5, 1e-4);
        ++crossing;
      }
    });
    EXPECT_GT(crossing, 500u);
    EXPECT_NEAR(clayVolume(result) * 0.125 / each.volume, 1, 0.004);
    expectProperBand(result, 1.1);
    expectClosed(result);
  }
}

TEST(Boolean, SharesWhatTheOtherDoesNotReach) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 40), b = sphere(store, Vec3d(40, 0, 0), 4);
  const Version joined = combine(a, b, Combination::join);
  uint64_t same = 0, all = 0;
  joined.forEachBrick([&](const Brick& brick) {
    ++all;
    same += a.find(brick.coord).brick() == &brick;
  });
  EXPECT_GT(double(same) / double(all), 0.95);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::join), a);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::cut), a);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::intersect).stats().bricks, 0u);
  EXPECT_EQ(combine(a, a, Combination::join).hash(), a.hash());
  EXPECT_EQ(combine(a, a, Combination::cut).stats().bricks, 0u);
  // Where a has nothing, b comes as it is.
  EXPECT_EQ(combine(Version::empty(store, a.grid()), a, Combination::join).hash(), a.hash());
}

TEST(Boolean, OtherStoreAndGrid) {
  const Version a = sphere(Store::make(), Vec3d::Zero(), 12), b = sphere(Store::make(), kOther, 8, 0.4);
  const Version result = combine(a, b, Combination::join, {.threads = 2});
  const double volume = 4.0 / 3 * M_PI * (1728 + 512) - lens(kOther.norm(), 12, 8);
  EXPECT_NEAR(clayVolume(result) * 0.125 / volume, 1, 0.004);
  EXPECT_EQ(result.store(), a.store());
  expectClosed(result);
}

TEST(Boolean, BlendRunsTheSurfacesTogether) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 12), b = sphere(store, kOther, 8);
  double before = 0;
  for (const double mm : {0.0, 2.0, 5.0}) {
    const Version result = combine(a, b, Combination::join, {.blendMm = mm, .threads = 2});
    const double volume = clayVolume(result);
    EXPECT_GT(volume, before * 1.0005);  // the seam fills
    before = volume;
    expectProperBand(result, 1.2);
    expectClosed(result);
  }
  EXPECT_THROW((void)combine(a, b, Combination::join, {.blendMm = 100}), Error);
  EXPECT_THROW((void)combine(a, b, Combination::join, {.blendMm = -1}), Error);
}

TEST(Boolean, CancelLeavesNothing) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 40), b = sphere(store, kOther, 30);
  const uint64_t hash = a.hash();
  Job job;
  job.cancel();
  EXPECT_THROW((void)combine(a, b, Combination::join, {}, &job), Cancelled);
  EXPECT_EQ(a.hash(), hash);
  EXPECT_EQ(store->usage().bricks, a.stats().bricks + b.stats().bricks);
}

}  // namespace
}  // namespace argil::clay
