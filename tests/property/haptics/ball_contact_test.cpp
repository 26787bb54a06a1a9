// The proxy: on the surface, never through it, never farther from the hand than it has to be; pushed out gently when
// clay grows.

#include "haptics/contact/ball_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string_view>

#include "clay_fields.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr uint32_t kSeed = 11;
constexpr double kVoxel = 0.5;  // mm

Scene makeScene(const clay::Version& version, double radiusMm) {
  Scene scene;
  scene.pieces.push_back({version, Pose(), 0});
  scene.tool.radiusMm = radiusMm;
  scene.check();
  return scene;
}

BallContact::Input inputAt(const Vec3d& hand) {
  BallContact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = 1.0;
  in.peakForceN = 1e3;
  return in;
}

struct Case {
  const char* name;
  Field field;
};
std::vector<Case> cases() {
  return {{"plane", planeField({0.3, -0.2, 1}, 1.37)},
          {"sphere", sphereField({0.3, 0.2, -30.4}, 31.3)},
          {"groove", grooveField(18.6)},
          {"rim", rimField(14.2, 6.3)},
          {"noise", noiseField(kSeed, 1.5, 5.0)}};
}

TEST(BallContact, RestsAtItsRadiusFromTheSurface) {
  for (const Case& c : cases()) {
    const clay::Version version = makeClay(c.field, 7, kVoxel);
    for (double r : {0.5, 1.0, 3.0, 6.0, 12.0, 24.0}) {
      double worstRest = 0, worstMoving = 0;
      int most = 0;
      std::mt19937 random(kSeed);
      std::uniform_real_distribution<double> spread(-10, 10);
      BallContact contact;
      const Scene scene = makeScene(version, r * kVoxel);
      // Press down, then glide with the hand 1 to 4 voxels too deep.
      Vec3d from(spread(random), spread(random), r + 6);
      Vec3d to(spread(random), spread(random), r - 4);
      if (c.name == std::string_view("groove")) to.z() = std::sqrt(2.0) * r - 18.6 - 4;
      uint64_t touching = 0, lost = 0;
      for (int i = 0; i < 600; ++i) {
        const double s = std::min(1.0, i / 400.0);
        const Vec3d hand = kVoxel * (from + s * (to - from));
        const auto out = contact.tick(scene, inputAt(hand));
        most = std::max(most, contact.proxy().searches());
        if (out.flags & kTouching)
          ++touching;
        else if (touching)
          ++lost;
        const bool rest = i > 590;
        if ((out.flags & kTouching) && (i % 40 == 0 || i == 599)) {
          const Vec3d p = out.proxy / kVoxel;
          const double truth = bruteDistance(version, p, r + 0.6, r > 10 ? 6 : 10);
          (rest ? worstRest : worstMoving) = std::max(rest ? worstRest : worstMoving, std::abs(truth - r));
        }
      }
      std::printf("seed %u, %-6s r %4.1f: at rest %.4f, moving %.4f voxels; at most %d searches a tick\n", kSeed,
                  c.name, r, worstRest, worstMoving, most);
      EXPECT_GT(touching, 50u) << c.name << " " << r;
      EXPECT_EQ(lost, 0u) << c.name << " " << r;
      EXPECT_LE(worstRest, 0.05) << c.name << " " << r;
      EXPECT_LE(worstMoving, 0.1) << c.name << " " << r;
    }
  }
}

TEST(BallContact, NeverMovesAwayFromTheHandAndNeverOverlaps) {
  for (const Case& c : cases()) {
    const clay::Version version = makeClay(c.field, 6, kVoxel);
    for (double r : {0.5, 3.0, 12.0}) {
      std::mt19937 random(kSeed);
      std::normal_distribution<double> kick(0, 0.6);
      BallContact contact;
      const Scene scene = makeScene(version, r * kVoxel);
      ClosestSurface surface;
      surface.reset(version);
      Vec3d hand(0, 0, r + 3);
      Vec3d before = hand;
      double worst = 0;
      for (int i = 0; i < 2000; ++i) {
        hand += Vec3d(kick(random), kick(random), kick(random));
        hand = hand.cwiseMax(Vec3d(-14, -14, -6)).cwiseMin(Vec3d(14, 14, r + 6));
        const auto out = contact.tick(scene, inputAt(hand * kVoxel));
        const Vec3d p = out.proxy / kVoxel;
        ASSERT_FALSE(out.flags & kLeaving) << c.name << " r " << r << " tick " << i;
        if (i) {
          ASSERT_LE((p - hand).norm(), (before - hand).norm() + 0.01) << c.name << " r " << r << " tick " << i;
        }
        before = p;
        const SurfacePoint near = surface.nearest(p, r);
        if (near.found) worst = std::max(worst, r - near.distance);
        ASSERT_FALSE(surface.inside(p)) << c.name << " r " << r << " tick " << i;
      }
      EXPECT_LE(worst, 0.05) << c.name << " r " << r;
    }
  }
}

