#include "haptics/base/pose.h"

#include <gtest/gtest.h>

#include <random>

namespace argil::haptics {
namespace {

// As Eigen's own, bit for bit, wherever the directions are not opposite.
TEST(RotationBetween, HasTheBitsOfEigensOwn) {
  std::mt19937 seed(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 10000; ++i) {
    const Vec3d from(normal(seed), normal(seed), normal(seed)), to(normal(seed), normal(seed), normal(seed));
    ASSERT_EQ(rotationBetween(from, to).coeffs(), Eigen::Quaterniond::FromTwoVectors(from, to).coeffs());
  }
  for (const Vec3d& axis : {Vec3d::UnitX().eval(), Vec3d::UnitY().eval(), Vec3d::UnitZ().eval()})
    EXPECT_EQ(rotationBetween(axis, 3 * axis).coeffs(), Eigen::Quaterniond::Identity().coeffs());
}

TEST(RotationBetween, TakesOppositeDirectionsToEachOther) {
  std::mt19937 seed(6);
  std::normal_distribution<double> normal;
  for (const double apart : {0.0, 1e-17, 1e-15, 1e-13, 1e-10, 1e-7, 1e-6, 1e-5, 1e-3}) {
    for (int i = 0; i < 1000; ++i) {
      const Vec3d from = Vec3d(normal(seed), normal(seed), normal(seed)).normalized();
      const Vec3d to = -(from + apart * from.unitOrthogonal());
      const Eigen::Quaterniond turn = rotationBetween(from, to);
      ASSERT_NEAR(turn.norm(), 1, 1e-9) << apart;
      ASSERT_LT((turn * from - to.normalized()).norm(), 1e-9) << apart;
    }
  }
  for (const Vec3d& axis : {Vec3d::UnitX().eval(), Vec3d::UnitY().eval(), Vec3d::UnitZ().eval()})
    EXPECT_LT((rotationBetween(axis, -2 * axis) * axis + axis).norm(), 1e-15);
}

}  // namespace
}  // namespace argil::haptics
