// The protocol is the one of Haply's serial interface: an opcode byte, then little-endian 32-bit floats. Forces are
// newtons, positions metres, velocities m/s (docs.haply.co, "Developing with Inverse3"). Answers carry no checksum:
// they are judged by opcode, length and whether their numbers can be.

#include "haptics/devices/haply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/device_thread.h"
#include "haptics/devices/serial_port.h"
#include "haptics/devices/sheets.h"
#include "haptics/threads/guard.h"

namespace argil::haptics {
namespace {

static_assert(std::endian::native == std::endian::little, "floats go out and come in as they lie in memory");

enum Opcode : uint8_t {
  kWake = 0x0A,
  kIdentity = 0x0B,  // Answers kWake.
  kForce = 0x2A,
  kState = 0x2B,      // Answers kForce.
  kGripState = 0xDB,  // Asks for kGripStatus.
  kGripIdentity = 0xD0,
  kGripStatus = 0xDA,
};

constexpr size_t kStateBytes = 1 + 6 * 4;
// Opcode, id, quaternion, error, hall sensor, length of what follows.
constexpr size_t kGripHeadBytes = 1 + 2 + 4 * 4 + 1 + 1 + 1;
constexpr int64_t kWakeNs = 300'000'000;
constexpr int64_t kQuietNs = 3'000'000;     // So long without a byte ends what a device says after waking.
constexpr size_t kMostIdentityBytes = 512;  // What a device says of itself is some twenty bytes.
constexpr double kMmPerM = 1000;
constexpr double kFarthestM = 1;  // The arm reaches 0.4 m.
constexpr double kFastestMs = 50;
constexpr double kGripRateHz = 60;

Vec3d floats(const uint8_t* at) {
  std::array<float, 3> f{};
  std::memcpy(f.data(), at, sizeof f);
  return {f[0], f[1], f[2]};
}

/// Wakes a device and lets it say who it is. Nothing, or what is wrong with what it said. Bounded in bytes and time,
/// whatever talks at the other end.
std::string wake(SerialPort& port, Opcode identity) {
  constexpr const char* kEndless = " talks without end: it is no Haply device; name another line";
  const uint8_t request[] = {kWake};
  if (!port.discardInput()) return kEndless;
  if (port.write(request) != 1) return " takes no bytes; unplug the device and plug it in again";
  std::array<uint8_t, kMostIdentityBytes> said;
  const int64_t end = nowNs() + kWakeNs;
  int n = port.read(said, end);
  if (n <= 0) return " does not answer as a Haply device; look at its power, or name another line";
  size_t count = static_cast<size_t>(n);
  while (count < said.size() && nowNs() < end) {
    n = port.read(std::span(said).subspan(count), std::min(end, nowNs() + kQuietNs));
    if (n <= 0) break;
    count += static_cast<size_t>(n);
  }
  if (count == said.size() || nowNs() >= end) return kEndless;
  if (said[0] == identity) return "";
  if (said[0] == kGripIdentity)
    return " is the grip of a Haply, not its arm; name the arm's line first, as haply:ARM,GRIP";
  if (said[0] == kIdentity) return " is the arm of a Haply, not its grip; name the arm's line first, as haply:ARM,GRIP";
  return " answers as another device, not as a Haply; name another line";
}

DeviceLink::Opened openAndWake(SerialPort& port, const std::string& path, Opcode identity, std::string& sentence) {
  const SerialPort::Opened opened = port.open(path, sentence);
  if (opened == SerialPort::Opened::absent) return DeviceLink::Opened::absent;
  if (opened == SerialPort::Opened::refused) return DeviceLink::Opened::refused;
  const std::string wrong = wake(port, identity);
  sentence = path + wrong;
  if (wrong.empty()) return DeviceLink::Opened::ready;
  port.close();
  return DeviceLink::Opened::refused;
}

/// Turns of the grip as the rotation of a state; its place is none.
class GripLink final : public DeviceLink {
 public:
  explicit GripLink(std::string path) : path_(std::move(path)) {}
  ~GripLink() override { port_.close(); }

  Opened open(std::string& sentence) override {
    held_ = 0;
    known_ = false;
    return openAndWake(port_, path_, kGripIdentity, sentence);
  }

  Exchanged exchange(const Vec3d&, int64_t deadlineNs, DeviceState& state) noexcept override {
    const uint8_t request[] = {kGripState, id_[0], id_[1], 0};
    if (port_.write(request) < 0) return Exchanged::gone;
    while (true) {
      if (held_ == buffer_.size()) return spoiled();
      const int n = port_.read(std::span(buffer_).subspan(held_), deadlineNs);
      if (n < 0) return Exchanged::gone;
      if (n == 0) return Exchanged::nothing;
      held_ += static_cast<size_t>(n);
      // Where several came at once the last one counts.
      Exchanged found = Exchanged::nothing;
      while (held_ > 0) {
        if (buffer_[0] != kGripStatus) return spoiled();
        if (held_ < kGripHeadBytes || held_ < kGripHeadBytes + buffer_[kGripHeadBytes - 1]) break;
        found = decode(state);
      }
      if (found != Exchanged::nothing) return found;
    }
  }

  void close() noexcept override { port_.close(); }

 private:
  Exchanged spoiled() {
    (void)port_.discardInput();
    held_ = 0;
    return Exchanged::garbage;
  }

