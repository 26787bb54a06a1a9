#include "haptics/scene/workspace.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kFrontMargin = 0.1;  // Of the reach's depth, kept free before what is nearest to the person.
// The clutch takes the force away and gives it back in this time: soft, and too short to wait for.
constexpr double kGripSeconds = 0.05;
constexpr double kWallPeakShare = 0.5;  // A wall never takes more of the motors: contact is felt beside it.

void require(bool good, const char* what) {
  if (!good) throw Error(std::string("workspace of the device: ") + what);
}

bool within(double value, double least, double most) {
  return value >= least && value <= most;
}

}  // namespace

void Workspace::check() const {
  require(
      pose.translation.allFinite() && pose.rotation.coeffs().allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6,
      "its pose is not finite or its quaternion not of unit length");
  require(within(scale, 1e-6, 1e6), "the scale must be 1e-6 to 1e6");
  require(std::isfinite(depthMm), "the depth must be finite");
  require(within(glideMms, 0, 1e4), "the glide must be 0 to 10 000 mm/s");
  require(within(walls.share, 0.1, 1), "the walls' share must be 0.1 to 1");
  require(within(walls.stiffnessNmm, 0.01, 10), "the walls' stiffness must be 0.01 to 10 N/mm");
  require(within(walls.restMm, 0, 10), "the walls' rest must be 0 to 10 mm");
  require(within(walls.speedMmsN, 0, 1000), "the walls' speed must be 0 to 1000 mm/s for a newton");
}

double touchableDepthMm(const Workspace& workspace, const DeviceSheet& sheet,
                        std::span<const Eigen::AlignedBox3d> world, double behindMm) {
  double nearest = -std::numeric_limits<double>::infinity();
  for (const Eigen::AlignedBox3d& box : world) {
    if (box.isEmpty()) continue;
    for (int corner = 0; corner < 8; ++corner)
      nearest = std::max(nearest, workspace.pose.applyInverse(box.corner(Eigen::AlignedBox3d::CornerType(corner))).z());
  }
  if (!std::isfinite(nearest)) return 0;
  const double front = workspace.scale * sheet.workspaceMm.z() * (0.5 - kFrontMargin);
  return nearest - front - behindMm;
}

Vec3d WorkspaceMap::Mapping::apply(const Vec3d& device) const ARGIL_REALTIME {
  return pose.apply(scale * Workspace::mirror(device, mirrored) + Vec3d(0, 0, depthMm));
}

bool WorkspaceMap::Mapping::same(const Mapping& other) const ARGIL_REALTIME {
  return scale == other.scale && depthMm == other.depthMm && mirrored == other.mirrored &&
         pose.translation == other.pose.translation && pose.rotation.coeffs() == other.pose.rotation.coeffs();
}

void WorkspaceMap::reset() noexcept {
  *this = WorkspaceMap();
}

// The tip under the new mapping: it stays where it was. While contact holds the ball, that is the tip which a person
// sees, and the spring from there to the hand's place is scaled, so that its length at the hand and with it the force
// stay.
Vec3d WorkspaceMap::change(const Mapping& next, const Vec3d* held) ARGIL_REALTIME {
  Vec3d tip = tip_;
  if (held && next.scale != now_.scale) tip = *held + next.scale / now_.scale * (tip_ - *held);
  const Vec3d left = tip - next.apply(device_);
  if (next.scale != now_.scale || next.mirrored != now_.mirrored)
    shift_ = left - lag_;
  else
    lag_ = left - shift_;
  now_ = next;
  return tip;
}

void WorkspaceMap::pressWalls(const PanWalls& walls, const DeviceSheet& sheet, const Vec3d& device,
                              double periodS) ARGIL_REALTIME {
  const Vec3d half = 0.5 * walls.share * sheet.workspaceMm;
  const Vec3d press = device - device.cwiseMin(half).cwiseMax(-half);
  const double depth = press.norm();
  const double stiffness = std::min(walls.stiffnessNmm, sheet.topStiffnessNmm);
  if (!(depth > 0 && stiffness > 0)) return;  // Inside, or no motors.
  const double force = std::min(stiffness * depth, kWallPeakShare * sheet.peakForceN);
  const Vec3d out = press / depth;
  wall_ = -force * out;
  wallEnergy_ = force * depth - 0.5 * force * force / stiffness;  // Also where the force no longer grows.
  const double beyond = force - stiffness * walls.restMm;
  if (clutched_ || !(beyond > 0)) return;
  panning_ = true;
  const Vec3d step = out * (walls.speedMmsN * beyond * periodS);
  shift_ += now_.pose.rotation * Vec3d(now_.scale * Workspace::mirror(step, now_.mirrored));
}

void WorkspaceMap::glide(double step) ARGIL_REALTIME {
  const double left = lag_.norm();
  if (left <= step)
    lag_.setZero();
  else
    lag_ -= lag_ * (step / left);
}

Pose WorkspaceMap::toWorld(const Workspace& workspace, const DeviceSheet& sheet, const Pose& device, uint32_t buttons,
                           double periodS, const Vec3d* held) ARGIL_REALTIME {
  const Handedness frame = workspace.frame == Handedness::either ? sheet.handedness : workspace.frame;
  const Mapping next{workspace.pose, workspace.scale, workspace.depthMm, frame == Handedness::left};
  clutched_ = (buttons & workspace.clutchButtons) != 0;
  panning_ = false;
  wall_.setZero();
  wallEnergy_ = 0;
  if (!begun_)
    now_ = next;
  else if (!next.same(now_))
    tip_ = change(next, held);
  else if (!held && !clutched_)
    glide(workspace.glideMms * now_.scale * periodS);
  if (workspace.walls.on) pressWalls(workspace.walls, sheet, device.translation, periodS);

  const Vec3d plain = now_.apply(device.translation);
  Vec3d tip = plain + shift_ + lag_;
  if (clutched_ && begun_) {
    tip = tip_;
    shift_ = tip - plain - lag_;
  }
  grip_ = std::clamp(grip_ + (clutched_ ? -periodS : periodS) / kGripSeconds, 0.0, 1.0);
  begun_ = true;
  device_ = device.translation;
  tip_ = tip;

  Eigen::Quaterniond turn = device.rotation;
  if (now_.mirrored) turn = Eigen::Quaterniond(turn.w(), turn.x(), -turn.y(), -turn.z());
  return {tip, now_.pose.rotation * turn};
}

Vec3d WorkspaceMap::toDevice(const Vec3d& forceN) const ARGIL_REALTIME {
  const Vec3d turned = now_.pose.rotation.conjugate() * forceN;
  return Workspace::mirror(grip_ < 1 ? Vec3d(grip_ * turned) : turned, now_.mirrored);
}

Vec3d WorkspaceMap::turnToWorld(const Vec3d& forceN) const ARGIL_REALTIME {
  return now_.pose.rotation * Workspace::mirror(forceN, now_.mirrored);
}

}  // namespace argil::haptics
