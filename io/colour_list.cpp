#include "io/colour_list.h"

#include <algorithm>
#include <cmath>

namespace argil::io {

namespace {

constexpr float kNone = -1;  ///< In place of red: no colour was given.

}  // namespace

void ColourList::add(size_t index, std::span<const double> numbers) {
  colours_.resize(index, {kNone, 0, 0, 0});
  std::array<float, 4>& colour = colours_.emplace_back(std::array<float, 4>{0, 0, 0, kNone});
  for (size_t i = 0; i < std::min<size_t>(numbers.size(), 4); ++i) {
    const double part = std::isfinite(numbers[i]) ? std::clamp(numbers[i], 0.0, 255.0) : 0.0;
    largest_ = std::max(largest_, part);
    colour[i] = static_cast<float>(part);
  }
}

std::vector<Colour> ColourList::take(size_t count) {
  std::vector<Colour> result;
  if (!colours_.empty()) {
    const float scale = largest_ > 1 ? 1.0f : 255.0f;
    const auto part = [scale](float number) { return static_cast<uint8_t>(number * scale + 0.5f); };
    result.resize(count);
    for (size_t i = 0; i < std::min(count, colours_.size()); ++i) {
      const auto& [red, green, blue, alpha] = colours_[i];
      if (red != kNone) result[i] = {part(red), part(green), part(blue), alpha == kNone ? uint8_t{255} : part(alpha)};
    }
  }
  *this = {};
  return result;
}

}  // namespace argil::io
