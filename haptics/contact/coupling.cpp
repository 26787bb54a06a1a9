#include "haptics/contact/coupling.h"

#include <algorithm>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

// Of 2b/T: how much farther passivity control carried all devices, rates and delays (haptics/servo/stability.md).
constexpr double kCarried = 1.2;
// The same of a device that exchanges once in more than so many ticks of the servo.
constexpr double kCarriedRare = 0.4;
constexpr double kRareTicks = 2.01;
// Of what passivity control could hold: the rest is for what the sheet does not say.
constexpr double kReserve = 0.8;
constexpr double kStepReserve = 0.75;  // Of what friction could hold at rest: along the clay it holds less across it.
// Of the sheet's top damping. With more of it the steps of the encoders shake a tool that glides.
constexpr double kDampingFraction = 0.2;

}  // namespace

CouplingBounds couplingBounds(const DeviceSheet& sheet, double periodS, double delayS) {
  if (!(periodS >= 1.0 / 8001 && periodS <= 0.01)) throw Error("coupling: the rate must be 100 to 8000 Hz");
  if (!(delayS >= 0 && delayS <= 0.015)) throw Error("coupling: the delay must be 0 to 0.015 s");
  // A force held for T acts half a period late on average, and by the delay later than that. What exchanges more slowly
  // than the servo turns holds it for longer.
  const double heldS = sheet.rateHz > 0 ? std::max(periodS, 1 / sheet.rateHz) : periodS;
  const double lateS = 0.5 * heldS + delayS;
  CouplingBounds bounds;
  bounds.colgateBrownNmm = sheet.dampingNsmm / lateS;
  bounds.quantizationNmm = sheet.resolutionMm > 0 ? 2 * sheet.frictionN / sheet.resolutionMm : 1e9;
  bounds.controlledNmm = (sheet.dampingNsmm + sheet.topDampingNsmm) / lateS;
  return bounds;
}

Coupling coupleTo(const DeviceSheet& sheet, double periodS, double delayS, bool controlled) {
  const CouplingBounds bounds = couplingBounds(sheet, periodS, delayS);
  // Positions that come in steps of several ticks look like leaps: passivity control helps less than it harms.
  const bool rare = sheet.rateHz > 0 && 1 / sheet.rateHz > kRareTicks * periodS;
  const double carried = (rare ? kCarriedRare : kCarried) * bounds.colgateBrownNmm;
  const double stable = controlled ? std::min(kReserve * bounds.controlledNmm, carried) : bounds.colgateBrownNmm;
  Coupling coupling;
  coupling.stiffnessNmm = std::min({sheet.topStiffnessNmm, stable, kStepReserve * bounds.quantizationNmm});
  coupling.dampingNsmm = controlled ? kDampingFraction * sheet.topDampingNsmm : 0;
  return coupling;
}

}  // namespace argil::haptics
