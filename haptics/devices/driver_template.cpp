#include "haptics/devices/driver_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "clay/base/error.h"
#include "haptics/devices/device_thread.h"
#include "haptics/devices/serial_port.h"

namespace argil::haptics {
namespace {

// 5. The bytes, as pure functions: units are converted here and nowhere else.
constexpr double kMnPerN = 1000, kStepsPerMm = 100;

uint8_t check(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (uint8_t b : bytes) sum ^= b;
  return sum;
}

std::array<uint8_t, 8> forcePacket(const Vec3d& forceN) {
  std::array<uint8_t, 8> packet{'F'};
  for (int a = 0; a < 3; ++a) {
    // Never up: not over the sheet.
    const auto mn = static_cast<int16_t>(std::clamp(std::trunc(kMnPerN * forceN[a]), -32767.0, 32767.0));
    packet[static_cast<size_t>(1 + 2 * a)] = static_cast<uint8_t>(mn);
    packet[static_cast<size_t>(2 + 2 * a)] = static_cast<uint8_t>(mn >> 8);
  }
  packet[7] = check(std::span(packet).first(7));
  return packet;
}

bool decode(std::span<const uint8_t, 9> answer, DeviceState& state) {
  if (answer[0] != 'P' || answer[8] != check(answer.first(8))) return false;
  for (size_t a = 0; a < 3; ++a)
    state.pose.translation[static_cast<int>(a)] =
        static_cast<int16_t>(answer[1 + 2 * a] | answer[2 + 2 * a] << 8) / kStepsPerMm;
  state.buttons = answer[7];
  state.pressure = state.buttons ? 1.0f : 0.0f;
  return true;
}

// 6. The link. ThreadedDevice calls it on a thread of its own and does the rest: states, reconnecting, zero force when
// anything is wrong, no force over the sheet, hand-offs to the servo.
class TemplateLink final : public DeviceLink {
 public:
  explicit TemplateLink(std::string port) : name_(std::move(port)) {}
  ~TemplateLink() override { shut(); }

  // 6a. Find it and greet it. Leave nothing open unless it is ready; say in a sentence what a person can do.
  Opened open(std::string& sentence) override {
    switch (port_.open(name_, sentence)) {
      case SerialPort::Opened::absent:
        return Opened::absent;
      case SerialPort::Opened::refused:
        return Opened::refused;
      case SerialPort::Opened::ready:
        break;
    }
    sentence = name_;
    return Opened::ready;
  }

  // 6b. One exchange: force out, state in, no later than the deadline. Judge what comes before you believe it.
  Exchanged exchange(const Vec3d& forceN, int64_t deadlineNs, DeviceState& state) noexcept override {
    // An answer that came late must not be taken for this one's.
    if (!port_.discardInput()) return Exchanged::garbage;
    const int written = port_.write(forcePacket(forceN));
    if (written != 1) return written < 0 ? Exchanged::gone : Exchanged::nothing;
    std::array<uint8_t, 9> answer;
    const int got = port_.readAll(answer, deadlineNs);
    if (got != 1) return got < 0 ? Exchanged::gone : Exchanged::nothing;
    return decode(answer, state) ? Exchanged::state : Exchanged::garbage;
  }

  // 6c. Zero force, then closed, however often it is called.
  void close() noexcept override { shut(); }

 private:
  void shut() {
    if (!port_.isOpen()) return;
    (void)port_.write(forcePacket(Vec3d::Zero()));
    port_.close();
  }

  std::string name_;
  SerialPort port_;
};

}  // namespace

const DeviceSheet& templateSheet() {
  static const DeviceSheet sheet = [] {
    DeviceSheet s;
    s.name = "template";
    s.like = "a made-up arm";
    s.workspaceMm = {160, 120, 70};
    s.peakForceN = 3;
    s.continuousForceN = 1;
    s.resolutionMm = 1 / kStepsPerMm;
    s.topStiffnessNmm = 1;
    s.topDampingNsmm = 0.002;
    s.rateHz = 1000;
    s.buttons = 8;
    return s;
  }();
  return sheet;
}

std::unique_ptr<Device> openTemplate(const TemplateOptions& options) {
  if (options.port.empty()) throw Error("template: name its serial line, such as /dev/ttyACM0");
  return std::make_unique<ThreadedDevice>(templateSheet(), std::make_unique<TemplateLink>(options.port));
}

// 7. An emulator in tests/support/ that speaks the same bytes (template_emulator.h is fifty lines), and a rig in
//    tests/unit/haptics/device_conformance_rigs.cpp: the suite then tries all that can go wrong.
// 8. Finding and opening it by name: haptics/devices/registry.cpp, a row in each of its two tables.
// 9. Rights without root: a line in installer/99-argil.rules. What is estimated or to be checked on hardware:
// haptics/devices/NOTES.md.

}  // namespace argil::haptics
