// What a hand would notice: lost contact, lag, force that jumps, friction that is not what it says, a ball that creeps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay_fields.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/devices/hand_path.h"
#include "haptics/devices/simulated.h"
#include "haptics/threads/sample_ring.h"
#include "tests/support/tier.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr uint32_t kSeed = 23;
constexpr double kPi = 3.14159265358979323846;

Scene sceneOf(const clay::Version& version, double radiusMm) {
  Scene scene;
  scene.pieces.push_back({version, Pose(), 0});
  scene.tool.radiusMm = radiusMm;
  return scene;
}

Contact::Input inputAt(const Vec3d& hand) {
  Contact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = 1;
  in.peakForceN = 1e3;
  return in;
}

// The ball at the hand is in the clay by so much, voxels; negative when it is not.
double overlap(ClosestSurface& surface, const clay::Version& version, const Vec3d& hand, double radiusMm) {
  surface.reset(version);
  const clay::Grid& grid = version.grid();
  const Vec3d at = grid.toVoxel(hand);
  const double r = radiusMm / grid.voxelMm;
  const SurfacePoint near = surface.nearest(at, r + 1);
  if (surface.inside(at)) return r + (near.found ? near.distance : r);
  return near.found ? r - near.distance : -1;
}

// Clay grows, shrinks, is smoothed and undone under a tool that stays pressed in: not a tick without contact.
TEST(Touch, IsNeverLostWhileTheClayChanges) {
  constexpr int kEvery = 20;
  const uint64_t count = tests::byTier<uint64_t>(50'000, 1'000'000);
  clay::Grid grid;
  grid.voxelMm = 0.5;
  auto store = clay::Store::make();
  const clay::Version first = clay::makeBlock(store, grid, {0, 0, -10}, {40, 40, 20}, 1);
  clay::Version version = first;
  std::vector<clay::Version> past{first};
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  auto contact = std::make_unique<BallContact>();
  ClosestSurface truth;
  Scene scene = sceneOf(version, 3);
  uint64_t pressed = 0, lost = 0, edits = 0, undone = 0;
  double steepest = 0, before = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const double t = double(i) * 1e-3;
    // To and fro over the top, 1 to 2 mm deep in it as it was at first.
    const Vec3d hand(8 * std::sin(0.7 * t), 8 * std::sin(0.43 * t + 1), 3 - 1.5 + 0.5 * std::sin(3 * t));
    if (i % kEvery == 0) {
      const double what = unit(random);
      if (what > 0.6 && past.size() > 1) {
        past.pop_back();
        version = past.back();
        ++undone;
      } else {
        clay::BrushStroke stroke(version, clay::Brush::of(what > 0.1    ? clay::Method::add
                                                          : what > -0.5 ? clay::Method::carve
                                                                        : clay::Method::smooth));
        clay::Stamp stamp;
        stamp.strength = 0.5f;
        stamp.radius = 3 + 3 * std::abs(unit(random));
        stamp.a = grid.toVoxel(hand + 3 * Vec3d(unit(random), unit(random), unit(random)));
        stamp.b = stamp.a + 2 * Vec3d(unit(random), unit(random), unit(random));
        stroke.apply(stamp);
        version = (edits & 1) ? stroke.finish() : stroke.publish();  // In mid-stroke too.
        past.push_back(version);
        if (past.size() > 40) past.erase(past.begin());
        ++edits;
      }
      scene.pieces[0].version = version;
      store->collect();
    }
    const auto out = contact->tick(scene, inputAt(hand));
    if (overlap(truth, version, hand, 3) > 0.1) {
      ++pressed;
      lost += !(out.flags & kTouching);
    }
    if (i) steepest = std::max(steepest, out.force.norm() - before);
    before = out.force.norm();
    ASSERT_TRUE(out.force.allFinite());
  }
  std::printf(
      "seed %u: %llu ticks, %llu pressed, %llu edits, %llu undone: %llu lost; force rises by %.3f N a tick at most\n",
      kSeed, static_cast<unsigned long long>(count), static_cast<unsigned long long>(pressed),
      static_cast<unsigned long long>(edits), static_cast<unsigned long long>(undone),
      static_cast<unsigned long long>(lost), steepest);
  EXPECT_GT(pressed, count / 2);
  EXPECT_GT(undone, 100u);
  EXPECT_EQ(lost, 0u);
}

