#pragma once
// Distances beside the line where the surfaces of two solids meet.

#include <algorithm>
#include <cmath>

#include "clay/base/vec.h"

namespace argil::clay {

/// Voxels: distances of sculpted clay are off by less.
inline constexpr float kInexact = 0.5f;
/// Cosine between two surfaces' normals above which they count as one surface: the line where they meet is then
/// nowhere.
inline constexpr float kParallel = 0.995f;

/// Whether a voxel lies outside of one solid, in its band, and as near to the other's surface as that it may be, but
/// for kInexact.
[[nodiscard]] inline bool isNear(float pa, float pb, float band) {
  const float value = std::max(pa, pb);
  return value > 0 && value < band && std::min(pa, pb) > -value - kInexact;
}

/// Whether what the larger of a voxel's distances to two solids was measured to may be gone from their intersection. It
/// can only be gone if it lies outside of the other solid, and then that is nearer than twice the distance, but for
/// kInexact. Where the other solid's band has ended it is not: no distance in the band is as large.
[[nodiscard]] inline bool mayEnd(float pa, float pb, float band) {
  return isNear(pa, pb, band) && std::min(pa, pb) > -band;
}

/// A field's slope along an axis: central differences, but where one neighbour is out of the band the other alone.
[[nodiscard]] inline float slopeWithin(float before, float after, float here, float band) {
  if (std::abs(before) >= band) return std::abs(after) >= band ? 0 : after - here;
  return std::abs(after) >= band ? here - before : (after - before) / 2;
}

/// Distance of a voxel outside of the intersection of two solids to it, from those to both. Near the voxel both are
/// half-spaces. Where the foot on the farther plane lies in the other half-space, that plane is nearest; else the line
/// is where both planes meet. Voxels beside the surface keep the larger distance, so that the surface crosses voxel
/// edges where one of the two solids' does. `a(axis, step)`, `b(axis, step)`: distances a step (−1 or 1) along an axis.
template <class A, class B>
[[nodiscard]] float wedgeDistance(float pa, float pb, float band, const A& a, const B& b) {
  const float high = std::max(pa, pb), low = std::min(pa, pb);
  if (low <= -high) return high;
  Vec3f ga, gb;
  for (int axis = 0; axis < 3; ++axis) {
    const float beforeA = a(axis, -1), beforeB = b(axis, -1);
    if (std::max(beforeA, beforeB) < 0) return high;
    const float afterA = a(axis, 1), afterB = b(axis, 1);
    if (std::max(afterA, afterB) < 0) return high;
    ga[axis] = slopeWithin(beforeA, afterA, pa, band);
    gb[axis] = slopeWithin(beforeB, afterB, pb, band);
  }
  const float lengths = std::sqrt(ga.squaredNorm() * gb.squaredNorm());
  if (!(lengths > 0.25f)) return high;  // a ridge of one of the solids: its normal is not known
  const float cosine =
      std::min(std::max(((ga.x() * gb.x() + ga.y() * gb.y()) + ga.z() * gb.z()) / lengths, -1.0f), 1.0f);
  if (low - cosine * high <= 0 || cosine > kParallel) return high;
  // Opposite half-spaces that do not meet, or far away only.
  if (cosine < -kParallel) return band;
  return std::min(std::sqrt((high * high + low * low - 2 * cosine * high * low) / (1 - cosine * cosine)), band);
}

/// Voxels from the tip of a wedge to the first voxel in it: farther from any voxel of the intersection a face is
/// thinner than the voxels tell, and is none.
inline constexpr int kTipReach = 3;

/// Tells whether a voxel within kTipReach of a place is in the intersection of two solids; `inside(voxel)`: whether it
/// is.
template <class Inside>
[[nodiscard]] bool anyInside(const Vec3d& place, const Inside& inside) {
  const Coord middle{static_cast<int32_t>(std::lround(place.x())), static_cast<int32_t>(std::lround(place.y())),
                     static_cast<int32_t>(std::lround(place.z()))};
  for (int reach = 0; reach <= kTipReach; ++reach)
    for (int x = -reach; x <= reach; ++x)
      for (int y = -reach; y <= reach; ++y)
        for (int z = -reach; z <= reach; ++z) {
          if (std::max({std::abs(x), std::abs(y), std::abs(z)}) != reach) continue;
          if (inside(middle + Coord{x, y, z})) return true;
        }
  return false;
}

/// Distances to faces that are none reach other distances, too: how often these are looked at again.
inline constexpr int kFallenRounds = 3;

/// Whether the surface of the intersection of two solids lies where the distance of a voxel outside of it was measured
/// to: on one of both surfaces, in the other solid, or on the line where both meet. `at(place)`: the larger of both
/// distances there; `voxel`: where `pa`, `pb` are those distances.
template <class A, class B, class At>
[[nodiscard]] bool standsOnSurface(const Vec3d& voxel, float pa, float pb, float band, const A& a, const B& b,
                                   const At& at) {
  constexpr float kOnSurface = 0.35f;  // voxels, as fields are read beside edges
  constexpr float kDirection = 0.25f;  // squared slope below which there is none
  Vec3f ga, gb;
  for (int axis = 0; axis < 3; ++axis) {
    ga[axis] = slopeWithin(a(axis, -1), a(axis, 1), pa, band);
    gb[axis] = slopeWithin(b(axis, -1), b(axis, 1), pb, band);
  }
  const Vec3f& slope = pa > pb ? ga : gb;
  if (slope.squaredNorm() < kDirection) return false;
  const Vec3f foot = slope * (std::max(pa, pb) / std::sqrt(slope.squaredNorm()));
  if (at(voxel - foot.cast<double>()) <= kOnSurface) return true;
  if (ga.squaredNorm() < kDirection || gb.squaredNorm() < kDirection) return false;
  const Vec3f na = ga.normalized(), nb = gb.normalized();
  const float cosine = na.dot(nb), rest = 1 - cosine * cosine;
  if (std::abs(cosine) > kParallel) return false;
  const Vec3f line = na * ((pa - cosine * pb) / rest) + nb * ((pb - cosine * pa) / rest);
  return line.squaredNorm() < band * band && at(voxel - line.cast<double>()) <= kOnSurface;
}

}  // namespace argil::clay
