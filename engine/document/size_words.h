#pragma once
// Sizes and counts in words.

#include <string>

#include "clay/base/vec.h"

namespace argil::engine {

/// "120 × 80 × 200 mm".
[[nodiscard]] std::string sizeWords(const Vec3d& sizeMm);
/// "8.1 M", "412 k", "17".
[[nodiscard]] std::string counted(double count);

}  // namespace argil::engine
