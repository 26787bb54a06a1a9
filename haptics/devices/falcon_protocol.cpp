#include "haptics/devices/falcon_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "clay/base/error.h"
#include "haptics/base/clock.h"

namespace argil::haptics {
namespace {

constexpr uint8_t kBegin = '<', kEnd = '>', kRaise = 0x41;
constexpr uint16_t kBootBaud = 0x4138, kLoadBaud = 0x15, kRunBaud = 0x2, k8N1 = 8;
constexpr uint16_t kBootLatencyMs = 16, kRunLatencyMs = 1;  // With less than 16 the boot loader's replies come torn.
constexpr std::array<uint8_t, 3> kGreeting = {0x0a, 0x43, 0x0d};
constexpr std::array<uint8_t, 4> kGreetingReply = {0x0a, 0x44, 0x2c, 0x0d};
constexpr uint8_t kFastByte = 0x41;
constexpr size_t kPiece = 62;  // A packet of the chip less its two status bytes: so an echo fits into one.
constexpr int kMostGreetings = 100;
constexpr int kMostAttempts = 5;
constexpr size_t kMostFirmwareBytes = 1 << 20;  // Known ones have some ten thousand.
constexpr int64_t kMs = 1'000'000;
constexpr int64_t kWriteNs = 200 * kMs;
constexpr int64_t kGreetNs = 50 * kMs;  // 16 ms of latency timer, 8 ms of wire at 9600 baud, and as much again.
constexpr int64_t kClearNs = 400 * kMs;
constexpr int64_t kEchoNs = 400 * kMs;

}  // namespace

FalconPacket encodeFalcon(const FalconCommand& command) ARGIL_REALTIME {
  FalconPacket packet;
  packet.front() = kBegin;
  size_t at = 1;
  for (const int motor : command.motors) {
    const auto bits = static_cast<uint16_t>(std::clamp(motor, -kFalconMotorLimit, kFalconMotorLimit));
    for (int shift = 0; shift < 16; shift += 4) packet[at++] = static_cast<uint8_t>(kRaise + ((bits >> shift) & 0xf));
  }
  packet[at++] = static_cast<uint8_t>(kRaise + command.leds + (command.homing ? kFalconHomingBit : 0));
  packet[at++] = kRaise;
  packet[at] = kEnd;
  return packet;
}

bool FalconDecoder::feed(uint8_t byte, FalconReply& reply) ARGIL_REALTIME {
  const auto drop = [&] {
    dropped_ += size_ + 1;
    size_ = 0;
  };
  // No byte of a packet can be a '<' before the filler, so one there begins a packet.
  if (byte == kBegin && size_ < 14) {
    dropped_ += size_;
    packet_[0] = byte;
    size_ = 1;
    return false;
  }
  if (size_ == 0 || (size_ < 13 && (byte < kRaise || byte > kRaise + 0xf)) ||
      (size_ == 13 && (byte < kRaise || byte > kRaise + 0x7f)) || (size_ == 15 && byte != kEnd)) {
    drop();
    return false;
  }
  packet_[size_++] = byte;
  if (size_ < packet_.size()) return false;
  size_ = 0;
  for (size_t arm = 0; arm < 3; ++arm) {
    unsigned bits = 0;
    for (size_t nibble = 0; nibble < 4; ++nibble)
      bits |= unsigned(packet_[1 + 4 * arm + nibble] - kRaise) << (4 * nibble);
    reply.counts[arm] = static_cast<int16_t>(bits);
  }
  const auto flags = static_cast<uint8_t>(packet_[13] - kRaise);
  reply.buttons = flags & 0xf;
  reply.homed = (flags >> 4) & kFalconAllHomed;
  return true;
}

Transfer enterFalconRunningMode(ByteTransport& transport) {
  const std::pair<FtdiRequest, uint16_t> requests[] = {{FtdiRequest::latencyTimer, kRunLatencyMs},
                                                       {FtdiRequest::baudDivisor, kRunBaud},
                                                       {FtdiRequest::reset, kFtdiPurgeRx},
                                                       {FtdiRequest::reset, kFtdiPurgeTx}};
  for (const auto& [request, value] : requests)
    if (const Transfer result = transport.control(request, value); result != Transfer::ok) return result;
  return Transfer::ok;
}

std::vector<uint8_t> readFalconFirmware(const std::string& path) {
  if (path.empty())
    throw Error(
        "Falcon: no firmware is given: set falcon.firmware to the firmware file of your device (it comes with its "
        "drivers)");
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file)
    throw Error(fmt::format(
        "Falcon: the firmware file '{}' cannot be read ({}): set falcon.firmware to the file of your device", path,
        std::strerror(errno)));
  const auto size = static_cast<int64_t>(file.tellg());
  if (size == 0)
    throw Error(fmt::format("Falcon: the firmware file '{}' is empty: copy it anew from the device's drivers", path));
  if (size < 0 || size > int64_t(kMostFirmwareBytes))
    throw Error(fmt::format(
        "Falcon: '{}' is no firmware of a Falcon, which holds at most {} bytes: set falcon.firmware to the right file",
        path, kMostFirmwareBytes));
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), size);
  if (!file) throw Error(fmt::format("Falcon: the firmware file '{}' cannot be read to its end", path));
  return bytes;
}

FalconLoader::Progress FalconLoader::failed(Transfer result, const std::string& problem) {
  if (result == Transfer::gone) {
    problem_ = "it was unplugged while its firmware was loaded";
    return Progress::gone;
  }
  problem_ = problem + (result == Transfer::stall ? " (the line stalled)" : "");
  stage_ = Stage::setUp;
  return attempts_ < kMostAttempts ? Progress::loading : Progress::failed;
}

