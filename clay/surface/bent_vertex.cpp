#include "clay/surface/bent_vertex.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/sharp_vertices.h"

namespace argil::clay {

namespace {
// Weight of the mean beside the tangent planes.
constexpr float kHeld = 0.05f;
// From the mean of the crossings, which lies inside of a bent surface, to where their tangent planes meet, which is as
// far outside: half-way is the surface, and here the triangles between the vertices cut off as much as the vertices
// stand out.
constexpr float kTowardsTip = 0.75f;

// Is a kink in this second difference, and none in the one beside it?
constexpr float kKink = 0.05f, kKinkRatio = 8;
bool kinked(float difference, float other) {
  return std::abs(difference) > kKinkRatio * std::abs(other) + kKink;
}

// Slope at a voxel along a line of them; beside a kink from the smooth side alone.
float slopeAt(const float* f, int step) {
  const float a = f[-2 * step], b = f[-step], c = f[0], d = f[step], e = f[2 * step];
  const float low = a - 2 * b + c, middle = b - 2 * c + d, high = c - 2 * d + e;
  if (!kinked(middle, std::abs(low) < std::abs(high) ? low : high)) return (d - b) * 0.5f;
  return std::abs(low) < std::abs(high) ? (3 * c - 4 * b + a) * 0.5f : (4 * d - 3 * c - e) * 0.5f;
}

// Where the cubic through f's values at −1, 0, 1, 2 is zero between 0 and 1, where its signs differ, and its slope
// there.
struct Zero {
  float at, slope;
};
Zero zeroOf(const float* f, int step) {
  const float b = f[0], c = f[step];
  float low = f[-step] - 2 * b + c, high = b - 2 * c + f[2 * step];
  if (kinked(low, high))
    low = high;
  else if (kinked(high, low))
    high = low;
  Zero zero{b / (b - c), c - b};
  for (int i = 0; i < 3; ++i) {
    const float t = zero.at, bend = (low * (2 - t) + high * (1 + t)) * (1.0f / 6);
    zero.slope = (c - b) + (2 * t - 1) * bend + t * (t - 1) * (high - low) * (1.0f / 6);
    if (std::abs(zero.slope) < 0.05f) break;
    zero.at = std::clamp(t - (b + t * (c - b) + t * (t - 1) * bend) / zero.slope, 0.0f, 1.0f);
  }
  return zero;
}

}  // namespace

Vec3f meetingPoint(std::span<const SurfacePoint> points, const Vec3f& mean) {
  const float held = kHeld * static_cast<float>(points.size());
  float xx = held, yy = held, zz = held, xy = 0, yz = 0, zx = 0;
  Vec3f right = Vec3f::Zero();
  for (const SurfacePoint& p : points) {
    const Vec3f& n = p.normal;
    xx += n.x() * n.x(), yy += n.y() * n.y(), zz += n.z() * n.z();
    xy += n.x() * n.y(), yz += n.y() * n.z(), zx += n.z() * n.x();
    right += n.dot(p.at - mean) * n;
  }
  // Positive definite: `held` is on the diagonal.
  const Vec3f a(xx, xy, zx), b(xy, yy, yz), c(zx, yz, zz);
  const Vec3f bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  return mean + (1 / a.dot(bc)) * (right.x() * bc + right.y() * ca + right.z() * ab);
}

std::optional<SurfacePoint> placeOnBend(const CellView& cell, uint16_t edges) {
  std::array<SurfacePoint, 12> points;
  size_t count = 0;
  Vec3f mean = Vec3f::Zero(), normal = Vec3f::Zero();
  const int steps[3] = {cell.stepX, cell.stepY, 1};
  for (unsigned left = edges; left != 0; left &= left - 1) {
    const CellEdge edge = kCellEdges[static_cast<size_t>(std::countr_zero(left))];
    const float* from =
        cell.phi + (edge.from >> 2) * cell.stepX + ((edge.from >> 1) & 1) * cell.stepY + (edge.from & 1);
    const int step = steps[edge.axis];
    SurfacePoint& p = points[count++];
    const Zero zero = zeroOf(from, step);
    const float t = zero.at;
    p.normal[edge.axis] = zero.slope;
    for (int other = 0; other < 3; ++other)
      if (other != edge.axis)
        p.normal[other] = (1 - t) * slopeAt(from, steps[other]) + t * slopeAt(from + step, steps[other]);
    p.at = Vec3f(static_cast<float>(edge.from >> 2), static_cast<float>((edge.from >> 1) & 1),
                 static_cast<float>(edge.from & 1));
    p.at[edge.axis] += t;
    const float length = std::sqrt(p.normal.squaredNorm());
    if (!(length > 0.1f)) return std::nullopt;
    p.normal *= 1 / length;
    mean += p.at;
    normal += p.normal;
  }
  mean *= 1 / static_cast<float>(count);
  const float length = std::sqrt(normal.squaredNorm());
  if (!(length > 0.1f)) return std::nullopt;
  const Vec3f tip = meetingPoint({points.data(), count}, mean);
  Vec3f at = mean + kTowardsTip * (tip - mean);
  for (int axis = 0; axis < 3; ++axis) at[axis] = std::clamp(at[axis], -kSharpReach, 1 + kSharpReach);
  return SurfacePoint{at, normal * (1 / length)};
}

}  // namespace argil::clay
