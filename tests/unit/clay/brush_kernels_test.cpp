// The question that a stroke asks of each brick: do the model's surface and the tip's meet at an angle here?

#include "clay/brush_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

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

Vec3d turned(double degrees) { return {std::sin(degrees * M_PI / 180), 0, std::cos(degrees * M_PI / 180)}; }

void onEveryTarget(const Field& phi, const Field& solid, float sign, bool meets) {
  tests::forEachSimdTarget([&](const std::string& target) {
    EXPECT_EQ(meetAtAnAngle(phi.data(), solid.data(), sign, kBand, kMost), meets) << target;
  });
}

TEST(MeetAtAnAngle, edgesDo) {
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

TEST(MeetAtAnAngle, surfacesThatGoOnAsOneDoNot) {
  onEveryTarget(plane(turned(0)), plane(turned(0)), 1, false);
  onEveryTarget(plane(turned(0)), plane(turned(0), 1.5), 1, false);
  onEveryTarget(plane(turned(0)), plane(turned(8)), 1, false);
}

TEST(MeetAtAnAngle, whatIsTakenAwayCountsTurnedOver) {
  // A carved solid on the same plane has its clay on the other side.
  onEveryTarget(plane(turned(0)), plane(turned(180)), -1, false);
  onEveryTarget(plane(turned(0)), plane(turned(0)), -1, true);
}

TEST(MeetAtAnAngle, onlyWhereBothAreNear) {
  Field far;
  far.fill(kBand);
  onEveryTarget(plane(turned(0)), far, 1, false);
  onEveryTarget(far, plane(turned(90)), 1, false);
  // One voxel is not enough to know an angle.
  Field one = far, other = far;
  one[100] = other[100] = 0.5f;
  onEveryTarget(one, other, 1, false);
}

// Two fields that differ by a step between one pair of neighbours: each pair of the brick is looked at, none across its faces.
TEST(MeetAtAnAngle, eachPairOfNeighboursIsLookedAt) {
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

}  // namespace
}  // namespace argil::clay
