#pragma once
// A cell whose surface is bent but has no crease: its vertex from where and how the surface crosses its edges.

#include <cstdint>
#include <optional>
#include <span>

#include "clay/base/vec.h"
#include "clay/surface/crease_path.h"

namespace argil::clay {

/// A point of the surface and its unit normal there.
struct SurfacePoint {
  Vec3f at;
  Vec3f normal;
};

/// The point nearest to their tangent planes in the sense of least squares, held weakly at the mean of the points: the
/// tip where they turn, beside the mean where they do not. O(points).
[[nodiscard]] Vec3f meetingPoint(std::span<const SurfacePoint> points, const Vec3f& mean);

/// The vertex of one loop of a cell, `edges` its crossed edges, in coordinates from the cell's lowest corner; in the
/// cell or beside it. Nothing where the field has hardly a slope.
[[nodiscard]] std::optional<SurfacePoint> placeOnBend(const CellView& cell, uint16_t edges);

}  // namespace argil::clay
