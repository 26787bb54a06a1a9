// A machine or a device that stalls while clay is carved: the force is gone for some milliseconds, comes back by
// itself, and no clay is cut by a hand that nothing holds meanwhile.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo_tick.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

constexpr double kPeriod = 1e-3, kRadius = 3.5, kPress = 6;
constexpr int kPressed = 700, kAlong = 1000, kStall = 2000, kLifted = 3000, kAgain = 4000, kEnd = 4500;  // ms
constexpr double kFirstX = -25, kLastX = 25;

class SilentDevice final : public Device {
 public:
  SilentDevice(const DeviceSheet& sheet, HandPath path) : device(sheet, std::move(path)) {}
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return device.sheet(); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override { return device.read(timeS, state) && !silent; }
  void write(double timeS, const Vec3d& force) ARGIL_REALTIME override { device.write(timeS, force); }
  ForceGate& gate() const noexcept override { return device.gate(); }

  SimulatedDevice device;
  bool silent = false;
};

enum class Kind {
  none,
  late,      // no tick comes; after 15 ms the watchdog lets the motors go
  silent,    // ticks come, the device does not answer
  voided,    // the device's thread was late: commands of before are void
  byPerson,  // somebody switches the force off, and on again
};
struct Stall {
  Kind kind = Kind::none;
  int ms = 0;
  int every = 0;  // again after so many ms; 0: once
};

struct Tick {
  bool ran = false;
  uint32_t flags = 0;
  double force = 0;
};
struct Ran {
  std::vector<double> bottom = std::vector<double>(60, 0);  // of what was cut, by mm of the way
  std::vector<Tick> ticks = std::vector<Tick>(kEnd);
  int count(uint32_t flag) const {
    return int(std::count_if(ticks.begin(), ticks.end(), [&](const Tick& tick) { return (tick.flags & flag) != 0; }));
  }
};

// A hand presses a ball into a block, draws it along for two seconds, lifts it, and presses it again.
Ran carve(const DeviceSheet& sheet, const Stall& stall, Work work = Work::cut) {
  std::vector<HandPoint> points;
  const auto add = [&](int ms, double x, double z, uint32_t buttons) {
    HandPoint p;
    p.timeS = ms * kPeriod;
    p.position = {x, 0, z};
    p.buttons = buttons;
    points.push_back(p);
  };
  add(0, kFirstX, kRadius + 3, 0);
  add(kPressed - 200, kFirstX, kRadius + 3, 0);
  add(kPressed, kFirstX, kRadius - kPress, 1);
  add(kAlong, kFirstX, kRadius - kPress, 1);
  add(kLifted, kLastX, kRadius - kPress, 1);
  add(kLifted + 300, kLastX, kRadius + 3, 0);
  add(kAgain - 300, 0, kRadius + 3, 0);
  add(kAgain, 0, kRadius - kPress - 2, 1);
  Tool tool;
  tool.radiusMm = kRadius;
  tool.work = work;
  testing::VirtualSession session(0.25, tool);
  SilentDevice device(sheet, HandPath(std::move(points)));
  SampleRing ring(1 / kPeriod);
  ServoTick tick(device, session.published(), ring, kPeriod);
  Ran ran;
  bool watchdog = false;
  ForceGate::Generation watched = 0, person = 0;
  int begins = stall.kind == Kind::none ? kEnd : kStall, ends = kEnd;
  for (int i = 0; i < kEnd; ++i) {
    if (i == begins) {
      ends = i + stall.ms;
      if (stall.kind == Kind::late) {
        if (stall.ms * kPeriod > kWatchdogSeconds) {
          DeviceState state;
          (void)device.read(i * kPeriod + kWatchdogSeconds, state);
          watched = device.gate().stop(StopOwner::watchdog);
          watchdog = true;
        }
        i = ends;
      }
      device.silent = stall.kind == Kind::silent;
      if (stall.kind == Kind::voided) device.gate().interrupt(StopOwner::device);
      if (stall.kind == Kind::byPerson) person = device.gate().stop(StopOwner::user);
    }
    if (i == ends) {
      device.silent = false;
      if (stall.kind == Kind::byPerson) (void)device.gate().resume(StopOwner::user, person);
      if (stall.every > 0 && i + stall.every + stall.ms < kLifted) begins = i + stall.every;
    }
    Tick& now = ran.ticks[size_t(i)];
    now.ran = true;
    now.flags = tick.run(i * kPeriod, false);
    if (std::exchange(watchdog, false)) (void)device.gate().resume(StopOwner::watchdog, watched);
    now.force = tick.last().forceN.norm();
    if (tick.last().flags & kCutting) {
      const Vec3d& at = tick.last().cutPoint;
      double& bottom = ran.bottom[size_t(std::clamp(at.x() + 30, 0.0, 59.0))];
      if (i < kLifted) bottom = std::min(bottom, at.z() - kRadius);
    }
    session.step(ring, tick.last().index + 1);
  }
  return ran;
}

void expectTheSameGroove(const Ran& calm, const Ran& ran, double mm) {
  for (double x = kFirstX + 4; x < kLastX - 6; ++x) {
    const auto i = size_t(x + 30);
    ASSERT_LT(calm.bottom[i], -2);
    EXPECT_NEAR(ran.bottom[i], calm.bottom[i], mm) << x << " mm along";
  }
}

