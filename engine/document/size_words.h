#pragma once
// Sizes and counts in words.

#include <string>

#include "clay/base/vec.h"

namespace argil::engine {

/// "120 × 80 × 200 mm".
[[nodiscard]] std::string sizeWords(const Vec3d& sizeMm);
/// The digits that matter and all before the point, never an exponent: "1062", "12.3", "0.00123".
[[nodiscard]] std::string figure(double value, int digits = 3);
/// "8.1 M", "412 k", "17".
[[nodiscard]] std::string counted(double count);

}  // namespace argil::engine
