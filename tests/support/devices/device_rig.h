#pragma once
// A device driver and what it drives, for the conformance suite: a new driver adds one rig.

#include <cstdint>
#include <memory>

#include "haptics/base/device.h"

namespace argil::haptics::testing {

/// What an emulator does wrong on command. `split` is allowed: a driver must cope with it.
enum class Misbehaviour { none, split, garbage, notFinite, shortAnswers, wrongEcho, late, silent };

/// One device of a kind, at the other end of its emulator. All calls from the test's thread. Has a constant Traits
/// kTraits.
class DeviceRig {
 public:
  virtual ~DeviceRig() = default;

  /// What the suite may expect of this kind.
  struct Traits {
    bool force = false;          ///< It has motors: forceN() tells what they were told.
    bool cable = false;          ///< It can be unplugged and plugged in again.
    bool follows = false;        ///< hand() moves it to a place; otherwise it is where place() says.
    bool bytes = false;          ///< It speaks bytes, right or wrong: misbehave() does something.
    bool silenceIsRest = false;  ///< It says nothing while it is at rest (HID).
    double resolutionMm = 1e-3;
  };
  [[nodiscard]] virtual std::unique_ptr<Device> open() = 0;

  /// Puts the emulated hand there, in the device's frame.
  virtual void hand(const Vec3d& positionMm, uint32_t buttons) = 0;
  [[nodiscard]] virtual Vec3d place() const { return Vec3d::Zero(); }
  /// The last that the motors were told, device's frame.
  [[nodiscard]] virtual Vec3d forceN() const { return Vec3d::Zero(); }
  [[nodiscard]] virtual double peakN() const { return 0; }   ///< The longest ever.
  [[nodiscard]] virtual uint64_t told() const { return 0; }  ///< Forces that reached the motors so far.
  [[nodiscard]] virtual Vec3d toldN(uint64_t) const { return Vec3d::Zero(); }  ///< Each of them, the first is 0.
  /// False where this kind cannot do that wrong.
  virtual bool misbehave(Misbehaviour) { return false; }
  /// How many times longer than a device's own bus this one takes now: an emulated one has no time of its own.
  [[nodiscard]] virtual double slack() const { return 1; }
  virtual void unplug() {}
  virtual void replug() {}
};

}  // namespace argil::haptics::testing
