// The delay of the loop: measured through the device's thread, and what the servo makes of it.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "haptics/base/clock.h"
#include "haptics/contact/coupling.h"
#include "haptics/devices/device_thread.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo_tick.h"
#include "haptics/threads/delay_meter.h"

namespace argil::haptics {
namespace {

TEST(DelayMeter, TellsTheMedianAndGoesUpAtOnceAndDownSlowly) {
  DelayMeter meter(0.002);
  EXPECT_EQ(meter.delayS(), 0.002);
  for (int i = 0; i < DelayMeter::kFirst; ++i) {
    EXPECT_EQ(meter.delayS(), 0.002) << "a guess until it is measured";
    meter.add(i % 10 == 0 ? 0.5 : 0.0011);  // One in ten is a hiccup.
  }
  EXPECT_NEAR(meter.delayS(), 0.0011, 5e-5);
  for (int i = 0; i < DelayMeter::kWindow; ++i) meter.add(0.004);
  EXPECT_NEAR(meter.delayS(), 0.004, 5e-5);
  for (int i = 0; i < DelayMeter::kWindow; ++i) meter.add(0.001);
  EXPECT_NEAR(meter.delayS(), 0.00325, 1e-4) << "a quarter of the way";
  for (int i = 0; i < 20 * DelayMeter::kWindow; ++i) meter.add(0.001);
  EXPECT_NEAR(meter.delayS(), 0.001, 1e-4);
  for (double bad : {-1.0, 1e9, std::nan(""), double(INFINITY)})
    for (int i = 0; i < DelayMeter::kWindow; ++i) meter.add(bad);
  EXPECT_LE(meter.delayS(), DelayMeter::kMostS);
}

// A device's thread in virtual time: exchanges of known length against ticks of known phase.
TEST(ThreadedDeviceDelay, IsTheWayFromAStateToTheForceThatAnswersIt) {
  constexpr int64_t kTick = 1'000'000;
  for (const int64_t length : {100'000, 300'000, 900'000})
    for (const int64_t phase : {0, 250'000, 700'000}) {
      DeviceSheet sheet = deviceSheet("falcon");
      ThreadedDevice::Options options;
      options.manual = true;
      ThreadedDevice device(sheet, nullptr, options);
      EXPECT_DOUBLE_EQ(device.delayS(), 0.002) << "two exchanges, until it is known";
      DeviceState state;
      // Both at 1 kHz: the command waits for the exchange, the answer for the tick.
      for (int64_t i = 1; i < 600; ++i) {
        const int64_t tick = i * kTick, begin = tick + 1000 + phase, end = begin + length;
        device.read(double(tick) * 1e-9, state);
        device.write(double(tick) * 1e-9, Vec3d(0, 0, 1));
        (void)device.begin(begin);
        // Ends before the next tick or after it.
        if (end <= tick + kTick) {
          device.end(DeviceLink::Exchanged::state, {}, end);
        } else {
          ++i;
          device.read(double(i * kTick) * 1e-9, state);
          device.write(double(i * kTick) * 1e-9, Vec3d(0, 0, 1));
          device.end(DeviceLink::Exchanged::state, {}, end);
        }
      }
      const double wanted = phase + 1000 + length <= kTick ? 1e-3 : 2e-3;
      EXPECT_NEAR(device.delayS(), wanted, 6e-5)
          << "exchange of " << length << " ns, " << phase << " ns after the tick";
    }
}

TEST(ThreadedDeviceDelay, OfADeviceThatExchangesOftenIsThatOfTheLastExchange) {
  DeviceSheet sheet = deviceSheet("falcon");
  sheet.rateHz = 8000;
  ThreadedDevice::Options options;
  options.manual = true;
  ThreadedDevice device(sheet, nullptr, options);
  DeviceState state;
  for (int i = 1; i < 600; ++i) {
    const double tick = i * 1e-3;
    device.read(tick, state);
    device.write(tick, Vec3d(0, 0, 1));
    for (int k = 0; k < 8; ++k) {
      const auto begin = static_cast<int64_t>((tick + 0.00002 + k * 0.000125) * 1e9);
      (void)device.begin(begin);
      device.end(DeviceLink::Exchanged::state, {}, begin + 60'000);
    }
  }
  // The command waits 20 µs for its first exchange; the last state is 105 µs old: 60 µs of exchange and a wait.
  EXPECT_NEAR(device.delayS(), 0.000125, 6e-5);
}

TEST(ThreadedDeviceDelay, IsNothingWhereNothingPushes) {
  DeviceSheet sheet = deviceSheet("falcon");
  sheet.dofOut = 0;
  ThreadedDevice::Options options;
  options.manual = true;
  EXPECT_EQ(ThreadedDevice(sheet, nullptr, options).delayS(), 0);
}

/// A simulated device that says to be late.
class LateDevice final : public Device {
 public:
  LateDevice() : device_(deviceSheet("premium15"), HandPath::hold({0, 0, 0}, 10)) {}
  const DeviceSheet& sheet() const noexcept override { return device_.sheet(); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override { return device_.read(timeS, state); }
  void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME override { device_.write(timeS, forceN); }
  ForceGate& gate() const noexcept override { return device_.gate(); }
  double delayS() const ARGIL_REALTIME override { return late; }
  double late = 0;

 private:
  SimulatedDevice device_;
};

TEST(ServoTickDelay, CouplesALateDeviceMoreSoftly) {
  LateDevice device;
  Published<Scene> published;
  published.publish(std::make_unique<const Scene>());
  SampleRing ring(1000);
  ServoTick tick(device, published, ring, 1e-3);
  double before = 1e9, timeS = 0;
  for (const double late : {0.0, 0.001, 0.002, 0.005, 0.02}) {
    device.late = late;
    tick.run(timeS += 1e-3, false);
    const double stiffness = tick.coupling().stiffnessNmm;
    EXPECT_DOUBLE_EQ(stiffness, coupleTo(device.sheet(), 1e-3, std::min(late, DelayMeter::kMostS)).stiffnessNmm);
    EXPECT_LT(stiffness, before);
    before = stiffness;
  }
  device.late = 0;
  tick.run(timeS += 1e-3, false);
  EXPECT_DOUBLE_EQ(tick.coupling().stiffnessNmm, coupleTo(device.sheet(), 1e-3).stiffnessNmm);
}

TEST(Coupling, KnowsTheSheetsRate) {
  DeviceSheet slow = deviceSheet("premium15"), fast = slow;
  slow.rateHz = 125;
  fast.rateHz = 4000;
  EXPECT_NEAR(couplingBounds(slow, 1e-3).colgateBrownNmm, couplingBounds(slow, 1.0 / 125).colgateBrownNmm, 1e-12)
      << "a servo that turns faster than its device exchanges wins nothing";
  EXPECT_LT(coupleTo(slow, 1e-3).stiffnessNmm, 0.5 * coupleTo(fast, 1e-3).stiffnessNmm);
}

// What a link was told: closed once for each time that it was open, before it is opened again.
struct Link final : DeviceLink {
  std::atomic<int>&opened, &closed;
  std::atomic<bool>& wrong;
  Link(std::atomic<int>& o, std::atomic<int>& c, std::atomic<bool>& w) : opened(o), closed(c), wrong(w) {}
  Opened open(std::string&) override {
    if (closed != opened) wrong = true;
    ++opened;
    return Opened::ready;
  }
  // Gone as soon as it is looked at.
  Exchanged exchange(const Vec3d&, int64_t, DeviceState&) noexcept override { return Exchanged::gone; }
  void close() noexcept override { ++closed; }
};

TEST(ThreadedDevice, ClosesWhatIsGoneBeforeItLooksForItAgain) {
  std::atomic<int> opened{0}, closed{0};
  std::atomic<bool> wrong{false};
  {
    ThreadedDevice device(deviceSheet("falcon"), std::make_unique<Link>(opened, closed, wrong));
    const int64_t end = nowNs() + 30'000'000'000;
    while (opened < 3 && nowNs() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(opened, 3);
  EXPECT_EQ(closed, opened) << "the last one too";
  EXPECT_FALSE(wrong);
}

}  // namespace
}  // namespace argil::haptics
