#pragma once
// The monotonic clock in nanoseconds, and sleeping until a time of it.

#include <cerrno>
#include <cstdint>
#include <ctime>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// CLOCK_MONOTONIC, through the vDSO: no system call where the kernel's clock source allows.
inline int64_t nowNs() ARGIL_REALTIME {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// What the calling thread has worked, ns: what other programs do beside it does not count.
inline int64_t threadWorkNs() noexcept {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// Sleeps until `ns` of that clock.
inline void sleepUntilNs(int64_t ns) noexcept {
  const timespec t{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace argil::haptics
