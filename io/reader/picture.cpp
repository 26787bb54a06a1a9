// PNG, JPEG, BMP, TGA and PGM, by stb_image.

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <memory>
#include <string>

#include "clay/error.h"
#include "io/reader/reader.h"

namespace {

/// A chunk may claim a GiB that it does not have: one piece of memory is at most what the picture, or the file, can
/// need.
thread_local size_t mostBytes = 0;

void* takeMemory(size_t bytes) {
  return bytes <= mostBytes ? std::malloc(bytes) : nullptr;
}
void* takeMore(void* before, size_t bytes) {
  return bytes <= mostBytes ? std::realloc(before, bytes) : nullptr;
}

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

namespace argil::io::reader {

namespace {

constexpr size_t kForHeaders = size_t{1} << 20;

/// A picture in the library's memory.
template <class Item>
using Pixels = std::unique_ptr<Item, void (*)(void*)>;

/// What the library says may quote bytes of the file.
[[noreturn]] void damaged() {
  std::string why;
  for (const char* c = stbi_failure_reason(); c != nullptr && *c != '\0' && why.size() < 100; ++c)
    why += *c >= 0x20 && *c < 0x7f ? *c : '?';
  throw Error("the image is damaged: " + (why.empty() ? std::string("it cannot be unpacked") : why));
}

}  // namespace

void readPicture(const std::filesystem::path& file, PictureAs as, int largest, Sender& sender) {
  const std::vector<unsigned char> bytes = contentOf(file);
  if (bytes.size() > size_t{INT_MAX}) throw Error("larger than 2 GB: no image that can be read");
  const int size = int(bytes.size());
  int width = 0, height = 0, channels = 0;
  mostBytes = kForHeaders;
  if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0)
    throw Error("not an image that can be read; give PNG, JPEG, BMP, TGA or PGM");
  if (width < 1 || height < 1 || width > largest || height > largest)
    throw Error(std::to_string(width) + " by " + std::to_string(height) + " pixels, at most " +
                std::to_string(largest) + " along an edge are read; make it smaller");
  // Four channels of 16 bits, in blocks that reach over the edges and with room to grow by doubling; a file's packed
  // bytes likewise.
  mostBytes = std::max({kForHeaders, 2 * bytes.size(), size_t(width + 32) * size_t(height + 32) * 16});
  const wire::Picture head{uint32_t(width), uint32_t(height)};
  const size_t count = size_t(width) * size_t(height);
  if (as == PictureAs::colour) {
    const Pixels<stbi_uc> pixels(stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4),
                                 stbi_image_free);
    if (!pixels) damaged();
    sender.named(wire::Kind::picture, head, {});
    sender.array(wire::Kind::pixels, std::span<const stbi_uc>(pixels.get(), 4 * count));
    return;
  }
  // Channels as the file has them: where stb_image of Debian 12 makes one of three, it reads beyond the end of a PPM of
  // 16 bits.
  const Pixels<stbi_us> pixels(stbi_load_16_from_memory(bytes.data(), size, &width, &height, &channels, 0),
                               stbi_image_free);
  if (!pixels) damaged();
  sender.named(wire::Kind::picture, head, {});
  const auto step = size_t(channels);
  std::vector<float> row(static_cast<size_t>(width));
  for (size_t first = 0; first < count; first += row.size()) {
    for (size_t i = 0; i < row.size(); ++i) {
      const stbi_us* pixel = pixels.get() + (first + i) * step;
      // Rec. 601 luma; what comes last of two or four is alpha.
      const float level =
          step < 3 ? float(pixel[0]) : 0.299f * float(pixel[0]) + 0.587f * float(pixel[1]) + 0.114f * float(pixel[2]);
      row[i] = std::min(level / 65535.0f, 1.0f);
    }
    sender.array(wire::Kind::levels, std::span<const float>(row));
  }
}

}  // namespace argil::io::reader
