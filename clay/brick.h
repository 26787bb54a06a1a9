#pragma once
// The unit of clay that versions share: 8×8×8 voxels.

#include <cmath>
#include <cstdint>

#include "clay/vec.h"

namespace argil::clay {

inline constexpr int kBrickBits = 3;
inline constexpr int kBrickEdge = 1 << kBrickBits;                       ///< 8 voxels along an edge.
inline constexpr int kBrickVoxels = kBrickEdge * kBrickEdge * kBrickEdge;  ///< 512.

/// Distance samples of one brick and what is derived from them. Never written again once its version is committed.
/// 2 176 bytes, 64-byte aligned; lives in slabs of a Store.
struct alignas(64) Brick {
  /// Signed distance in voxels, negative inside, clamped to ±band, never NaN, never −0; in OpenVDB's leaf order
  /// (offset x·64 + y·8 + z).
  float phi[kBrickVoxels];
  /// Bit y·8 + z of word x is set where phi < 0. Zero counts as outside.
  uint64_t inside[kBrickEdge];
  uint8_t anyInside, anyOutside;  ///< Whether some voxel is; from `inside`, so that most bricks are told apart by one line.
  uint64_t serial;  ///< Names this content for good, in all stores: addresses are reused, serials never.
  uint64_t birth;   ///< Id of the version that made it.
  Coord coord;      ///< Brick coordinate: its first voxel is coord · 8.

  [[nodiscard]] static constexpr int offset(int x, int y, int z) { return (x << 6) | (y << 3) | z; }
};

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
    return isTile() ? (tile() == Tile::inside ? -band : band) : brick()->phi[voxelOffset];
  }
  friend constexpr bool operator==(Slot, Slot) = default;

 private:
  uintptr_t bits_;
};

}  // namespace argil::clay
