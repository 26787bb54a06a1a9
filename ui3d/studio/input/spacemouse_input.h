#pragma once
// A 3D mouse that moves the view.

#include <array>
#include <memory>
#include <optional>

namespace argil::haptics {
class Device;
}

namespace argil::studio {

/// Reads the first SpaceMouse that is plugged in, also one that comes later. Without one it costs a look into sysfs
/// every two seconds. One thread.
class SpaceMouseInput {
 public:
  SpaceMouseInput();
  ~SpaceMouseInput();
  SpaceMouseInput(const SpaceMouseInput&) = delete;
  SpaceMouseInput& operator=(const SpaceMouseInput&) = delete;

  /// Six axes, −1 to 1: translation right, up, towards the person; rotation about these. Nothing while it rests or is
  /// not there.
  [[nodiscard]] std::optional<std::array<float, 6>> poll(double nowS);
  [[nodiscard]] bool there() const { return device_ != nullptr; }
  /// Lets go of it: it is the stylus now. Taken up again with `free`.
  void yield(bool free);

 private:
  std::unique_ptr<haptics::Device> device_;
  double lookedS_ = -1e9, lastS_ = -1;
  bool free_ = true;
  std::array<double, 7> before_{};  // Place and rotation (x, y, z, w) of the last reading.
};

}  // namespace argil::studio
