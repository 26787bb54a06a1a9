#pragma once
// Reads distances and channels of voxels together. This module's own.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <unordered_map>

#include "clay/kernels/brush_kernels.h"
#include "clay/kernels/channel.h"
#include "clay/store/brick_set.h"

namespace argil::clay {

/// The bytes of a voxel in all channels.
using ChannelBytes = std::array<uint8_t, kChannels>;

inline constexpr size_t indexOf(Channel channel) {
  return static_cast<size_t>(channel);
}

/// What stands at a brick coordinate in all trees.
struct ChannelPlace {
  Slot distance;
  std::array<ChannelSlot, kChannels> channel;

  [[nodiscard]] bool empty() const { return channel == std::array<ChannelSlot, kChannels>{}; }
  [[nodiscard]] bool inBand(int voxel, float band) const {
    return distance.brick() && std::abs(distance.brick()->phi(voxel)) < band;
  }
  /// The same of all voxels, by bandBits.
  void inBand(float band, uint64_t (&bits)[kBrickEdge]) const {
    BrickValues room;
    bandBits(distance.values(room, band), band, bits);
  }
  [[nodiscard]] ChannelBytes bytes(int voxel) const {
    ChannelBytes all;
    for (size_t i = 0; i < kChannels; ++i) all[i] = channel[i].value(voxel);
    return all;
  }
};

/// Of a Version or an Editor, which must not change meanwhile. Remembers what it looked up.
template <class Clay>
class ChannelReader {
 public:
  explicit ChannelReader(const Clay& clay) : clay_(clay), band_(clay.grid().band) {
    for (const Channel channel : kAllChannels) has_[indexOf(channel)] = clay.has(channel);
  }

  [[nodiscard]] float band() const { return band_; }
  /// Valid as long as the reader.
  [[nodiscard]] const ChannelPlace& at(Coord brick) {
    const auto [entry, fresh] = places_.try_emplace(brick);
    if (fresh) {
      entry->second.distance = clay_.find(brick);
      for (size_t i = 0; i < kChannels; ++i)
        if (has_[i]) entry->second.channel[i] = clay_.find(static_cast<Channel>(i), brick);
    }
    return entry->second;
  }

 private:
  const Clay& clay_;
  float band_;
  std::array<bool, kChannels> has_{};
  std::unordered_map<Coord, ChannelPlace, CoordHash> places_;
};

/// All channels of one brick, to be changed and put back.
struct ChannelBlock {
  uint8_t value[kChannels][kBrickVoxels];
  uint32_t changed = 0;  ///< Bit i: channel i is not what it was.

  explicit ChannelBlock(const ChannelPlace& place) {
    for (size_t i = 0; i < kChannels; ++i) {
      if (const ChannelBrick* brick = place.channel[i].brick())
        std::copy_n(brick->value, kBrickVoxels, value[i]);
      else
        std::fill_n(value[i], kBrickVoxels, place.channel[i].value(0));
    }
  }
  [[nodiscard]] const uint8_t* operator[](Channel channel) const { return value[indexOf(channel)]; }
  [[nodiscard]] ChannelBytes bytes(int voxel) const {
    ChannelBytes all;
    for (size_t i = 0; i < kChannels; ++i) all[i] = value[i][voxel];
    return all;
  }
  void set(int voxel, const ChannelBytes& bytes) {
    for (size_t i = 0; i < kChannels; ++i) {
      changed |= uint32_t{value[i][voxel] != bytes[i]} << i;
      value[i][voxel] = bytes[i];
    }
  }
  /// Makes the bytes of voxels whose bit (y·8 + z of word x) is not set 0.
  void keepOnly(const uint64_t (&bits)[kBrickEdge]) {
    uint8_t kept[kBrickVoxels];
    for (int i = 0; i < kBrickVoxels; ++i) kept[i] = static_cast<uint8_t>(0 - ((bits[i >> 6] >> (i & 63)) & 1));
    for (size_t c = 0; c < kChannels; ++c) {
      uint8_t gone = 0;
      for (int i = 0; i < kBrickVoxels; ++i) {
        gone |= value[c][i] & static_cast<uint8_t>(~kept[i]);
        value[c][i] &= kept[i];
      }
      changed |= uint32_t{gone != 0} << c;
    }
  }
  template <class Editor>
  void store(Editor& editor, Coord brick) const {
    for (const Channel channel : kAllChannels) {
      const std::span<const uint8_t, kBrickVoxels> mine(value[indexOf(channel)], kBrickVoxels);
      editor.setChannel(channel, brick, mine);
    }
  }
  /// The same where it was taken from there: what did not change is not looked at.
  template <class Editor>
  void storeChanged(Editor& editor, Coord brick) const {
    for (const Channel channel : kAllChannels)
      if ((changed >> indexOf(channel)) & 1)
        editor.setChannel(channel, brick,
                          std::span<const uint8_t, kBrickVoxels>(value[indexOf(channel)], kBrickVoxels));
  }
};

}  // namespace argil::clay
