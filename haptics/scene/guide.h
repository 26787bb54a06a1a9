#pragma once
// Guides: data of the document that the hand feels. World millimetres throughout.

#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "haptics/base/pose.h"

namespace argil::haptics {

class LocalModelSource;  // haptics/scene/local_model.h
class Polyline;          // haptics/scene/polyline.h: a smooth curve, shared by scenes.

/// The tool's centre is held...
struct LockToPoint {
  Vec3d point = Vec3d::Zero();
};  ///< ...at a place,
struct LockToLine {
  Vec3d point = Vec3d::Zero(), direction = Vec3d::UnitX();
};  ///< ...on an endless line,
struct LockToPlane {
  Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();
};  ///< ...in a plane,
struct LockToCurve {
  std::shared_ptr<const Polyline> curve;
};  ///< ...on a curve,
/// ...on the normal of the surface that the tool touched when the lock began, through the place of the touch.
struct LockToNormal {};

/// The tool's ball may not enter (or, with `inside`, leave).
struct KeepOutBox {
  Pose pose;
  Vec3d halfMm = Vec3d::Constant(10);
  bool inside = false;
};
struct KeepOutBall {
  Vec3d centre = Vec3d::Zero();
  double radiusMm = 10;
  bool inside = false;
};
/// The normal points to the free side.
struct KeepOutPlane {
  Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();
};
struct KeepOutPiece {
  uint32_t piece = 0;
};  ///< Index into Scene::pieces: felt, never cut.

/// Attracts the tool's centre: a potential of finite range, smooth at the rim and in the middle. Caught at 0.7 of the
/// range, let go at the whole of it.
struct WellShape {
  double rangeMm = 5;  ///< Above 0.
  /// Largest attraction, at 0.45 of the range. Rendered is no more than half of the device's peak, and than what keeps
  /// the middle softer than half of its top stiffness.
  double forceN = 1;
};
struct WellAtPoints {
  std::vector<Vec3d> points;
  WellShape shape;
};  ///< The nearest of 1 to kMaxWellPoints.
struct WellAtCurve {
  std::shared_ptr<const Polyline> curve;
  WellShape shape;
};
struct WellAtPlane {
  Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();
  WellShape shape;
};
/// The surface of a piece, from outside; range from the ball, not its centre.
struct WellAtPiece {
  uint32_t piece = 0;
  WellShape shape;
};

/// Everywhere at once.
struct Gravity {
  Vec3d forceN = {0, 0, -0.3};
};  ///< Weight of the tool.
/// Lifts below a level, fully at `depthMm`.
struct Buoyancy {
  Vec3d levelPoint = Vec3d::Zero(), up = Vec3d::UnitZ();
  double forceN = 0.3, depthMm = 5;
};
struct Viscosity {
  double dragNsmm = 0.002;
};  ///< −drag · velocity.
/// Draws to a plane from both sides.
struct AmbientPlane {
  Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();
  double stiffnessNmm = 0.1, mostN = 1;
};
/// As somebody beside the servo says it from moment to moment (haptics/scene/local_model.h); fades when they say
/// nothing.
struct FollowModel {
  std::shared_ptr<LocalModelSource> source;
  double mostN = 1;
};

inline constexpr size_t kMaxWellPoints = 256;
inline constexpr size_t kMaxPieceGuides = 4;  ///< In one scene: each searches its piece in every tick.

/// Hard ones hold the proxy, soft ones only pull.
enum class GuideRole : uint8_t { lock, keepOut, soft };

/// Of guides that contradict each other the earlier in Scene::guides holds.
struct Guide {
  uint32_t id = 0;  ///< Stays with the guide from scene to scene: what the servo knows of it is kept by this. Unique.
  std::variant<LockToPoint, LockToLine, LockToPlane, LockToCurve, LockToNormal, KeepOutBox, KeepOutBall, KeepOutPlane,
               KeepOutPiece, WellAtPoints, WellAtCurve, WellAtPlane, WellAtPiece, Gravity, Buoyancy, Viscosity,
               AmbientPlane, FollowModel>
      shape;
  uint32_t whileButtons = 0;  ///< Works only while one of these buttons is down; 0: always.

  /// Throws Error when a number is not finite or out of range, or a pointer is missing. That pieces are there,
  /// Scene::check sees.
  void check() const;
  [[nodiscard]] GuideRole role() const noexcept { return roleOf(shape.index()); }
  [[nodiscard]] static GuideRole roleOf(size_t kind) noexcept;  ///< `kind`: an index of the variant.
  /// The piece that it names; -1: none.
  [[nodiscard]] int64_t piece() const noexcept;
};

}  // namespace argil::haptics
