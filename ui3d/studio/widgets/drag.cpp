#include "ui3d/studio/widgets/drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kStillUnits = 1.5;  // A press is no drag until the hand has moved so far.
constexpr double kParallel = 1e-3;   // Sine squared, between the line of sight and what is dragged along.
constexpr double kFlat = 5e-3;       // Sine, between the line of sight and a plane.
constexpr double kFarthest = 1e3;    // Distances of the view: beyond, a plane ends in its horizon.
constexpr double kFarthestMm = 1e6;  // From zero: what a document may hold.
constexpr double kEdgeOn = 0.15;     // Sine, between the line of sight and a circle's plane.
constexpr double kScaleStep = 0.1;   // Of constrained scales.

Vec3d without(const Vec3d& v, const Vec3d& axis) {
  return v - v.dot(axis) * axis;
}

}  // namespace

Drag::Drag(const Handle& handle, const Vec3d& grab, Subject start, const Grip& grip, const ScreenMap& screen,
           std::string merge)
    : handle_(handle),
      grab_(grab),
      start_(start),
      now_(std::move(start)),
      merge_(std::move(merge)),
      stylus_(grip.stylus) {
  if (handle_.anchorIsGrab) handle_.anchor = grab_;
  if (stylus_) {
    pressed_ = grip.origin;
    shift_ = grab_ - pressed_;
  } else {
    const Vec3d at = screen.place({grip.origin, grip.direction}), on = screen.project(grab_);
    pressed_ = {at.x(), at.y(), 0};
    shift_ = {on.x() - at.x(), on.y() - at.y(), 0};
  }
  edgeOn_ = handle_.way == Way::about && !stylus_ && std::abs(screen.toEye(grab_).dot(handle_.axis)) < kEdgeOn;
}

Drag::Hand Drag::shifted(const Grip& grip, const ScreenMap& screen) const {
  Hand hand;
  if (stylus_) {
    hand.tip = grip.origin + shift_;
    return hand;
  }
  const Vec3d at = screen.place({grip.origin, grip.direction});
  hand.x = at.x() + shift_.x();
  hand.y = at.y() + shift_.y();
  hand.ray = screen.ray(hand.x, hand.y);
  return hand;
}

std::optional<double> Drag::alongLine(const Hand& hand, const Vec3d& through, const Vec3d& axis,
                                      const ScreenMap& screen) const {
  if (stylus_) return (hand.tip - through).dot(axis);
  const Vec3d w = through - hand.ray.origin;
  const double b = axis.dot(hand.ray.direction), square = 1 - b * b;
  if (square < kParallel) return {};
  const double t = (b * hand.ray.direction.dot(w) - axis.dot(w)) / square;
  if (!screen.seen(through + t * axis) || std::abs(t) > kFarthest * screen.view().distance()) return {};
  return t;
}

std::optional<Vec3d> Drag::onPlane(const Hand& hand, const Vec3d& normal, const ScreenMap& screen) const {
  if (stylus_) return hand.tip - (hand.tip - grab_).dot(normal) * normal;
  const double fall = hand.ray.direction.dot(normal);
  if (std::abs(fall) < kFlat) return {};
  const double t = (grab_ - hand.ray.origin).dot(normal) / fall;
  const Vec3d hit = hand.ray.origin + t * hand.ray.direction;
  if (!screen.seen(hit) || (hit - grab_).norm() > kFarthest * screen.view().distance()) return {};
  return hit;
}

std::optional<Change> Drag::measureMove(const World& world, const engine::Document& shown, const Grip& grip,
                                        const Hand& hand, std::optional<Snap>& snap) const {
  const ScreenMap& screen = world.screen;
  SnapQuery query;
  query.self = handle_.target;
  query.toSurface = handle_.toSurface;
  query.aligns = handle_.aligns;
  query.beside = handle_.beside;
  query.tipReachMm = 1.5 * world.toolRadiusMm;
  Change change;
  if (handle_.way == Way::along) {
    const auto t = alongLine(hand, grab_, handle_.axis, screen);
    if (!t) return {};
    change.move = *t * handle_.axis;
    query.bound = {Bound::Kind::line, handle_.anchor, handle_.axis};
  } else if (handle_.way == Way::inPlane) {
    const auto p = onPlane(hand, handle_.axis, screen);
    if (!p) return {};
    change.move = *p - grab_;
    query.bound = {Bound::Kind::plane, handle_.anchor, handle_.axis};
  } else if (stylus_) {
    change.move = hand.tip - grab_;
  } else {
    const auto p = onPlane(hand, screen.axes().forward, screen);
    if (!p) return {};
    change.move = *p - grab_;
    // The anchor's own line of sight: a body is not always grabbed there.
    const Vec3d on = screen.project(handle_.anchor + change.move);
    query.sight = screen.ray(on.x(), on.y());
  }
  query.at = handle_.anchor + change.move;
  if (grip.constrain) {
    change.move = toGrid(world, query.bound, handle_.anchor, query.at) - handle_.anchor;
  } else if (world.state.snapWidgets && !grip.snapOff) {
    snap = snapPlace(world, shown, query);
    if (snap) change.move = snap->at - handle_.anchor;
  }
  return change;
}

