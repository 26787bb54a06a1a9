#include "haptics/devices/spacemouse.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "clay/error.h"
#include "haptics/clock.h"
#include "haptics/devices/hid_descriptor.h"

namespace argil::haptics {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStillNs = 100'000'000;  // A deflected puck reports every 8 or 16 ms: one that says nothing for so long has let go.
constexpr int64_t kSpoiledNs = 30'000'000;  // So long after a report that made no sense nothing is believed but a good one.
constexpr uint16_t kDesktop = 1, kButtons = 9, kFirstAxis = 0x30;

class HidrawSource final : public HidSource {
 public:
  explicit HidrawSource(std::string node) : wanted_(std::move(node)) {}
  ~HidrawSource() override { close(); }

  DeviceLink::Opened open(std::string& sentence) override {
    close();
    std::string node = wanted_;
    if (node.empty())
      for (const HidNode& n : hidNodes())
        if (isSpaceMouse(n.vendor, n.product) && node.empty()) node = n.node;
    if (node.empty()) {
      sentence = "not plugged in";
      return DeviceLink::Opened::absent;
    }
    fd_ = ::open(node.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) {
      const bool absent = errno == ENOENT || errno == ENXIO || errno == ENODEV;
      sentence = absent ? "not plugged in (" + node + ")"
                        : node + " cannot be opened (" + std::strerror(errno) + ")" + (errno == EACCES ? ": install installer/99-argil.rules" : "");
      return absent ? DeviceLink::Opened::absent : DeviceLink::Opened::refused;
    }
    int size = 0;
    hidraw_report_descriptor d{};
    if (ioctl(fd_, HIDIOCGRDESCSIZE, &size) != 0 || size <= 0 || size > HID_MAX_DESCRIPTOR_SIZE) size = 0;
    d.size = static_cast<uint32_t>(size);
    if (size == 0 || ioctl(fd_, HIDIOCGRDESC, &d) != 0) {
      sentence = node + " does not tell its report descriptor; name the node of a SpaceMouse";
      close();
      return DeviceLink::Opened::refused;
    }
    descriptor_.assign(d.value, d.value + size);
    sentence = node;
    return DeviceLink::Opened::ready;
  }
  std::span<const uint8_t> descriptor() const noexcept override { return descriptor_; }
  int fd() const noexcept override { return fd_; }
  void close() noexcept override {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  std::string wanted_;
  std::vector<uint8_t> descriptor_;
  int fd_ = -1;
};

class SpaceMouseLink final : public DeviceLink {
 public:
  SpaceMouseLink(const SpaceMouseOptions& options, std::unique_ptr<HidSource> source) : options_(options), source_(std::move(source)) {}

  Opened open(std::string& sentence) override {
    const Opened opened = source_->open(sentence);
    if (opened != Opened::ready) return opened;
    std::string why;
    if (auto inputs = parseHidDescriptor(source_->descriptor(), why)) inputs_ = std::move(*inputs);
    else inputs_ = {};
    axes_ = 0;
    for (const HidField& f : inputs_.fields)
      if (isAxis(f)) axes_ |= 1 << (f.usage - kFirstAxis);
    if (axes_ != 0x3F) {
      sentence = (why.empty() ? "its report descriptor names no six axes" : why) + "; name the node of a SpaceMouse";
      source_->close();
      return Opened::refused;
    }
    rest();
    last_ = heard_ = nowNs();
    spoiledUntil_ = 0;
    return Opened::ready;
  }

  Exchanged exchange(const Vec3d&, int64_t, DeviceState& state) noexcept override {
    const int64_t now = nowNs();
    std::array<uint8_t, 512> report;
    while (true) {
      const ssize_t n = ::read(source_->fd(), report.data(), report.size());
      if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) return Exchanged::gone;
      if (n < 0) break;
      heard_ = now;
      if (!take(std::span(report).first(static_cast<size_t>(n)))) {
        rest();
        spoiledUntil_ = now + kSpoiledNs;
      } else {
        spoiledUntil_ = 0;
      }
    }
    if (now - heard_ > kStillNs) {
      velocity_.setZero();
      turn_.setZero();
    }
    const double dt = double(now - last_) * 1e-9;
    last_ = now;
    const Vec3d half = 0.5 * options_.boxMm;
    pose_.translation = (pose_.translation + dt * velocity_).cwiseMax(-half).cwiseMin(half);
    if (const double angle = dt * turn_.norm(); angle > 0)
      pose_.rotation = (Eigen::AngleAxisd(angle, turn_.normalized()) * pose_.rotation).normalized();
    if (now < spoiledUntil_) return Exchanged::garbage;
    state.pose = pose_;
    state.buttons = buttons_;
    state.pressure = buttons_ ? 1.0f : 0.0f;
    return Exchanged::state;
  }

  void close() noexcept override { source_->close(); }

 private:
  static bool isAxis(const HidField& f) { return f.page == kDesktop && f.usage >= kFirstAxis && f.usage < kFirstAxis + 6 && f.most > f.least; }

  void rest() {
    velocity_.setZero();
    turn_.setZero();
    buttons_ = 0;
  }

