#pragma once
// Where a Falcon's grip is, from its three arms, and what its motors must do for a force on the hand.

#include <array>

#include "clay/base/vec.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// The Falcon's linkage, mm: three arms of length `arm` about axes on the base, each joined to the grip by a
/// parallelogram of length `rod` whose ends sit `hinge` away from the arm and from the grip. Names in brackets:
/// Stamper's thesis (1997), p. 30. Lengths as published with libnifalcon; leg i lies at angle kFalconLegDeg[i] about
/// the z axis.
struct FalconGeometry {
  double arm = 60;        ///< [a]
  double rod = 102.5;     ///< [b]
  double gripU = 14.43;   ///< [c] From a leg's joint to the grip's centre, radially
  double gripV = -25;     ///< [f] … and sideways.
  double hinge = 11.25;   ///< [d = e]
  double baseU = 40;      ///< [r] From the base's centre to an arm's axis, radially
  double baseV = -23.09;  ///< [s] … and sideways.
};
inline constexpr std::array<double, 3> kFalconLegDeg = {105, -15, -135};

/// Degrees of an arm a count: 320 slots in quadrature, shaft 14.25 mm on a sector of 110 mm diameter.
inline constexpr double kFalconDegPerCount = 360.0 / (320 * 4) * 14.25 / 110.0;
/// Arm angle at count zero, once homed.
inline constexpr double kFalconHomeDeg = 35;
/// Centre of the workspace on the mechanism's z axis, mm from its base plane: the device's origin.
inline constexpr double kFalconCentreMm = 115;

/// Where the grip's centre is and how it moves with the arms. Frame of the device: origin at kFalconCentreMm before the
/// base, x to the right, y up, z towards the person.
struct FalconPose {
  Vec3d positionMm = Vec3d::Zero();
  /// dp/dθ, mm per radian: column i is the motion of the grip for arm i alone.
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
};

using FalconCounts = std::array<int, 3>;

/// Arm angles, radians, from encoder counts.
[[nodiscard]] Vec3d falconArmAngles(const FalconCounts& counts) ARGIL_REALTIME;

/// Forward kinematics from encoder counts: intersection of three spheres in closed form, then
/// Newton steps on the exact linkage, whose hinges bend the spheres. False, `pose` untouched, where no place fits these
/// angles.
[[nodiscard]] bool falconPose(const FalconCounts& counts, FalconPose& pose) ARGIL_REALTIME;
/// The same from any angles, radians.
[[nodiscard]] bool falconPose(const Vec3d& anglesRad, FalconPose& pose) ARGIL_REALTIME;

/// Exact inverse kinematics: the arm angles, radians, that put the grip at `positionMm`. False where it cannot reach.
[[nodiscard]] bool falconInverse(const Vec3d& positionMm, Vec3d& anglesRad) ARGIL_REALTIME;

/// Torques about the arms' axes that put `forceN` on the hand, N·mm: Jᵀ f (virtual work).
[[nodiscard]] inline Vec3d falconTorques(const FalconPose& pose, const Vec3d& forceN) ARGIL_REALTIME {
  return pose.jacobian.transpose() * forceN;
}
/// The force that these torques put on the hand, N. For tests and emulators.
[[nodiscard]] Vec3d falconForce(const FalconPose& pose, const Vec3d& torquesNmm);

}  // namespace argil::haptics
