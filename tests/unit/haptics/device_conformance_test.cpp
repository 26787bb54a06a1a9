// What every driver must do, against an emulator that misbehaves on command.

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>

#include "device_conformance.h"
#include "haptics/base/clock.h"
#include "haptics/servo/safety.h"
#include "haptics/servo/servo.h"
#include "realtime_trap.h"

namespace argil::haptics {
namespace {

using testing::DeviceRig;
using testing::Misbehaviour;
using testing::RigMaker;

// Each times the rig's slack.
constexpr double kReconnectSeconds = 1.0;  // Asked: replug within one second.
constexpr double kZeroSeconds = 0.150;     // The device's own lateness, a tick, and a shared machine's hiccups.
constexpr double kPatienceSeconds = 3.0;   // Anything longer is broken.

const char* nameOf(Misbehaviour what) {
  switch (what) {
    case Misbehaviour::none:
      return "none";
    case Misbehaviour::split:
      return "split answers";
    case Misbehaviour::garbage:
      return "garbage";
    case Misbehaviour::notFinite:
      return "not finite";
    case Misbehaviour::shortAnswers:
      return "short answers";
    case Misbehaviour::wrongEcho:
      return "wrong echo";
    case Misbehaviour::late:
      return "late";
    case Misbehaviour::silent:
      return "silent";
  }
  return "?";
}

/// Plays the servo: one turn a millisecond.
class Hands {
 public:
  Hands(Device& device, const DeviceRig& rig) : device_(device), rig_(rig), patience_(rig.slack() * kPatienceSeconds) {}

  /// One tick: true when the device was new.
  bool tick(const Vec3d& force) {
    const double now = double(nowNs()) * 1e-9;
    fresh = device_.read(now, state);
    device_.write(now, fresh ? force : Vec3d(0, 0, 0));  // As the servo does.
    toldAtWrite = rig_.told();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return fresh;
  }
  /// Ticks until `done`; seconds that it took, or infinity.
  double until(const Vec3d& force, const std::function<bool()>& done) {
    const int64_t begin = nowNs();
    while (double(nowNs() - begin) * 1e-9 < patience_) {
      tick(force);
      if (done()) return double(nowNs() - begin) * 1e-9;
    }
    return std::numeric_limits<double>::infinity();
  }
  bool ready() {
    return until(Vec3d::Zero(), [this] { return fresh; }) < patience_;
  }

  DeviceState state;
  bool fresh = false;
  uint64_t toldAtWrite = 0;  ///< Forces that had reached the motors when the last one was written.

 private:
  Device& device_;
  const DeviceRig& rig_;
  double patience_;
};

class DeviceConformance : public ::testing::TestWithParam<RigMaker> {
 protected:
  void SetUp() override {
    // The servo's place, where that is granted: on a busy machine the tests would else judge its scheduler.
    (void)becomeRealtime(80, false);
    rig = GetParam().make();
    traits = GetParam().traits;
    slack_ = rig->slack();
    device = rig->open();
    hands = std::make_unique<Hands>(*device, *rig);
  }
  void TearDown() override {
    hands.reset();
    device.reset();
    const sched_param plain{};
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &plain);
  }
  [[nodiscard]] Vec3d half(int axis) const { return 0.5 * device->sheet().peakForceN * Vec3d::Unit(axis); }
  void feelHalf() {
    ASSERT_TRUE(hands->ready()) << device->status();
    ASSERT_LT(hands->until(half(2), [&] { return (rig->forceN() - half(2)).norm() < 1e-2; }), slack(kPatienceSeconds))
        << device->status();
  }
  [[nodiscard]] double slack(double seconds) const { return slack_ * seconds; }
  [[nodiscard]] bool motorsOff() const { return rig->forceN().norm() == 0; }

