#include "haptics/devices/hid_descriptor.h"

#include <algorithm>
#include <array>

namespace argil::haptics {
namespace {

constexpr uint32_t kMostBits = 8 * 4096;  // Of a report: the kernel takes no longer ones.
constexpr size_t kMostFields = 1024;
constexpr size_t kMostArrays = 64;
constexpr size_t kMostPushes = 16;

struct Globals {
  uint16_t page = 0;
  int32_t least = 0;
  int64_t most = 0;
  uint32_t bits = 0, count = 0;
  uint8_t report = 0;
};

struct Locals {
  std::vector<uint32_t> usages;  // Page above, usage below.
  uint32_t first = 0;
};

int32_t signedOf(uint32_t value, size_t bytes) {
  if (bytes == 1) return static_cast<int8_t>(value);
  if (bytes == 2) return static_cast<int16_t>(value);
  return static_cast<int32_t>(value);
}

}  // namespace

std::optional<HidInputs> parseHidDescriptor(std::span<const uint8_t> d, std::string& sentence) {
  const auto refuse = [&](const char* what) {
    sentence = std::string("its report descriptor ") + what;
    return std::nullopt;
  };
  HidInputs inputs;
  Globals g;
  Locals l;
  std::vector<Globals> stack;
  std::array<uint32_t, 256> used{};  // Bits of each report so far.
  size_t at = 0;
  while (at < d.size()) {
    const uint8_t prefix = d[at++];
    if (prefix == 0xFE) {  // A long item: its length, its tag, its data. None is defined.
      if (at >= d.size()) return refuse("is cut short");
      at += 2u + d[at];
      continue;
    }
    const size_t bytes = (prefix & 3) == 3 ? 4 : prefix & 3;
    if (at + bytes > d.size()) return refuse("is cut short");
    uint32_t value = 0;
    for (size_t i = 0; i < bytes; ++i) value |= uint32_t{d[at + i]} << (8 * i);
    at += bytes;
    switch (prefix & 0xFC) {
      case 0x04:
        g.page = static_cast<uint16_t>(value);
        break;
      case 0x14:
        g.least = signedOf(value, bytes);
        break;
      case 0x24:
        g.most = g.least < 0 ? int64_t{signedOf(value, bytes)} : int64_t{value};
        break;
      case 0x74:
        g.bits = value;
        break;
      case 0x84:
        g.report = static_cast<uint8_t>(value);
        inputs.numbered = true;
        break;
      case 0x94:
        g.count = value;
        break;
      case 0xA4:
        if (stack.size() >= kMostPushes) return refuse("is beyond all bounds");
        stack.push_back(g);
        break;
      case 0xB4:
        if (stack.empty()) return refuse("pops what was never pushed");
        g = stack.back();
        stack.pop_back();
        break;
      case 0x08:
        if (l.usages.size() < kMostFields) l.usages.push_back(bytes == 4 ? value : (uint32_t{g.page} << 16 | value));
        break;
      case 0x18:
        l.first = bytes == 4 ? value : (uint32_t{g.page} << 16 | value);
        break;
      case 0x28: {
        const uint32_t last = bytes == 4 ? value : (uint32_t{g.page} << 16 | value);
        for (uint32_t u = l.first; u <= last && l.usages.size() < kMostFields; ++u) l.usages.push_back(u);
        break;
      }
      case 0x80: {  // Input.
        if (g.count > kMostBits || g.bits > kMostBits || uint64_t{g.count} * g.bits + used[g.report] > kMostBits)
          return refuse("is beyond all bounds");
        const bool constant = value & 1, variable = value & 2;
        if (!constant && !variable && g.bits >= 1 && g.bits <= 32 && g.count > 0 && !l.usages.empty()) {
          if (inputs.arrays.size() >= kMostArrays || g.count > kMostFields) return refuse("is beyond all bounds");
          inputs.arrays.push_back({g.report, used[g.report], g.count, static_cast<uint8_t>(g.bits), g.least,
                                   static_cast<int32_t>(std::min<int64_t>(g.most, INT32_MAX)), l.usages});
        }
        for (uint32_t i = 0; i < g.count; ++i, used[g.report] += g.bits) {
          if (constant || !variable || g.bits < 1 || g.bits > 32 || l.usages.empty()) continue;
          if (inputs.fields.size() >= kMostFields) return refuse("is beyond all bounds");
          // More values than usages: the last usage goes on.
          const uint32_t usage = l.usages[std::min<size_t>(i, l.usages.size() - 1)];
          inputs.fields.push_back({g.report, used[g.report], static_cast<uint8_t>(g.bits),
                                   static_cast<uint16_t>(usage >> 16), static_cast<uint16_t>(usage), g.least,
                                   static_cast<int32_t>(std::min<int64_t>(g.most, INT32_MAX))});
        }
        l = {};
        break;
      }
      case 0x90:  // Output, feature, collection and its end: locals do not live beyond a main item.
      case 0xB0:
      case 0xA0:
      case 0xC0:
        l = {};
        break;
      default:
        break;
    }
  }
  if (inputs.fields.empty() && inputs.arrays.empty()) return refuse("names no input");
  return inputs;
}

std::optional<int32_t> hidValue(const HidField& field, std::span<const uint8_t> payload) noexcept {
  if (uint64_t{field.bit} + field.bits > 8 * uint64_t{payload.size()}) return std::nullopt;
  uint64_t value = 0;
  const size_t first = field.bit / 8, last = (field.bit + field.bits - 1u) / 8;
  for (size_t i = first; i <= last; ++i) value |= uint64_t{payload[i]} << (8 * (i - first));
  value >>= field.bit % 8;
  value &= (uint64_t{1} << field.bits) - 1;
  if (field.least < 0 && (value >> (field.bits - 1) & 1)) value -= uint64_t{1} << field.bits;
  return static_cast<int32_t>(value);
}

}  // namespace argil::haptics