TEST(BallContact, FindsTheFloorOfAGrooveAndTheCornerOfThreeWalls) {
  // Two walls at 45°: the ball of radius r sits r√2 above the groove's floor line, however it came there.
  const clay::Version groove = makeClay(grooveField(18.6), 6, kVoxel);
  const double r = 6;
  const Scene scene = makeScene(groove, r * kVoxel);
  BallContact contact;
  BallContact::Output out;
  for (int i = 0; i < 300; ++i) out = contact.tick(scene, inputAt(kVoxel * Vec3d(5 - i * 0.02, 0, 20 - 0.15 * i)));
  EXPECT_NEAR(out.proxy.z() / kVoxel, -18.6 + r * std::sqrt(2.0), 0.1);
  EXPECT_NEAR(out.proxy.x() / kVoxel, 0, 0.1);
  EXPECT_EQ(out.planes, 2);
  // Three walls: a ball in a corner of a room rests at r from each.
  const clay::Version room = makeClay([](const Vec3d& p) { return p.minCoeff() + 8.3; }, 4, kVoxel);
  const Scene corner = makeScene(room, r * kVoxel);
  contact.reset();
  for (int i = 0; i < 300; ++i)
    out = contact.tick(corner, inputAt(kVoxel * (Vec3d(3, 2, 1) - Vec3d(0.08, 0.07, 0.06) * i)));
  EXPECT_LE((out.proxy / kVoxel - Vec3d::Constant(-8.3 + r)).cwiseAbs().maxCoeff(), 0.06)
      << (out.proxy / kVoxel).transpose();
  EXPECT_EQ(out.planes, 3);
}

TEST(BallContact, AJumpOfTheHandNeverPassesAThinWall) {
  // A sheet two voxels thick; the hand jumps 40 voxels through it in one tick.
  const clay::Version sheet = makeClay([](const Vec3d& p) { return std::abs(p.z()) - 1.0; }, 5, kVoxel);
  for (double r : {0.5, 2.0, 12.0}) {
    const Scene scene = makeScene(sheet, r * kVoxel);
    BallContact contact;
    (void)contact.tick(scene, inputAt(kVoxel * Vec3d(1.3, 0.4, 20)));
    BallContact::Output out;
    for (int i = 0; i < 60; ++i) out = contact.tick(scene, inputAt(kVoxel * Vec3d(1.3, 0.4, -20)));
    EXPECT_NEAR(out.proxy.z() / kVoxel, 1 + r, 0.05) << r;
  }
}

TEST(BallContact, ClayThatGrowsAroundTheBallPushesItOutGently) {
  const double peak = 3.3, stiffness = 1.26;
  const clay::Version none = makeClay(planeField({0, 0, 1}, -30), 5, kVoxel);
  for (double depth : {2.0, 10.0, 25.0}) {  // Voxels of clay above the ball's centre.
    const clay::Version wall = makeClay(planeField({0, 0, 1}, depth), 5, kVoxel);
    BallContact contact;
    const double r = 6;
    BallContact::Input in = inputAt({0.1, 0.2, 0});
    in.topStiffnessNmm = stiffness;
    in.peakForceN = peak;
    for (int i = 0; i < 10; ++i) (void)contact.tick(makeScene(none, r * kVoxel), in);
    std::vector<double> force;
    const Scene scene = makeScene(wall, r * kVoxel);
    BallContact::Output out;
    for (int i = 0; i < 2500; ++i) {
      out = contact.tick(scene, in);
      force.push_back(out.force.norm());
      ASSERT_GE(out.force.z(), -1e-9);
    }
    double steepest = 0;
    for (size_t i = 10; i < force.size(); ++i) steepest = std::max(steepest, std::abs(force[i] - force[i - 10]));
    std::printf(
        "clay %.0f voxels above the centre: steepest change %.2f %% of peak per 10 ms, proxy ends at %.3f voxels\n",
        depth, 100 * steepest / peak, out.proxy.z() / kVoxel);
    EXPECT_LE(steepest, 0.07 * peak);
    EXPECT_NEAR(out.proxy.z() / kVoxel, depth + r, 0.06) << depth;
  }
}

