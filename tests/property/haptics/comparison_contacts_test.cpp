// The contacts kept for comparison do what their methods do: no better, no worse.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "clay_fields.h"
#include "haptics/contact/contact.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr uint32_t kSeed = 5;
constexpr double kVoxel = 0.5;  // mm

Scene makeScene(const Field& field, double radiusMm = 0.5) {
  Scene scene;
  scene.pieces.push_back({makeClay(field, 5, kVoxel), Pose(), 0});
  scene.tool.radiusMm = radiusMm;
  scene.check();
  return scene;
}

Contact::Input at(const Vec3d& hand) {
  Contact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = 1;
  in.peakForceN = 1e3;
  return in;
}

Field wallField(double thickness) {
  return [=](const Vec3d& p) { return std::abs(p.z()) - thickness / 2; };
}
// Full inside and full outside, nothing in between: a volume that was cut out by a threshold. Within the band, or it
// were tiles.
Field stepField(const Field& field) {
  return [=](const Vec3d& p) { return field(p) < 0 ? -2.9 : 2.9; };
}

TEST(ComparisonContacts, AreMadeByName) {
  for (const char* name : {"proxy", "god-object", "penalty"}) {
    EXPECT_NE(makeContact(name), nullptr);
    EXPECT_EQ(std::count(contactNames().begin(), contactNames().end(), name), 1) << name;
  }
  EXPECT_THROW((void)makeContact("penality"), Error);
}

TEST(ComparisonContacts, PushOutOfAPlaneAlike) {
  const Vec3d normal = Vec3d(0.2, -0.1, 1).normalized();
  const Scene scene = makeScene(planeField(normal, 0.3));
  for (const char* name : {"god-object", "penalty"}) {
    const bool ball = std::string_view(name) == "penalty";
    const auto contact = makeContact(name);
    for (int i = 0; i <= 200; ++i) {
      const double height = (ball ? 0.5 : 0.0) + 1 - i * 0.01;  // From 1 mm above its touching to 1 mm deep.
      const Vec3d hand = normal * (0.3 * kVoxel + height) + Vec3d(1, 0.2 * i * 0.01, 0).cross(normal);
      const auto out = contact->tick(scene, at(hand));
      const double depth = i * 0.01 - 1;
      if (depth < -0.02) {
        EXPECT_EQ(out.force, Vec3d::Zero()) << name << depth;
      }
      if (depth < 0.05) continue;
      EXPECT_NEAR(out.force.norm(), depth, 0.01) << name;
      EXPECT_GT(out.force.normalized().dot(normal), 0.99999) << name;
      EXPECT_NEAR(out.depthMm, depth, 0.01) << name;
      EXPECT_EQ(out.planes, 1) << name;
      EXPECT_TRUE(out.flags & kTouching) << name;
    }
  }
}

// Pressed into a wall thinner than twice the depth, penalty pushes out of the other side.
TEST(ComparisonContacts, PenaltyPopsThroughAThinWallAndTheGodObjectDoesNot) {
  const Scene scene = makeScene(wallField(2));  // 1 mm
  for (const char* name : {"god-object", "penalty"}) {
    const auto contact = makeContact(name);
    double back = 0;  // The strongest push to the far side.
    for (int i = 0; i <= 500; ++i) {
      const auto out = contact->tick(scene, at({0.1, 0.2, 2 - i * 0.01}));
      back = std::max(back, -out.force.z());
    }
    if (std::string_view(name) == "penalty")
      EXPECT_GT(back, 0.5);
    else
      EXPECT_EQ(back, 0.0);
  }
}

// The slope of the field is a factor of the stiffness: what the method cannot know is that it is no distance.
TEST(ComparisonContacts, AFieldThatJumpsMultipliesThePenaltysStiffness) {
  const Scene scene = makeScene(stepField(planeField(Vec3d::UnitZ(), 0.25)), 0.25);
  double stiffest[2] = {0, 0};
  int n = 0;
  for (const char* name : {"god-object", "penalty"}) {
    const auto contact = makeContact(name);
    double before = 0;
    for (int i = 0; i <= 200; ++i) {
      const double force = contact->tick(scene, at({0.1, 0.2, 1 - i * 0.01})).force.norm();
      stiffest[n] = std::max(stiffest[n], (force - before) / 0.01);
      before = force;
    }
    ++n;
  }
  std::printf("stiffness felt on a step, of 1 N/mm: god-object %.2f, penalty %.2f N/mm\n", stiffest[0], stiffest[1]);
  EXPECT_LT(stiffest[0], 1.5);
  EXPECT_GT(stiffest[1], 4);
}

TEST(GodObject, StaysOnTheSurfaceAndNeverGoesAwayFromTheHand) {
  const struct {
    const char* name;
    Field field;
    double below;  // mm
  } cases[] = {{"sphere", sphereField({0.3, 0.2, -20.4}, 21.3), 1},
               {"groove", grooveField(8.6), 5.5},
               {"noise", noiseField(kSeed, 1.0, 6.0), 1}};
  for (const auto& c : cases) {
    const Scene scene = makeScene(c.field);
    clay::Sampler field(scene.pieces[0].version);
    const auto contact = makeContact("god-object");
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> spread(-1, 1);
    Vec3d hand(0, 0, 3), speed = Vec3d::Zero(), place = hand;
    int touching = 0;
    double grew = 0, off = 0;
    for (int i = 0; i < 4000; ++i) {
      // A walk that pulls to a place below the surface.
      speed += 0.02 * Vec3d(spread(random), spread(random), spread(random)) + 0.002 * (Vec3d(0, 0, -c.below) - hand) -
               0.05 * speed;
      hand += speed;
      const double before = (place - hand).norm();
      const auto out = contact->tick(scene, at(hand));
      if (i) grew = std::max(grew, (out.proxy - hand).norm() - before);
      place = out.proxy;
      if (!(out.flags & kTouching) || (out.flags & kIncomplete)) continue;
      ++touching;
      off = std::max(off, std::abs(double(field.trilinear(place / kVoxel))));
    }
    std::printf(
        "%s: %d of 4000 ticks touching, at most %.3f voxels off the surface, %.4f voxels away from the hand in a "
        "tick\n",
        c.name, touching, off, grew / kVoxel);
    EXPECT_GT(touching, 1000) << c.name;
    EXPECT_LT(off, 0.05) << c.name;
    EXPECT_LT(grew / kVoxel, 0.03) << c.name;
  }
}

// Pressed into the corner of three walls it rests there, held by several planes, wherever the hand is beyond it.
TEST(GodObject, RestsInACorner) {
  const Scene scene = makeScene([](const Vec3d& p) { return std::min({p.x() - 0.3, p.y() + 0.2, p.z() - 0.4}); });
  const auto contact = makeContact("god-object");
  Contact::Output out;
  for (int i = 0; i <= 400; ++i) out = contact->tick(scene, at(Vec3d(3, 2.5, 2) - Vec3d(0.01, 0.011, 0.009) * i));
  EXPECT_LT((out.proxy - Vec3d(0.15, -0.1, 0.2)).norm(), kVoxel);  // The corner is as round as a voxel.
  EXPECT_GE(out.planes, 2);
}

}  // namespace
}  // namespace argil::haptics
