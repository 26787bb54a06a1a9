// A device that is unplugged, late, silent or talks garbage feels nothing from that tick on, and the person is told;
// two devices at once know nothing of each other's trouble.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

/// A simulated device with a fault that begins and ends on command.
class FaultyDevice final : public Device {
 public:
  enum class Trouble { none, silent, notFinite, infinite, turned, farAway };

  explicit FaultyDevice(const char* sheet, const Vec3d& start = {0, 0, 6}, const Vec3d& end = {0, 0, 1.5})
      : device_(deviceSheet(sheet), HandPath::line(start, end, 0.3), prescribed()) {}
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return device_.sheet(); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override {
    const bool fresh = device_.read(timeS, state);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    switch (trouble) {
      case Trouble::none:
        break;
      case Trouble::silent:
        return false;
      case Trouble::notFinite:
        state.pose.translation.y() = nan;
        break;
      case Trouble::infinite:
        state.pose.translation.z() = -std::numeric_limits<double>::infinity();
        break;
      case Trouble::turned:
        state.pose.rotation.x() = nan;
        break;
      case Trouble::farAway:
        state.pose.translation.x() = 1e5;
        break;
    }
    return fresh;
  }
  void write(double timeS, const Vec3d& force) ARGIL_REALTIME override {
    told = force;
    device_.write(timeS, force);
  }
  ForceGate& gate() const noexcept override { return device_.gate(); }

  Trouble trouble = Trouble::none;
  Vec3d told = Vec3d::Zero();

 private:
  static SimulatedDevice::Options prescribed() {
    SimulatedDevice::Options options;
    options.prescribed = true;
    return options;
  }
  SimulatedDevice device_;
};

TEST(ServoStates, UnplugLateGarbageAndSilenceAreZeroInThatTick) {
  using Trouble = FaultyDevice::Trouble;
  for (const auto& [trouble, state, fault] : {std::tuple(Trouble::silent, ServoState::silent, Fault::none),
                                              {Trouble::notFinite, ServoState::stopped, Fault::notFinite},
                                              {Trouble::infinite, ServoState::stopped, Fault::notFinite},
                                              {Trouble::turned, ServoState::stopped, Fault::notFinite},
                                              {Trouble::farAway, ServoState::stopped, Fault::implausible}}) {
    testing::VirtualSession session(0.5, Tool());
    FaultyDevice device("touchx");
    Servo servo(device, session.published());
    EXPECT_EQ(servo.state(), ServoState::noScene) << "before the first tick";
    servo.runVirtual(500);
    EXPECT_EQ(servo.state(), ServoState::running);
    EXPECT_GT(device.told.norm(), 1.0);
    const Vec3d before = servo.tick().last().device.translation;
    device.trouble = trouble;
    servo.runVirtual(1);
    EXPECT_EQ(device.told, Vec3d::Zero()) << int(trouble);
    EXPECT_EQ(servo.state(), state);
    EXPECT_EQ(servo.fault(), fault);
    EXPECT_EQ(servo.tick().last().device.translation, before) << "the last place that was good is kept";
    EXPECT_GT(std::string(sentence(servo.state())).size(), 20u);
    servo.runVirtual(uint64_t(1.01 * kAwaySeconds * servo.rateHz()));
    // The device is back where it was, pressed into the clay: no force until that is small, or until a fault was looked
    // at.
    device.trouble = Trouble::none;
    servo.runVirtual(50);
    EXPECT_EQ(device.told, Vec3d::Zero());
    EXPECT_EQ(servo.state(), fault == Fault::none ? ServoState::waiting : ServoState::stopped);
  }
}

TEST(ServoStates, AGapOfOneTickComesBackGently) {
  testing::VirtualSession session(0.5, Tool());
  FaultyDevice device("touchx", {0, 0, 1.5}, {0, 0, 6});  // Comes out of the clay by itself.
  Servo servo(device, session.published());
  servo.runVirtual(400);
  EXPECT_EQ(servo.state(), ServoState::running);
  device.trouble = FaultyDevice::Trouble::silent;
  servo.runVirtual(1);
  device.trouble = FaultyDevice::Trouble::none;
  servo.runVirtual(1);
  EXPECT_EQ(servo.state(), ServoState::running) << "nothing pressed: at once";
}

TEST(ServoStates, EverySentenceIsItsOwn) {
  std::vector<std::string> seen;
  for (ServoState s : {ServoState::running, ServoState::warm, ServoState::waiting, ServoState::noScene,
                       ServoState::silent, ServoState::hung, ServoState::stopped})
    seen.emplace_back(sentence(s));
  for (Fault f : {Fault::none, Fault::notFinite, Fault::commandTooLarge, Fault::tooFast, Fault::implausible})
    seen.emplace_back(sentence(f));
  for (size_t i = 0; i < seen.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_NE(seen[i], seen[j]);
}

TEST(TwoDevices, FeelOneSceneAndOneMayFail) {
  testing::VirtualSession session(0.5, Tool());
  FaultyDevice left("touchx"), right("falcon", {20, 5, 6}, {20, 5, 2});
  Servo first(left, session.published()), second(right, session.published());
  // The second alone, to compare with.
  std::vector<Vec3d> alone;
  {
    FaultyDevice device("falcon", {20, 5, 6}, {20, 5, 2});
    Servo servo(device, session.published());
    for (int i = 0; i < 1000; ++i) {
      servo.runVirtual(1);
      alone.push_back(device.told);
    }
  }
  for (int i = 0; i < 1000; ++i) {
    if (i == 500) left.trouble = FaultyDevice::Trouble::silent;
    if (i == 700) left.trouble = FaultyDevice::Trouble::notFinite;
    first.runVirtual(1);
    second.runVirtual(1);
    ASSERT_EQ(right.told, alone[size_t(i)]) << "tick " << i;
    if (i == 499) {
      EXPECT_GT(left.told.norm(), 1.0);
    }
    if (i >= 500) {
      ASSERT_EQ(left.told, Vec3d::Zero());
    }
  }
  EXPECT_GT(right.told.norm(), 0.9);
  EXPECT_EQ(first.state(), ServoState::stopped);
  EXPECT_EQ(second.state(), ServoState::running);
}

TEST(TwoDevices, RunPacedWhileScenesArePublished) {
  testing::VirtualSession session(0.5, Tool());
  FaultyDevice left("touchx"), right("touch", {20, 5, 6}, {20, 5, 2});
  Servo::Options options;
  options.realtime = false;
  Servo first(left, session.published(), options), second(right, session.published(), options);
  (void)first.start();
  (void)second.start();
  for (int i = 0; i < 60; ++i) {
    session.scene().tool.radiusMm = 3 + 0.001 * i;
    session.publish();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (i == 45) first.stop();  // Unplugged for good; the other goes on.
  }
  second.stop();
  EXPECT_GT(first.statistics().touching, 50u);
  EXPECT_GT(second.statistics().touching, 50u);
  EXPECT_EQ(left.told, Vec3d::Zero());
  EXPECT_EQ(first.fault(), Fault::none);
  EXPECT_EQ(second.fault(), Fault::none);
  session.publish();
  EXPECT_EQ(session.published().reclaim(), 0u) << "no servo that stopped holds a scene";
}

}  // namespace
}  // namespace argil::haptics
