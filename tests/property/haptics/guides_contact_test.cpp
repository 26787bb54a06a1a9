// Guides and clay in one: what is felt when eight of them work while the ball is pressed onto clay.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "clay_fields.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr double kVoxel = 0.5, kRadius = 3, kPeakN = 3.3, kPeriodS = 1e-3;

/// A hand on a smooth path, to and fro over the clay and up and down: 20 mm/s at most, 1 mm too deep and more.
Vec3d handAt(double s) {
  return {9 * std::sin(1.1 * s), 5 * std::sin(0.83 * s), kRadius - 0.4 + 1.6 * std::cos(0.9 * s)};
}

BallContact::Input inputAt(int tick) {
  BallContact::Input in;
  in.hand = handAt(tick * kPeriodS);
  in.velocity = (handAt((tick + 0.5) * kPeriodS) - handAt((tick - 0.5) * kPeriodS)) / kPeriodS;
  in.topStiffnessNmm = 1;
  in.topDampingNsmm = 0.002;
  in.dampingNsmm = 0.001;
  in.peakForceN = kPeakN;
  return in;
}

Scene bareScene(const clay::Version& version) {
  Scene scene;
  scene.pieces.push_back({version, Pose(), 0});
  scene.materials[0].staticFriction = 0.2;  // No more than sliding: what slips jumps by itself.
  scene.materials[0].dynamicFriction = 0.2;
  scene.tool.radiusMm = kRadius;
  return scene;
}

std::shared_ptr<const Polyline> wire() {
  std::vector<Vec3d> points;
  for (int i = 0; i <= 300; ++i) points.push_back({i * 0.1 - 15, 3 * std::sin(i * 0.03), 2.5 + std::sin(i * 0.02)});
  return std::make_shared<Polyline>(points);
}

const Vec3d kLockNormal = Vec3d(0.2, 1, 0.1).normalized();
const Vec3d kLockPoint(0, 0.5, kRadius);

Scene eightGuides(const clay::Version& version) {
  Scene scene = bareScene(version);
  Pose box;
  box.translation = {8, 0, 2};
  scene.guides = {{1, LockToPlane{kLockPoint, kLockNormal}, 1},
                  {2, KeepOutBox{box, {2, 8, 4}, false}, 0},
                  {3, KeepOutBall{{0, 0, 0}, 16, true}, 0},
                  {4, WellAtPoints{{{-4, 1, 4}, {3, -2, 4}}, {8, 0.5}}, 0},
                  {5, WellAtCurve{wire(), {6, 0.4}}, 2},
                  {6, Gravity{{0, 0, -0.3}}, 0},
                  {7, Viscosity{0.001}, 0},
                  {8, AmbientPlane{{0, 0, 4}, {0, 0, 1}, 0.1, 0.5}, 0}};
  scene.check();
  return scene;
}

clay::Version slopes() {
  return makeClay([](const Vec3d& p) { return p.z() + 2 * std::sin(p.x() * 0.08) + 1.5 * std::cos(p.y() * 0.07); }, 7,
                  kVoxel);
}

TEST(GuidesInContact, ALockHoldsWithinAMicrometreWhileClayPushes) {
  const clay::Version version = slopes();
  const Scene scene = eightGuides(version);
  const auto contact = std::make_unique<BallContact>();
  double off = 0, push = 0;
  int pressed = 0, kept = 0, settledFor = 0;
  for (int tick = 0; tick < 20'000; ++tick) {
    BallContact::Input in = inputAt(tick);
    in.buttons = 1;
    const BallContact::Output out = contact->tick(scene, in);
    if (tick < 3000) continue;  // The lock comes from the side at a bounded speed.
    off = std::max(off, std::abs((out.proxy - kLockPoint).dot(kLockNormal)));
    const bool held = out.flags & kTouching;
    pressed += held && out.planes > 0;
    kept += out.planes > 1;
    if (held) push = std::max(push, out.force.norm());
    ASSERT_LE(off, 1e-3) << "tick " << tick;
    ++settledFor;
  }
  std::printf(
      "%d ticks, clay or keep-outs push in %d, several at once in %d, force up to %.2f N: off the lock by at most %.1e "
      "mm\n",
      settledFor, pressed, kept, push, off);
  EXPECT_LE(off, 1e-9);
  EXPECT_GT(pressed, 3000);
  EXPECT_GT(push, 0.5);
}

