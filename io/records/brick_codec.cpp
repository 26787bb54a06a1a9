#include "io/records/brick_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace argil::io {

namespace {

constexpr size_t kCoordBytes = 12;
constexpr size_t kRawBytes = sizeof(clay::BrickValues);
constexpr size_t kRawCodeBytes = sizeof clay::FixedBrick::code;
constexpr size_t kMostBits = 3 + clay::kBrickVoxels * 40;  // whatever is read: no voxel takes more than 40 bits
constexpr size_t kWorkBytes = kMostBits / 8 + 16;

constexpr float kBeyondBand = 8;  // how far distances are continued past the band, in voxels

// A number that rises with the value of a float: neighbours in value are neighbours in number.
uint32_t ordered(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return bits ^ (static_cast<uint32_t>(static_cast<int32_t>(bits) >> 31) | 0x80000000u);
}
float unordered(uint32_t order) {
  return std::bit_cast<float>(order ^ (~static_cast<uint32_t>(static_cast<int32_t>(order) >> 31) | 0x80000000u));
}

// How distances are counted: floats in voxels, codes in steps.
struct FloatNumbers {
  using Value = float;
  static constexpr int kFirstLength = 24;  // bits expected of the first voxel, which nothing predicts
  float band;
  [[nodiscard]] float beyond() const { return band + kBeyondBand; }
  static uint32_t order(float predicted) { return ordered(predicted); }
  static float value(uint32_t order) { return unordered(order); }
};

struct CodeNumbers {
  using Value = int16_t;
  static constexpr int kFirstLength = 14;
  static constexpr float band = clay::kMostCode;
  [[nodiscard]] static float beyond() { return 4 * band; }
  // predictions are whole
  static uint32_t order(float predicted) { return static_cast<uint32_t>(static_cast<int32_t>(predicted)); }
  static float value(uint32_t order) { return static_cast<float>(static_cast<int32_t>(order)); }
};

// Differences of both signs as small numbers.
uint32_t zigzag(uint32_t step) {
  return (step << 1) ^ (0u - (step >> 31));
}
uint32_t unzigzag(uint32_t code) {
  return (code >> 1) ^ (0u - (code & 1));
}

int bitLength(uint32_t value) {
  return 32 - std::countl_zero(value);
}

constexpr int kCornerBits = 3;
constexpr int kMostPrefix = 4;  // longer ones say the length in kLengthBits instead
constexpr int kLengthBits = 5;

// Goes through the voxels (index x·64 + y·8 + z, from the chosen corner) in order and calls step(index, prediction as
// an ordered number), which returns the value there. The prediction is Lorenzo's: exact where the field is a sum of
// functions of two coordinates each. Where values are clamped it goes on from what it predicted instead, so that a
// plane that comes back into the band is still known. Encoder and decoder must do the same arithmetic.
template <class Numbers, class Step>
void predict(const Numbers& numbers, const Step& step) {
  const float band = numbers.band, beyond = numbers.beyond();
  std::array<float, clay::kBrickVoxels + 2 * 64> store{};  // rows before the first ones are zero
  float* at = store.data() + 2 * 64;
  const auto value = [&](float predicted, int index) __attribute__((always_inline)) {
    const float within = std::min(std::max(predicted, -band), band) + 0.0f;
    const float is = step(index, numbers.order(within));
    float goOn = is;
    if (is >= band) goOn = std::min(std::max(predicted, band), beyond);
    if (is <= -band) goOn = std::max(std::min(predicted, -band), -beyond);
    at[index] = goOn;
    return goOn;
  };
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      const int row = x * 64 + y * 8;
      float base[8];
      for (int z = 0; z < 8; ++z)
        base[z] = x == 0   ? (y == 0 ? 0.0f : at[row + z - 8])
                  : y == 0 ? at[row + z - 64]
                           : (at[row + z - 8] - at[row + z - 72]) + at[row + z - 64];
      float first = base[0];
      if (y == 0 && x > 1) first = 2 * at[row - 64] - at[row - 128];
      if (x == 0 && y > 1) first = 2 * at[row - 8] - at[row - 16];
      float before = value(first, row);
      if (row == 0) {
        float slope = 0;
        for (int z = 1; z < 8; ++z) {
          const float now = value(before + slope, z);
          slope = now - before;
          before = now;
        }
      } else {
        for (int z = 1; z < 8; ++z) before = value(before + (base[z] - base[z - 1]), row + z);
      }
    }
  }
}

// Bit lengths of codes as far as they are known, and what they say about the next.
class Lengths {
 public:
  explicit Lengths(int first) : first_(first) {}
  void set(int index, uint32_t code) { of_[static_cast<size_t>(index)] = static_cast<int8_t>(bitLength(code)); }
  // How many low bits of the code at `index` stand as they are.
  [[nodiscard]] int plainBits(int index) const {
    if (index == 0) return first_ - 1;
    const int x = index >> 6, y = (index >> 3) & 7, z = index & 7;
    const int8_t* at = of_.data() + index;
    const int byZ = z > 0 ? at[-1] : y > 0 ? at[-8] : at[-64];
    const int byY = y > 0 ? at[-8] : x > 0 ? at[-64] : byZ;
    const int byX = x > 0 ? at[-64] : (byZ + byY + 1) / 2;
    const int median = std::max(std::min(byZ, byY), std::min(std::max(byZ, byY), byX));
    return std::max(0, median - 1);
  }

