#pragma once
// Guides: data of the document that the hand feels. World millimetres throughout.

#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "haptics/pose.h"

namespace argil::haptics {

/// An immutable polyline with its arc lengths, shared by scenes. Smooth curves are given finely enough.
class Polyline;

/// The tool's centre is held...
struct LockToPoint { Vec3d point = Vec3d::Zero(); };                                      ///< ...at a place,
struct LockToLine { Vec3d point = Vec3d::Zero(), direction = Vec3d::UnitX(); };           ///< ...on an endless line,
struct LockToPlane { Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ(); };             ///< ...in a plane,
struct LockToCurve { std::shared_ptr<const Polyline> curve; };                            ///< ...on a curve,
struct LockToNormal {};  ///< ...on the normal of the surface that the tool touched when the lock began, through the place of the touch.

/// The tool's ball may not enter (or, with `inside`, leave).
struct KeepOutBox { Pose pose; Vec3d halfMm = Vec3d::Constant(10); bool inside = false; };
struct KeepOutBall { Vec3d centre = Vec3d::Zero(); double radiusMm = 10; bool inside = false; };
struct KeepOutPlane { Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ(); };            ///< The normal points to the free side.
struct KeepOutPiece { uint32_t piece = 0; };                                              ///< Index into Scene::pieces: felt, never cut.

/// Attracts the tool's centre within `rangeMm`: finite range, smooth at both ends, caught at less than let go (hysteresis).
struct WellShape {
  double rangeMm = 5;       ///< Above 0.
  double forceN = 1;        ///< Largest attraction; never more than half of the device's peak is rendered.
};
struct WellAtPoints { std::vector<Vec3d> points; WellShape shape; };
struct WellAtCurve { std::shared_ptr<const Polyline> curve; WellShape shape; };
struct WellAtPlane { Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ(); WellShape shape; };
struct WellAtPiece { uint32_t piece = 0; WellShape shape; };                              ///< The surface of a piece, from outside.

/// Everywhere at once.
struct Gravity { Vec3d forceN = {0, 0, -0.3}; };                                          ///< Weight of the tool.
struct Buoyancy { Vec3d levelPoint = Vec3d::Zero(), up = Vec3d::UnitZ(); double forceN = 0.3, depthMm = 5; };  ///< Lifts below a level, fully at `depthMm`.
struct Viscosity { double dragNsmm = 0.002; };                                            ///< −drag · velocity.
struct AmbientPlane { Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ(); double stiffnessNmm = 0.1, mostN = 1; };  ///< Draws to a plane from both sides.

struct Guide {
  uint32_t id = 0;          ///< Stays with the guide from scene to scene: what the servo knows of it is kept by this. Unique.
  std::variant<LockToPoint, LockToLine, LockToPlane, LockToCurve, LockToNormal, KeepOutBox, KeepOutBall, KeepOutPlane, KeepOutPiece,
               WellAtPoints, WellAtCurve, WellAtPlane, WellAtPiece, Gravity, Buoyancy, Viscosity, AmbientPlane>
      shape;
  uint32_t whileButtons = 0;  ///< Works only while one of these buttons is down; 0: always.

  /// Throws Error when a number is not finite or out of range, or a pointer is missing.
  void check() const;
};

}  // namespace argil::haptics
