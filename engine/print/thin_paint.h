#pragma once
// Walls that are too thin and gaps that are too narrow, as colours of the surface while the clay is worked on.

#include <optional>
#include <unordered_set>

#include "clay/store/brick_set.h"
#include "clay/surface/surface.h"
#include "clay/surface/wall_map.h"

namespace argil::engine {

/// What is coloured, mm; 0: not looked for.
struct ThinLimits {
  double wallMm = 0, gapMm = 0;
  friend bool operator==(const ThinLimits&, const ThinLimits&) = default;
};

/// Colours over those of the clay: walls red where there is nothing left to yellow at the limit, gaps violet to light
/// blue. Follows one surface; one thread. Limits of more than 256 voxels are looked for up to that.
class ThinPaint {
 public:
  explicit ThinPaint(const ThinLimits& limits) : limits_(limits) {}
  /// After `surface` changed by `delta`, from all of it on: measures what that may have changed, and adds to
  /// delta.painted each brick that shows or showed something thin. Cost: WallMap::follow().
  void follow(const clay::Surface& surface, clay::SurfaceDelta& delta, int threads);

 private:
  ThinLimits limits_;
  std::optional<clay::WallMap> map_;
  float wall_ = 0, gap_ = 0;  // voxels
  std::unordered_set<Coord, clay::CoordHash> shown_;
};

}  // namespace argil::engine
