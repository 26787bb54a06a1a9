// Ticks that come late, in bunches or not at all: what is felt, heated, paid and judged goes by the time that passed.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "haptics/base/tick_clock.h"
#include "haptics/devices/hand_path.h"
#include "haptics/devices/sheets.h"
#include "haptics/servo/heat_budget.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/safety.h"
#include "haptics/servo/servo_tick.h"
#include "haptics/servo/velocity_filter.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

constexpr double kPeriod = 1e-3;

struct Schedule {
  std::string name;
  std::vector<double> times;  // s, of ticks that begin.
};

// What an ordinary desktop does to a thread without rights, and worse.
std::vector<Schedule> schedules(double seconds) {
  std::vector<Schedule> all = {{"on time", {}},
                               {"jitter of 0.3 ms", {}},
                               {"pairs, 0.1 and 1.9 ms", {}},
                               {"every third missing", {}},
                               {"5 ms late now and then, then a bunch", {}},
                               {"one in four", {}}};
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto ticks = static_cast<int>(seconds / kPeriod);
  for (int i = 0; i < ticks; ++i) {
    const double due = i * kPeriod;
    all[0].times.push_back(due);
    all[1].times.push_back(due + 0.3e-3 * unit(random));
    all[2].times.push_back(i % 2 ? due - 0.9e-3 : due);
    if (i % 3 != 2) all[3].times.push_back(due);
    const int in = i % 40;  // Ticks 20 to 24 begin at 24 and a little.
    all[4].times.push_back(in >= 20 && in < 25 ? (i - in + 24) * kPeriod + (in - 20) * 0.15e-3 : due);
    if (i % 4 == 0) all[5].times.push_back(due);
  }
  return all;
}

TEST(TickClock, ATickOnTimeIsOnePeriodAndAGapIsNoStep) {
  TickClock clock(kPeriod);
  EXPECT_TRUE(clock.next(5000).first);
  for (int i = 1; i < 10'000; ++i) {
    const TickClock::Step step = clock.next(5000 + i * kPeriod);
    ASSERT_EQ(step.seconds, kPeriod) << "to the bit";
    ASSERT_EQ(step.heldS, kPeriod);
    ASSERT_FALSE(step.gap || step.first);
  }
  const double now = 5000 + 9999 * kPeriod;
  EXPECT_NEAR(clock.next(now + 4e-3).seconds, 4e-3, 1e-9);
  const TickClock::Step gap = clock.next(now + 7);
  EXPECT_TRUE(gap.gap);
  EXPECT_EQ(gap.seconds, kPeriod) << "seconds are not integrated as one step";
  EXPECT_NEAR(gap.heldS, 6.996, 1e-6);
  for (const double odd : {now + 7, now, -1.0, std::nan(""), -double(INFINITY)}) {
    const TickClock::Step step = clock.next(odd);
    EXPECT_GT(step.seconds, 0) << odd;
    EXPECT_LE(step.seconds, kPeriod);
    EXPECT_EQ(step.heldS, 0);
    (void)clock.next(now + 7);
  }
}

TEST(LateTicks, VelocitiesAreThoseOfTheHand) {
  for (const double step : {0.0, 0.02}) {
    for (const Schedule& schedule : schedules(4)) {
      // A stroke to and fro, 2 Hz: as a hand does.
      const double w = 2 * std::numbers::pi * 2, amplitude = 20, top = amplitude * w;
      VelocityFilter filter(kPeriod, step);
      double worst = 0, last = 0;
      for (size_t i = 0; i < schedule.times.size(); ++i) {
        const double t = schedule.times[i], x = amplitude * std::sin(w * t);
        const double read = step > 0 ? step * std::nearbyint(x / step) : x;
        const double v = filter.add({read, 0, 0}, i ? t - last : kOnePeriod).x();
        last = t;
        if (t > 0.1) worst = std::max(worst, std::abs(v - top * std::cos(w * t)));
      }
      std::printf("%-38s steps of %.2f mm: off by at most %.1f %% of the largest speed\n", schedule.name.c_str(), step,
                  100 * worst / top);
      EXPECT_LE(worst, 0.10 * top) << schedule.name << ", " << step;
    }
  }
}

TEST(LateTicks, TheHeatIsThatOfRealTime) {
  const DeviceSheet& sheet = deviceSheet("touchx");
  double onTime = 0;
  for (const Schedule& schedule : schedules(20)) {
    HeatBudget budget(sheet, kPeriod);
    double truth = 0, now = 0;  // q' = (f² − q)/τ by the exact law, force held.
    const double c2 = sheet.continuousForceN * sheet.continuousForceN;
    Vec3d held = Vec3d::Zero();
    for (size_t i = 0; i < schedule.times.size(); ++i) {
      const double t = schedule.times[i];
      if (i) {
        budget.felt(held, std::abs(t - now - kPeriod) < 1e-9 ? kPeriod : t - now);
        truth += (1 - std::exp(-(t - now) / sheet.thermalSeconds)) * (held.squaredNorm() / c2 - truth);
      }
      now = t;
      // Pushes for three seconds of four, as hard as may be.
      held = {0, 0, std::fmod(t, 4) < 3 ? budget.limitN() : 0};
      ASSERT_NEAR(budget.load(), truth, 1e-6 + 1e-6 * truth) << schedule.name;
      ASSERT_LE(budget.load(), 1 + 1e-6) << schedule.name;
    }
    if (onTime == 0) onTime = budget.load();
    EXPECT_NEAR(budget.load(), onTime, 0.02) << schedule.name << ": the same push is the same heat";
  }
  HeatBudget budget(sheet, kPeriod);
  budget.begin(0.9, 0);
  EXPECT_LT(budget.limitN(), sheet.peakForceN);
  budget.begin(0.9, 5 * sheet.thermalSeconds);
  EXPECT_EQ(budget.limitN(), sheet.peakForceN);
  EXPECT_NEAR(budget.load(), 0.9 * std::exp(-5), 1e-12);
}

