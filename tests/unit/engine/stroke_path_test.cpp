#include "engine/tools/stroke_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "clay/base/error.h"
#include "engine/document/random.h"

namespace argil::engine {
namespace {

using clay::Stamp;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

clay::Grid halfMillimetre() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  grid.originMm = {10, -20, 30};
  return grid;
}

std::vector<Stamp> stampsOf(const std::vector<Vec3d>& points, const Tool& tool = {}) {
  StrokePath path(halfMillimetre(), tool);
  std::vector<Stamp> stamps;
  for (const Vec3d& point : points) path.add(point, stamps);
  path.finish(stamps);
  return stamps;
}

double pathLength(const std::vector<Stamp>& stamps) {
  double sum = 0;
  for (const Stamp& stamp : stamps) sum += (stamp.b - stamp.a).norm();
  return sum;
}

void expectUnbroken(const std::vector<Stamp>& stamps) {
  ASSERT_FALSE(stamps.empty());
  EXPECT_EQ(stamps[0].a, stamps[0].b);
  for (size_t i = 1; i < stamps.size(); ++i) EXPECT_EQ(stamps[i].a, stamps[i - 1].b) << i;
}

std::vector<Vec3d> wander(uint64_t seed, int count, double step) {
  Random random(seed);
  std::vector<Vec3d> points = {Vec3d(0, 0, 0)};
  for (int i = 1; i < count; ++i) points.push_back(points.back() + step * random.inBall());
  return points;
}

bool same(const Stamp& a, const Stamp& b) {
  return a.a == b.a && a.b == b.b && a.radius == b.radius && a.endRadius == b.endRadius && a.strength == b.strength;
}

TEST(StrokePath, OnePointIsADab) {
  const auto stamps = stampsOf({Vec3d(11, -20, 30)}, {"smooth", 5, 0.25});
  ASSERT_EQ(stamps.size(), 1u);
  EXPECT_EQ(stamps[0].a, Vec3d(2, 0, 0));
  EXPECT_EQ(stamps[0].b, Vec3d(2, 0, 0));
  EXPECT_EQ(stamps[0].radius, 10);
  EXPECT_EQ(stamps[0].strength, 0.25f);
}

TEST(StrokePath, NothingIsNothing) {
  EXPECT_TRUE(stampsOf({}).empty());
}

TEST(StrokePath, RepeatedPointsCountOnce) {
  const Vec3d a(0, 0, 0), b(7, 1, 0), c(9, 9, 2);
  const auto once = stampsOf({a, b, c});
  const auto often = stampsOf({a, a, b, b, b, c, c});
  ASSERT_EQ(once.size(), often.size());
  for (size_t i = 0; i < once.size(); ++i) EXPECT_TRUE(same(once[i], often[i])) << i;
  EXPECT_EQ(stampsOf({a, a, a}).size(), 1u);
}

TEST(StrokePath, AStraightLineIsCutInEqualStepsToItsEnd) {
  const auto stamps = stampsOf({Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(10.2, 0, 0)});  // 20.4 voxels, spacing 1
  expectUnbroken(stamps);
  ASSERT_EQ(stamps.size(), 22u);
  for (size_t i = 1; i <= 20; ++i) EXPECT_NEAR((stamps[i].b - stamps[i].a).norm(), 1, 1e-9);
  EXPECT_NEAR((stamps[21].b - stamps[21].a).norm(), 0.4, 1e-9);
  EXPECT_EQ(stamps.back().b, halfMillimetre().toVoxel({10.2, 0, 0}));
  for (const Stamp& stamp : stamps) EXPECT_NEAR(stamp.b.y(), 40, 1e-12);
}

TEST(StrokePath, GoesThroughItsPoints) {
  const auto points = wander(1, 40, 20);
  const auto stamps = stampsOf(points);
  expectUnbroken(stamps);
  for (const Vec3d& mm : points) {
    double nearest = 1e9;
    for (const Stamp& stamp : stamps) nearest = std::min(nearest, (stamp.b - halfMillimetre().toVoxel(mm)).norm());
    EXPECT_LE(nearest, 0.55);  // half the spacing of 1 voxel, and the bend
  }
}

TEST(StrokePath, ACircleComesOutRound) {
  std::vector<Vec3d> points;
  for (int i = 0; i <= 32; ++i) points.emplace_back(40 * std::cos(i * M_PI / 16), 40 * std::sin(i * M_PI / 16), 0);
  const auto stamps = stampsOf(points);
  const Vec3d centre = halfMillimetre().toVoxel({0, 0, 0});
  // Chords of 1/16 π · 80 = 15.7 voxels have a sagitta of 0.385; the first and the last one start straight.
  for (size_t i = 0; i < stamps.size(); ++i) {
    const bool end = i < 17 || i + 17 > stamps.size();
    EXPECT_NEAR((stamps[i].b - centre).norm(), 80, end ? 0.25 : 0.01) << i;
  }
  EXPECT_NEAR(pathLength(stamps), 2 * M_PI * 80, 0.5);
}

TEST(StrokePath, DoesNotSwingOutBesideAJump) {
  // Points 0.1 mm apart, a jump of 200 mm, points 0.1 mm apart: the curve stays beside the straight way.
  std::vector<Vec3d> points;
  for (int i = 0; i < 10; ++i) points.emplace_back(0.1 * i, 0, 0);
  for (int i = 0; i < 10; ++i) points.emplace_back(0.9, 200 + 0.1 * i, 0);
  const auto stamps = stampsOf(points);
  expectUnbroken(stamps);
  for (const Stamp& stamp : stamps) {
    EXPECT_LE((stamp.b - stamp.a).norm(), 1 + 1e-9);
    EXPECT_LE(halfMillimetre().toWorld(stamp.b).x(), 0.9 + 1.0);
    EXPECT_GE(halfMillimetre().toWorld(stamp.b).x(), -1e-9);
  }
}

TEST(StrokePath, WhatIsCertainDoesNotWaitForTheEnd) {
  StrokePath path(halfMillimetre(), {});
  std::vector<Stamp> stamps;
  path.add({0, 0, 0}, stamps);
  EXPECT_EQ(stamps.size(), 1u);
  path.add({10, 0, 0}, stamps);
  EXPECT_EQ(stamps.size(), 1u);
  path.add({20, 0, 0}, stamps);
  EXPECT_NEAR(double(stamps.size()), 1 + 20, 1);
}

TEST(StrokePath, SaysWhichPointsItsStampsCover) {
  StrokePath path(halfMillimetre(), {});
  std::vector<Stamp> stamps;
  std::vector<Vec3d> points = wander(5, 300, 0.4);
  for (size_t i = 20; i < 300; i += 20) points[i] = points[i - 1];
  uint64_t lag = 0;
  for (size_t given = 0; given < points.size(); ++given) {
    path.add(points[given], stamps);
    ASSERT_LE(path.covered(), given + 1);
    lag = std::max(lag, given + 1 - path.covered());
    for (size_t i = 0; i < path.covered(); ++i) {
      const Vec3d p = halfMillimetre().toVoxel(points[i]);
      double nearest = 1e9;
      for (const Stamp& s : stamps) {
        const Vec3d d = s.b - s.a;
        const double t = d.squaredNorm() > 0 ? std::clamp((p - s.a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
        nearest = std::min(nearest, (s.a + t * d - p).norm());
      }
      ASSERT_LE(nearest, 0.5) << i << " of " << given;  // half the spacing of 1 voxel, where the path turns back
    }
  }
  EXPECT_LE(lag, 12u);
  EXPECT_GE(lag, 2u);
  path.finish(stamps);
  EXPECT_EQ(path.covered(), points.size());
}

TEST(StrokePath, StampsDoNotDependOnHowPointsCameTogether) {
  for (const double step : {0.01, 0.3, 9.0}) {
    const auto points = wander(7, 400, step);
    const auto whole = stampsOf(points);
    StrokePath path(halfMillimetre(), {});
    Random random(11);
    std::vector<Stamp> all;
    for (size_t next = 0; next < points.size();) {
      std::vector<Stamp> batch;
      for (size_t count = random.below(17); count > 0 && next < points.size(); --count) path.add(points[next++], batch);
      all.insert(all.end(), batch.begin(), batch.end());
    }
    path.finish(all);
    ASSERT_EQ(all.size(), whole.size());
    for (size_t i = 0; i < all.size(); ++i) EXPECT_TRUE(same(all[i], whole[i])) << i;
  }
}

TEST(StrokePath, RefusesWhatIsNotAPlaceAndGoesOn) {
  const Vec3d a(0, 0, 0), b(10, 0, 0);
  StrokePath path(halfMillimetre(), {});
  std::vector<Stamp> stamps;
  path.add(a, stamps);
  for (const Vec3d& bad : {Vec3d(kNaN, 0, 0), Vec3d(0, INFINITY, 0), Vec3d(0, 0, 1e9), Vec3d(-1e300, 0, 0)}) {
    EXPECT_THROW(path.add(bad, stamps), Error);
  }
  path.add(b, stamps);
  path.finish(stamps);
  const auto clean = stampsOf({a, b});
  ASSERT_EQ(stamps.size(), clean.size());
  for (size_t i = 0; i < clean.size(); ++i) EXPECT_TRUE(same(stamps[i], clean[i]));
}

TEST(StrokePath, RefusesAGridThatIsNone) {
  for (const double nowhere : {double(NAN), double(INFINITY)}) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    grid.originMm.x() = nowhere;
    EXPECT_THROW(StrokePath(grid, Tool{"carve", 3}), Error);
  }
}

TEST(StrokePath, RefusesToolsThatDoNotFit) {
  const clay::Grid grid = halfMillimetre();
  for (const double radius : {0.0, -1.0, 0.2, 3000.0, kNaN}) {
    EXPECT_THROW(StrokePath(grid, Tool{"carve", radius, 1}), Error) << radius;
  }
  EXPECT_THROW(StrokePath(grid, Tool{"smooth", 5, 1.5}), Error);
  EXPECT_THROW(StrokePath(grid, Tool{.quality = {.spacing = 0}}), Error);
}

}  // namespace
}  // namespace argil::engine
