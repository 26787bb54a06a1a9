#pragma once
// The least of what vertices have, near each of them.

#include <cstddef>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// For each place a value that is at most the least one of the places within `reach` (above 0) of it along each axis,
/// and at least that of those within twice as much. One value a place. O(n log n) for places on a surface.
[[nodiscard]] std::vector<float> leastNear(const std::vector<Vec3d>& places, const std::vector<float>& values,
                                           double reach);

}  // namespace argil::clay
