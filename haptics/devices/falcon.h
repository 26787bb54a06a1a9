#pragma once
// Novint Falcon: a force-feedback delta robot on USB.

#include <memory>
#include <string>
#include <vector>

#include "haptics/base/device.h"
#include "haptics/devices/byte_transport.h"
#include "haptics/devices/usb_transport.h"

namespace argil::haptics {

struct FalconOptions {
  std::string where;  ///< USB place as findFalcons() names it; empty: the first that nobody else uses.
  /// The firmware file that the person has (setting falcon.firmware); empty: it must be loaded already.
  std::string firmware;
  bool realtime = true;  ///< Ask for SCHED_FIFO for the device's thread.
};

/// Those that are plugged in now. Throws Error when USB cannot be used at all.
[[nodiscard]] std::vector<UsbPlace> findFalcons();

/// Starts the device's thread; a Falcon that is not there yet, is not homed or has no firmware yet is used as soon as
/// it can be, and status() says what it waits for. Frame: origin in the middle of the workspace, x to the right, y up,
/// z towards the person. Buttons: 1 the centre one, 2 right, 4 forward, 8 left. Throws Error for a firmware file that
/// is given and cannot be used, never for a device that is absent.
[[nodiscard]] std::unique_ptr<Device> openFalcon(const FalconOptions& options);
/// The same over another transport (`where` is not used): emulators, other buses.
[[nodiscard]] std::unique_ptr<Device> openFalcon(const FalconOptions& options,
                                                 std::unique_ptr<ByteTransport> transport);

/// For whoever outlives a driver that died: sends zero force to every Falcon that nobody holds open. How many took it.
/// Never throws; returns within 100 ms a device.
int zeroFalcons() noexcept;

}  // namespace argil::haptics
