#include "ui3d/studio/widgets/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kPi = std::numbers::pi;
constexpr double kDotUnits = 4.5, kHotUnits = 6, kHeadUnits = 17, kHeadWidthUnits = 6;
constexpr double kArrowUnits = 62;
constexpr double kArcUnits = 17;
constexpr double kEdgeOn = 0.12;  // Sine: an arc seen from its edge cannot be dragged round.

/// Lines that are made for a dark ground are pale on a light one.
render::Colour onGround(render::Colour c, const World& world) {
  constexpr float kDarker = 0.68f, kMostLuminance = 0.2f;  // contrast with a light ground of 3 at least
  if (!world.state.look.lightBackground) return c;
  const auto darken = [&](float by) { c = {by * c.r, by * c.g, by * c.b, c.a}; };
  darken(kDarker);
  // Nearly linear light: good enough to tell pale from dark.
  const auto luminance = [&] { return 0.2126f * c.r * c.r + 0.7152f * c.g * c.g + 0.0722f * c.b * c.b; };
  if (const float now = luminance(); now > kMostLuminance) darken(std::sqrt(kMostLuminance / now));
  return c;
}

render::Colour darker(render::Colour c) {
  return {0.25f * c.r, 0.25f * c.g, 0.25f * c.b, c.a};
}

bool isHot(const Handle& handle, const std::vector<const Handle*>& hot) {
  return std::any_of(hot.begin(), hot.end(), [&](const Handle* other) { return other->same(handle); });
}

/// A regular figure that faces the eye.
std::vector<Vec3d> facing(const ScreenMap& screen, const Vec3d& at, double units, int corners, double first) {
  std::vector<Vec3d> result;
  const double r = units * screen.unitMm(at);
  for (int i = 0; i < corners; ++i) {
    const double a = first + 2 * kPi * i / corners;
    result.push_back(at + r * (std::cos(a) * screen.axes().right + std::sin(a) * screen.axes().up));
  }
  return result;
}

void solid(Build& build, const std::vector<Vec3d>& outline, render::Colour colour) {
  std::vector<Vec3d> triangles;
  for (size_t i = 1; i + 1 < outline.size(); ++i) {
    triangles.push_back(outline[0]);
    triangles.push_back(outline[i]);
    triangles.push_back(outline[i + 1]);
  }
  build.fill(std::move(triangles), colour, render::Depth::onTop);
  build.closedLine(outline, darker(colour), 1.2f, render::Depth::onTop);
}

}  // namespace

render::Colour axisColour(int axis) {
  return axis == 0 ? widget_colours::kX : axis == 1 ? widget_colours::kY : widget_colours::kZ;
}

render::Colour faded(render::Colour colour, float alpha) {
  colour.a *= alpha;
  return colour;
}

render::Colour guideColour(const Guide& guide) {
  if (guide.kind == Guide::Kind::ruler || guide.kind == Guide::Kind::angle) return {0.98f, 0.90f, 0.55f, 1};
  switch (guide.feel) {
    case Guide::Feel::seen:
      return {0.78f, 0.82f, 0.88f, 1};
    case Guide::Feel::lock:
      return {0.98f, 0.68f, 0.30f, 1};
    case Guide::Feel::well:
      return {0.36f, 0.84f, 0.80f, 1};
    case Guide::Feel::keepOut:
      return {0.96f, 0.42f, 0.40f, 1};
  }
  return {};
}

std::string lengthText(double mm) {
  const double size = std::abs(mm);
  if (size >= 9999.5) return fmt::format("{:.3f} m", mm / 1000);
  if (size >= 999.95) return fmt::format("{:.1f} mm", mm);
  if (size >= 0.0995 || size == 0) return fmt::format("{:.2f} mm", mm);
  return fmt::format("{:.1f} µm", mm * 1000);
}

std::string angleText(double rad) {
  return fmt::format("{:.1f}°", rad * 180 / kPi);
}

void Build::line(std::vector<Vec3d> points, render::Colour colour, float width, render::Depth depth) {
  lines.push_back({std::move(points), depth == render::Depth::onTop ? colour : onGround(colour, world), width, depth});
}

