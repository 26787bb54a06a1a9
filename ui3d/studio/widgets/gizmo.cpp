// Move, turn and scale what is selected; the same size in every picture.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "ui3d/studio/widgets/box_frame.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kSizeUnits = 100, kGapUnits = 14;
constexpr double kPadFrom = 30, kPadTo = 54;
constexpr double kRingUnits = 84, kViewRingUnits = 100;
constexpr int kRingSteps = 72;
constexpr double kScaleRing = 0.5;     // Of kSizeUnits.
constexpr double kTowardsEye = 0.985;  // Cosine: an axis that points at the eye cannot be dragged along.
constexpr double kEdgeOn = 0.12;       // Sine: nor a plane that is seen from its edge.

constexpr std::string_view kSide = "scale side", kCorner = "scale corner";
// About as much as the operations take: "stretch" and "scale".
constexpr double kMostStretch = 7.5, kMostScale = 100;
constexpr float kBehind = 0.45f;
constexpr double kLeastSideUnits = 24;  // A box with a shorter side has no handles of its own: the ring has.

/// Along one axis of a guide's own: 0, 1, 2; −1: all.
void scaleGuide(Guide& guide, const Vec3d& pivot, int axis, double factor) {
  const double f = std::clamp(factor, 1e-4, 1e4);
  for (Vec3d& p : guide.pointsMm) {
    if (axis < 0) {
      p = pivot + f * (p - pivot);
    } else {
      p[axis] = pivot[axis] + f * (p[axis] - pivot[axis]);
    }
  }
  if (!guide.pointsMm.empty()) return;
  for (int i = 0; i < 3; ++i)
    if (axis < 0 || axis == i) guide.sizeMm[i] = std::max(kLeastSizeMm, f * guide.sizeMm[i]);
}

void applyScale(Subject& subject, const Handle& handle, const Change& change) {
  if (auto* guide = std::get_if<Guide>(&subject)) scaleGuide(*guide, handle.anchor, handle.index, change.factor);
  if (!std::holds_alternative<HeldScale>(subject)) return;
  HeldScale held;
  held.aboutMm = change.about.value_or(handle.anchor);
  if (handle.name == kSide) {
    held.factors[handle.index / 2] = std::clamp(change.factor, 1 / kMostStretch, kMostStretch);
  } else {
    held.factors.setConstant(std::clamp(change.factor, 1 / kMostScale, kMostScale));
  }
  subject = held;
}

bool scales(const Guide& guide, int axis) {
  switch (guide.kind) {
    case Guide::Kind::plane:
      return axis < 2;
    case Guide::Kind::line:
      return axis == 2;
    case Guide::Kind::point:
      return false;
    default:
      return true;
  }
}

/// A box around a piece or a part. A corner scales all sides alike, a side along its axis; what lies opposite stays.
void buildScaleBox(Build& build, const Target& target) {
  if (!build.world.boundsOf) return;
  const render::Box box = build.world.boundsOf(target.id);
  if (box.empty()) return;
  const ScreenMap& screen = build.world.screen;
  const Vec3d half = 0.5 * box.size(), middle = box.centre();
  if (!(half.minCoeff() > 0)) return;
  const BoxFrame frame{{middle, Eigen::Quaterniond::Identity()}, half};
  for (const auto& edge : frame.edges())
    build.line({edge[0], edge[1]}, faded(widget_colours::kHandle, 0.5f), 1.4f, render::Depth::xray);
  if (2 * half.minCoeff() < kLeastSideUnits * screen.unitMm(middle)) return;
  const auto add = [&](std::string_view name, int index, const Vec3d& at, const Vec3d& opposite, const Vec3d& axis,
                       const render::Colour& colour) {
    Handle handle;
    handle.target = target;
    handle.name = name;
    handle.index = index;
    handle.way = Way::scaleBox;
    handle.anchor = opposite;
    handle.axis = axis;
    handle.middle = middle;
    handle.form = Form::square;
    handle.points = {at};
    handle.colour = (at - middle).dot(screen.toEye(at)) > 0 ? colour : faded(colour, kBehind);
    handle.apply = applyScale;
    build.handles.push_back(std::move(handle));
  };
  for (int face = 0; face < 6; ++face) {
    const Vec3d at = frame.faceCentre(face), axis = frame.normal(face);
    if (std::abs(axis.dot(screen.toEye(at))) < kTowardsEye)
      add(kSide, face, at, frame.faceCentre(face ^ 1), axis, axisColour(face / 2));
  }
  for (int i = 0; i < 8; ++i) {
    const Vec3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const Vec3d at = frame.at(sign.x(), sign.y(), sign.z()), axis = (at - middle).normalized();
    if (std::abs(axis.dot(screen.toEye(at))) < kTowardsEye)
      add(kCorner, i, at, 2 * middle - at, axis, widget_colours::kHandle);
  }
}

}  // namespace

