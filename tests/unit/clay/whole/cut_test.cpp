// Clay cut by planes and by drawn curves.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "clay/cage/crease_map.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/cut.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/field_compare.h"

namespace argil::clay {
namespace {

using testing::fieldError;

TopologyReport topology(const Version& version) {
  Surface surface;
  surface.update(version);
  return checkTopology(surface.toMesh());
}

Version ball(double radius = 15) {
  return makeSphere(Store::make(), Grid{}, Vec3d::Zero(), radius);
}

TEST(Cut, AHalfBallHasExactDistances) {
  const Version whole = ball();
  const Vec3d n = Vec3d(1, 2, 3).normalized(), point(1, 2, 0.5);
  const Version half = cut(whole, PlaneDivider(point, 2 * n), true, whole.store());
  const double below = point.dot(n) * 2;
  // Of the part of a ball of radius 30 voxels below the plane; beside the rim the nearest place is the rim.
  const auto exact = [&](const Vec3d& p) {
    const double z = p.dot(n) - below, r = (p - p.dot(n) * n).norm(), rim = std::sqrt(900 - below * below);
    const double centre = p.norm() - 30;
    if (z <= 0 && centre <= 0) return std::max({-std::hypot(r - rim, z), z, centre});
    if (r <= rim && z > 0) return z;
    // On the ball's side of the cone through the rim.
    if (r * below <= rim * p.dot(n) || z > 0) return std::hypot(r - rim, z);
    return centre;
  };
  const auto error = fieldError(half, exact, 1), band = fieldError(half, exact, 2.9);
  std::printf("half ball: %.4f RMS, %.3f worst within 1; %.4f RMS, %.3f worst in the band\n", error.rms, error.worst,
              band.rms, band.worst);
  EXPECT_LE(error.rms, 0.006);
  EXPECT_LE(band.rms, 0.006);
  EXPECT_LE(band.worst, 0.2);
  testing::expectProperBand(half, 1.3);
  EXPECT_TRUE(topology(half).closed());
}

// Where the plane lies among the voxels changes nothing: the rim is a crease all around, as on a block that was made
// so.
TEST(Cut, LeavesCreases) {
  Grid grid;
  grid.voxelMm = 0.5;
  const Version block = makeBlock(Store::make(), grid, {1, 2, 3}, {30, 20, 12}, 0);
  for (const double at : {1.0, 1.1, 1.25, 1.4, -3.5}) {
    const Version part = cut(block, PlaneDivider({at, 0, 0}, {1, 0, 0}), true, Store::make());
    const double width = at + 14;
    const auto outside = [&](const Vec3d& voxel) -> Vec3d {
      const Vec3d p = grid.toWorld(voxel) - Vec3d(1 + (width - 30) / 2, 2, 3);
      return (p.cwiseAbs() - Vec3d(width, 20, 12) / 2) / grid.voxelMm;
    };
    const auto exact = [&](const Vec3d& voxel) {
      const Vec3d q = outside(voxel);
      return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
    };
    // Where three faces meet distances are solved to first order.
    const auto onTwo = [&](const Vec3d& voxel) { return outside(voxel).minCoeff() < -3; };
    EXPECT_LE(testing::fieldError(part, exact, 2.9, onTwo).worst, 0.001) << at;
    Surface fine(true, Grade::fine);
    fine.update(part, 2);
    EXPECT_NEAR(CreaseMap(fine, fine.toMesh(), 1.5).lengthMm() / (4 * (20 + 12 + width)), 1, 0.07) << at;
  }
}

TEST(Cut, BothPartsMakeTheWholeAndAreClosed) {
  const Version whole = ball();
  const PlaneDivider plane(Vec3d(0.13, 3, 1), Vec3d(1, -2, 0.3));
  const Version a = cut(whole, plane, true, whole.store()), b = cut(whole, plane, false, Store::make());
  const double volume = topology(whole).volume, parts = topology(a).volume + topology(b).volume;
  EXPECT_TRUE(topology(a).closed());
  EXPECT_TRUE(topology(b).closed());
  // Rims are chamfered by half a voxel at most: 0.1 mm² of section along 2 · 90 mm.
  EXPECT_NEAR(parts, volume, 20);
  EXPECT_EQ(cut(whole, plane, true, Store::make()).hash(), a.hash());
  for (const int threads : {1, 2, 5})
    EXPECT_EQ(cut(whole, plane, true, whole.store(), nullptr, threads).hash(), a.hash());
}

TEST(Cut, SharesWhatItDoesNotComeNear) {
  const Version whole = ball(40);
  const Version top = cut(whole, PlaneDivider(Vec3d(0, 0, 36), Vec3d::UnitZ()), true, whole.store());
  uint64_t different = 0, far = 0;
  Version::forEachDifference(whole, top, [&](Coord brick, Slot, Slot) {
    ++different;
    far += brick.z * 8 + 7 < 72 - 12;
  });
  EXPECT_GT(different, 0u);
  EXPECT_EQ(far, 0u);
  EXPECT_EQ(cut(whole, PlaneDivider(Vec3d(0, 0, 50), Vec3d::UnitZ()), true, whole.store()), whole);
  EXPECT_EQ(cut(whole, PlaneDivider(Vec3d(0, 0, 50), Vec3d::UnitZ()), false, whole.store()).stats().bricks, 0u);
}

TEST(Cut, AStraightCurveIsAPlane) {
  const Version whole = ball();
  const Vec3d sight = Vec3d(0.2, 0.3, -1).normalized(), from(-30, -4, 2), to(20, 9, 7);
  const Version wire = cut(whole, CurveDivider({{from, to}, sight, false, 0}), true, Store::make());
  // Left of the way as seen along the direction of sight.
  const Vec3d left = (to - from).cross(sight);
  EXPECT_GT(left.y(), 0);
  const Version plane = cut(whole, PlaneDivider(from, left), false, Store::make());
  EXPECT_LE(fieldError(wire, plane, 2.9).worst, 1e-4);
  EXPECT_EQ(topology(wire).bodies, 1u);
}

TEST(Cut, ALassoIsAPunch) {
  // A circle of many points around the z axis leaves a rod; outside of it, a ring.
  const Version whole = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {40, 30, 16}, 0);
  CurveDivider::Curve curve{{}, -Vec3d::UnitZ(), true, 0.5};
  for (int i = 0; i < 200; ++i)
    curve.pointsMm.push_back({10 * std::cos(i * 0.0314159265), 10 * std::sin(i * 0.0314159265), double(i % 7)});
  const CurveDivider divider(curve);
  const Version rod = cut(whole, divider, true, Store::make()), ring = cut(whole, divider, false, Store::make());
  const Version exact = makeCylinder(Store::make(), Grid{}, Vec3d::Zero(), 10, 16, 0);
  const auto error = fieldError(rod, exact, 1);
  std::printf("lasso: %.4f RMS, %.3f worst within 1 voxel\n", error.rms, error.worst);
  EXPECT_LE(error.rms, 0.08);
  EXPECT_TRUE(topology(rod).closed());
  const TopologyReport report = topology(ring);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(static_cast<int64_t>(report.vertices), static_cast<int64_t>(report.triangles) / 2);  // Genus one.
}

TEST(CurveDivider, NearPartsOfTheCurveGiveWhatTheWholeGives) {
  const uint64_t seed = 4;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-20, 20);
  for (int i = 0; i < 20; ++i) {
    CurveDivider::Curve curve{{}, {u(random), u(random), u(random)}, i % 2 == 0, i % 3 == 0 ? 0.7 : 0.0};
    for (int k = 0; k < 30; ++k) curve.pointsMm.push_back({u(random), u(random), u(random)});
    const CurveDivider divider(curve);
    std::array<double, kBrickVoxels> all;
    for (int k = 0; k < 20; ++k) {
      const Vec3d first(u(random), u(random), u(random));
      divider.distances(first, 0.5, all);
      for (int v = 0; v < kBrickVoxels; ++v) {
        const Vec3d p = first + 0.5 * Coord{v >> 6, (v >> 3) & 7, v & 7}.toVec3d();
        ASSERT_NEAR(all[size_t(v)], divider.distance(p), 1e-12) << "seed " << seed << " curve " << i;
      }
    }
    // Sides change where the distance is zero and nowhere else.
    for (int k = 0; k < 200; ++k) {
      const Vec3d a(u(random), u(random), u(random)), step = Vec3d(u(random), u(random), u(random)) / 200;
      const double from = divider.distance(a), to = divider.distance(a + step);
      ASSERT_LE(std::abs(from - to), step.norm() + 1e-9) << "seed " << seed << " curve " << i;
    }
  }
}

