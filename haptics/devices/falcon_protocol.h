#pragma once
// The bytes that a Falcon speaks: its packets, and how its firmware is loaded.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptics/base/realtime.h"
#include "haptics/devices/byte_transport.h"
#include "haptics/devices/falcon_kinematics.h"

namespace argil::haptics {

inline constexpr uint16_t kFalconVendor = 0x0403, kFalconProduct = 0xcb48;
inline constexpr int kFalconMotorLimit = 4096;
inline constexpr uint8_t kFalconLedRed = 0x02, kFalconLedGreen = 0x04, kFalconLedBlue = 0x08;
/// Asks the firmware to look for the arms' stops. Published sources disagree (0x01 or 0x10): to be checked on hardware.
inline constexpr uint8_t kFalconHomingBit = 0x01;
inline constexpr uint8_t kFalconAllHomed = 7;

struct FalconCommand {
  std::array<int, 3> motors{};  ///< −4096 to 4096; what is beyond is cut there.
  uint8_t leds = 0;             ///< Sum of kFalconLed…
  bool homing = false;
};
struct FalconReply {
  FalconCounts counts{};
  uint8_t buttons = 0;  ///< 1 right, 2 forward, 4 centre, 8 left.
  uint8_t homed = 0;    ///< A bit an arm.
};

/// '<', three motors as four nibbles each, LEDs, a filler, '>'; each byte between raised by 0x41, low nibble first.
using FalconPacket = std::array<uint8_t, 16>;
[[nodiscard]] FalconPacket encodeFalcon(const FalconCommand& command) ARGIL_REALTIME;

/// Finds replies in a stream of bytes that may be split anywhere and hold garbage. Never fails: what is no packet is
/// dropped.
class FalconDecoder {
 public:
  /// True when `byte` ends a whole, well-formed packet, which is then in `reply`.
  bool feed(uint8_t byte, FalconReply& reply) ARGIL_REALTIME;
  void reset() noexcept { size_ = 0; }
  /// Bytes that were part of no packet, since construction.
  [[nodiscard]] uint64_t dropped() const noexcept { return dropped_; }

 private:
  FalconPacket packet_{};
  size_t size_ = 0;
  uint64_t dropped_ = 0;
};

/// Latency 1 ms, 1.5 Mbaud, buffers empty: how a Falcon whose firmware runs is spoken to.
Transfer enterFalconRunningMode(ByteTransport& transport);

/// The firmware file that a person gives (Argil ships none: it is not free). Throws Error when the path is empty or the
/// file is missing, empty or larger than any firmware of a Falcon.
[[nodiscard]] std::vector<uint8_t> readFalconFirmware(const std::string& path);

/// Puts firmware into a Falcon, step by step, so that whoever drives it can stop in between: boot handshake at 9600
/// baud, faster line, the file in pieces of 62 bytes whose echo is compared, running mode. An attempt that fails is
/// begun anew from the start.
class FalconLoader {
 public:
  enum class Progress : uint8_t { loading, done, failed, gone };

  /// Both must outlive it.
  FalconLoader(ByteTransport& transport, std::span<const uint8_t> firmware)
      : transport_(transport), firmware_(firmware) {}

  /// One exchange: at most half a second. After done, failed or gone it is over.
  Progress step();
  /// What went wrong last, in words.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }
  /// The boot loader answered in this attempt: there is one.
  [[nodiscard]] bool greeted() const noexcept { return stage_ != Stage::setUp && stage_ != Stage::greet; }
  /// Whole attempts begun.
  [[nodiscard]] int attempts() const noexcept { return attempts_; }
  /// Bytes of the firmware that came back right in this attempt.
  [[nodiscard]] size_t loaded() const noexcept { return loaded_; }

 private:
  enum class Stage : uint8_t { setUp, greet, speedUp, stream, run };

  Progress failed(Transfer result, const std::string& problem);
  Progress setUp();
  Progress greet();
  Progress speedUp();
  Progress stream();
  /// Reads until `into` is full; timeout when it takes longer than `timeoutNs`.
  Transfer readAll(std::span<uint8_t> into, int64_t timeoutNs);

  ByteTransport& transport_;
  std::span<const uint8_t> firmware_;
  Stage stage_ = Stage::setUp;
  int attempts_ = 0, greetings_ = 0;
  size_t loaded_ = 0;
  std::string problem_;
  std::array<uint8_t, 64> read_{};  // Bytes that came with the last packet beyond what was asked for.
  size_t readBegin_ = 0, readEnd_ = 0;
};

}  // namespace argil::haptics
