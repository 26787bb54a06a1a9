#pragma once
// Points spread evenly over a triangle.

#include <cmath>

#include "clay/base/vec.h"

namespace argil::clay {

/// The i-th of a sequence whose every beginning covers the triangle evenly: the R2 sequence (Roberts 2018), folded.
[[nodiscard]] inline Vec3d evenPoint(const Vec3d& a, const Vec3d& b, const Vec3d& c, int i) {
  double u = std::fmod(0.5 + 0.7548776662 * i, 1), v = std::fmod(0.5 + 0.5698402910 * i, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return a + u * (b - a) + v * (c - a);
}

}  // namespace argil::clay
