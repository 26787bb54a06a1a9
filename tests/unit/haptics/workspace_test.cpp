// Scale, walls, depth, clutch and handedness: whatever changes, the tip stays where it is.

#include "haptics/scene/workspace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo.h"
#include "realtime_trap.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

constexpr double kPeriod = 1e-3;
const DeviceSheet& sheet() {
  return deviceSheet("touch");
}
Pose at(const Vec3d& p) {
  return {p, Eigen::Quaterniond::Identity()};
}
Eigen::Quaterniond anyTurn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
}

TEST(Workspace, IsPlainUntilSomethingChanges) {
  Workspace workspace;
  workspace.pose = {{3, -2, 7}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()))};
  workspace.scale = 0.37;
  WorkspaceMap map;
  for (int i = 0; i < 100; ++i) {
    const Vec3d device(0.31 * i, 5 - 0.7 * i, 0.011 * i);
    const Pose world = map.toWorld(workspace, sheet(), at(device), 3, kPeriod);
    ASSERT_EQ(world.translation, workspace.pose.apply(workspace.scale * device)) << "to the last bit";
    ASSERT_EQ(map.toDevice({1, 2, 3}), workspace.pose.rotation.conjugate() * Vec3d(1, 2, 3));
    ASSERT_EQ(map.wallForce(), Vec3d::Zero());
    ASSERT_NEAR((workspace.toDevice(world.translation) - device).norm(), 0, 1e-12);
  }
}

TEST(Workspace, MirrorsALeftHandedFrame) {
  Workspace workspace;
  workspace.frame = Handedness::left;
  WorkspaceMap map;
  Pose device = at({1, 2, 3});
  device.rotation = Eigen::AngleAxisd(0.5, Vec3d::UnitZ());
  const Pose world = map.toWorld(workspace, sheet(), device, 0, kPeriod);
  EXPECT_EQ(world.translation, Vec3d(-1, 2, 3));
  EXPECT_EQ(workspace.toDevice(world.translation), Vec3d(1, 2, 3));
  // What the stylus points along is mirrored as places are.
  const Vec3d along = device.rotation * Vec3d(0.6, 0.8, 0);
  EXPECT_NEAR((world.rotation * Vec3d(-0.6, 0.8, 0) - Vec3d(-along.x(), along.y(), along.z())).norm(), 0, 1e-12);
  EXPECT_EQ(map.toDevice({5, 6, 7}), Vec3d(-5, 6, 7));
  EXPECT_EQ(map.turnToWorld({5, 6, 7}), Vec3d(-5, 6, 7));
  // The sheet decides where the person does not.
  DeviceSheet left = sheet();
  left.handedness = Handedness::left;
  WorkspaceMap other;
  EXPECT_EQ(other.toWorld(Workspace(), left, at({1, 2, 3}), 0, kPeriod).translation, Vec3d(-1, 2, 3));
  workspace.frame = Handedness::right;
  WorkspaceMap third;
  EXPECT_EQ(third.toWorld(workspace, left, at({1, 2, 3}), 0, kPeriod).translation, Vec3d(1, 2, 3));
}

