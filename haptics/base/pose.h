#pragma once
// A place and an orientation.

#include "clay/base/vec.h"

namespace argil::haptics {

/// Rigid motion from a body's frame to its parent's: parent = rotation · body + translation.
struct Pose {
  Vec3d translation = Vec3d::Zero();                             ///< mm.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< Unit.

  [[nodiscard]] Vec3d apply(const Vec3d& body) const noexcept { return rotation * body + translation; }
  [[nodiscard]] Vec3d applyInverse(const Vec3d& parent) const noexcept {
    return rotation.conjugate() * (parent - translation);
  }
};

/// Part `share` of the way from one to the other, 0 to 1: `to` itself, bit for bit, from 1 on.
[[nodiscard]] inline Pose mix(const Pose& from, const Pose& to, double share) noexcept {
  if (share >= 1) return to;
  return {from.translation + share * (to.translation - from.translation),
          from.rotation.slerp(share, to.rotation).normalized()};
}

/// Where a place goes that is fixed to a body, when the body goes from one pose to another.
[[nodiscard]] inline Vec3d carried(const Pose& from, const Pose& to, const Vec3d& place) noexcept {
  return to.apply(from.applyInverse(place));
}

/// The shortest turn that takes one direction to another, of any lengths but 0. Opposite ones have many: one of them.
[[nodiscard]] Eigen::Quaterniond rotationBetween(const Vec3d& from, const Vec3d& to) noexcept;

}  // namespace argil::haptics
