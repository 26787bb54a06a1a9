// Couplings, the energy tank, and passivity control by itself.

#include "haptics/servo/passivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "haptics/contact/coupling.h"
#include "haptics/devices/sheets.h"
#include "tests/unit/haptics/realtime_trap.h"

namespace argil::haptics {
namespace {

constexpr double kPeriod = 1e-3;

// A sampled wall at z = 0 with a spring.
Passivity::Input wall(double z, double speed, double stiffness, bool active = false, double top = 0) {
  Passivity::Input in;
  in.position = {0, 0, z};
  in.velocity = {0, 0, speed};
  const double stretch = std::max(0.0, top - z);
  in.force = {0, 0, stiffness * stretch};
  in.storedNmm = 0.5 * stiffness * stretch * stretch;
  in.active = active;
  return in;
}

TEST(Coupling, IsAsStiffAsTheSheetAndTheBoundsAllow) {
  for (const DeviceSheet& sheet : deviceSheets())
    for (const double rate : {100.0, 1000.0, 4000.0})
      for (const double delay : {0.0, 1e-3})
        for (const bool controlled : {false, true}) {
          const Coupling c = coupleTo(sheet, 1 / rate, delay, controlled);
          const CouplingBounds b = couplingBounds(sheet, 1 / rate, delay);
          EXPECT_GT(c.stiffnessNmm, 0);
          EXPECT_LE(c.stiffnessNmm, sheet.topStiffnessNmm);
          EXPECT_LE(c.dampingNsmm, sheet.topDampingNsmm);
          EXPECT_LE(c.stiffnessNmm, b.quantizationNmm);
          EXPECT_LE(c.stiffnessNmm, controlled ? b.controlledNmm : b.colgateBrownNmm);
          if (!controlled) {
            EXPECT_GE(sheet.dampingNsmm, c.stiffnessNmm * (0.5 / rate + delay) + c.dampingNsmm - 1e-12)
                << "b > KT/2 + |B|";
          }
          EXPECT_GE(b.controlledNmm, 2 * b.colgateBrownNmm)
              << sheet.name << ": its top damping does what is asked of it";
        }
  const CouplingBounds touch = couplingBounds(deviceSheet("touch"), kPeriod);
  EXPECT_NEAR(touch.colgateBrownNmm, 1.6, 1e-9) << "2b/T";
  EXPECT_NEAR(touch.quantizationNmm, 2 * 0.26 / 0.055, 1e-9) << "2c/Δ";
  EXPECT_THROW((void)couplingBounds(deviceSheet("touch"), 0.02), Error);
  EXPECT_THROW((void)couplingBounds(deviceSheet("touch"), kPeriod, 0.1), Error);
}

TEST(EnergyTank, GivesNoMoreThanWasPutInAndHoldsNoMoreThanItsSize) {
  EnergyTank tank(4, 1);
  EXPECT_EQ(tank.draw(3), 3);
  EXPECT_EQ(tank.draw(3), 1);
  EXPECT_EQ(tank.draw(3), 0);
  tank.fill(100);
  EXPECT_EQ(tank.levelNmm(), 4);
  (void)tank.draw(4);
  for (int i = 0; i < 500; ++i) tank.pass(1e-3);
  EXPECT_NEAR(tank.levelNmm(), 0.5, 1e-9);
}

TEST(Passivity, LeavesAPassiveSceneAloneBitForBit) {
  // Clay that yields: pressed in it costs work, let out it gives less than half of it back. Nothing is ever lacking.
  Passivity passivity(deviceSheet("touchx"), kPeriod);
  constexpr double kStiffness = 1;
  const auto place = [](int i) { return -2 - 1.7 * std::sin(i * 0.013); };
  double pressed = 0;
  for (int i = 0; i < 5000; ++i) {
    const bool out = place(i + 1) > place(i);
    Passivity::Input in = wall(place(i), (place(i + 1) - place(i)) / kPeriod, kStiffness);
    in.storedNmm *= 0.5;
    if (out) in.force *= 0.4;
    const Vec3d force = passivity.apply(in);
    ASSERT_EQ(force, in.force) << i << ": " << passivity.lackingNmm();
    ASSERT_EQ(passivity.addedNsmm(), 0);
    passivity.commanded(force);
    pressed = std::max(pressed, force.z());
  }
  EXPECT_GT(pressed, 3);
}

TEST(Passivity, DampsWhatAHeldForceLeaks) {
  const DeviceSheet& sheet = deviceSheet("touchx");
  double without = 0;
  for (const bool controlled : {false, true}) {
    Passivity passivity(sheet, kPeriod);
    const double stiffness = 3;
    double given = 0, before = 3;
    Vec3d held = Vec3d::Zero();
    for (int i = 0; i < 4000; ++i) {
      const double z = 1 - 2 * std::sin(i * 0.02), speed = -2 * 0.02 / kPeriod * std::cos(i * 0.02);
      given += held.z() * (z - before) * (i > 0);
      before = z;
      const Passivity::Input in = wall(z, speed, stiffness);
      held = controlled ? passivity.apply(in) : in.force;
      ASSERT_GE(held.z(), 0) << "never turned round";
      ASSERT_LE(held.z(), in.force.z() + sheet.topDampingNsmm * std::abs(speed) + 1e-12)
          << "no more damping than the sheet's top";
      passivity.commanded(held);
    }
    std::printf("%s: a prescribed tool got %.3f mJ in 13 contacts\n", controlled ? "with passivity control" : "without",
                given);
    if (controlled) {
      EXPECT_LE(given, 0.05 * without) << "all but what is slower than encoder steps can tell";
    } else {
      EXPECT_GT(given, 0.2) << "½ K Δx² a tick";
      without = given;
    }
  }
}

TEST(Passivity, AnActiveScenePushesNoHarderThanTheTankPays) {
  // Clay grows under a hand that does not move, again and again.
  const DeviceSheet& sheet = deviceSheet("touchx");
  Passivity passivity(sheet, kPeriod);
  const double stiffness = sheet.topStiffnessNmm, full = passivity.tank().capacityNmm();
  double top = 0, drawn = 0;
  for (int growth = 0; growth < 4; ++growth) {
    double steepest = 0, last = 0;
    (void)passivity.apply(wall(0, 0, stiffness, false, -1));
    const double paid = passivity.tank().levelNmm() + 300 * kPeriod * passivity.tank().trickleNmmS();
    for (int i = 0; i < 300; ++i) {
      const bool active = i < 200;
      if (active) top = 0.01 * (i + 1);
      const double level = passivity.tank().levelNmm();
      const Passivity::Input in = wall(0, 0, stiffness, active, top);
      const Vec3d out = passivity.apply(in);
      drawn += std::max(0.0, level - passivity.tank().levelNmm());
      ASSERT_LE(out.z(), in.force.z() * (1 + 1e-12));
      ASSERT_GE(out.z(), 0);
      ASSERT_TRUE(out.allFinite());
      steepest = std::max(steepest, std::abs(out.z() - last));
      last = out.z();
      passivity.commanded(out);
    }
    if (growth == 0) {
      EXPECT_NEAR(last, stiffness * 2, 1e-9) << "the first is paid in full";
    } else {
      EXPECT_LT(last, 0.7 * stiffness * 2);
    }
    EXPECT_LE(0.5 * last * last / stiffness, paid * (1 + 1e-9))
        << "the hand does not move: all that the spring holds came from the tank";
    EXPECT_GT(last, 0.1);
    // Afterwards the clay is gone: what the spring held is lost to the scene, and the person gets nothing of it. Empty
    // the tank.
    const Passivity::Input gone = wall(0, 0, stiffness, false, -1);
    passivity.commanded(passivity.apply(gone));
    passivity.interrupt();
    while (passivity.tank().levelNmm() > 0.02 * full) {
      Passivity::Input drain = wall(0, 0, stiffness, true, 0.5);
      (void)passivity.apply(gone);
      (void)passivity.apply(drain);
      passivity.interrupt();
    }
    EXPECT_LT(steepest, 0.1) << "no jump when the tank runs dry, nor when the clay has stopped growing";
  }
  EXPECT_GT(drawn, 0);
}

TEST(Passivity, ItsForceStaysFiniteWithinLimitsAndInRealTimeWhateverComes) {
  constexpr uint32_t kSeed = 7;
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  const DeviceSheet& sheet = deviceSheet("falcon");
  Passivity passivity(sheet, kPeriod, 2.3e-3);
  testing::RealtimeTrap trap;
  Vec3d place = Vec3d::Zero();
  for (int i = 0; i < 100000; ++i) {
    place += 0.2 * Vec3d(normal(random), normal(random), normal(random));
    if (random() % 1000 == 0) place = 1e6 * Vec3d(normal(random), normal(random), normal(random));
    if (random() % 1000 == 1) place.setZero();
    Passivity::Input in;
    in.position = place;
    in.velocity = 300 * Vec3d(normal(random), normal(random), normal(random));
    in.force = random() % 3 ? Vec3d(3 * Vec3d(normal(random), normal(random), normal(random))) : Vec3d(Vec3d::Zero());
    in.storedNmm = random() % 4 ? std::abs(normal(random)) : 0;
    in.dampingNsmm = 0.002;
    in.active = random() % 5 == 0;
    if (random() % 200 == 0) passivity.interrupt();
    trap.enter();
    const Vec3d out = passivity.apply(in);
    passivity.commanded(out);
    trap.leave();
    ASSERT_TRUE(out.allFinite());
    ASSERT_LE(out.norm(), in.force.norm() + (sheet.topDampingNsmm + in.dampingNsmm) * in.velocity.norm() + 1e-9);
    ASSERT_GE(out.dot(in.force), 0);
    ASSERT_LE(passivity.tank().levelNmm(), passivity.tank().capacityNmm());
    ASSERT_GE(passivity.tank().levelNmm(), 0);
    if (i == 0) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
  }
  EXPECT_EQ(trap.allocations, 0u);
  EXPECT_EQ(trap.locks, 0u);
  EXPECT_EQ(trap.systemCalls, 0u);
  EXPECT_THROW(Passivity(sheet, kPeriod, 0.02), Error);
}

TEST(Passivity, AfterAPauseNothingOfBeforeIsDampedAndAResetFillsTheTank) {
  Passivity passivity(deviceSheet("touchx"), kPeriod);
  const auto leak = [&] {
    // Each way in is far slower than the way out, at a force that is held for a period: energy leaks.
    double most = 0;
    for (int i = 0; i < 400; ++i) {
      const double z = -1 + 0.9 * std::sin(i * 0.8), speed = 0.9 * 0.8 * std::cos(i * 0.8) / kPeriod;
      const Passivity::Input in = wall(z, speed, 3);
      passivity.commanded(passivity.apply(in));
      most = std::max(most, passivity.lackingNmm());
      if (passivity.lackingNmm() > 0 && passivity.addedNsmm() > 0) return true;
    }
    return false;
  };
  ASSERT_TRUE(leak());
  passivity.interrupt();
  (void)passivity.apply(wall(-0.5, 0, 3));
  EXPECT_EQ(passivity.lackingNmm(), 0);
  EXPECT_EQ(passivity.addedNsmm(), 0);
  // Clay that grows empties the tank.
  for (int i = 0; i < 1000 && passivity.tank().levelNmm() > 0.1 * passivity.tank().capacityNmm(); ++i)
    passivity.commanded(passivity.apply(wall(0, 0, 3, true, 0.2 * (i + 1))));
  ASSERT_LT(passivity.tank().levelNmm(), 0.2 * passivity.tank().capacityNmm());
  ASSERT_TRUE(leak());
  passivity.reset();
  EXPECT_EQ(passivity.tank().levelNmm(), passivity.tank().capacityNmm());
  EXPECT_EQ(passivity.lackingNmm(), 0);
  EXPECT_EQ(passivity.addedNsmm(), 0);
}

}  // namespace
}  // namespace argil::haptics
