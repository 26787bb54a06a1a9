#pragma once
// What the hand holds.

#include "clay/brush.h"

namespace argil::engine {

/// A ball that works on clay. The same for a whole stroke.
struct Tool {
  clay::Operation operation = clay::Operation::carve;
  double radiusMm = 5;  ///< 0.5 to 4096 voxels of the clay that it is used on.
  float strength = 1;   ///< Smooth only: 0 to 1.

  friend bool operator==(const Tool&, const Tool&) = default;
};

}  // namespace argil::engine