// A spring wall at z = 0 that a hand presses and leaves; what the motor gives by the exact integral of the held force,
// and what the observer makes of it. Without damping or forgetting: as Input has it.
TEST(LateTicks, TheObserverCountsTheEnergyThatTheMotorGives) {
  DeviceSheet sheet = deviceSheet("touchx");
  sheet.topDampingNsmm = 1e-12;  // The controller may not act: the observer alone is looked at.
  for (const double delayS : {0.0, 2.3e-3}) {
    for (const Schedule& schedule : schedules(2)) {
      Passivity passivity(sheet, kPeriod, delayS);
      const double w = 2 * std::numbers::pi * 3;
      const auto place = [&](double t) { return 1.5 * std::cos(w * t); };
      struct Command {
        double fromS, z;
      };
      std::vector<Command> commands = {{-1, 0}};
      // Work on the hand from a to b, force as commanded delayS ago.
      const auto work = [&](double a, double b) {
        double sum = 0;
        for (size_t i = 0; i < commands.size(); ++i) {
          const double from = std::max(a, commands[i].fromS + delayS),
                       to = std::min(b, i + 1 < commands.size() ? commands[i + 1].fromS + delayS : 1e9);
          if (to > from) sum += commands[i].z * (place(to) - place(from));
        }
        return sum;
      };
      double given = 0, counted = 0, largest = 0, now = 0, tank = 0;
      for (size_t i = 0; i < schedule.times.size(); ++i) {
        const double t = schedule.times[i], elapsed = t - now;
        const double step = i == 0 ? kOnePeriod : std::abs(elapsed - kPeriod) < 1e-9 ? kPeriod : elapsed;
        Passivity::Input in;
        in.position = {0, 0, place(t)};
        in.velocity = {0, 0, -1.5 * w * std::sin(w * t)};
        in.elapsedS = step;
        const double stretch = std::max(0.0, -place(t));
        in.force = {0, 0, 1.0 * stretch};
        // Whatever the hand puts in goes to the tank, whatever it gets is drawn: both are seen there.
        in.storedNmm = 0;
        in.active = true;
        const double before = passivity.tank().levelNmm();
        (void)passivity.apply(in);
        tank = passivity.tank().levelNmm() - before;
        if (i > 0) {
          const double truth = -work(now, t);
          // The tank's trickle is known; when it is full or empty nothing can be read from it.
          const double trickle = passivity.tank().trickleNmmS() * elapsed;
          const bool readable = passivity.tank().levelNmm() > 1e-9 &&
                                passivity.tank().levelNmm() < passivity.tank().capacityNmm() - 1e-9 &&
                                before < passivity.tank().capacityNmm() - trickle;
          if (readable) {
            given += truth;
            counted += tank - trickle;
            largest = std::max(largest, std::abs(given));
          }
        }
        now = t;
        passivity.commanded(in.force, step);
        commands.push_back({t, stretch});
        if (commands.size() > 200) commands.erase(commands.begin(), commands.begin() + 100);
      }
      std::printf("%-38s delay %.1f ms: %.4f of %.4f mJ\n", schedule.name.c_str(), 1e3 * delayS, counted, given);
      EXPECT_GT(largest, 0.05) << "something was read";
      // With a delay within a tick the motion in it counts as even.
      EXPECT_NEAR(counted, given, delayS > 0 ? 0.03 * largest : 1e-6 * largest) << schedule.name;
    }
  }
}

TEST(LateTicks, TooFastIsASpeedAndNotACount) {
  const DeviceSheet& sheet = deviceSheet("touch");
  for (const Schedule& schedule : schedules(1)) {
    for (const double share : {0.85, 1.25}) {
      Safety safety(sheet, kPeriod);
      DeviceState state;
      uint32_t flags = 0;
      double now = 0;
      for (size_t i = 0; i < schedule.times.size(); ++i) {
        const double t = schedule.times[i], elapsed = t - now;
        now = t;
        state.pose.translation = {share * sheet.topSpeedMms * t, 0, 0};
        (void)safety.apply(Vec3d::Zero(), state, true, flags, 1e9,
                           {i ? elapsed : kOnePeriod, i ? elapsed : kOnePeriod});
      }
      EXPECT_EQ(safety.fault(), share > 1 ? Fault::tooFast : Fault::none)
          << schedule.name << " at " << share << " of the top speed";
    }
  }
  // A glitch of one position within a bunch is no speed.
  Safety safety(sheet, kPeriod);
  DeviceState state;
  uint32_t flags = 0;
  for (int i = 0; i < 60; ++i) {
    state.pose.translation = {i == 40 ? 3.0 : 0.0, 0, 0};
    const double elapsed = i >= 30 && i < 50 ? 0.1e-3 : kPeriod;
    (void)safety.apply(Vec3d::Zero(), state, true, flags, 1e9, {elapsed, elapsed});
  }
  EXPECT_EQ(safety.fault(), Fault::none);
}

