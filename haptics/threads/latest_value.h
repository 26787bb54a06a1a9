#pragma once
// Hand-off 1 of 3: the newest value from one thread to another.

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace argil::haptics {

/// Triple buffer: one writer, one reader, neither ever waits; values in between may be skipped, none is torn. Cost: one
/// atomic exchange and one copy each way.
template <class T>
class LatestValue {
  static_assert(std::is_trivially_destructible_v<T>, "values are copied on the real-time path: they may own nothing");

 public:
  LatestValue() = default;
  explicit LatestValue(const T& initial) { slots_[reading_].value = initial; }

  /// Writer's thread only. Real-time safe.
  void store(const T& value) noexcept {
    slots_[writing_].value = value;
    const uint8_t given = middle_.exchange(static_cast<uint8_t>(writing_ | kFresh), std::memory_order_acq_rel);
    writing_ = given & kIndex;
  }

  /// Reader's thread only: copies the newest value to `value`; true when it was not handed out before. Real-time safe.
  bool load(T& value) noexcept {
    const bool fresh = (middle_.load(std::memory_order_relaxed) & kFresh) != 0;
    if (fresh) reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    value = slots_[reading_].value;
    return fresh;
  }

 private:
  static constexpr uint8_t kIndex = 3, kFresh = 4;
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_;
  alignas(64) std::atomic<uint8_t> middle_{1};
  alignas(64) uint8_t writing_ = 0;
  alignas(64) uint8_t reading_ = 2;
};

}  // namespace argil::haptics
