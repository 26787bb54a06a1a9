#pragma once
// Stability measured in closed loop, in virtual time: the real servo tick, real clay, a simulated device, a simulated
// hand.

#include <span>

#include "haptics/contact/coupling.h"
#include "haptics/devices/simulated.h"

namespace argil::haptics {

/// How the tool is held. A name and a model; `none` is pushed by a constant force alone.
struct StabilityHand {
  const char* name;
  HandModel model;
};
[[nodiscard]] std::span<const StabilityHand> stabilityHands();  ///< none, light, firm.

/// What the hand does at a flat piece of clay.
enum class StabilityTask : uint8_t {
  grasp,  ///< Puts the tool on and presses.
  tap,    ///< Hits it three times and stays.
  glide,  ///< Presses and moves along it.
  grow,   ///< Presses; then 1 mm of clay grows under the tool.
};
[[nodiscard]] const char* name(StabilityTask task) noexcept;
inline constexpr StabilityTask kStabilityTasks[] = {StabilityTask::grasp, StabilityTask::tap, StabilityTask::glide,
                                                    StabilityTask::grow};

struct StabilityCase {
  DeviceSheet sheet;
  double rateHz = 1000;
  HandModel hand;  ///< All zero: none.
  StabilityTask task = StabilityTask::grasp;
  Coupling coupling;       ///< Of any size, whatever the sheet's top.
  bool controlled = true;  ///< With passivity control.
  double delayS = 0;       ///< From command to motor.
  /// Above 0: through a ThreadedDevice that exchanges so often, on a time of its own that drifts against the servo's:
  /// `delayS` is then how long an exchange takes, its middle the moment when it measures and its force begins. The
  /// servo measures the delay itself and couples to it: `coupling` is not looked at.
  double exchangesHz = 0;
  bool encoderSteps = true;  ///< False: positions are exact, and the servo knows that.
};

/// Quiet: the tool swings by no more than kQuietCycleMm across the clay, and the force changes by no more than
/// kQuietJump of the peak from tick to tick, over the last kJudgedS of the task, motions over. While gliding the
/// encoders must step: there, one step's worth of the spring is allowed on top of the jump.
struct StabilityFigures {
  double cycleMm = 0;   ///< Peak to peak of the tool's true place across the clay in 0.1 s, the largest.
  double jumpN = 0;     ///< Largest change of the commanded force in a tick.
  double givenNmm = 0;  ///< Work of the motor on the tool, less what the mechanism dissipated, over the whole task.
  double peakN = 0;
  double startCycleMm = 0, endCycleMm = 0;  ///< The same in the first and in the last 0.1 s of what is judged.
  double delayS = 0;                        ///< What the servo took the loop's delay for in the end.
  double stiffnessNmm = 0;                  ///< What it coupled at.
  bool stopped = false;                     ///< Safety latched.
  bool quiet = false;
  /// Nothing that swings goes on: what is left in the end is below kStableCycleMm or has faded since kJudgedS before.
  [[nodiscard]] bool stable() const noexcept {
    return !stopped && (endCycleMm <= kStableCycleMm || endCycleMm < kStableFade * startCycleMm);
  }
  static constexpr double kStableCycleMm = 0.03, kStableFade = 0.7;
};
inline constexpr double kQuietCycleMm = 0.010, kQuietJump = 0.01, kJudgedS = 0.4;

/// Runs one task, 1.5 to 2 s of virtual time. Throws Error for numbers out of range.
[[nodiscard]] StabilityFigures runStability(const StabilityCase& what);

/// The largest stiffness, N/mm, such that it and all smaller ones on a ladder are quiet; between 0.5 and 200, to 4 %.
/// 0: not even the smallest. The coupling's own stiffness is not looked at.
[[nodiscard]] double largestQuietStiffness(StabilityCase what);

/// Contacts one after another: a hand taps `contacts` times.
struct ContactEnergy {
  uint64_t contacts = 0;
  double workNmm = 0;  ///< Σ f·Δx of the motor over all contacts; below zero: the hand paid.
  /// What reached the hand in those contacts that gave: the motor's work less the mechanism's losses.
  double givenNmm = 0;
  double worstNmm = 0;  ///< The largest work of the motor in one contact.
};
[[nodiscard]] ContactEnergy energyOfContacts(const StabilityCase& what, uint64_t contacts);

}  // namespace argil::haptics
