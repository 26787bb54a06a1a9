#pragma once
// Catches what a servo tick must not do: allocation, locks, system calls, page faults.

#include <cstdint>

namespace argil::haptics::testing {

/// Breaches on this thread between enter() and leave(). One trap at a time.
class RealtimeTrap {
 public:
  RealtimeTrap();
  ~RealtimeTrap();
  RealtimeTrap(const RealtimeTrap&) = delete;
  RealtimeTrap& operator=(const RealtimeTrap&) = delete;

  void enter() noexcept;
  void leave() noexcept;

  uint64_t allocations = 0, locks = 0, systemCalls = 0, pageFaults = 0;

  /// False under a sanitizer, which allocates and locks by itself.
  static bool seesAllocationsAndLocks() noexcept;
  /// False where the kernel lacks system call user dispatch.
  [[nodiscard]] bool seesSystemCalls() const noexcept { return dispatch_; }

 private:
  bool dispatch_ = false;
  long faultsBefore_ = 0;
};

}  // namespace argil::haptics::testing
