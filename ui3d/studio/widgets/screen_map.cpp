#include "ui3d/studio/widgets/screen_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::studio {
namespace {

constexpr double kNearPart = 1e-3;  // Of the distance to the target, as the renderer has it.
constexpr double kBack = 1e3;       // As Camera::ray.

}  // namespace

ScreenMap::ScreenMap(const render::View& view, double width, double height)
    : view_(view),
      axes_(view.axes()),
      width_(width),
      height_(std::max(1.0, height)),
      halfTangent_(std::tan(0.5 * view.openingDegrees * std::numbers::pi / 180)),
      nearMm_(kNearPart * view.distance()) {}

bool ScreenMap::seen(const Vec3d& p) const {
  return view_.projection == render::Projection::orthographic || depth(p) > nearMm_;
}

double ScreenMap::unitMm(const Vec3d& p) const {
  const double z = view_.projection == render::Projection::perspective ? std::max(nearMm_, depth(p)) : view_.distance();
  return 2 * z * halfTangent_ / height_;
}

Vec3d ScreenMap::project(const Vec3d& p) const {
  const Vec3d to = p - view_.position;
  const double unit = unitMm(p);
  return {0.5 * width_ + to.dot(axes_.right) / unit, 0.5 * height_ - to.dot(axes_.up) / unit, to.dot(axes_.forward)};
}

Vec3d ScreenMap::toEye(const Vec3d& p) const {
  if (view_.projection == render::Projection::orthographic) return -axes_.forward;
  const Vec3d to = view_.position - p;
  const double length = to.norm();
  return length > 0 ? Vec3d(to / length) : Vec3d(-axes_.forward);
}

Ray ScreenMap::ray(double x, double y) const {
  const double side = (x - 0.5 * width_) / (0.5 * height_), up = (0.5 * height_ - y) / (0.5 * height_);
  if (view_.projection == render::Projection::perspective)
    return {view_.position, (axes_.forward + halfTangent_ * (side * axes_.right + up * axes_.up)).normalized()};
  const double half = 0.5 * view_.heightAtTarget(), back = kBack * std::max(2 * half, 10.0);
  return {view_.position + half * (side * axes_.right + up * axes_.up) - back * axes_.forward, axes_.forward};
}

Vec3d ScreenMap::place(const Ray& ray) const {
  // The point of the ray at the target's depth.
  const double along = ray.direction.dot(axes_.forward);
  const double t = along > 1e-9 ? (view_.distance() - depth(ray.origin)) / along : view_.distance();
  return project(ray.origin + t * ray.direction);
}

std::optional<ScreenMap::Near> ScreenMap::nearest(std::span<const Vec3d> chain, double x, double y) const {
  std::optional<Near> best;
  const auto consider = [&](Vec3d a, Vec3d b) {
    const bool seenA = seen(a), seenB = seen(b);
    if (!seenA && !seenB) return;
    if (seenA != seenB) {
      const double part = (nearMm_ * 1.01 - depth(a)) / (depth(b) - depth(a));
      (seenA ? b : a) = a + part * (b - a);
    }
    const Vec3d pa = project(a), pb = project(b);
    const double dx = pb.x() - pa.x(), dy = pb.y() - pa.y(), length2 = dx * dx + dy * dy;
    const double s = length2 > 0 ? std::clamp(((x - pa.x()) * dx + (y - pa.y()) * dy) / length2, 0.0, 1.0) : 0;
    const double units = std::hypot(x - pa.x() - s * dx, y - pa.y() - s * dy);
    if (best && units >= best->units) return;
    // A part of the way in the picture is another one in depth.
    const double wa = view_.projection == render::Projection::perspective ? pa.z() : 1;
    const double wb = view_.projection == render::Projection::perspective ? pb.z() : 1;
    const double t = s * wa / (s * wa + (1 - s) * wb);
    best = Near{units, pa.z() + t * (pb.z() - pa.z()), a + t * (b - a)};
  };
  if (chain.size() == 1) consider(chain[0], chain[0]);
  for (size_t i = 1; i < chain.size(); ++i) consider(chain[i - 1], chain[i]);
  return best;
}

std::optional<ScreenMap::Near> ScreenMap::inside(std::span<const Vec3d> triangles, double x, double y) const {
  const Ray sight = ray(x, y);
  std::optional<Near> best;
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const Vec3d &a = triangles[i], &b = triangles[i + 1], &c = triangles[i + 2];
    const Vec3d ab = b - a, ac = c - a, p = sight.direction.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-12 * ab.norm() * ac.norm()) continue;
    const Vec3d s = sight.origin - a;
    const double u = s.dot(p) / determinant;
    const Vec3d q = s.cross(ab);
    const double v = sight.direction.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1) continue;
    const Vec3d point = sight.origin + ac.dot(q) / determinant * sight.direction;
    if (!seen(point) || (best && depth(point) >= best->depthMm)) continue;
    best = Near{0, depth(point), point};
  }
  return best;
}

}  // namespace argil::studio
