#include "haptics/devices/falcon.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <span>

#include "haptics/base/clock.h"
#include "haptics/devices/device_thread.h"
#include "haptics/devices/falcon_kinematics.h"
#include "haptics/devices/falcon_protocol.h"
#include "haptics/devices/sheets.h"
#include "haptics/threads/guard.h"

namespace argil::haptics {
namespace {

constexpr int64_t kMs = 1'000'000;
// An open() longer than this would keep a person waiting who closes the device.
constexpr int64_t kOpenNs = 400 * kMs;
constexpr int64_t kAskNs = 200 * kMs;  // Loading firmware resets a Falcon: only one that was silent for so long.
constexpr int64_t kAnswerNs = 20 * kMs;
// A boot loader answers by then, or there is none: it may be a running Falcon that was silent.
constexpr int64_t kBootNs = 2000 * kMs;
constexpr int64_t kLostNs = 25 * kMs;  // An answer that did not come by then will not.
constexpr int kMostWaiting = 64;       // Packets taken at once from a line that never ends.
constexpr int64_t kLastWriteNs = 20 * kMs;
// Motor value for a torque about an arm's axis of 1 N·mm: the factor and the sign that libnifalcon uses. To be checked
// on hardware.
constexpr double kMotorPerNmm = -10;
// Motor values are whole: the force that they make may be longer than the one asked for by 1e-3 of the peak.
constexpr double kRoundingRoom = 1e-3;
// Lights that no Falcon at rest answers with: so an echo is told from an answer.
constexpr FalconCommand kAskHoming = {{}, kFalconLedRed, true};
constexpr const char* kNoAnswer = "it does not answer: look at its cable and its power";

/// A Falcon as the device's thread drives it. open() leaves the line open while a Falcon is being loaded or homed, so
/// that the next open() goes on there.
class FalconLink final : public DeviceLink {
 public:
  FalconLink(std::unique_ptr<ByteTransport> transport, std::vector<uint8_t> firmware, double peakN)
      : transport_(std::move(transport)), firmware_(std::move(firmware)), mostN_(peakN * (1 - kRoundingRoom)) {}
  ~FalconLink() override { FalconLink::close(); }

  Opened open(std::string& sentence) override;
  Exchanged exchange(const Vec3d& forceN, int64_t deadlineNs, DeviceState& state) noexcept override;
  void close() noexcept override;

 private:
  /// One packet each way.
  Exchanged talk(const FalconCommand& command, int64_t deadlineNs, FalconReply& reply) noexcept;
  /// What came in: true when an answer ended in it, which is then in `reply`.
  bool hear(std::span<const uint8_t> bytes, FalconReply& reply) noexcept;
  /// Does its firmware run? Asks, with zero force, until it answers or `deadlineNs`.
  Exchanged ask(int64_t deadlineNs);
  Opened load(int64_t deadlineNs, std::string& sentence);
  Opened home(int64_t deadlineNs, std::string& sentence);
  Opened unplugged(std::string& sentence);
  /// From now on the guard, if there is one, zeroes the motors when this program dies. What keeps it from doing so, or
  /// nothing.
  [[nodiscard]] std::string beGuarded();
  [[nodiscard]] std::array<int, 3> motors(Vec3d forceN) const noexcept;