TEST(Workspace, NoChangeOfAnySettingMovesTheTip) {
  constexpr uint32_t kSeed = 11;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 200; ++round) {
    WorkspaceMap map;
    Workspace workspace;
    workspace.clutchButtons = 4;
    Vec3d device = Vec3d::Zero(), tip = Vec3d::Zero();
    uint32_t buttons = 0;
    for (int i = 0; i < 60; ++i) {
      const bool change = i > 0 && random() % 3 == 0;
      if (!change) {
        device += 3 * Vec3d(unit(random), unit(random), unit(random));
        if (random() % 5 == 0) buttons ^= 4;
      } else {
        switch (random() % 6) {
          case 0:
            workspace.scale = std::pow(10.0, 3 * unit(random));
            break;
          case 1:
            workspace.pose.translation = 50 * Vec3d(unit(random), unit(random), unit(random));
            break;
          case 2:
            workspace.pose.rotation = anyTurn(random);
            break;
          case 3:
            workspace.depthMm += 1 + 40 * std::abs(unit(random));
            break;
          case 4:
            workspace.frame = workspace.frame == Handedness::left ? Handedness::right : Handedness::left;
            break;
          default:
            buttons ^= 4;
            workspace.scale *= 1.01;
            break;
        }
      }
      const Pose world = map.toWorld(workspace, sheet(), at(device), buttons, kPeriod);
      if (change) {
        // Rounding of large worlds: 1000 mm of hand at the largest scale.
        ASSERT_LE((world.translation - tip).norm(), 1e-9 + 1e-14 * workspace.scale * 1000)
            << "seed " << kSeed << " round " << round;
      }
      tip = world.translation;
    }
  }
  // One by one, to rounding; and a clutch or walls that are only then switched on.
  for (int which = 0; which < 6; ++which) {
    for (uint32_t buttons : {0u, 4u}) {
      WorkspaceMap map;
      Workspace workspace;
      workspace.clutchButtons = which == 4 ? 0 : 4;
      workspace.scale = 0.3;
      workspace.walls.on = which == 5;
      (void)map.toWorld(workspace, sheet(), at({10, 20, 30}), 0, kPeriod);
      const Vec3d before = map.toWorld(workspace, sheet(), at({12, 21, 28}), buttons, kPeriod).translation;
      if (which == 0) workspace.scale = 0.001;
      if (which == 1) workspace.pose = {{5, 5, 5}, anyTurn(random)};
      if (which == 2) workspace.depthMm = 15;
      if (which == 3) workspace.frame = Handedness::left;
      if (which == 4) workspace.clutchButtons = 4;
      if (which == 5) workspace.walls = PanWalls();
      const Vec3d after = map.toWorld(workspace, sheet(), at({12, 21, 28}), buttons, kPeriod).translation;
      EXPECT_LE((after - before).norm(), 1e-9) << which;
    }
  }
}

TEST(Workspace, AZoomIsAboutTheTipAndKeepsTheForceOfAPressingHand) {
  WorkspaceMap map;
  Workspace workspace;
  workspace.pose.translation = {100, 0, 0};
  const Vec3d device(10, 5, -3);
  (void)map.toWorld(workspace, sheet(), at(device), 0, kPeriod);
  const Vec3d before = map.toWorld(workspace, sheet(), at(device), 0, kPeriod).translation;
  const Vec3d held = before + Vec3d(0, 0, 1.5);  // The surface holds the ball 1.5 mm above.
  for (double scale : {0.5, 0.01, 1e-6, 40.0}) {
    workspace.scale = scale;
    const Vec3d hand = map.toWorld(workspace, sheet(), at(device), 0, kPeriod, &held).translation;
    // The spring in the world is k / scale: the same newtons as before at the same depth of the hand.
    EXPECT_NEAR(((held - hand) / scale - Vec3d(0, 0, 1.5)).norm(), 0, 1e-7) << scale;
    const Vec3d moved = map.toWorld(workspace, sheet(), at(device + Vec3d(0, 0, -1)), 0, kPeriod, &held).translation;
    EXPECT_NEAR(((held - moved) / scale - Vec3d(0, 0, 2.5)).norm(), 0, 1e-7)
        << "a mm of the hand is a mm of its spring";
    (void)map.toWorld(workspace, sheet(), at(device), 0, kPeriod, &held);
  }
}

