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

/// Standard allocator over a shared pool, for std::allocate_shared: what it makes keeps the pool alive.
template <class T>
struct PoolAllocator {
  using value_type = T;
  explicit PoolAllocator(std::shared_ptr<BlockPool> p) : pool(std::move(p)) {}
  template <class U>
  PoolAllocator(const PoolAllocator<U>& other) : pool(other.pool) {}
  T* allocate(size_t n) { return static_cast<T*>(pool->allocate(n * sizeof(T))); }
  void deallocate(T* p, size_t n) noexcept { pool->release(p, n * sizeof(T)); }
  template <class U>
  bool operator==(const PoolAllocator<U>& other) const {
    return pool == other.pool;
  }
  std::shared_ptr<BlockPool> pool;
};

/// An array of trivial elements from a pool; uninitialised when made.
template <class T>
class PoolArray {
 public:
  PoolArray() = default;
  PoolArray(std::shared_ptr<BlockPool> pool, size_t count)
      : pool_(std::move(pool)), data_(count > 0 ? static_cast<T*>(pool_->allocate(count * sizeof(T))) : nullptr), count_(count) {}
  PoolArray(PoolArray&& other) noexcept
      : pool_(std::move(other.pool_)), data_(std::exchange(other.data_, nullptr)), count_(std::exchange(other.count_, 0)) {}
  PoolArray& operator=(PoolArray&& other) noexcept {
    std::swap(pool_, other.pool_);
    std::swap(data_, other.data_);
    std::swap(count_, other.count_);
    return *this;
  }
  ~PoolArray() {
    if (data_) pool_->release(data_, count_ * sizeof(T));
  }
  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] size_t size() const { return count_; }

 private:
  std::shared_ptr<BlockPool> pool_;
  T* data_ = nullptr;
  size_t count_ = 0;
};

}  // namespace argil::clay
