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
#include <iterator>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/hid_descriptor.h"

namespace argil::haptics {
namespace {

namespace fs = std::filesystem;

// A deflected puck reports every 8 or 16 ms: one that says nothing for so long has let go.
constexpr int64_t kStillNs = 100'000'000;
// So long after a report that made no sense nothing is believed but a good one.
constexpr int64_t kSpoiledNs = 30'000'000;
constexpr int kMostReports = 64;  // Of a node in an exchange: what the kernel keeps for a reader.
constexpr uint16_t kDesktop = 1, kButtons = 9, kFirstAxis = 0x30;

bool isAxis(const HidField& f) {
  return f.page == kDesktop && f.usage >= kFirstAxis && f.usage < kFirstAxis + 6 && f.most > f.least;
}

bool sixAxes(const HidInputs& inputs) {
  int axes = 0;
  for (const HidField& f : inputs.fields)
    if (isAxis(f)) axes |= 1 << (f.usage - kFirstAxis);
  return axes == 0x3F;
}

class HidrawSource final : public HidSource {
 public:
  explicit HidrawSource(std::string node) : wanted_(std::move(node)) {}
  ~HidrawSource() override { close(); }

  DeviceLink::Opened open(std::string& sentence) override {
    close();
    const std::vector<std::string> names = wanted();
    sentence = "not plugged in";
    DeviceLink::Opened result = DeviceLink::Opened::absent;
    for (const std::string& name : names) {
      std::string why;
      const DeviceLink::Opened opened = add(name, why);
      if (result == DeviceLink::Opened::ready) continue;  // One node is enough: the others may be another user's.
      result = opened;
      sentence = opened == DeviceLink::Opened::ready ? name : why;
    }
    return result;
  }
  std::span<const Node> nodes() const noexcept override { return nodes_; }
  void drop(size_t node) noexcept override {
    if (nodes_[node].fd >= 0) ::close(nodes_[node].fd);
    nodes_[node].fd = -1;
  }
  void close() noexcept override {
    for (size_t i = 0; i < nodes_.size(); ++i) drop(i);
    nodes_.clear();
  }

 private:
  // The nodes to open: all of the device that is named, or of the first.
  [[nodiscard]] std::vector<std::string> wanted() const {
    const std::vector<HidNode> all = hidNodes();
    std::string device;
    for (const HidNode& n : all)
      if (n.node == wanted_ && isSpaceMouse(n.vendor, n.product)) device = n.device;
    if (wanted_.empty())
      if (const auto found = spaceMice(all); !found.empty()) device = found.front().device;
    std::vector<std::string> names;
    for (const HidNode& n : all)
      if (!device.empty() && n.device == device) names.push_back(n.node);
    if (names.empty() && !wanted_.empty()) names.push_back(wanted_);
    return names;
  }

  DeviceLink::Opened add(const std::string& name, std::string& why) {
    Node node;
    node.fd = ::open(name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (node.fd < 0) {
      const bool absent = errno == ENOENT || errno == ENXIO || errno == ENODEV;
      why = absent ? "not plugged in (" + name + ")"
                   : name + " cannot be opened (" + std::strerror(errno) + ")" +
                         (errno == EACCES ? ": install installer/99-argil.rules" : "");
      return absent ? DeviceLink::Opened::absent : DeviceLink::Opened::refused;
    }
    int size = 0;
    hidraw_report_descriptor d{};
    if (ioctl(node.fd, HIDIOCGRDESCSIZE, &size) != 0 || size <= 0 || size > HID_MAX_DESCRIPTOR_SIZE) size = 0;
    d.size = static_cast<uint32_t>(size);
    if (size == 0 || ioctl(node.fd, HIDIOCGRDESC, &d) != 0) {
      why = name + " does not tell its report descriptor; name the node of a SpaceMouse";
      ::close(node.fd);
      return DeviceLink::Opened::refused;
    }
    node.descriptor.assign(d.value, d.value + size);
    nodes_.push_back(std::move(node));
    return DeviceLink::Opened::ready;
  }

  std::string wanted_;
  std::vector<Node> nodes_;
};

class SpaceMouseLink final : public DeviceLink {
 public:
  SpaceMouseLink(const SpaceMouseOptions& options, std::unique_ptr<HidSource> source)
      : options_(options), source_(std::move(source)) {}