TEST(GuidesInContact, EightOfThemNeverJump) {
  const clay::Version version = slopes();
  const Scene scene = eightGuides(version);
  const auto contact = std::make_unique<BallContact>();
  double worst = 0;
  int touching = 0, at = 0;
  Vec3d before = Vec3d::Zero();
  for (int tick = 0; tick < 40'000; ++tick) {
    BallContact::Input in = inputAt(tick);
    // Lock and wire come and go, while clay is touched and while not.
    in.buttons = static_cast<uint32_t>(tick / 1700 % 4);
    const BallContact::Output out = contact->tick(scene, in);
    touching += (out.flags & kTouching) != 0;
    if (tick > 0) {
      const double jump = (out.force - before).norm() / kPeakN;
      if (jump > worst) worst = jump, at = tick;
    }
    before = out.force;
  }
  std::printf(
      "40000 ticks, %d touching: the force changes by at most %.2f %% of the peak from tick to tick (tick %d)\n",
      touching, 100 * worst, at);
  EXPECT_LE(worst, 0.02);
  EXPECT_GT(touching, 10'000);
}

TEST(GuidesInContact, LocksComeBeforeKeepOutsAndTheseBeforeClay) {
  const clay::Version version = makeClay(planeField({0, 0, 1}, 0), 6, kVoxel);
  const auto contact = std::make_unique<BallContact>();
  BallContact::Input in;
  in.topStiffnessNmm = 1;
  in.peakForceN = kPeakN;
  BallContact::Output out;
  // A ball held in by a box that dips into the clay: the box holds it where the clay alone would leave more room.
  Scene scene = bareScene(version);
  Pose pose;
  pose.translation = {0, 0, 6};
  scene.guides = {{1, KeepOutBox{pose, {4, 4, 4}, true}, 0}};
  in.hand = {0, 0, 6};
  for (int tick = 0; tick < 200; ++tick) out = contact->tick(scene, in);
  in.hand = {7, 6, -4};
  for (int tick = 0; tick < 2000; ++tick) out = contact->tick(scene, in);
  EXPECT_NEAR((out.proxy - Vec3d(1, 1, 5)).norm(), 0, 0.05) << out.proxy.transpose();
  EXPECT_EQ(out.planes, 3);
  EXPECT_FALSE(out.flags & kGuideConflict);
  // A lock in the midst of the clay: it holds, and says that the clay could not.
  scene.guides.push_back({2, LockToPlane{{0, 0, 1}, {0, 0, 1}}, 0});
  uint32_t flags = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    out = contact->tick(scene, in);
    flags |= out.flags;
  }
  EXPECT_NEAR(out.proxy.z(), 1, 1e-9);
  EXPECT_TRUE(flags & kGuideConflict);
}

TEST(GuidesInContact, AToolThatCutsStaysOnItsLockAndOutOfWhatIsKept) {
  const clay::Version version = makeClay(planeField({0, 0, 1}, 0), 6, kVoxel);
  Scene scene = bareScene(version);
  scene.tool.work = haptics::Work::cut;
  scene.guides = {{1, LockToPlane{kLockPoint, kLockNormal}, 0}};
  double off = 0, deepest = 0, deepestKept = 0;
  for (const bool kept : {false, true}) {
    if (kept) scene.guides.push_back({2, KeepOutPiece{0}, 0});
    scene.check();
    const auto contact = std::make_unique<BallContact>();
    for (int tick = 0; tick < 4000; ++tick) {
      BallContact::Input in = inputAt(0);
      in.hand = Vec3d(-8 + 0.004 * tick, 0.5, 6 - std::min(0.003 * tick, 4.5));
      in.operate = true;
      in.sampleIndex = static_cast<uint64_t>(tick);
      const BallContact::Output out = contact->tick(scene, in);
      if (tick < 500) continue;
      off = std::max(off, std::abs((out.proxy - kLockPoint).dot(kLockNormal)));
      (kept ? deepestKept : deepest) = std::max(kept ? deepestKept : deepest, kRadius - out.proxy.z());
    }
  }
  std::printf("off the lock by at most %.1e mm while cutting; %.3f mm deep, %.3f in a piece that is kept\n", off,
              deepest, deepestKept);
  EXPECT_LE(off, 1e-3);
  EXPECT_GT(deepest, 0.3);
  EXPECT_LE(deepestKept, 0.05 * kVoxel);
}

