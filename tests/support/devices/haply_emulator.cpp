#include "haply_emulator.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace argil::haptics::testing {
namespace {

void put(std::vector<uint8_t>& out, float value) {
  uint8_t bytes[4];
  std::memcpy(bytes, &value, 4);
  out.insert(out.end(), bytes, bytes + 4);
}

}  // namespace

size_t HaplyArmEmulator::answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) {
  if (in[0] == 0x0A) {  // Who it is: id, model, hardware, firmware, a long id.
    out = {0x0B, 0x34, 0x12, 3, 1, 7};
    out.resize(22, 0x5A);
    return 1;
  }
  if (in[0] != 0x2A) return 1;  // What it does not know it passes over.
  if (in.size() < 13) return 0;
  float f[3];
  std::memcpy(f, &in[1], sizeof f);
  motors(Vec3d(f[0], f[1], f[2]));
  out = {0x2B};
  const Vec3d metres = (hand.positionMm + centreMm_) / 1000;
  for (int a = 0; a < 3; ++a) put(out, static_cast<float>(metres[a]));
  for (int a = 0; a < 3; ++a) put(out, 0.01f);
  return 13;
}

void HaplyArmEmulator::spoil(Misbehaviour what, std::vector<uint8_t>& out) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  if (what == Misbehaviour::wrongEcho)
    out[0] = 0x2C;
  else if (out.size() >= 9)
    std::memcpy(&out[5], &nan, 4);
}

size_t HaplyGripEmulator::answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) {
  if (in[0] == 0x0A) {
    out = {0xD0, 0, 0x78, 0x56, 1, 1, 1};
    return 1;
  }
  if (in[0] != 0xDB) return 1;
  if (in.size() < 4 || in.size() < 4u + in[3]) return 0;
  const auto say = [&](uint8_t buttons) {
    out.insert(out.end(), {0xDA, 0x78, 0x56});
    for (float q : {std::sqrt(0.5f), 0.0f, 0.0f, std::sqrt(0.5f)}) put(out, q);  // w first.
    out.insert(out.end(), {0, 42, 1, buttons});
  };
  if (const int late = late_.load(); late >= 0) say(static_cast<uint8_t>(late));
  say(static_cast<uint8_t>(hand.buttons));
  return 4u + in[3];
}

void HaplyGripEmulator::spoil(Misbehaviour what, std::vector<uint8_t>& out) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  if (what == Misbehaviour::wrongEcho)
    out[0] = 0xDF;
  else if (out.size() >= 7)
    std::memcpy(&out[3], &nan, 4);
}

}  // namespace argil::haptics::testing
