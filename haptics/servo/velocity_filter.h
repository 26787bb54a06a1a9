#pragma once
// The speed of a stylus from the steps of its encoders.

#include <array>

#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"
#include "haptics/base/tick_clock.h"

namespace argil::haptics {

/// First-order adaptive windowing, end-fit (Janabi-Sharifi, Hayward, Chen 2000), per axis: the slope from the newest
/// position back to the oldest one such that a straight line between them passes within one encoder step of all in
/// between. Slow: a long window, little noise; quick changes: a short one, little lag. A low-pass takes off the edges
/// where the window changes. Cost: about kWindow operations an axis. One thread. Measured cut-off, lag and noise:
/// stability.md.
class VelocityFilter {
 public:
  static constexpr int kWindow = 64;  ///< Ticks that it looks back at most.

  /// `stepMm`: one encoder step of an axis, 0 for exact positions.
  VelocityFilter(double periodS, double stepMm);

  /// Forgets everything: the next position is the first.
  void reset() noexcept {
    count_ = regular_ = 0;
    pending_ = 0;
  }
  /// The next position, in the frame of the encoders, mm, measured `elapsedS` after the last one; the velocity, mm/s,
  /// zero at the first. Positions that come together (less than a tenth of a period) count as one: between them steps
  /// of the encoder look like speed.
  Vec3d add(const Vec3d& position, double elapsedS = kOnePeriod) ARGIL_REALTIME;

 private:
  Vec3d measure(const Vec3d& position, double periods) ARGIL_REALTIME;

  double periodS_, margin_, smoothing_;
  int longest_;
  std::array<Vec3d, kWindow + 1> ring_;
  std::array<double, kWindow + 1> took_;  // Periods from the position before to this one.
  int regular_ = 0;                       // So many of the newest positions came one period after another.
  double pending_ = 0;                    // Periods of positions that were passed over.
  Vec3d velocity_ = Vec3d::Zero();
  int newest_ = 0, count_ = 0;
};

}  // namespace argil::haptics
