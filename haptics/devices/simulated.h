#pragma once
// A force-feedback device that does not exist, held by a hand that does not exist either.

#include <array>

#include "haptics/base/device.h"
#include "haptics/devices/hand_path.h"
#include "haptics/threads/latest_value.h"

namespace argil::haptics {

/// A hand as a mass, a damper and a spring that ties the stylus to the place where the hand wants to be.
struct HandModel {
  double massKg = 0.1;         ///< Moves with the stylus.
  double dampingNsmm = 0.005;  ///< N·s/mm.
  double stiffnessNmm = 0.5;   ///< N/mm; 0 for a hand that only pushes (HandPoint::forceN).
};

/// Mass, damping and Coulomb friction of the sheet, encoder steps, actuator limit, a delay of whole or fractional ticks
/// between command and motor, commands held between ticks; integrated at a fixed fine step. Deterministic: the same
/// calls give the same bits. Model and sources: NOTES.md, "Simulated device".
class SimulatedDevice final : public Device {
 public:
  struct Options {
    HandModel hand;
    double delayS = 0;         ///< From write() to the motor: 0 to 15 ms.
    double fineStepS = 5e-5;   ///< Integration step: 1e-6 to 1e-3 s.
    bool encoderSteps = true;  ///< False: positions are exact, to judge contact alone.
    bool prescribed = false;   ///< The stylus is on the path, whatever the force: an infinitely strong hand.
  };

  /// `path` is in the device's frame. Throws Error for an option out of range.
  SimulatedDevice(DeviceSheet sheet, HandPath path, const Options& options);
  /// The same with default options.
  SimulatedDevice(DeviceSheet sheet, HandPath path) : SimulatedDevice(std::move(sheet), std::move(path), Options()) {}

  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override;
  void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME override;

  /// From now on the hand wants to be there, in the device's frame, instead of on its path: somebody moves it, as with
  /// a mouse. It goes there at 800 mm/s at most, so that a cursor that jumps is no fault. One thread, which may run
  /// beside the servo's.
  void steer(const HandPoint& wanted) noexcept { steered_.store(wanted); }
  /// The same, and the stylus is there already. Before the servo starts.
  void startAt(const Vec3d& position) noexcept;

  // For tests and plots; the servo's thread or after it stopped.
  [[nodiscard]] const Vec3d& position() const noexcept { return position_; }  ///< Before the encoders, mm.
  [[nodiscard]] const Vec3d& velocity() const noexcept { return velocity_; }  ///< mm/s.
  [[nodiscard]] const Vec3d& motorForce() const noexcept { return motor_; }   ///< N, after delay and limit.
  /// Kinetic and spring energy of device and hand, N·mm.
  [[nodiscard]] double energyNmm() const noexcept;

 private:
  void advance(double timeS) ARGIL_REALTIME;
  void step(double timeS) ARGIL_REALTIME;

  struct Command {
    double dueS = 0;
    Vec3d force = Vec3d::Zero();
    ForceGate::Word word = 0;  // Of the gate when its tick began.
  };
  static constexpr size_t kCommands = 128;  // 15 ms of commands at 8 kHz.

  DeviceSheet sheet_;
  HandPath path_;
  Options options_;
  ForceGate::Word word_ = 0;  // Of the gate when this tick began.
  std::array<Command, kCommands> commands_;
  size_t firstCommand_ = 0, commandCount_ = 0;
  uint64_t stepsDone_ = 0;
  size_t hint_ = 0;
  HandPoint wanted_;
  LatestValue<HandPoint> steered_;
  HandPoint steeredTo_;
  bool isSteered_ = false;
  Vec3d position_ = Vec3d::Zero(), velocity_ = Vec3d::Zero(), motor_ = Vec3d::Zero();
  ForceGate::Word motorWord_ = 0;
};

}  // namespace argil::haptics
