#pragma once
// The newest value from one process to another, in memory that both share: a sequence lock of which neither side waits.

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace argil::plugin {

/// One writer, one reader. A reader that meets a write takes the value for not there yet: it asks again later. What a
/// writer that is not to be trusted does to it changes the value and nothing else.
template <class T>
class SharedValue {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Writer alone. Never waits.
  void store(const T& value) noexcept {
    std::array<uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof value);
    const uint64_t before = sequence_.load(std::memory_order_relaxed);
    sequence_.store(before + 1, std::memory_order_relaxed);
    // Whoever sees one of these sees the odd number too.
    for (size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    sequence_.store(before + 2, std::memory_order_release);
  }

  /// Reader alone: true, and the value, when there is one that is not the one of `seen`. Never waits.
  bool load(T& value, uint64_t& seen) const noexcept {
    const uint64_t before = sequence_.load(std::memory_order_acquire);
    if (before == seen || (before & 1) != 0) return false;
    std::array<uint64_t, kWords> words;
    for (size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
    if (sequence_.load(std::memory_order_relaxed) != before) return false;
    std::memcpy(&value, words.data(), sizeof value);
    seen = before;
    return true;
  }

 private:
  static constexpr size_t kWords = (sizeof(T) + 7) / 8;
  std::atomic<uint64_t> sequence_{0};
  std::array<std::atomic<uint64_t>, kWords> words_{};
};

}  // namespace argil::plugin
