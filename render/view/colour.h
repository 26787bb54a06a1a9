#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace argil::render {

/// Colour as people name it: sRGB, 0 to 1; alpha 1 is opaque.
struct Colour {
  float r = 1, g = 1, b = 1, a = 1;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// sRGB bytes of a piece's materials (clay::Channel::material 1, 2, ...); nothing, or a row that is not there: the
/// piece's own colour.
using MaterialColours = std::vector<std::optional<std::array<uint8_t, 3>>>;

}  // namespace argil::render