  Opened open(std::string& sentence) override {
    const Opened opened = source_->open(sentence);
    if (opened != Opened::ready) return opened;
    std::string why;
    nodes_.assign(source_->nodes().size(), {});
    bool six = false;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (auto inputs = parseHidDescriptor(source_->nodes()[i].descriptor, why)) nodes_[i].inputs = std::move(*inputs);
      nodes_[i].axes = sixAxes(nodes_[i].inputs);
      six = six || nodes_[i].axes;
    }
    if (!six) {
      sentence = (why.empty() ? "its report descriptor names no six axes" : why) + "; name the node of a SpaceMouse";
      source_->close();
      return Opened::refused;
    }
    rest();
    last_ = nowNs();
    heard_ = last_ - 2 * kStillNs;
    spoiledUntil_ = 0;
    speaker_ = 0;
    return Opened::ready;
  }

  Exchanged exchange(const Vec3d&, int64_t, DeviceState& state) noexcept override {
    const int64_t now = nowNs();
    bool alive = false;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      listen(i, now);
      alive = alive || (nodes_[i].axes && source_->nodes()[i].fd >= 0);
    }
    if (!alive) return Exchanged::gone;
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
  struct Node {
    HidInputs inputs;
    bool axes = false;
  };

  /// Takes what one node says, kMostReports at most: one that talks without end must not hold up the others.
  void listen(size_t index, int64_t now) noexcept {
    std::array<uint8_t, 512> report;
    for (int count = 0; count < kMostReports && source_->nodes()[index].fd >= 0; ++count) {
      const ssize_t n = ::read(source_->nodes()[index].fd, report.data(), report.size());
      if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) source_->drop(index);
      if (n <= 0) return;
      if (!take(index, std::span(report).first(static_cast<size_t>(n)), now)) {
        rest();
        spoiledUntil_ = now + kSpoiledNs;
      } else {
        spoiledUntil_ = 0;
      }
    }
  }

  void rest() {
    velocity_.setZero();
    turn_.setZero();
    buttons_ = 0;
  }

  /// Takes over what a report says; false when it cannot be one of this node's. Reports of other things (battery) are
  /// fine.
  bool take(size_t index, std::span<const uint8_t> bytes, int64_t now) {
    const HidInputs& inputs = nodes_[index].inputs;
    const uint8_t id = inputs.numbered ? bytes[0] : uint8_t{0};
    const auto payload = bytes.subspan(inputs.numbered ? 1 : 0);
    for (const HidField& f : inputs.fields) {
      if (f.report != id) continue;
      const std::optional<int32_t> value = hidValue(f, payload);
      if (!value) return false;
      if (isAxis(f)) {
        // Of several pucks on one receiver the one that speaks is held, until it was silent.
        if (index != speaker_ && now - heard_ <= kStillNs) continue;
        const double full = 0.5 * (double(f.most) - f.least), middle = 0.5 * (double(f.most) + f.least);
        const double part = (*value - middle) / full;
        if (!(std::abs(part) <= kFarthest)) return false;
        if (index != speaker_) rest();
        speaker_ = index;
        setAxis(f.usage - kFirstAxis, part);
      } else if (f.page == kButtons && f.usage >= 1 && f.usage <= 32) {
        const uint32_t bit = uint32_t{1} << (f.usage - 1);
        buttons_ = *value ? buttons_ | bit : buttons_ & ~bit;
      }
    }
    for (const HidArray& array : inputs.arrays) {
      if (array.report != id) continue;
      uint32_t all = 0, held = 0;
      for (const uint32_t usage : array.usages) all |= buttonBit(usage);
      if (!hidHeld(array, payload, [&](uint32_t usage) { held |= buttonBit(usage); })) return false;
      buttons_ = (buttons_ & ~all) | held;
    }
    if (index == speaker_) heard_ = now;
    return true;
  }

  static uint32_t buttonBit(uint32_t usage) {
    const uint32_t button = usage & 0xFFFF;
    return usage >> 16 == kButtons && button >= 1 && button <= 32 ? uint32_t{1} << (button - 1) : 0u;
  }

  void setAxis(int axis, double part) {
    part = std::clamp(part, -1.0, 1.0);
    const double beyond = std::max(0.0, std::abs(part) - options_.deadZone) / (1 - options_.deadZone);
    // The device's own axes are x right, y towards the person, z down: half a turn about x from ours.
    const double value = std::copysign(beyond, axis % 3 == 0 ? part : -part);
    if (axis < 3)
      velocity_[axis] = options_.topSpeedMms * value;
    else
      turn_[axis - 3] = options_.topTurnRads * value;
  }

  // Some devices go a little beyond the range that they name; twice is none of theirs.
  static constexpr double kFarthest = 2;

