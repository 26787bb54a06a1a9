#pragma once
// Guides and materials as scripts hold them.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "clay/base/vec.h"
#include "haptics/scene/guide.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

class Place;

/// A guide of haptics/scene/guide.h in plain numbers. `{"guide": NAME, ...}` with the keys that the kind needs:
/// lock_to_point at · lock_to_line at, direction · lock_to_plane at, direction · lock_to_curve points, closed ·
/// lock_to_normal · keep_out_box at, size_mm, inside · keep_out_ball at, radius_mm, inside · keep_out_plane at,
/// direction (to the free side) · well_at_points points, range_mm, force_n · well_at_curve points, closed, range_mm,
/// force_n · well_at_plane at, direction, range_mm, force_n · well_at_clay range_mm, force_n · gravity direction,
/// force_n · buoyancy at, direction, force_n, depth_mm · viscosity drag_nsmm · ambient_plane at, direction,
/// stiffness_nmm, force_n. All may have while_buttons; closed and inside are false when left out.
struct GuideSetup {
  enum class Kind : uint8_t {
    lockToPoint,
    lockToLine,
    lockToPlane,
    lockToCurve,
    lockToNormal,
    keepOutBox,
    keepOutBall,
    keepOutPlane,
    wellAtPoints,
    wellAtCurve,
    wellAtPlane,
    wellAtClay,
    gravity,
    buoyancy,
    viscosity,
    ambientPlane
  };
  Kind kind = Kind::lockToPoint;
  Vec3d atMm = Vec3d::Zero(), direction = Vec3d::Zero(), sizeMm = Vec3d::Zero();
  std::vector<Vec3d> pointsMm;
  bool closed = false, inside = false;
  double radiusMm = 0, rangeMm = 0, depthMm = 0, forceN = 0, stiffnessNmm = 0, dragNsmm = 0;
  uint32_t whileButtons = 0;

  friend bool operator==(const GuideSetup&, const GuideSetup&) = default;
};

/// Throws Error that names the place for keys that are unknown or missing and numbers out of range.
[[nodiscard]] GuideSetup readGuide(const Place& place);
[[nodiscard]] nlohmann::json guideJson(const GuideSetup& guide);
/// `{"stiffness_nmm", "hardness_nmm2", "viscosity_nsmm", "drag_nsmm", "static_friction", "dynamic_friction",
/// "viscous_friction_nsmm"}`, any of them.
[[nodiscard]] haptics::Material readMaterial(const Place& place);
[[nodiscard]] nlohmann::json materialJson(const haptics::Material& material);

/// For the page on scripts: kinds of guides with their keys, but for "guide" and "while_buttons"; properties of a
/// material.
struct GuideKind {
  std::string_view name;
  std::vector<std::string_view> keys;
};
[[nodiscard]] std::vector<GuideKind> guideKinds();
struct MaterialKey {
  std::string_view key;
  double least = 0, most = 0;
};
[[nodiscard]] std::vector<MaterialKey> materialKeys();

/// For a scene, ids from 1. Throws Error for what haptics refuses (a curve of one point).
[[nodiscard]] std::vector<haptics::Guide> sceneGuides(std::span<const GuideSetup> guides);

}  // namespace argil::engine
