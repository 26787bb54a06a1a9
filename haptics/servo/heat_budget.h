#pragma once
// Motors that may push hard for a moment and not for long (I²t).

#include "haptics/base/device.h"
#include "haptics/base/realtime.h"
#include "haptics/base/tick_clock.h"

namespace argil::haptics {

/// First-order model of a winding's heat: q' = (f² − q) / τ, with τ the sheet's thermalSeconds; q is the mean square of
/// the force as the copper remembers it. limitN() is what may be commanded next; who keeps to it never lets √q rise
/// above the sheet's continuous force. Over any window of W seconds the RMS force is at most continuous · √(1 + τ/W).
/// The limit is the peak while the winding is cool, and then falls smoothly, at most kLimitStep of the peak a period,
/// to the continuous force. One thread, the servo's.
class HeatBudget {
 public:
  static constexpr double kLimitStep = 0.02;

  /// `periodS`: time between ticks.
  HeatBudget(const DeviceSheet& sheet, double periodS);

  /// Longest force to command now, N: between the continuous and the peak force.
  [[nodiscard]] double limitN() const ARGIL_REALTIME { return limit_; }
  /// Tells that `commandedN` was in force for `elapsedS`; zero included.
  void felt(const Vec3d& commandedN, double elapsedS = kOnePeriod) ARGIL_REALTIME;
  /// The motors are as warm as load() said when they were used last, `restedS` ago. Not while a servo runs.
  void begin(double load, double restedS) noexcept;
  /// Heat in use, 0 (cold) to 1.
  [[nodiscard]] double load() const ARGIL_REALTIME { return heat_; }

 private:
  double wanted() const ARGIL_REALTIME;

  double peak_, continuous_, thermalS_, periodS_, blend_, slope_ = 0;
  double heat_ = 0;  // q as a share of the continuous force's square.
  double limit_;
};

}  // namespace argil::haptics
