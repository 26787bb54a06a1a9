#include "spacemouse_emulator.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>

#include "haptics/servo/servo.h"

namespace argil::haptics::testing {

using namespace std::chrono_literals;

std::span<const uint8_t> SpaceMouseEmulator::descriptor(Layout layout) {
  // As read from the devices by lsusb and kin; the parts that follow (vendor features) add nothing to the input.
  static const uint8_t two[] = {
      0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xA1, 0x00, 0x85, 0x01, 0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x36, 0x88, 0xFA,
      0x46, 0x78, 0x05, 0x55, 0x0C, 0x65, 0x11, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x75, 0x10, 0x95, 0x03, 0x81, 0x06,
      0xC0, 0xA1, 0x00, 0x85, 0x02, 0x09, 0x33, 0x09, 0x34, 0x09, 0x35, 0x75, 0x10, 0x95, 0x03, 0x81, 0x06, 0xC0, 0xA1,
      0x02, 0x85, 0x03, 0x05, 0x01, 0x05, 0x09, 0x19, 0x01, 0x29, 0x02, 0x15, 0x00, 0x25, 0x01, 0x35, 0x00, 0x45, 0x01,
      0x75, 0x01, 0x95, 0x02, 0x81, 0x02, 0x95, 0x0E, 0x81, 0x03, 0xC0, 0xA1, 0x02, 0x85, 0x04, 0x05, 0x08, 0x09, 0x4B,
      0x15, 0x00, 0x25, 0x01, 0x95, 0x01, 0x75, 0x01, 0x91, 0x02, 0x95, 0x01, 0x75, 0x07, 0x91, 0x03, 0xC0, 0xC0};
  static const uint8_t one[] = {
      0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xA1, 0x00, 0x85, 0x01, 0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x36,
      0x88, 0xFA, 0x46, 0x78, 0x05, 0x55, 0x0C, 0x65, 0x11, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x09, 0x33,
      0x09, 0x34, 0x09, 0x35, 0x75, 0x10, 0x95, 0x06, 0x81, 0x02, 0xC0, 0xA1, 0x02, 0x85, 0x03, 0x05, 0x01,
      0x05, 0x09, 0x19, 0x01, 0x29, 0x02, 0x15, 0x00, 0x25, 0x01, 0x35, 0x00, 0x45, 0x01, 0x75, 0x01, 0x95,
      0x02, 0x81, 0x02, 0x95, 0x0E, 0x81, 0x03, 0xC0, 0xA1, 0x02, 0x85, 0x17, 0x15, 0x00, 0x25, 0x64, 0x55,
      0x00, 0x65, 0x00, 0x05, 0x06, 0x09, 0x20, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xC0, 0xC0};
  // The axes as above; buttons as HID 1.11 has arrays (6.2.2.5): four bytes, each the number of a button that is held,
  // or 0.
  static const std::vector<uint8_t> array = [] {
    std::vector<uint8_t> d;
    for (size_t i = 0; i < 45; ++i) d.push_back(one[i]);
    const uint8_t list[] = {0xA1, 0x02, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29, 0x20, 0x15,
                            0x01, 0x25, 0x20, 0x75, 0x08, 0x95, 0x04, 0x81, 0x00, 0xC0, 0xC0};
    for (const uint8_t byte : list) d.push_back(byte);
    return d;
  }();
  if (layout == Layout::buttonArray) return array;
  return layout == Layout::twoReports ? std::span<const uint8_t>(two) : std::span<const uint8_t>(one);
}

class SpaceMouseEmulator::Source final : public HidSource {
 public:
  explicit Source(SpaceMouseEmulator& emulator) : emulator_(emulator) {}
  ~Source() override { close(); }
  DeviceLink::Opened open(std::string& sentence) override {
    close();
    for (const int fd : emulator_.connect()) {
      const auto d = SpaceMouseEmulator::descriptor(emulator_.layout_);
      nodes_.push_back({{d.begin(), d.end()}, fd});
    }
    sentence = nodes_.empty() ? "not plugged in" : "emulated";
    return nodes_.empty() ? DeviceLink::Opened::absent : DeviceLink::Opened::ready;
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
  SpaceMouseEmulator& emulator_;
  std::vector<Node> nodes_;
};

SpaceMouseEmulator::SpaceMouseEmulator(Layout layout) : layout_(layout), thread_([this] { run(); }) {}

SpaceMouseEmulator::~SpaceMouseEmulator() {
  stop_.store(true);
  thread_.join();
  unplug();
}

std::unique_ptr<HidSource> SpaceMouseEmulator::source() {
  return std::make_unique<Source>(*this);
}

std::vector<int> SpaceMouseEmulator::connect() {
  const std::scoped_lock lock(mutex_);
  if (!plugged_) return {};
  for (const int fd : far_) close(fd);
  far_.clear();
  std::vector<int> near;
  for (int i = 0; i < (layout_ == Layout::receiver ? 5 : 1); ++i) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) continue;
    far_.push_back(ends[0]);
    near.push_back(ends[1]);
  }
  return near;
}

