#include "clay/base/block_pool.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <tuple>
#include <utility>

#include "clay/base/memory_guard.h"

namespace argil::clay {

namespace {

constexpr size_t kSlab = size_t{2} << 20, kLeastSlab = size_t{32} << 10;
constexpr size_t kShareInSlab = 8;  // of what a pool has, its next slab is this part

// Slabs that no pool has. Clearing fresh pages takes a large share of making a whole surface, and a document that is
// opened or a model that is exported makes one soon after another went.
class SlabStock {
 public:
  std::byte* take() {
    claimMemory(kSlab);  // those in stock too: the system may have taken their pages
    {
      const std::lock_guard lock(mutex_);
      if (!slabs_.empty()) {
        std::byte* slab = slabs_.back();
        slabs_.pop_back();
        return slab;
      }
    }
    auto* slab = static_cast<std::byte*>(std::aligned_alloc(kSlab, kSlab));
    if (!slab) throw std::bad_alloc();
    madvise(slab, kSlab, MADV_HUGEPAGE);
    return slab;
  }

  void give(const std::vector<std::byte*>& slabs) noexcept {
    const std::lock_guard lock(mutex_);
    for (std::byte* slab : slabs) {
      if (slabs_.size() == kMost) {
        std::free(slab);
        continue;
      }
      madvise(slab, kSlab, MADV_FREE);
      slabs_.push_back(slab);
    }
  }

 private:
  static constexpr size_t kMost = 128;
  SlabStock() { slabs_.reserve(kMost); }
  friend SlabStock& stock();
  std::mutex mutex_;
  std::vector<std::byte*> slabs_;
};

// Never destroyed: meshes may outlive everything.
SlabStock& stock() {
  static SlabStock& all = *new SlabStock();
  return all;
}

}  // namespace

BlockPool::~BlockPool() {
  stock().give(slabs_);
  for (std::byte* slab : small_) std::free(slab);
}

std::pair<std::byte*, size_t> BlockPool::takeSlab(size_t least) {
  size_t bytes = 0;
  {
    const std::lock_guard lock(mutex_);
    bytes = std::max({slabBytes_ / kShareInSlab / kStep * kStep, kLeastSlab, least});
    if (bytes > kSlab / 2) bytes = kSlab;
    slabBytes_ += bytes;
  }
  std::byte* slab = bytes == kSlab ? stock().take() : static_cast<std::byte*>(std::aligned_alloc(kStep, bytes));
  if (!slab) throw std::bad_alloc();
  const std::lock_guard lock(mutex_);
  try {
    (bytes == kSlab ? slabs_ : small_).push_back(slab);
  } catch (...) {
    std::free(slab);
    throw;
  }
  return {slab, bytes};
}

void BlockPool::Retire::operator()(BlockPool* pool) const noexcept {
  bool last;
  {
    const std::lock_guard lock(pool->mutex_);
    pool->retired_ = true;
    last = pool->live_ == 0;
  }
  if (last) delete pool;
}

BlockPool::Share::Share(BlockPool& pool) : pool_(pool) {
  const std::lock_guard lock(pool_.mutex_);
  if (pool_.rests_.empty()) return;
  std::tie(next_, end_) = pool_.rests_.back();
  pool_.rests_.pop_back();
}

BlockPool::Share::~Share() {
  const std::lock_guard lock(pool_.mutex_);
  pool_.live_ += taken_;
  // Beyond the room for them a rest waits for the pool's end.
  if (next_ != end_ && pool_.rests_.size() < pool_.rests_.capacity()) pool_.rests_.emplace_back(next_, end_);
}

void* BlockPool::Share::allocate(size_t bytes) {
  if (bytes > kLargest) {
    void* block = ::operator new(bytes, std::align_val_t(kStep));
    ++taken_;
    return block;
  }
  const size_t index = classOf(bytes), size = index * kStep;
  if (pool_.freeBlocks_.load(std::memory_order_relaxed) > 0) {
    const std::lock_guard lock(pool_.mutex_);
    if (FreeBlock* const block = pool_.free_[index]) {
      pool_.free_[index] = block->next;
      pool_.freeBlocks_.store(pool_.freeBlocks_.load(std::memory_order_relaxed) - 1, std::memory_order_relaxed);
      ++taken_;
      return block;
    }
  }
  if (static_cast<size_t>(end_ - next_) < size) {
    const auto [slab, room] = pool_.takeSlab(size);
    next_ = slab;
    end_ = slab + room;
  }
  ++taken_;
  std::byte* block = std::exchange(next_, next_ + size);
  // The next one will be much like it.
  for (size_t line = 0; line < size && line < static_cast<size_t>(end_ - next_); line += kStep)
    __builtin_prefetch(next_ + line, 1);
  return block;
}

BlockPool::Usage BlockPool::usage() const {
  const std::lock_guard lock(mutex_);
  return {slabBytes_, slabBytes_ - slabs_.size() * kSlab};
}

void BlockPool::release(void* block, size_t bytes) noexcept {
  bool last;
  {
    const std::lock_guard lock(mutex_);
    if (bytes <= kLargest) {
      FreeBlock*& list = free_[classOf(bytes)];
      list = new (block) FreeBlock{list};
      freeBlocks_.store(freeBlocks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    }
    last = --live_ == 0 && retired_;
  }
  if (bytes > kLargest) ::operator delete(block, std::align_val_t(kStep));
  if (last) delete this;
}

}  // namespace argil::clay
