#pragma once
// A point, a line, a plane or all of space: where a lock lets the tool be.

#include <array>

#include "clay/base/vec.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// An affine set. Invariant: the first min(dimension, 2) axes are orthonormal.
struct Subspace {
  /// 3: all of space; 2: the plane through origin spanned by both axes; 1: the line along axes[0]; 0: origin.
  int dimension = 3;
  Vec3d origin = Vec3d::Zero();
  std::array<Vec3d, 2> axes{Vec3d::UnitX(), Vec3d::UnitY()};

  [[nodiscard]] static Subspace at(const Vec3d& point) ARGIL_REALTIME;
  /// `direction` and `normal`: any length above 0.
  [[nodiscard]] static Subspace line(const Vec3d& point, const Vec3d& direction) ARGIL_REALTIME;
  [[nodiscard]] static Subspace plane(const Vec3d& point, const Vec3d& normal) ARGIL_REALTIME;

  /// The part of a vector that the set lets through.
  [[nodiscard]] Vec3d along(const Vec3d& v) const ARGIL_REALTIME {
    if (dimension == 3) return v;
    Vec3d part = Vec3d::Zero();
    for (int i = 0; i < dimension; ++i) part += axes[size_t(i)] * axes[size_t(i)].dot(v);
    return part;
  }
  /// The place of the set nearest to p.
  [[nodiscard]] Vec3d nearest(const Vec3d& p) const ARGIL_REALTIME {
    return dimension == 3 ? p : Vec3d(origin + along(p - origin));
  }

  /// Keeps what both hold. False, and unchanged, when they have no place in common: parallel within kParallelSine and
  /// apart by more than kApartMm.
  bool intersect(const Subspace& other) ARGIL_REALTIME;

  /// Flatter angles would throw the common place far away for a rounding error.
  static constexpr double kParallelSine = 1e-4;
  static constexpr double kApartMm = 1e-6;

  friend bool operator==(const Subspace&, const Subspace&) = default;

 private:
  bool keepPlane(const Vec3d& normal, const Vec3d& point) ARGIL_REALTIME;
};

}  // namespace argil::haptics
