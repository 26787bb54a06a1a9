#include "falcon_emulator.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "haptics/base/clock.h"

namespace argil::haptics::testing {
namespace {

// The protocol once more, from the published description and not from the driver's headers.
constexpr uint8_t kRaise = 0x41;
constexpr int64_t kWireNs = 107'000;     // 16 bytes at 1.5 Mbaud, one way.
constexpr int64_t kLoadByteNs = 71'000;  // A byte at 140 kbaud.
constexpr int64_t kLateNs = 20'000'000;
constexpr size_t kPayload = 62;
constexpr double kMotorPerNmm = -10;
constexpr double kHomeDeg = 35, kDegPerCount = 0.0364346590909;

FalconPose poseAt(const Vec3d& position) {
  Vec3d angles;
  FalconPose pose;
  // A test put the hand out of reach.
  if (!falconInverse(position, angles) || !falconPose(angles, pose)) std::abort();
  return pose;
}

}  // namespace

void FalconEmulator::hand(const Vec3d& positionMm, uint8_t rawButtons) {
  const std::scoped_lock lock(mutex_);
  position_ = positionMm;
  buttons_ = rawButtons;
}
void FalconEmulator::setHomed(bool homed) {
  const std::scoped_lock lock(mutex_);
  homed_ = homed;
}
void FalconEmulator::powerCycle() {
  const std::scoped_lock lock(mutex_);
  mode_ = Mode::boot;
  homed_ = false;
  motors_ = {};
  streamed_ = 0;
  broken_ = false;
  taken_.clear();
  answers_.clear();
}
void FalconEmulator::loadElsewhere() {
  const std::scoped_lock lock(mutex_);
  mode_ = Mode::running;
  homed_ = true;
}
void FalconEmulator::misbehave(FalconFault fault) {
  const std::scoped_lock lock(mutex_);
  fault_ = fault;
}
void FalconEmulator::wrongEchoes(int count) {
  const std::scoped_lock lock(mutex_);
  wrongEchoes_ = count;
}
void FalconEmulator::ignoreGreetings(int count) {
  const std::scoped_lock lock(mutex_);
  deaf_ = count;
}
void FalconEmulator::setClearAfterNs(int64_t ns) {
  const std::scoped_lock lock(mutex_);
  clearAfterNs_ = ns;
}
void FalconEmulator::unplug() {
  const std::scoped_lock lock(mutex_);
  plugged_ = false;
  ++plugging_;
  answers_.clear();
}
void FalconEmulator::replug() {
  const std::scoped_lock lock(mutex_);
  plugged_ = true;
  taken_.clear();
}

Vec3d FalconEmulator::force() const {
  Vec3d torques;
  for (int i = 0; i < 3; ++i) torques[i] = motors_[size_t(i)] / kMotorPerNmm;
  return falconForce(poseAt(position_), torques);
}
Vec3d FalconEmulator::forceN() const {
  const std::scoped_lock lock(mutex_);
  return force();
}
double FalconEmulator::peakN() const {
  const std::scoped_lock lock(mutex_);
  return peakN_;
}
uint8_t FalconEmulator::lights() const {
  const std::scoped_lock lock(mutex_);
  return lights_;
}
bool FalconEmulator::running() const {
  const std::scoped_lock lock(mutex_);
  return mode_ == Mode::running;
}
uint64_t FalconEmulator::packets() const {
  const std::scoped_lock lock(mutex_);
  return toldN_.size();
}
Vec3d FalconEmulator::toldN(uint64_t which) const {
  const std::scoped_lock lock(mutex_);
  return toldN_[which];
}
std::vector<std::pair<uint8_t, uint16_t>> FalconEmulator::requests() const {
  const std::scoped_lock lock(mutex_);
  return requests_;
}
bool FalconEmulator::plugged() const {
  const std::scoped_lock lock(mutex_);
  return plugged_;
}
uint64_t FalconEmulator::plugging() const {
  const std::scoped_lock lock(mutex_);
  return plugging_;
}

void FalconEmulator::control(uint8_t request, uint16_t value) {
  const std::scoped_lock lock(mutex_);
  requests_.emplace_back(request, value);
  switch (request) {
    case 0:
      if (value == 1) answers_.clear();
      if (value == 2) taken_.clear();
      break;
    case 1:
      if (value & 0x0100) {
        const bool on = (value & 1) != 0;
        if (on && !dtr_ && mode_ != Mode::boot) {  // A rising DTR resets the processor: no firmware any more.
          mode_ = Mode::boot;
          motors_ = {};
        }
        if (on) streamed_ = 0, broken_ = false, taken_.clear();
        dtr_ = on;
      }
      break;
    case 3:
      divisor_ = value;
      if (value == 0x2 && mode_ == Mode::loaded) mode_ = Mode::running;
      break;
    case 9:
      latencyNs_ = int64_t{value} * 1'000'000;
      break;
    default:
      break;
  }
}

bool FalconEmulator::out(std::span<const uint8_t> bytes) {
  const std::scoped_lock lock(mutex_);
  if (fault_ == FalconFault::stall) return false;
  const int64_t now = nowNs();
  for (const uint8_t byte : bytes) take(byte, now);
  return true;
}

void FalconEmulator::take(uint8_t byte, int64_t atNs) {
  if (mode_ == Mode::running && divisor_ == 0x2) {
    if (byte == '<') taken_.clear();
    taken_.push_back(byte);
    if (taken_.size() == 16) {
      if (taken_.front() == '<' && taken_.back() == '>') command(atNs);
      taken_.clear();
    }
    return;
  }
  if (mode_ == Mode::boot && divisor_ == 0x4138 && dtr_) {
    taken_.push_back(byte);
    if (taken_.size() > 3) taken_.erase(taken_.begin());
    if (taken_ != std::vector<uint8_t>{0x0a, 0x43, 0x0d}) return;
    taken_.clear();
    if (deaf_ > 0) {
      --deaf_;
      return;
    }
    mode_ = Mode::greeted;
    answer({0x0a, 0x44, 0x2c, 0x0d}, atNs);
    return;
  }
  if (mode_ == Mode::greeted && divisor_ == 0x15 && !dtr_ && byte == 0x41) {
    mode_ = Mode::loading;
    clearAtNs_ = atNs + clearAfterNs_;
    answer({0x41}, atNs);
    return;
  }
  if (mode_ != Mode::loading) return;  // Echoes at any speed: harsher than the real one, whose echo would be garbled.
  if (atNs < clearAtNs_) return;       // Not listening yet: lost, and so is its echo.
  uint8_t echo = byte;
  if (wrongEchoes_ > 0 && streamed_ % 100 == 70) {
    --wrongEchoes_;
    echo ^= 0x10;
  }
  broken_ = broken_ || streamed_ >= firmware_.size() || firmware_[streamed_] != byte;
  ++streamed_;
  wireFreeNs_ = std::max(wireFreeNs_, atNs) + kLoadByteNs;
  if (answers_.empty() || answers_.back().bytes.size() >= kPayload) answer({}, wireFreeNs_);
  answers_.back().bytes.push_back(echo);
  answers_.back().dueNs = wireFreeNs_;
  if (streamed_ == firmware_.size() && !broken_) mode_ = Mode::loaded;
}

void FalconEmulator::command(int64_t atNs) {
  const auto nibble = [&](size_t i) { return int(taken_[i] - kRaise) & 0xf; };
  for (size_t arm = 0; arm < 3; ++arm) {
    const size_t at = 1 + 4 * arm;
    motors_[arm] = static_cast<int16_t>(nibble(at) | nibble(at + 1) << 4 | nibble(at + 2) << 8 | nibble(at + 3) << 12);
  }
  lights_ = static_cast<uint8_t>(taken_[13] - kRaise);
  toldN_.push_back(force());
  peakN_ = std::max(peakN_, toldN_.back().norm());
  if (fault_ == FalconFault::silent) return;

  Vec3d angles;
  if (!falconInverse(position_, angles)) return;
  std::vector<uint8_t> bytes = {'<'};
  for (int arm = 0; arm < 3; ++arm) {
    const auto count = std::lround((angles[arm] * 57.29577951308232 - kHomeDeg) / kDegPerCount);
    for (int shift = 0; shift < 16; shift += 4)
      bytes.push_back(static_cast<uint8_t>(kRaise + ((count >> shift) & 0xf)));
  }
  bytes.push_back(static_cast<uint8_t>(kRaise + buttons_ + (homed_ ? 0x70 : 0)));
  bytes.push_back(kRaise);
  bytes.push_back('>');

  const auto litter = [&](size_t count) {
    std::vector<uint8_t> some(count);
    for (uint8_t& b : some) b = static_cast<uint8_t>(random_());
    some.back() = '!';  // Random bytes may not begin a packet that the answer would then complete.
    return some;
  };
  if (fault_ == FalconFault::shortPackets) bytes.resize(9);
  if (fault_ == FalconFault::garbage) bytes = litter(16);
  if (fault_ == FalconFault::littered) {
    std::vector<uint8_t> all = litter(23);
    all.insert(all.end(), bytes.begin(), bytes.end());
    bytes = all;
  }
  int64_t due = atNs + 2 * kWireNs;
  if (fault_ == FalconFault::late) due += kLateNs;
  if (fault_ != FalconFault::split) return answer(bytes, due);
  for (size_t i = 0; i < bytes.size(); i += 5)
    answer({bytes.begin() + long(i), bytes.begin() + long(std::min(i + 5, bytes.size()))}, due);
}

void FalconEmulator::answer(std::vector<uint8_t> bytes, int64_t dueNs) {
  answers_.push_back({dueNs, std::move(bytes)});
}

size_t FalconEmulator::in(std::array<uint8_t, 64>& packet, int64_t atNs) {
  const std::scoped_lock lock(mutex_);
  packet[0] = static_cast<uint8_t>(0x01 | (mode_ >= Mode::loading && atNs >= clearAtNs_ ? 0x10 : 0));
  packet[1] = 0x60;
  // Less than a full packet waits for the latency timer, which ticks on a grid of its own; the rest of a split answer
  // does not.
  const auto tick = [&](int64_t t) { return (t + latencyNs_ - 1) / latencyNs_ * latencyNs_; };
  if (!answers_.empty()) {
    const Chunk& first = answers_.front();
    const bool due = first.bytes.size() >= kPayload ? first.dueNs <= atNs
                                                    : (tick(first.dueNs) <= atNs || lastInNs_ >= tick(first.dueNs));
    if (due) {
      const size_t count = std::min(first.bytes.size(), kPayload);
      std::memcpy(packet.data() + 2, first.bytes.data(), count);
      answers_.pop_front();
      lastInNs_ = atNs;
      return 2 + count;
    }
  }
  if (atNs / latencyNs_ == lastInNs_ / latencyNs_) return 0;
  lastInNs_ = atNs;
  return 2;
}

bool misbehave(FalconEmulator& falcon, Misbehaviour what) {
  switch (what) {
    case Misbehaviour::none:
      falcon.misbehave(FalconFault::none);
      return true;
    case Misbehaviour::split:
      falcon.misbehave(FalconFault::split);
      return true;
    case Misbehaviour::garbage:
      falcon.misbehave(FalconFault::garbage);
      return true;
    case Misbehaviour::shortAnswers:
      falcon.misbehave(FalconFault::shortPackets);
      return true;
    case Misbehaviour::late:
      falcon.misbehave(FalconFault::late);
      return true;
    case Misbehaviour::silent:
      falcon.misbehave(FalconFault::silent);
      return true;
    case Misbehaviour::notFinite:  // Its numbers are whole.
    case Misbehaviour::wrongEcho:
      return false;  // Only while firmware is loaded.
  }
  return false;
}

ByteTransport::Opening FalconLine::open() {
  opened_ = emulator_.plugging();
  open_ = emulator_.plugged();
  return open_ ? Opening::opened : Opening::absent;
}

std::string FalconLine::sentence() const {
  return open_ ? "emulated" : "not plugged in: connect its USB cable and its power";
}

Transfer FalconLine::control(FtdiRequest request, uint16_t value) {
  if (gone()) return Transfer::gone;
  emulator_.control(static_cast<uint8_t>(request), value);
  return Transfer::ok;
}

Transfer FalconLine::write(std::span<const uint8_t> bytes, int64_t) {
  if (gone()) return Transfer::gone;
  return emulator_.out(bytes) ? Transfer::ok : Transfer::stall;
}

Transfer FalconLine::read(std::span<uint8_t> into, size_t& count, int64_t timeoutNs) {
  constexpr int64_t kLookNs = 50'000;
  const int64_t end = nowNs() + timeoutNs;
  count = 0;
  for (;;) {
    if (gone()) return Transfer::gone;
    std::array<uint8_t, 64> packet;
    const int64_t now = nowNs();
    const auto payload = withoutModemStatus({packet.data(), emulator_.in(packet, now)}, clearToSend_);
    if (!payload.empty()) {
      count = std::min(payload.size(), into.size());
      std::memcpy(into.data(), payload.data(), count);
      return Transfer::ok;
    }
    if (now >= end) return Transfer::timeout;
    sleepUntilNs(std::min(now + kLookNs, end));
  }
}

}  // namespace argil::haptics::testing