TEST(Workspace, TheClutchLetsTheHandGoAndTakesTheForceSoftly) {
  WorkspaceMap map;
  Workspace workspace;
  workspace.clutchButtons = 2;
  Vec3d device(40, 0, 0);
  const Vec3d before = map.toWorld(workspace, sheet(), at(device), 0, kPeriod).translation;
  double last = 1;
  for (int i = 0; i < 80; ++i) {
    device.x() -= 0.5;
    ASSERT_EQ(map.toWorld(workspace, sheet(), at(device), 2, kPeriod).translation, before);
    const double grip = map.toDevice(Vec3d::UnitX()).x();
    ASSERT_LE(std::abs(grip - last), 0.0201);
    last = grip;
    EXPECT_TRUE(map.clutched());
  }
  EXPECT_EQ(last, 0);
  // Let go: from here the tip follows again, from where it was.
  const Vec3d after = map.toWorld(workspace, sheet(), at(device + Vec3d(1, 2, 3)), 0, kPeriod).translation;
  EXPECT_NEAR((after - before - Vec3d(1, 2, 3)).norm(), 0, 1e-12);
  for (int i = 0; i < 60; ++i) (void)map.toWorld(workspace, sheet(), at(device), 0, kPeriod);
  EXPECT_EQ(map.toDevice(Vec3d::UnitX()).x(), 1);
}

TEST(Workspace, APressedWallPansAsFastAsItIsPressed) {
  Workspace workspace;
  workspace.scale = 0.1;
  workspace.walls.on = true;
  const double edge = 0.5 * workspace.walls.share * sheet().workspaceMm.x();
  const auto pan = [&](double press, int ticks) {
    WorkspaceMap map;
    const Vec3d first = map.toWorld(workspace, sheet(), at({edge + press, 0, 0}), 0, kPeriod).translation;
    Vec3d tip = first;
    for (int i = 0; i < ticks; ++i) {
      tip = map.toWorld(workspace, sheet(), at({edge + press, 0, 0}), 0, kPeriod).translation;
      EXPECT_NEAR(map.wallForce().x(), -workspace.walls.stiffnessNmm * std::max(0.0, press), 1e-12);
    }
    EXPECT_EQ(tip.y(), 0);
    return (tip - first).x() / (ticks * kPeriod) / workspace.scale;  // mm of hand a second
  };
  EXPECT_EQ(pan(-0.5, 100), 0);
  EXPECT_EQ(pan(0.9, 1000), 0) << "a hand at rest wanders 1 mm: the model must not move";
  EXPECT_NEAR(pan(2, 1000), workspace.walls.speedMmsN * 0.4 * 1, 1e-6);
  EXPECT_NEAR(pan(3, 1000), workspace.walls.speedMmsN * 0.4 * 2, 1e-6);
  // Never more than half of the motors.
  WorkspaceMap map;
  (void)map.toWorld(workspace, sheet(), at({edge + 60, 0, 0}), 0, kPeriod);
  EXPECT_NEAR(map.wallForce().norm(), 0.5 * sheet().peakForceN, 1e-12);
}

