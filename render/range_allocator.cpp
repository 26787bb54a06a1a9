#include "render/range_allocator.h"

#include <iterator>

namespace argil::render {

std::optional<uint32_t> RangeAllocator::allocate(uint32_t count) {
  for (auto it = free_.begin(); it != free_.end(); ++it) {
    if (it->second < count) continue;
    const uint32_t begin = it->first, left = it->second - count;
    free_.erase(it);
    if (left > 0) free_.emplace(begin + count, left);
    used_ += count;
    return begin;
  }
  return std::nullopt;
}

void RangeAllocator::release(uint32_t begin, uint32_t count) {
  if (count == 0) return;
  used_ -= count;
  auto next = free_.lower_bound(begin);
  if (next != free_.end() && begin + count == next->first) {
    count += next->second;
    next = free_.erase(next);
  }
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == begin) {
      before->second += count;
      return;
    }
  }
  free_.emplace_hint(next, begin, count);
}

void RangeAllocator::grow(uint32_t capacity) {
  if (capacity <= capacity_) return;
  const uint32_t added = capacity - capacity_, begin = capacity_;
  capacity_ = capacity;
  used_ += added;  // release() takes it off again
  release(begin, added);
}

uint32_t RangeAllocator::end() const {
  if (free_.empty()) return capacity_;
  const auto last = std::prev(free_.end());
  return last->first + last->second == capacity_ ? last->first : capacity_;
}

}  // namespace argil::render
