#pragma once
// Where the two faces that meet in a cell cross: the live grade's quick step, for creases between curved faces too.

#include "clay/surface/crease_vertex.h"

namespace argil::clay {

/// How far a vertex may lie outside of its cell, in voxels along an axis.
inline constexpr float kCrispReach = 0.5f;
/// Cells up to two away along each axis have a plane each at most.
inline constexpr size_t kMostCrispPlanes = 125;

/// The vertex of a cell whose field has a kink, from the planes around it: on the crease where edges of the cell cross
/// both faces, else on the face that they cross. Where a third face is near and two do not explain the cell, as
/// placeAtCrease. `none` where two faces are not told apart or the cell's own values contradict them. O(planes).
[[nodiscard]] CreaseVertex placeCrisply(const CreaseCell& cell) noexcept;

}  // namespace argil::clay
