#pragma once
// A place and an orientation.

#include "clay/vec.h"

namespace argil::haptics {

/// Rigid motion from a body's frame to its parent's: parent = rotation · body + translation.
struct Pose {
  Vec3d translation = Vec3d::Zero();                              ///< mm.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();   ///< Unit.

  [[nodiscard]] Vec3d apply(const Vec3d& body) const noexcept { return rotation * body + translation; }
  [[nodiscard]] Vec3d applyInverse(const Vec3d& parent) const noexcept {
    return rotation.conjugate() * (parent - translation);
  }
};

}  // namespace argil::haptics
