#pragma once
// A SpaceMouse in either of its layouts, with the descriptors of real ones, at the far end of a socket that keeps
// reports apart.

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
  /// `receiver`: five interfaces, each with the descriptor of one report, of which only one (speaks()) ever says
  /// anything. `buttonArray`: one report for the axes, and buttons as a list of those that are held.
  enum class Layout { twoReports, oneReport, receiver, buttonArray };
  explicit SpaceMouseEmulator(Layout layout);
  ~SpaceMouseEmulator();
  SpaceMouseEmulator(const SpaceMouseEmulator&) = delete;
  SpaceMouseEmulator& operator=(const SpaceMouseEmulator&) = delete;

  /// What the driver opens: as often as it likes.
  [[nodiscard]] std::unique_ptr<HidSource> source();

  /// Deflection as the device counts it, x y z rx ry rz, −350 to 350.
  void deflect(const std::array<int, 6>& counts);
  void buttons(uint32_t held);
  void speaks(size_t interface);                  ///< Of a receiver: to which of its five the puck is paired.
  void second(const std::array<int, 6>& counts);  ///< Deflection of a second puck, on the interface after that.
  void talksWithoutEnd(bool endless);             ///< Reports as fast as they are taken.
  void plug();
  void unplug();
  void misbehave(Misbehaviour what) { misbehaviour_.store(what); }
  /// The descriptor of a real one: 046d:c626 (two reports, its axes wrongly called relative), 256f:c62e (one).
  [[nodiscard]] static std::span<const uint8_t> descriptor(Layout layout);

 private:
  class Source;
  void run();
  bool send(std::vector<uint8_t> report, size_t puck = 0);
  std::vector<int> connect();

  Layout layout_;
  std::mutex mutex_;
  std::vector<int> far_;  // Ours of the sockets' two ends.
  size_t speaks_ = 0;
  std::atomic<bool> endless_{false};
  bool plugged_ = true;
  std::array<int, 6> counts_{}, second_{};
  uint32_t held_ = 0;
  std::atomic<Misbehaviour> misbehaviour_{Misbehaviour::none};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace argil::haptics::testing
