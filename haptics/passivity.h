#pragma once
// Energy: what the scene gives to the hand is watched, and what it should not have given is damped away.

#include <array>
#include <cstddef>

#include "haptics/device.h"
#include "haptics/realtime.h"

namespace argil::haptics {

/// A bounded store of energy for effects that push by themselves: clay that grows, wells. They draw from it, what the person
/// puts in fills it. N·mm, which is mJ.
class EnergyTank {
 public:
  explicit EnergyTank(double capacityNmm) : capacity_(capacityNmm), level_(capacityNmm) {}
  /// What does not fit is gone.
  void fill(double energyNmm) ARGIL_REALTIME { level_ += energyNmm < capacity_ - level_ ? energyNmm : capacity_ - level_; }
  /// As much of `wantedNmm` as there is.
  double draw(double wantedNmm) ARGIL_REALTIME {
    const double granted = wantedNmm < level_ ? wantedNmm : level_;
    level_ -= granted;
    return granted;
  }
  [[nodiscard]] double levelNmm() const noexcept { return level_; }
  [[nodiscard]] double capacityNmm() const noexcept { return capacity_; }
  void reset() noexcept { level_ = capacity_; }

 private:
  double capacity_, level_;
};

/// Time-domain passivity observer and controller (Hannaford & Ryu 2002) with the energy of the coupling's spring as reference: at
/// each tick the energy that the hand has put in must cover what the spring now holds. What a sampled and held force leaks is
/// seen in the tick in which it leaks, and damped along the force in the next ones. What the mechanism itself dissipates (the
/// sheet's damping and friction) may leak: so nothing at all is done below the bounds of Colgate and Brown and of Diolaiti, and the
/// force comes out bit for bit as it came in. All in the device's frame. One thread, the servo's.
class Passivity {
 public:
  /// `delayS`: from command to motor, as far as it is known; 0 to 15 ms. Throws Error for others.
  Passivity(const DeviceSheet& sheet, double periodS, double delayS = 0);

  struct Input {
    Vec3d position = Vec3d::Zero();   ///< As measured in this tick, mm.
    Vec3d velocity = Vec3d::Zero();   ///< Filtered, mm/s.
    Vec3d force = Vec3d::Zero();      ///< What contact asks for, N.
    double storedNmm = 0;             ///< What its springs hold now.
    double dampingNsmm = 0;           ///< Of the coupling: added along the force in any case.
    bool active = false;              ///< The scene moves by itself: its work is paid from the tank.
  };
  /// The force to go on with: as it came, or with damping along it; never turned round. What the tank does not pay for an
  /// active scene is taken from the force.
  Vec3d apply(const Input& input) ARGIL_REALTIME;
  /// What was commanded to the device in this tick after all. Call once a tick, also when apply() was not called.
  void commanded(const Vec3d& force) ARGIL_REALTIME;
  /// The device did not answer, or the scene let go: the next position is a first one. Keeps the tank.
  void interrupt() ARGIL_REALTIME { known_ = false; }
  /// Begins anew, the tank full.
  void reset() noexcept;

  /// Energy that leaked and is not yet damped away, N·mm.
  [[nodiscard]] double lackingNmm() const noexcept { return lacking_; }
  /// Damping that the last apply() added, N·s/mm.
  [[nodiscard]] double addedNsmm() const noexcept { return added_; }
  [[nodiscard]] const EnergyTank& tank() const noexcept { return tank_; }

 private:
  static double speedAlong(const Input& in) ARGIL_REALTIME;
  Vec3d damped(const Input& in) const ARGIL_REALTIME;
  Vec3d acted() const ARGIL_REALTIME;

  static constexpr size_t kHistory = 128;  // 15 ms at 8 kHz.
  double periodS_, damping_, friction_, most_, hold_, forget_, mostLacking_;
  size_t lateTicks_;
  double lateRest_;
  std::array<Vec3d, kHistory> commands_;
  size_t newest_ = 0;
  EnergyTank tank_;
  bool known_ = false;
  Vec3d position_ = Vec3d::Zero();
  double paid_ = 0;      // Of the spring's energy, what the hand put in.
  double lacking_ = 0, added_ = 0;
};

}  // namespace argil::haptics
