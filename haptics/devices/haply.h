#pragma once
// Haply Inverse3: a force-feedback arm on a USB serial line, and its stylus grip on another.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "haptics/base/device.h"

namespace argil::haptics {

struct HaplyOptions {
  std::string port = "/dev/ttyACM0";
  std::string grip = {};  ///< Serial line of the stylus grip or its receiver; empty: none, the stylus does not turn.
  /// Centre of the workspace in the arm's own frame, whose origin is at its mounting plate.
  Vec3d centreMm = {0, -150, 150};
  bool realtime = true;  ///< Ask for SCHED_FIFO for the devices' threads.
};

/// Starts the arm's thread, and the grip's; a device that is not there yet is used as soon as it is. Throws Error for
/// options out of range, never for a device that is absent.
[[nodiscard]] std::unique_ptr<Device> openHaply(const HaplyOptions& options);

[[nodiscard]] const DeviceSheet& haplySheet();

/// The packet that sets the force on the hand, N in the arm's frame: opcode, then three little-endian floats. The arm
/// holds it until the next one.
[[nodiscard]] std::array<uint8_t, 13> haplyForcePacket(const Vec3d& forceN) noexcept;
[[nodiscard]] std::span<const std::byte> haplyZeroPacket() noexcept;

}  // namespace argil::haptics
