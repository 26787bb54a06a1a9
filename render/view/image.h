#pragma once
// A picture in memory and on disk.

#include <cstdint>
#include <string>
#include <vector>

namespace argil::render {

/// RGBA, 8 bits a channel, sRGB, top row first, no padding.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;

  [[nodiscard]] const uint8_t* pixel(int x, int y) const { return &rgba[4 * (size_t(y) * size_t(width) + size_t(x))]; }
  friend bool operator==(const Image&, const Image&) = default;
};

/// The bytes of a PNG file. Throws Error (work) for an image without pixels.
[[nodiscard]] std::vector<uint8_t> encodePng(const Image& image);

/// Writes a PNG to a temporary file beside `path`, flushes it and renames it, so that `path` is either the old file or
/// the whole new one. Throws Error naming the path.
void writePng(const Image& image, const std::string& path);

}  // namespace argil::render
