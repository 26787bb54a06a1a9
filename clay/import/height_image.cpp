#include "clay/import/height_image.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::clay {

namespace {
constexpr int kMostPixels = 16384;  // along a side
}

HeightImage::HeightImage(int width, int height, size_t count) {
  if (width < 1 || height < 1 || width > kMostPixels || height > kMostPixels)
    throw Error(fmt::format("a height image of {} × {} pixels: give one of 1 to {} along each side", width, height,
                            kMostPixels));
  if (count != static_cast<size_t>(width) * static_cast<size_t>(height))
    throw Error(
        fmt::format("a height image of {} × {} pixels with {} values: give one for each pixel", width, height, count));
  levels_.push_back({width, height, std::vector<float>(count)});
}

HeightImage::HeightImage(int width, int height, std::span<const uint8_t> grey)
    : HeightImage(width, height, grey.size()) {
  std::transform(grey.begin(), grey.end(), levels_[0].grey.begin(),
                 [](uint8_t v) { return static_cast<float>(v) / 255.0f; });
  addCoarser();
}

HeightImage::HeightImage(int width, int height, std::span<const uint16_t> grey)
    : HeightImage(width, height, grey.size()) {
  std::transform(grey.begin(), grey.end(), levels_[0].grey.begin(),
                 [](uint16_t v) { return static_cast<float>(v) / 65535.0f; });
  addCoarser();
}

// Means of two by two; where a side is odd its last row or column counts twice.
void HeightImage::addCoarser() {
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    coarse.grey.reserve(static_cast<size_t>(coarse.width) * static_cast<size_t>(coarse.height));
    const auto value = [&](int x, int y) {
      return fine.grey[static_cast<size_t>(std::min(y, fine.height - 1)) * static_cast<size_t>(fine.width) +
                       static_cast<size_t>(std::min(x, fine.width - 1))];
    };
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        coarse.grey.push_back(((value(2 * x, 2 * y) + value(2 * x + 1, 2 * y)) +
                               (value(2 * x, 2 * y + 1) + value(2 * x + 1, 2 * y + 1))) *
                              0.25f);
    levels_.push_back(std::move(coarse));
  }
}

int HeightImage::levelFor(float pixels) const {
  int level = 0;
  while (level + 1 < static_cast<int>(levels_.size()) && static_cast<float>(1 << level) < pixels) ++level;
  return level;
}

float HeightImage::at(float x, float y, int level) const {
  const Level& of = levels_[static_cast<size_t>(level)];
  // In pixels of the image's own, then of the copy: its odd last pixel reaches beyond the image.
  const float half = 0.5f * static_cast<float>(std::max(width(), height())),
              scale = 1.0f / static_cast<float>(1 << level);
  const float px = x * half + 0.5f * static_cast<float>(width()), py = 0.5f * static_cast<float>(height()) - y * half;
  if (!(px >= 0 && py >= 0 && px <= static_cast<float>(width()) && py <= static_cast<float>(height()))) return 0;
  const float cx = std::min(std::max(px * scale - 0.5f, 0.0f), static_cast<float>(of.width - 1));
  const float cy = std::min(std::max(py * scale - 0.5f, 0.0f), static_cast<float>(of.height - 1));
  const int x0 = static_cast<int>(cx), y0 = static_cast<int>(cy);
  const int x1 = std::min(x0 + 1, of.width - 1), y1 = std::min(y0 + 1, of.height - 1);
  const float fx = cx - static_cast<float>(x0), fy = cy - static_cast<float>(y0);
  const auto pixel = [&](int i, int j) {
    return of.grey[static_cast<size_t>(j) * static_cast<size_t>(of.width) + static_cast<size_t>(i)];
  };
  const float top = pixel(x0, y0) * (1 - fx) + pixel(x1, y0) * fx,
              bottom = pixel(x0, y1) * (1 - fx) + pixel(x1, y1) * fx;
  return top * (1 - fy) + bottom * fy;
}

}  // namespace argil::clay
