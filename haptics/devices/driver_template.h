#pragma once
// A driver to copy: the numbered steps here, in driver_template.cpp, and at the end of that file.
//
// It drives a made-up arm on a serial line. Request, 8 bytes: 'F', three little-endian int16 of millinewtons, the
// exclusive or of what came before. Answer, 9 bytes: 'P', three int16 of hundredths of a millimetre, the buttons, the
// exclusive or again.

#include <memory>
#include <string>

#include "haptics/base/device.h"

namespace argil::haptics {

// 1. Copy driver_template.h and .cpp to haptics/devices/NAME.h and NAME.cpp and put your device's name for "template".

// 2. What a person may set: each with a default, a unit and a range.
struct TemplateOptions {
  std::string port = "/dev/ttyACM0";
};

// 3. The sheet: contact, coupling and safety take every limit from it. Published figures, or estimates marked as such
// in NOTES.md.
[[nodiscard]] const DeviceSheet& templateSheet();

// 4. One function that opens it. Throws Error for options out of range, never for a device that is absent.
[[nodiscard]] std::unique_ptr<Device> openTemplate(const TemplateOptions& options);

}  // namespace argil::haptics
