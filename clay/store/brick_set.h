#pragma once
// A set of brick coordinates that is cheap to fill with neighbours.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

struct CoordHash {
  size_t operator()(Coord c) const {
    const uint64_t key = (static_cast<uint64_t>(static_cast<uint32_t>(c.x)) << 42) ^
                         (static_cast<uint64_t>(static_cast<uint32_t>(c.y)) << 21) ^ static_cast<uint32_t>(c.z);
    return static_cast<size_t>((key * 0x9e3779b97f4a7c15ull) >> 20);
  }
};

/// All 27 bricks around one and itself (number 13), z fastest.
inline constexpr size_t kBricksAround = 27;
[[nodiscard]] constexpr size_t aroundNumber(Coord step) {
  return static_cast<size_t>((step.x + 1) * 9 + (step.y + 1) * 3 + step.z + 1);
}
inline constexpr std::array<Coord, kBricksAround> kAroundSteps = [] {
  std::array<Coord, kBricksAround> steps;
  for (int i = 0; i < static_cast<int>(kBricksAround); ++i)
    steps[static_cast<size_t>(i)] = {i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
  return steps;
}();

/// One bit a brick in blocks of 8×8×8. Adding near the last added costs a few instructions.
class BrickSet {
 public:
  void add(Coord brick) {
    const Coord region = brick >> 3;
    if (!last_ || region != lastRegion_) {
      lastRegion_ = region;
      last_ = &regions_[region];  // references into the map stay valid
    }
    (*last_)[static_cast<size_t>(brick.x & 7)] |= uint64_t{1} << ((brick.y & 7) * 8 + (brick.z & 7));
  }
  /// All of them, region by region in order of coordinate, within a region too: an order that the content alone
  /// decides.
  [[nodiscard]] std::vector<Coord> sorted() const {
    std::vector<Coord> keys;
    keys.reserve(regions_.size());
    for (const auto& entry : regions_) keys.push_back(entry.first);
    std::sort(keys.begin(), keys.end());
    std::vector<Coord> all;
    for (const Coord region : keys) {
      const auto& words = regions_.at(region);
      for (int x = 0; x < 8; ++x)
        for (uint64_t left = words[static_cast<size_t>(x)]; left != 0; left &= left - 1) {
          const int bit = std::countr_zero(left);
          all.push_back(region * 8 + Coord{x, bit >> 3, bit & 7});
        }
    }
    return all;
  }

 private:
  using Words = std::array<uint64_t, 8>;
  std::unordered_map<Coord, Words, CoordHash> regions_;
  Coord lastRegion_;
  Words* last_ = nullptr;
};

/// With those that touch them by a face, an edge or a corner; sorted by coordinate.
inline std::vector<Coord> withNeighbours(const std::vector<Coord>& bricks) {
  BrickSet set;
  for (const Coord c : bricks)
    for (const Coord step : kAroundSteps) set.add(c + step);
  std::vector<Coord> all = set.sorted();
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace argil::clay
