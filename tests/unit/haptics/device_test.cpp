// The simulated device, its sheets and its hand.

#include <gtest/gtest.h>

#include <cmath>

#include "clay/base/error.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"

namespace argil::haptics {
namespace {

DeviceSheet plainSheet() {
  DeviceSheet s = deviceSheet("touch");
  s.frictionN = 0;
  s.dampingNsmm = 0;
  return s;
}

TEST(DeviceSheets, AreThoseOfTheTable) {
  EXPECT_EQ(deviceSheets().size(), 6u);
  EXPECT_DOUBLE_EQ(deviceSheet("touch").peakForceN, 3.3);
  EXPECT_DOUBLE_EQ(deviceSheet("touchx").topStiffnessNmm, 1.86);
  EXPECT_DOUBLE_EQ(deviceSheet("premium15").frictionN, 0.04);
  EXPECT_DOUBLE_EQ(deviceSheet("falcon").resolutionMm, 0.06);
  EXPECT_DOUBLE_EQ(deviceSheet("omega3").topStiffnessNmm, 14.5);
  EXPECT_DOUBLE_EQ(deviceSheet("haply").continuousForceN, 3.3);
  try {
    (void)deviceSheet("nothing");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("omega3"), std::string::npos) << "the sentence names what there is";
  }
}

TEST(HandPath, GoesThroughItsPointsAndStandsStillAtItsEnds) {
  HandPoint a, b;
  b.timeS = 2;
  b.position = {4, 0, 0};
  b.buttons = 1;
  const HandPath path(std::vector<HandPoint>{a, b});
  size_t hint = 0;
  EXPECT_EQ(path.at(-1, hint).position.x(), 0);
  EXPECT_EQ(path.at(1, hint).position.x(), 2);
  EXPECT_EQ(path.at(1, hint).buttons, 0u) << "a button is that of the earlier point";
  EXPECT_EQ(path.at(9, hint).position.x(), 4);
  EXPECT_EQ(path.at(9, hint).buttons, 1u);
  EXPECT_EQ(path.at(0.5, hint).position.x(), 1) << "and time may go back";
  const HandPath circle = HandPath::circle({0, 0, 0}, {2, 0, 0}, Vec3d::UnitZ(), 1, 1);
  for (double t : {0.1, 0.4, 0.9}) EXPECT_NEAR(circle.at(t, hint).position.norm(), 2, 1e-3);
  EXPECT_NEAR(path.then(circle).durationS(), 3, 1e-3);
}

TEST(HandPath, RefusesWhatIsNotAPath) {
  const std::string header = "t_s,x_mm,y_mm,z_mm,buttons\n";
  const HandPath good = HandPath::fromCsv(header + "0,1,2,3,0\r\n0.5,1,2,4,1\n", "p.csv");
  EXPECT_EQ(good.points().size(), 2u);
  EXPECT_EQ(good.points()[1].buttons, 1u);
  EXPECT_EQ(good.points()[1].position.z(), 4);
  for (const char* rows : {"", "0,1,2\n", "0,1,2,nan,0\n", "0,1,2,3,0\n0,1,2,3,0\n", "0,1,2,x,0\n", "0,1,2,3,-1\n"}) {
    try {
      (void)HandPath::fromCsv(header + rows, "p.csv");
      ADD_FAILURE() << rows;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("p.csv"), std::string::npos);
    }
  }
  EXPECT_THROW(HandPath::fromCsv("t_s,x_mm,y_mm\n0,0,0\n", "p.csv"), Error);
  EXPECT_THROW(HandPath::fromCsv("t_s,x_mm,y_mm,z_mm,speed\n0,0,0,0,1\n", "p.csv"), Error);
  HandPoint p;
  p.position.x() = std::nan("");
  EXPECT_THROW(HandPath(std::vector<HandPoint>{p}), Error);
}

TEST(SimulatedDevice, FallsAsMassAndForceSay) {
  SimulatedDevice::Options options;
  options.hand = {0.0, 0.0, 0.0};
  options.encoderSteps = false;
  SimulatedDevice device(plainSheet(), HandPath::hold({0, 0, 0}, 10), options);
  DeviceState state;
  device.read(0, state);
  device.write(0, {0.09, 0, 0});  // 0.045 kg: 2 m/s².
  device.read(0.5, state);
  EXPECT_NEAR(state.pose.translation.x(), 0.5 * 2000 * 0.1 * 0.1, 0.2)
      << "no more than a tenth of a second is caught up";
  for (int i = 501; i <= 600; ++i) device.read(i * 1e-3, state);
  EXPECT_NEAR(state.pose.translation.x(), 0.5 * 2000 * 0.2 * 0.2, 0.2);
}