TEST(LateTicks, AFaultFadesInItsTimeAndABunchIsNoSteeper) {
  const DeviceSheet& sheet = deviceSheet("touch");
  Safety safety(sheet, kPeriod);
  DeviceState state;
  uint32_t flags = 0;
  (void)safety.apply(Vec3d::Zero(), state, true, flags);
  Vec3d force = Vec3d::Zero();
  for (int i = 0; i < 20; ++i) {
    const Vec3d next = safety.apply({0, 0, 3}, state, true, flags, 1e9, {0.1e-3, 0.1e-3});
    EXPECT_LE((next - force).norm(), 0.1 * safety.slewStepN() * (1 + 1e-9));
    force = next;
  }
  for (int i = 0; i < 20; ++i) force = safety.apply({0, 0, 3}, state, true, flags);
  ASSERT_NEAR(force.z(), 3, 1e-9);
  safety.trip(Fault::implausible);
  double faded = 0;
  while (force.norm() > 0 && faded < 1) {
    faded += 5e-3;
    force = safety.apply({0, 0, 3}, state, true, flags, 1e9, {5e-3, 5e-3});
  }
  EXPECT_LE(faded, kFadeSeconds + 1e-9);
}

/// A hand that moves evenly, read when the tick says it is; or whose answers come from a thread of their own and are
/// older.
class MovingDevice final : public Device {
 public:
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return deviceSheet("touchx"); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override {
    const double at = answersS > 0 ? answersS * std::floor(timeS / answersS) : timeS;
    state.ageS = timeS - at;
    state.pose.translation = {speedMms * at, 0, 20};
    return true;
  }
  void write(double, const Vec3d& forceN) ARGIL_REALTIME override { told = forceN; }
  double speedMms = 100, answersS = 0;
  Vec3d told = Vec3d::Zero();
};

// Through the whole tick: a medium that drags by the speed alone says what speed the tick takes.
TEST(LateTicks, AMediumDragsAsFastAsTheHandMoves) {
  for (const double answersS : {0.0, 1e-3, 1.0 / 700}) {
    for (const Schedule& schedule : schedules(1)) {
      Published<Scene> published;
      Scene scene;
      scene.guides.push_back({1, Viscosity{0.001}, 0});
      scene.check();
      published.publish(std::make_unique<const Scene>(scene));
      MovingDevice device;
      device.answersS = answersS;
      SampleRing ring(10.0);
      ServoTick tick(device, published, ring, kPeriod);
      const double drag = device.speedMms * 0.001;
      double worst = 0;
      for (const double t : schedule.times) {
        const uint32_t flags = tick.run(t, false);
        EXPECT_FALSE(flags & (kStopped | kStale));
        if (t > 0.3) worst = std::max(worst, std::abs(device.told.x() + drag));
      }
      EXPECT_LE(worst, 0.05 * drag) << schedule.name << ", answers every " << 1e3 * answersS << " ms";
    }
  }
}

TEST(LateTicks, AfterAGapForcesBeginAnewAndTheMotorsHaveCooled) {
  testing::VirtualSession session(0.5, Tool());
  class PressedDevice final : public Device {
   public:
    [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return deviceSheet("touchx"); }
    bool read(double timeS, DeviceState& state) ARGIL_REALTIME override {
      state.pose.translation = {0, 0, std::max(bottom, 6 - 20 * timeS)};
      return true;
    }
    void write(double, const Vec3d& forceN) ARGIL_REALTIME override { told = forceN; }
    double bottom = -1;
    Vec3d told = Vec3d::Zero();
  } device;
  SampleRing ring(10.0);
  ServoTick tick(device, session.published(), ring, kPeriod);
  double t = 0;
  for (int i = 0; i < 4000; ++i) (void)tick.run(t += kPeriod, false);
  ASSERT_GT(device.told.z(), 0.5);
  const double warm = tick.heat().load();
  ASSERT_GT(warm, 0.01);
  const uint32_t flags = tick.run(t += 10, false);
  EXPECT_EQ(device.told, Vec3d::Zero());
  EXPECT_TRUE(flags & kWaiting);
  EXPECT_FALSE(flags & kStopped) << "a gap is no fault";
  EXPECT_NEAR(tick.heat().load(), warm * std::exp(-10 / device.sheet().thermalSeconds), 0.02 * warm);
}

}  // namespace
}  // namespace argil::haptics