  std::unique_ptr<ByteTransport> transport_;
  std::vector<uint8_t> firmware_;
  double mostN_;
  bool open_ = false;
  int guarded_ = Guard::kUnguarded;
  std::optional<FalconLoader> loader_;
  int64_t loadingSinceNs_ = 0;
  FalconDecoder decoder_;
  int owed_ = 0;          // Answers not yet come to packets sent.
  int64_t heardNs_ = 0;   // When bytes last went either way.
  bool resting_ = false;  // The last packet sent told the motors to rest.
  FalconPose pose_;       // Of the last answer; its Jacobian is zero until there is one, and so are the motors.
};

DeviceLink::Opened FalconLink::unplugged(std::string& sentence) {
  close();
  sentence = "unplugged; plug it in again and it goes on";
  return Opened::absent;
}

DeviceLink::Opened FalconLink::open(std::string& sentence) {
  if (!open_) {
    const ByteTransport::Opening opening = transport_->open();
    if (opening != ByteTransport::Opening::opened) {
      sentence = transport_->sentence();
      return opening == ByteTransport::Opening::absent ? Opened::absent : Opened::refused;
    }
    open_ = true;
    guarded_ = Guard::registerCall(zeroFalcons);
  }
  const int64_t end = nowNs() + kOpenNs;
  if (!loader_) {
    const Exchanged answer = ask(nowNs() + kAskNs);
    if (answer == Exchanged::gone) return unplugged(sentence);
    if (answer == Exchanged::state) return home(end, sentence);
    if (firmware_.empty()) {
      close();  // Another program may load it.
      sentence =
          "it does not answer: look at its power; if it was switched on anew, set falcon.firmware to its firmware "
          "file, so that it can be loaded";
      return Opened::refused;
    }
    loader_.emplace(*transport_, firmware_);
    loadingSinceNs_ = nowNs();
  }
  const Opened loaded = load(end, sentence);
  return loaded == Opened::ready ? home(end, sentence) : loaded;
}

DeviceLink::Opened FalconLink::load(int64_t deadlineNs, std::string& sentence) {
  do {
    switch (loader_->step()) {
      case FalconLoader::Progress::loading:
        break;
      case FalconLoader::Progress::done:
        loader_.reset();
        return Opened::ready;
      case FalconLoader::Progress::gone:
        return unplugged(sentence);
      case FalconLoader::Progress::failed:
        sentence = fmt::format(
            "its firmware cannot be loaded, after {} attempts: {}; check that falcon.firmware is the file of this "
            "device, "
            "switch it off and on",
            loader_->attempts(), loader_->problem());
        loader_.reset();
        return Opened::refused;
    }
  } while (nowNs() < deadlineNs);
  if (loader_->greeted()) {
    sentence = fmt::format("its firmware is being loaded, {} %", 100 * loader_->loaded() / firmware_.size());
  } else if (loader_->attempts() > 1) {
    sentence = "its firmware is being loaded anew: " + loader_->problem();
  } else {
    sentence = kNoAnswer;
    if (nowNs() - loadingSinceNs_ > kBootNs) loader_.reset();  // The next open() asks anew.
  }
  return Opened::refused;
}

DeviceLink::Opened FalconLink::home(int64_t deadlineNs, std::string& sentence) {
  do {
    FalconReply reply;
    const bool answered = talk(kAskHoming, nowNs() + kAnswerNs, reply) == Exchanged::state;
    if (answered && reply.homed == kFalconAllHomed) {
      sentence = transport_->sentence() + beGuarded();
      pose_.jacobian.setZero();
      return Opened::ready;
    }
    if (!answered) {
      sentence = kNoAnswer;
      return Opened::refused;
    }
    sleepUntilNs(nowNs() + kMs);
  } while (nowNs() < deadlineNs);
  sentence = "not homed: pull its grip out as far as it goes, then push it in once";
  return Opened::refused;
}

std::string FalconLink::beGuarded() try {
  const FalconPacket zero = encodeFalcon({});
  if (guarded_ == Guard::kUnguarded && transport_->file() >= 0)
    guarded_ = Guard::registerDevice(transport_->file(), std::as_bytes(std::span(zero)), Guard::Transport::usbBulk,
                                     kUsbOutEndpoint);
  return "";
} catch (const std::exception& error) {
  return std::string("; not guarded against the end of this program: ") + error.what();
}

DeviceLink::Exchanged FalconLink::ask(int64_t deadlineNs) {
  if (const Transfer result = enterFalconRunningMode(*transport_); result != Transfer::ok)
    return result == Transfer::gone ? Exchanged::gone : Exchanged::nothing;
  FalconReply reply;
  Exchanged result;
  do {
    result = talk(kAskHoming, nowNs() + kAnswerNs, reply);
  } while (result != Exchanged::state && result != Exchanged::gone && nowNs() < deadlineNs);
  return result;
}

bool FalconLink::hear(std::span<const uint8_t> bytes, FalconReply& reply) noexcept {
  bool whole = false;
  for (const uint8_t byte : bytes)
    if (decoder_.feed(byte, reply)) {
      whole = true;
      if (owed_ > 0) --owed_;
    }
  if (!bytes.empty()) heardNs_ = nowNs();
  return whole;
}

DeviceLink::Exchanged FalconLink::talk(const FalconCommand& command, int64_t deadlineNs, FalconReply& reply) noexcept {
  std::array<uint8_t, 64> bytes;
  size_t count = 0;
  for (int packets = 0; packets < kMostWaiting && transport_->read(bytes, count, 0) == Transfer::ok; ++packets)
    (void)hear({bytes.data(), count}, reply);
  // Answers carry no number: one that is late looks like one to the next question, and a place of the past would be
  // felt. So when one is owed, and the motors were told to rest, nothing is asked until it came or is lost.
  if (owed_ > 0 && resting_ && nowNs() - heardNs_ > kLostNs) owed_ = 0;
  const bool ask = owed_ == 0 || !resting_;
  if (ask) {
    const FalconPacket packet = encodeFalcon(command);
    if (const Transfer result = transport_->write(packet, deadlineNs - nowNs()); result != Transfer::ok)
      return result == Transfer::gone ? Exchanged::gone : Exchanged::nothing;
    ++owed_;
    heardNs_ = nowNs();
    resting_ = command.motors == FalconCommand().motors;
    if (resting_)
      Guard::rest(guarded_);
    else
      Guard::beat(guarded_);
  }
  bool any = false;
  for (;;) {
    const Transfer result = transport_->read(bytes, count, deadlineNs - nowNs());
    if (result == Transfer::gone) return Exchanged::gone;
    if (result == Transfer::ok) {
      any = true;
      const bool whole = hear({bytes.data(), count}, reply);
      // A boot loader that waits for firmware sends back what it gets.
      const bool echo =
          reply.counts == command.motors && reply.homed == 0 && reply.buttons == kFalconHomingBit + command.leds;
      if (whole && owed_ == 0 && !echo) return ask ? Exchanged::state : Exchanged::nothing;
    }
    if (result == Transfer::ok && nowNs() <= deadlineNs) continue;
    if (any) owed_ = 0;  // Something came that was no answer: nothing better will.
    return any ? Exchanged::garbage : Exchanged::nothing;
  }
}

std::array<int, 3> FalconLink::motors(Vec3d forceN) const noexcept {
  if (const double size = forceN.norm(); size > mostN_) forceN *= mostN_ / size;
  Vec3d values = kMotorPerNmm * falconTorques(pose_, forceN);
  // All three are lessened alike where one is at its end: the force keeps its direction.
  if (const double most = values.cwiseAbs().maxCoeff(); most > kFalconMotorLimit) values *= kFalconMotorLimit / most;
  if (!values.allFinite()) return {};
  return {int(std::lround(values[0])), int(std::lround(values[1])), int(std::lround(values[2]))};
}

DeviceLink::Exchanged FalconLink::exchange(const Vec3d& forceN, int64_t deadlineNs, DeviceState& state) noexcept {
  FalconReply reply;
  const Exchanged result = talk({motors(forceN), kFalconLedGreen, false}, deadlineNs, reply);
  if (result != Exchanged::state) return result;
  // Not homed any more: its firmware began anew, its counts mean nothing. Opened anew it is homed.
  if (reply.homed != kFalconAllHomed || !falconPose(reply.counts, pose_)) return Exchanged::garbage;
  constexpr uint8_t kRight = 1, kForward = 2, kCentre = 4, kLeft = 8;
  constexpr std::array<uint8_t, 4> kOrder = {kCentre, kRight, kForward, kLeft};
  state.buttons = 0;
  for (size_t i = 0; i < kOrder.size(); ++i)
    if (reply.buttons & kOrder[i]) state.buttons |= 1u << i;
  state.pressure = state.buttons ? 1.0f : 0.0f;
  state.pose.translation = pose_.positionMm;
  state.pose.rotation.setIdentity();
  return result;
}

void FalconLink::close() noexcept {
  if (!open_) return;
  if (!loader_) (void)transport_->write(encodeFalcon({}), kLastWriteNs);
  Guard::unregister(guarded_);
  guarded_ = Guard::kUnguarded;
  loader_.reset();
  transport_->close();
  open_ = false;
}

}  // namespace

std::vector<UsbPlace> findFalcons() {
  return findUsb(kFalconVendor, kFalconProduct);
}

std::unique_ptr<Device> openFalcon(const FalconOptions& options) {
  return openFalcon(options, std::make_unique<UsbTransport>(kFalconVendor, kFalconProduct, options.where));
}

std::unique_ptr<Device> openFalcon(const FalconOptions& options, std::unique_ptr<ByteTransport> transport) {
  std::vector<uint8_t> firmware;
  if (!options.firmware.empty()) firmware = readFalconFirmware(options.firmware);
  const DeviceSheet& sheet = deviceSheet("falcon");
  ThreadedDevice::Options thread;
  thread.realtime = options.realtime;
  return std::make_unique<ThreadedDevice>(
      sheet, std::make_unique<FalconLink>(std::move(transport), std::move(firmware), sheet.peakForceN), thread);
}

int zeroFalcons() noexcept try {
  int zeroed = 0;
  for (const UsbPlace& place : findFalcons()) {
    UsbTransport line(kFalconVendor, kFalconProduct, place.where);
    if (line.open() == ByteTransport::Opening::opened && line.write(encodeFalcon({}), kLastWriteNs) == Transfer::ok)
      ++zeroed;
  }
  return zeroed;
} catch (const std::exception&) {
  return 0;
}

}  // namespace argil::haptics
