#pragma once

#include <cstdint>

namespace argil::render {

/// Colour as people name it: sRGB, 0 to 1; alpha 1 is opaque.
struct Colour {
  float r = 1, g = 1, b = 1, a = 1;
  friend bool operator==(const Colour&, const Colour&) = default;
};

}  // namespace argil::render
