#include "render/surface/range_allocator.h"

#include <iterator>

namespace argil::render {

std::optional<uint32_t> RangeAllocator::allocate(uint32_t count) {
  const auto best = bySize_.lower_bound({count, 0});
  if (best == bySize_.end()) return std::nullopt;
  const auto [size, begin] = *best;
  bySize_.erase(best);
  free_.erase(begin);
  if (size > count) {
    free_.emplace(begin + count, size - count);
    bySize_.emplace(size - count, begin + count);
  }
  used_ += count;
  return begin;
}

void RangeAllocator::release(uint32_t begin, uint32_t count) {
  if (count == 0) return;
  used_ -= count;
  auto next = free_.lower_bound(begin);
  if (next != free_.end() && begin + count == next->first) {
    count += next->second;
    bySize_.erase({next->second, next->first});
    next = free_.erase(next);
  }
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == begin) {
      bySize_.erase({before->second, before->first});
      before->second += count;
      bySize_.emplace(before->second, before->first);
      return;
    }
  }
  free_.emplace_hint(next, begin, count);
  bySize_.emplace(count, begin);
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