  double slack_ = 1;
  std::unique_ptr<DeviceRig> rig;
  DeviceRig::Traits traits;
  std::unique_ptr<Device> device;
  std::unique_ptr<Hands> hands;
};

class FollowingDevice : public DeviceConformance {};
class ForceDevice : public DeviceConformance {};
class DeviceOfBytes : public DeviceConformance {};
class DeviceOnACable : public DeviceConformance {};

TEST_P(DeviceConformance, HasASheetThatCanBe) {
  const DeviceSheet& s = device->sheet();
  EXPECT_FALSE(s.name.empty());
  EXPECT_TRUE(s.dofIn == 3 || s.dofIn == 6) << s.dofIn;
  EXPECT_TRUE(s.dofOut == 0 || s.dofOut == 3 || s.dofOut == 6) << s.dofOut;
  EXPECT_TRUE(s.dofOut > 0 || !traits.force);
  EXPECT_GT(s.workspaceMm.minCoeff(), 0);
  EXPECT_GE(s.peakForceN, s.continuousForceN);
  EXPECT_GT(s.continuousForceN, 0);
  EXPECT_GT(s.resolutionMm, 0);
  EXPECT_GT(s.topStiffnessNmm, 0);
  EXPECT_GT(s.rateHz, 0);
  EXPECT_LE(s.buttons, 32);
}

TEST_P(DeviceConformance, BeginsWithoutForceAndSaysHowItIs) {
  EXPECT_TRUE(motorsOff());
  EXPECT_EQ(device->status().rfind(device->sheet().name, 0), 0u) << device->status() << ": begins with its name";
  ASSERT_TRUE(hands->ready()) << device->status();
  EXPECT_NE(device->status().find("ready"), std::string::npos) << device->status();
  EXPECT_TRUE(motorsOff());
  EXPECT_LT((hands->state.pose.translation - rig->place()).norm(), traits.resolutionMm)
      << hands->state.pose.translation.transpose();
  EXPECT_NEAR(hands->state.pose.rotation.norm(), 1, 1e-5);
}

TEST_P(FollowingDevice, FollowsTheHandInMillimetresAndItsOwnAxes) {
  ASSERT_TRUE(hands->ready()) << device->status();
  for (const Vec3d& place : {Vec3d(10, 0, 0), Vec3d(0, -20, 0), Vec3d(0, 0, 30), Vec3d(-7.5, 12.25, -3)}) {
    rig->hand(place, 1);
    EXPECT_LT(hands->until(Vec3d::Zero(),
                           [&] { return (hands->state.pose.translation - place).norm() <= traits.resolutionMm; }),
              slack(kPatienceSeconds))
        << place.transpose() << " but it is at " << hands->state.pose.translation.transpose();
  }
  if (device->sheet().buttons > 0) {
    EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return hands->state.buttons == 1; }), slack(kPatienceSeconds));
    rig->hand({0, 0, 0}, 0);
    EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return hands->state.buttons == 0; }), slack(kPatienceSeconds));
  }
}

TEST_P(ForceDevice, PushesAsToldInNewtonsAndItsOwnAxes) {
  ASSERT_TRUE(hands->ready()) << device->status();
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0}) {
      const Vec3d force = sign * half(axis);
      // Counted by the emulator, for it is told on while this thread waits for a processor. A driver drops what was
      // written too late, which a busy machine may cause: one quiet try is enough.
      uint64_t exchanges = 0;
      for (int tries = 0; tries < 20; ++tries) {
        bool written = false;
        uint64_t first = 0, next = 0;
        const auto arrives = [&] {
          if (!written && hands->fresh) {
            written = true;
            first = next = hands->toldAtWrite;
          }
          for (; written && next < rig->told(); ++next)
            if ((rig->toldN(next) - force).norm() < 0.01 * force.norm()) return true;
          return false;
        };
        ASSERT_LT(hands->until(force, arrives), slack(kPatienceSeconds))
            << force.transpose() << " but its motors push " << rig->forceN().transpose();
        exchanges = next + 1 - first;
        if (exchanges <= 10) break;
        EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return motorsOff(); }), slack(kPatienceSeconds));
      }
      EXPECT_LE(exchanges, 10u);
    }
  EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return motorsOff(); }), slack(kPatienceSeconds));
}

TEST_P(ForceDevice, NeverPushesHarderThanItsSheet) {
  ASSERT_TRUE(hands->ready()) << device->status();
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double peak = device->sheet().peakForceN;
  for (const Vec3d& force : {Vec3d(peak, peak, peak), Vec3d(-100 * peak, 0, 0), Vec3d(0, nan, 0), Vec3d(inf, 0, 0),
                             Vec3d(1e300, 1e300, 0)}) {
    // Counted in exchanges of force, not in time: a busy machine may give the driver's thread no turn for long.
    const uint64_t before = rig->told();
    int fresh = 0;
    const auto toldOften = [&] { return (fresh += hands->fresh) >= 10 && rig->told() >= before + 10; };
    EXPECT_LT(hands->until(force, toldOften), slack(kPatienceSeconds)) << force.transpose() << device->status();
  }
  // What was written too late was dropped: the device pushes at all.
  EXPECT_LT(hands->until(Vec3d(peak, peak, peak), [&] { return rig->peakN() > 0.5 * peak; }), slack(kPatienceSeconds));
  EXPECT_LE(rig->peakN(), peak * (1 + 1e-6));
}

