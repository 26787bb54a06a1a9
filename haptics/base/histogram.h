#pragma once
// Counts durations without allocating.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Fixed-size histogram of nanoseconds: 32 steps a power of two (3 % wide), up to about an hour. One thread adds; read
/// it after that thread stopped.
class Histogram {
 public:
  void add(int64_t nanoseconds) ARGIL_REALTIME {
    const auto value = static_cast<uint64_t>(std::max<int64_t>(0, nanoseconds));
    ++counts_[std::min(index(value), kBins - 1)];
    ++total_;
    max_ = std::max(max_, value);
  }
  void add(const Histogram& other) noexcept {
    for (size_t i = 0; i < kBins; ++i) counts_[i] += other.counts_[i];
    total_ += other.total_;
    max_ = std::max(max_, other.max_);
  }
  [[nodiscard]] uint64_t count() const noexcept { return total_; }
  [[nodiscard]] double maxUs() const noexcept { return double(max_) * 1e-3; }
  /// Value below which the fraction q (0 to 1) of all durations lies, µs, rounded up to a step's upper end.
  [[nodiscard]] double quantileUs(double q) const noexcept {
    const auto wanted = static_cast<uint64_t>(q * double(total_));
    uint64_t seen = 0;
    for (size_t i = 0; i < kBins; ++i) {
      seen += counts_[i];
      if (seen > wanted) return std::min(double(max_), double(upper(i))) * 1e-3;
    }
    return maxUs();
  }
  void clear() noexcept { *this = Histogram(); }

 private:
  static constexpr int kSubBits = 5;
  static constexpr size_t kBins = size_t{38} << kSubBits;
  static size_t index(uint64_t v) noexcept {
    if (v < (1u << kSubBits)) return v;
    const int shift = std::bit_width(v) - 1 - kSubBits;
    return (static_cast<size_t>(shift + 1) << kSubBits) + ((v >> shift) & ((1u << kSubBits) - 1));
  }
  static uint64_t upper(size_t i) noexcept {
    if (i < (1u << kSubBits)) return i;
    const int shift = static_cast<int>(i >> kSubBits) - 1;
    return ((((i & ((1u << kSubBits) - 1)) | (1u << kSubBits)) + 1) << shift) - 1;
  }
  std::array<uint64_t, kBins> counts_{};
  uint64_t total_ = 0, max_ = 0;
};

}  // namespace argil::haptics
