#pragma once
// Hand-off 3 of 3: an immutable thing that one side replaces whole and others read without ever waiting.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Holder of the current T. The publisher (one thread at a time) replaces it; readers announce the epoch that they
/// read, or that they are parked; the publisher frees an old T once every reader has announced a later epoch or is
/// parked. A reader never frees, never waits, never touches a reference count.
///
/// Why it is safe: the new pointer is stored before the epoch is raised, a reader announces before it loads the
/// pointer, and all four are sequentially consistent. A reader that announces the raised epoch therefore sees the new
/// pointer; one seen parked announces later than that look, so it sees the new pointer too.
template <class T>
class Published {
 public:
  static constexpr size_t kMaxReaders = 8;

  /// One reading thread. Made and destroyed off the real-time path; must not outlive its Published.
  class Reader {
   public:
    explicit Reader(Published& source) : source_(&source), slot_(source.claim()) {}
    ~Reader() {
      if (source_) source_->release(slot_);
    }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    /// The current T, or null before the first publish. Valid until the next enter() or park() of this reader. A store
    /// and two loads.
    const T* enter() ARGIL_REALTIME {
      auto& announced = source_->slots_[slot_].epoch;
      announced.store(source_->epoch_.load(), std::memory_order_seq_cst);
      return source_->current_.load(std::memory_order_seq_cst);
    }
    /// This reader holds nothing until its next enter(): a stopped servo piles nothing up.
    void park() ARGIL_REALTIME { source_->slots_[slot_].epoch.store(kParked, std::memory_order_seq_cst); }

   private:
    Published* source_;
    size_t slot_;
  };

  Published() = default;
  Published(const Published&) = delete;
  Published& operator=(const Published&) = delete;
  /// No reader may be left.
  ~Published() { delete current_.load(); }

  /// Makes `next` what readers see from now on; retires the one before and frees what no reader can hold any more.
  void publish(std::unique_ptr<const T> next) {
    retired_.reserve(retired_.size() + 1);
    const T* old = current_.exchange(next.release());
    const uint64_t epoch = epoch_.fetch_add(1) + 1;
    if (old) retired_.push_back({epoch, std::unique_ptr<const T>(old)});
    reclaim();
  }

  /// Publisher's thread: frees what every reader has passed; how many still wait.
  size_t reclaim() {
    uint64_t oldest = UINT64_MAX;
    for (const auto& slot : slots_) {
      const uint64_t epoch = slot.epoch.load();
      if (epoch < oldest) oldest = epoch;  // Parked and unclaimed slots hold the largest number.
    }
    std::erase_if(retired_, [oldest](const Retired& r) { return r.epoch <= oldest; });
    return retired_.size();
  }

  /// Publisher's thread: what it published last, or null.
  [[nodiscard]] const T* current() const noexcept { return current_.load(); }

 private:
  static constexpr uint64_t kParked = UINT64_MAX;
  struct alignas(64) Slot {
    std::atomic<uint64_t> epoch{kParked};
    std::atomic<bool> claimed{false};
  };
  struct Retired {
    uint64_t epoch;
    std::unique_ptr<const T> value;
  };

  size_t claim() {
    for (size_t i = 0; i < kMaxReaders; ++i) {
      bool free = false;
      if (slots_[i].claimed.compare_exchange_strong(free, true)) return i;
    }
    throw Error("more readers of a published scene than it has places for: stop a servo before starting another",
                Error::Kind::work);
  }
  void release(size_t slot) noexcept {
    slots_[slot].epoch.store(kParked);
    slots_[slot].claimed.store(false);
  }

  std::atomic<const T*> current_{nullptr};
  std::atomic<uint64_t> epoch_{0};
  std::array<Slot, kMaxReaders> slots_;
  std::vector<Retired> retired_;
};

}  // namespace argil::haptics
