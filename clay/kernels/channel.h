#pragma once
// What clay has beside distances: a byte a voxel, in trees of their own that are absent until used.

#include <array>
#include <cstdint>

#include "clay/kernels/brick.h"

namespace argil::clay {

/// Values count in the band alone; where there is none they are 0. A colour is red, green, blue (sRGB) and how much of
/// it covers the piece's own.
enum class Channel : uint8_t {
  red,
  green,
  blue,
  cover,     ///< 0: the piece's colour; 255: red, green, blue alone.
  material,  ///< Row of the piece's materials; 0 is its own.
  mask,      ///< 0: free; 255: no tool changes the voxel by a bit.
};
inline constexpr int kChannels = 6;
inline constexpr std::array kAllChannels{Channel::red,   Channel::green,    Channel::blue,
                                         Channel::cover, Channel::material, Channel::mask};
inline constexpr std::array kColourChannels{Channel::red, Channel::green, Channel::blue, Channel::cover};

/// One channel of one brick coordinate. Never written again once its version is committed. 576 bytes.
struct alignas(64) ChannelBrick {
  uint8_t value[kBrickVoxels];  ///< In Brick's order.
  uint64_t serial;              ///< Names this content for good, in all stores; counted with those of bricks.
  uint64_t birth;               ///< Id of the version that made it.
  Coord coord;
};

/// What stands at a brick coordinate of a channel: a brick, or 0 or 255 everywhere.
class ChannelSlot {
 public:
  constexpr ChannelSlot() = default;
  explicit constexpr ChannelSlot(bool full) : bits_(full) {}
  explicit ChannelSlot(const ChannelBrick* brick) : bits_(reinterpret_cast<uintptr_t>(brick)) {}

  [[nodiscard]] bool isTile() const { return bits_ <= 1; }
  [[nodiscard]] const ChannelBrick* brick() const {
    return isTile() ? nullptr : reinterpret_cast<const ChannelBrick*>(bits_);
  }
  [[nodiscard]] uint8_t value(int voxelOffset) const {
    return isTile() ? static_cast<uint8_t>(bits_ * 255) : brick()->value[voxelOffset];
  }
  friend constexpr bool operator==(ChannelSlot, ChannelSlot) = default;

 private:
  uintptr_t bits_ = 0;
};

}  // namespace argil::clay
