#include "clay/surface/rim_model.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace argil::clay {

namespace {

// The squared sine of the least angle at which two faces have a rim; the least determinant of three normals that have
// a corner.
constexpr float kLeastSine2 = 0.02f, kLeastCorner = 0.1f;
// Faces meet where a step moves by less than the square root of this, voxels.
constexpr float kStill2 = 1e-6f;
constexpr int kSteps = 6;
// A face whose distance grows by less from one voxel to the next is not left there.
constexpr float kAlong = 0.02f;
// How far from each face a point may be left where they meet, voxels.
constexpr float kMet = 0.02f;

}  // namespace

float RimModel::distance(int k, const Vec3f& p, Vec3f& gradient) const {
  const RimFace& f = fit_.face[k];
  const Vec3f d = p - Vec3f(f.origin[0], f.origin[1], f.origin[2]), normal(f.normal[0], f.normal[1], f.normal[2]);
  const auto [xx, yy, zz, xy, yz, zx] = f.bend;
  const Vec3f b(xx * d.x() + xy * d.y() + zx * d.z(), xy * d.x() + yy * d.y() + yz * d.z(),
                zx * d.x() + yz * d.y() + zz * d.z());
  const float h = d.dot(normal), q = d.dot(b), w = b.squaredNorm(), bent = w * q / (q * q + 1e-8f),
              steep = 1 + bent * h, root = std::sqrt(std::max(0.01f, steep * steep + w));
  gradient = (1 / root) * (steep * normal + b);
  return (2 * h + bent * h * h + q) / (1 + root);
}

float RimModel::joined(const std::array<float, kMostRimFaces>& d) const {
  const auto join = [](bool convex, float a, float b) { return convex ? std::max(a, b) : std::min(a, b); };
  return join(fit_.outerConvex, d[0], fit_.faces == 3 ? join(fit_.innerConvex, d[1], d[2]) : d[1]);
}

float RimModel::distance(const Vec3f& p) const {
  std::array<float, kMostRimFaces> d{};
  Vec3f gradient;
  for (int k = 0; k < fit_.faces; ++k) d[static_cast<size_t>(k)] = distance(k, p, gradient);
  return joined(d);
}

RimModel::Corners RimModel::corners(const Vec3f& low) const {
  Corners corners;
  const float from[3] = {low.x(), low.y(), low.z()};
  for (int k = 0; k < fit_.faces; ++k) cornerDistances(fit_.face[k], from, corners.face[k]);
  if (fit_.faces < kMostRimFaces) std::fill_n(corners.face[2], 8, 0.0f);
  return corners;
}

RimModel::Crossing RimModel::crossing(const Corners& corners, int inside, int outside) const {
  const std::array<float, kMostRimFaces> from = corners.at(inside), to = corners.at(outside);
  Crossing best;
  float least = INFINITY;
  for (size_t k = 0; k < static_cast<size_t>(fit_.faces); ++k) {
    // A face that is not crossed is taken where it comes nearest, if no other is. One along the way is not crossed.
    const float way = to[k] - from[k];
    const float t = std::clamp(std::abs(way) > kAlong ? -from[k] / way : 0.5f, 0.0f, 1.0f);
    std::array<float, kMostRimFaces> there{};
    for (size_t j = 0; j < static_cast<size_t>(fit_.faces); ++j) there[j] = from[j] + t * (to[j] - from[j]);
    const float off = std::abs(joined(there)) + std::abs(there[k]) + std::max(0.0f, kAlong - way);
    if (off < least) least = off, best = {static_cast<int>(k), t};
  }
  return best;
}

bool RimModel::meet(unsigned which, float reach, Vec3f& p, std::array<Vec3f, kMostRimFaces>& g) const {
  const Vec3f start = p;
  std::array<int, kMostRimFaces> faces{};
  size_t n = 0;
  for (unsigned left = which; left != 0; left &= left - 1) faces[n++] = std::countr_zero(left);
  std::array<float, kMostRimFaces> d{};
  for (int step = 0; step < kSteps; ++step) {
    for (size_t k = 0; k < n; ++k) d[k] = distance(faces[k], p, g[k]);
    Vec3f next;
    if (n == 1) {
      next = p - (d[0] / g[0].squaredNorm()) * g[0];
    } else if (n == 2) {
      const float aa = g[0].squaredNorm(), bb = g[1].squaredNorm(), ab = g[0].dot(g[1]), det = aa * bb - ab * ab;
      if (!(det > kLeastSine2 * aa * bb)) return false;
      next = p - ((bb * d[0] - ab * d[1]) / det) * g[0] - ((aa * d[1] - ab * d[0]) / det) * g[1];
      const Vec3f along = g[0].cross(g[1]);
      next -= (along.dot(next - start) / det) * along;
    } else {
      const Vec3f bc = g[1].cross(g[2]), ca = g[2].cross(g[0]), ab = g[0].cross(g[1]);
      const float det = g[0].dot(bc);
      if (!(std::abs(det) > kLeastCorner)) return false;
      next = p - (1 / det) * (d[0] * bc + d[1] * ca + d[2] * ab);
    }
    const float moved = (next - p).squaredNorm();
    p = next;
    if (!((p - start).squaredNorm() <= reach * reach)) return false;
    if (moved < kStill2) return true;
  }
  return false;
}

}  // namespace argil::clay
