#pragma once
// Devices that plugins brought.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/base/device.h"

namespace argil::haptics {

struct AddedDevice {
  std::string name;  ///< What openDevice() takes.
  std::string what;  ///< In words.
  DeviceSheet sheet;
  std::function<std::unique_ptr<Device>()> open;  ///< Throws Error.
};

/// One that has its name already stays as it is. For the life of the program; any thread.
void addDevice(AddedDevice device);
[[nodiscard]] std::vector<AddedDevice> addedDevices();

}  // namespace argil::haptics
