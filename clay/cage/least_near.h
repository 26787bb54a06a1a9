#pragma once
// The least of what vertices have, near each of them.

#include <cstddef>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// At each place no more than the least value of those within `reach`, above 0, along each axis, and no less than that
/// of those within twice as much. O(n) for places on a surface.
[[nodiscard]] std::vector<float> leastNear(const std::vector<Vec3d>& places, const std::vector<float>& values,
                                           double reach);

}  // namespace argil::clay
