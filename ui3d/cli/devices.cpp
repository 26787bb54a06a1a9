// argil devices: what is plugged in, what it can do, and a live try of it.

#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/base/clock.h"
#include "haptics/devices/registry.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo.h"
#include "haptics/threads/bare_loop.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

namespace {

constexpr double kGentle = 0.1;         // Of a device's peak: what a test may push with. Nobody was asked to hold on.
constexpr double kPatienceSeconds = 2;  // For a device to be ready.
constexpr double kClearMm = 10;         // The block of a test lies so far from the hand.

void list() {
  const auto found = haptics::findDevices();
  if (found.empty())
    fmt::print("Plugged in: nothing that Argil drives (Novint Falcon, Haply Inverse3, 3Dconnexion SpaceMouse)\n");
  else
    fmt::print("Plugged in:\n");
  for (const haptics::FoundDevice& d : found)
    fmt::print("  {:<28} {}{}\n", d.name, d.what, d.problem.empty() ? "" : " — " + d.problem);
  fmt::print("\nRecorded: recorded:FILE, a hand path (CSV)\n\nSimulated:\n");
  fmt::print("  {:<20} {:>8} {:>14} {:>10} {:>10} {:>9}  {}\n", "name", "peak N", "continuous N", "step mm", "top N/mm",
             "rate Hz", "like");
  for (const haptics::DeviceSheet& s : haptics::deviceSheets())
    fmt::print("  {:<20} {:>8.2f} {:>14.2f} {:>10.3f} {:>10.2f} {:>9.0f}  {}\n", "simulated:" + s.name, s.peakForceN,
               s.continuousForceN, s.resolutionMm, s.topStiffnessNmm, s.rateHz, s.like);
  fmt::print("\nAll of a sheet: argil devices --sheet NAME; a live test: argil devices --test NAME\n");
}

const char* inWords(haptics::Handedness handedness) {
  switch (handedness) {
    case haptics::Handedness::left:
      return "left hand";
    case haptics::Handedness::right:
      return "right hand";
    case haptics::Handedness::either:
      break;
  }
  return "either hand";
}

void printSheet(const std::string& name) {
  const haptics::DeviceSheet s = haptics::sheetOfDevice(name);
  const bool moved = s.dofOut > 0;
  fmt::print("{}: {}\n", name, s.like);
  fmt::print("  degrees of freedom   {} in, {} out\n", s.dofIn, s.dofOut);
  fmt::print("  workspace            {:.0f} × {:.0f} × {:.0f} mm\n", s.workspaceMm.x(), s.workspaceMm.y(),
             s.workspaceMm.z());
  fmt::print("  step                 {:.3f} mm\n", s.resolutionMm);
  fmt::print("  rate                 {:.0f} Hz\n", s.rateHz);
  fmt::print("  top speed            {:.0f} mm/s, a fault beyond\n", s.topSpeedMms);
  fmt::print("  buttons              {}\n", s.buttons);
  fmt::print("  handedness           {}\n", inWords(s.handedness));
  if (!moved) {
    fmt::print("  force                none: it is not felt; contact reckons with {:.2g} N and {:.2g} N/mm\n",
               s.peakForceN, s.topStiffnessNmm);
    return;
  }
  fmt::print("  force                {:.2f} N peak, {:.2f} N continuous\n", s.peakForceN, s.continuousForceN);
  fmt::print("  top stiffness        {:.2f} N/mm at 1 kHz\n", s.topStiffnessNmm);
  fmt::print("  top damping          {:.4f} N·s/mm at 1 kHz\n", s.topDampingNsmm);
  if (haptics::isHardware(name)) return;
  fmt::print("  moving mass          {:.0f} g\n", 1000 * s.massKg);
  fmt::print("  friction             {:.2f} N, {:.4f} N·s/mm\n", s.frictionN, s.dampingNsmm);
}

/// Another device with a smaller peak, so that everything from contact to safety stays below it.
class GentleDevice final : public haptics::Device {
 public:
  explicit GentleDevice(haptics::Device& device) : device_(device), sheet_(device.sheet()) {
    sheet_.peakForceN *= kGentle;
    sheet_.continuousForceN = std::min(sheet_.continuousForceN, sheet_.peakForceN);
  }
  const haptics::DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double timeS, haptics::DeviceState& state) ARGIL_REALTIME override { return device_.read(timeS, state); }
  void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME override { device_.write(timeS, forceN); }
  haptics::ForceGate& gate() const noexcept override { return device_.gate(); }
  double delayS() const ARGIL_REALTIME override { return device_.delayS(); }

 private:
  haptics::Device& device_;
  haptics::DeviceSheet sheet_;
};

