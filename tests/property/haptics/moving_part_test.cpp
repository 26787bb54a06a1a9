// Parts and pieces that move: however fast, they push the ball along and never pass through it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/analysis/touch_bench.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/servo/servo_tick.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kRadius = 3;
constexpr uint32_t kSeed = 20261121;

// A thin plate in the plane x = 0 of its own frame, felt from both sides.
std::shared_ptr<const PartMesh> plate(double half, int cells) {
  clay::TriangleMesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.positions.push_back({0, half * (2.0 * i / cells - 1), half * (2.0 * j / cells - 1)});
  const auto row = static_cast<uint32_t>(cells + 1);
  for (uint32_t j = 0; j + 1 < row; ++j)
    for (uint32_t i = 0; i + 1 < row; ++i) {
      const uint32_t a = j * row + i;
      mesh.triangles.push_back({a, a + 1, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + row});
    }
  return std::make_shared<const PartMesh>(mesh);
}

Scene sceneOf(std::shared_ptr<const PartMesh> mesh, double radiusMm = kRadius) {
  Scene scene;
  scene.parts.push_back({std::move(mesh), Pose(), 0});
  scene.tool.radiusMm = radiusMm;
  return scene;
}

// What a force may change by in a tick: what the way of the part stretches the spring by, twice that where a first step
// waited to be known as a motion, and a little for the contact's tolerance.
double mostJump(double speed, double stiffness) {
  return 2.1 * stiffness * speed * 1e-3 + 0.02;
}

// A plate flies 60 mm against a ball in a hand at rest, its poses published every so many ticks.
TEST(MovingPart, PushesAHandAtRestAndNeverPassesThroughIt) {
  const auto mesh = plate(80, 8);
  for (const double speed : {10.0, 30.0, 100.0, 300.0, 1000.0})
    for (const int every : {1, 3, 16})
      for (const double radius : {1.0, 3.0}) {
        Scene scene = sceneOf(mesh, radius);
        BallContact contact;
        BallContact::Input input;
        input.hand = {0, 0.37, -0.21};
        input.peakForceN = 1e4;  // Never clamped: the force is the spring's.
        const double from = 12;
        Vec3d before = Vec3d::Zero();
        double jump = 0, deepest = 0;
        const int ticks = static_cast<int>(std::ceil(60 / (speed * 1e-3)));
        for (int i = 0; i < ticks; ++i) {
          if (i % every == 0) scene.parts[0].pose.translation.x() = from - speed * 1e-3 * i;
          const BallContact::Output out = contact.tick(scene, input);
          const double felt = scene.parts[0].pose.translation.x();
          // The plate that is felt may be behind the one that is published, by two publications: the ball is on its
          // left.
          ASSERT_LT(out.proxy.x(), felt + 2 * speed * 1e-3 * every + radius)
              << "speed " << speed << " every " << every << " tick " << i;
          if (felt + 2 * speed * 1e-3 * every < -radius) {
            ASSERT_LT(out.proxy.x(), felt + 2 * speed * 1e-3 * every - radius + 0.05)
                << "speed " << speed << " every " << every << " tick " << i;
            ASSERT_LT(out.force.x(), 0);
          }
          jump = std::max(jump, (out.force - before).norm());
          deepest = std::max(deepest, out.force.norm());
          before = out.force;
        }
        EXPECT_LE(jump, mostJump(speed, input.topStiffnessNmm))
            << "speed " << speed << " every " << every << " radius " << radius;
        EXPECT_GT(deepest, 30) << "the ball was taken along";
      }
}

// Poses at random speeds and spins about far and near pivots: as the part sees it, the ball stays on its side.
TEST(MovingPart, NeverPassesThroughWhileItTurns) {
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto mesh = plate(60, 6);
  int touched = 0;
  for (int round = 0; round < 60; ++round) {
    // mm/s, rad/s.
    const double speed = std::pow(10.0, 2 + u(random)), spin = speed / (20 + 80 * std::abs(u(random)));
    const Vec3d axis = Vec3d(0.3 * u(random), u(random), u(random)).normalized(),
                pivot(0, 30 * u(random), 30 * u(random));
    Scene scene = sceneOf(mesh);
    BallContact contact;
    BallContact::Input input;
    input.hand = Vec3d(0, 5 * u(random), 5 * u(random));
    input.peakForceN = 1e4;
    const double side = round % 2 ? 1 : -1;
    const double seconds = std::min(60 / speed, 0.6);
    double overlap = 0;
    bool touching = false;
    for (int i = 0; i < static_cast<int>(seconds * 1e3); ++i) {
      const double t = i * 1e-3;
      const Eigen::AngleAxisd turn(spin * t, axis);
      Pose& pose = scene.parts[0].pose;
      pose.rotation = Eigen::Quaterniond(turn);
      pose.translation = Vec3d(side * (8 - speed * t), 0, 0) + pivot - turn * pivot;
      const BallContact::Output out = contact.tick(scene, input);
      const Vec3d seen = pose.applyInverse(out.proxy);
      // Beside the plate it may go anywhere.
      if (std::max(std::abs(seen.y()), std::abs(seen.z())) > 60 - 2 * kRadius) break;
      if (i < 3) continue;  // A first step may be a jump: known as a motion from the next one on.
      ASSERT_LT(side * seen.x(), 0) << "round " << round << " tick " << i << " speed " << speed;
      overlap = std::max(overlap, kRadius + side * seen.x());
      touching = touching || (out.flags & kTouching);
    }
    touched += touching;
    EXPECT_LT(overlap, 0.03) << "round " << round << " speed " << speed << " spin " << spin;
  }
  EXPECT_GT(touched, 40);
}