  Exchanged decode(DeviceState& state) {
    std::array<float, 4> q{};  // w, x, y, z.
    std::memcpy(q.data(), &buffer_[3], sizeof q);
    // A receiver may hear several grips: the first that answers is the one that is held.
    const bool another = known_ && std::memcmp(id_.data(), &buffer_[1], sizeof id_) != 0;
    if (!another) std::memcpy(id_.data(), &buffer_[1], sizeof id_);
    known_ = true;
    const uint8_t error = buffer_[3 + sizeof q], extra = buffer_[kGripHeadBytes - 1];
    const size_t length = kGripHeadBytes + extra;
    state.pose.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    state.buttons = extra ? buffer_[kGripHeadBytes] : 0u;
    std::memmove(buffer_.data(), &buffer_[length], held_ - length);
    held_ -= length;
    const double size = state.pose.rotation.norm();
    if (another || error != 0 || !(size > 0.9 && size < 1.1)) return Exchanged::garbage;
    state.pose.rotation.normalize();
    return Exchanged::state;
  }

  std::string path_;
  SerialPort port_;
  std::array<uint8_t, 2> id_{};
  bool known_ = false;
  std::array<uint8_t, 512> buffer_{};
  size_t held_ = 0;
};

class ArmLink final : public DeviceLink {
 public:
  explicit ArmLink(const HaplyOptions& options) : options_(options) {
    if (options.grip.empty()) return;
    DeviceSheet sheet;
    sheet.name = "haply grip";
    sheet.dofOut = 0;
    sheet.rateHz = kGripRateHz;
    ThreadedDevice::Options grip;
    grip.realtime = false;  // Sixty times a second: nobody feels its lateness.
    grip_ = std::make_unique<ThreadedDevice>(sheet, std::make_unique<GripLink>(options.grip), grip);
  }
  ~ArmLink() override { shut(); }

  Opened open(std::string& sentence) override {
    const Opened opened = openAndWake(port_, options_.port, kIdentity, sentence);
    if (opened != Opened::ready) return opened;
    guarded_ = Guard::registerDevice(port_.fd(), haplyZeroPacket());
    return opened;
  }

  Exchanged exchange(const Vec3d& forceN, int64_t deadlineNs, DeviceState& state) noexcept override {
    // Of an exchange that was late: every answer after it would be one behind.
    if (!port_.discardInput()) return Exchanged::garbage;
    const int written = port_.write(haplyForcePacket(forceN));
    Guard::beat(guarded_);
    if (written != 1) return written < 0 ? Exchanged::gone : Exchanged::nothing;
    std::array<uint8_t, kStateBytes> answer;
    const int got = port_.readAll(answer, deadlineNs);
    if (got != 1) return got < 0 ? Exchanged::gone : Exchanged::nothing;
    const Vec3d position = floats(&answer[1]), velocity = floats(&answer[13]);
    if (answer[0] != kState || !(position.norm() < kFarthestM) || !(velocity.norm() < kFastestMs))
      return Exchanged::garbage;
    state.pose.translation = kMmPerM * position - options_.centreMm;
    if (grip_ && grip_->read(0, held_)) {
      state.pose.rotation = held_.pose.rotation;
      state.buttons = held_.buttons;
    } else {
      state.pose.rotation = held_.pose.rotation;  // Where it was when it was lost; no button stays held.
    }
    state.pressure = state.buttons ? 1.0f : 0.0f;
    return Exchanged::state;
  }

  void close() noexcept override { shut(); }

 private:
  void shut() {
    if (!port_.isOpen()) return;
    (void)port_.write(haplyForcePacket(Vec3d::Zero()));
    Guard::unregister(guarded_);
    guarded_ = Guard::kUnguarded;
    port_.close();
  }

  HaplyOptions options_;
  SerialPort port_;
  int guarded_ = Guard::kUnguarded;
  std::unique_ptr<ThreadedDevice> grip_;
  DeviceState held_;  // The newest grip that was heard.
};

}  // namespace

std::array<uint8_t, 13> haplyForcePacket(const Vec3d& forceN) noexcept {
  const std::array<float, 3> f = {static_cast<float>(forceN.x()), static_cast<float>(forceN.y()),
                                  static_cast<float>(forceN.z())};
  std::array<uint8_t, 13> packet{kForce};
  std::memcpy(&packet[1], f.data(), sizeof f);
  return packet;
}

std::span<const std::byte> haplyZeroPacket() noexcept {
  static constexpr std::array<std::byte, 13> packet{std::byte{kForce}};  // Zero is four zero bytes.
  return packet;
}

const DeviceSheet& haplySheet() {
  return deviceSheet("haply");
}

std::unique_ptr<Device> openHaply(const HaplyOptions& options) {
  if (options.port.empty()) throw Error("haply: name its serial line, such as haply:/dev/ttyACM0");
  if (options.grip == options.port) throw Error("haply: the arm and the grip cannot both be on " + options.port);
  if (!options.centreMm.allFinite()) throw Error("haply: the centre of the workspace must be finite");
  DeviceSheet sheet = haplySheet();
  if (options.grip.empty()) {
    sheet.dofIn = 3;
    sheet.buttons = 0;
  }
  ThreadedDevice::Options thread;
  thread.realtime = options.realtime;
  return std::make_unique<ThreadedDevice>(sheet, std::make_unique<ArmLink>(options), thread);
}

}  // namespace argil::haptics