  SpaceMouseOptions options_;
  std::unique_ptr<HidSource> source_;
  std::vector<Node> nodes_;
  size_t speaker_ = 0;  // The node whose axes count.
  Pose pose_;
  Vec3d velocity_ = Vec3d::Zero(), turn_ = Vec3d::Zero();  // mm/s, rad/s.
  uint32_t buttons_ = 0;
  int64_t last_ = 0, heard_ = 0, spoiledUntil_ = 0;
};

}  // namespace

bool isSpaceMouse(uint16_t vendor, uint16_t product) noexcept {
  if (vendor == 0x256F) return true;
  constexpr uint16_t kLogitech[] = {0xC603, 0xC605, 0xC606, 0xC621, 0xC623, 0xC625,
                                    0xC626, 0xC627, 0xC628, 0xC629, 0xC62B, 0xC640};
  return vendor == 0x046D && std::find(std::begin(kLogitech), std::end(kLogitech), product) != std::end(kLogitech);
}

std::vector<HidNode> spaceMice(const std::vector<HidNode>& all) {
  std::vector<HidNode> found;
  for (const HidNode& n : all) {
    const auto same = [&](const HidNode& other) { return other.device == n.device; };
    if (isSpaceMouse(n.vendor, n.product) && n.sixAxes && std::none_of(found.begin(), found.end(), same))
      found.push_back(n);
  }
  return found;
}

std::vector<HidNode> hidNodes(const std::string& sys, const std::string& dev) {
  std::vector<HidNode> nodes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(fs::path(sys) / "class" / "hidraw", none)) {
    HidNode node;
    node.node = (fs::path(dev) / entry.path().filename()).string();
    std::string place, unique;
    std::ifstream in(entry.path() / "device" / "uevent");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("HID_NAME=")) node.name = line.substr(9);
      // usb-0000:00:14.0-4/input2: what follows the last stroke is the interface. By radio it is the host, and what is
      // unique the device.
      if (line.starts_with("HID_PHYS="))
        place = line.substr(9, line.rfind("/input") == std::string::npos ? line.npos : line.rfind("/input") - 9);
      if (line.starts_with("HID_UNIQ=")) unique = line.substr(9);
      if (!line.starts_with("HID_ID=")) continue;  // HID_ID=bus:vendor:product, in hexadecimal.
      const size_t first = line.find(':'), second = line.find(':', first + 1);
      if (first == std::string::npos || second == std::string::npos) continue;
      uint32_t vendor = 0, product = 0;
      std::from_chars(line.data() + first + 1, line.data() + second, vendor, 16);
      std::from_chars(line.data() + second + 1, line.data() + line.size(), product, 16);
      node.vendor = static_cast<uint16_t>(vendor);
      node.product = static_cast<uint16_t>(product);
    }
    node.device = place.empty() && unique.empty() ? node.node : place + " " + unique;
    // The descriptor is there for all to read; where it is not, the node itself tells when it is opened.
    std::ifstream raw(entry.path() / "device" / "report_descriptor", std::ios::binary);
    const std::vector<uint8_t> descriptor{std::istreambuf_iterator<char>(raw), {}};
    std::string why;
    if (!descriptor.empty()) {
      const auto inputs = parseHidDescriptor(descriptor, why);
      node.sixAxes = inputs && sixAxes(*inputs);
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
  if (!(options.topSpeedMms >= 1 && options.topSpeedMms <= 1000))
    throw Error("spacemouse: the top speed must be 1 to 1000 mm/s");
  if (!(options.topTurnRads >= 0 && options.topTurnRads <= 20))
    throw Error("spacemouse: the top turn must be 0 to 20 rad/s");
  if (!(options.deadZone >= 0 && options.deadZone <= 0.5)) throw Error("spacemouse: the dead zone must be 0 to 0.5");
  if (!(options.boxMm.allFinite() && options.boxMm.minCoeff() > 0))
    throw Error("spacemouse: the box must have edges above zero");
  DeviceSheet sheet = spaceMouseSheet();
  sheet.workspaceMm = options.boxMm;
  sheet.resolutionMm = options.topSpeedMms / sheet.rateHz;
  ThreadedDevice::Options thread;
  thread.lateSeconds = 0.02;  // Nobody feels it: a stall of the machine is no fault here.
  thread.realtime = false;
  return std::make_unique<ThreadedDevice>(sheet, std::make_unique<SpaceMouseLink>(options, std::move(source)), thread);
}

}  // namespace argil::haptics
