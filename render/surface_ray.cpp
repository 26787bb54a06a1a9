#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "render/surface_layout.h"

namespace argil::render {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Where a ray enters a box, at or after its origin; kNever when it misses.
double enterBox(const Vec3d& origin, const Vec3d& direction, const Vec3d& min, const Vec3d& max) {
  double first = 0, last = kNever;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin[axis] < min[axis] || origin[axis] > max[axis]) return kNever;
      continue;
    }
    const double a = (min[axis] - origin[axis]) / direction[axis], b = (max[axis] - origin[axis]) / direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last ? first : kNever;
}

/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both sides.
double hitTriangle(const Vec3d& origin, const Vec3d& direction, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0) return kNever;
  const Vec3d s = origin - a;
  const double u = s.dot(p) / determinant;
  const Vec3d q = s.cross(ab);
  const double v = direction.dot(q) / determinant, t = ac.dot(q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t >= 0 ? t : kNever;
}

}  // namespace

std::optional<SurfaceLayout::Hit> SurfaceLayout::raycast(const Vec3d& originMm, const Vec3d& direction) const {
  const Vec3d origin = grid_.toVoxel(originMm);
  double nearest = kNever;
  bool fromOutside = true;
  for (const ChunkDraw& draw : draws_) {
    if (enterBox(origin, direction, draw.min, draw.max) >= nearest) continue;
    for (const Coord coord : chunks_.at(draw.firstVoxel >> (kChunkBits + clay::kBrickBits)).bricks) {
      const Vec3d base = (coord * clay::kBrickEdge).toVec3d();
      if (enterBox(origin, direction, base - Vec3d::Ones(), base + Vec3d::Constant(clay::kBrickEdge)) >= nearest)
        continue;
      const auto corner = [&](clay::VertexRef ref) -> Vec3d {
        const int n = ref >> clay::kVertexRefBits;
        const Coord owner = coord - Coord{n & 1, (n >> 1) & 1, n >> 2};
        return (owner * clay::kBrickEdge).toVec3d() +
               bricks_.at(owner).mesh->positions[ref & clay::kVertexRefIndex].cast<double>();
      };
      for (const auto& quad : bricks_.at(coord).mesh->quads) {
        const Vec3d a = corner(quad[0]), b = corner(quad[1]), c = corner(quad[2]), d = corner(quad[3]);
        for (const auto& [p, q, r] : {std::tie(a, b, c), std::tie(a, c, d)}) {
          const double t = hitTriangle(origin, direction, p, q, r);
          if (t >= nearest) continue;
          nearest = t;
          fromOutside = (q - p).cross(r - p).dot(direction) < 0;
        }
      }
    }
  }
  if (nearest == kNever) return std::nullopt;
  return Hit{nearest * grid_.voxelMm, fromOutside};
}

}  // namespace argil::render
