#pragma once
// Sleeping on a word of memory that processes share.

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstdint>
#include <ctime>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace argil::plugin {

/// Returns once `word` is not `value`, after `ns`, or for no reason. `ns` below 0: however long it takes.
inline void sleepWhile(std::atomic<uint32_t>& word, uint32_t value, int64_t ns) noexcept {
  const timespec time{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  ::syscall(SYS_futex, &word, FUTEX_WAIT, value, ns < 0 ? nullptr : &time, nullptr, 0);
}
inline void wakeAll(std::atomic<uint32_t>& word) noexcept {
  ::syscall(SYS_futex, &word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

/// Looks for about `ns` whether `word` is no longer `value`: what comes soon comes sooner than a sleeper wakes.
inline bool changesSoon(const std::atomic<uint32_t>& word, uint32_t value, int64_t ns) noexcept {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
  };
  const int64_t until = now() + ns;
  do {
    for (int i = 0; i < 32; ++i) {
      if (word.load() != value) return true;
#if defined(__x86_64__)
      _mm_pause();
#endif
    }
  } while (now() < until);
  return false;
}

}  // namespace argil::plugin
