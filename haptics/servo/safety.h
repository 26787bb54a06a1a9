#pragma once
// The last stop before the motor.

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

#include "haptics/base/device.h"
#include "haptics/base/realtime.h"
#include "haptics/base/tick_clock.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {

inline constexpr double kFadeSeconds = 0.020;  ///< From a fault to zero force, at most.
inline constexpr int kRawOverTicks = 5;        ///< So many commands over twice the peak in a row are a fault.
inline constexpr double kRawOverFactor = 2.0;
/// Zero to peak force in no less: steep enough for a hand that hits a wall at 0.5 m/s.
inline constexpr double kSlewPeakSeconds = 0.002;
inline constexpr double kStartFraction = 0.1;  ///< Forces begin once the command is below this part of the peak.
/// After a shorter interruption they come back by themselves: a surprised hand takes 0.15 s and more to let go.
inline constexpr double kAwaySeconds = 0.1;
inline constexpr double kReturnSeconds = 0.05;  ///< From zero to the peak then.
inline constexpr int kSpeedTicks = 8;  ///< Device speed is judged over so many positions: one glitch is not a speed.
/// From its origin (a recorded path has its own): a device that says more says garbage.
inline constexpr double kFarthestMm = 10'000;
/// A servo silent for so long is dead: zero within 20 ms with the watchdog's own period.
inline constexpr double kWatchdogSeconds = 0.015;

/// Why the output is latched at zero.
enum class Fault : uint8_t { none, notFinite, commandTooLarge, tooFast, implausible };
[[nodiscard]] const char* sentence(Fault fault) noexcept;

/// What Safety counts as time.
struct TickTimes {
  double tickS = kOnePeriod;      ///< Since the tick before.
  double measuredS = kOnePeriod;  ///< From the position before to this one; 0: it is the same measurement.
};

/// Every command passes here: whatever comes in, what goes out is finite, no longer than the sheet's peak, and changes
/// by no more than the slew limit a period. A fault fades the force within kFadeSeconds to a latched stop. One thread.
/// A mouse or a pen (DeviceSheet::pointing) has no motor that could hurt: it is limited alike, and never stopped,
/// whatever it does.
class Safety {
 public:
  /// `periodS`: time between ticks.
  Safety(const DeviceSheet& sheet, double periodS);

  /// The force to command, N, in the device's frame, and what was done to it in `flags` (kClamped, kWarm, kSlewed,
  /// kStale, kStopped, kWaiting, kReturning, kCut). `fresh`: the device answered in this tick; if not, or if what it
  /// answered is no place, zero at once. `mostN`: a limit below the peak, that of the heat budget. Ticks that come
  /// together share the slew limit of their period; late ones get no more than that of one, but fade by as much as
  /// their time asks for. `shut`: the gate is, zero at once. How long an answer fails or a gate is shut, interrupt() is
  /// told.
  Vec3d apply(const Vec3d& raw, const DeviceState& state, bool fresh, uint32_t& flags,
              double mostN = std::numeric_limits<double>::infinity(), const TickTimes& times = {},
              bool shut = false) ARGIL_REALTIME;
  /// Whether the device can be there: finite, and no farther than kFarthestMm (a pointer may be anywhere).
  [[nodiscard]] bool plausible(const DeviceState& state) const ARGIL_REALTIME;
  /// Fades to a latched stop for a reason found elsewhere.
  void trip(Fault fault) ARGIL_REALTIME;

  /// Any thread.
  [[nodiscard]] Fault fault() const noexcept { return fault_.load(std::memory_order_relaxed); }
  /// Grows with every fault: a reset names what its caller had seen. Any thread.
  [[nodiscard]] uint32_t faults() const noexcept { return faults_.load(); }
  /// The output was zero for a while whatever was commanded: start gently again, as from the beginning. Keeps a fault.
  void restart() ARGIL_REALTIME;
  /// The output was or is zero for `seconds` more (a late tick, a watchdog, a silent device): forces that had begun
  /// come back by themselves, or begin anew when they have been away for kAwaySeconds. Keeps a fault.
  void interrupt(double seconds) ARGIL_REALTIME;
  /// Forces have begun, and are not on their way back: what is touched is felt as it is.
  [[nodiscard]] bool felt() const ARGIL_REALTIME { return start_ == Start::felt; }
  /// Leaves the latched stop: starts anew, waiting for a force in range. Not while the servo runs.
  void reset() noexcept;

  /// Largest change of force in a period, N.
  [[nodiscard]] double slewStepN() const noexcept { return slewStep_; }

 private:
  bool tooFast(const Vec3d& position, double measuredS) ARGIL_REALTIME;

  bool motor_;
  double periodS_, peak_, slewStep_, fadeStep_, fastMm_, fastMms_;
  Vec3d last_ = Vec3d::Zero();
  std::array<Vec3d, kSpeedTicks> trail_;
  std::array<double, kSpeedTicks> took_;  // Seconds from the position before to this one.
  int trailCount_ = 0, trailNext_ = 0, regular_ = 0;
  int rawOver_ = 0;
  enum class Start : uint8_t { waiting, returning, felt };
  Start start_ = Start::waiting;
  double awayS_ = 0;      // Since a force was last let through.
  double returnedS_ = 0;  // Since forces began to come back.
  std::atomic<Fault> fault_{Fault::none};
  std::atomic<uint32_t> faults_{0};
};

/// Tells that a servo still lives. beat() from the servo, the rest from any thread.
class Heartbeat {
 public:
  void beat(double nowS) ARGIL_REALTIME { last_.store(nowS, std::memory_order_relaxed); }
  [[nodiscard]] bool silent(double nowS) const noexcept {
    return nowS - last_.load(std::memory_order_relaxed) > kWatchdogSeconds;
  }

 private:
  std::atomic<double> last_{0};
};

/// Shuts the gate while a servo is silent. It undoes its own stops alone. One thread, not the servo's.
class Watchdog {
 public:
  /// A look at `nowS`: true when the servo fell silent since the last one.
  bool look(const Heartbeat& heart, ForceGate& gate, double nowS) noexcept;
  /// The servo was stopped by whoever had the right to: nothing is held any more.
  void end(ForceGate& gate) noexcept;
  [[nodiscard]] bool holds() const noexcept { return holds_; }

 private:
  bool holds_ = false;
  ForceGate::Generation mine_ = 0;
};

}  // namespace argil::haptics
