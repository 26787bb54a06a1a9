#pragma once
// A grey image as heights, for embossing.

#include <cstdint>
#include <span>
#include <vector>

namespace argil::clay {

/// Heights from 0 (black) to 1 (white), in ever coarser copies, so that a place may be asked for as wide as a voxel
/// sees it. Never changes.
class HeightImage {
 public:
  /// Rows from the top, `width · height` values each. Throws Error for sides outside of 1 to 16384 or another count of
  /// values.
  HeightImage(int width, int height, std::span<const uint8_t> grey);
  HeightImage(int width, int height, std::span<const uint16_t> grey);

  [[nodiscard]] int width() const { return levels_[0].width; }
  [[nodiscard]] int height() const { return levels_[0].height; }

  /// The first copy whose pixels are at least `pixels` of the image's own across; 0 is the image.
  [[nodiscard]] int levelFor(float pixels) const;
  /// Bilinear, x and y from −1 to 1 over the longer side, x to the right, y up, the middle of the image at 0, 0; 0
  /// beyond its edges.
  [[nodiscard]] float at(float x, float y, int level) const;

 private:
  struct Level {
    int width, height;
    std::vector<float> grey;
  };
  HeightImage(int width, int height, size_t count);
  void addCoarser();

  std::vector<Level> levels_;
};

}  // namespace argil::clay
