#pragma once
// Pictures as PNG files, in memory.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace argil::io {

/// Three bytes a pixel, sRGB or plain numbers; rows from the top, none padded. As many as width × height. The same
/// bytes everywhere.
[[nodiscard]] std::vector<std::byte> pngOf(int width, int height, std::span<const uint8_t> rgb);
/// One number a pixel, of all 16 bits.
[[nodiscard]] std::vector<std::byte> pngOf(int width, int height, std::span<const uint16_t> grey);

}  // namespace argil::io
