#pragma once
// What a ball can touch.

#include "haptics/scene/closest_surface.h"
#include "haptics/scene/scene.h"

namespace argil::haptics {

/// Nearest point of something touchable, in world millimetres.
struct Nearest {
  bool found = false;  ///< False: nothing within the reach; `distance` is then the reach, with its sign.
  Vec3d point = Vec3d::Zero();
  double distance = 0;  ///< Negative when the place asked for is inside.
};

/// A thing that contact works on: a piece of clay, a mesh part, a keep-out. Servo thread only.
class Touchable {
 public:
  virtual ~Touchable() = default;
  /// Nearest point within `reachMm` of `p`, exact to `resolutionMm` / 50; `hint`: where it was last time, or null. What
  /// has no inside (a mesh part: both faces count) never answers with a negative distance.
  virtual Nearest nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME = 0;
  /// Smooth unit normal of the surface at a point that nearest() gave, for the direction of the force alone (force
  /// shading, Ruspini et al. 1997); its sign does not matter. Zero: take the direction to the point.
  virtual Vec3d normal(const Vec3d& point) ARGIL_REALTIME = 0;
  /// The smallest length that it tells apart, mm: a voxel; what tolerances of contact are counted in.
  [[nodiscard]] virtual double resolutionMm() const ARGIL_REALTIME = 0;
};

/// A piece of a scene as a touchable.
class TouchableClay final : public Touchable {
 public:
  /// Reads `piece` from now on; the scene that holds it is held by the caller. True when it is not what was read
  /// before.
  bool reset(const Piece& piece) ARGIL_REALTIME;
  /// The same, but where it is felt is for move() to say: the piece's own pose is not looked at.
  bool resetClay(const Piece& piece) ARGIL_REALTIME;
  /// It goes there as a rigid body: what is known of it goes along.
  void move(const Pose& to) ARGIL_REALTIME;
  /// Whether that piece is a version of the clay that is read now, edited or not.
  [[nodiscard]] bool reads(const Piece& piece) const ARGIL_REALTIME { return store_ == piece.version.store().get(); }
  Nearest nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME override;

  Vec3d normal(const Vec3d& point) ARGIL_REALTIME override;
  [[nodiscard]] double resolutionMm() const ARGIL_REALTIME override { return voxelMm_; }

  [[nodiscard]] double voxelMm() const noexcept { return voxelMm_; }
  [[nodiscard]] Vec3d toVoxel(const Vec3d& world) const noexcept {
    return toVoxel_ * (world - pose_.translation) - offset_;
  }
  [[nodiscard]] Vec3d toWorld(const Vec3d& voxel) const noexcept {
    return toWorld_ * (voxel + offset_) + pose_.translation;
  }
  /// A world direction in the frame of the voxels.
  [[nodiscard]] Vec3d turnToVoxel(const Vec3d& direction) const noexcept { return toVoxel_ * direction * voxelMm_; }
  [[nodiscard]] ClosestSurface& surface() noexcept { return surface_; }

  /// Whether its clay feels different from place to place; then material() reads the clay.
  [[nodiscard]] bool mixed() const noexcept { return rows_ != nullptr; }
  /// Index into Scene::materials, of a voxel or of the one nearest to a point of the surface (that one is always in the
  /// band). Remembers the brick that it read last.
  [[nodiscard]] uint32_t material(Coord voxel) ARGIL_REALTIME;
  [[nodiscard]] uint32_t material(const Vec3d& world) ARGIL_REALTIME {
    return mixed() ? material(ClosestSurface::nearestVoxel(toVoxel(world))) : material_;
  }

 private:
  bool solid(const Vec3d& world, const Vec3d& at) ARGIL_REALTIME;
  void orient() ARGIL_REALTIME;

  ClosestSurface surface_;
  Pose pose_;
  Vec3d origin_ = Vec3d::Zero();
  // Of pose and voxel size,
  Eigen::Matrix3d toVoxel_ = Eigen::Matrix3d::Identity(), toWorld_ = Eigen::Matrix3d::Identity();
  Vec3d offset_ = Vec3d::Zero();  // and the origin in voxels.
  double voxelMm_ = 1;
  const clay::Version* version_ = nullptr;
  const MaterialRows* rows_ = nullptr;
  uint32_t material_ = 0;
  Coord rowBrick_{INT32_MIN, 0, 0};  // Where materials were read last,
  clay::ChannelSlot rowSlot_;        // and what stood there.
  Vec3d free_ = Vec3d::Zero();       // Of a piece that hides clay: the last place outside that was asked for, world;
  bool freeKnown_ = false, hideMasked_ = false;
  bool within_ = false;  // from there the way led in through what is hidden.
  const clay::VersionRecord* record_ = nullptr;
  const clay::Store* store_ = nullptr;
  uint64_t id_ = 0;
};

}  // namespace argil::haptics
