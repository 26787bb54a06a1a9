#pragma once
// Which points of a surface lie opposite to one of its points.

#include <cstddef>
#include <cstdint>
#include <limits>

namespace argil::clay {

/// Points of a surface with their normals: six rows of floats, x, y, z and the normal's, `stride` apart; eight floats
/// behind the last of a row can be read.
struct SurfacePoints {
  const float* rows = nullptr;
  size_t stride = 0;
  uint32_t count = 0;
};

/// Twice the radius of the smallest ball that touches the surface in a point and goes through another one, opposite to
/// it: in the clay and in the air; and which one that is. Infinity where there is none.
struct Opposite {
  float wall = std::numeric_limits<float>::infinity(), gap = wall;
  uint32_t wallAt = 0, gapAt = 0;
};

/// Cosine of the angle between the normals of two sides of a wall or a gap, from which on they are opposite: over 120°.
inline constexpr float kOppositeCosine = -0.5f;

/// Of `points` beside the point `p` with the normal `n`, both of three floats: makes those in `found` smaller where
/// there is a smaller one, and tells by bit 0 (wall) and bit 1 (gap) whether it did. Of several that are equal the
/// first. The same bits on every CPU.
int findOpposite(const SurfacePoints& points, const float* p, const float* n, Opposite& found) noexcept;

}  // namespace argil::clay