// A piece of clay is a moving thing like any other.
TEST(MovingPart, ClayThatMovesDoesTheSame) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const clay::Version block = clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), Vec3d(4, 60, 60), 0);
  for (const double speed : {30.0, 300.0, 1000.0}) {
    Scene scene;
    scene.pieces.push_back({block, Pose(), 0});
    scene.tool.radiusMm = kRadius;
    BallContact contact;
    BallContact::Input input;
    input.peakForceN = 1e4;
    Vec3d before = Vec3d::Zero();
    for (int i = 0; i < static_cast<int>(50 / (speed * 1e-3)); ++i) {
      const double x = 10 - speed * 1e-3 * i;  // Middle of a block 4 mm thick.
      scene.pieces[0].pose.translation.x() = x;
      const BallContact::Output out = contact.tick(scene, input);
      if (i > 2) {
        ASSERT_LT(out.proxy.x(), x - 2 - kRadius + 0.05) << "speed " << speed << " tick " << i;
      }
      ASSERT_LE((out.force - before).norm(), mostJump(speed, input.topStiffnessNmm))
          << "speed " << speed << " tick " << i;
      before = out.force;
    }
    EXPECT_LT(before.x(), -20) << speed;
  }
}

// Between a wall at rest and a part that comes there is no place in the end: the part waits, nothing passes.
TEST(MovingPart, ABallBetweenTwoThingsHoldsTheOneThatComes) {
  const auto mesh = plate(40, 4);
  Scene scene = sceneOf(mesh);
  scene.parts.push_back({mesh, Pose(), 0});
  scene.parts[1].pose.translation.x() = -5;
  BallContact contact;
  BallContact::Input input;
  input.peakForceN = 1e4;
  for (int i = 0; i < 200; ++i) {
    scene.parts[0].pose.translation.x() = 10 - 0.1 * i;
    const BallContact::Output out = contact.tick(scene, input);
    ASSERT_GT(out.proxy.x(), -5 + kRadius - 0.05) << i;
    if (i < 130) continue;  // By now the plate would be through the ball.
    ASSERT_GE(out.reactionCount, 1) << i << ": the one that comes is held, and told so";
    const Reaction& coming = out.reactions[out.reactions[0].part == 0 ? 0 : 1];
    ASSERT_EQ(coming.part, 0) << i;
    ASSERT_GT(coming.forceN.x(), 1) << i;
  }
}

// What the hand feels, and minus that on what it touches, with its torque; friction and two things at once included.
TEST(MovingPart, GetsMinusTheForceOnTheHandAndItsTorque) {
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto ball = std::make_shared<const PartMesh>(icosphere(40, 4));
  for (int round = 0; round < 40; ++round) {
    Scene scene = sceneOf(ball);
    scene.materials[0].staticFriction = round % 2 ? 0.6 : 0;
    scene.materials[0].dynamicFriction = round % 2 ? 0.4 : 0;
    Pose& pose = scene.parts[0].pose;
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(u(random), Vec3d(u(random), u(random), 1).normalized()));
    pose.translation = 50 * Vec3d(u(random), u(random), u(random));
    BallContact contact;
    BallContact::Input input;
    input.peakForceN = round % 3 ? 100 : 1;  // Also clamped.
    const Vec3d way = Vec3d(u(random), u(random), u(random)).normalized(), aside = way.unitOrthogonal();
    int seen = 0;
    for (int i = 0; i < 300; ++i) {
      input.hand = scene.parts[0].pose.translation + way * (46 - 0.02 * i) + aside * (0.01 * i);
      pose.translation += Vec3d(0.02, -0.01, 0.03);
      pose.rotation = (Eigen::Quaterniond(Eigen::AngleAxisd(2e-4, Vec3d::UnitY())) * pose.rotation).normalized();
      const BallContact::Output out = contact.tick(scene, input);
      if (!(out.flags & kTouching)) continue;
      ++seen;
      ASSERT_EQ(out.reactionCount, 1) << i;
      const Reaction& r = out.reactions[0];
      EXPECT_EQ(r.part, 0);
      EXPECT_EQ(r.piece, -1);
      ASSERT_LT((r.forceN + out.force).norm(), 1e-9) << i;
      // The same force at the place of contact: on the line from the ball's middle to the part's.
      const Vec3d centre = pose.translation, contactPoint = centre + (out.proxy - centre).normalized() * 40;
      EXPECT_LT((r.centreMm - centre).norm(), 1e-3);
      ASSERT_LT((r.torqueNmm - (contactPoint - centre).cross(-out.force)).norm(),
                0.05 * 40 * out.force.norm() * 0.2 + 1e-6)
          << i;
      if (!(round % 2)) {
        EXPECT_LT(r.torqueNmm.norm(), 0.3 * out.force.norm() + 0.01)
            << "a push to the middle of a ball does not turn it";
      } else if (i > 280) {
        EXPECT_GT(r.torqueNmm.norm(), 1 * out.force.norm()) << "friction does";
      }
    }
    EXPECT_GT(seen, 100);
  }
}

