#include "ui3d/studio/view/icon.h"

#include <algorithm>
#include <cmath>

#include "clay/base/vec.h"

namespace argil::studio {

render::Image icon(int pixels) {
  pixels = std::clamp(pixels, 16, 512);
  render::Image image;
  image.width = image.height = pixels;
  image.rgba.resize(4 * size_t(pixels) * size_t(pixels));
  const Vec3d light = Vec3d(-0.5, 0.6, 0.62).normalized();
  for (int row = 0; row < pixels; ++row) {
    for (int column = 0; column < pixels; ++column) {
      // The ball fills the square but for a pixel; its edge is softened over one.
      const double x = (2 * (column + 0.5) / pixels - 1) * 1.04, y = (1 - 2 * (row + 0.5) / pixels) * 1.04,
                   r = std::hypot(x, y);
      const double cover = std::clamp((1 - r) * pixels / 2 + 0.5, 0.0, 1.0);
      Vec3d normal(x, y, std::sqrt(std::max(0.0, 1 - r * r)));
      const double across = y - 0.35 * x - 0.12, groove = std::exp(-across * across / 0.018);
      normal = (normal + Vec3d(0, 1.1 * across / 0.134 * groove, 0)).normalized();
      const double shade = 0.28 + 0.75 * std::max(0.0, normal.dot(light)) - 0.12 * groove;
      uint8_t* p = &image.rgba[4 * (size_t(row) * size_t(pixels) + size_t(column))];
      const double colour[] = {214, 128, 92};
      for (int i = 0; i < 3; ++i) p[i] = uint8_t(std::clamp(colour[i] * shade, 0.0, 255.0));
      p[3] = uint8_t(std::lround(255 * cover));
    }
  }
  return image;
}

}  // namespace argil::studio
