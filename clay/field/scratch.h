#pragma once
// Room for what is solved brick by brick. This module's own.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace argil::clay {

/// Room of a thread, kept from call to call: fresh pages would cost more than what is computed in them.
class Scratch {
 public:
  /// `count` of T, with whatever was there. One room for all: the next call, for whatever type, takes it.
  template <class T>
  [[nodiscard]] static std::span<T> of(size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> && alignof(T) <= 16);
    T* const first = static_cast<T*>(mine().room(count * sizeof(T)));
    std::uninitialized_default_construct_n(first, count);
    return {first, count};
  }
  /// Bytes that this thread keeps.
  [[nodiscard]] static size_t kept() { return mine().size_; }

 private:
  // Given back once so many calls in a row asked for a quarter of it at most: one large stroke is over.
  static constexpr int kCallsToShrink = 256;

  static Scratch& mine() {
    static thread_local Scratch scratch;
    return scratch;
  }
  [[nodiscard]] void* room(size_t bytes) {
    smallCalls_ = bytes <= size_ / 4 ? smallCalls_ + 1 : 0;
    if (bytes > size_ || smallCalls_ > kCallsToShrink) {
      room_.reset();
      size_ = bytes + bytes / 8;  // What grows with a stroke does not come anew with each stamp.
      room_ = std::make_unique_for_overwrite<std::byte[]>(size_);
      smallCalls_ = 0;
    }
    return room_.get();
  }

  std::unique_ptr<std::byte[]> room_;
  size_t size_ = 0;
  int smallCalls_ = 0;
};

}  // namespace argil::clay
