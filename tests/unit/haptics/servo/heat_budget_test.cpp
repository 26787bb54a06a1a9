// The motors' heat: the peak for a while, the continuous force for ever, and no step between.

#include "haptics/servo/heat_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

TEST(HeatBudget, GivesThePeakForAWhileAndThenTheContinuousForce) {
  for (double periodS : {1e-2, 1e-3, 1.0 / 8000}) {
    for (const DeviceSheet& sheet : deviceSheets()) {
      HeatBudget budget(sheet, periodS);
      double atPeak = 0, last = sheet.peakForceN, steepest = 0, square = 0;
      const auto ticks = static_cast<int>(60 / periodS);
      for (int i = 0; i < ticks; ++i) {
        const double force = budget.limitN();
        ASSERT_LE(force, sheet.peakForceN * (1 + 1e-12));
        ASSERT_GE(force, std::min(sheet.continuousForceN, sheet.peakForceN) * (1 - 1e-12));
        if (force >= sheet.peakForceN * (1 - 1e-9)) atPeak += periodS;
        steepest = std::max(steepest, std::abs(force - last));
        last = force;
        square += force * force / ticks;
        budget.felt({0, force, 0});
        ASSERT_LE(budget.load(), 1 + 1e-6) << sheet.name << periodS;
      }
      if (periodS == 1e-3)
        std::printf("%-9s peak for %.2f s of 60, then %.2f N, steepest %.3f %% of peak a tick, RMS %.2f N\n",
                    sheet.name.c_str(), atPeak, last, 100 * steepest / sheet.peakForceN, std::sqrt(square));
      EXPECT_LE(steepest, HeatBudget::kLimitStep * sheet.peakForceN * (1 + 1e-9));
      EXPECT_LE(last, 1.01 * sheet.continuousForceN);
      EXPECT_LE(std::sqrt(square), sheet.continuousForceN * std::sqrt(1 + sheet.thermalSeconds / 60));
      EXPECT_GT(atPeak, periodS <= 1e-3 ? 0.2 : 0.0);
    }
  }
}

TEST(HeatBudget, IsNeverOverdrawnByAnyForce) {
  constexpr uint32_t kSeed = 5;
  std::mt19937 random(kSeed);
  const DeviceSheet& sheet = deviceSheet("touchx");
  HeatBudget budget(sheet, 1e-3);
  double asked = 0;
  for (int i = 0; i < 300'000; ++i) {
    if (i % 250 == 0) asked = random() % 3 ? sheet.peakForceN : sheet.continuousForceN * double(random() % 100) / 100;
    budget.felt({std::min(asked, budget.limitN()), 0, 0});
    ASSERT_LE(budget.load(), 1 + 1e-6) << "seed " << kSeed << " tick " << i;
  }
  // Rest gives the peak back.
  for (int i = 0; i < 30'000; ++i) budget.felt(Vec3d::Zero());
  EXPECT_NEAR(budget.limitN(), sheet.peakForceN, 1e-9);
}

TEST(HeatBudget, HoldsAServoThatPressesOnAndOn) {
  Tool tool;
  testing::VirtualSession session(0.5, tool);
  session.scene().materials[0].stiffnessNmm = 5;
  session.publish();
  SimulatedDevice::Options options;
  options.prescribed = true;
  options.encoderSteps = false;
  const DeviceSheet& sheet = deviceSheet("touch");
  SimulatedDevice device(sheet, HandPath::line({0, 0, 6}, {0, 0, -1}, 0.5), options);
  Servo servo(device, session.published());
  double square = 0, most = 0, steepest = 0;
  Vec3d last = Vec3d::Zero();
  bool warm = false;
  constexpr uint64_t kTicks = 60'000;
  servo.runVirtual(kTicks, [&](uint64_t i, double) {
    const Vec3d force = servo.tick().last().forceN;
    square += force.squaredNorm() / double(kTicks);
    most = std::max(most, force.norm());
    if (i > 700) steepest = std::max(steepest, (force - last).norm());
    last = force;
    warm = warm || (servo.tick().last().flags & kWarm);
  });
  EXPECT_NEAR(most, sheet.peakForceN, 1e-6) << "the peak is given at first";
  EXPECT_LE(last.norm(), 1.01 * sheet.continuousForceN);
  EXPECT_LE(std::sqrt(square), sheet.continuousForceN * std::sqrt(1 + sheet.thermalSeconds / 60.0));
  EXPECT_LE(steepest, 0.02 * sheet.peakForceN);
  EXPECT_TRUE(warm);
  EXPECT_EQ(servo.state(), ServoState::warm);
}

}  // namespace
}  // namespace argil::haptics
