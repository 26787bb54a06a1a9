#pragma once
// Which devices are plugged in, and opening one by its name.

#include <memory>
#include <string>
#include <vector>

#include "haptics/base/device.h"
#include "haptics/devices/hand_path.h"

namespace argil::haptics {

/// Something plugged in that a driver knows.
struct FoundDevice {
  std::string name;     ///< What openDevice() takes.
  std::string what;     ///< In words, as it calls itself.
  std::string node;     ///< Where it is.
  std::string problem;  ///< What keeps it from being opened and what to do; empty: nothing.
};

/// Looks through sysfs: needs no rights, opens no device. Those of plugins are behind the others (added_devices.h),
/// plugged in or not. Empty where nothing is.
[[nodiscard]] std::vector<FoundDevice> findDevices(const std::string& sys = "/sys", const std::string& dev = "/dev");

struct OpenDeviceOptions {
  HandPathLayout layout;       ///< For "recorded:FILE": with units empty the file has the house's own layout.
  bool loop = false;           ///< Begin a recorded path anew at its end.
  std::string falconFirmware;  ///< For "falcon": setting falcon.firmware; empty: it must be loaded already.
};

/// Opens by name: "falcon" (the first that nobody uses), "falcon:BUS-PORT"; "haply" (the first there is, with its
/// grip), "haply:PORT", "haply:PORT,GRIP"; "spacemouse", "spacemouse:NODE"; "recorded:FILE"; "simulated:SHEET", or the
/// SHEET alone where no hardware has that name: a hand that holds still at the origin. Throws Error that lists the
/// names for an unknown one; a device of a known kind that is not there yet is used as soon as it is.
[[nodiscard]] std::unique_ptr<Device> openDevice(const std::string& name, const OpenDeviceOptions& options = {});

/// The sheet that goes with such a name; opens nothing but a recorded file. Throws as openDevice().
[[nodiscard]] DeviceSheet sheetOfDevice(const std::string& name, const OpenDeviceOptions& options = {});

/// Whether the name stands for motors or sensors that can be touched, not for a simulation or a recording.
[[nodiscard]] bool isHardware(const std::string& name);

}  // namespace argil::haptics
