#pragma once
// Rays against boxes and triangles.

#include <cmath>
#include <limits>

#include "clay/base/vec.h"

namespace argil::render {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// Points origin + t · direction with first ≤ t ≤ last; direction of length 1 where t is to be mm.
struct Ray {
  Vec3d origin, direction;
  double first = 0, last = kNever;
};

struct RayHit {
  double distanceMm = 0;
  bool fromOutside = true;  ///< Met a triangle's front.
  Vec3d normal;             ///< Of the triangle, unit, towards its front.
};

/// Where a ray enters a box, at or after its first point; kNever when it misses.
inline double enterBox(const Ray& ray, const Vec3d& min, const Vec3d& max) {
  double first = ray.first, last = ray.last;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = ray.origin[axis], direction = ray.direction[axis];
    if (direction == 0) {
      if (origin < min[axis] || origin > max[axis]) return kNever;
      continue;
    }
    const double a = (min[axis] - origin) / direction, b = (max[axis] - origin) / direction;
    first = std::fmax(first, std::fmin(a, b));
    last = std::fmin(last, std::fmax(a, b));
  }
  return first <= last ? first : kNever;
}

/// Where the ray meets the triangle, from either side; no ray passes between triangles that share an edge or a corner.
/// Woop, Benthin and Wald, "Watertight ray/triangle intersection" (2013).
inline double hitTriangle(const Ray& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d size = ray.direction.cwiseAbs();
  const int z = size.x() > size.y() ? (size.x() > size.z() ? 0 : 2) : (size.y() > size.z() ? 1 : 2);
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double shearX = ray.direction[x] / ray.direction[z], shearY = ray.direction[y] / ray.direction[z];
  // Corners as the ray sees them: the same numbers whichever triangle they belong to.
  const auto seen = [&](const Vec3d& corner) {
    const Vec3d from = corner - ray.origin;
    return Vec3d(from[x] - shearX * from[z], from[y] - shearY * from[z], from[z] / ray.direction[z]);
  };
  const Vec3d p = seen(a), q = seen(b), r = seen(c);
  const double u = r.x() * q.y() - r.y() * q.x(), v = p.x() * r.y() - p.y() * r.x(), w = q.x() * p.y() - q.y() * p.x();
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return kNever;
  const double sum = u + v + w;
  if (sum == 0) return kNever;  // Seen from its edge.
  const double t = (u * p.z() + v * q.z() + w * r.z()) / sum;
  return t >= ray.first && t <= ray.last ? t : kNever;
}

}  // namespace argil::render
