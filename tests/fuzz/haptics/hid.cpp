// What a HID device says of its reports, and reports. The first byte says where one ends and the other begins.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "haptics/devices/hid_descriptor.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace argil;
  if (size == 0) return 0;
  const std::span<const uint8_t> bytes(data + 1, size - 1);
  const size_t split = std::min<size_t>(data[0], bytes.size());
  std::string sentence;
  const auto inputs = haptics::parseHidDescriptor(bytes.subspan(split), sentence);
  tests::require(inputs ? !inputs->fields.empty() || !inputs->arrays.empty() : !sentence.empty());
  if (!inputs) return 0;
  for (const haptics::HidField& field : inputs->fields) {
    tests::require(field.bits >= 1 && field.bits <= 32);
    (void)haptics::hidValue(field, bytes.first(split));
  }
  for (const haptics::HidArray& array : inputs->arrays) {
    tests::require(array.bits >= 1 && array.bits <= 32 && array.count > 0 && !array.usages.empty());
    uint32_t named = 0;
    (void)haptics::hidHeld(array, bytes.first(split), [&](uint32_t) { ++named; });
    tests::require(named <= array.count);
  }
  return 0;
}
