#include "haptics/servo/heat_budget.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

// Of the heat: over so much of it the limit falls, until then the whole peak is given.
constexpr double kFallShare = 0.2;
constexpr double kSteepest = 0.75;  // Of kLimitStep: how steeply the limit may be planned to fall.

}  // namespace

// limit² = continuous² · (1 + slope · (1 − heat)): the peak's square while the heat is 1 − fall or less, the continuous
// force's at 1. At the limit the heat left shrinks like e^(−(1 + slope) t/τ), so it never runs out, and no memory of
// past forces is needed. The limit falls fastest where it leaves the peak; slow servos get a wider fall so that this is
// below kLimitStep.
HeatBudget::HeatBudget(const DeviceSheet& sheet, double periodS)
    : peak_(sheet.peakForceN),
      continuous_(sheet.pointing ? 0 : std::min(sheet.continuousForceN, sheet.peakForceN)),
      thermalS_(sheet.thermalSeconds),
      periodS_(periodS),
      blend_(1 - std::exp(-periodS / sheet.thermalSeconds)),
      limit_(peak_) {
  if (!(continuous_ > 0)) return;
  const double ratio = peak_ * peak_ / (continuous_ * continuous_);
  const double fall = blend_ * (ratio - 1) * (ratio - 1) / (2 * ratio) / (kSteepest * kLimitStep);
  slope_ = (ratio - 1) / std::clamp(fall, kFallShare, 1.0);
}

double HeatBudget::wanted() const ARGIL_REALTIME {
  return std::min(peak_, continuous_ * std::sqrt(1 + slope_ * std::max(0.0, 1 - heat_)));
}

void HeatBudget::felt(const Vec3d& commandedN, double elapsedS) ARGIL_REALTIME {
  if (!(continuous_ > 0)) return;  // No motors.
  const bool regular = elapsedS == kOnePeriod || elapsedS == periodS_;
  if (!regular && !(elapsedS > 0)) return;
  // Exact for a force that is held, however long.
  const double blend = regular ? blend_ : 1 - std::exp(-elapsedS / thermalS_);
  heat_ += blend * (commandedN.squaredNorm() / (continuous_ * continuous_) - heat_);
  const double step = kLimitStep * peak_ * (regular ? 1.0 : elapsedS / periodS_);
  limit_ = std::clamp(wanted(), limit_ - step, limit_ + step);
}

void HeatBudget::begin(double load, double restedS) noexcept {
  if (!(continuous_ > 0)) return;
  heat_ = std::clamp(load, 0.0, 1.0) * std::exp(-std::max(0.0, restedS) / thermalS_);
  limit_ = wanted();
}

}  // namespace argil::haptics