// Waits until the device says where it is; throws with its own sentence when it does not.
haptics::DeviceState firstState(haptics::Device& device) {
  const int64_t begin = haptics::nowNs();
  haptics::DeviceState state;
  while (!device.read(double(haptics::nowNs() - begin) * 1e-9, state)) {
    if (double(haptics::nowNs() - begin) * 1e-9 > kPatienceSeconds) throw Error(device.status(), Error::Kind::work);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return state;
}

// A block 10 mm from the hand of a real device, down the device's z, forces at a tenth of its peak; or a simulated hand
// that presses into a block and leaves it. In real time.
void test(const std::string& name, const std::string& firmware) {
  const bool hardware = haptics::isHardware(name);
  const haptics::DeviceSheet sheet = haptics::sheetOfDevice(name);
  const bool simulated = !hardware && sheet.dofOut > 0;
  const Vec3d above(0, 0, 5), pressed(5, 0, -6);
  std::unique_ptr<haptics::Device> device;
  haptics::OpenDeviceOptions options;
  options.falconFirmware = firmware;
  if (simulated)
    device = std::make_unique<haptics::SimulatedDevice>(
        sheet, haptics::HandPath::line(above, pressed, 1.5).then(haptics::HandPath::line(pressed, above, 1.5)));
  else
    device = haptics::openDevice(name, options);
  const double seconds = 3;
  Vec3d top(0, 0, -5);  // Middle of the block's upper face.
  if (hardware) top = firstState(*device).pose.translation - Vec3d(0, 0, kClearMm);

  clay::Grid grid;
  grid.originMm = top;
  haptics::Scene scene;
  scene.pieces.push_back(
      {clay::makeBlock(clay::Store::make(), grid, top - Vec3d(0, 0, 10), Vec3d(60, 60, 20), 2), {}, 0});
  scene.tool.radiusMm = 3;
  haptics::Published<haptics::Scene> published;
  published.publish(std::make_unique<const haptics::Scene>(scene));
  GentleDevice gentle(*device);
  haptics::Device& felt = hardware ? static_cast<haptics::Device&>(gentle) : *device;
  haptics::Servo servo(felt, published);
  haptics::BareLoop bare(servo.rateHz());
  fmt::print("{}: {:.0f} s at {:.0f} Hz against a block{}\n", name, seconds, servo.rateHz(),
             hardware ? fmt::format(" {:.0f} mm from the stylus, down its own z; forces stay below {:.2f} N", kClearMm,
                                    felt.sheet().peakForceN)
                      : "");
  const haptics::RealtimeGrant grant = servo.start();
  bare.start();
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const std::string status = device->status();
  const double delayS = felt.delayS();
  bare.stop();
  servo.stop();
  const haptics::ServoStatistics& s = servo.statistics();
  fmt::print("  {}\n", grant.sentence);
  fmt::print("  device      {}\n", status);
  fmt::print("  ticks       {} ({} touching, {} missed, {} overrun, {} without a new state)\n", s.ticks, s.touching,
             s.missed, s.overrun, s.stale);
  fmt::print("  compute     median {:.1f}, p99 {:.1f}, p99.9 {:.1f} µs\n", s.compute.quantileUs(0.5),
             s.compute.quantileUs(0.99), s.compute.quantileUs(0.999));
  fmt::print("  lateness    median {:.1f}, p99 {:.1f}, p99.9 {:.1f} µs (bare sleep loop {:.1f}, {:.1f}, {:.1f})\n",
             s.lateness.quantileUs(0.5), s.lateness.quantileUs(0.99), s.lateness.quantileUs(0.999),
             bare.lateness().quantileUs(0.5), bare.lateness().quantileUs(0.99), bare.lateness().quantileUs(0.999));
  if (sheet.dofOut > 0)
    fmt::print("  loop        {:.1f} ms from a state to the force that answers it; coupled at {:.2f} of {:.2f} N/mm\n",
               1e3 * delayS, servo.tick().coupling().stiffnessNmm, sheet.topStiffnessNmm);
  const haptics::StylusSample& last = servo.tick().last();
  fmt::print("  stylus      at {:.1f}, {:.1f}, {:.1f} mm, buttons {:#x}\n", last.device.translation.x(),
             last.device.translation.y(), last.device.translation.z(), last.buttons);
  fmt::print("  peak force  {:.2f} of {:.2f} N\n", s.peakForceN, sheet.peakForceN);
  if (servo.fault() != haptics::Fault::none)
    throw Error(fmt::format("device {}: its force was stopped: {}", name, haptics::sentence(servo.fault())),
                Error::Kind::work);
  if (hardware && s.stale > s.ticks / 2) throw Error(status, Error::Kind::work);
  if (simulated && s.touching == 0)
    throw Error(fmt::format("device {}: the block was never felt", name), Error::Kind::work);
}

}  // namespace

void devices(const DevicesOptions& options) {
  if (!options.sheet.empty()) printSheet(options.sheet);
  if (!options.test.empty()) test(options.test, options.firmware);
  if (options.sheet.empty() && options.test.empty()) list();
}

}  // namespace argil::cli