TEST(Workspace, DepthBringsTheNearestWithinReachAndGlidesThere) {
  Workspace workspace;
  workspace.pose.rotation = Eigen::AngleAxisd(0.4, Vec3d::UnitY());
  workspace.scale = 2;
  const Vec3d person = workspace.pose.rotation * Vec3d::UnitZ();
  // Two small boxes, one much nearer to the person.
  const std::vector<Eigen::AlignedBox3d> boxes = {
      {Vec3d(-1, -1, -1), Vec3d(1, 1, 1)}, {Vec3d(300 * person - Vec3d::Ones()), Vec3d(300 * person + Vec3d::Ones())}};
  WorkspaceMap map;
  const Vec3d first = map.toWorld(workspace, sheet(), at(Vec3d::Zero()), 0, kPeriod).translation;
  workspace.depthMm = touchableDepthMm(workspace, sheet(), boxes);
  // The reach now holds the nearer box and not the farther one.
  const auto reached = [&](const Vec3d& world) {
    return (workspace.toDevice(world).cwiseAbs().array() <= 0.5 * sheet().workspaceMm.array()).all();
  };
  EXPECT_TRUE(reached(300 * person));
  EXPECT_FALSE(reached(Vec3d::Zero()));
  Workspace behind = workspace;
  behind.depthMm = touchableDepthMm(workspace, sheet(), boxes, 250);
  EXPECT_NEAR(workspace.depthMm - behind.depthMm, 250, 1e-9);
  EXPECT_EQ(touchableDepthMm(workspace, sheet(), {}), 0);

  const Vec3d held = first;
  Vec3d tip = map.toWorld(workspace, sheet(), at(Vec3d::Zero()), 0, kPeriod).translation;
  EXPECT_LE((tip - first).norm(), 1e-9);
  for (int i = 0; i < 100; ++i) tip = map.toWorld(workspace, sheet(), at(Vec3d::Zero()), 0, kPeriod, &held).translation;
  EXPECT_LE((tip - first).norm(), 1e-9) << "not while it touches";
  for (int i = 0; i < 5000; ++i) {
    const Vec3d next = map.toWorld(workspace, sheet(), at(Vec3d::Zero()), 0, kPeriod).translation;
    ASSERT_LE((next - tip).norm(), workspace.glideMms * workspace.scale * kPeriod * (1 + 1e-9));
    tip = next;
  }
  EXPECT_NEAR((tip - workspace.toWorld(Vec3d::Zero())).norm(), 0, 1e-9) << "and then it is there";
}

TEST(Workspace, RefusesBadNumbers) {
  const auto refused = [](auto&& spoil) {
    Workspace workspace;
    spoil(workspace);
    EXPECT_THROW(workspace.check(), Error);
  };
  EXPECT_NO_THROW(Workspace().check());
  const double nan = std::nan("");
  for (double bad : {0.0, -1.0, 1e-7, 1e7, nan}) refused([bad](Workspace& w) { w.scale = bad; });
  refused([nan](Workspace& w) { w.depthMm = nan; });
  refused([](Workspace& w) { w.glideMms = -1; });
  refused([](Workspace& w) { w.walls.share = 1.5; });
  refused([](Workspace& w) { w.walls.stiffnessNmm = 0; });
  refused([nan](Workspace& w) { w.walls.speedMmsN = nan; });
  refused([](Workspace& w) { w.walls.restMm = 11; });
  refused([](Workspace& w) { w.pose.rotation.w() = 0.5; });
}

// A finger of clay felt through the whole servo.
struct Felt {
  StylusSample before, after;
  double steepestN = 0;
};
Felt zoomWhilePressing(double from, double to) {
  Tool tool;
  testing::VirtualSession session(0.5, tool);
  Workspace& workspace = session.scene().workspace;
  workspace.scale = from;
  workspace.pose.translation = {1, 2, 3};
  session.publish();
  SimulatedDevice::Options options;
  options.prescribed = true;
  options.encoderSteps = false;
  SimulatedDevice device(deviceSheet("touchx"), HandPath::line({0, 0, 4}, {0, 0, -1.5}, 1), options);
  Servo servo(device, session.published());
  servo.runVirtual(1200);
  Felt felt;
  felt.before = servo.tick().last();
  workspace.scale = to;
  session.publish();
  Vec3d last = felt.before.forceN;
  servo.runVirtual(300, [&](uint64_t, double) {
    felt.steepestN = std::max(felt.steepestN, (servo.tick().last().forceN - last).norm());
    last = servo.tick().last().forceN;
  });
  felt.after = servo.tick().last();
  EXPECT_EQ(servo.fault(), Fault::none);
  return felt;
}

