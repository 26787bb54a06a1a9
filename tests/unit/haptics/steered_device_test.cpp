// A simulated device whose hand somebody moves, as with a mouse.

#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"

namespace argil::haptics {
namespace {

constexpr double kTickS = 0.001;

HandPoint wanted(const Vec3d& at, uint32_t buttons = 0) {
  HandPoint point;
  point.position = at;
  point.buttons = buttons;
  return point;
}

TEST(SteeredDevice, GoesWhereItIsSentAndNoFasterThanAHand) {
  for (const DeviceSheet& sheet : deviceSheets()) {
    SCOPED_TRACE(sheet.name);
    SimulatedDevice device(sheet, HandPath::hold(Vec3d::Zero(), 1e9));
    DeviceState state;
    double timeS = 0, fastest = 0;
    const auto run = [&](double seconds) {
      for (const double end = timeS + seconds; timeS < end; timeS += kTickS) {
        ASSERT_TRUE(device.read(timeS, state));
        device.write(timeS, Vec3d::Zero());
        fastest = std::max(fastest, device.velocity().norm());
      }
    };
    run(0.1);
    EXPECT_LT(device.position().norm(), 1e-9) << "nobody has moved it yet";
    // A cursor that jumps.
    device.steer(wanted({60, -20, 30}, 1));
    run(1.5);
    EXPECT_LT((device.position() - Vec3d(60, -20, 30)).norm(), 1);
    EXPECT_EQ(state.buttons, 1u);
    EXPECT_LT(fastest, sheet.topSpeedMms) << "faster would be a fault";
    device.steer(wanted({-60, 20, -30}));
    run(1.5);
    EXPECT_LT((device.position() - Vec3d(-60, 20, -30)).norm(), 1);
    EXPECT_EQ(state.buttons, 0u);
    EXPECT_LT(fastest, sheet.topSpeedMms);
  }
}

TEST(SteeredDevice, IsPushedBackByAForceAndStaysWhereItWasPut) {
  SimulatedDevice device(deviceSheets().front(), HandPath::hold(Vec3d::Zero(), 1e9));
  device.startAt({10, 20, 30});
  DeviceState state;
  double timeS = 0;
  for (; timeS < 0.5; timeS += kTickS) {
    ASSERT_TRUE(device.read(timeS, state));
    EXPECT_LT((state.pose.translation - Vec3d(10, 20, 30)).norm(), 0.1);
    device.write(timeS, Vec3d::Zero());
  }
  // 1 N against the hand's 0.5 N/mm: 2 mm, less the friction.
  for (; timeS < 2; timeS += kTickS) {
    ASSERT_TRUE(device.read(timeS, state));
    device.write(timeS, {0, 0, 1});
  }
  EXPECT_NEAR(device.position().z(), 32, 0.4);
}

}  // namespace
}  // namespace argil::haptics
