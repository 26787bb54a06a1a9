// The Falcon's kinematics against its exact inverse, through encoders as coarse as the real ones.

#include "haptics/devices/falcon_kinematics.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace argil::haptics {
namespace {

constexpr unsigned kSeed = 41;
constexpr double kRadiusMm = 50;  // Of the ball that is the workspace.
constexpr double kAskedErrorMm = 0.061;
constexpr double kDeg = 180 / std::numbers::pi;

/// Places spread over the ball, edge included.
std::vector<Vec3d> places(size_t count) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-kRadiusMm, kRadiusMm);
  std::vector<Vec3d> all;
  while (all.size() < count) {
    Vec3d p(u(random), u(random), u(random));
    if (p.norm() > kRadiusMm) continue;
    if (all.size() % 4 == 0 && p.norm() > 1) p *= kRadiusMm / p.norm();
    all.push_back(p);
  }
  return all;
}

FalconCounts counts(const Vec3d& angles) {
  FalconCounts c;
  for (int i = 0; i < 3; ++i) c[size_t(i)] = int(std::lround((angles[i] * kDeg - kFalconHomeDeg) / kFalconDegPerCount));
  return c;
}

TEST(FalconKinematics, InvertsTheExactInverseEverywhereInTheWorkspace) {
  std::printf("seed %u\n", kSeed);
  double worst = 0;
  for (const Vec3d& p : places(100'000)) {
    Vec3d angles;
    ASSERT_TRUE(falconInverse(p, angles)) << p.transpose();
    FalconPose pose;
    ASSERT_TRUE(falconPose(angles, pose)) << p.transpose();
    worst = std::max(worst, (pose.positionMm - p).norm());
  }
  std::printf("largest error without encoders: %.5f mm\n", worst);
  EXPECT_LT(worst, 0.005) << "a tenth of an encoder's step at most";
}

// In its corners a real one reaches beyond the ball that its sheet names.
TEST(FalconKinematics, FindsWhatTheLinkageReachesBesideTheWorkspace) {
  constexpr double kReachMm = 80;
  int reached = 0;
  for (const Vec3d& each : places(100'000)) {
    const Vec3d p = each * (kReachMm / kRadiusMm);
    Vec3d angles;
    if (!falconInverse(p, angles)) continue;
    ++reached;
    FalconPose pose;
    ASSERT_TRUE(falconPose(angles, pose)) << p.transpose();
    ASSERT_LT((pose.positionMm - p).norm(), 0.1) << p.transpose();
  }
  EXPECT_GT(reached, 50'000);
}

TEST(FalconKinematics, IsAsRightAsTheEncodersAllow) {
  std::printf("seed %u\n", kSeed);
  double worst = 0, sum = 0;
  const auto all = places(200'000);
  for (const Vec3d& p : all) {
    Vec3d angles;
    ASSERT_TRUE(falconInverse(p, angles));
    FalconPose pose;
    ASSERT_TRUE(falconPose(counts(angles), pose)) << p.transpose();
    worst = std::max(worst, (pose.positionMm - p).norm());
    sum += (pose.positionMm - p).norm();
  }
  std::printf("through encoders: largest error %.4f mm, mean %.4f mm\n", worst, sum / double(all.size()));
  EXPECT_LE(worst, kAskedErrorMm);
  EXPECT_GT(worst, 0.02) << "the encoders were really between";
}

TEST(FalconKinematics, TheLinkageClosesAtTheHomeAngle) {
  // At equal angles the grip is on the axis; the rods, by Pythagoras, close the gap between arm and grip.
  const FalconGeometry g;
  FalconPose pose;
  ASSERT_TRUE(falconPose(FalconCounts{0, 0, 0}, pose));
  EXPECT_NEAR(pose.positionMm.x(), 0, 1e-4);
  EXPECT_NEAR(pose.positionMm.y(), 0, 1e-4);
  const double u = g.baseU - g.gripU + g.arm * std::cos(kFalconHomeDeg / kDeg), v = g.baseV - g.gripV;
  const double reach = std::sqrt(g.rod * g.rod - v * v) + 2 * g.hinge;
  EXPECT_NEAR(pose.positionMm.z() + kFalconCentreMm,
              g.arm * std::sin(kFalconHomeDeg / kDeg) + std::sqrt(reach * reach - u * u), 1e-3);
}

TEST(FalconKinematics, TheJacobianIsTheDerivativeOfTheInverse) {
  std::printf("seed %u\n", kSeed);
  double worst = 0;
  for (const Vec3d& p : places(2'000)) {
    Vec3d angles;
    ASSERT_TRUE(falconInverse(p, angles));
    FalconPose pose;
    ASSERT_TRUE(falconPose(angles, pose));
    constexpr double kH = 1e-4;
    Eigen::Matrix3d inverse;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d after, before;
      ASSERT_TRUE(falconInverse(p + kH * Vec3d::Unit(axis), after));
      ASSERT_TRUE(falconInverse(p - kH * Vec3d::Unit(axis), before));
      inverse.col(axis) = (after - before) / (2 * kH);
    }
    worst = std::max(worst, (pose.jacobian * inverse - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff());
    // Virtual work: what the motors give out is what the hand takes in.
    const Vec3d force(1, -2, 3), motion(0.1, 0.2, -0.3);
    EXPECT_NEAR(falconTorques(pose, force).dot(inverse * motion), force.dot(motion), 0.02);
    EXPECT_LT((falconForce(pose, falconTorques(pose, force)) - force).norm(), 1e-9);
  }
  std::printf("largest element of J times its inverse less one: %.5f\n", worst);
  EXPECT_LT(worst, 0.01);
}

TEST(FalconKinematics, RefusesWhatNoLinkageCanBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  FalconPose pose;
  pose.positionMm = {1, 2, 3};
  EXPECT_FALSE(falconPose(Vec3d(nan, 0, 0), pose));
  EXPECT_FALSE(falconPose(Vec3d(0, inf, 0), pose));
  EXPECT_FALSE(falconPose(FalconCounts{5000, 0, 0}, pose));
  EXPECT_FALSE(falconPose(FalconCounts{0, 0, std::numeric_limits<int>::min()}, pose));
  EXPECT_EQ(pose.positionMm, Vec3d(1, 2, 3));
  Vec3d angles;
  EXPECT_FALSE(falconInverse({0, 0, 500}, angles));
  EXPECT_FALSE(falconInverse({200, 0, 0}, angles));
  // Whatever the encoders say, the answer is a place or a refusal.
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<int> any(-4096, 4096);
  for (int i = 0; i < 100'000; ++i)
    if (falconPose(FalconCounts{any(random), any(random), any(random)}, pose)) {
      ASSERT_TRUE(pose.positionMm.allFinite() && pose.jacobian.allFinite());
    }
}

TEST(FalconKinematics, Costs) {
  std::vector<FalconCounts> all;
  for (const Vec3d& p : places(4'000)) {
    Vec3d angles;
    ASSERT_TRUE(falconInverse(p, angles));
    all.push_back(counts(angles));
  }
  double best = 1e9;
  Vec3d sum = Vec3d::Zero();
  for (int round = 0; round < 100; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    FalconPose pose;
    for (const FalconCounts& c : all) {
      (void)falconPose(c, pose);
      sum += pose.positionMm;
    }
    best = std::min(best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count() /
                              double(all.size()));
  }
  std::printf("position and Jacobian: %.0f ns (%.3g)\n", best, sum.sum());
  EXPECT_LT(best, 20'000) << "no figure, only a bound that a sanitizer and a busy machine keep";
}

}  // namespace
}  // namespace argil::haptics
