#pragma once
// Which bricks an application has to look at. This module's own.

#include <span>
#include <vector>

#include "clay/brush/brush_method.h"
#include "clay/store/editor.h"

namespace argil::clay {

/// Bricks within reach of the images that hold some surface, and those beside them that some may come to by
/// applications that move clay by `moved` voxels altogether (DistanceMethod::travel). Of a method that makes clay
/// everywhere all within reach but `goal` tiles. Sorted.
[[nodiscard]] std::vector<Coord> reachedBricks(const Editor& editor, const DistanceMethod& method,
                                               std::span<const Stamp> images, double moved, Tile goal);

}  // namespace argil::clay