void buildGizmo(Build& build, const Target& target, GizmoMode mode, const Vec3d& pivot, const Eigen::Matrix3d& axes,
                bool sized) {
  const ScreenMap& screen = build.world.screen;
  const double unit = screen.unitMm(pivot);
  const Vec3d eye = screen.toEye(pivot),
              across = (screen.axes().right - screen.axes().right.dot(eye) * eye).normalized();
  const auto add = [&](std::string_view name, int index, Way way, const Vec3d& axis, Form form,
                       std::vector<Vec3d> points, render::Colour colour) {
    Handle handle;
    handle.target = target;
    handle.name = name;
    handle.index = index;
    handle.way = way;
    handle.anchor = pivot;
    handle.axis = axis;
    handle.form = form;
    handle.points = std::move(points);
    handle.colour = colour;
    handle.apply = way == Way::scaleAlong || way == Way::scaleAll ? applyScale : applyRigid;
    build.handles.push_back(std::move(handle));
  };

  if (mode == GizmoMode::move) {
    for (int i = 0; i < 3; ++i) {
      const Vec3d axis = axes.col(i), u = axes.col((i + 1) % 3), v = axes.col((i + 2) % 3);
      if (std::abs(axis.dot(eye)) < kTowardsEye)
        add("move axis", i, Way::along, axis, Form::arrow,
            {pivot + kGapUnits * unit * axis, pivot + kSizeUnits * unit * axis}, axisColour(i));
      if (std::abs(axis.dot(eye)) > kEdgeOn) {
        const auto corner = [&](double a, double b) { return Vec3d(pivot + unit * (a * u + b * v)); };
        const std::array<Vec3d, 4> c{corner(kPadFrom, kPadFrom), corner(kPadTo, kPadFrom), corner(kPadTo, kPadTo),
                                     corner(kPadFrom, kPadTo)};
        add("move plane", i, Way::inPlane, axis, Form::area, {c[0], c[1], c[2], c[0], c[2], c[3]}, axisColour(i));
        build.closedLine({c.begin(), c.end()}, axisColour(i), 1.5f, render::Depth::onTop);
      }
    }
    add("move", 0, Way::free, eye, Form::dot, {pivot}, widget_colours::kHandle);
  } else if (mode == GizmoMode::rotate) {
    const double r = kRingUnits * unit;
    for (int i = 0; i < 3; ++i) {
      const Vec3d axis = axes.col(i);
      build.closedLine(arc(pivot, axes.col((i + 1) % 3), axes.col((i + 2) % 3), r, 0, 2 * std::numbers::pi, kRingSteps),
                       faded(axisColour(i), 0.22f), 1.5f, render::Depth::onTop);
      // The half that faces the person can be grabbed; a ring that is seen from its edge is a line there.
      Vec3d front = eye - eye.dot(axis) * axis;
      const bool whole = front.norm() < 0.05;
      front = whole ? Vec3d(axes.col((i + 1) % 3)) : front.normalized();
      const double half = whole ? std::numbers::pi : 0.5 * std::numbers::pi;
      add("turn axis", i, Way::about, axis, Form::path,
          arc(pivot, front, axis.cross(front), r, -half, half, whole ? kRingSteps : kRingSteps / 2), axisColour(i));
    }
    add("turn view", 0, Way::about, eye, Form::path,
        arc(pivot, across, eye.cross(across), kViewRingUnits * unit, 0, 2 * std::numbers::pi, kRingSteps),
        faded(widget_colours::kHandle, 0.85f));
  } else if (mode == GizmoMode::scale && sized) {
    const Guide* guide = build.document.guide(target.id);
    // Clay and parts: all sides alike about the middle, and a box.
    if (!guide) {
      buildScaleBox(build, target);
      for (int i = 0; i < 4; ++i) {
        const double angle = (0.25 + 0.5 * i) * std::numbers::pi;
        const Vec3d out = std::cos(angle) * across + std::sin(angle) * eye.cross(across);
        add("scale", i, Way::scaleAll, eye, Form::square, {pivot + kScaleRing * kSizeUnits * unit * out},
            widget_colours::kHandle);
      }
    }
    for (int i = 0; guide && i < 3; ++i) {
      const Vec3d axis = axes.col(i);
      if (!scales(*guide, i) || std::abs(axis.dot(eye)) >= kTowardsEye) continue;
      build.line({pivot + kGapUnits * unit * axis, pivot + kSizeUnits * unit * axis}, axisColour(i), 3.f,
                 render::Depth::onTop);
      add("scale axis", i, Way::scaleAlong, axis, Form::square, {pivot + kSizeUnits * unit * axis}, axisColour(i));
    }
    add("scale", -1, Way::scaleAll, eye, Form::path,
        arc(pivot, across, eye.cross(across), kScaleRing * kSizeUnits * unit, 0, 2 * std::numbers::pi, kRingSteps),
        widget_colours::kHandle);
  }
}

}  // namespace argil::studio