Transfer FalconLoader::readAll(std::span<uint8_t> into, int64_t timeoutNs) {
  const int64_t end = nowNs() + timeoutNs;
  for (size_t i = 0; i < into.size();) {
    if (readBegin_ == readEnd_) {
      size_t count = 0;
      const Transfer result = transport_.read(read_, count, std::max<int64_t>(0, end - nowNs()));
      if (result != Transfer::ok) return result;
      readBegin_ = 0;
      readEnd_ = count;
    }
    into[i++] = read_[readBegin_++];
  }
  return Transfer::ok;
}

FalconLoader::Progress FalconLoader::step() {
  switch (stage_) {
    case Stage::setUp:
      return setUp();
    case Stage::greet:
      return greet();
    case Stage::speedUp:
      return speedUp();
    case Stage::stream:
      return stream();
    case Stage::run:
      break;
  }
  const Transfer result = enterFalconRunningMode(transport_);
  return result == Transfer::ok ? Progress::done : failed(result, "its line cannot be set to running speed");
}

FalconLoader::Progress FalconLoader::setUp() {
  ++attempts_;
  greetings_ = 0;
  loaded_ = readBegin_ = readEnd_ = 0;
  const std::pair<FtdiRequest, uint16_t> requests[] = {{FtdiRequest::reset, kFtdiPurgeRx},
                                                       {FtdiRequest::reset, kFtdiPurgeTx},
                                                       {FtdiRequest::latencyTimer, kBootLatencyMs},
                                                       {FtdiRequest::baudDivisor, kBootBaud},
                                                       {FtdiRequest::lineFormat, k8N1},
                                                       {FtdiRequest::flowControl, 0},
                                                       {FtdiRequest::modemLines, kFtdiRtsOff},
                                                       {FtdiRequest::modemLines, kFtdiDtrOff},
                                                       {FtdiRequest::modemLines, kFtdiDtrOn}};
  for (const auto& [request, value] : requests)
    if (const Transfer result = transport_.control(request, value); result != Transfer::ok)
      return failed(result, "its line cannot be set up for loading");
  stage_ = Stage::greet;
  return Progress::loading;
}

FalconLoader::Progress FalconLoader::greet() {
  if (greetings_++ == kMostGreetings) return failed(Transfer::ok, "its boot loader does not answer");
  if (const Transfer result = transport_.write(kGreeting, kWriteNs); result != Transfer::ok)
    return failed(result, "it takes no bytes");
  // The reply may follow a zero byte or what is left of an earlier one: the end of what came counts.
  const int64_t end = nowNs() + kGreetNs;
  std::array<uint8_t, 4> last{};
  uint8_t byte = 0;
  for (;;) {
    const Transfer result = readAll({&byte, 1}, std::max<int64_t>(0, end - nowNs()));
    if (result == Transfer::timeout) return Progress::loading;
    if (result != Transfer::ok) return failed(result, "its boot loader cannot be read");
    std::rotate(last.begin(), last.begin() + 1, last.end());
    last.back() = byte;
    if (last == kGreetingReply) break;
    if (nowNs() > end) return Progress::loading;  // Bytes without end that are no reply.
  }
  stage_ = Stage::speedUp;
  return Progress::loading;
}

FalconLoader::Progress FalconLoader::speedUp() {
  Transfer result = transport_.control(FtdiRequest::modemLines, kFtdiDtrOff);
  if (result == Transfer::ok) result = transport_.control(FtdiRequest::baudDivisor, kLoadBaud);
  if (result != Transfer::ok) return failed(result, "its line cannot be set to loading speed");
  readBegin_ = readEnd_ = 0;
  result = transport_.write({&kFastByte, 1}, kWriteNs);
  uint8_t echo = 0;
  if (result == Transfer::ok) result = readAll({&echo, 1}, kEchoNs);
  if (result != Transfer::ok || echo != kFastByte)
    return failed(result, "its boot loader does not follow to loading speed");
  // Streaming before the device is clear to send is what makes loads fail. One that never says so is tried all the
  // same: the echo tells.
  const int64_t end = nowNs() + kClearNs;
  while (!transport_.clearToSend() && nowNs() < end) {
    size_t count = 0;
    result = transport_.read(read_, count, 10 * kMs);
    if (result == Transfer::gone || result == Transfer::stall) return failed(result, "its boot loader cannot be read");
  }
  stage_ = Stage::stream;
  return Progress::loading;
}

FalconLoader::Progress FalconLoader::stream() {
  const auto piece = firmware_.subspan(loaded_, std::min(kPiece, firmware_.size() - loaded_));
  Transfer result = transport_.write(piece, kWriteNs);
  std::array<uint8_t, kPiece> echo;
  const std::span<uint8_t> back(echo.data(), piece.size());
  if (result == Transfer::ok) result = readAll(back, kEchoNs);
  if (result != Transfer::ok)
    return failed(result,
                  fmt::format("the echo of its firmware stopped near byte {} of {}", loaded_, firmware_.size()));
  const auto wrong = std::mismatch(piece.begin(), piece.end(), back.begin()).first;
  if (wrong != piece.end())
    return failed(Transfer::ok,
                  fmt::format("byte {} of its firmware came back wrong", loaded_ + size_t(wrong - piece.begin())));
  loaded_ += piece.size();
  if (loaded_ == firmware_.size()) stage_ = Stage::run;
  return Progress::loading;
}

}  // namespace argil::haptics