void Build::closedLine(std::vector<Vec3d> points, render::Colour colour, float width, render::Depth depth) {
  if (!points.empty()) points.push_back(Vec3d(points.front()));
  line(std::move(points), colour, width, depth);
}

void Build::fill(std::vector<Vec3d> triangles, render::Colour colour, render::Depth depth) {
  fills.push_back({std::move(triangles), depth == render::Depth::onTop ? colour : onGround(colour, world), depth});
}

void Build::text(const Vec3d& at, std::string text, render::Colour colour) {
  texts.push_back({at, std::move(text), onGround(colour, world)});
}

double Build::extentMm() const {
  return world.bounds.empty() ? 0.5 * world.screen.view().heightAtTarget() : std::max(1e-3, world.bounds.size().norm());
}

std::vector<Vec3d> Sheet::triangles() const {
  const auto c = corners();
  return {c[0], c[1], c[2], c[0], c[2], c[3]};
}

std::vector<Vec3d> Sheet::rim() const {
  constexpr double kWidth = 0.04;  // Of the smaller side.
  const double width = kWidth * std::min(halfX, halfY);
  Sheet inner = *this;
  inner.halfX -= width;
  inner.halfY -= width;
  const auto out = corners(), in = inner.corners();
  std::vector<Vec3d> triangles;
  for (size_t i = 0; i < 4; ++i) {
    const size_t j = (i + 1) % 4;
    triangles.insert(triangles.end(), {out[i], out[j], in[j], out[i], in[j], in[i]});
  }
  return triangles;
}

void sheetHandles(Build& build, const Sheet& sheet, const Target& target, const Vec3d& foot, render::Colour colour,
                  bool tilts) {
  const Vec3d n = sheet.normal();
  Handle arrow;
  arrow.target = target;
  arrow.name = "along normal";
  arrow.way = Way::along;
  arrow.anchor = sheet.centre;
  arrow.axis = n;
  arrow.form = Form::arrow;
  arrow.points = {foot, foot + kArrowUnits * build.unit(foot) * n};
  arrow.colour = colour;
  arrow.aligns = true;
  arrow.apply = applyRigid;
  build.handles.push_back(arrow);
  if (!tilts) return;
  for (int i = 0; i < 2; ++i) {
    // out × n... turns out towards n.
    const Vec3d out = i == 0 ? sheet.x : sheet.y, axis = i == 0 ? -sheet.y : sheet.x;
    const double radius = i == 0 ? sheet.halfX : sheet.halfY;
    if (std::abs(build.world.screen.toEye(sheet.centre).dot(axis)) < kEdgeOn) continue;
    const Vec3d middle = sheet.centre + radius * out;
    const double half = std::min(0.6, kArcUnits * build.unit(middle) / radius);
    Handle tilt;
    tilt.target = target;
    tilt.name = "tilt";
    tilt.index = i;
    tilt.way = Way::about;
    tilt.anchor = sheet.centre;
    tilt.axis = axis;
    tilt.form = Form::path;
    tilt.points = arc(sheet.centre, out, n, radius, -half, half, 12);
    tilt.colour = colour;
    tilt.apply = applyRigid;
    build.handles.push_back(tilt);
  }
}

void buildGuide(Build& build, const Guide& guide, const Stance& stance) {
  switch (guide.kind) {
    case Guide::Kind::plane:
      return buildPlane(build, guide, stance);
    case Guide::Kind::line:
      return buildLine(build, guide, stance);
    case Guide::Kind::point:
      return buildPoint(build, guide, stance);
    case Guide::Kind::curve:
      return buildCurve(build, guide, stance);
    case Guide::Kind::keepOutBox:
      return buildKeepOutBox(build, guide, stance);
    case Guide::Kind::ruler:
      return buildRuler(build, guide, stance);
    case Guide::Kind::angle:
      return buildAngle(build, guide, stance);
  }
}

std::optional<Vec3d> pivotOf(const World& world, const engine::Document& shown, engine::Id id) {
  if (const Guide* guide = shown.guide(id)) {
    if (guide->pointsMm.empty()) return guide->pose.translation;
    Vec3d sum = Vec3d::Zero();
    for (const Vec3d& p : guide->pointsMm) sum += p;
    return sum / double(guide->pointsMm.size());
  }
  if (!shown.thing(id)) return {};
  if (world.boundsOf) {
    const render::Box box = world.boundsOf(id);
    if (!box.empty()) return box.centre();
  }
  if (const auto* piece = shown.piece(id)) return piece->pose.translation;
  if (const auto* part = shown.part(id)) return part->pose.translation;
  return {};
}

