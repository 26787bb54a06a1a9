#pragma once
// Colours or masks of a brick towards the mean of what is around them. This module's own.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "clay/store/channel_reader.h"

namespace argil::clay {

/// Voxels of the band around a brick, 3×3×3 with weights 1 2 1 along each axis: colours count by how much they cover.
/// Sums are whole numbers, so that no order matters.
class ChannelBlur {
 public:
  ChannelBlur() {
    for (auto& field : fields_) field.resize(kAround);
  }

  /// False where there is nothing to blur, and apply() would change nothing.
  template <class Clay>
  [[nodiscard]] bool gather(ChannelReader<Clay>& clay, Coord coord, bool colour) {
    const float band = clay.band();
    const ChannelPlace* places[kBricksAround];
    for (size_t i = 0; i < kBricksAround; ++i) places[i] = &clay.at(coord + kAroundSteps[i]);
    const size_t counted = indexOf(colour ? Channel::cover : Channel::mask);
    if (std::all_of(std::begin(places), std::end(places),
                    [&](const ChannelPlace* p) { return p->channel[counted] == ChannelSlot(); }))
      return false;
    const auto side = [](int c) { return c < 0 ? 0 : c < kBrickEdge ? 1 : 2; };
    colour_ = colour;
    for (int x = -1; x <= kBrickEdge; ++x)
      for (int y = -1; y <= kBrickEdge; ++y)
        for (int z = -1; z <= kBrickEdge; ++z) {
          const ChannelPlace& place = *places[side(x) * 9 + side(y) * 3 + side(z)];
          const int voxel = Brick::offset(x & 7, y & 7, z & 7);
          const auto at = static_cast<size_t>(around(x + 1, y + 1, z + 1));
          const bool in = place.inBand(voxel, band);
          const auto byte = [&](Channel channel) {
            return in ? int32_t{place.channel[indexOf(channel)].value(voxel)} : 0;
          };
          fields_[0][at] = in;
          fields_[1][at] = byte(colour_ ? Channel::cover : Channel::mask);
          if (!colour_) continue;
          for (size_t i = 0; i < 3; ++i) fields_[2 + i][at] = fields_[1][at] * byte(kColourChannels[i]);
        }
    for (size_t i = 0; i < (colour_ ? 5u : 2u); ++i) binomialSums(fields_[i]);
    return true;
  }

  void apply(int voxel, float share, ChannelBytes& bytes) const {
    const auto at = static_cast<size_t>(around((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, (voxel & 7) + 1));
    const auto count = static_cast<float>(fields_[0][at]);
    const auto towards = [share](float from, float to) { return from + (to - from) * share; };
    const auto byteOf = [](float value) { return static_cast<uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); };
    uint8_t& own = bytes[indexOf(colour_ ? Channel::cover : Channel::mask)];
    const float before = own, after = towards(before, static_cast<float>(fields_[1][at]) / count);
    own = byteOf(after);
    if (!colour_) return;
    for (size_t i = 0; i < 3; ++i) {
      uint8_t& mine = bytes[indexOf(kColourChannels[i])];
      const float premultiplied = towards(before * mine, static_cast<float>(fields_[2 + i][at]) / count);
      mine = own == 0 ? uint8_t{0} : byteOf(premultiplied / after);
    }
  }

 private:
  // A brick with one voxel around it.
  static constexpr int kSide = 10, kAround = kSide * kSide * kSide;
  static constexpr int around(int x, int y, int z) { return (x * kSide + y) * kSide + z; }

  // Sums over 3×3×3 with weights 1 2 1 along each axis, in place; right at the brick's own voxels.
  static void binomialSums(std::vector<int32_t>& field) {
    static thread_local std::vector<int32_t> source;
    for (const int step : {1, kSide, kSide * kSide}) {
      source = field;
      for (int i = step; i < kAround - step; ++i)
        field[static_cast<size_t>(i)] = source[static_cast<size_t>(i - step)] + 2 * source[static_cast<size_t>(i)] +
                                        source[static_cast<size_t>(i + step)];
    }
  }

  std::array<std::vector<int32_t>, 5> fields_;
  bool colour_ = true;
};

}  // namespace argil::clay