TEST(SimulatedDevice, NeverGainsEnergyByItself) {
  for (double friction : {0.0, 0.26})
    for (double stiffness : {0.1, 0.5, 20.0}) {
      DeviceSheet sheet = plainSheet();
      sheet.frictionN = friction;
      HandPoint from, to;
      from.position = {0, 0, 0};
      to.position = {5, -3, 2};
      to.timeS = 1e-3;  // A step of the hand, then it holds still.
      SimulatedDevice::Options options;
      options.hand = {0.1, friction > 0 ? 0.005 : 0.0, stiffness};
      SimulatedDevice device(sheet, HandPath(std::vector<HandPoint>{from, to}), options);
      DeviceState state;
      device.read(0.002, state);
      double energy = device.energyNmm();
      const double first = energy;
      ASSERT_GT(first, 0);
      for (int i = 3; i < 3000; ++i) {
        device.read(i * 1e-3, state);
        // The spring of a symplectic step swings within a part of the step; it must not grow over that.
        ASSERT_LE(device.energyNmm(), energy * 1.02 + 1e-12) << friction << " " << stiffness << " tick " << i;
        energy = std::min(energy, device.energyNmm());
      }
      if (friction > 0) {
        EXPECT_LT(device.velocity().norm(), 1e-9) << "friction brings it to rest";
      }
    }
}

TEST(SimulatedDevice, ReadsInStepsOfTheEncoder) {
  const DeviceSheet sheet = deviceSheet("touch");
  SimulatedDevice device(sheet, HandPath::line({0, 0, 0}, {10, 5, 1}, 1));
  DeviceState state;
  for (int i = 0; i < 1000; ++i) {
    device.read(i * 1e-3, state);
    for (int a = 0; a < 3; ++a) {
      const double steps = state.pose.translation[a] / sheet.resolutionMm;
      ASSERT_NEAR(steps, std::round(steps), 1e-9);
      ASSERT_LE(std::abs(state.pose.translation[a] - device.position()[a]), sheet.resolutionMm * 0.5 + 1e-9);
    }
  }
}

TEST(SimulatedDevice, PullsNoHarderThanItsMotorAndOnlyAfterTheDelay) {
  for (double delayTicks : {0.0, 1.0, 2.5}) {
    SimulatedDevice::Options options;
    options.delayS = delayTicks * 1e-3;
    options.hand = {0, 0, 0};
    SimulatedDevice device(plainSheet(), HandPath::hold({0, 0, 0}, 10), options);
    DeviceState state;
    double felt = -1;
    for (int i = 0; i < 10; ++i) {
      device.read(i * 1e-3, state);
      if (felt < 0 && device.motorForce().norm() > 0) felt = i;
      EXPECT_LE(device.motorForce().norm(), plainSheet().peakForceN + 1e-12);
      device.write(i * 1e-3, {0, 0, 50});
    }
    EXPECT_EQ(felt, std::floor(delayTicks) + 1) << delayTicks;
    // Where in the tick it begins shows in the speed: the force acted from delay to 9 ticks.
    const double seconds = (9 - delayTicks) * 1e-3;
    EXPECT_NEAR(device.velocity().z(), 1000 * plainSheet().peakForceN / plainSheet().massKg * seconds, 5) << delayTicks;
  }
}

TEST(SimulatedDevice, IsDeadWhenCut) {
  SimulatedDevice device(plainSheet(), HandPath::hold({0, 0, 0}, 10));
  DeviceState state;
  device.read(0, state);
  device.write(0, {1, 0, 0});
  device.read(0.001, state);
  EXPECT_GT(device.motorForce().norm(), 0);
  const ForceGate::Generation stop = device.gate().stop(StopOwner::user);
  device.write(0.001, {1, 0, 0});
  device.read(0.002, state);
  EXPECT_EQ(device.motorForce().norm(), 0);
  device.write(0.002, {1, 0, 0});
  ASSERT_TRUE(device.gate().resume(StopOwner::user, stop));
  device.read(0.003, state);
  EXPECT_EQ(device.motorForce().norm(), 0) << "a command from before the resume";
  device.write(0.003, {1, 0, 0});
  device.read(0.004, state);
  EXPECT_GT(device.motorForce().norm(), 0);
  EXPECT_THROW(SimulatedDevice(plainSheet(), HandPath()), Error);
}

}  // namespace
}  // namespace argil::haptics
