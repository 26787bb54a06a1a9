#pragma once
// Where the two faces that meet in a cell cross: the live grade's quick step, for creases between curved faces too.

#include "clay/kernels/crease_kernels.h"
#include "clay/surface/crease_vertex.h"

namespace argil::clay {

/// How far a vertex may lie outside of its cell, in voxels along an axis.
inline constexpr float kCrispReach = 0.5f;
/// The vertex of a cell from the planes around it, which have been rated: on the crease where edges of the cell cross
/// both faces, else on the face that they cross. Where a third face is near and two do not explain the cell, as
/// placeAtCrease. `none` where there are no four planes, and `least` for each face, where two faces are not told apart,
/// or where the cell's own values contradict them: on the side where faces that meet are exact, these may be up to
/// `deeper` voxels farther from the surface in the mean. On a rounding they are more. Feet are in voxels from
/// `cell.low`; `cell.planes` is not looked at. O(planes).
[[nodiscard]] CreaseVertex placeCrisply(const CreaseCell& cell, NearPlanes& planes, float deeper, int least) noexcept;

}  // namespace argil::clay