// A hand that jumps half a millimetre a tick in any direction.
TEST(Touch, IsNeverLostInARandomWalk) {
  const uint64_t count = tests::byTier<uint64_t>(50'000, 1'000'000);
  const clay::Version version = makeClay(noiseField(kSeed, 2, 9), 6, 0.5);
  auto contact = std::make_unique<BallContact>();
  ClosestSurface truth;
  const Scene scene = sceneOf(version, 3);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> kick(0, 1);
  Vec3d hand(0, 0, 5);
  uint64_t pressed = 0, lost = 0, through = 0;
  for (uint64_t i = 0; i < count; ++i) {
    hand += 0.5 * Vec3d(kick(random), kick(random), kick(random)).normalized();
    hand = hand.cwiseMax(Vec3d(-12, -12, -2)).cwiseMin(Vec3d(12, 12, 5));
    const auto out = contact->tick(scene, inputAt(hand));
    if (overlap(truth, version, hand, 3) > 0.1) {
      ++pressed;
      lost += !(out.flags & kTouching);
    }
    through += overlap(truth, version, out.proxy, 3) > 0.1;
  }
  std::printf("seed %u: %llu ticks, %llu pressed, %llu lost, %llu through\n", kSeed,
              static_cast<unsigned long long>(count), static_cast<unsigned long long>(pressed),
              static_cast<unsigned long long>(lost), static_cast<unsigned long long>(through));
  EXPECT_GT(pressed, count / 4);
  EXPECT_EQ(lost, 0u);
  EXPECT_EQ(through, 0u);
}

// Clay in the middle of a stroke: the distances around the cut are only bounds, and not redistanced yet.
TEST(Touch, RestsAtItsRadiusInMidStroke) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  for (double r : {0.5, 1.0, 3.0, 6.0, 12.0, 24.0}) {
    auto store = clay::Store::make();
    clay::BrushStroke stroke(clay::makeBlock(store, grid, {0, 0, -15}, {70, 70, 30}, 0.5),
                             clay::Brush::of(clay::Method::carve));
    auto contact = std::make_unique<BallContact>();
    double worst = 0;
    uint64_t touching = 0;
    Vec3d last = grid.toVoxel({-8, 0.3, 1});
    for (int i = 0; i < 240; ++i) {
      const double s = i / 240.0;
      if (i % 12 == 0) {
        clay::Stamp stamp;
        stamp.a = last;
        stamp.b = last = grid.toVoxel(Vec3d(-8 + 16 * s, 0.3 + 3 * std::sin(5 * s), 1));
        stamp.radius = 7;
        stroke.apply(stamp);
      }
      const clay::Version version = stroke.publish();
      const Scene scene = sceneOf(version, r * grid.voxelMm);
      // Over the groove that is being cut, behind the tool and across its rim.
      const Vec3d hand(-8 + 14 * s, 0.3 + 4 * std::sin(20 * s), r * grid.voxelMm - 2.5);
      const auto out = contact->tick(scene, inputAt(hand));
      touching += (out.flags & kTouching) != 0;
      if (i % 16 != 15 || (out.flags & kLeaving) || !(out.flags & kTouching)) continue;
      const double truth = bruteDistance(version, grid.toVoxel(out.proxy), r + 0.6, r > 10 ? 6 : 10);
      worst = std::max(worst, std::abs(truth - r));
    }
    std::printf("r %4.1f in mid-stroke: worst %.4f voxels, %llu of 240 ticks touching\n", r, worst,
                static_cast<unsigned long long>(touching));
    EXPECT_GT(touching, 150u);
    EXPECT_LE(worst, 0.1) << r;
  }
}

