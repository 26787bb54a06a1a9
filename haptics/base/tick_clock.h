#pragma once
// How much time a tick stands for: the time that passed, not the number of ticks.

#include <cmath>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Stands for "one period of the servo" wherever elapsed seconds are asked for.
inline constexpr double kOnePeriod = -1;
/// A servo or a device thread that comes so late may find the motors zeroed, by the watchdog or by the guard process.
inline constexpr double kStallSeconds = 0.012;

/// Elapsed time from tick to tick. A tick on time counts as exactly one period, so that virtual time and a regular
/// servo give the same bits as counting ticks. One thread, the servo's.
class TickClock {
 public:
  explicit TickClock(double periodS) : periodS_(periodS) {}

  struct Step {
    double heldS = 0;  ///< Since the tick before: how long the last command was in force. 0 at the first tick.
    /// What is integrated: heldS, at least kLeast of a period. One period at the first tick and after a gap.
    double seconds = 0;
    bool gap = false;  ///< Over a period and kStallSeconds: nothing may be concluded from what lies before it.
    bool first = false;
    /// For laws that take kOnePeriod for "as usual": a first tick is one.
    [[nodiscard]] double elapsedS() const ARGIL_REALTIME { return first ? kOnePeriod : heldS; }
  };
  /// The tick at `timeS`. Time that stands still, runs backwards or is no number counts as next to nothing.
  Step next(double timeS) ARGIL_REALTIME {
    const double elapsed = timeS - lastS_;
    const bool first = !begun_;
    begun_ = true;
    if (std::isfinite(timeS)) lastS_ = timeS;
    if (first) return {0, periodS_, false, true};
    if (std::abs(elapsed - periodS_) <= kOnTimeS) return {periodS_, periodS_, false, false};
    if (!(elapsed > 0)) return {0, kLeast * periodS_, false, false};
    if (elapsed > periodS_ + kStallSeconds) return {elapsed, periodS_, true, false};
    return {elapsed, elapsed > kLeast * periodS_ ? elapsed : kLeast * periodS_, false, false};
  }
  /// The next tick is a first one.
  void reset() noexcept { begun_ = false; }

 private:
  // Above the rounding of hours counted in seconds, far below what a clock resolves in use.
  static constexpr double kOnTimeS = 1e-9;
  static constexpr double kLeast = 0.02;  // Of a period: laws of contact divide by the time of a tick.

  double periodS_, lastS_ = 0;
  bool begun_ = false;
};

}  // namespace argil::haptics
