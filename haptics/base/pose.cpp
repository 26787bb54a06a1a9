#include "haptics/base/pose.h"

#include <cmath>

namespace argil::haptics {

// By half angles: the axis is the cross product, as long as the sine of the angle; the sum of both directions is twice
// as long as the cosine of half of it. Eigen's FromTwoVectors has these very bits, but near opposite directions, which
// it solves by a singular value decomposition that every file that calls it compiles for seconds.
Eigen::Quaterniond rotationBetween(const Vec3d& from, const Vec3d& to) noexcept {
  const Vec3d a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  constexpr double kNearOpposite = 1e-6;  // Of the cosine, whose last digits are not enough below.
  if (!(cosine > kNearOpposite - 1)) {
    const double cosineOfHalf = (a + b).norm() / 2;
    Vec3d axis = a.cross(b);
    if (!(axis.squaredNorm() > 1e-24)) axis = a.unitOrthogonal();  // Any will do.
    axis = (axis - axis.dot(a) * a).normalized() * std::sqrt(1 - cosineOfHalf * cosineOfHalf);
    return {cosineOfHalf, axis.x(), axis.y(), axis.z()};
  }
  const double twiceCosineOfHalf = std::sqrt((1 + cosine) * 2);
  const Vec3d axis = a.cross(b) * (1 / twiceCosineOfHalf);
  return {twiceCosineOfHalf * 0.5, axis.x(), axis.y(), axis.z()};
}

}  // namespace argil::haptics
