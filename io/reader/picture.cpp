// PNG, JPEG, BMP, TGA and PGM, by stb_image.

#include <algorithm>
#include <array>
#include <climits>
#include <cstdlib>
#include <memory>
#include <string>

#include "clay/base/error.h"
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
using Levels = std::unique_ptr<stbi_us, void (*)(void*)>;

/// What the library says may quote bytes of the file.
[[noreturn]] void damaged() {
  std::string why;
  for (const char* c = stbi_failure_reason(); c != nullptr && *c != '\0' && why.size() < 100; ++c)
    why += *c >= 0x20 && *c < 0x7f ? *c : '?';
  throw Error("the image is damaged: " + (why.empty() ? std::string("it cannot be unpacked") : why));
}

/// `at(i)`: of the pixel i, row by row.
template <class Item, class At>
void sendRows(const wire::Picture& size, wire::Kind kind, Sender& sender, const At& at) {
  std::vector<Item> row(size.width);
  for (size_t first = 0, y = 0; y < size.height; ++y, first += row.size()) {
    for (size_t x = 0; x < row.size(); ++x) row[x] = at(first + x);
    sender.array(kind, std::span<const Item>(row));
  }
}

/// An unpacked picture, its levels as the file has them, 16 bits each.
class Unpacked {
 public:
  Unpacked(std::span<const unsigned char> bytes, int largest) : levels_(nullptr, stbi_image_free) {
    if (bytes.size() > size_t{INT_MAX}) throw Error("larger than 2 GB: no image that can be read");
    const int bytesGiven = int(bytes.size());
    int width = 0, height = 0, channels = 0;
    mostBytes = kForHeaders;
    if (stbi_info_from_memory(bytes.data(), bytesGiven, &width, &height, &channels) == 0)
      throw Error("not an image that can be read; give PNG, JPEG, BMP, TGA or PGM");
    if (width < 1 || height < 1 || width > largest || height > largest)
      throw Error(std::to_string(width) + " by " + std::to_string(height) + " pixels, at most " +
                  std::to_string(largest) + " along an edge are read; make it smaller");
    // Four channels of 16 bits, in blocks that reach over the edges and with room to grow by doubling; a file's packed
    // bytes likewise.
    mostBytes = std::max({kForHeaders, 2 * bytes.size(), size_t(width + 32) * size_t(height + 32) * 16});
    size = {uint32_t(width), uint32_t(height)};
    const bool deep = stbi_is_16_bit_from_memory(bytes.data(), bytesGiven) != 0;
    // Channels as the file has them: where stb_image of Debian 12 makes others, it reads beyond the end of a PPM of 16
    // bits. Of eight bits it makes sixteen by repeating them.
    levels_.reset(stbi_load_16_from_memory(bytes.data(), bytesGiven, &width, &height, &channels, 0));
    if (!levels_) damaged();
    step = size_t(channels);
    // It leaves the levels of PGM and PPM as they stand: high byte first.
    swapped_ = deep && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6');
  }
  [[nodiscard]] uint16_t level(size_t pixel, size_t channel) const {
    const uint16_t value = levels_.get()[pixel * step + channel];
    return swapped_ ? uint16_t(value << 8 | value >> 8) : value;
  }
  /// What comes last of two or four channels is alpha.
  [[nodiscard]] std::array<uint8_t, 4> colour(size_t pixel) const {
    const auto byte = [&](size_t channel) { return uint8_t(level(pixel, channel) >> 8); };
    const bool grey = step < 3, clear = step % 2 == 0;
    return {byte(0), byte(grey ? 0 : 1), byte(grey ? 0 : 2), clear ? byte(step - 1) : uint8_t{255}};
  }

  wire::Picture size{};
  size_t step = 0;  ///< Channels.

 private:
  Levels levels_;
  bool swapped_ = false;
};

}  // namespace

DecodedPicture decodePicture(std::span<const unsigned char> bytes, int largest) {
  const Unpacked picture(bytes, largest);
  DecodedPicture decoded{picture.size.width, picture.size.height, {}};
  decoded.pixels.resize(size_t(decoded.width) * decoded.height);
  for (size_t i = 0; i < decoded.pixels.size(); ++i) decoded.pixels[i] = picture.colour(i);
  return decoded;
}

void readPicture(const std::filesystem::path& file, PictureAs as, int largest, Sender& sender) {
  const std::vector<unsigned char> bytes = contentOf(file);
  const Unpacked picture(bytes, largest);
  sender.named(wire::Kind::picture, picture.size, {});
  if (as == PictureAs::colour) {
    sendRows<std::array<uint8_t, 4>>(picture.size, wire::Kind::pixels, sender,
                                     [&](size_t i) { return picture.colour(i); });
  } else {
    sendRows<float>(picture.size, wire::Kind::levels, sender, [&](size_t i) {
      const auto part = [&](size_t channel) { return float(picture.level(i, channel)); };
      const float brightness =  // Rec. 601 luma.
          picture.step < 3 ? part(0) : 0.299f * part(0) + 0.587f * part(1) + 0.114f * part(2);
      return std::min(brightness / 65535.0f, 1.0f);
    });
  }
}

}  // namespace argil::io::reader
