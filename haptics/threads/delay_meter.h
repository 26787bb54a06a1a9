#pragma once
// How late the loop of servo and device is.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// The median of the last kWindow delays that were measured, of kFirst in the beginning. One that grew counts at once,
/// one that shrank little by little: a coupling that follows it is never too stiff for long. One thread adds, any
/// thread asks. Some 0.01 µs a delay; no memory but its own.
class DelayMeter {
 public:
  static constexpr int kWindow = 256, kFirst = 32;
  static constexpr double kMostS = 0.015;  ///< Longer ones count as so long: what couplings can be made for.
  static constexpr double kFall = 0.25;    ///< Of the way to a shorter median, each kWindow delays.

  /// `guessS`: what is answered until the first kFirst delays were measured.
  explicit DelayMeter(double guessS) : delayS_(std::clamp(guessS, 0.0, kMostS)) {}

  void add(double delayS) ARGIL_REALTIME {
    // Not a number is counted as the longest.
    const double part = delayS >= 0 && delayS < kMostS ? delayS / kMostS : delayS < 0 ? 0.0 : 1.0;
    ++counts_[static_cast<size_t>(part * (kBins - 1))];
    if (++count_ == (windows() == 0 ? kFirst : kWindow)) close();
  }
  [[nodiscard]] double delayS() const noexcept { return delayS_.load(std::memory_order_relaxed); }
  /// Windows of delays that were measured so far.
  [[nodiscard]] uint32_t windows() const noexcept { return windows_.load(std::memory_order_relaxed); }

 private:
  static constexpr int kBins = 301;  // 50 µs each.

  void close() ARGIL_REALTIME {
    int below = 0;
    size_t bin = 0;
    while (2 * (below += counts_[bin]) < count_) ++bin;
    const double median = std::min(kMostS, (double(bin) + 0.5) * kMostS / (kBins - 1));
    const double before = delayS();
    delayS_.store(windows() == 0 || median > before ? median : before + kFall * (median - before),
                  std::memory_order_relaxed);
    windows_.store(windows() + 1, std::memory_order_relaxed);
    counts_.fill(0);
    count_ = 0;
  }

  std::array<int, kBins> counts_{};
  int count_ = 0;
  std::atomic<double> delayS_;
  std::atomic<uint32_t> windows_{0};
};

}  // namespace argil::haptics
