#pragma once
// A SpaceMouse in either of its layouts, with the descriptors of real ones, at the far end of a socket that keeps reports apart.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "device_rig.h"
#include "haptics/devices/spacemouse.h"

namespace argil::haptics::testing {

/// A report each 8 ms while deflected, one of rest afterwards, nothing then; buttons when they change.
class SpaceMouseEmulator {
 public:
  enum class Layout { twoReports, oneReport };
  explicit SpaceMouseEmulator(Layout layout);
  ~SpaceMouseEmulator();
  SpaceMouseEmulator(const SpaceMouseEmulator&) = delete;
  SpaceMouseEmulator& operator=(const SpaceMouseEmulator&) = delete;

  /// What the driver opens: as often as it likes.
  [[nodiscard]] std::unique_ptr<HidSource> source();

  /// Deflection as the device counts it, x y z rx ry rz, −350 to 350.
  void deflect(const std::array<int, 6>& counts);
  void buttons(uint32_t held);
  void plug();
  void unplug();
  void misbehave(Misbehaviour what) { misbehaviour_.store(what); }
  /// The descriptor of a real one: 046d:c626 (two reports, its axes wrongly called relative), 256f:c62e (one).
  [[nodiscard]] static std::span<const uint8_t> descriptor(Layout layout);

 private:
  class Source;
  void run();
  void send(std::vector<uint8_t> report);
  int connect();

  Layout layout_;
  std::mutex mutex_;
  int far_ = -1;        // Ours of the socket's two ends.
  bool plugged_ = true;
  std::array<int, 6> counts_{};
  uint32_t held_ = 0;
  std::atomic<Misbehaviour> misbehaviour_{Misbehaviour::none};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace argil::haptics::testing
