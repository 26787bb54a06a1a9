// Masked clay of a piece that hides it: not there for the hand, and what is left feels as it did.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/threads/sample_ring.h"
#include "tests/unit/haptics/painted_clay.h"

namespace argil::haptics {
namespace {

constexpr double kRadius = 3;

clay::Version block(double topMm = 0) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeBlock(clay::Store::make(), grid, {0, 0, (topMm - 20) / 2}, {60, 40, 20 + topMm}, 0);
}

clay::Version masked(const clay::Version& version, uint8_t from = 255) {
  return testing::painted(version, clay::Channel::mask, [from](Coord v) { return v.x >= 0 ? from : uint8_t{100}; });
}

Scene sceneOf(const clay::Version& version, bool hide) {
  Scene scene;
  scene.pieces.push_back({version, Pose(), 0, hide});
  scene.tool.radiusMm = kRadius;
  scene.check();
  return scene;
}

/// A hand that goes straight from place to place, 20 mm/s.
struct Hand {
  std::unique_ptr<BallContact> contact = std::make_unique<BallContact>();
  Vec3d at;
  Contact::Output out;
  uint32_t flags = 0;

  explicit Hand(const Vec3d& from) : at(from) {}
  Contact::Output& to(const Vec3d& place, const Scene& scene) {
    const Vec3d from = at;
    const int steps = std::max(1, static_cast<int>((place - from).norm() / 0.02));
    flags = 0;
    for (int i = 1; i <= steps; ++i) {
      at = from + (place - from) * (double(i) / steps);
      Contact::Input in;
      in.hand = at;
      in.peakForceN = 1e3;
      out = contact->tick(scene, in);
      flags |= out.flags;
    }
    return out;
  }
};

TEST(HiddenClay, IsNotFeltAndTheRestIsAsItWas) {
  const clay::Version clay = masked(block());
  const Scene hiding = sceneOf(clay, true), whole = sceneOf(clay, false);
  for (const uint32_t seed : {1u, 2u, 3u, 4u, 5u}) {
    std::printf("seed %u\n", seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    const double x = 14 + 8 * any(random), y = 10 * any(random), depth = 2 + any(random);
    Hand through({x, y, 6}), there({-x, y, 6}), before({-x, y, 6});
    through.to({x, y, kRadius - depth}, hiding);
    EXPECT_FALSE(through.flags & kTouching);
    EXPECT_EQ(through.out.proxy, through.at);
    // All through, out at the other side.
    through.to({x, y, -30}, hiding);
    EXPECT_FALSE(through.flags & kTouching);
    EXPECT_EQ(through.out.force, Vec3d::Zero());
    EXPECT_EQ(there.to({-x, y, kRadius - depth}, hiding).force, before.to({-x, y, kRadius - depth}, whole).force);
    EXPECT_NEAR(there.out.force.z(), depth, 0.02);
    // Shown again it holds the ball as before.
    Hand again({x, y, 6});
    EXPECT_NEAR(again.to({x, y, kRadius - depth}, whole).force.z(), depth, 0.02);
  }
}

TEST(HiddenClay, OfHalfAMaskOrLessIsFelt) {
  Hand hand({15, 0.3, 6});
  EXPECT_NEAR(hand.to({15, 0.3, kRadius - 1}, sceneOf(masked(block(), 127), true)).force.z(), 1, 0.02);
  Hand through({15, 0.3, 6});
  EXPECT_EQ(through.to({15, 0.3, kRadius - 1}, sceneOf(masked(block(), 128), true)).force, Vec3d::Zero());
}

TEST(HiddenClay, LetsTheHandInWhereItFeelsTheRestFromBehind) {
  const Scene scene = sceneOf(masked(block()), true);
  Hand hand({12, 0.3, 6});
  hand.to({12, 0.3, -10}, scene);
  EXPECT_FALSE(hand.flags & kTouching);
  hand.to({-28, 0.3, -10}, scene);
  EXPECT_FALSE(hand.flags & kLeaving);
  EXPECT_NEAR(hand.out.proxy.x(), -30 + kRadius, 0.05);
  EXPECT_NEAR(hand.out.force.x(), 1, 0.05);
  hand.to({12, 0.3, -10}, scene);
  hand.to({40, 0.3, -10}, scene);
  EXPECT_EQ(hand.out.force, Vec3d::Zero());
  // From outside the rest is solid again.
  hand.to({40, 0.3, 10}, scene);
  hand.to({-12, 0.3, 10}, scene);
  hand.to({-12, 0.3, kRadius - 1}, scene);
  EXPECT_NEAR(hand.out.force.z(), 1, 0.05);
}

TEST(HiddenClay, GrowsAroundTheBallAsSolidClay) {
  Hand hand({-12, 0.3, 6});
  hand.to({-12, 0.3, 4}, sceneOf(masked(block()), true));
  EXPECT_EQ(hand.flags & kTouching, 0u);
  const Scene grown = sceneOf(masked(block(6)), true);
  for (int i = 0; i < 1500; ++i) hand.to({-12, 0.3, 4}, grown);
  EXPECT_TRUE(hand.flags & kTouching);
  EXPECT_NEAR(hand.out.proxy.z(), 6 + kRadius, 0.05);
}

// At the rim some crossings are hidden and some are not: no jump, nothing that is not finite.
TEST(HiddenClay, EndsWithoutAJump) {
  const Scene scene = sceneOf(masked(block()), true);
  Hand hand({-10, 0.3, 6});
  hand.to({-10, 0.3, kRadius - 1}, scene);
  Vec3d before = hand.out.force;
  double jump = 0;
  for (double x = -10; x < 10; x += 0.02) {
    hand.to({x, 0.3, kRadius - 1}, scene);
    ASSERT_TRUE(hand.out.force.allFinite());
    jump = std::max(jump, (hand.out.force - before).norm());
    before = hand.out.force;
  }
  std::printf("largest step of the force across the rim: %.4f N\n", jump);
  EXPECT_LE(jump, 0.066);
  EXPECT_EQ(before, Vec3d::Zero());
}

}  // namespace
}  // namespace argil::haptics
