#pragma once
// A Falcon that does not exist: its FTDI chip, boot loader, firmware and arm, byte for byte, which misbehave on
// command.

#include <array>
#include <cstdint>
#include <deque>
#include <mutex>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "device_rig.h"
#include "haptics/devices/byte_transport.h"
#include "haptics/devices/falcon_kinematics.h"

namespace argil::haptics::testing {

enum class FalconFault {
  none,
  split,         ///< Answers come five bytes a packet.
  shortPackets,  ///< Answers end after nine bytes.
  garbage,       ///< Bytes of any value instead of answers.
  littered,      ///< Answers whole, garbage before each: a driver must find them.
  late,          ///< Answers 20 ms late.
  silent,        ///< No answers.
  stall,         ///< The OUT endpoint halts at every packet.
};

/// Bus side: what a host controller would call. Hand side: what a person does, and what they feel. Any thread.
class FalconEmulator {
 public:
  /// `firmware`: what must be loaded before it runs. Begins loaded and homed, its grip in the middle.
  explicit FalconEmulator(std::vector<uint8_t> firmware) : firmware_(std::move(firmware)) {}

  // Hand side.
  void hand(const Vec3d& positionMm, uint8_t rawButtons);
  void setHomed(bool homed);
  void powerCycle();     ///< Firmware and homing are lost, motors off.
  void loadElsewhere();  ///< Another program loads and homes it.
  void misbehave(FalconFault fault);
  void wrongEchoes(int count);      ///< So many bytes of the firmware come back wrong.
  void ignoreGreetings(int count);  ///< The boot loader is deaf to so many.
  /// Clear to send so long after it followed to loading speed; what comes before is lost.
  void setClearAfterNs(int64_t ns);
  void unplug();
  void replug();
  [[nodiscard]] Vec3d forceN() const;    ///< Of the motors on the hand, device's frame.
  [[nodiscard]] double peakN() const;    ///< The longest ever.
  [[nodiscard]] uint8_t lights() const;  ///< The byte of LEDs and homing as last sent, without the 0x41.
  [[nodiscard]] bool running() const;
  [[nodiscard]] uint64_t packets() const;           ///< Whole ones taken while running.
  [[nodiscard]] Vec3d toldN(uint64_t which) const;  ///< The force that each of them asked for.
  /// Every control request so far: number, value.
  [[nodiscard]] std::vector<std::pair<uint8_t, uint16_t>> requests() const;

  // Bus side.
  [[nodiscard]] bool plugged() const;
  [[nodiscard]] uint64_t plugging() const;  ///< Counts up with every unplugging: what was opened before is gone.
  void control(uint8_t request, uint16_t value);
  [[nodiscard]] bool out(std::span<const uint8_t> bytes);  ///< False: the endpoint halted.
  /// The next IN packet at that time, its two status bytes first; 0 when there is none yet.
  [[nodiscard]] size_t in(std::array<uint8_t, 64>& packet, int64_t atNs);

 private:
  enum class Mode { boot, greeted, loading, loaded, running };
  struct Chunk {
    int64_t dueNs;
    std::vector<uint8_t> bytes;
  };

  void take(uint8_t byte, int64_t atNs);
  void command(int64_t atNs);
  void answer(std::vector<uint8_t> bytes, int64_t dueNs);
  [[nodiscard]] Vec3d force() const;

  mutable std::mutex mutex_;
  std::vector<uint8_t> firmware_;
  Mode mode_ = Mode::running;
  bool plugged_ = true, homed_ = true, dtr_ = false;
  uint64_t plugging_ = 0;
  uint16_t divisor_ = 0x2;
  int64_t latencyNs_ = 16'000'000, clearAfterNs_ = 3'000'000, clearAtNs_ = 0, lastInNs_ = 0, wireFreeNs_ = 0;
  FalconFault fault_ = FalconFault::none;
  int wrongEchoes_ = 0, deaf_ = 0;
  size_t streamed_ = 0;
  bool broken_ = false;
  std::vector<uint8_t> taken_;
  std::deque<Chunk> answers_;
  std::vector<std::pair<uint8_t, uint16_t>> requests_;
  std::mt19937 random_{7};

  Vec3d position_ = Vec3d::Zero();
  uint8_t buttons_ = 0, lights_ = 0;
  std::array<int, 3> motors_{};
  double peakN_ = 0;
  std::vector<Vec3d> toldN_;  // One a packet.
};

/// What the conformance suite asks for; false where a Falcon cannot do that wrong while it runs.
[[nodiscard]] bool misbehave(FalconEmulator& falcon, Misbehaviour what);

/// The emulator at the other end of a short wire, without a bus between: for timing.
class FalconLine final : public ByteTransport {
 public:
  explicit FalconLine(FalconEmulator& emulator) : emulator_(emulator) {}
  Opening open() override;
  void close() noexcept override { open_ = false; }
  [[nodiscard]] std::string sentence() const override;
  Transfer control(FtdiRequest request, uint16_t value) override;
  Transfer write(std::span<const uint8_t> bytes, int64_t timeoutNs) override;
  Transfer read(std::span<uint8_t> into, size_t& count, int64_t timeoutNs) override;
  [[nodiscard]] bool clearToSend() const noexcept override { return clearToSend_; }

 private:
  [[nodiscard]] bool gone() const { return !open_ || emulator_.plugging() != opened_; }

  FalconEmulator& emulator_;
  bool open_ = false, clearToSend_ = false;
  uint64_t opened_ = 0;
};

}  // namespace argil::haptics::testing
