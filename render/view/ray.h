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

/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both sides.
inline double hitTriangle(const Ray& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, p = ray.direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0) return kNever;
  const Vec3d s = ray.origin - a;
  const double u = s.dot(p) / determinant;
  const Vec3d q = s.cross(ab);
  const double v = ray.direction.dot(q) / determinant, t = ac.dot(q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t >= ray.first && t <= ray.last ? t : kNever;
}

}  // namespace argil::render
