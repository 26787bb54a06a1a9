#include "io/grey_image.h"

#include <climits>
#include <memory>
#include <string>

#include "io/input.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_GIF
#define STBI_NO_HDR
#define STBI_NO_PSD
#define STBI_NO_PIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace argil::io {

GreyImage readGreyImage(const std::filesystem::path& file, int largest) {
  const FileBytes bytes = readFile(file);
  const std::string name = displayName(file);
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data.get());
  if (bytes.size > size_t{INT_MAX}) fail(name, "larger than 2 GB: no image that can be read");
  const int size = static_cast<int>(bytes.size);
  GreyImage image;
  int channels = 0;
  if (!stbi_info_from_memory(data, size, &image.width, &image.height, &channels))
    fail(name, "not an image that can be read; give PNG, JPEG, BMP, TGA or PGM");
  if (image.width < 1 || image.height < 1 || image.width > largest || image.height > largest)
    fail(name, std::to_string(image.width) + " by " + std::to_string(image.height) + " pixels, at most " + std::to_string(largest) +
                   " along an edge are read; make it smaller");
  const std::unique_ptr<stbi_us, void (*)(void*)> pixels(stbi_load_16_from_memory(data, size, &image.width, &image.height, &channels, 1),
                                                         stbi_image_free);
  // The reason may quote bytes of the file.
  if (!pixels) fail(name, "the image is damaged: " + cleanName(stbi_failure_reason()));
  image.grey.resize(size_t(image.width) * size_t(image.height));
  for (size_t i = 0; i < image.grey.size(); ++i) image.grey[i] = float(pixels.get()[i]) / 65535.0f;
  return image;
}

}  // namespace argil::io