 private:
  int first_;
  std::array<int8_t, clay::kBrickVoxels> of_{};
};

// Bits from the lowest of the first byte on.
class BitWriter {
 public:
  explicit BitWriter(std::byte* to) : to_(to) {}
  void add(uint64_t bits, int count) {  // at most 32 at once
    word_ |= bits << filled_;
    filled_ += count;
    if (filled_ >= 32) {
      const auto low = static_cast<uint32_t>(word_);
      std::memcpy(to_, &low, 4);
      to_ += 4;
      word_ >>= 32;
      filled_ -= 32;
    }
  }
  std::byte* finish() {
    std::memcpy(to_, &word_, 8);
    return to_ + (filled_ + 7) / 8;
  }

 private:
  std::byte* to_;
  uint64_t word_ = 0;
  int filled_ = 0;
};

template <class Numbers>
size_t encode(const typename Numbers::Value* phi, const Numbers& numbers, std::byte* to) {
  // The corner nearest to the surface: from there the field is known before it is clamped.
  int corner = 0;
  for (int i = 1; i < 8; ++i) {
    const int other = (i & 4 ? 448 : 0) | (i & 2 ? 56 : 0) | (i & 1 ? 7 : 0);
    if (std::abs(phi[other]) < std::abs(phi[corner])) corner = other;
  }
  BitWriter writer(to);
  writer.add(static_cast<uint64_t>((corner >> 6 & 4) | (corner >> 3 & 2) | (corner & 1)), kCornerBits);
  Lengths lengths(Numbers::kFirstLength);
  predict(
      numbers, [&](int index, uint32_t predicted) __attribute__((always_inline)) {
        const auto value = static_cast<float>(phi[index ^ corner]);
        const uint32_t code = zigzag(numbers.order(value) - predicted);
        const int plain = lengths.plainBits(index);
        lengths.set(index, code);
        const int prefix = bitLength(code >> plain);
        if (prefix < kMostPrefix) {
          writer.add((uint64_t{1} << prefix) - 1, prefix + 1);
          const int rest = plain + std::max(0, prefix - 1);
          writer.add(code & ((uint64_t{1} << rest) - 1), rest);
        } else {
          const int length = bitLength(code);
          writer.add((uint64_t{1} << kMostPrefix) - 1 + (static_cast<uint64_t>(length - 1) << kMostPrefix),
                     kMostPrefix + kLengthBits);
          writer.add(code & ((uint64_t{1} << (length - 1)) - 1), length - 1);
        }
        return value;
      });
  return static_cast<size_t>(writer.finish() - to);
}

// `from` has kWorkBytes, zeros behind the body. Returns how many bytes were used; it may be more than the body had.
template <class Numbers>
size_t decode(const std::byte* from, const Numbers& numbers, float* phi) {
  size_t at = kCornerBits;
  const auto first = static_cast<int>(from[0]);
  const int corner = (first & 4 ? 448 : 0) | (first & 2 ? 56 : 0) | (first & 1 ? 7 : 0);
  Lengths lengths(Numbers::kFirstLength);
  predict(
      numbers, [&](int index, uint32_t predicted) __attribute__((always_inline)) {
        uint64_t bits;
        std::memcpy(&bits, from + at / 8, 8);
        bits >>= at % 8;  // 57 at least
        const int plain = lengths.plainBits(index);
        const int prefix = std::min(std::countr_one(bits), kMostPrefix);
        uint32_t code;
        if (prefix < kMostPrefix) {
          const int rest = plain + std::max(0, prefix - 1);
          code = static_cast<uint32_t>((bits >> (prefix + 1)) & ((uint64_t{1} << rest) - 1)) |
                 static_cast<uint32_t>((prefix > 0 ? uint64_t{1} : 0) << rest);
          at += static_cast<size_t>(prefix + 1 + rest);
        } else {
          const auto rest = static_cast<int>((bits >> kMostPrefix) & ((1u << kLengthBits) - 1));
          code = static_cast<uint32_t>((bits >> (kMostPrefix + kLengthBits)) & ((uint64_t{1} << rest) - 1)) |
                 static_cast<uint32_t>(uint64_t{1} << rest);
          at += static_cast<size_t>(kMostPrefix + kLengthBits + rest);
        }
        lengths.set(index, code);
        const float value = numbers.value(predicted + unzigzag(code));
        phi[index ^ corner] = value;
        return value;
      });
  return (at + 7) / 8;
}

