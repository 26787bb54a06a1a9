#include "io/brick_codec.h"

#include <zstd.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>

namespace argil::io {

namespace {

constexpr size_t kCoordBytes = 12;
constexpr size_t kRawBytes = sizeof(clay::Brick::phi);
constexpr int kZstdLevel = 1;

// Order of magnitude of the bits of a float in one integer: neighbours in value are neighbours in number.
uint32_t ordered(uint32_t bits) { return bits ^ ((bits >> 31) != 0 ? 0xffffffffu : 0x80000000u); }
uint32_t unordered(uint32_t order) { return order ^ ((order >> 31) != 0 ? 0x80000000u : 0xffffffffu); }
uint32_t zigzag(uint32_t step) { return (step << 1) ^ (0u - (step >> 31)); }
uint32_t unzigzag(uint32_t code) { return (code >> 1) ^ (0u - (code & 1)); }

using Planes = std::array<unsigned char, kRawBytes>;

void split(const float* phi, Planes& planes) {
  uint32_t before = ordered(0);
  for (size_t i = 0; i < clay::kBrickVoxels; ++i) {
    const uint32_t value = ordered(std::bit_cast<uint32_t>(phi[i]));
    const uint32_t code = zigzag(value - before);
    before = value;
    for (size_t plane = 0; plane < 4; ++plane) planes[plane * clay::kBrickVoxels + i] = static_cast<unsigned char>(code >> (8 * plane));
  }
}

void join(const Planes& planes, float* phi) {
  uint32_t before = ordered(0);
  for (size_t i = 0; i < clay::kBrickVoxels; ++i) {
    uint32_t code = 0;
    for (size_t plane = 0; plane < 4; ++plane) code |= static_cast<uint32_t>(planes[plane * clay::kBrickVoxels + i]) << (8 * plane);
    before += unzigzag(code);
    phi[i] = std::bit_cast<float>(unordered(before));
  }
}

// Fills `inside`; false for what no version holds.
bool settle(clay::Brick& brick, float band) {
  const uint32_t bandBits = std::bit_cast<uint32_t>(band);
  uint32_t bad = 0, inBand = 0;
  for (size_t x = 0; x < clay::kBrickEdge; ++x) {
    uint64_t word = 0;
    for (size_t i = 0; i < 64; ++i) {
      const uint32_t bits = std::bit_cast<uint32_t>(brick.phi[x * 64 + i]);
      const uint32_t size = bits & 0x7fffffffu;  // as a number in the order of the absolute values; NaN is above all
      bad |= static_cast<uint32_t>(size > bandBits) | static_cast<uint32_t>(bits == 0x80000000u);
      inBand |= static_cast<uint32_t>(size < bandBits);
      word |= static_cast<uint64_t>(bits >> 31) << i;
    }
    brick.inside[x] = word;
  }
  return bad == 0 && inBand != 0;
}

}  // namespace

struct BrickCodec::State {
  ZSTD_CCtx* packer = ZSTD_createCCtx();
  ZSTD_DCtx* unpacker = ZSTD_createDCtx();
  Planes planes;
  State() {
    if (packer == nullptr || unpacker == nullptr) throw std::bad_alloc();
  }
  ~State() {
    ZSTD_freeCCtx(packer);
    ZSTD_freeDCtx(unpacker);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

BrickCodec::BrickCodec() : state_(std::make_unique<State>()) {}
BrickCodec::~BrickCodec() = default;

std::span<const std::byte> BrickCodec::pack(const clay::Brick& brick, RecordCodec& codec) {
  body_.resize(kCoordBytes + ZSTD_compressBound(kRawBytes));
  const int32_t coord[3] = {brick.coord.x, brick.coord.y, brick.coord.z};
  std::memcpy(body_.data(), coord, kCoordBytes);
  if (codec == RecordCodec::zstd) {
    split(brick.phi, state_->planes);
    const size_t size = ZSTD_compressCCtx(state_->packer, &body_[kCoordBytes], body_.size() - kCoordBytes, state_->planes.data(), kRawBytes, kZstdLevel);
    if (ZSTD_isError(size) == 0 && size < kRawBytes) return std::span(body_).first(kCoordBytes + size);
    codec = RecordCodec::raw;
  }
  std::memcpy(&body_[kCoordBytes], brick.phi, kRawBytes);
  return std::span(body_).first(kCoordBytes + kRawBytes);
}

std::optional<Coord> BrickCodec::unpack(const RecordView& record, float band, clay::Brick& brick) {
  const std::span<const std::byte> body = record.body;
  if (record.header.kind != RecordKind::brick || body.size() <= kCoordBytes) return std::nullopt;
  int32_t coord[3];
  std::memcpy(coord, body.data(), kCoordBytes);
  const std::span<const std::byte> packed = body.subspan(kCoordBytes);
  if (record.header.codec == RecordCodec::raw) {
    if (packed.size() != kRawBytes) return std::nullopt;
    std::memcpy(brick.phi, packed.data(), kRawBytes);
  } else if (record.header.codec == RecordCodec::zstd) {
    if (ZSTD_decompressDCtx(state_->unpacker, state_->planes.data(), kRawBytes, packed.data(), packed.size()) != kRawBytes) return std::nullopt;
    join(state_->planes, brick.phi);
  } else {
    return std::nullopt;
  }
  if (!settle(brick, band)) return std::nullopt;
  return Coord{coord[0], coord[1], coord[2]};
}

}  // namespace argil::io
