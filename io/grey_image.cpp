#include "io/grey_image.h"

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <memory>
#include <string>

#include "io/input.h"

namespace {

/// A chunk may claim a GiB that it does not have: one piece of memory is at most what the picture, or the file, can need.
thread_local size_t mostBytes = 0;

void* takeMemory(size_t bytes) { return bytes <= mostBytes ? std::malloc(bytes) : nullptr; }
void* takeMore(void* before, size_t bytes) { return bytes <= mostBytes ? std::realloc(before, bytes) : nullptr; }

}  // namespace

#define STBI_MALLOC(bytes) takeMemory(bytes)
#define STBI_REALLOC(before, bytes) takeMore(before, bytes)
#define STBI_FREE(memory) std::free(memory)
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
  constexpr size_t kForHeaders = size_t{1} << 20;
  mostBytes = kForHeaders;
  if (!stbi_info_from_memory(data, size, &image.width, &image.height, &channels))
    fail(name, "not an image that can be read; give PNG, JPEG, BMP, TGA or PGM");
  if (image.width < 1 || image.height < 1 || image.width > largest || image.height > largest)
    fail(name, std::to_string(image.width) + " by " + std::to_string(image.height) + " pixels, at most " + std::to_string(largest) +
                   " along an edge are read; make it smaller");
  // Four channels of 16 bits, in blocks that reach over the edges and with room to grow by doubling; a file's packed bytes likewise.
  mostBytes = std::max({kForHeaders, 2 * bytes.size, size_t(image.width + 32) * size_t(image.height + 32) * 16});
  // Channels as the file has them: where stb_image of Debian 12 makes one of three, it reads beyond the end of a PPM of 16 bits.
  const std::unique_ptr<stbi_us, void (*)(void*)> pixels(stbi_load_16_from_memory(data, size, &image.width, &image.height, &channels, 0),
                                                         stbi_image_free);
  // The reason may quote bytes of the file.
  if (!pixels) fail(name, "the image is damaged: " + cleanName(stbi_failure_reason()));
  image.grey.resize(size_t(image.width) * size_t(image.height));
  const size_t step = size_t(channels);
  for (size_t i = 0; i < image.grey.size(); ++i) {
    const stbi_us* pixel = pixels.get() + i * step;
    // Rec. 601 luma; what comes last of two or four is alpha.
    const float level = step < 3 ? float(pixel[0]) : 0.299f * float(pixel[0]) + 0.587f * float(pixel[1]) + 0.114f * float(pixel[2]);
    image.grey[i] = std::min(level / 65535.0f, 1.0f);
  }
  return image;
}

}  // namespace argil::io
