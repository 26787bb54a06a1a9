#pragma once
// Energy: what the scene gives to the hand is watched, and what it should not have given is damped away.

#include <array>
#include <cstddef>

#include "haptics/base/device.h"
#include "haptics/base/realtime.h"
#include "haptics/base/tick_clock.h"

namespace argil::haptics {

/// A bounded store of energy for effects that push by themselves: clay that grows, wells. They draw from it; what the
/// person loses to the scene fills it, and a trickle does, so that clay that grows is never without any push. N·mm,
/// which is mJ.
class EnergyTank {
 public:
  /// Begins full. `trickleNmmS`: per second.
  EnergyTank(double capacityNmm, double trickleNmmS)
      : capacity_(capacityNmm), trickle_(trickleNmmS), level_(capacityNmm) {}
  /// What does not fit is gone.
  void fill(double energyNmm) ARGIL_REALTIME {
    level_ += energyNmm < capacity_ - level_ ? energyNmm : capacity_ - level_;
  }
  void pass(double seconds) ARGIL_REALTIME { fill(trickle_ * seconds); }
  /// As much of `wantedNmm` as there is.
  double draw(double wantedNmm) ARGIL_REALTIME {
    const double granted = wantedNmm < level_ ? wantedNmm : level_;
    level_ -= granted;
    return granted;
  }
  [[nodiscard]] double levelNmm() const noexcept { return level_; }
  [[nodiscard]] double capacityNmm() const noexcept { return capacity_; }
  [[nodiscard]] double trickleNmmS() const noexcept { return trickle_; }
  void reset() noexcept { level_ = capacity_; }

 private:
  double capacity_, trickle_, level_;
};

/// Time-domain passivity observer and controller (Hannaford & Ryu 2002) with the energy of the scene's springs as
/// reference: at each tick what the hand has put in must cover what they hold now. What a sampled and held force leaks
/// is seen in the tick in which it leaks and damped along the force in the next ones; while nothing leaks the force
/// comes out bit for bit as it came in. All in the device's frame. One thread, the servo's. Recipe and figures:
/// stability.md.
class Passivity {
 public:
  /// `delayS`: from command to motor, as far as it is known; 0 to 15 ms. Throws Error for others.
  Passivity(const DeviceSheet& sheet, double periodS, double delayS = 0);

  /// From now on; longer ones count as 15 ms. Keeps all that it knows.
  void setDelay(double delayS) ARGIL_REALTIME;

  struct Input {
    Vec3d position = Vec3d::Zero();  ///< As measured in this tick, mm.
    Vec3d velocity = Vec3d::Zero();  ///< Filtered, mm/s.
    Vec3d force = Vec3d::Zero();     ///< What contact asks for, N, without damping.
    double storedNmm = 0;            ///< What its springs hold now.
    double dampingNsmm = 0;          ///< Of the coupling: added along the force in any case.
    bool active = false;             ///< The scene moves by itself: its work is paid from the tank.
    double elapsedS = kOnePeriod;    ///< Since the last tick.
  };
  /// The force to go on with: as it came, or with damping along it; never turned round. An active scene pushes no
  /// harder than what the tank and the hand have paid for.
  Vec3d apply(const Input& input) ARGIL_REALTIME;
  /// What was commanded to the device in this tick after all, `elapsedS` after the last one. Once a tick, also when
  /// apply() was not called.
  void commanded(const Vec3d& force, double elapsedS = kOnePeriod) ARGIL_REALTIME;
  /// The device did not answer, or the scene let go: the next position is a first one. Keeps the tank.
  void interrupt() ARGIL_REALTIME { known_ = false; }
  /// Begins anew, the tank full.
  void reset() noexcept;

  /// Energy that leaked and is not yet damped away, N·mm.
  [[nodiscard]] double lackingNmm() const noexcept { return lacking_; }
  /// Damping that the last apply() added to the coupling's, N·s/mm.
  [[nodiscard]] double addedNsmm() const noexcept { return added_; }
  [[nodiscard]] const EnergyTank& tank() const noexcept { return tank_; }

 private:
  Vec3d acted(double elapsedS) const ARGIL_REALTIME;
  static double speedAlong(const Input& in) ARGIL_REALTIME;
  Vec3d damped(const Input& in) const ARGIL_REALTIME;
  void control(const Input& in, double spring, double elapsedS, double holds) ARGIL_REALTIME;

  static constexpr size_t kHistory = 128;  // 15 ms at 8 kHz.
  double periodS_, slow_, delayS_, lateS_, most_, mostLacking_, hold_, forget_;
  size_t lateTicks_;
  double lateRest_;
  std::array<Vec3d, kHistory> commands_;
  std::array<double, kHistory> heldS_;  // How long each was the newest one; of the newest itself not yet known.
  size_t newest_ = 0, regular_ = 0;     // So many of them, the newest apart, were held for one period.
  EnergyTank tank_;
  bool known_ = false;
  Vec3d position_ = Vec3d::Zero();
  double paid_ = 0;     // What the hand and the tank have put in and not got back.
  bool owing_ = false;  // The scene's springs hold more than that since it moved by itself.
  double lacking_ = 0, added_ = 0;
};

}  // namespace argil::haptics
