#pragma once
// Tells another program whether the studio has something left to do.

#include <atomic>
#include <cstdint>

namespace argil::studio {

/// For programs that work the window by events of mouse and keys and have to wait for what these do. The variable
/// ARGIL_REST names a file of kBytes bytes that such a program has made; without it nothing happens. The file holds two
/// counts, 64 bits each: turns of the window's loop after which something was left to do (a stroke, a job, a picture of
/// the clay, events), and turns after which nothing was and all was shown. Who sees the second one grow by two while
/// the first one stays knows that all that had reached the window before is done and shown. One thread; a call costs an
/// addition.
class RestSign {
 public:
  static constexpr int64_t kBytes = 16;
  /// Throws Error: there is no such file, or it is of another size.
  RestSign();
  ~RestSign();
  RestSign(const RestSign&) = delete;
  RestSign& operator=(const RestSign&) = delete;

  [[nodiscard]] bool wanted() const noexcept { return counts_ != nullptr; }
  void tell(bool atRest) noexcept {
    if (counts_) counts_[atRest ? 1 : 0].fetch_add(1, std::memory_order_release);
  }

 private:
  static_assert(std::atomic<uint64_t>::is_always_lock_free, "shared between processes");
  std::atomic<uint64_t>* counts_ = nullptr;
};

}  // namespace argil::studio
