// Every contact keeps to the rules of real time, not only the one that Argil uses.

#include <gtest/gtest.h>

#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo_tick.h"
#include "realtime_trap.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

TEST(Contacts, KeepToTheRulesOfRealTime) {
  for (const std::string_view name : contactNames()) {
    Tool tool;
    tool.radiusMm = 1;
    testing::VirtualSession session(0.5, tool);
    SimulatedDevice device(deviceSheet("touch"), testing::scribble(20, tool.radiusMm, 1.2));
    SampleRing ring(64);
    ServoTick tick(device, session.published(), ring, 1e-3, name);
    testing::RealtimeTrap trap;
    int touching = 0;
    for (int i = 0; i < 20'000; ++i) {
      session.step(ring, static_cast<uint64_t>(i));
      trap.enter();
      const uint32_t flags = tick.run(i * 1e-3, false);
      trap.leave();
      // Its stack and code come in.
      if (i < 1000) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
      touching += (flags & kTouching) != 0;
    }
    EXPECT_GT(touching, 10'000) << name;
    EXPECT_EQ(trap.allocations, 0u) << name;
    EXPECT_EQ(trap.locks, 0u) << name;
    EXPECT_EQ(trap.systemCalls, 0u) << name;
  }
}

}  // namespace
}  // namespace argil::haptics