std::optional<Change> Drag::measureTurn(const World& world, const engine::Document& shown, const Grip& grip,
                                        const Hand& hand, std::optional<Snap>& snap) const {
  const Vec3d from = without(grab_ - handle_.anchor, handle_.axis);
  if (!(from.norm() > 0)) return {};
  Change change;
  if (edgeOn_) {
    const auto t = alongLine(hand, grab_, handle_.axis.cross(from).normalized(), world.screen);
    if (!t) return {};
    change.angle = *t / from.norm();
  } else {
    const auto p = onPlane(hand, handle_.axis, world.screen);
    if (!p) return {};
    const Vec3d to = without(*p - handle_.anchor, handle_.axis);
    if (!(to.norm() > 1e-6 * from.norm())) return {};
    change.angle = std::atan2(from.cross(to).dot(handle_.axis), from.dot(to));
  }
  if (grip.constrain) {
    change.angle = std::round(change.angle / kStepAngle) * kStepAngle;
  } else if (world.state.snapWidgets && !grip.snapOff) {
    if (const auto angle = snapTurn(shown, handle_.target, axesOf(start_), handle_.axis, change.angle)) {
      change.angle = *angle;
      snap = Snap{handle_.anchor, "right angle", {}};
    }
  }
  return change;
}

std::optional<Change> Drag::measure(const World& world, const engine::Document& shown, const Grip& grip,
                                    std::optional<Snap>& snap) const {
  const Hand hand = shifted(grip, world.screen);
  Change change;
  switch (handle_.way) {
    case Way::free:
    case Way::along:
    case Way::inPlane:
      return measureMove(world, shown, grip, hand, snap);
    case Way::about:
      return measureTurn(world, shown, grip, hand, snap);
    case Way::scaleAlong: {
      const double before = (grab_ - handle_.anchor).dot(handle_.axis);
      const auto t = alongLine(hand, grab_, handle_.axis, world.screen);
      if (!t || before == 0) return {};
      change.factor = (before + *t) / before;
      break;
    }
    case Way::scaleBox: {
      // A corner is led along the diagonal, a side along its normal.
      const Vec3d from = grip.snapOff ? handle_.middle : handle_.anchor;
      const double before = (grab_ - from).dot(handle_.axis);
      const auto t = alongLine(hand, grab_, handle_.axis, world.screen);
      if (!t || before == 0) return {};
      change.factor = (before + *t) / before;
      change.about = from;
      break;
    }
    case Way::scaleAll: {
      if (stylus_) {
        change.factor = (hand.tip - handle_.anchor).norm() / (grab_ - handle_.anchor).norm();
      } else {
        const Vec3d centre = world.screen.project(handle_.anchor), was = world.screen.project(grab_);
        change.factor = std::hypot(hand.x - centre.x(), hand.y - centre.y()) /
                        std::hypot(was.x() - centre.x(), was.y() - centre.y());
      }
      break;
    }
  }
  if (!std::isfinite(change.factor)) return {};
  change.factor = std::max(change.factor, 1e-3);
  if (grip.constrain) change.factor = std::max(kScaleStep, std::round(change.factor / kScaleStep) * kScaleStep);
  return change;
}

bool Drag::follow(const World& world, const engine::Document& shown, const Grip& grip) {
  if (!moved_) {
    Vec3d at = grip.origin;
    double still = kStillUnits;
    if (stylus_) {
      still *= world.screen.unitMm(grab_);
    } else {
      at = world.screen.place({grip.origin, grip.direction});
      at.z() = 0;
    }
    if ((at - pressed_).norm() < still) return false;
    moved_ = true;
  }
  std::optional<Snap> snap;
  const auto change = measure(world, shown, grip, snap);
  if (!change || !((handle_.anchor + change->move).cwiseAbs().maxCoeff() <= kFarthestMm)) return false;
  Subject next = start_;
  handle_.apply(next, handle_, *change);
  change_ = *change;
  snap_ = std::move(snap);
  if (sameSubject(next, now_)) return false;
  now_ = std::move(next);
  changed_ = true;
  return true;
}

std::string Drag::label(const engine::Document& document) const {
  const bool scales = handle_.way == Way::scaleAlong || handle_.way == Way::scaleAll || handle_.way == Way::scaleBox;
  const char* verb = handle_.way == Way::about ? "Turn" : scales ? "Scale" : "Move";
  if (handle_.name == "insert") verb = "Insert a point in";
  switch (handle_.target.kind) {
    case Target::Kind::symmetry:
      return fmt::format("{} symmetry", verb);
    case Target::Kind::section:
      return fmt::format("{} section", verb);
    case Target::Kind::lattice:
      return "Deform";
    case Target::Kind::workspace:
      return fmt::format("{} workspace", verb);
    case Target::Kind::cut:
      return fmt::format("{} the plane", verb);
    default:
      break;
  }
  if (handle_.name == "corner" || handle_.name == "face") verb = "Resize";
  const engine::Thing* thing = document.thing(handle_.target.id);
  return fmt::format("{} {}", verb, thing ? thing->name : "thing");
}

std::string Drag::text() const {
  if (const auto* guide = std::get_if<Guide>(&now_)) {
    if (handle_.name == "corner") return lengthText(guide->sizeMm.x()) + " × " + lengthText(guide->sizeMm.y());
    if (handle_.name == "face") return lengthText(guide->sizeMm[handle_.index / 2]);
  }
  if (const auto* workspace = std::get_if<haptics::Workspace>(&now_); workspace && handle_.name == "face")
    return fmt::format("× {:.3g}", workspace->scale);
  if (const auto* held = std::get_if<HeldScale>(&now_)) {
    int axis = 0;
    (held->factors - Vec3d::Ones()).cwiseAbs().maxCoeff(&axis);
    const bool alike = held->factors == Vec3d::Constant(held->factors[axis]);
    return fmt::format("{}× {:.2f}", alike ? "" : axis == 0 ? "x " : axis == 1 ? "y " : "z ", held->factors[axis]);
  }
  switch (handle_.way) {
    case Way::about:
      return angleText(change_.angle);
    case Way::scaleAlong:
    case Way::scaleAll:
    case Way::scaleBox:
      return fmt::format("× {:.2f}", change_.factor);
    default:
      return lengthText(change_.move.norm());
  }
}

}  // namespace argil::studio
