#pragma once
// Sub-ranges of one large buffer.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace argil::render {

/// Hands out ranges of [0, capacity) and merges what is given back. The smallest free range that is long enough is
/// taken, the lowest of equal ones. Deterministic; O(log free ranges). One thread.
class RangeAllocator {
 public:
  explicit RangeAllocator(uint32_t capacity = 0) { grow(capacity); }

  /// Begin of a free range of `count` units, or nothing when none is long enough. `count` > 0.
  [[nodiscard]] std::optional<uint32_t> allocate(uint32_t count);
  void release(uint32_t begin, uint32_t count);
  /// Makes the whole longer; smaller values are ignored.
  void grow(uint32_t capacity);

  [[nodiscard]] uint32_t capacity() const { return capacity_; }
  [[nodiscard]] uint32_t used() const { return used_; }
  /// One past the last unit in use.
  [[nodiscard]] uint32_t end() const;

 private:
  std::map<uint32_t, uint32_t> free_;               // begin → count; never adjacent
  std::set<std::pair<uint32_t, uint32_t>> bySize_;  // count, begin of the same
  uint32_t capacity_ = 0, used_ = 0;
};

}  // namespace argil::render
