#pragma once
// Shapes side by side in a square.

#include <cstdint>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/unwrap/flatten.h"

namespace argil::clay {

/// Triangles on the flat, mm.
struct FlatShape {
  const std::vector<Vec2d>* places = nullptr;
  const std::vector<std::array<uint32_t, 3>>* triangles = nullptr;
};

struct Packing {
  /// Of each shape: turned by `turn` radians, then moved, then divided by `sideMm`: inside the square from 0 to 1.
  struct Placed {
    double turn = 0;
    Vec2d moveMm = Vec2d::Zero();
  };
  std::vector<Placed> placed;
  double sideMm = 1;
  double covered = 0;  ///< Of the square, by the shapes.
};

/// All shapes in one scale, as large as they come, none mirrored, none nearer to another than `margin` of the square's
/// side, nor to its rim than half of that. Looked at in 512 × 512 cells, of which a margin is at least one. Throws
/// Error without an area, or where so many do not go in at all; Cancelled. Cost: one to three seconds for 15 shapes.
/// The same on all machines and on any number of threads.
[[nodiscard]] Packing packed(const std::vector<FlatShape>& shapes, double margin, int threads, const WorkPart& part);

}  // namespace argil::clay
