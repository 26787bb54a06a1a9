#pragma once
// Sets of numbers that are joined two by two (union–find).

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace argil::clay {

/// Numbers 0 to count − 1, each alone at first. The lowest names its set, whatever was joined first. One thread.
class JoinedSets {
 public:
  explicit JoinedSets(size_t count) : root_(count) { std::iota(root_.begin(), root_.end(), 0u); }
  [[nodiscard]] uint32_t find(uint32_t i) {
    while (root_[i] != i) i = root_[i] = root_[root_[i]];
    return i;
  }
  /// False where they were joined before.
  bool join(uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    root_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<uint32_t> root_;
};

}  // namespace argil::clay
