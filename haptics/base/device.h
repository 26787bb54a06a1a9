#pragma once
// What a force-feedback device is to the servo.

#include <atomic>
#include <cstdint>
#include <string>

#include "haptics/base/force_gate.h"
#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

enum class Handedness : uint8_t { either, left, right };

/// Capability sheet: what a device can do. Contact, coupling and safety take every limit from here.
struct DeviceSheet {
  std::string name;                     ///< Short name, as in `argil devices`.
  std::string like;                     ///< What it stands for, in words.
  int dofIn = 3;                        ///< Degrees of freedom measured: 3 or 6.
  int dofOut = 3;                       ///< Degrees of freedom driven: 0, 3 or 6.
  Vec3d workspaceMm = {100, 100, 100};  ///< Edges of the reachable box, centred on the device's origin.
  double peakForceN = 3;                ///< Largest force that may be commanded, as a vector's length.
  double continuousForceN = 1;          ///< What it holds without overheating.
  double thermalSeconds = 10;     ///< Time constant of its motors' heat; no maker says it: a guess of the usual size.
  double resolutionMm = 0.05;     ///< One encoder step at the tip.
  double topStiffnessNmm = 1;     ///< Largest stiffness that it renders at 1 kHz.
  double topDampingNsmm = 0.002;  ///< Largest damping that it renders at 1 kHz, N·s/mm.
  double topSpeedMms = 2000;      ///< Faster than a hand moves it: a fault.
  double rateHz = 1000;           ///< Highest rate of exchanges.
  int buttons = 2;
  Handedness handedness = Handedness::either;
  /// Mouse or pen: no hand feels the clay, so every tool works at once, exactly where it points.
  bool pointing = false;

  // What the simulated device is made of; drivers of real ones leave these as they are.
  double massKg = 0.045;        ///< Moving mass at the tip.
  double frictionN = 0.1;       ///< Coulomb friction.
  double dampingNsmm = 0.0005;  ///< Viscous friction of the mechanism, N·s/mm.
};

/// What a device says in a tick, in its own frame.
struct DeviceState {
  Pose pose;             ///< mm.
  float pressure = 0;    ///< 0 to 1; 1 with a button held where the device cannot tell.
  uint32_t buttons = 0;  ///< Bit a button.
  double ageS = 0;       ///< How long before read() the pose was measured; 0: in read() itself.
};

/// A device as the servo sees it. A driver that waits for its bus does so on a thread of its own and hands over through
/// LatestValue; read() and write() themselves never wait. The servo is their only caller, with times that never
/// decrease.
class Device {
 public:
  virtual ~Device() = default;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Constant for the life of the device.
  [[nodiscard]] virtual const DeviceSheet& sheet() const noexcept = 0;

  /// State at servo time `timeS`; false when nothing new came (the servo then commands zero). A device that answers at
  /// its own rate is new until its next answer is late; one that is unplugged, faulty or silent never is.
  virtual bool read(double timeS, DeviceState& state) ARGIL_REALTIME = 0;
  /// Commands a force on the hand in the device's frame, N. Finite, within the sheet.
  virtual void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME = 0;

  /// While it is shut the motors get zero, whatever write() says. Any thread. A device that passes on to another gives
  /// that one's gate.
  [[nodiscard]] virtual ForceGate& gate() const noexcept { return *gate_.load(); }
  /// From now on `gate` in place of the device's own, so that whoever stopped the device before this one need not stop
  /// this one too. Before its servo starts; `gate` must outlive the device.
  void setGate(ForceGate& gate) noexcept { gate_.store(&gate); }

  /// How late a force acts on a state that was measured, seconds: from the state's measurement to the tick that reads
  /// it, and from that tick's command to the motors. 0 where read() measures and write() acts at once. Changes slowly.
  /// Any thread; real-time safe.
  [[nodiscard]] virtual double delayS() const ARGIL_REALTIME { return 0; }

  /// What it does or what ails it and what to do, one sentence for the person. Any thread but the servo's: it
  /// allocates.
  [[nodiscard]] virtual std::string status() const { return sheet().name + ": ready"; }

 private:
  ForceGate own_;
  std::atomic<ForceGate*> gate_{&own_};
};

}  // namespace argil::haptics