TEST(MovingPart, SharesTheReactionAmongAllThatIsTouched) {
  // A groove of two plates, each at 45°.
  Scene scene = sceneOf(plate(40, 4));
  scene.parts.push_back(scene.parts[0]);
  scene.parts[0].pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 4, Vec3d::UnitY()));
  scene.parts[1].pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 4, Vec3d::UnitY()));
  BallContact contact;
  BallContact::Input input;
  input.peakForceN = 100;
  BallContact::Output out;
  for (int i = 0; i < 200; ++i) {
    input.hand = Vec3d(0, 0.3, 10 - 0.05 * i);
    out = contact.tick(scene, input);
  }
  ASSERT_EQ(out.reactionCount, 2);
  EXPECT_NE(out.reactions[0].part, out.reactions[1].part);
  EXPECT_LT((out.reactions[0].forceN + out.reactions[1].forceN + out.force).norm(), 1e-9);
  for (const Reaction& r : {out.reactions[0], out.reactions[1]})
    EXPECT_NEAR(std::abs(r.forceN.x()), std::abs(r.forceN.z()), 0.01);
  // Each acts 3 mm along its plate from the middle line: r × f = 3 mm · |f|.
  for (const Reaction& r : {out.reactions[0], out.reactions[1]})
    EXPECT_NEAR(std::abs(r.torqueNmm.y()), kRadius * r.forceN.norm(), 0.05);
}

// A belt under a ball that is pressed onto it drags the ball along as far as friction holds.
TEST(MovingPart, ABeltDragsTheHandByItsFriction) {
  Scene scene = sceneOf(plate(200, 4));
  scene.materials[0].staticFriction = scene.materials[0].dynamicFriction = 0.5;
  BallContact contact;
  BallContact::Input input;
  input.peakForceN = 100;
  BallContact::Output out;
  for (int i = 0; i < 1000; ++i) {
    input.hand = Vec3d(kRadius - std::min(2.0, 0.01 * i), 0, 0);  // 2 mm deep at 1 N/mm.
    scene.parts[0].pose.translation.y() = 0.1 * i;
    out = contact.tick(scene, input);
  }
  EXPECT_NEAR(out.force.x(), 2, 0.02);
  EXPECT_NEAR(out.force.y(), 1, 0.02) << "half of the push, along the belt";
}

// The servo hands out what the hand was really pushed with.
TEST(MovingPart, TheServoTellsItsReaction) {
  Published<Scene> published;
  published.publish(std::make_unique<const Scene>(sceneOf(std::make_shared<const PartMesh>(icosphere(40, 4)))));
  SimulatedDevice::Options options;
  options.prescribed = true;
  const HandPath down = HandPath::line({0, 0, 45}, {0, 0, 41.5}, 0.5);
  SimulatedDevice device(deviceSheet("touch"), down, options);
  SampleRing ring(2000);
  ServoTick tick(device, published, ring, 1e-3);
  Reactions reactions;
  int seen = 0;
  for (int i = 0; i < 800; ++i) {
    tick.run(i * 1e-3, false);
    ASSERT_TRUE(tick.reactions().load(reactions));
    EXPECT_EQ(reactions.index, tick.last().index);
    Vec3d sum = Vec3d::Zero();
    for (size_t k = 0; k < size_t(reactions.count); ++k) sum += reactions.all[k].forceN;
    EXPECT_LE(sum.norm(), tick.last().forceN.norm() + 1e-9);
    if (i < 700) continue;
    ++seen;
    EXPECT_LT((sum + tick.last().forceN).norm(), 0.01) << i;
  }
  EXPECT_GT(tick.last().forceN.z(), 0.5);
  EXPECT_GT(seen, 0);
}

}  // namespace
}  // namespace argil::haptics
