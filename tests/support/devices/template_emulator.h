#pragma once
// The made-up arm of haptics/devices/driver_template.h, on a pseudo-terminal.

#include <cmath>

#include "pty_emulator.h"

namespace argil::haptics::testing {

class TemplateEmulator final : public PtyEmulator {
 public:
  ~TemplateEmulator() override { stop(); }

 protected:
  size_t answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) override {
    if (in[0] != 'F') return 1;
    if (in.size() < 8) return 0;
    if (check(in.first(7)) == in[7]) {
      Vec3d force;
      for (size_t a = 0; a < 3; ++a)
        force[static_cast<int>(a)] = static_cast<int16_t>(in[1 + 2 * a] | in[2 + 2 * a] << 8) / 1000.0;
      motors(force);
    }
    out = {'P'};
    for (int a = 0; a < 3; ++a) {
      const auto steps = static_cast<int16_t>(std::lround(100 * hand.positionMm[a]));
      out.push_back(static_cast<uint8_t>(steps));
      out.push_back(static_cast<uint8_t>(steps >> 8));
    }
    out.push_back(static_cast<uint8_t>(hand.buttons));
    out.push_back(check(out));
    return 8;
  }
  void spoil(Misbehaviour what, std::vector<uint8_t>& out) override {
    if (what == Misbehaviour::wrongEcho)
      out[0] = 'Q';
    else
      out[8] = static_cast<uint8_t>(out[8] ^ 1);  // Integers are never not finite: a wrong sum is its like.
  }

 private:
  static uint8_t check(std::span<const uint8_t> bytes) {
    uint8_t sum = 0;
    for (uint8_t b : bytes) sum = static_cast<uint8_t>(sum ^ b);
    return sum;
  }
};

}  // namespace argil::haptics::testing