TEST(Touch, DoesNotLagOnAPlaneAt500MmPerS) {
  const clay::Version version = makeClay(planeField({0.3, -0.2, 1}, 1.37), 10, 0.5);
  const Vec3d n = Vec3d(0.3, -0.2, 1).normalized(), along = n.unitOrthogonal();
  auto contact = std::make_unique<BallContact>();
  const Scene scene = sceneOf(version, 3);
  double lag = 0, depth = 0;
  for (int i = 0; i < 110; ++i) {
    const double s = -27.5 + 0.5 * i;
    const Vec3d hand = n * (1.37 * 0.5 + 3 - std::min(1.0, i * 0.1)) + along * s;
    const auto out = contact->tick(scene, inputAt(hand));
    if (i < 20) continue;
    const Vec3d offset = out.proxy - hand;
    lag = std::max(lag, (offset - n * n.dot(offset)).norm());
    depth = std::max(depth, std::abs(n.dot(offset) - 1));
  }
  std::printf("plane at 500 mm/s: lag %.5f mm, depth errs by %.5f mm\n", lag, depth);
  EXPECT_LE(lag, 0.01);
  EXPECT_LE(depth, 0.01);
}

struct Glide {
  double jumpRms = 0, jumpMax = 0, directionRms = 0, turnRms = 0, ratio = 0, ratioError = 0;
};
// 80 mm/s over a sphere of 40 mm, 1 mm deep, the hand exactly on its path.
Glide glide(double voxelMm, double toolMm, double friction) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  const Vec3d centre(0.013, 0.02, -0.03);
  Scene scene = sceneOf(clay::makeSphere(clay::Store::make(), grid, centre, 40), toolMm);
  scene.materials[0].staticFriction = scene.materials[0].dynamicFriction = friction;
  auto contact = std::make_unique<BallContact>();
  const Vec3d axis = Vec3d(0.2, 0.3, 1).normalized(), up = axis.unitOrthogonal(), side = axis.cross(up);
  const double turn = 0.08 / (40 + toolMm);
  Glide g;
  Vec3d before = Vec3d::Zero();
  int n = 0;
  for (int i = 0; i < 3500; ++i) {
    const Vec3d direction = up * std::cos(turn * i) + side * std::sin(turn * i);
    const auto out = contact->tick(scene, inputAt(centre + direction * (40 + toolMm - std::min(1.0, i * 0.01))));
    if (i < 500) continue;
    const double f = out.force.norm();
    if (n++) {
      const double jump = std::abs(f - before.norm()) / f;
      g.jumpRms += jump * jump;
      g.jumpMax = std::max(g.jumpMax, jump);
      const double turned = std::acos(std::min(1.0, before.dot(out.force) / (f * before.norm())));
      g.turnRms += (turned - turn) * (turned - turn);
    }
    const double off = std::acos(std::min(1.0, out.force.dot(direction) / f));
    g.directionRms += off * off;
    const Vec3d normal = (out.proxy - centre).normalized();
    const double push = out.force.dot(normal), pull = (out.force - push * normal).norm();
    g.ratio += pull / push;
    g.ratioError += (pull / push - friction) * (pull / push - friction);
    before = out.force;
  }
  g.jumpRms = std::sqrt(g.jumpRms / n);
  g.directionRms = std::sqrt(g.directionRms / n) * 180 / kPi;
  g.turnRms = std::sqrt(g.turnRms / n) * 180 / kPi;
  g.ratio /= n;
  g.ratioError = std::sqrt(g.ratioError / n);
  return g;
}

TEST(Touch, IsSmoothOnASphere) {
  for (double voxel : {0.25, 0.5})
    for (double tool : {1.0, 3.0}) {
      const Glide g = glide(voxel, tool, 0);
      std::printf(
          "voxel %.2f tool %.0f mm: jump %.4f %% RMS, %.4f %% max; direction %.4f deg RMS, turns %.4f deg RMS unlike "
          "the path\n",
          voxel, tool, 100 * g.jumpRms, 100 * g.jumpMax, g.directionRms, g.turnRms);
      EXPECT_LE(g.jumpRms, 0.003);
      EXPECT_LE(g.jumpMax, 0.01);
      EXPECT_LE(g.directionRms, 0.1);
      EXPECT_LE(g.turnRms, 0.1);
    }
}

TEST(Friction, IsWhatTheMaterialSays) {
  for (double mu : {0.05, 0.1, 0.3, 0.6, 1.0}) {
    const Glide g = glide(0.25, 3, mu);
    std::printf("mu %.2f on a sphere: %.5f, RMS error %.2f %%\n", mu, g.ratio, 100 * g.ratioError / mu);
    EXPECT_NEAR(g.ratio, mu, 0.02 * mu);
    EXPECT_LE(g.ratioError, 0.02 * mu);
  }
}

