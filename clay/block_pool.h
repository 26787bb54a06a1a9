#pragma once
// Memory for many small blocks of mixed sizes that come and go with the surface.

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace argil::clay {

/// Free lists by size (64-byte steps up to 32 KiB; larger ones come from the heap) over slabs of 2 MiB, huge pages where the
/// system grants them: a whole surface would otherwise take a page fault per few bricks (sharing one pool between
/// models was slower: freed blocks come back in no order, and writing them misses the cache). Blocks are 64-byte aligned. Memory goes back to the system with the pool. Any thread.
class BlockPool {
 public:
  BlockPool() = default;
  ~BlockPool();
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  [[nodiscard]] void* allocate(size_t bytes);
  void release(void* block, size_t bytes) noexcept;

 private:
  static constexpr size_t kStep = 64, kLargest = size_t{32} << 10, kSlab = size_t{2} << 20;
  [[nodiscard]] static size_t classOf(size_t bytes) { return (bytes + kStep - 1) / kStep; }

  std::mutex mutex_;
  std::vector<void*> free_[kLargest / kStep + 1];
  std::vector<std::byte*> slabs_;
  size_t used_ = kSlab;  // of the newest slab
};

/// For std::allocate_shared over a shared pool: makes each object with `tail` bytes behind it in the same block, and says at `*at` where
/// they begin (aligned as T is). What it makes keeps the pool alive.
template <class T>
struct TailAllocator {
  using value_type = T;
  TailAllocator(std::shared_ptr<BlockPool> p, size_t tailBytes, std::byte** where) : pool(std::move(p)), tail(tailBytes), at(where) {}
  template <class U>
  TailAllocator(const TailAllocator<U>& other) : pool(other.pool), tail(other.tail), at(other.at) {}
  T* allocate(size_t n) {
    auto* block = static_cast<std::byte*>(pool->allocate(n * sizeof(T) + tail));
    *at = block + n * sizeof(T);
    return reinterpret_cast<T*>(block);
  }
  void deallocate(T* p, size_t n) noexcept { pool->release(p, n * sizeof(T) + tail); }
  template <class U>
  bool operator==(const TailAllocator<U>& other) const {
    return pool == other.pool && tail == other.tail;
  }
  std::shared_ptr<BlockPool> pool;
  size_t tail;
  std::byte** at;  ///< Used by allocate() alone.
};

}  // namespace argil::clay
