#pragma once
// The size of a thing in words.

#include <string>

#include "clay/base/vec.h"

namespace argil::engine {

/// "120 × 80 × 200 mm".
[[nodiscard]] std::string sizeWords(const Vec3d& sizeMm);

}  // namespace argil::engine