TEST_P(ForceDevice, IsAtZeroWhenCutAndKeepsNothingFromBefore) {
  feelHalf();
  device->gate().stop(StopOwner::user);
  const double zero = hands->until(half(2), [&] { return motorsOff(); });
  std::printf("%s: zero %.1f ms after a cut\n", GetParam().name.c_str(), 1e3 * zero);
  EXPECT_LT(zero, slack(kZeroSeconds));
  for (int i = 0; i < 20; ++i) {
    hands->tick(half(2));
    ASSERT_TRUE(motorsOff()) << "whatever write() says";
  }
  EXPECT_NE(device->status().find("cut"), std::string::npos) << device->status();
  ASSERT_TRUE(device->gate().resume(StopOwner::user, device->gate().generation(StopOwner::user)));
  feelHalf();
  device->gate().interrupt(StopOwner::user);
  std::this_thread::sleep_for(std::chrono::milliseconds(8));  // Shorter than the servo may be silent.
  EXPECT_TRUE(motorsOff()) << "a force from before the cut does not come back";
}

TEST_P(ForceDevice, IsAtZeroWhenTheServoFallsSilent) {
  feelHalf();
  const int64_t begin = nowNs();
  while (!motorsOff() && double(nowNs() - begin) < slack(1e9))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_LT(double(nowNs() - begin) * 1e-9, slack(kWatchdogSeconds + kZeroSeconds));
}

TEST_P(ForceDevice, IsAtZeroWhenItIsClosed) {
  feelHalf();
  hands.reset();
  device.reset();
  const int64_t begin = nowNs();
  while (!motorsOff() && double(nowNs() - begin) < slack(1e9))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(motorsOff()) << rig->forceN().transpose();
}

TEST_P(DeviceOfBytes, IsAtZeroAndSaysSoWhileItsDeviceMisbehaves) {
  for (Misbehaviour what : {Misbehaviour::garbage, Misbehaviour::notFinite, Misbehaviour::shortAnswers,
                            Misbehaviour::wrongEcho, Misbehaviour::late, Misbehaviour::silent}) {
    SCOPED_TRACE(nameOf(what));
    if (what == Misbehaviour::silent && traits.silenceIsRest) continue;
    if (traits.force) feelHalf();
    ASSERT_TRUE(hands->ready()) << device->status();
    if (!rig->misbehave(what)) continue;
    const double noticed = hands->until(half(2), [&] { return !hands->fresh; });
    const double zero = noticed + hands->until(half(2), [&] { return motorsOff(); });
    std::printf("%s: %s noticed after %.1f ms, zero after %.1f ms\n", GetParam().name.c_str(), nameOf(what),
                1e3 * noticed, 1e3 * zero);
    EXPECT_LT(noticed, slack(kZeroSeconds)) << device->status();
    EXPECT_LT(zero, slack(2 * kZeroSeconds)) << device->status();
    EXPECT_LT(hands->until(half(2), [&] { return device->status().find("ready") == std::string::npos; }),
              slack(kZeroSeconds))
        << device->status();
    for (int i = 0; i < 40; ++i) {
      hands->tick(half(2));
      EXPECT_TRUE(motorsOff() || hands->fresh) << i << " " << device->status();
    }
    rig->misbehave(Misbehaviour::none);
    EXPECT_LT(hands->until(Vec3d::Zero(),
                           [&] { return hands->fresh && device->status().find("ready") != std::string::npos; }),
              slack(kReconnectSeconds))
        << device->status();
  }
}

TEST_P(DeviceOfBytes, CopesWithSplitAnswers) {
  if (!rig->misbehave(Misbehaviour::split)) return;  // It speaks in packets that the system keeps whole.
  ASSERT_TRUE(hands->ready()) << device->status();
  int fresh = 0;
  for (int i = 0; i < 100; ++i) fresh += hands->tick(Vec3d::Zero());
  EXPECT_GT(fresh, 10);  // As many as there is time for: ticks do not wait for a busy machine.
  EXPECT_LT((hands->state.pose.translation - rig->place()).norm(), traits.resolutionMm);
}

