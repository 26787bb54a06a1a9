#pragma once
// Letters made of strokes: as many as the picture's labels need.

#include <string_view>
#include <vector>

namespace argil::render {

struct Stroke2 {
  float ax, ay, bx, by;
};

/// Strokes of a line of UTF-8 text whose capitals are `height` high, top left corner at (x, y), y down. Knows digits,
/// space, '.', '-' and the letters of "mm", "µm" and "grid"; other characters leave a gap.
[[nodiscard]] std::vector<Stroke2> letter(std::string_view text, float x, float y, float height);
/// Width of the same text.
[[nodiscard]] float letterWidth(std::string_view text, float height);

}  // namespace argil::render
