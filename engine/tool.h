#pragma once
// What the hand holds.

#include "clay/brush.h"

namespace argil::engine {

/// Radius of a tool in voxels of the clay that it is used on.
inline constexpr double kLeastToolVoxels = 0.5, kMostToolVoxels = 4096;

/// A ball that works on clay. The same for a whole stroke.
struct Tool {
  clay::Operation operation = clay::Operation::carve;
  double radiusMm = 5;  ///< kLeastToolVoxels to kMostToolVoxels.
  float strength = 1;   ///< Smooth only: 0 to 1.

  friend bool operator==(const Tool&, const Tool&) = default;
};

}  // namespace argil::engine
