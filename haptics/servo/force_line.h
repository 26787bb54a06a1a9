#pragma once
// The way of a force from the servo to the thread that hands it to the motor.

#include "haptics/base/force_gate.h"
#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"
#include "haptics/threads/latest_value.h"

namespace argil::haptics {

/// The newest command, with the gate's word from when its tick began. A command whose tick began before a stop never
/// comes out, also not after the resume: the servo begins anew from zero then.
class ForceLine {
 public:
  /// The servo's thread, as its tick begins.
  void begin(const ForceGate& gate) ARGIL_REALTIME { word_ = gate.word(); }
  /// The servo's thread, as its tick ends. `atNs`: when that is.
  void put(const Vec3d& forceN, int64_t atNs = 0) ARGIL_REALTIME { commands_.store({forceN, word_, atNs}); }

  /// The device's thread: takes the newest command; true when it is a new one.
  bool take() noexcept { return commands_.load(command_); }
  /// The device's thread: when the command that was taken last was put.
  [[nodiscard]] int64_t putNs() const noexcept { return command_.atNs; }
  /// The device's thread: what may go to the motor now. The look at the gate is the last step before.
  [[nodiscard]] Vec3d allowed(const ForceGate& gate) const noexcept {
    const ForceGate::Word now = gate.word();
    return ForceGate::open(now) && now == command_.word ? command_.forceN : Vec3d(Vec3d::Zero());
  }

 private:
  struct Command {
    Vec3d forceN = Vec3d::Zero();
    ForceGate::Word word = 0;
    int64_t atNs = 0;
  };
  LatestValue<Command> commands_;
  ForceGate::Word word_ = 0;  // The servo's.
  Command command_;           // The device thread's.
};

}  // namespace argil::haptics
