#pragma once
// Memory for many small blocks of mixed sizes that come and go with the surface.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace argil::clay {

/// Free lists by size (64-byte steps up to 32 KiB; larger ones come from the heap) over slabs that grow with the pool,
/// from 32 KiB to 2 MiB: a document may have a thousand small surfaces. Those of 2 MiB are huge pages where the system
/// grants them: a whole surface would otherwise take a page fault per few bricks (sharing one pool between models was
/// slower: freed blocks come back in no order, and writing them misses the cache). Blocks are 64-byte aligned. Large
/// slabs of a pool that is gone wait for the next one, up to 256 MiB in the process; the system may take them back when
/// it is short of memory.
class BlockPool {
 public:
  /// A pool stands until its owner has let go of it and every block is released.
  struct Retire {
    void operator()(BlockPool* pool) const noexcept;
  };
  using Owner = std::unique_ptr<BlockPool, Retire>;
  [[nodiscard]] static Owner make() { return Owner(new BlockPool()); }
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  /// What one thread allocates from while it is at work: fresh memory of its own, so that threads seldom meet.
  class Share {
   public:
    explicit Share(BlockPool& pool);
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    [[nodiscard]] void* allocate(size_t bytes);
    [[nodiscard]] BlockPool& pool() const { return pool_; }

   private:
    BlockPool& pool_;
    std::byte *next_ = nullptr, *end_ = nullptr;
    int64_t taken_ = 0;
  };

  /// Taken from the system, blocks above 32 KiB apart; so much of it from the heap, the rest in slabs. Any thread.
  struct Usage {
    size_t bytes = 0, heapBytes = 0;
  };
  [[nodiscard]] Usage usage() const;
  /// Of a block from any share. Any thread.
  void release(void* block, size_t bytes) noexcept;

 private:
  static constexpr size_t kStep = 64, kLargest = size_t{32} << 10;
  /// Fresh memory, and its size: `least` bytes or more.
  [[nodiscard]] std::pair<std::byte*, size_t> takeSlab(size_t least);
  [[nodiscard]] static size_t classOf(size_t bytes) { return (bytes + kStep - 1) / kStep; }
  BlockPool() { rests_.reserve(64); }
  ~BlockPool();

  mutable std::mutex mutex_;
  // Lists through the blocks themselves: what is given back needs no memory.
  struct FreeBlock {
    FreeBlock* next;
  };
  FreeBlock* free_[kLargest / kStep + 1] = {};
  std::atomic<int64_t> freeBlocks_ = 0;    // in the lists together
  std::vector<std::byte*> slabs_, small_;  // of 2 MiB, and below
  size_t slabBytes_ = 0;                   // of all of them
  // of slabs, for the next shares; room for as many as are at work at once
  std::vector<std::pair<std::byte*, std::byte*>> rests_;
  int64_t live_ = 0;  // blocks out, those of shares at work apart
  bool retired_ = false;
};

/// For std::allocate_shared from a share: makes an object with `tail` bytes behind it in the same block, and leaves in
/// `at` where they begin (aligned as T is). What it makes keeps the pool alive.
struct TailPlace {
  BlockPool::Share& share;
  size_t tail;
  std::byte* at = nullptr;
};
template <class T>
struct TailAllocator {
  using value_type = T;
  explicit TailAllocator(TailPlace& where) : pool(&where.share.pool()), tail(where.tail), place(&where) {}
  template <class U>
  TailAllocator(const TailAllocator<U>& other) : pool(other.pool), tail(other.tail), place(other.place) {}
  T* allocate(size_t n) {
    auto* block = static_cast<std::byte*>(place->share.allocate(n * sizeof(T) + tail));
    place->at = block + n * sizeof(T);
    return reinterpret_cast<T*>(block);
  }
  void deallocate(T* p, size_t n) noexcept { pool->release(p, n * sizeof(T) + tail); }
  template <class U>
  bool operator==(const TailAllocator<U>& other) const {
    return pool == other.pool && tail == other.tail;
  }
  BlockPool* pool;
  size_t tail;
  TailPlace* place;  ///< Used by allocate() alone.
};

}  // namespace argil::clay