  /// Takes over what a report says; false when it cannot be one of this device's. Reports of other things (battery) are fine.
  bool take(std::span<const uint8_t> bytes) {
    const uint8_t id = inputs_.numbered ? bytes[0] : uint8_t{0};
    const auto payload = bytes.subspan(inputs_.numbered ? 1 : 0);
    for (const HidField& f : inputs_.fields) {
      if (f.report != id) continue;
      const std::optional<int32_t> value = hidValue(f, payload);
      if (!value) return false;
      if (isAxis(f)) {
        const double full = 0.5 * (double(f.most) - f.least), middle = 0.5 * (double(f.most) + f.least);
        const double part = (*value - middle) / full;
        if (!(std::abs(part) <= kFarthest)) return false;
        setAxis(f.usage - kFirstAxis, part);
      } else if (f.page == kButtons && f.usage >= 1 && f.usage <= 32) {
        const uint32_t bit = uint32_t{1} << (f.usage - 1);
        buttons_ = *value ? buttons_ | bit : buttons_ & ~bit;
      }
    }
    return true;
  }

  void setAxis(int axis, double part) {
    part = std::clamp(part, -1.0, 1.0);
    const double beyond = std::max(0.0, std::abs(part) - options_.deadZone) / (1 - options_.deadZone);
    // The device's own axes are x right, y towards the person, z down: half a turn about x from ours.
    const double value = std::copysign(beyond, axis % 3 == 0 ? part : -part);
    if (axis < 3) velocity_[axis] = options_.topSpeedMms * value;
    else turn_[axis - 3] = options_.topTurnRads * value;
  }

  static constexpr double kFarthest = 2;  // Some devices go a little beyond the range that they name; twice is none of theirs.

  SpaceMouseOptions options_;
  std::unique_ptr<HidSource> source_;
  HidInputs inputs_;
  int axes_ = 0;
  Pose pose_;
  Vec3d velocity_ = Vec3d::Zero(), turn_ = Vec3d::Zero();  // mm/s, rad/s.
  uint32_t buttons_ = 0;
  int64_t last_ = 0, heard_ = 0, spoiledUntil_ = 0;
};

}  // namespace

bool isSpaceMouse(uint16_t vendor, uint16_t product) noexcept {
  if (vendor == 0x046D)
    return product == 0xC621 || product == 0xC623 || (product >= 0xC625 && product <= 0xC629) || product == 0xC62B;
  if (vendor != 0x256F) return false;
  constexpr uint16_t kProducts[] = {0xC62E, 0xC62F, 0xC631, 0xC633, 0xC635};
  return std::find(std::begin(kProducts), std::end(kProducts), product) != std::end(kProducts) || (product & 0xFFF0) == 0xC650;
}

std::vector<HidNode> hidNodes(const std::string& sys, const std::string& dev) {
  std::vector<HidNode> nodes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(fs::path(sys) / "class" / "hidraw", none)) {
    HidNode node;
    node.node = (fs::path(dev) / entry.path().filename()).string();
    std::ifstream in(entry.path() / "device" / "uevent");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("HID_NAME=")) node.name = line.substr(9);
      if (!line.starts_with("HID_ID=")) continue;  // HID_ID=bus:vendor:product, in hexadecimal.
      const size_t first = line.find(':'), second = line.find(':', first + 1);
      if (first == std::string::npos || second == std::string::npos) continue;
      uint32_t vendor = 0, product = 0;
      std::from_chars(line.data() + first + 1, line.data() + second, vendor, 16);
      std::from_chars(line.data() + second + 1, line.data() + line.size(), product, 16);
      node.vendor = static_cast<uint16_t>(vendor);
      node.product = static_cast<uint16_t>(product);
    }
    nodes.push_back(node);
  }
  std::sort(nodes.begin(), nodes.end(), [](const HidNode& a, const HidNode& b) {
    return a.node.size() != b.node.size() ? a.node.size() < b.node.size() : a.node < b.node;
  });
  return nodes;
}

const DeviceSheet& spaceMouseSheet() {
  static const DeviceSheet sheet = [] {
    DeviceSheet s;
    s.name = "spacemouse";
    s.like = "3Dconnexion SpaceMouse";
    s.dofIn = 6;
    s.dofOut = 0;  // What follows about forces is what contact reckons with: the stylus stands in for a light arm.
    s.workspaceMm = SpaceMouseOptions().boxMm;
    s.resolutionMm = 0.12;  // A tick at top speed.
    s.rateHz = 1000;        // Of the sum; the puck reports every 8 or 16 ms.
    s.buttons = 32;
    return s;
  }();
  return sheet;
}

std::unique_ptr<Device> openSpaceMouse(const SpaceMouseOptions& options) {
  return openSpaceMouse(options, std::make_unique<HidrawSource>(options.node));
}

std::unique_ptr<Device> openSpaceMouse(const SpaceMouseOptions& options, std::unique_ptr<HidSource> source) {
  if (!(options.topSpeedMms >= 1 && options.topSpeedMms <= 1000)) throw Error("spacemouse: the top speed must be 1 to 1000 mm/s");
  if (!(options.topTurnRads >= 0 && options.topTurnRads <= 20)) throw Error("spacemouse: the top turn must be 0 to 20 rad/s");
  if (!(options.deadZone >= 0 && options.deadZone <= 0.5)) throw Error("spacemouse: the dead zone must be 0 to 0.5");
  if (!(options.boxMm.allFinite() && options.boxMm.minCoeff() > 0)) throw Error("spacemouse: the box must have edges above zero");
  DeviceSheet sheet = spaceMouseSheet();
  sheet.workspaceMm = options.boxMm;
  sheet.resolutionMm = options.topSpeedMms / sheet.rateHz;
  ThreadedDevice::Options thread;
  thread.lateSeconds = 0.02;  // Nobody feels it: a stall of the machine is no fault here.
  thread.realtime = false;
  return std::make_unique<ThreadedDevice>(sheet, std::make_unique<SpaceMouseLink>(options, std::move(source)), thread);
}

}  // namespace argil::haptics
