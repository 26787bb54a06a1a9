#pragma once
// The unit of clay that versions share: 8×8×8 voxels.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "clay/base/vec.h"

namespace argil::clay {

inline constexpr int kBrickBits = 3;
inline constexpr int kBrickEdge = 1 << kBrickBits;                         ///< 8 voxels along an edge.
inline constexpr int kBrickVoxels = kBrickEdge * kBrickEdge * kBrickEdge;  ///< 512.

/// Distances of a brick's voxels, in OpenVDB's leaf order (offset x·64 + y·8 + z).
using BrickValues = float[kBrickVoxels];

/// How bricks hold distances. All bricks of a Store are of one precision.
enum class Precision : uint8_t {
  float32,  ///< FloatBrick.
  fixed16   ///< FixedBrick: half the memory, distances to band / 32 767.
};

inline constexpr int kMostCode = 32767;  ///< Of a fixed brick: ±band.

/// A Brick's step, voxels: 0 for floats.
[[nodiscard]] constexpr float stepOf(Precision precision, float band) {
  return precision == Precision::float32 ? 0 : band / kMostCode;
}

/// What is known of one brick; its distances follow, in the form that its store chose (FloatBrick or FixedBrick). Never
/// written again once its version is committed. 64-byte aligned; lives in slabs of a Store.
struct alignas(64) Brick {
  /// Bit y·8 + z of word x is set where phi < 0. Zero counts as outside.
  uint64_t inside[kBrickEdge];
  float step = 0;       ///< 0: a FloatBrick. Else a FixedBrick, whose codes count steps of so many voxels.
  Coord coord;          ///< Brick coordinate: its first voxel is coord · 8.
  uint64_t serial = 0;  ///< Names this content for good, in all stores: addresses are reused, serials never.
  uint64_t birth = 0;   ///< Id of the version that made it.
  /// Whether some voxel is; from `inside`, so that most bricks are told apart by one line.
  uint8_t anyInside, anyOutside;

  [[nodiscard]] static constexpr int offset(int x, int y, int z) { return (x << 6) | (y << 3) | z; }

  /// Signed distance of a voxel, in voxels: negative inside, clamped to ±band, never NaN, never −0.
  [[nodiscard]] float phi(int voxel) const { return phi(voxel, step); }
  /// `count` of them in a row, from `first` on.
  void read(int first, int count, float* out) const { read(first, count, out, step); }
  /// All 512: the brick's own where it has floats, else written to `scratch`.
  [[nodiscard]] const BrickValues& values(BrickValues& scratch) const;

  // The same for who knows the step of the version: a cache line less.
  [[nodiscard]] float phi(int voxel, float unit) const;
  void read(int first, int count, float* out, float unit) const;
  [[nodiscard]] const void* address(int voxel, float unit) const;

 protected:  // Alone it has no distances: made, copied and freed as what it is.
  Brick() = default;
  Brick(const Brick&) = default;
  Brick& operator=(const Brick&) = default;
  ~Brick() = default;
};

/// A brick of 32-bit distances: 2 176 bytes. What kernels write.
struct FloatBrick : Brick {
  alignas(64) BrickValues value;  ///< As phi() says.
};

/// A brick of 16-bit distances: 1 152 bytes. A distance is its code times the step, rounded once; ±32 767 are ±band.
struct FixedBrick : Brick {
  alignas(64) int16_t code[kBrickVoxels];
};

[[nodiscard]] constexpr size_t brickBytes(Precision precision) {
  return precision == Precision::float32 ? sizeof(FloatBrick) : sizeof(FixedBrick);
}

/// A fixed brick's codes times the step (fixed_brick.h, SIMD).
void unpackDistances(const int16_t* codes, float step, float* values) noexcept;

inline float Brick::phi(int voxel, float unit) const {
  if (unit == 0) return static_cast<const FloatBrick*>(this)->value[voxel];
  return static_cast<float>(static_cast<const FixedBrick*>(this)->code[voxel]) * unit;
}

inline const void* Brick::address(int voxel, float unit) const {
  if (unit == 0) return static_cast<const FloatBrick*>(this)->value + voxel;
  return static_cast<const FixedBrick*>(this)->code + voxel;
}

inline void Brick::read(int first, int count, float* out, float unit) const {
  if (unit == 0) {
    // (g++ calls memmove for a copy of a row that it knows the length of, but not memcpy.)
    std::memcpy(out, static_cast<const FloatBrick*>(this)->value + first, static_cast<size_t>(count) * sizeof(float));
    return;
  }
  const int16_t* code = static_cast<const FixedBrick*>(this)->code + first;
  for (int i = 0; i < count; ++i) out[i] = static_cast<float>(code[i]) * unit;
}

inline const BrickValues& Brick::values(BrickValues& scratch) const {
  if (step == 0) return static_cast<const FloatBrick*>(this)->value;
  unpackDistances(static_cast<const FixedBrick*>(this)->code, step, scratch);
  return scratch;
}

/// A place without a brick: all of it is farther than the band from the surface.
enum class Tile : uint8_t { outside = 0, inside = 1 };

/// What stands at a brick coordinate: a brick or a tile. One word; trivially copyable.
class Slot {
 public:
  constexpr Slot(Tile tile = Tile::outside) : bits_(static_cast<uintptr_t>(tile)) {}
  explicit Slot(const Brick* brick) : bits_(reinterpret_cast<uintptr_t>(brick)) {}

  [[nodiscard]] bool isTile() const { return bits_ <= 1; }
  [[nodiscard]] Tile tile() const { return static_cast<Tile>(bits_); }
  [[nodiscard]] const Brick* brick() const { return isTile() ? nullptr : reinterpret_cast<const Brick*>(bits_); }
  /// Signed distance at a voxel of the place; a tile answers ±band.
  [[nodiscard]] float phi(int voxelOffset, float band) const {
    return isTile() ? (tile() == Tile::inside ? -band : band) : brick()->phi(voxelOffset);
  }
  [[nodiscard]] float phi(int voxelOffset, float band, float step) const {
    return isTile() ? (tile() == Tile::inside ? -band : band) : brick()->phi(voxelOffset, step);
  }
  /// All 512: a float brick's own, else written to `scratch`.
  [[nodiscard]] const BrickValues& values(BrickValues& scratch, float band) const {
    if (!isTile()) return brick()->values(scratch);
    std::fill_n(scratch, kBrickVoxels, phi(0, band));
    return scratch;
  }
  /// The same, copied.
  void read(BrickValues& out, float band) const {
    if (isTile())
      std::fill_n(out, kBrickVoxels, phi(0, band));
    else
      brick()->read(0, kBrickVoxels, out);
  }
  friend constexpr bool operator==(Slot, Slot) = default;

 private:
  uintptr_t bits_;
};

}  // namespace argil::clay
