// The question that a stroke asks of each brick: do the model's surface and the tip's meet at an angle here?

#include "clay/kernels/brush_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/kernels/shaping_kernels.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr float kBand = 3, kMost = 0.25f;
using Field = std::array<float, kBrickVoxels>;

// The distance to a plane through the middle of the brick, `off` voxels from it, ±band from there on.
Field plane(const Vec3d& normal, double off = 0) {
  Field field;
  for (int v = 0; v < kBrickVoxels; ++v) {
    const Vec3d at(v >> 6, (v >> 3) & 7, v & 7);
    field[size_t(v)] = std::clamp(float((at - Vec3d(3.5, 3.5, 3.5)).dot(normal.normalized()) - off), -kBand, kBand);
  }
  return field;
}

Vec3d turned(double degrees) {
  return {std::sin(degrees * M_PI / 180), 0, std::cos(degrees * M_PI / 180)};
}

void onEveryTarget(const Field& phi, const Field& solid, float sign, bool meets) {
  tests::forEachSimdTarget([&](const std::string& target) {
    EXPECT_EQ(meetAtAnAngle(phi.data(), solid.data(), sign, kBand, kMost), meets) << target;
  });
}

TEST(MeetAtAnAngle, EdgesDo) {
  for (const double degrees : {20.0, 40.0, 90.0, 160.0}) {
    SCOPED_TRACE(degrees);
    onEveryTarget(plane(turned(0)), plane(turned(degrees)), 1, true);
    onEveryTarget(plane(turned(degrees)), plane(turned(0)), 1, true);
  }
  // Along each axis, as each is looked at by itself.
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    onEveryTarget(plane(Vec3d::Unit(axis)), plane(Vec3d::Unit((axis + 1) % 3)), 1, true);
  }
}

TEST(MeetAtAnAngle, SurfacesThatGoOnAsOneDoNot) {
  onEveryTarget(plane(turned(0)), plane(turned(0)), 1, false);
  onEveryTarget(plane(turned(0)), plane(turned(0), 1.5), 1, false);
  onEveryTarget(plane(turned(0)), plane(turned(8)), 1, false);
}

TEST(MeetAtAnAngle, WhatIsTakenAwayCountsTurnedOver) {
  // A carved solid on the same plane has its clay on the other side.
  onEveryTarget(plane(turned(0)), plane(turned(180)), -1, false);
  onEveryTarget(plane(turned(0)), plane(turned(0)), -1, true);
}

TEST(MeetAtAnAngle, OnlyWhereBothAreNear) {
  Field far;
  far.fill(kBand);
  onEveryTarget(plane(turned(0)), far, 1, false);
  onEveryTarget(far, plane(turned(90)), 1, false);
  // One voxel is not enough to know an angle.
  Field one = far, other = far;
  one[100] = other[100] = 0.5f;
  onEveryTarget(one, other, 1, false);
}

// Two fields that differ by a step between one pair of neighbours: each pair of the brick is looked at, none across its
// faces.
TEST(MeetAtAnAngle, EachPairOfNeighboursIsLookedAt) {
  for (const int step : {64, 8, 1})
    for (int v = 0; v < kBrickVoxels; ++v) {
      const int along = (v / step) & 7;
      Field phi, solid;
      phi.fill(kBand);
      solid.fill(0);
      if (v + step >= kBrickVoxels) continue;
      phi[size_t(v)] = 0;
      phi[size_t(v + step)] = 1;
      // The last of a row and the first of the next are no neighbours.
      ASSERT_EQ(meetAtAnAngle(phi.data(), solid.data(), 1, kBand, kMost), along < 7) << v << " + " << step;
    }
}

// The formula of each falloff (brush.h), in doubles.
double falloff(int shape, double t) {
  if (t >= 1) return 0;
  switch (shape) {
    case 0:
      return 1;
    case 1:
      return (1 - t * t) * (1 - t * t);
    case 2:
      return 1 - t;
    case 3:
      return (1 - t) * (1 - t);
    default:
      return std::sqrt(1 - t * t);
  }
}

TEST(BallWeights, AreTheFalloffTimesTheStrengthAndNeverLessThanBefore) {
  for (const int shape : {0, 1, 2, 3, 4})
    for (const float strength : {0.25f, 1.0f}) {
      SCOPED_TRACE(shape);
      const SweptBall ball{0.5f, -0.25f, 1, 0, 0, 0, 0, 3, 0};
      tests::forEachSimdTarget([&](const std::string& target) {
        float weight[kBrickVoxels] = {};
        weight[0] = 0.5f;  // Outside of the ball.
        weight[7] = 0.0625f;
        ballWeights(ball, shape, strength, weight);
        for (int v = 0; v < kBrickVoxels; ++v) {
          const Vec3d at(v >> 6, (v >> 3) & 7, v & 7);
          const double t = (at - Vec3d(4, 3.25, 4.5)).norm() / 3;
          if (std::abs(t - 1) < 1e-5) continue;
          const double before = v == 0 ? 0.5 : v == 7 ? 0.0625 : 0;
          ASSERT_NEAR(weight[v], std::max(before, strength * falloff(shape, t)), 2e-6) << target << " voxel " << v;
        }
      });
    }
}

// The constant one has a rim of two voxels.
TEST(FootWeights, AreTheFalloffAtTheVoxelsFeet) {
  const SweptBall ball{0.5f, -0.25f, 1, 0, 0, 0, 0, 3, 0};
  float foot[3 * kBrickVoxels];
  for (int v = 0; v < 3 * kBrickVoxels; ++v) foot[v] = 0.25f * float(v % 7 - 3);
  for (const int shape : {0, 1, 2, 3, 4})
    for (const float strength : {0.25f, 1.0f}) {
      SCOPED_TRACE(shape);
      tests::forEachSimdTarget([&](const std::string& target) {
        float weight[kBrickVoxels] = {};
        weight[0] = 0.5f;  // Outside of the ball.
        footWeights(ball, shape, strength, foot, weight);
        for (int v = 0; v < kBrickVoxels; ++v) {
          const Vec3d at(v >> 6, (v >> 3) & 7, v & 7), to(foot[v], foot[kBrickVoxels + v], foot[2 * kBrickVoxels + v]);
          const double away = (at + to - Vec3d(4, 3.25, 4.5)).norm();
          const double own = shape == 0 ? std::clamp((3 - away) / 2, 0.0, 1.0) : falloff(shape, away / 3);
          ASSERT_NEAR(weight[v], std::max(v == 0 ? 0.5 : 0.0, strength * own), 2e-3) << target << " voxel " << v;
        }
      });
    }
}

}  // namespace
}  // namespace argil::clay