TEST(Stall, AShortOneNeitherLosesTheForceNorDeepensTheCut) {
  for (const char* name : {"touch", "touchx", "falcon", "omega3"}) {
    const DeviceSheet& sheet = deviceSheet(name);
    const Ran calm = carve(sheet, {});
    for (const Stall& stall :
         {Stall{Kind::late, 13}, Stall{Kind::late, 18}, Stall{Kind::late, 40}, Stall{Kind::late, 90},
          Stall{Kind::late, 18, 200}, Stall{Kind::silent, 1}, Stall{Kind::silent, 8}, Stall{Kind::silent, 90},
          Stall{Kind::silent, 8, 150}, Stall{Kind::voided, 1}, Stall{Kind::voided, 1, 150}}) {
      SCOPED_TRACE(::testing::Message() << name << ", kind " << int(stall.kind) << ", " << stall.ms << " ms, every "
                                        << stall.every);
      const Ran ran = carve(sheet, stall);
      expectTheSameGroove(calm, ran, 0.35);
      EXPECT_EQ(ran.count(kWaiting), calm.count(kWaiting));
      EXPECT_EQ(ran.count(kStopped), 0);
      EXPECT_GT(ran.count(kReturning), 40);
      if (stall.every == 0) {
        for (int i = kStall + stall.ms + 300; i < kLifted; ++i)
          ASSERT_NEAR(ran.ticks[size_t(i)].force, calm.ticks[size_t(i)].force, 0.25) << i << " ms";
      }
      // From zero, and to the peak in no less than kReturnSeconds.
      double back = 0;
      for (int i = kStall; i < kLifted; ++i) {
        const Tick& now = ran.ticks[size_t(i)];
        back = now.flags & kReturning ? back + kPeriod : 0;
        if (back == 0) continue;
        ASSERT_LE(now.force, sheet.peakForceN * back / kReturnSeconds * (1 + 1e-9)) << i << " ms";
        ASSERT_FALSE(now.flags & kCutting) << i << " ms";
      }
    }
  }
}

TEST(Stall, AfterALongOneNoForceComesAndNothingIsCutUntilTheStylusWasMovedAway) {
  for (const Kind kind : {Kind::late, Kind::silent}) {
    for (const int ms : {110, 400}) {
      SCOPED_TRACE(::testing::Message() << "kind " << int(kind) << ", " << ms << " ms");
      const Ran ran = carve(deviceSheet("touch"), {kind, ms});
      for (int i = kStall + ms; i < kLifted; ++i) {
        const Tick& now = ran.ticks[size_t(i)];
        ASSERT_TRUE(now.flags & kWaiting) << i << " ms";
        ASSERT_FALSE(now.flags & kCutting) << i << " ms";
        ASSERT_EQ(now.force, 0) << i << " ms";
      }
      for (size_t i = 30 + 4; i < 30 + size_t(kLastX); ++i) EXPECT_EQ(ran.bottom[i], 0) << "nothing is cut there";
      EXPECT_GT(ran.ticks[kEnd - 1].force, 0.5) << "then it is felt again";
      EXPECT_TRUE(ran.ticks[kEnd - 1].flags & kCutting);
    }
  }
}

// The clay that a tool lays does not hold a hand back, nor do motors that are not there: a bead has no gaps, and what
// carves with them goes on.
TEST(Stall, ToolsThatNoForceHoldsBackGoOn) {
  DeviceSheet unmoved = deviceSheet("touch");
  unmoved.dofOut = 0;
  for (const auto& [sheet, work] : {std::pair(deviceSheet("touch"), Work::lay), {unmoved, Work::cut}}) {
    for (const Stall& stall : {Stall{Kind::late, 18, 200}, Stall{Kind::late, 150}, Stall{Kind::voided, 1, 150}}) {
      const Ran ran = carve(sheet, stall, work);
      int came = 0;
      for (int i = kPressed; i < kLifted; ++i) {
        const Tick& now = ran.ticks[size_t(i)];
        came += now.ran;
        ASSERT_TRUE(!now.ran || (now.flags & kCutting)) << "kind " << int(stall.kind) << ", " << i << " ms";
      }
      EXPECT_GT(came, 2000);
    }
  }
}

TEST(Stall, AForceThatAPersonSwitchedOffDoesNotComeBackByItself) {
  for (const int ms : {0, 30}) {  // 0: off and on between two ticks
    const Ran ran = carve(deviceSheet("touch"), {Kind::byPerson, ms});
    for (int i = kStall; i < kStall + ms; ++i) {
      ASSERT_EQ(ran.ticks[size_t(i)].force, 0);
      ASSERT_TRUE(ran.ticks[size_t(i)].flags & kCutting) << "who wants no force may carve without";
    }
    for (int i = kStall + ms; i < kLifted; ++i) {
      ASSERT_TRUE(ran.ticks[size_t(i)].flags & kWaiting) << i;
      ASSERT_FALSE(ran.ticks[size_t(i)].flags & (kReturning | kCutting)) << i;
    }
    EXPECT_GT(ran.ticks[kEnd - 1].force, 0.5);
  }
}

}  // namespace
}  // namespace argil::haptics
