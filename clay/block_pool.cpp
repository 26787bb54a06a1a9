#include "clay/block_pool.h"

#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace argil::clay {

BlockPool::~BlockPool() {
  for (std::byte* slab : slabs_) std::free(slab);
}

void* BlockPool::allocate(size_t bytes) {
  if (bytes > kLargest) return ::operator new(bytes, std::align_val_t(64));
  const size_t index = classOf(bytes), size = index * kStep;
  const std::lock_guard lock(mutex_);
  auto& list = free_[index];
  if (!list.empty()) {
    void* block = list.back();
    list.pop_back();
    return block;
  }
  if (used_ + size > kSlab) {
    auto* slab = static_cast<std::byte*>(std::aligned_alloc(kSlab, kSlab));
    if (!slab) throw std::bad_alloc();
    madvise(slab, kSlab, MADV_HUGEPAGE);
    slabs_.push_back(slab);
    used_ = 0;
  }
  void* block = slabs_.back() + used_;
  used_ += size;
  return block;
}

void BlockPool::release(void* block, size_t bytes) noexcept {
  if (bytes > kLargest) {
    ::operator delete(block, std::align_val_t(64));
    return;
  }
  const std::lock_guard lock(mutex_);
  free_[classOf(bytes)].push_back(block);
}

}  // namespace argil::clay
