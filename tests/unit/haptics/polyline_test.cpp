// Curves of guides: smooth, and their nearest place found whatever their size.

#include "haptics/scene/polyline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Vec3d> ring(int count, double radius) {
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i)
    points.push_back(radius * Vec3d(std::cos(2 * kPi * i / count), std::sin(2 * kPi * i / count), 0));
  return points;
}

std::vector<Vec3d> walk(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Vec3d> points{Vec3d::Zero()};
  Vec3d step(1, 0, 0);
  for (int i = 1; i < count; ++i) {
    step = (step + 0.5 * Vec3d(normal(random), normal(random), normal(random))).normalized() *
           (0.5 + std::abs(normal(random)));
    points.push_back(points.back() + step);
  }
  return points;
}

TEST(Polyline, RefusesWhatIsNoCurve) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Polyline({}), Error);
  EXPECT_THROW(Polyline({{1, 2, 3}, {1, 2, 3}}), Error);
  EXPECT_THROW(Polyline({{1, 2, 3}, {1, nan, 3}}), Error);
  EXPECT_THROW(Polyline({{1, 2, 3}, {1, 2, 3e6}}), Error);
  EXPECT_THROW(Polyline({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}, true), Error);
  EXPECT_NO_THROW(Polyline({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}, true));
}

TEST(Polyline, FollowsASmoothCurveByItsArcLength) {
  const Polyline circle(ring(64, 20), true);
  EXPECT_NEAR(circle.lengthMm(), 2 * kPi * 20, 1e-3);
  double worst = 0, worstLength = 0, worstTurn = 0;
  Polyline::Place before = circle.at(0);
  for (int i = 1; i <= 5000; ++i) {
    const double s = circle.lengthMm() * i / 5000;
    const Polyline::Place place = circle.at(s);
    worst = std::max(worst, std::abs(place.point.norm() - 20));
    worstLength = std::max(worstLength, std::abs(circle.arcLengthMm(place) - s));
    // Without a corner anywhere, the joints included, the tangent turns with the arc.
    worstTurn = std::max(worstTurn, (place.tangent - before.tangent).norm() / (circle.lengthMm() / 5000 / 20));
    before = place;
  }
  EXPECT_LT(worst, 1e-4);
  EXPECT_LT(worstLength, 1e-6);
  EXPECT_LT(worstTurn, 1.2);
}

TEST(Polyline, IsSmoothWhereItsPointsTurnBack) {
  const Polyline hairpin({{0, 0, 0}, {10, 0, 0}, {0, 0, 0}, {0, 10, 0}});
  Polyline::Place before = hairpin.at(0);
  constexpr int kParts = 200'000;
  for (int i = 1; i <= kParts; ++i) {
    const Polyline::Place place = hairpin.at(hairpin.lengthMm() * i / kParts);
    ASSERT_TRUE(place.tangent.allFinite());
    ASSERT_LT((place.tangent - before.tangent).norm(), 0.01) << i;
    ASSERT_LT((place.point - before.point).norm(), 1.1 * hairpin.lengthMm() / kParts) << i;
    before = place;
  }
}

TEST(Polyline, FindsTheNearestPlaceOfAll) {
  constexpr uint32_t kSeed = 3;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal(0, 1);
  for (const bool closed : {false, true}) {
    const Polyline curve(walk(200, kSeed), closed);
    // The slow truth: many places, the best of them by its neighbours.
    constexpr int kParts = 40'000;
    std::vector<Vec3d> places;
    for (int i = 0; i <= kParts; ++i) places.push_back(curve.at(curve.lengthMm() * i / kParts).point);
    const double spacing = curve.lengthMm() / kParts;
    Polyline::Place hint = curve.at(0);
    for (int round = 0; round < 300; ++round) {
      const Vec3d p =
          places[size_t(random() % kParts)] + (round % 3) * 2.0 * Vec3d(normal(random), normal(random), normal(random));
      double truth = std::numeric_limits<double>::infinity();
      for (const Vec3d& q : places) truth = std::min(truth, (q - p).norm());
      hint = curve.nearest(p, round % 2 ? &hint : nullptr);
      ASSERT_LE(hint.distance, truth + 1e-9) << "seed " << kSeed << " round " << round;
      ASSERT_GE(hint.distance, truth - spacing) << "seed " << kSeed << " round " << round;
      ASSERT_NEAR((hint.point - p).norm(), hint.distance, 1e-12);
      // Square to the curve, unless at an end of it.
      if (closed) {
        ASSERT_NEAR((hint.point - p).dot(hint.tangent), 0, 1e-6) << "round " << round;
      }
    }
  }
}

TEST(Polyline, ABeadStaysOnItsStrand) {
  // A figure of eight: pulled along one strand through the crossing, and beside the other.
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i)
    points.push_back({20 * std::sin(2 * kPi * i / 200), 10 * std::sin(4 * kPi * i / 200), 0});
  const Polyline eight(points, true);
  Polyline::Place bead = eight.nearest({-5, -4, 0});
  const Vec3d way = bead.tangent;
  double along = eight.arcLengthMm(bead);
  for (int i = 0; i < 1000; ++i) {
    const Polyline::Place next = eight.slide(bead.point + 0.01 * bead.tangent + Vec3d(0, 0, 0.5), bead);
    const double now = eight.arcLengthMm(next);
    const double moved = std::remainder(now - along, eight.lengthMm());
    ASSERT_NEAR(moved, 0.01, 1e-3) << i;
    along = now;
    bead = next;
  }
  EXPECT_GT(bead.tangent.dot(way), 0.5);
}

TEST(Polyline, CostsTheSameForAMillionPoints) {
  // Counted in groups looked at it is bounded by construction; here that the answers are right where the hint is near
  // and where there is none.
  std::vector<Vec3d> points;
  constexpr int kCount = 1'000'000;
  for (int i = 0; i < kCount; ++i) {
    const double a = 2 * kPi * i / 1000;
    points.push_back({30 * std::cos(a), 30 * std::sin(a), i * 1e-3});
  }
  const Polyline helix(points);
  for (double z : {1.0, 333.3, 999.0 - 1e-3}) {
    const double a = 2 * kPi * z;
    const Vec3d on(30 * std::cos(a), 30 * std::sin(a), z);
    const Polyline::Place place = helix.nearest(on + Vec3d(0.1 * std::cos(a), 0.1 * std::sin(a), 0));
    EXPECT_NEAR((place.point - on).norm(), 0, 1e-3);
  }
  // In the middle everything is as near: the answer is not farther than the hint.
  const Polyline::Place hint = helix.at(1234);
  EXPECT_LE(helix.nearest({0, 0, 500}, &hint).distance, (hint.point - Vec3d(0, 0, 500)).norm());
}

}  // namespace
}  // namespace argil::haptics
