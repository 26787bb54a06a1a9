#pragma once
// Capability sheets of the devices that the simulated one can stand for.

#include <span>
#include <string_view>

#include "haptics/base/device.h"

namespace argil::haptics {

/// Every sheet, in the order in which `argil devices` lists them.
[[nodiscard]] std::span<const DeviceSheet> deviceSheets();
/// The sheet of that name ("touch", "touchx", "premium15", "falcon", "omega3", "haply"); throws Error that lists the
/// names otherwise.
[[nodiscard]] const DeviceSheet& deviceSheet(std::string_view name);

}  // namespace argil::haptics
