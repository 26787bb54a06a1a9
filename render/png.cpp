#include "render/png.h"

#include <stb_image.h>

#include <limits>
#include <memory>

#include "clay/error.h"

namespace argil::render {

Image decodePng(std::span<const std::byte> bytes, int mostEdge) {
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  Image image;
  int channels = 0;
  if (bytes.size() > size_t(std::numeric_limits<int>::max()) || !stbi_info_from_memory(data, int(bytes.size()), &image.width, &image.height, &channels))
    throw Error("the picture is no PNG");
  if (image.width > mostEdge || image.height > mostEdge) throw Error("the picture is too large");
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(stbi_load_from_memory(data, int(bytes.size()), &image.width, &image.height, &channels, 4),
                                                         stbi_image_free);
  if (!pixels) throw Error("the picture is damaged");
  image.rgba.assign(pixels.get(), pixels.get() + 4 * size_t(image.width) * size_t(image.height));
  return image;
}

}  // namespace argil::render