// Pulled sideways little by little: it stays up to μ_s, then slides and is felt as μ_d.
TEST(Friction, BreaksAwayAtTheStaticCoefficient) {
  const clay::Version version = makeClay(planeField({0, 0, 1}, 0.37), 5, 0.5);
  Scene scene = sceneOf(version, 3);
  scene.materials[0].staticFriction = 0.5;
  scene.materials[0].dynamicFriction = 0.3;
  auto contact = std::make_unique<BallContact>();
  double most = 0, sliding = 0;
  Vec3d stuck = Vec3d::Zero();
  for (int i = 0; i < 3000; ++i) {
    const double x = i < 200 ? 0 : (i - 200) * 0.001;
    const auto out = contact->tick(scene, inputAt({x, 0, 0.37 * 0.5 + 3 - std::min(1.0, i * 0.02)}));
    if (i == 199) stuck = out.proxy;
    if (i < 200) continue;
    const double ratio = std::abs(out.force.x()) / out.force.z();
    most = std::max(most, ratio);
    if (x < 0.49) {
      EXPECT_EQ(out.proxy, stuck) << i;
    }
    if (i > 2000) sliding = std::max(sliding, std::abs(ratio - 0.3));
  }
  EXPECT_NEAR(most, 0.5, 0.01);
  EXPECT_LE(sliding, 0.006);
}

TEST(Friction, AViscousSurfaceHoldsByItsSpeed) {
  const clay::Version version = makeClay(planeField({0, 0, 1}, 0.37), 8, 0.5);
  Scene scene = sceneOf(version, 3);
  scene.materials[0].viscousFrictionNsmm = 0.01;
  auto contact = std::make_unique<BallContact>();
  double pull = 0;
  for (int i = 0; i < 900; ++i) {
    const auto out = contact->tick(scene, inputAt({-20 + 0.04 * i, 0, 0.37 * 0.5 + 3 - std::min(1.0, i * 0.02)}));
    pull = -out.force.x();
  }
  EXPECT_NEAR(pull, 0.01 * 40, 0.02 * 0.4);  // b · 40 mm/s
}

// A minute at rest on a slope and in a groove, held by friction, the hand trembling by an encoder step.
TEST(Friction, AStuckBallDoesNotCreep) {
  struct Place {
    const char* name;
    Field field;
    Vec3d hand;
  };
  const Place places[] = {{"slope", planeField({0.3, -0.2, 1}, 1.37), {0, 0, 2.8}},
                          {"sphere", sphereField({0.3, 0.2, -30.4}, 31.3), {1, 0.5, 2.5}},
                          {"rim", rimField(14.2, 6.3), {5.5, 0.4, 2.0}},
                          {"noise", noiseField(kSeed, 1.5, 5.0), {0.2, 0.1, 2.6}}};
  for (const Place& place : places) {
    Scene scene = sceneOf(makeClay(place.field, 6, 0.5), 3);
    scene.materials[0].staticFriction = scene.materials[0].dynamicFriction = 0.8;
    auto contact = std::make_unique<BallContact>();
    std::mt19937 random(kSeed);
    Vec3d start = Vec3d::Zero();
    double drift = 0;
    for (int i = 0; i < 62'000; ++i) {
      const auto step = [&random] { return 0.03 * (double(random() % 3) - 1); };
      Vec3d hand = place.hand + (i < 1000 ? Vec3d(0, 0, 4 * (1 - i / 1000.0)) : Vec3d(step(), step(), step()));
      const auto out = contact->tick(scene, inputAt(hand));
      ASSERT_TRUE(i < 1000 || (out.flags & kTouching)) << place.name;
      if (i == 2000) start = out.proxy;
      if (i > 2000) drift = std::max(drift, (out.proxy - start).norm());
    }
    std::printf("%s: %.3f um in a minute\n", place.name, 1000 * drift);
    EXPECT_LE(drift, 1e-3) << place.name;
  }
}

}  // namespace
}  // namespace argil::haptics
