#include "ui3d/studio/view/cursor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/tools/tool_table.h"

namespace argil::studio {
namespace {

using render::Cursor;
using render::View;

constexpr double kFelt = 1e-3;          // N: less is no contact's force.
constexpr double kReach = 3;            // Radii from the ball's centre to a footprint.
constexpr double kMostAlongView = 0.9;  // Cosine: a stylus that points at the eye hides its own ball.

double mmPerUnit(const View& view, const Vec3d& at, float heightUnits) {
  const double height = view.heightAtTarget() / std::max(1.0f, heightUnits);
  if (view.projection == render::Projection::orthographic) return height;
  return height * std::max(1e-3, (at - view.position).dot(view.axes().forward) / view.distance());
}

Vec3d shaftOf(const Eigen::Quaterniond& rotation, const View& view, bool turns) {
  const View::Axes a = view.axes();
  const Vec3d leaning = (0.5 * a.right + 0.6 * a.up - 0.65 * a.forward).normalized();
  if (!turns) return leaning;
  const Vec3d shaft = rotation * Vec3d::UnitZ();
  const double along = -shaft.dot(a.forward);
  if (along <= kMostAlongView) return shaft;
  // The more it points at the eye the more it leans, without a leap.
  const double part = (along - kMostAlongView) / (1 - kMostAlongView);
  return (shaft + part * (leaning - shaft)).normalized();
}

Cursor basis(const Vec3d& at, const Eigen::Quaterniond& rotation, const engine::Tool& tool, const View& view,
             const CursorOptions& options) {
  Cursor cursor;
  cursor.positionMm = at;
  cursor.radiusMm = std::max(tool.radiusMm, kLeastBallUnits * mmPerUnit(view, at, options.heightUnits));
  cursor.shaft = shaftOf(rotation, view, options.turns);
  cursor.drop = options.dropAlongView ? view.axes().forward : Vec3d(-Vec3d::UnitZ());
  cursor.fullForceN = options.fullForceN;
  cursor.tint = tintOf(tool);
  return cursor;
}

}  // namespace

render::Colour tintOf(const engine::Tool& tool) {
  switch (engine::rowOf(tool).work) {
    case haptics::Work::cut:
      return {0.35f, 0.81f, 0.98f, 1};
    case haptics::Work::lay:
      return {0.47f, 0.88f, 0.45f, 1};
    case haptics::Work::rub:
      return {0.79f, 0.66f, 0.98f, 1};
  }
  return {0.9f, 0.9f, 0.9f, 1};
}

Cursor makeCursor(const haptics::StylusSample& sample, const engine::Tool& tool, const View& view,
                  const CursorOptions& options, const std::optional<Cursor::Footprint>& footprint) {
  Cursor cursor = basis(sample.proxy, sample.device.rotation, tool, view, options);
  cursor.contact = (sample.flags & (haptics::kTouching | haptics::kCutting)) != 0;
  cursor.forceN = sample.forceN;
  cursor.footprint = footprint;
  return cursor;
}

Cursor pointerCursor(const Cursor::Footprint& surface, const engine::Tool& tool, const View& view,
                     const CursorOptions& options, bool pressed) {
  CursorOptions leaning = options;
  leaning.turns = false;
  Cursor cursor = basis(surface.pointMm, Eigen::Quaterniond::Identity(), tool, view, leaning);
  cursor.footprint = surface;
  cursor.contact = pressed;
  cursor.flat = true;
  return cursor;
}

std::optional<Cursor::Footprint> footprintOf(const haptics::StylusSample& sample, const engine::Tool& tool,
                                             const View& view, const PickSurface& pick) {
  const Vec3d away = view.axes().forward;
  const bool held = (sample.flags & haptics::kTouching) != 0 && sample.forceN.norm() > kFelt;
  const std::array<Vec3d, 2> ways{held ? Vec3d(-sample.forceN.normalized()) : away, -Vec3d::UnitZ()};
  for (const Vec3d& way : ways) {
    // From behind the ball, which a cut may have left in the clay.
    const auto hit = pick(sample.proxy - tool.radiusMm * way, way);
    if (hit && (hit->pointMm - sample.proxy).norm() <= kReach * tool.radiusMm) return hit;
  }
  return {};
}

}  // namespace argil::studio
