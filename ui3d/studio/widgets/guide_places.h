#pragma once
// The way that a guide shows, as places.

#include <vector>

#include "engine/document/document.h"

namespace argil::studio {

/// Places along a curve (smooth through its points; the first again at the end of a closed one) or both ends of what is
/// drawn of a line, world mm. Empty for any other guide.
[[nodiscard]] std::vector<Vec3d> placesAlong(const engine::Guide& guide);

}  // namespace argil::studio