TEST(BallContact, ClayThatClosesInFromAllSidesHoldsIt) {
  // A hollow smaller than the ball: nowhere to go; it must come to rest without shaking.
  const clay::Version none = makeClay(planeField({0, 0, 1}, -30), 4, kVoxel);
  const clay::Version hollow =
      makeClay([](const Vec3d& p) { return 4.0 - (p - Vec3d(0.3, 0.1, 0)).norm(); }, 4, kVoxel);
  BallContact contact;
  BallContact::Input in = inputAt({0.1, 0.2, 0});
  in.topStiffnessNmm = 1.26;
  in.peakForceN = 3.3;
  for (int i = 0; i < 10; ++i) (void)contact.tick(makeScene(none, 6 * kVoxel), in);
  double shake = 0;
  Vec3d before = Vec3d::Zero();
  for (int i = 0; i < 500; ++i) {
    const auto out = contact.tick(makeScene(hollow, 6 * kVoxel), in);
    if (i > 200) shake = std::max(shake, (out.force - before).norm());
    before = out.force;
  }
  EXPECT_LT(shake, 0.01 * 3.3);
}

TEST(BallContact, LayingAndSmoothingSayWhereTheyWork) {
  const clay::Version version = makeClay(planeField({0, 0, 1}, 0), 4, kVoxel);
  Scene scene = makeScene(version, 3);
  BallContact contact;
  BallContact::Input in = inputAt({0, 0, 5});
  (void)contact.tick(scene, in);
  // Smoothing: held at the surface, the ball of the operation sinks with the pressure.
  scene.tool.work = haptics::Work::rub;
  in.operate = true;
  in.hand = {0, 0, 2};
  BallContact::Output out;
  for (int i = 0; i < 5; ++i) out = contact.tick(scene, in);
  EXPECT_NEAR(out.proxy.z(), 3, 0.02);
  EXPECT_NEAR(out.cutPoint.z(), 2, 1e-9);
  EXPECT_TRUE(out.flags & kCutting);
  in.hand = {0, 0, -20};
  in.peakForceN = 3;
  for (int i = 0; i < 5; ++i) out = contact.tick(scene, in);
  EXPECT_NEAR(out.cutPoint.z(), 0, 0.03) << "no deeper than the centre on the surface";
  EXPECT_NEAR(out.force.norm(), 3, 1e-9);
  EXPECT_TRUE(out.flags & kClamped);
  // Laying clay: the ball is where the hand is, with drag alone.
  scene.tool.work = haptics::Work::lay;
  in.hand = {1, 2, -1};
  in.velocity = {50, 0, 0};
  out = contact.tick(scene, in);
  EXPECT_EQ(out.cutPoint, in.hand);
  EXPECT_LT(out.force.x(), 0);
  EXPECT_LT(out.force.norm(), 0.2);
}

TEST(BallContact, TouchesSeveralPiecesEachAtItsPlaceAndVoxelSize) {
  // Two halves of a corner: a floor of 0.5 mm voxels, a wall of 0.2 mm voxels turned by 30° about z and moved.
  const clay::Version floor = makeClay(planeField({0, 0, 1}, 0), 5, 0.5);
  const clay::Version wall = makeClay(planeField({1, 0, 0}, 0), 9, 0.2);
  Scene scene = makeScene(floor, 2);
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(0.5235987755982988, Vec3d::UnitZ());
  pose.translation = {-4, 1, 0};
  scene.pieces.push_back({wall, pose, 0});
  scene.check();
  const Vec3d normal = pose.rotation * Vec3d::UnitX();
  BallContact contact;
  BallContact::Output out;
  for (int i = 0; i < 400; ++i) out = contact.tick(scene, inputAt(Vec3d(0, 0, 5) + i * 0.025 * Vec3d(-0.8, 0, -0.8)));
  EXPECT_GE(out.planes, 2);
  EXPECT_NEAR(out.proxy.z(), 2, 0.02);
  EXPECT_NEAR((out.proxy - pose.translation).dot(normal), 2, 0.02);
}

TEST(BallContact, CostOfATick) {
  // Figures for haptics/contact/NOTES.md; the assertion only catches a blunder.
  const clay::Version version = makeClay(sphereField({0.3, 0.2, -60.4}, 61.3), 9, kVoxel);
  for (double r : {0.5, 1.0, 3.0, 6.0, 12.0, 24.0}) {
    BallContact contact;
    const Scene scene = makeScene(version, r * kVoxel);
    std::vector<double> us;
    for (int i = 0; i < 3000; ++i) {
      const double a = i * 2e-3;
      const Vec3d hand = kVoxel * Vec3d(20 * std::sin(a), 20 * std::sin(1.7 * a), r - 6 + 2 * std::cos(3 * a));
      const auto begin = std::chrono::steady_clock::now();
      (void)contact.tick(scene, inputAt(hand));
      us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
    std::sort(us.begin(), us.end());
    std::printf("touch, r %4.1f voxels: median %.2f us, p99 %.2f us, p99.9 %.2f us\n", r, us[us.size() / 2],
                us[us.size() * 99 / 100], us[us.size() * 999 / 1000]);
    EXPECT_LT(us[us.size() / 2], 1000);
  }
}

}  // namespace
}  // namespace argil::haptics
