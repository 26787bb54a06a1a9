#pragma once
// Friction by holding back the proxy: no velocity of the device is used, so encoder noise cannot excite it.

#include <array>

#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Static, dynamic and viscous friction of a proxy (Ruspini et al. 1997). At rest the proxy stays while the pull along
/// the surface is at most μ_s times the push on it; sliding, it follows until the pull is μ_d times the push, no faster
/// than (pull − μ_d push) / b. One thread.
class Friction {
 public:
  /// What is touched at this tick. Lengths are spring stretches: the force over the stiffness, mm.
  struct Touch {
    Vec3d push = Vec3d::Zero();  ///< From the hand to where the surface holds it: along the normal force.
    double staticMm = 0;         ///< Σ μ_s · share of each plane in the push.
    double dynamicMm = 0;        ///< Σ μ_d · share.
    double viscousNsmm = 0;      ///< Σ b.
    double stiffnessNmm = 1;
    double periodS = 1e-3;
  };

  void reset() noexcept { sliding_ = false; }
  /// The goal that the proxy follows in place of the hand.
  [[nodiscard]] Vec3d goal(const Vec3d& proxy, const Vec3d& hand, const Touch& touch) ARGIL_REALTIME;
  [[nodiscard]] bool sliding() const noexcept { return sliding_; }

 private:
  bool sliding_ = false;
  int restTicks_ = 0;
};

}  // namespace argil::haptics
