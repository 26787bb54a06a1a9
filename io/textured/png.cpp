// PNG (ISO/IEC 15948): signature, IHDR, IDAT, IEND.

#include "io/textured/png.h"

#include <libdeflate.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "clay/base/error.h"

namespace argil::io {

namespace {

constexpr int kLevel = 6;  // of compression
constexpr uint8_t kGrey = 0, kColour = 2;
enum Filter : uint8_t { none, left, up, mean, paeth };

void appendBig(std::vector<std::byte>& out, uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::byte>(value >> shift & 0xff));
}

void appendChunk(std::vector<std::byte>& out, const char* name, std::span<const std::byte> content) {
  appendBig(out, static_cast<uint32_t>(content.size()));
  const size_t begin = out.size();
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(name[i]));
  out.insert(out.end(), content.begin(), content.end());
  appendBig(out, libdeflate_crc32(0, out.data() + begin, out.size() - begin));
}

uint8_t predicted(Filter filter, int a, int b, int c) {  // left, above, above left
  switch (filter) {
    case left:
      return static_cast<uint8_t>(a);
    case up:
      return static_cast<uint8_t>(b);
    case mean:
      return static_cast<uint8_t>((a + b) / 2);
    case paeth: {
      const int p = a + b - c, toA = std::abs(p - a), toB = std::abs(p - b), toC = std::abs(p - c);
      return static_cast<uint8_t>(toA <= toB && toA <= toC ? a : toB <= toC ? b : c);
    }
    default:
      return 0;
  }
}

// Each row by the filter that leaves the smallest numbers, as the standard advises.
std::vector<uint8_t> filtered(const uint8_t* bytes, size_t rows, size_t stride, size_t step) {
  std::vector<uint8_t> out, row(stride), best(stride);
  out.reserve(rows * (stride + 1));
  for (size_t y = 0; y < rows; ++y) {
    const uint8_t *here = bytes + y * stride, *above = y > 0 ? here - stride : nullptr;
    long least = -1;
    Filter chosen = none;
    for (const Filter filter : {none, left, up, mean, paeth}) {
      long sum = 0;
      for (size_t x = 0; x < stride; ++x) {
        const int a = x >= step ? here[x - step] : 0, b = above ? above[x] : 0,
                  c = above && x >= step ? above[x - step] : 0;
        row[x] = static_cast<uint8_t>(here[x] - predicted(filter, a, b, c));
        sum += std::abs(static_cast<int8_t>(row[x]));
      }
      if (least >= 0 && sum >= least) continue;
      least = sum;
      chosen = filter;
      best.swap(row);
    }
    out.push_back(chosen);
    out.insert(out.end(), best.begin(), best.end());
  }
  return out;
}

std::vector<std::byte> pngOf(int width, int height, uint8_t kind, uint8_t bits, const uint8_t* bytes) {
  const size_t step = kind == kColour ? 3 : 2, stride = size_t(width) * step;
  const std::vector<uint8_t> rows = filtered(bytes, size_t(height), stride, step);
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> packer(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (!packer) throw std::bad_alloc();
  std::vector<std::byte> packed(libdeflate_zlib_compress_bound(packer.get(), rows.size()));
  packed.resize(libdeflate_zlib_compress(packer.get(), rows.data(), rows.size(), packed.data(), packed.size()));

  std::vector<std::byte> out;
  for (const int each : {0x89, 'P' + 0, 'N' + 0, 'G' + 0, 13, 10, 26, 10}) out.push_back(static_cast<std::byte>(each));
  std::vector<std::byte> head;
  appendBig(head, static_cast<uint32_t>(width));
  appendBig(head, static_cast<uint32_t>(height));
  for (const uint8_t each : {bits, kind, uint8_t{0}, uint8_t{0}, uint8_t{0}}) head.push_back(std::byte{each});
  appendChunk(out, "IHDR", head);
  appendChunk(out, "IDAT", packed);
  appendChunk(out, "IEND", {});
  return out;
}

}  // namespace

std::vector<std::byte> pngOf(int width, int height, std::span<const uint8_t> rgb) {
  return pngOf(width, height, kColour, 8, rgb.data());
}

std::vector<std::byte> pngOf(int width, int height, std::span<const uint16_t> grey) {
  std::vector<uint8_t> big(2 * grey.size());
  for (size_t i = 0; i < grey.size(); ++i) {
    big[2 * i] = static_cast<uint8_t>(grey[i] >> 8);
    big[2 * i + 1] = static_cast<uint8_t>(grey[i] & 0xff);
  }
  return pngOf(width, height, kGrey, 16, big.data());
}

}  // namespace argil::io