TEST(Workspace, ZoomsInMidPressWithoutAKick) {
  for (const auto& [from, to] : {std::pair(1.0, 0.5), {1.0, 0.1}, {0.2, 1.0}}) {
    const Felt felt = zoomWhilePressing(from, to);
    std::printf("scale %.2f to %.2f: force %.4f to %.4f N, steepest %.5f N a tick, tip moved by %.2e mm\n", from, to,
                felt.before.forceN.norm(), felt.after.forceN.norm(), felt.steepestN,
                (felt.after.proxy - felt.before.proxy).norm());
    EXPECT_GT(felt.before.forceN.z(), 1.0);
    EXPECT_NEAR(felt.after.forceN.norm(), felt.before.forceN.norm(), 0.02 * felt.before.forceN.norm());
    EXPECT_LE(felt.steepestN, 0.02 * felt.before.forceN.norm());
    EXPECT_LE((felt.after.proxy - felt.before.proxy).norm(), 0.02 * 0.5);
  }
}

TEST(Workspace, AHandAtRestDoesNotShakeASmallScale) {
  // The same wandering hand, 1 mm, on the surface: at 1:100 a voxel of 0.5 mm is 50 mm of the hand.
  constexpr double kScale = 0.01, kVoxel = 0.5;
  Tool tool;
  testing::VirtualSession session(kVoxel, tool);
  session.scene().workspace.scale = kScale;
  session.scene().workspace.pose.translation = {0, 0, 3 - 0.02};  // The plane is felt 2 mm above the device's middle.
  session.publish();
  std::vector<HandPoint> points;
  for (int i = 0; i < 400; ++i) {
    HandPoint p;
    p.timeS = 0.01 * i;
    // From free space down to 1 mm deep, then wandering within 1 mm.
    const double down = std::max(0.0, 5 - 0.05 * i);
    p.position = {0.5 * std::sin(0.05 * i), 0.5 * std::cos(0.031 * i), 1 + down + 0.3 * std::sin(0.043 * i)};
    points.push_back(p);
  }
  SimulatedDevice::Options options;
  options.prescribed = true;
  SimulatedDevice device(deviceSheet("touchx"), HandPath(points), options);
  Servo servo(device, session.published());
  Eigen::AlignedBox3d box;
  double steepest = 0;
  Vec3d last = Vec3d::Zero();
  uint64_t touching = 0;
  servo.runVirtual(3900, [&](uint64_t i, double) {
    const StylusSample& sample = servo.tick().last();
    if (i > 1500) {
      box.extend(sample.proxy);
      steepest = std::max(steepest, (sample.forceN - last).norm());
      touching += (sample.flags & kTouching) != 0;
    }
    last = sample.forceN;
  });
  std::printf("the tip wandered over %.4f voxels, steepest change of force %.4f N a tick\n",
              box.sizes().maxCoeff() / kVoxel, steepest);
  EXPECT_GT(touching, 2000u);
  EXPECT_LE(box.sizes().maxCoeff(), 0.1 * kVoxel) << "1 mm of hand is less than a tenth of a voxel";
  EXPECT_LE(steepest, 0.07 * device.sheet().peakForceN);
}

TEST(Workspace, KeepsToTheRulesOfRealTime) {
  Workspace workspace;
  workspace.walls.on = true;
  workspace.clutchButtons = 2;
  WorkspaceMap map;
  testing::RealtimeTrap trap;
  const Vec3d held(0, 0, 0);
  Vec3d sum = Vec3d::Zero();
  for (int i = 0; i < 20'000; ++i) {
    if (i % 500 == 250) workspace.scale = 1 + (i % 7);
    if (i % 700 == 350) workspace.depthMm = i % 11;
    const Pose device = at({90 * std::sin(i * 0.001), 80 * std::cos(i * 0.0013), 0});
    trap.enter();
    sum += map.toWorld(workspace, sheet(), device, i % 900 < 100 ? 2 : 0, kPeriod, i % 300 < 100 ? &held : nullptr)
               .translation;
    sum += map.toDevice(map.wallForce()) + map.velocityToWorld(device.translation);
    trap.leave();
    if (i == 0) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
  }
  EXPECT_TRUE(sum.allFinite());
  EXPECT_EQ(trap.allocations + trap.locks + trap.systemCalls, 0u);
}

}  // namespace
}  // namespace argil::haptics
