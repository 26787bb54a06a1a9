// The last stop before the motor.

#include "haptics/servo/safety.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "haptics/devices/sheets.h"

namespace argil::haptics {
namespace {

constexpr double kPeriod = 1e-3;
DeviceState at(double x) {
  DeviceState s;
  s.pose.translation = {x, 0, 0};
  return s;
}

TEST(Safety, ClampsAndLimitsTheChange) {
  const DeviceSheet& sheet = deviceSheet("touch");
  Safety safety(sheet, kPeriod);
  uint32_t flags = 0;
  (void)safety.apply(Vec3d::Zero(), at(0), true, flags);
  EXPECT_EQ(flags, 0u);
  Vec3d last = Vec3d::Zero();
  for (int i = 0; i < 10; ++i) {
    flags = 0;
    const Vec3d f = safety.apply({0, 5.0, 0}, at(0), true, flags);
    EXPECT_TRUE(flags & kClamped);
    EXPECT_LE(f.norm(), sheet.peakForceN);
    EXPECT_LE((f - last).norm(), safety.slewStepN() * (1 + 1e-12));
    last = f;
  }
  EXPECT_NEAR(last.y(), sheet.peakForceN, 1e-12);
}

TEST(Safety, StartsOnlyOnceTheForceIsInRange) {
  Safety safety(deviceSheet("touch"), kPeriod);
  uint32_t flags = 0;
  EXPECT_EQ(safety.apply({2, 0, 0}, at(0), true, flags).norm(), 0);
  EXPECT_TRUE(flags & kWaiting);
  flags = 0;
  EXPECT_GT(safety.apply({0.2, 0, 0}, at(0), true, flags).norm(), 0);
  EXPECT_FALSE(flags & kWaiting);
}

TEST(Safety, APointerIsNeverStopped) {
  DeviceSheet sheet;
  sheet.pointing = true;
  Safety safety(sheet, kPeriod);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-1e6, 1e6);
  for (int i = 0; i < 2000; ++i) {
    uint32_t flags = 0;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Vec3d force = safety.apply(i % 7 == 0 ? Vec3d(nan, 0, 0) : Vec3d(0, 0, anywhere(random)),
                                     at(anywhere(random)), i % 5 != 0, flags);
    EXPECT_EQ(safety.fault(), Fault::none);
    EXPECT_FALSE(flags & (kStopped | kWaiting));
    EXPECT_TRUE(force.allFinite());
    EXPECT_LE(force.norm(), sheet.peakForceN);
  }
}

TEST(Safety, FadesToALatchedStopOnEachFault) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  struct Planted {
    Vec3d force;
    Vec3d position;
    Fault fault;
  };
  for (const Planted& p :
       {Planted{{nan, 0, 0}, {0, 0, 0}, Fault::notFinite}, Planted{{0, inf, 0}, {0, 0, 0}, Fault::notFinite},
        Planted{{0, 0, 0}, {0, nan, 0}, Fault::notFinite}, Planted{{0, 0, 7}, {0, 0, 0}, Fault::commandTooLarge},
        Planted{{0, 0, 1}, {30, 0, 0}, Fault::tooFast}}) {
    const DeviceSheet& sheet = deviceSheet("touch");
    Safety safety(sheet, kPeriod);
    uint32_t flags = 0;
    Vec3d last = safety.apply(Vec3d::Zero(), at(0), true, flags);
    for (int i = 0; i < 20; ++i) last = safety.apply({0, 0, 3}, at(0), true, flags);
    ASSERT_NEAR(last.z(), 3, 1e-9);
    DeviceState state;
    state.pose.translation = p.position;
    int tripped = -1;
    for (int i = 0; i < 40; ++i) {
      flags = 0;
      // Faults that need several ticks in a row get them; a fast device goes on being fast.
      if (p.fault == Fault::tooFast) state.pose.translation.x() += 30;
      const Vec3d f = safety.apply(p.force, state, true, flags);
      ASSERT_TRUE(f.allFinite());
      ASSERT_LE(f.norm(), sheet.peakForceN);
      if (tripped < 0 && (flags & kStopped)) tripped = i;
      if (tripped >= 0 && i >= tripped + 19) {
        ASSERT_EQ(f.norm(), 0) << sentence(p.fault);
      }
      last = f;
    }
    EXPECT_GE(tripped, p.fault == Fault::commandTooLarge ? kRawOverTicks - 1 : 0);
    EXPECT_LE(tripped, kSpeedTicks);
    EXPECT_EQ(safety.fault(), p.fault);
    // Latched: a good command changes nothing until reset.
    flags = 0;
    EXPECT_EQ(safety.apply({0, 0, 0.1}, at(0), true, flags).norm(), 0);
    EXPECT_TRUE(flags & kStopped);
    safety.reset();
    flags = 0;
    EXPECT_GT(safety.apply({0, 0, 0.1}, at(0), true, flags).norm(), 0);
  }
}

