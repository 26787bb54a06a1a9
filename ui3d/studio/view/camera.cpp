#include "ui3d/studio/view/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::studio {
namespace {

using render::Projection;
using render::View;

constexpr double kPi = std::numbers::pi;
constexpr double kZoomPerClick = 1.15;
constexpr double kGlideSeconds = 0.2;
constexpr double kUprightPerRad = 4;     // A leaning view comes upright by e for each quarter of a radian of orbit.
constexpr double kMostSeconds = 0.1;     // A 3D mouse after a stall of the window goes on, it does not leap.
constexpr double kDeadZone = 0.06;       // Of an axis: a hand at rest on the cap.
constexpr double kPanHeightsPerS = 1.0;  // Of the picture, at full deflection.
constexpr double kZoomPerS = 1.5;        // Powers of e.
constexpr double kTurnPerS = 2.0;        // rad.
constexpr double kLeastDepth = 1e-3;     // Of the distance to the target: a pan of what lies in the eye moves nothing.
// Heights of the picture (at least 10 mm) behind the camera where rays begin.
constexpr double kOrthographicBack = 1e3;

double halfTangent(const View& view) {
  return std::tan(0.5 * view.openingDegrees * kPi / 180);
}

Eigen::Quaterniond orientation(const View& view) {
  const View::Axes a = view.axes();
  Eigen::Matrix3d m;
  m << a.right, a.up, -a.forward;
  return Eigen::Quaterniond(m).normalized();
}

void orient(View& view, const Eigen::Quaterniond& q, double distance) {
  view.position = view.target + distance * (q * Vec3d::UnitZ());
  view.up = q * Vec3d::UnitY();
}

/// The view as three angles: azimuth of what lies to the right, elevation of where it looks, lean about that.
struct Angles {
  double azimuth = 0, elevation = 0, lean = 0;
};

Angles anglesOf(const View::Axes& a) {
  Angles angles;
  constexpr double kUpright = 1e-12;
  Vec3d level = a.right;
  if (std::abs(a.right.z()) > kUpright || a.up.z() < -kUpright) {
    const Vec3d across = a.forward.cross(Vec3d::UnitZ());
    // Straight up or down any lean is a turn.
    level = across.norm() > 1e-9 ? across.normalized() : Vec3d(a.right.x(), a.right.y(), 0).normalized();
  }
  angles.azimuth = std::atan2(level.y(), level.x());
  angles.elevation = std::atan2(a.forward.z(), level.cross(a.forward).z());
  angles.lean = std::atan2(level.cross(a.right).dot(a.forward), level.dot(a.right));
  return angles;
}

View::Axes axesOf(const Angles& angles) {
  const double ca = std::cos(angles.azimuth), sa = std::sin(angles.azimuth);
  const double ce = std::cos(angles.elevation), se = std::sin(angles.elevation);
  const Vec3d level(ca, sa, 0), forward(-sa * ce, ca * ce, se), upright = level.cross(forward);
  const double cl = std::cos(angles.lean), sl = std::sin(angles.lean);
  // Turned about the direction of view, in which level × upright points back at the person.
  return {cl * level - sl * upright, sl * level + cl * upright, forward};
}

double deflection(float axis) {
  const double size = std::abs(std::clamp(double(axis), -1.0, 1.0));
  if (!(size > kDeadZone)) return 0;
  const double beyond = (size - kDeadZone) / (1 - kDeadZone);
  return std::copysign(beyond * beyond, double(axis));  // Fine near rest, fast at the end.
}

/// A factor for the distance that stays within what may be shown, and within what doubles resolve so far from zero.
double allowed(const View& view, double factor) {
  const double height = view.heightAtTarget();
  const double least = std::max(Camera::kLeastHeightMm / height, 4e-9 * (1 + view.target.norm()) / view.distance());
  const double most = Camera::kMostHeightMm / height;
  return factor < 1 ? std::clamp(factor, std::min(least, 1.0), 1.0) : std::clamp(factor, 1.0, std::max(most, 1.0));
}

void scaleDistance(View& view, double factor) {
  view.position = view.target + factor * (view.position - view.target);
}

}  // namespace

Camera::Camera() {
  set(View::named("iso", {}, 16.0 / 9));
}

void Camera::set(const View& view) {
  view.check();
  view_ = view;
  view_.up = view.axes().up;
  glide_ = 1;
}

void Camera::orbit(float dx, float dy, float height, const Vec3d& pivot) {
  glide_ = 1;
  const double perUnit = kPi / std::max(1.0, double(height));
  const View::Axes before = view_.axes();
  Angles angles = anglesOf(before);
  angles.azimuth -= dx * perUnit;
  angles.elevation = std::clamp(angles.elevation - dy * perUnit, -0.5 * kPi, 0.5 * kPi);
  angles.lean *= std::exp(-kUprightPerRad * std::hypot(double(dx), double(dy)) * perUnit);
  const View::Axes after = axesOf(angles);

  const double distance = view_.distance();
  const Vec3d to = pivot - view_.position;
  view_.position = pivot - to.dot(before.right) * after.right - to.dot(before.up) * after.up -
                   to.dot(before.forward) * after.forward;
  view_.target = view_.position + distance * after.forward;
  view_.up = after.up;
}

