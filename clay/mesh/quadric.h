#pragma once
// Squared distances from a point to many planes, as ten numbers.
// Garland, Heckbert: Surface Simplification Using Quadric Error Metrics, SIGGRAPH 1997.

#include "clay/base/vec.h"

namespace argil::clay {

/// Σ wᵢ (nᵢ·x + dᵢ)² over planes of unit normal: xᵀAx + 2b·x + c. Doubles: the terms cancel, so keep the origin near.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Vec3d b = Vec3d::Zero();
  double c = 0;

  void addPlane(const Vec3d& n, double d, double w) {
    xx += w * n.x() * n.x(), xy += w * n.x() * n.y(), xz += w * n.x() * n.z();
    yy += w * n.y() * n.y(), yz += w * n.y() * n.z(), zz += w * n.z() * n.z();
    b += w * d * n;
    c += w * d * d;
  }
  friend Quadric operator+(const Quadric& p, const Quadric& q) {
    return {p.xx + q.xx, p.xy + q.xy, p.xz + q.xz, p.yy + q.yy, p.yz + q.yz, p.zz + q.zz, p.b + q.b, p.c + q.c};
  }
  /// A·x + b: half the gradient.
  [[nodiscard]] Vec3d slope(const Vec3d& x) const {
    return Vec3d(xx * x.x() + xy * x.y() + xz * x.z(), xy * x.x() + yy * x.y() + yz * x.z(),
                 xz * x.x() + yz * x.y() + zz * x.z()) +
           b;
  }
  /// Never below zero.
  [[nodiscard]] double at(const Vec3d& x) const {
    const double value = x.dot(slope(x) + b) + c;
    return value > 0 ? value : 0;
  }
  /// Sum of the weights: the trace of A, as normals are unit.
  [[nodiscard]] double weight() const { return xx + yy + zz; }

  /// Where it is least, held back towards `near` by `hold` of the weight, so that a direction in which the planes say
  /// nothing (along a flat part, along a straight edge) is left as it is.
  [[nodiscard]] Vec3d least(const Vec3d& near, double hold) const {
    const double h = hold * weight();
    const double a = xx + h, d = yy + h, f = zz + h;
    // Inverse of the symmetric matrix by cofactors: it is positive definite.
    const double c00 = d * f - yz * yz, c01 = xz * yz - xy * f, c02 = xy * yz - xz * d;
    const double c11 = a * f - xz * xz, c12 = xy * xz - a * yz, c22 = a * d - xy * xy;
    const double determinant = a * c00 + xy * c01 + xz * c02;
    if (!(determinant > 0)) return near;
    const Vec3d g = slope(near);
    return near - Vec3d(c00 * g.x() + c01 * g.y() + c02 * g.z(), c01 * g.x() + c11 * g.y() + c12 * g.z(),
                        c02 * g.x() + c12 * g.y() + c22 * g.z()) /
                      determinant;
  }
};

}  // namespace argil::clay
