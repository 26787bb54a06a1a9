#pragma once
// A mean of channels over a few voxels. This module's own.

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "clay/store/channel_reader.h"

namespace argil::clay {

/// Of at most eight voxels, in whole numbers, so that the order of adding does not matter: each colour counts by its
/// weight and by how much it covers; of materials the heaviest, then the lowest.
class ChannelMean {
 public:
  void add(const ChannelBytes& bytes, int64_t weight) {
    const int64_t cover = bytes[indexOf(Channel::cover)] * weight;
    weight_ += weight;
    cover_ += cover;
    mask_ += bytes[indexOf(Channel::mask)] * weight;
    for (size_t i = 0; i < 3; ++i) colour_[i] += bytes[i] * cover;
    const uint8_t material = bytes[indexOf(Channel::material)];
    const auto end = materials_.begin() + kinds_;
    const auto it = std::find_if(materials_.begin(), end, [&](const auto& each) { return each.first == material; });
    if (it != end)
      it->second += weight;
    else
      materials_[static_cast<size_t>(kinds_++)] = {material, weight};
  }
  [[nodiscard]] bool empty() const { return weight_ == 0; }
  /// Of none: nothing.
  [[nodiscard]] ChannelBytes value() const {
    ChannelBytes bytes{};
    if (empty()) return bytes;
    const auto rounded = [](int64_t sum, int64_t count) {
      return static_cast<uint8_t>((2 * sum + count) / (2 * count));
    };
    const uint8_t cover = rounded(cover_, weight_);
    if (cover > 0)
      for (size_t i = 0; i < 3; ++i) bytes[i] = rounded(colour_[i], cover_);
    bytes[indexOf(Channel::cover)] = cover;
    bytes[indexOf(Channel::mask)] = rounded(mask_, weight_);
    const auto heaviest = std::min_element(
        materials_.begin(), materials_.begin() + kinds_,
        [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
    bytes[indexOf(Channel::material)] = heaviest->first;
    return bytes;
  }

 private:
  int64_t weight_ = 0, cover_ = 0, mask_ = 0;
  std::array<int64_t, 3> colour_{};
  std::array<std::pair<uint8_t, int64_t>, 8> materials_{};
  int kinds_ = 0;
};

}  // namespace argil::clay