TEST(CurveDivider, RefusesWhatIsNoCurve) {
  const Vec3d a(0, 0, 0), b(1, 0, 0), ahead(0, 0, 1);
  EXPECT_THROW(CurveDivider({{a}, ahead, false, 0}), Error);
  EXPECT_THROW(CurveDivider({{a, a}, ahead, false, 0}), Error);
  EXPECT_THROW(CurveDivider({{a, b}, ahead, true, 0}), Error);
  EXPECT_THROW(CurveDivider({{a, a + ahead}, ahead, false, 0}), Error);
  EXPECT_THROW(CurveDivider({{a, Vec3d(NAN, 0, 0)}, ahead, false, 0}), Error);
  EXPECT_THROW(CurveDivider({{a, b}, Vec3d::Zero(), false, 0}), Error);
  EXPECT_THROW(PlaneDivider(a, Vec3d::Zero()), Error);
  EXPECT_THROW(PlaneDivider(Vec3d(INFINITY, 0, 0), b), Error);
}

TEST(CurveDivider, SmoothingKeepsCornersAndRoundsTheRest) {
  // A quarter of a circle from few points, and a right angle.
  CurveDivider::Curve arc{{}, -Vec3d::UnitZ(), false, 0.2};
  for (int i = 0; i <= 6; ++i)
    arc.pointsMm.push_back({10 * std::cos(i * 0.2617993878), 10 * std::sin(i * 0.2617993878), 0});
  const CurveDivider smooth(arc);
  for (double t = 0.3; t < 1.3; t += 0.01)
    EXPECT_NEAR(smooth.distance({10 * std::cos(t), 10 * std::sin(t), 5}), 0, 0.02);
  const CurveDivider square({{{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, -Vec3d::UnitZ(), true, 0.2});
  EXPECT_NEAR(square.distance({5, 5, 0}), 0, 1e-9);
  EXPECT_NEAR(square.distance({5, 1, 0}), 0, 1e-9);
  EXPECT_NEAR(square.distance({0, 0, 0}), -5, 1e-9);
}

}  // namespace
}  // namespace argil::clay
