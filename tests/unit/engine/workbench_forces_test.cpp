#include <gtest/gtest.h>

#include <future>

#include "../../support/devices/haply_emulator.h"
#include "haptics/devices/haply.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

/// An arm on a serial line, pressed into the block; what its motors are told is read at the far end.
class WorkbenchForces : public WorkbenchTest {
 protected:
  void SetUp() override {
    block();
    Tool tool;
    tool.radiusMm = 3;
    bench.setTool(tool);
    arm.plug();
    rise();
    bench.useDevice(name());
    ASSERT_TRUE(until([&] {
      return bench.touch(false).device == name() && bench.touch(false).state == haptics::ServoState::running;
    })) << bench.touch(false).sentence;
    ASSERT_TRUE(pushes()) << bench.touch(false).sentence;
  }
  std::string name() const { return "haply:" + arm.path(); }
  void rise() { arm.hand({0, 0, 16}, 0); }
  void press(double depthMm = 1.5) { arm.hand({0, 0, 13 - depthMm}, 0); }
  /// Pressed into the block it pushes back. On a busy machine forces begin anew now and then, and wait for the hand to
  /// rise.
  [[nodiscard]] bool pushes(double depthMm = 1.5) {
    return until([&] {
      if (arm.forceN().norm() > 0.3) return true;
      if (bench.touch(false).state == haptics::ServoState::waiting)
        rise();
      else
        press(depthMm);
      return false;
    });
  }
  /// It is told zero so many times running; the edit thread need not do anything for it.
  [[nodiscard]] bool staysAtZero(uint64_t times = 40) {
    if (!until([&] { return arm.forceN().norm() == 0; })) return false;
    const uint64_t from = arm.told();
    bool zero = true;
    return until([&] {
             zero = zero && arm.forceN().norm() == 0;
             return !zero || arm.told() > from + times;
           }) &&
           zero;
  }
  /// While it lives the edit thread does nothing else.
  class Busy {
   public:
    explicit Busy(Workbench& bench) {
      bench.edit("Wait", [began = &began_, let = let_.get_future().share()](Document&) {
        began->set_value();
        let.wait();
      });
      began_.get_future().wait();
    }
    ~Busy() { let_.set_value(); }

   private:
    std::promise<void> began_, let_;
  };

  haptics::testing::HaplyArmEmulator arm{haptics::HaplyOptions().centreMm};
};

TEST_F(WorkbenchForces, StopAtOnceAtTheMotorsAndComeBack) {
  {
    const Busy busy(bench);
    EXPECT_TRUE(pushes()) << "the servo turns beside the edit thread";
    bench.stopForces();
    EXPECT_TRUE(staysAtZero()) << "before the edit thread has heard of it";
    EXPECT_NE(bench.touch(false).sentence.find("stopped by you"), std::string::npos);
    EXPECT_EQ(bench.touch(false).state, haptics::ServoState::stopped);
  }
  ASSERT_TRUE(rest());
  EXPECT_TRUE(staysAtZero());
  rise();
  bench.resumeForces();
  EXPECT_TRUE(pushes()) << bench.touch(false).sentence;
  EXPECT_EQ(bench.touch(false).forceN.size(), 1000u);
}

TEST_F(WorkbenchForces, AStopIsNotUndoneByAResumeThatWaited) {
  rise();
  {
    const Busy busy(bench);
    bench.stopForces();
    bench.resumeForces();
    bench.stopForces();
  }
  ASSERT_TRUE(rest());
  EXPECT_EQ(bench.touch(false).state, haptics::ServoState::stopped);
  press();
  EXPECT_TRUE(staysAtZero());
  // Two that saw the same stop: the second finds it undone and leaves the servo alone.
  rise();
  {
    const Busy busy(bench);
    bench.resumeForces();
    bench.resumeForces();
  }
  EXPECT_TRUE(pushes()) << bench.touch(false).sentence;
}

TEST_F(WorkbenchForces, AStopOutlivesAChangeOfDevice) {
  rise();
  {
    const Busy busy(bench);
    bench.useDevice("simulated:touch");
    bench.useDevice(name());
    bench.stopForces();
  }
  ASSERT_TRUE(until([&] { return bench.idle() && bench.touch(false).device == name(); }));
  EXPECT_EQ(bench.touch(false).state, haptics::ServoState::stopped);
  press();
  EXPECT_TRUE(staysAtZero());
  rise();
  bench.resumeForces();
  EXPECT_TRUE(pushes()) << bench.touch(false).sentence;
}

TEST_F(WorkbenchForces, MotorsStayWarmWhenTheDeviceIsChosenAnew) {
  // Lightly pressed, the motors give away as much warmth as they get: a deep press warms them in a second.
  ASSERT_TRUE(until([&] {
    if (bench.touch(false).state == haptics::ServoState::waiting)
      rise();
    else
      press(6);
    return bench.touch(false).heat > 0.2;
  })) << bench.touch(false).heat
      << ' ' << bench.touch(false).sentence;
  rise();
  ASSERT_TRUE(until([&] { return arm.forceN().norm() == 0; }));
  bench.useDevice("pointer");
  ASSERT_TRUE(until([&] { return bench.touch(false).device == "pointer"; }));
  EXPECT_EQ(bench.touch(false).heat, 0) << "another device is another motor";
  bench.useDevice(name());
  ASSERT_TRUE(until(
      [&] { return bench.touch(false).device == name() && bench.touch(false).state == haptics::ServoState::running; }));
  EXPECT_GT(bench.touch(false).heat, 0.01)
      << "nothing was pressed since: only half a minute of rest would bring it there";
}

}  // namespace
}  // namespace argil::engine
