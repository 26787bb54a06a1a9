#pragma once
// An Inverse3 and a stylus grip, byte for byte, on pseudo-terminals.

#include <atomic>

#include "pty_emulator.h"

namespace argil::haptics::testing {

/// The arm: wake and force are all it understands. Metres and newtons, as the real one. It has no watchdog: a force
/// stays.
class HaplyArmEmulator final : public PtyEmulator {
 public:
  /// `centreMm` is what the driver takes as the middle of the workspace.
  explicit HaplyArmEmulator(const Vec3d& centreMm) : centreMm_(centreMm) {}
  ~HaplyArmEmulator() override { stop(); }

 protected:
  size_t answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) override;
  void spoil(Misbehaviour what, std::vector<uint8_t>& out) override;

 private:
  Vec3d centreMm_;
};

/// The grip: turned by a quarter about z; its buttons are the hand's.
class HaplyGripEmulator final : public PtyEmulator {
 public:
  ~HaplyGripEmulator() override { stop(); }
  /// Before each state comes one of another time, in which these buttons were held: a line that was held up.
  void lateButtons(int buttons) { late_.store(buttons); }

 protected:
  size_t answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) override;
  void spoil(Misbehaviour what, std::vector<uint8_t>& out) override;

 private:
  std::atomic<int> late_{-1};
};

}  // namespace argil::haptics::testing