void Camera::pan(float dx, float dy, float height, double depthMm) {
  glide_ = 1;
  const View::Axes a = view_.axes();
  const double depth = view_.projection == Projection::perspective && std::isfinite(depthMm)
                           ? std::max(depthMm, kLeastDepth * view_.distance())
                           : view_.distance();
  const double mmPerUnit = 2 * depth * halfTangent(view_) / std::max(1.0, double(height));
  const Vec3d by = mmPerUnit * (double(dy) * a.up - double(dx) * a.right);
  view_.position += by;
  view_.target += by;
}

void Camera::zoom(float clicks, const Vec3d& under) {
  if (glide_ < 1) view_ = to_;  // A named view is not left half turned.
  glide_ = 1;
  const double factor = allowed(view_, std::pow(kZoomPerClick, -double(clicks)));
  view_.position = under + factor * (view_.position - under);
  view_.target = under + factor * (view_.target - under);
}

void Camera::motion(const std::array<float, 6>& axes, double seconds) {
  std::array<double, 6> by;
  bool any = false;
  for (size_t i = 0; i < 6; ++i) {
    by[i] = deflection(axes[i]) * std::clamp(seconds, 0.0, kMostSeconds);
    any = any || by[i] != 0;
  }
  if (!any) return;
  glide_ = 1;
  const View::Axes a = view_.axes();
  const Vec3d shift = kPanHeightsPerS * view_.heightAtTarget() * (by[0] * a.right + by[1] * a.up);
  view_.position -= shift;
  view_.target -= shift;
  scaleDistance(view_, allowed(view_, std::exp(-kZoomPerS * by[2])));

  const Vec3d turn = kTurnPerS * (by[3] * a.right + by[4] * a.up - by[5] * a.forward);
  if (const double angle = turn.norm(); angle > 0) {
    const Eigen::Quaterniond back(Eigen::AngleAxisd(-angle, turn / angle));
    orient(view_, (back * orientation(view_)).normalized(), view_.distance());
  }
}

void Camera::glideTo(const View& view) {
  view.check();
  from_ = view_;
  from_.projection = view.projection;
  to_ = view;
  to_.up = view.axes().up;
  glide_ = 0;
}

void Camera::look(const std::string& name, const Vec3d& pivot) {
  const View now = glide_ < 1 ? to_ : view_;  // Keys that follow each other at once add up.
  View next = View::named(name, {}, 1, now.projection);
  next.openingDegrees = now.openingDegrees;
  const View::Axes before = now.axes(), after = next.axes();
  const Vec3d to = pivot - now.position;
  next.position = pivot - to.dot(before.right) * after.right - to.dot(before.up) * after.up -
                  to.dot(before.forward) * after.forward;
  next.target = next.position + now.distance() * after.forward;
  glideTo(next);
}

void Camera::focus(const render::Box& bounds, double aspect) {
  View next = view_;
  next.fit(bounds, aspect);
  glideTo(next);
}

void Camera::toggleProjection() {
  view_.projection = view_.projection == Projection::perspective ? Projection::orthographic : Projection::perspective;
  from_.projection = to_.projection = view_.projection;
}

void Camera::openingDegrees(double degrees) {
  glide_ = 1;
  const double height = view_.heightAtTarget();
  view_.openingDegrees = std::clamp(degrees, 1.0, 150.0);
  scaleDistance(view_, height / view_.heightAtTarget());
}

bool Camera::tick(double seconds) {
  if (glide_ >= 1) return false;
  glide_ += std::max(0.0, seconds) / kGlideSeconds;
  if (glide_ >= 1) {
    view_ = to_;
    return true;  // This step moved it too.
  }
  const double part = glide_ * glide_ * (3 - 2 * glide_);
  view_.target = from_.target + part * (to_.target - from_.target);
  const double distance = from_.distance() * std::pow(to_.distance() / from_.distance(), part);
  orient(view_, orientation(from_).slerp(part, orientation(to_)), distance);
  return true;
}

Camera::Ray Camera::ray(float x, float y, float width, float height) const {
  const View::Axes a = view_.axes();
  const double side = (x - 0.5 * double(width)) / (0.5 * double(height)),
               up = (0.5 * double(height) - y) / (0.5 * double(height));
  if (view_.projection == Projection::perspective) {
    const double tangent = halfTangent(view_);
    return {view_.position, (a.forward + tangent * (side * a.right + up * a.up)).normalized()};
  }
  const double half = 0.5 * view_.heightAtTarget(), back = kOrthographicBack * std::max(2 * half, 10.0);
  return {view_.position + half * (side * a.right + up * a.up) - back * a.forward, a.forward};
}

}  // namespace argil::studio
