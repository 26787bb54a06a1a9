#pragma once
// Where the hand's reach lies in the world: scale, walls that pan, depth, clutch.

#include <Eigen/Geometry>
#include <cstdint>
#include <span>

#include "haptics/base/device.h"
#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// A box inside the device's reach whose walls are felt as springs; a wall that is pressed moves the workspace.
struct PanWalls {
  bool on = false;
  double share = 0.85;        ///< Edges of the box in those of the sheet's workspace, 0.1 to 1.
  double stiffnessNmm = 0.4;  ///< 0.01 to 10; never above the sheet's own top stiffness.
  double restMm = 1;          ///< So deep in the wall nothing moves yet: a hand at rest wanders this far. 0 to 10.
  double speedMmsN = 30;      ///< Of the tip for each newton beyond that, in mm of hand a second. 0 to 1000.
};

/// Settings, part of a scene: world = pose · (scale · device + depth), with x of a left-handed device mirrored first.
/// While nothing ever changed, no wall was pressed and no clutch was used, the servo maps just so; WorkspaceMap says
/// what it does then.
struct Workspace {
  Pose pose;
  double scale = 1;                       ///< World mm per device mm, 1e-6 to 1e6. Stiffness is kept at the hand.
  Handedness frame = Handedness::either;  ///< Of the device's axes: `left` mirrors x; `either` as the sheet says.
  /// World mm along the device's z (towards the person): touchableDepthMm() or the person's own choice.
  double depthMm = 0;
  /// While one of these is down the hand moves and the tip stays: to re-centre. 0: no clutch.
  uint32_t clutchButtons = 0;
  /// After a change of pose or depth the tip glides to its new place at so many mm of hand a second while it touches
  /// nothing. 0: never.
  double glideMms = 100;
  PanWalls walls;

  /// Plans of hand paths. `either` counts as right-handed here.
  [[nodiscard]] Vec3d toWorld(const Vec3d& device) const noexcept {
    return pose.apply(scale * mirror(device, frame == Handedness::left) + Vec3d(0, 0, depthMm));
  }
  [[nodiscard]] Vec3d toDevice(const Vec3d& world) const noexcept {
    return mirror((pose.applyInverse(world) - Vec3d(0, 0, depthMm)) / scale, frame == Handedness::left);
  }

  /// Throws Error when a number is not finite or out of range.
  void check() const;

  [[nodiscard]] static Vec3d mirror(const Vec3d& v, bool mirrored) noexcept {
    return mirrored ? Vec3d(-v.x(), v.y(), v.z()) : v;
  }
};

/// The depth (Workspace::depthMm) at which the front of the device's reach lies a little before what is nearest to the
/// person of all `world` boxes (of pieces, parts and guides), and `behindMm` deeper for a person who wants to reach
/// past it. Zero for no boxes.
[[nodiscard]] double touchableDepthMm(const Workspace& workspace, const DeviceSheet& sheet,
                                      std::span<const Eigen::AlignedBox3d> world, double behindMm = 0);

/// What the servo keeps of a workspace from tick to tick. Invariant: no change of the settings moves the tip in the
/// tick in which it arrives. A change of scale or handedness then holds for good (zoom is about the tip); pose and
/// depth are glided to. One thread, the servo's. Recipe: workspace.md.
class WorkspaceMap {
 public:
  /// Back to the plain mapping: the tip is where pose and scale say.
  void reset() noexcept;

  /// The stylus in the world. `held`: where contact held the tool's ball in the last tick, or null while it was free: a
  /// zoom in mid- press keeps that place, the force, and the depth that the hand is in.
  Pose toWorld(const Workspace& workspace, const DeviceSheet& sheet, const Pose& device, uint32_t buttons,
               double periodS, const Vec3d* held = nullptr) ARGIL_REALTIME;

  // Of the last toWorld():
  /// A world force in the device's frame. Fades out while the clutch is held: a constant force on a hand that goes
  /// anywhere gives energy without end.
  [[nodiscard]] Vec3d toDevice(const Vec3d& forceN) const ARGIL_REALTIME;
  /// A device force in world directions, for samples.
  [[nodiscard]] Vec3d turnToWorld(const Vec3d& forceN) const ARGIL_REALTIME;
  /// A velocity of the hand in the world, mm/s. What the mapping itself adds (walls, glide, zoom) is no speed that a
  /// damper may push against, so velocities are measured in the device's frame.
  [[nodiscard]] Vec3d velocityToWorld(const Vec3d& mmS) const ARGIL_REALTIME { return now_.scale * turnToWorld(mmS); }
  /// Of the pan walls on the hand, device frame, N; at most half of the sheet's peak.
  [[nodiscard]] const Vec3d& wallForce() const noexcept { return wall_; }
  [[nodiscard]] double scale() const noexcept { return now_.scale; }
  /// Energy in the walls' springs, N·mm.
  [[nodiscard]] double wallEnergyNmm() const noexcept { return wallEnergy_; }
  /// Part of a world force that the hand gets: 1 but for the clutch.
  [[nodiscard]] double grip() const noexcept { return grip_; }
  [[nodiscard]] bool panning() const noexcept { return panning_; }
  [[nodiscard]] bool clutched() const noexcept { return clutched_; }

 private:
  struct Mapping {
    Pose pose;
    double scale = 1, depthMm = 0;
    bool mirrored = false;
    [[nodiscard]] Vec3d apply(const Vec3d& device) const ARGIL_REALTIME;
    [[nodiscard]] bool same(const Mapping& other) const ARGIL_REALTIME;
  };
  Vec3d change(const Mapping& next, const Vec3d* held) ARGIL_REALTIME;
  void pressWalls(const PanWalls& walls, const DeviceSheet& sheet, const Vec3d& device, double periodS) ARGIL_REALTIME;
  void glide(double step) ARGIL_REALTIME;

  Mapping now_;
  Vec3d device_ = Vec3d::Zero(), tip_ = Vec3d::Zero();  // Of the last call: device frame, world.
  Vec3d shift_ = Vec3d::Zero();  // World mm on top of the plain mapping, for good: walls, clutch, zoom.
  Vec3d lag_ = Vec3d::Zero();    // The same, until it is glided away.
  Vec3d wall_ = Vec3d::Zero();
  double wallEnergy_ = 0, grip_ = 1;
  bool begun_ = false, panning_ = false, clutched_ = false;
};

}  // namespace argil::haptics
