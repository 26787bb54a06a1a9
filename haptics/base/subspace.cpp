#include "haptics/base/subspace.h"

#include <cmath>

namespace argil::haptics {

Subspace Subspace::at(const Vec3d& point) ARGIL_REALTIME {
  return {0, point, {Vec3d::Zero(), Vec3d::Zero()}};
}

Subspace Subspace::line(const Vec3d& point, const Vec3d& direction) ARGIL_REALTIME {
  return {1, point, {direction.normalized(), Vec3d::Zero()}};
}

Subspace Subspace::plane(const Vec3d& point, const Vec3d& normal) ARGIL_REALTIME {
  const Vec3d first = normal.unitOrthogonal();
  return {2, point, {first, normal.normalized().cross(first)}};
}

// Keeps what lies in the plane; the set must not be all of space.
bool Subspace::keepPlane(const Vec3d& normal, const Vec3d& point) ARGIL_REALTIME {
  const double gap = normal.dot(point - origin);
  const Vec3d within = along(normal);
  const double sine = within.norm();
  if (!(sine > kParallelSine)) return std::abs(gap) <= kApartMm;
  origin += within * (gap / (sine * sine));
  if (dimension == 2) {
    // The line of a plane across both: the in-plane direction square to the normal's trace.
    const double a = axes[0].dot(within) / sine, b = axes[1].dot(within) / sine;
    axes[0] = (a * axes[1] - b * axes[0]).normalized();
  }
  --dimension;
  return true;
}

bool Subspace::intersect(const Subspace& other) ARGIL_REALTIME {
  if (other.dimension == 3) return true;
  if (dimension == 3) {
    *this = other;
    return true;
  }
  const Subspace before = *this;
  std::array<Vec3d, 3> normals;
  int count = 0;
  if (other.dimension == 2) {
    normals[size_t(count++)] = other.axes[0].cross(other.axes[1]);
  } else if (other.dimension == 1) {
    normals[0] = other.axes[0].unitOrthogonal();
    normals[1] = other.axes[0].cross(normals[0]);
    count = 2;
  } else {
    normals = {Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()};
    count = 3;
  }
  for (int i = 0; i < count; ++i)
    if (!keepPlane(normals[size_t(i)], other.origin)) {
      *this = before;
      return false;
    }
  return true;
}

}  // namespace argil::haptics