TEST(Safety, FourLargeCommandsAreNoFault) {
  Safety safety(deviceSheet("touch"), kPeriod);
  uint32_t flags = 0;
  (void)safety.apply(Vec3d::Zero(), at(0), true, flags);
  for (int i = 0; i < 40; ++i) (void)safety.apply({0, 0, i % 5 == 4 ? 1.0 : 20.0}, at(0), true, flags);
  EXPECT_FALSE(flags & kStopped);
}

TEST(Safety, ASilentDeviceGetsZeroAtOnce) {
  const DeviceSheet& sheet = deviceSheet("touch");
  Safety safety(sheet, kPeriod);
  uint32_t flags = 0;
  for (int i = 0; i < 20; ++i) (void)safety.apply({0, 0, i ? 2.0 : 0.0}, at(0), true, flags);
  EXPECT_EQ(safety.apply({0, 0, 2}, at(0), false, flags).norm(), 0);
  EXPECT_TRUE(flags & kStale);
  flags = 0;
  EXPECT_LE(safety.apply({0, 0, 2}, at(0), true, flags).norm(), sheet.peakForceN * kPeriod / kReturnSeconds * 1.0001)
      << "and comes back gently";
  EXPECT_TRUE(flags & kReturning);
  safety.interrupt(1.01 * kAwaySeconds);
  flags = 0;
  EXPECT_EQ(safety.apply({0, 0, 2}, at(0), true, flags).norm(), 0) << "after long it begins anew";
  EXPECT_TRUE(flags & kWaiting);
}

TEST(Safety, InterruptionsThatFollowEachOtherAreOne) {
  Safety safety(deviceSheet("touch"), kPeriod);
  uint32_t flags = 0;
  for (int i = 0; i < 20; ++i) (void)safety.apply({0, 0, i ? 2.0 : 0.0}, at(0), true, flags);
  EXPECT_TRUE(safety.felt());
  for (int i = 0; i < 99; ++i) {
    safety.interrupt(kPeriod);
    EXPECT_EQ(safety.apply({0, 0, 2}, at(0), true, flags, 1e9, {}, true), Vec3d::Zero()) << "shut";
  }
  flags = 0;
  EXPECT_GT(safety.apply({0, 0, 2}, at(0), true, flags).norm(), 0);
  EXPECT_FALSE(safety.felt());
  for (int i = 0; i < 102; ++i) {
    safety.interrupt(kPeriod);
    (void)safety.apply({0, 0, 2}, at(0), true, flags, 1e9, {}, true);
  }
  flags = 0;
  EXPECT_EQ(safety.apply({0, 0, 2}, at(0), true, flags), Vec3d::Zero());
  EXPECT_TRUE(flags & kWaiting);
}

