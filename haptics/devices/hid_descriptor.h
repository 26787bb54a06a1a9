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
  uint8_t report = 0;  ///< Report id; 0 where the device does not number its reports.
  uint32_t bit = 0;    ///< Of the report, after the id's byte.
  uint8_t bits = 0;    ///< 1 to 32.
  uint16_t page = 0, usage = 0;
  int32_t least = 0, most = 0;  ///< Logical range.
};

/// Several values of one report that each name something that is on, such as a button that is held: `usages[value -
/// least]`; a value out of the range names nothing.
struct HidArray {
  uint8_t report = 0;
  uint32_t bit = 0, count = 0;  ///< Of the first value, and how many follow one another.
  uint8_t bits = 0;             ///< Of each, 1 to 32.
  int32_t least = 0, most = 0;
  std::vector<uint32_t> usages;  ///< Page above, usage below.
};

/// The input fields of a descriptor; constants only take their room.
struct HidInputs {
  bool numbered = false;  ///< Each report begins with its id.
  std::vector<HidField> fields;
  std::vector<HidArray> arrays;
};

/// Reads a report descriptor (HID 1.11, section 6.2.2). Nothing, and a sentence, when it is cut short, beyond all
/// bounds or holds no input. Whether a field is called relative is not told: SpaceNavigators call their absolute values
/// so.
[[nodiscard]] std::optional<HidInputs> parseHidDescriptor(std::span<const uint8_t> descriptor, std::string& sentence);

/// The usages (page above, usage below) that an array names in a report's bytes after the id are handed to `each`.
/// False when the report is too short.
template <class Each>
[[nodiscard]] bool hidHeld(const HidArray& array, std::span<const uint8_t> payload, Each&& each);

/// The value of a field in a report's bytes after the id; nothing when the report is too short. Signed where the range
/// is.
[[nodiscard]] std::optional<int32_t> hidValue(const HidField& field, std::span<const uint8_t> payload) noexcept;

template <class Each>
bool hidHeld(const HidArray& array, std::span<const uint8_t> payload, Each&& each) {
  for (uint32_t i = 0; i < array.count; ++i) {
    const std::optional<int32_t> value =
        hidValue({array.report, array.bit + i * array.bits, array.bits, 0, 0, array.least, array.most}, payload);
    if (!value) return false;
    if (*value < array.least || *value > array.most) continue;
    const auto index = static_cast<size_t>(int64_t{*value} - array.least);
    if (index < array.usages.size()) each(array.usages[index]);
  }
  return true;
}

}  // namespace argil::haptics