Build buildAll(const World& world, const engine::Document& shown, const std::optional<Vec3d>& pivot) {
  Build build{world, shown, {}, {}, {}, {}, {}};
  const StudioState& state = world.state;
  for (const Guide& guide : shown.guides) {
    if (!guide.visible) continue;
    Stance stance;
    stance.selected = guide.id == state.selected;
    stance.grabbed = !guide.locked;
    stance.gizmo = stance.selected && stance.grabbed && state.gizmo != GizmoMode::none;
    buildGuide(build, guide, stance);
  }
  buildSymmetry(build);
  buildSection(build);
  if (world.reachMm.minCoeff() > 0) buildWorkspaceBox(build);
  if (state.bedShown) buildPrintBed(build);
  buildPegs(build);
  buildLattice(build);
  buildPlaneCut(build);
  buildDrawnCurve(build);

  const engine::Thing* selected = shown.thing(state.selected);
  if (selected && selected->visible && !selected->locked && state.gizmo != GizmoMode::none) {
    if (const auto at = pivot ? pivot : pivotOf(world, shown, selected->id)) {
      Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
      bool sized = false;
      if (const Guide* guide = shown.guide(selected->id)) {
        if (guide->pointsMm.empty()) axes = guide->pose.rotation.toRotationMatrix();
        sized = guide->kind != Guide::Kind::point;
      }
      const bool body = shown.guide(selected->id) == nullptr;
      const bool scales = body && state.gizmo == GizmoMode::scale;
      buildGizmo(build, {scales ? Target::Kind::scale : Target::Kind::thing, selected->id}, state.gizmo, *at, axes,
                 sized || body);
    }
  }
  return build;
}

std::vector<Vec3d> arc(const Vec3d& centre, const Vec3d& x, const Vec3d& y, double radius, double from, double to,
                       int steps) {
  std::vector<Vec3d> points;
  points.reserve(size_t(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps;
    points.push_back(centre + radius * (std::cos(a) * x + std::sin(a) * y));
  }
  return points;
}

void drawHandles(Build& build, const std::vector<const Handle*>& hot) {
  const ScreenMap& screen = build.world.screen;
  for (const Handle& handle : build.handles) {
    const bool on = isHot(handle, hot);
    const render::Colour colour = on ? widget_colours::kHot : handle.colour;
    const double size = on ? kHotUnits : kDotUnits;
    switch (handle.form) {
      case Form::dot:
        solid(build, facing(screen, handle.points[0], size, 16, 0), colour);
        break;
      case Form::square:
        solid(build, facing(screen, handle.points[0], 1.3 * size, 4, kPi / 4), colour);
        break;
      case Form::arrow: {
        const Vec3d tip = handle.points.back();
        const Vec3d along = (tip - handle.points.front()).normalized(), away = screen.toEye(tip);
        const Vec3d aside = along.cross(away);
        const double unit = screen.unitMm(tip), scale = on ? 1.2 : 1;
        build.line({handle.points.front(), tip - kHeadUnits * unit * along}, colour, on ? 4.f : 3.f,
                   render::Depth::onTop);
        if (aside.norm() < 0.2) {  // It points at the eye.
          solid(build, facing(screen, tip, size, 16, 0), colour);
          break;
        }
        const Vec3d base = tip - kHeadUnits * scale * unit * along,
                    half = kHeadWidthUnits * scale * unit * aside.normalized();
        solid(build, {tip, base - half, base + half}, colour);
        break;
      }
      case Form::path:
        build.line(handle.points, colour, on ? 5.f : 3.2f, render::Depth::onTop);
        break;
      case Form::area:
        build.fill(handle.points, faded(colour, on ? 0.85f : 0.45f), render::Depth::onTop);
        break;
      case Form::unseen:
        if (on) build.line(handle.points, faded(widget_colours::kHot, 0.9f), 3.5f, render::Depth::xray);
        break;
    }
  }
}

}  // namespace argil::studio
