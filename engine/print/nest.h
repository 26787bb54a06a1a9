#pragma once
// Pieces side by side on beds, close together.

#include <span>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/vec.h"
#include "clay/base/work_part.h"

namespace argil::engine {

using Vec2d = Eigen::Vector2d;

struct NestOptions {
  Vec2d bedMm{250, 210};  ///< 1 mm and more.
  double gapMm = 3;       ///< From one piece to the next, 0 and more.
  int turns = 8;          ///< So many ways to turn each, evenly: 1 to 64.
  double cellMm = 0.5;    ///< Of the raster that shapes are laid on: what places of a footprint stand apart, or more.
};

/// What becomes of a footprint: turned about zero by so many radians, moved, and on which bed it is.
struct Nested {
  double turn = 0;
  Vec2d moveMm = Vec2d::Zero();  ///< With the bed's corner at zero, whatever the bed.
  int bed = 0;
};

/// A footprint has no place on a bed, however it is turned.
class LargerThanBed : public Error {
 public:
  explicit LargerThanBed(size_t number) : Error("a piece is larger than the bed"), which(number) {}
  size_t which;
};

/// Footprints are places of a surface, seen from above, no farther apart than a cell. One after the other, the largest
/// first, each where its upper edge lies lowest and then farthest to the left, of all places of a raster and all turns;
/// a bed more where none is left. Shapes lie in each other's hollows and holes. Gaps are exact but for a cell. Throws
/// Error for what is out of range, LargerThanBed, Cancelled. Cost: about
/// half a second for sixty footprints of 40 mm.
[[nodiscard]] std::vector<Nested> nest(std::span<const std::vector<Vec2d>> footprints, const NestOptions& options,
                                       const clay::WorkPart& part);

}  // namespace argil::engine
