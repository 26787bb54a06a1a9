#pragma once
// What a stop, a resume and a change of device do to a servo, in the order that loses no stop.

#include <cstdint>

#include "haptics/base/force_gate.h"

namespace argil::engine {

/// What the caller of a resume had seen: it undoes no stop and no fault that came after.
struct SeenStops {
  haptics::ForceGate::Generation user = 0;
  uint32_t faults = 0;  ///< Of the servo of that time; 0 without one.
};

// The zero itself is the gate's, from the moment of the stop. These follow on the thread that owns the servo, which may
// be busy for long: whatever came meanwhile is in the gate. `Servo` is haptics::Servo, or a stand-in of the tests with
// its stop(), reset(), start() and faults().

/// After ForceGate::stop(user): a servo whose force is held at zero need not turn.
template <class Servo>
void restStopped(const haptics::ForceGate& gate, Servo& servo) {
  if (gate.stoppedBy(haptics::StopOwner::user)) servo.stop();
}

/// A resume whose caller had seen `seen`: true when the servo began anew. One that came before the last stop leaves all
/// as it is.
template <class Servo>
bool resumeSeen(haptics::ForceGate& gate, const SeenStops& seen, Servo& servo) {
  if (!gate.resume(haptics::StopOwner::user, seen.user)) {
    restStopped(gate, servo);
    return false;
  }
  servo.stop();
  if (servo.faults() == seen.faults) servo.reset();
  // A stop that came since then holds the gate: the servo turns without force until its own restStopped().
  servo.start();
  return true;
}

/// A servo that takes the place of another: a stop outlives the device that it was meant for. True when the servo
/// began.
template <class Servo>
bool beginUnlessStopped(const haptics::ForceGate& gate, Servo& servo) {
  if (gate.stoppedBy(haptics::StopOwner::user)) return false;
  servo.start();
  return true;
}

}  // namespace argil::engine
