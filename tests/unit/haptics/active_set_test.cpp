// The exact solve against an independent one.

#include "haptics/contact/active_set.h"

#include <gtest/gtest.h>

#include <random>

namespace argil::haptics {
namespace {

// Dykstra's alternating projections onto the half-spaces: slow, and shares nothing with the solve.
Vec3d dykstra(const Vec3d& goal, const std::vector<HalfSpace>& planes) {
  Vec3d x = goal;
  std::vector<Vec3d> correction(planes.size(), Vec3d::Zero());
  for (int sweep = 0; sweep < 200'000; ++sweep) {
    double change = 0;
    for (size_t i = 0; i < planes.size(); ++i) {
      const Vec3d y = x + correction[i];
      const double lack = planes[i].offset - planes[i].normal.dot(y);
      x = lack > 0 ? Vec3d(y + lack * planes[i].normal) : y;
      change = std::max(change, (y - x - correction[i]).norm());  // It may rest for long while these still move.
      correction[i] = y - x;
    }
    if (change < 1e-14) break;
  }
  return x;
}

TEST(ActiveSet, AgreesWithAlternatingProjections) {
  constexpr uint32_t kSeed = 5;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal(0, 1);
  int corners = 0;
  for (int round = 0; round < 3000; ++round) {
    const int count = 1 + round % 8;
    // Planes that all allow the origin and face upwards: never without a solution.
    std::vector<HalfSpace> planes;
    for (int i = 0; i < count; ++i) {
      const Vec3d n = Vec3d(normal(random), normal(random), 1.2 + std::abs(normal(random))).normalized();
      planes.push_back({n, -std::abs(0.2 * normal(random))});
    }
    const Vec3d goal(normal(random), normal(random), -2 + normal(random));
    const ActiveSet exact = nearestAllowed(goal, planes.data(), count);
    ASSERT_TRUE(exact.feasible) << "seed " << kSeed << " round " << round;
    const Vec3d slow = dykstra(goal, planes);
    ASSERT_NEAR((exact.x - slow).norm(), 0, 1e-8) << "seed " << kSeed << " round " << round;
    // The conditions of the optimum, to rounding: allowed, pushed only outwards, only by planes that it lies on.
    Vec3d push = Vec3d::Zero();
    for (const HalfSpace& p : planes) ASSERT_GE(p.normal.dot(exact.x) - p.offset, -1e-9);
    for (int i = 0; i < exact.count; ++i) {
      const HalfSpace& p = planes[size_t(exact.active[size_t(i)])];
      ASSERT_GE(exact.multiplier[size_t(i)], -1e-9);
      ASSERT_NEAR(p.normal.dot(exact.x), p.offset, 1e-9);
      push += exact.multiplier[size_t(i)] * p.normal;
    }
    ASSERT_NEAR((exact.x - goal - push).norm(), 0, 1e-9);
    corners += exact.count == 3;
  }
  EXPECT_GT(corners, 20);
}

TEST(ActiveSet, LeavesAnAllowedGoalAlone) {
  const HalfSpace floor{Vec3d::UnitZ(), 0};
  EXPECT_EQ(nearestAllowed({1, 2, 3}, &floor, 1).x, Vec3d(1, 2, 3));
  EXPECT_EQ(nearestAllowed({1, 2, -3}, &floor, 1).x, Vec3d(1, 2, 0));
  EXPECT_EQ(nearestAllowed({1, 2, -3}, &floor, 0).x, Vec3d(1, 2, -3));
}

TEST(ActiveSet, SaysWhenThereIsNoPlace) {
  const HalfSpace planes[] = {{Vec3d::UnitZ(), 1}, {-Vec3d::UnitZ(), 1}};
  EXPECT_FALSE(nearestAllowed({0, 0, 0}, planes, 2).feasible);
}

TEST(ActiveSet, SaysWhenALockLeavesNoPlace) {
  const HalfSpace apart[] = {{Vec3d::UnitZ(), 1}, {-Vec3d::UnitZ(), 1}};
  for (const Subspace& within :
       {Subspace::plane(Vec3d::Zero(), Vec3d::UnitX()), Subspace::line(Vec3d::Zero(), Vec3d::UnitZ())})
    EXPECT_FALSE(nearestAllowed({0, 0, 0}, apart, 2, within).feasible);
  // One that the lock runs along, on its wrong side.
  EXPECT_FALSE(nearestAllowed({0, 0, 0}, apart, 1, Subspace::plane(Vec3d::Zero(), Vec3d::UnitZ())).feasible);
  EXPECT_TRUE(nearestAllowed({0, 0, 0}, apart, 1, Subspace::plane(Vec3d(0, 0, 2), Vec3d::UnitZ())).feasible);
  // The first of them is hard: it alone holds.
  const ActiveSet hard = nearestAllowed({0, 0, 0}, apart, 2, Subspace::plane(Vec3d::Zero(), Vec3d::UnitX()), 1);
  EXPECT_FALSE(hard.feasible);
  EXPECT_NEAR(hard.x.z(), 1, 1e-12);
}

TEST(ActiveSet, HoldsWithPlanesThatAreAlmostOne) {
  const Vec3d n = Vec3d(1e-6, 0, 1).normalized(), m = Vec3d(-1e-6, 1e-7, 1).normalized();
  const HalfSpace planes[] = {{n, 0}, {m, 0}, {Vec3d::UnitZ(), 0}};
  const ActiveSet result = nearestAllowed({0.1, 0, -5}, planes, 3);
  EXPECT_TRUE(result.feasible);
  for (const HalfSpace& p : planes) EXPECT_GE(p.normal.dot(result.x), p.offset - 1e-8);
  EXPECT_LT(result.x.norm(), 5.01);
}

}  // namespace
}  // namespace argil::haptics
