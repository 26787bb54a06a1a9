#pragma once
// Limits that are printed: a bound must not become less by rounding.

#include <cmath>

namespace argil::clay {

/// Returns `value` with so many significant digits, away from zero where it has more: "at most 0.063" holds for 0.0621.
/// Zero and what is not finite come back as they are.
[[nodiscard]] inline double roundedUp(double value, int digits = 2) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) + 1 - digits);
  constexpr double kSame = 1e-9;  // of the last digit: what arithmetic adds to a value that has no more digits
  return std::copysign(std::ceil(std::abs(value) / unit - kSame) * unit, value);
}

}  // namespace argil::clay
