#pragma once
// Distance to a mesh by looking at every triangle, for tests: shares nothing with clay/mesh/nearest_triangle.h.

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay::testing {

/// Squared distance from p to the nearest triangle; triangles without area do not count.
inline double bruteSquared(const Vec3d& p, const TriangleMesh& mesh) {
  double best = INFINITY;
  for (const auto& [a, b, c] : mesh.triangles) {
    // The foot on the plane when it is inside, else the edges.
    const Vec3d &A = mesh.positions[a], &B = mesh.positions[b], &C = mesh.positions[c];
    const Vec3d n = (B - A).cross(C - A).normalized();
    const Vec3d foot = p - n * n.dot(p - A);
    if (n.dot((B - A).cross(foot - A)) >= 0 && n.dot((C - B).cross(foot - B)) >= 0 &&
        n.dot((A - C).cross(foot - C)) >= 0)
      best = std::min(best, (foot - p).squaredNorm());
    for (const auto& [from, to] : {std::pair(A, B), std::pair(B, C), std::pair(C, A)}) {
      const double t = std::clamp((p - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
      best = std::min(best, (from + t * (to - from) - p).squaredNorm());
    }
  }
  return best;
}

}  // namespace argil::clay::testing