void SpaceMouseEmulator::speaks(size_t interface) {
  const std::scoped_lock lock(mutex_);
  speaks_ = interface;
}

void SpaceMouseEmulator::talksWithoutEnd(bool endless) {
  const std::scoped_lock lock(mutex_);
  endless_ = endless;
}

void SpaceMouseEmulator::deflect(const std::array<int, 6>& counts) {
  const std::scoped_lock lock(mutex_);
  counts_ = counts;
}

void SpaceMouseEmulator::second(const std::array<int, 6>& counts) {
  const std::scoped_lock lock(mutex_);
  second_ = counts;
}

void SpaceMouseEmulator::buttons(uint32_t held) {
  const std::scoped_lock lock(mutex_);
  held_ = held;
}

void SpaceMouseEmulator::plug() {
  const std::scoped_lock lock(mutex_);
  plugged_ = true;
}

void SpaceMouseEmulator::unplug() {
  const std::scoped_lock lock(mutex_);
  plugged_ = false;
  for (const int fd : far_) close(fd);
  far_.clear();
}

bool SpaceMouseEmulator::send(std::vector<uint8_t> report, size_t puck) {
  switch (misbehaviour_.load()) {
    case Misbehaviour::garbage:
      for (size_t i = 1; i < report.size(); ++i) report[i] = static_cast<uint8_t>(0x70 + i);  // Far beyond the range.
      break;
    case Misbehaviour::shortAnswers:
      report.resize(report.size() / 2);
      break;
    case Misbehaviour::silent:
      return false;
    default:
      break;
  }
  const size_t at = speaks_ + puck;
  return at < far_.size() && ::send(far_[at], report.data(), report.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0;
}

void SpaceMouseEmulator::run() {
  (void)becomeRealtime(90, false);  // A device reports whatever else this machine does.
  std::array<int, 6> last{};
  uint32_t lastHeld = 0;
  while (!stop_.load()) {
    if (!endless_)
      std::this_thread::sleep_for(8ms);
    else
      std::this_thread::yield();
    const std::scoped_lock lock(mutex_);
    for (int i = 0; endless_ && i < 4096 && send({3, 0, 0, 0, 0}); ++i) {
    }
    const bool moved = counts_ != std::array<int, 6>{} || last != counts_ || misbehaviour_.load() != Misbehaviour::none;
    last = counts_;
    if (moved) {
      std::vector<uint8_t> report{1};
      for (size_t a = 0; a < 6; ++a) {
        if (a == 3 && layout_ == Layout::twoReports) {
          (void)send(report);
          report = {2};
        }
        report.push_back(static_cast<uint8_t>(counts_[a]));
        report.push_back(static_cast<uint8_t>(counts_[a] >> 8));
      }
      (void)send(report);
    }
    if (second_ != std::array<int, 6>{}) {
      std::vector<uint8_t> report{1};
      for (const int count : second_) {
        report.push_back(static_cast<uint8_t>(count));
        report.push_back(static_cast<uint8_t>(count >> 8));
      }
      (void)send(report, 1);
    }
    if (held_ != lastHeld && layout_ == Layout::buttonArray) {
      std::vector<uint8_t> report{3};
      for (int button = 0; button < 32 && report.size() < 5; ++button)
        if (held_ >> button & 1) report.push_back(static_cast<uint8_t>(button + 1));
      report.resize(5, 0);
      (void)send(report);
    } else if (held_ != lastHeld) {
      (void)send({3, static_cast<uint8_t>(held_), 0});
    }
    lastHeld = held_;
  }
}

}  // namespace argil::haptics::testing