TEST(Safety, NothingThatComesInBreaksALimit) {
  constexpr uint32_t kSeed = 3;
  std::mt19937 random(kSeed);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double odd[] = {0, -0.0, 1e-300, 1, 3.3, 6.7, -2, 1e9, -1e300, nan, inf, -inf};
  const auto pick = [&] { return odd[random() % std::size(odd)]; };
  for (const DeviceSheet& sheet : deviceSheets()) {
    Safety safety(sheet, kPeriod);
    Vec3d last = Vec3d::Zero();
    for (int i = 0; i < 200'000; ++i) {
      const bool rarely = random() % 40 == 0;
      Vec3d force = rarely ? Vec3d(pick(), pick(), pick()) : Vec3d(std::sin(i * 0.01), std::cos(i * 0.02), 0.1);
      DeviceState state = at(rarely && random() % 8 == 0 ? pick() : 0.0);
      const bool fresh = random() % 100 != 0;
      uint32_t flags = 0;
      const Vec3d f = safety.apply(force, state, fresh, flags);
      ASSERT_TRUE(f.allFinite()) << "seed " << kSeed;
      ASSERT_LE(f.norm(), sheet.peakForceN);
      if (fresh && !(flags & kStopped)) {
        ASSERT_LE((f - last).norm(), safety.slewStepN() * (1 + 1e-9));
      }
      last = f;
      if ((flags & kStopped) && random() % 50 == 0) {
        safety.reset();
        last.setZero();
      }
    }
  }
}

TEST(ForceGate, IsOpenedByItsOwnersAloneAndByWhoSawTheLastStop) {
  ForceGate gate;
  EXPECT_TRUE(gate.open());
  EXPECT_TRUE(gate.resume(StopOwner::user, gate.generation(StopOwner::user))) << "nothing was stopped";
  const ForceGate::Generation first = gate.stop(StopOwner::user), second = gate.stop(StopOwner::user);
  EXPECT_FALSE(gate.resume(StopOwner::user, first)) << "there was a later stop";
  const ForceGate::Generation dog = gate.stop(StopOwner::watchdog);
  EXPECT_TRUE(gate.resume(StopOwner::watchdog, dog));
  EXPECT_FALSE(gate.open()) << "the user's stop is not the watchdog's";
  EXPECT_TRUE(gate.resume(StopOwner::user, second));
  EXPECT_TRUE(gate.open());
  EXPECT_FALSE(gate.resume(StopOwner::user, second)) << "a resume that came twice";
  const ForceGate::Word before = gate.word();
  gate.interrupt(StopOwner::device);
  EXPECT_TRUE(gate.open());
  EXPECT_NE(gate.word(), before) << "what was commanded before is void";
  gate.stop(StopOwner::user);
  gate.interrupt(StopOwner::device);
  EXPECT_FALSE(gate.open());
}

TEST(ForceGate, ACounterThatRunsOverTouchesNoOther) {
  for (const StopOwner owner : {StopOwner::user, StopOwner::watchdog, StopOwner::device}) {
    ForceGate gate;
    for (int i = 0; i < 40'000; ++i) {
      const ForceGate::Generation stop = gate.stop(owner);
      ASSERT_FALSE(gate.open()) << i;
      ASSERT_TRUE(gate.stoppedBy(owner));
      ASSERT_TRUE(gate.resume(owner, stop));
      ASSERT_TRUE(gate.open()) << i;
    }
    for (const StopOwner other : {StopOwner::user, StopOwner::watchdog, StopOwner::device})
      EXPECT_EQ(gate.generation(other) != 0, other == owner);
  }
}

TEST(Watchdog, HoldsNothingAfterItsEnd) {
  ForceGate gate;
  Heartbeat heart;
  heart.beat(0);
  Watchdog watchdog;
  EXPECT_FALSE(watchdog.look(heart, gate, 0.001));
  EXPECT_TRUE(watchdog.look(heart, gate, 10));
  EXPECT_TRUE(watchdog.holds());
  EXPECT_FALSE(gate.open());
  watchdog.end(gate);
  EXPECT_FALSE(watchdog.holds());
  EXPECT_TRUE(gate.open());
}

TEST(Heartbeat, IsSilentAfterItsTime) {
  Heartbeat heart;
  heart.beat(10);
  EXPECT_FALSE(heart.silent(10 + kWatchdogSeconds * 0.9));
  EXPECT_TRUE(heart.silent(10 + kWatchdogSeconds * 1.1));
}

}  // namespace
}  // namespace argil::haptics
