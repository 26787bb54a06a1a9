#include "clay/surface/bent_vertex.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "clay/kernels/bend_kernels.h"
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
// The sum of its normals is longer where a surface is not folded in the cell.
constexpr float kLeastNormal = 0.1f;

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
  EdgeCrossings crossings;
  if (!crossEdges(cell.phi, cell.stepX, cell.stepY, edges, crossings)) return std::nullopt;
  std::array<SurfacePoint, EdgeCrossings::kMost> points;
  size_t count = 0;
  Vec3f mean = Vec3f::Zero(), normal = Vec3f::Zero();
  for (unsigned left = edges; left != 0; left &= left - 1, ++count) {
    const CellEdge edge = kCellEdges[static_cast<size_t>(std::countr_zero(left))];
    SurfacePoint& p = points[count];
    p.at = Vec3f(static_cast<float>(edge.from >> 2), static_cast<float>((edge.from >> 1) & 1),
                 static_cast<float>(edge.from & 1));
    p.at[edge.axis] += crossings.along[count];
    for (int k = 0; k < 3; ++k) p.normal[(edge.axis + k) % 3] = crossings.normal[k][count];
    mean += p.at;
    normal += p.normal;
  }
  mean *= 1 / static_cast<float>(count);
  const float length = std::sqrt(normal.squaredNorm());
  if (!(length > kLeastNormal)) return std::nullopt;
  const Vec3f tip = meetingPoint({points.data(), count}, mean);
  Vec3f at = mean + kTowardsTip * (tip - mean);
  for (int axis = 0; axis < 3; ++axis) at[axis] = std::clamp(at[axis], -kSharpReach, 1 + kSharpReach);
  return SurfacePoint{at, normal * (1 / length)};
}

}  // namespace argil::clay