// Fills `inside`; false for what no version holds.
bool settle(clay::FloatBrick& brick, float band) {
  const auto bandBits = std::bit_cast<int32_t>(band);
  int32_t bad = 0, inBand = 0;
  for (const float phi : brick.value) {  // apart from the next loop, so that it runs on vectors
    const auto bits = std::bit_cast<int32_t>(phi);
    const int32_t size = bits & 0x7fffffff;          // in the order of the absolute values; NaN is above all
    bad |= (bandBits - size) | ((size - 1) & bits);  // negative: out of the band; -0
    inBand |= size - bandBits;
  }
  for (size_t x = 0; x < clay::kBrickEdge; ++x) {
    uint64_t word = 0;
    for (size_t i = 0; i < 64; i += 4) {
      const auto sign = [&](size_t k) {
        return static_cast<uint64_t>(std::bit_cast<uint32_t>(brick.value[x * 64 + i + k]) >> 31) << k;
      };
      word |= (sign(0) | sign(1) | sign(2) | sign(3)) << i;
    }
    brick.inside[x] = word;
  }
  return bad >= 0 && inBand < 0;
}

bool settle(clay::FixedBrick& brick) {
  bool sound = true, inBand = false;
  for (size_t x = 0; x < clay::kBrickEdge; ++x) {
    uint64_t word = 0;
    for (size_t i = 0; i < 64; ++i) {
      const int code = brick.code[x * 64 + i];
      sound &= code >= -clay::kMostCode;
      inBand |= std::abs(code) < clay::kMostCode;
      word |= static_cast<uint64_t>(code < 0) << i;
    }
    brick.inside[x] = word;
  }
  return sound && inBand;
}

}  // namespace

BrickCodec::BrickCodec() : work_(kCoordBytes + std::max(kWorkBytes, kRawBytes)) {}

std::span<const std::byte> BrickCodec::pack(const clay::Brick& brick, float band, RecordCodec& codec) {
  const int32_t coord[3] = {brick.coord.x, brick.coord.y, brick.coord.z};
  std::memcpy(work_.data(), coord, kCoordBytes);
  std::byte* body = &work_[kCoordBytes];
  const bool packed = codec != RecordCodec::raw;
  if (brick.step != 0) {
    const auto& code = static_cast<const clay::FixedBrick&>(brick).code;
    const size_t size = packed ? encode(code, CodeNumbers{}, body) : kRawCodeBytes;
    codec = size < kRawCodeBytes ? RecordCodec::predicted16 : RecordCodec::raw16;
    if (codec == RecordCodec::predicted16) return std::span(work_).first(kCoordBytes + size);
    std::memcpy(body, code, kRawCodeBytes);
    return std::span(work_).first(kCoordBytes + kRawCodeBytes);
  }
  const auto& value = static_cast<const clay::FloatBrick&>(brick).value;
  const size_t size = packed ? encode(value, FloatNumbers{band}, body) : kRawBytes;
  codec = size < kRawBytes ? RecordCodec::predicted : RecordCodec::raw;
  if (codec == RecordCodec::predicted) return std::span(work_).first(kCoordBytes + size);
  std::memcpy(body, value, kRawBytes);
  return std::span(work_).first(kCoordBytes + kRawBytes);
}

std::optional<Coord> BrickCodec::unpack(const RecordView& record, float band, clay::Brick& brick) {
  const std::span<const std::byte> body = record.body;
  if (record.header.kind != RecordKind::brick || body.size() <= kCoordBytes) return std::nullopt;
  int32_t coord[3];
  std::memcpy(coord, body.data(), kCoordBytes);
  const std::span<const std::byte> packed = body.subspan(kCoordBytes);
  // What follows the coordinate; whoever decodes looks at zeros behind it.
  const auto padded = [&] {
    std::memcpy(work_.data(), packed.data(), packed.size());
    std::memset(&work_[packed.size()], 0, kWorkBytes - packed.size());
    return work_.data();
  };
  const bool isFixed = brick.step != 0;
  const RecordCodec raw = isFixed ? RecordCodec::raw16 : RecordCodec::raw,
                    predicted = isFixed ? RecordCodec::predicted16 : RecordCodec::predicted;
  const size_t rawBytes = isFixed ? kRawCodeBytes : kRawBytes;
  if (record.header.codec == raw ? packed.size() != rawBytes
                                 : record.header.codec != predicted || packed.size() >= rawBytes)
    return std::nullopt;
  if (isFixed) {
    auto& fixed = static_cast<clay::FixedBrick&>(brick);
    if (record.header.codec == raw) {
      std::memcpy(fixed.code, packed.data(), kRawCodeBytes);
    } else {
      clay::BrickValues codes;
      if (decode(padded(), CodeNumbers{}, codes) != packed.size()) return std::nullopt;
      for (size_t i = 0; i < clay::kBrickVoxels; ++i) {
        if (!(std::abs(codes[i]) <= clay::kMostCode)) return std::nullopt;
        fixed.code[i] = static_cast<int16_t>(codes[i]);
      }
    }
    if (!settle(fixed)) return std::nullopt;
  } else {
    auto& floats = static_cast<clay::FloatBrick&>(brick);
    if (record.header.codec == raw)
      std::memcpy(floats.value, packed.data(), kRawBytes);
    else if (decode(padded(), FloatNumbers{band}, floats.value) != packed.size())
      return std::nullopt;
    if (!settle(floats, band)) return std::nullopt;
  }
  return Coord{coord[0], coord[1], coord[2]};
}

}  // namespace argil::io
