#pragma once
// What a HID device says about its own reports.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace argil::haptics {

/// One value in an input report.
struct HidField {
  uint8_t report = 0;     ///< Report id; 0 where the device does not number its reports.
  uint32_t bit = 0;       ///< Of the report, after the id's byte.
  uint8_t bits = 0;       ///< 1 to 32.
  uint16_t page = 0, usage = 0;
  int32_t least = 0, most = 0;  ///< Logical range.
};

/// The variable input fields of a descriptor; arrays and constants only take their room.
struct HidInputs {
  bool numbered = false;  ///< Each report begins with its id.
  std::vector<HidField> fields;
};

/// Reads a report descriptor (HID 1.11, section 6.2.2). Nothing, and a sentence, when it is cut short, beyond all bounds or holds no
/// input. Whether a field is called relative is not told: SpaceNavigators call their absolute values so.
[[nodiscard]] std::optional<HidInputs> parseHidDescriptor(std::span<const uint8_t> descriptor, std::string& sentence);

/// The value of a field in a report's bytes after the id; nothing when the report is too short. Signed where the range is.
[[nodiscard]] std::optional<int32_t> hidValue(const HidField& field, std::span<const uint8_t> payload) noexcept;

}  // namespace argil::haptics
