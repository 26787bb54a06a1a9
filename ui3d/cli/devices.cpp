// argil devices: what can be held, and a live try of it.

#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "clay/primitives.h"
#include "clay/store.h"
#include "haptics/bare_loop.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

namespace {

void list() {
  fmt::print("Simulated devices (no driver for hardware is built in yet):\n");
  fmt::print("  {:<10} {:>12} {:>14} {:>10} {:>10} {:>9}  {}\n", "name", "peak N", "continuous N", "step mm", "top N/mm", "rate Hz", "like");
  for (const haptics::DeviceSheet& s : haptics::deviceSheets())
    fmt::print("  {:<10} {:>12.2f} {:>14.2f} {:>10.3f} {:>10.2f} {:>9.0f}  {}\n", s.name, s.peakForceN, s.continuousForceN, s.resolutionMm,
               s.topStiffnessNmm, s.rateHz, s.like);
}

// A hand presses the stylus into a block and leaves it, in real time.
void test(const std::string& name) {
  const haptics::DeviceSheet& sheet = haptics::deviceSheet(name);
  clay::Grid grid;
  haptics::Scene scene;
  scene.pieces.push_back({clay::makeBlock(clay::Store::make(), grid, Vec3d(0, 0, -15), Vec3d(60, 60, 20), 2), {}, 0});
  scene.tool.radiusMm = 3;
  haptics::Published<haptics::Scene> published;
  published.publish(std::make_unique<const haptics::Scene>(scene));
  const Vec3d above(0, 0, 5), pressed(5, 0, -6);
  haptics::SimulatedDevice device(sheet, haptics::HandPath::line(above, pressed, 1.5).then(haptics::HandPath::line(pressed, above, 1.5)));
  haptics::Servo servo(device, published);
  haptics::BareLoop bare(servo.rateHz());
  fmt::print("{}: 3 s at {:.0f} Hz against a block\n", name, servo.rateHz());
  const haptics::RealtimeGrant grant = servo.start();
  bare.start();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  bare.stop();
  servo.stop();
  const haptics::ServoStatistics& s = servo.statistics();
  fmt::print("  {}\n", grant.sentence);
  fmt::print("  ticks       {} ({} touching, {} missed, {} overrun)\n", s.ticks, s.touching, s.missed, s.overrun);
  fmt::print("  compute     median {:.1f}, p99 {:.1f}, p99.9 {:.1f} µs\n", s.compute.quantileUs(0.5), s.compute.quantileUs(0.99), s.compute.quantileUs(0.999));
  fmt::print("  lateness    median {:.1f}, p99 {:.1f}, p99.9 {:.1f} µs (bare sleep loop {:.1f}, {:.1f}, {:.1f})\n", s.lateness.quantileUs(0.5),
             s.lateness.quantileUs(0.99), s.lateness.quantileUs(0.999), bare.lateness().quantileUs(0.5), bare.lateness().quantileUs(0.99),
             bare.lateness().quantileUs(0.999));
  fmt::print("  peak force  {:.2f} of {:.2f} N\n", s.peakForceN, sheet.peakForceN);
  if (servo.fault() != haptics::Fault::none) throw Error(fmt::format("device {}: its force was stopped; {}", name, grant.sentence), Error::Kind::work);
  if (s.touching == 0) throw Error(fmt::format("device {}: the block was never felt", name), Error::Kind::work);
}

}  // namespace

void devices(const DevicesOptions& options) {
  if (options.test.empty())
    list();
  else
    test(options.test);
}

}  // namespace argil::cli
