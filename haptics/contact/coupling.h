#pragma once
// How stiff a device may be coupled to the scene.

#include "haptics/base/device.h"

namespace argil::haptics {

/// The virtual coupling between hand and proxy: a spring with a damper along it.
struct Coupling {
  double stiffnessNmm = 1;  ///< K at the hand, N/mm.
  double dampingNsmm = 0;   ///< B at the hand, N·s/mm.
};

/// Largest stiffness at the hand that theory allows, N/mm (Colgate and Brown 1994; Diolaiti et al. 2006), whatever the
/// sheet's top.
struct CouplingBounds {
  double colgateBrownNmm = 0;  ///< 2b/T, and less with a delay: passive in the hands of anybody without any control.
  /// 2c/Δ (Diolaiti): above it encoder steps feed an oscillation that friction does not stop.
  double quantizationNmm = 0;
  double controlledNmm = 0;  ///< Where the damping of passivity control, held to the sheet's top damping, is used up.
};

/// `periodS`: of the servo, 1/8000 to 1/100 s; a device whose sheet names a lower rate holds forces for as long as
/// that. `delayS`: of the whole loop, from a state's measurement to the force that answers it (Device::delayS), 0 to 15
/// ms. Throws Error for others.
[[nodiscard]] CouplingBounds couplingBounds(const DeviceSheet& sheet, double periodS, double delayS = 0);

/// The stiffest coupling for a rate and a delay that stays quiet, and its damper; K never above the sheet's top, B
/// never above its top damping. `controlled`: with passivity control (haptics/servo/passivity.h); without, the bounds
/// of theory hold.
[[nodiscard]] Coupling coupleTo(const DeviceSheet& sheet, double periodS, double delayS = 0, bool controlled = true);

}  // namespace argil::haptics