TEST_P(DeviceOnACable, NoticesThatItIsUnpluggedAndGoesOnWhenItIsBack) {
  for (int round = 0; round < 2; ++round) {
    if (traits.force) feelHalf();
    ASSERT_TRUE(hands->ready()) << device->status();
    rig->unplug();
    EXPECT_LT(hands->until(half(2), [&] { return !hands->fresh; }), slack(kZeroSeconds));
    EXPECT_LT(hands->until(half(2), [&] { return device->status().find("unplugged") != std::string::npos; }),
              slack(kReconnectSeconds))
        << device->status();
    for (int i = 0; i < 30; ++i) EXPECT_FALSE(hands->tick(half(2)));
    rig->replug();
    const double back = hands->until(Vec3d::Zero(), [&] { return hands->fresh; });
    std::printf("%s: back %.0f ms after it was plugged in again\n", GetParam().name.c_str(), 1e3 * back);
    EXPECT_LT(back, slack(kReconnectSeconds)) << device->status();
    EXPECT_TRUE(motorsOff()) << "nothing from before comes back";
    EXPECT_NE(device->status().find("ready"), std::string::npos) << device->status();
  }
}

TEST_P(DeviceOnACable, WaitsForADeviceThatIsNotThereYet) {
  hands.reset();
  device.reset();
  rig->unplug();
  device = rig->open();
  hands = std::make_unique<Hands>(*device, *rig);
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(hands->tick(half(2)));
  EXPECT_NE(device->status().find("not plugged in"), std::string::npos) << device->status();
  rig->replug();
  EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return hands->fresh; }), slack(kReconnectSeconds)) << device->status();
}

TEST_P(DeviceConformance, KnowsNothingOfAnotherOfItsKind) {
  const auto otherRig = GetParam().make();
  const auto other = otherRig->open();
  Hands otherHands(*other, *otherRig);
  ASSERT_TRUE(hands->ready());
  ASSERT_TRUE(otherHands.ready()) << other->status();
  if (traits.follows) {
    rig->hand({5, 0, 0}, 0);
    otherRig->hand({0, 6, 0}, 0);
    EXPECT_LT(
        hands->until(Vec3d::Zero(),
                     [&] { return (hands->state.pose.translation - Vec3d(5, 0, 0)).norm() <= traits.resolutionMm; }),
        slack(kPatienceSeconds));
    EXPECT_LT(otherHands.until(
                  Vec3d::Zero(),
                  [&] { return (otherHands.state.pose.translation - Vec3d(0, 6, 0)).norm() <= traits.resolutionMm; }),
              slack(kPatienceSeconds));
  }
  if (traits.cable) {
    rig->unplug();
    EXPECT_LT(hands->until(Vec3d::Zero(), [&] { return !hands->fresh; }), slack(kZeroSeconds));
    EXPECT_TRUE(otherHands.ready()) << "the other goes on";
    if (traits.force) {
      EXPECT_LT(otherHands.until(half(0), [&] { return (otherRig->forceN() - half(0)).norm() < 1e-2; }),
                slack(kPatienceSeconds));
      EXPECT_TRUE(motorsOff());
    }
  }
}

TEST_P(DeviceConformance, KeepsToTheRulesOfRealTime) {
  ASSERT_TRUE(hands->ready()) << device->status();
  testing::RealtimeTrap trap;
  for (int i = 0; i < 300; ++i) {
    if (i == 100) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;  // Its code came in.
    DeviceState state;
    const double now = double(nowNs()) * 1e-9;
    trap.enter();
    device->read(now, state);
    device->write(now, {0, 0, 0.01});
    trap.leave();
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  EXPECT_EQ(trap.allocations, 0u);
  EXPECT_EQ(trap.locks, 0u);
  EXPECT_EQ(trap.systemCalls, 0u);
}

std::string rigName(const ::testing::TestParamInfo<RigMaker>& rig) {
  return rig.param.name;
}

INSTANTIATE_TEST_SUITE_P(Drivers, DeviceConformance, ::testing::ValuesIn(testing::deviceRigs()), rigName);
INSTANTIATE_TEST_SUITE_P(Drivers, FollowingDevice,
                         ::testing::ValuesIn(testing::deviceRigs(&DeviceRig::Traits::follows)), rigName);
INSTANTIATE_TEST_SUITE_P(Drivers, ForceDevice, ::testing::ValuesIn(testing::deviceRigs(&DeviceRig::Traits::force)),
                         rigName);
INSTANTIATE_TEST_SUITE_P(Drivers, DeviceOfBytes, ::testing::ValuesIn(testing::deviceRigs(&DeviceRig::Traits::bytes)),
                         rigName);
INSTANTIATE_TEST_SUITE_P(Drivers, DeviceOnACable, ::testing::ValuesIn(testing::deviceRigs(&DeviceRig::Traits::cable)),
                         rigName);

}  // namespace
}  // namespace argil::haptics