TEST(GuidesInContact, AWellAtAPieceDrawsTheBallOntoIt) {
  const clay::Version version = makeClay(sphereField({0, 0, 0}, 20), 6, kVoxel);  // r 10 mm
  Scene scene = bareScene(version);
  scene.guides = {{1, WellAtPiece{0, {6, 1}}, 0}};
  scene.check();
  const auto contact = std::make_unique<BallContact>();
  BallContact::Input in;
  in.topStiffnessNmm = 1;
  in.peakForceN = kPeakN;
  const Vec3d out = Vec3d(1, 2, 3).normalized();
  Vec3d before = Vec3d::Zero();
  double most = 0, jump = 0;
  for (double gap = 8; gap > 0; gap -= 0.005) {
    in.hand = out * (10 + kRadius + gap);
    const Vec3d force = contact->tick(scene, in).force;
    EXPECT_LE(force.cross(out).norm(), 0.02) << "gap " << gap;
    if (gap > 4.3) {
      EXPECT_EQ(force, Vec3d::Zero()) << "gap " << gap;
    }
    most = std::max(most, -force.dot(out));
    jump = std::max(jump, (force - before).norm() / kPeakN);
    before = force;
  }
  EXPECT_GT(most, 0.8);
  EXPECT_LE(jump, 0.02);
  EXPECT_LE(before.norm(), 0.01) << "at the surface contact alone is felt";
}

// Figures to read, not limits: the machine is shared. The same hand in the locked plane and away from keep-outs, so
// that clay is touched alike.
TEST(GuidesInContact, EightOfThemCostLittle) {
  const clay::Version version = slopes();
  Scene with = eightGuides(version), without = bareScene(version);
  with.guides[0].whileButtons = with.guides[4].whileButtons = 0;
  std::get<KeepOutBox>(with.guides[1].shape).pose.translation.x() = 20;
  std::get<KeepOutBall>(with.guides[2].shape).radiusMm = 30;
  const auto inPlane = [](int tick) {
    BallContact::Input in = inputAt(tick);
    in.hand -= kLockNormal * kLockNormal.dot(in.hand - kLockPoint);
    in.velocity -= kLockNormal * kLockNormal.dot(in.velocity);
    return in;
  };
  std::vector<double> cost[2];
  const auto guided = std::make_unique<BallContact>(), bare = std::make_unique<BallContact>();
  uint64_t held = 0;
  double apart = 0;
  for (int tick = 0; tick < 20'000; ++tick) {
    Vec3d proxy[2];
    for (int which = 0; which < 2; ++which) {
      const BallContact::Input in = inPlane(tick);
      const auto begin = std::chrono::steady_clock::now();
      const BallContact::Output out = (which ? *guided : *bare).tick(which ? with : without, in);
      cost[which].push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
      held += which && out.planes > 0;
      proxy[which] = out.proxy;
    }
    apart += (proxy[0] - proxy[1]).norm() / 20'000;
  }
  std::printf("touching in %d of 20000 ticks, proxies %.2f mm apart on average\n", static_cast<int>(held), apart);
  for (auto& c : cost) std::sort(c.begin(), c.end());
  const auto at = [](const std::vector<double>& sorted, double part) {
    return sorted[size_t(part * double(sorted.size() - 1))];
  };
  std::printf("contact without guides: median %.2f, p99 %.2f µs; with eight: median %.2f, p99 %.2f µs\n",
              at(cost[0], 0.5), at(cost[0], 0.99), at(cost[1], 0.5), at(cost[1], 0.99));
  // And the guides alone, without what they make contact do.
  const auto guides = std::make_unique<Guides>();
  std::vector<double> alone;
  Vec3d proxy = handAt(0);
  for (int tick = 0; tick < 20'000; ++tick) {
    const BallContact::Input in = inputAt(tick);
    const auto begin = std::chrono::steady_clock::now();
    guides->begin(with, in, proxy, Vec3d::UnitZ());
    proxy = guides->snap(guides->lockAt(proxy).nearest(guides->goal(in.hand)));
    alone.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::sort(alone.begin(), alone.end());
  std::printf("eight guides alone: median %.2f, p99 %.2f µs\n", at(alone, 0.5), at(alone, 0.99));
  EXPECT_GT(held, 1000u) << "nothing was touched: the figures say nothing";
}

}  // namespace
}  // namespace argil::haptics
