// Smoothing: volume kept when asked, and the same feel at any radius.

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/property/clay/brush_checks.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

using namespace testing;

// Of the closed surface, in voxels³.
double volumeOf(const Version& version) {
  Surface surface(false);
  surface.update(version);
  const TopologyReport report = checkTopology(surface.toMesh());
  EXPECT_TRUE(report.closed());
  return report.volume / std::pow(version.grid().voxelMm, 3);
}

std::shared_ptr<const Brush> smoothing(Method method, Falloff shape = Falloff::smooth) {
  auto brush = std::make_shared<Brush>(*Brush::of(method));
  brush->operations[0].shape = shape;
  return brush;
}

TEST(Smooth, KeepingVolumeOfASphere) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(0.11, 0.07, 0.05), 20);
  const double before = volumeOf(base);
  const auto change = [&](const Version& after) {
    const double share = std::abs(volumeOf(after) / before - 1);
    std::printf("volume changes by %.4f %%\n", 100 * share);
    return share;
  };
  // Along its equator, and over all of it at once; then five times.
  EXPECT_LE(change(apply(base, smoothing(Method::smoothKeep), arc(40, 0, 2 * M_PI, 8))), 1e-4);
  EXPECT_LE(change(apply(base, smoothing(Method::smoothKeep), arc(40, 0, 2 * M_PI, 20))), 1e-4);
  EXPECT_LE(change(apply(base, smoothing(Method::smoothKeep, Falloff::constant), {{{0, 0, 0}, {0, 0, 0}, 60}})), 1e-4);
  EXPECT_LE(change(apply(base, smoothing(Method::smoothKeep), arc(40, 0, 2 * M_PI, 12), 5)), 1e-4);
  // What it is measured against.
  EXPECT_GE(change(apply(base, smoothing(Method::smooth), arc(40, 0, 2 * M_PI, 20))), 1e-3);
}

// What stands up is gone to a like part, whatever the size of the tip and of the bump.
TEST(Smooth, BumpsGoAlikeAtAnyRadius) {
  for (const Method method : {Method::smooth, Method::smoothKeep})
    for (const double radius : {10.0, 20.0, 40.0}) {
      const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -15), {70, 70, 30}, 1);
      // A cap 0.1 radii high and 0.4 wide.
      const double ball = 0.25 * radius;
      const Version bump =
          apply(block, Brush::of(Method::add), {{{0, 0, 0.1 * radius - ball}, {0, 0, 0.1 * radius - ball}, ball}});
      const Version after = apply(bump, smoothing(method), line({-0.8 * radius, 0, 0}, {0.8 * radius, 0, 0}, radius));
      Sampler sampler(after);
      double z = -5;
      while (sampler.trilinear(Vec3d(0, 0, z)) < 0) z += 0.005;
      std::printf("method %d radius %g: %.3f of the bump is left\n", static_cast<int>(method), radius,
                  z / (0.1 * radius));
      EXPECT_LT(z, 0.075 * radius) << radius;
      EXPECT_GT(z, 0) << radius;
      closedSurface(after);
      const FieldErrors errors = fieldErrors(after);
      EXPECT_LE(errors.rms, 0.05) << radius;
      EXPECT_LE(errors.worst, 0.25) << radius;
    }
}

// A ridge 1.6 radii wide and half as high, along which a tip goes once.
TEST(Smooth, AWiderSpreadEvensOutRidgesAsWideAsTheTipInOnePass) {
  for (const double radius : {5.0, 10.0, 16.0, 24.0, 40.0}) {
    const double ridge = 0.8 * radius;
    const Version block =
        makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -1.5 * radius), {5 * radius, 4 * radius, 3 * radius}, 1);
    const Version base = apply(block, Brush::of(Method::add), {{{-2 * radius, 0, 0}, {2 * radius, 0, 0}, ridge}});
    double left[2];
    for (const int wide : {0, 1}) {
      auto brush = std::make_shared<Brush>(*smoothing(Method::smooth));
      brush->spread = wide ? 12 : 1;
      const Version after = apply(base, brush, line({-2 * radius, 0, ridge}, {2 * radius, 0, ridge}, radius, 0.5f));
      Sampler sampler(after);
      double z = 0;
      while (sampler.trilinear(Vec3d(0.2, 0, z)) < 0) z += 0.01;
      left[wide] = z / ridge;
      closedSurface(after);
      const FieldErrors errors = fieldErrors(after);
      EXPECT_LE(errors.rms, 0.05) << radius;
      EXPECT_LE(errors.worst, 0.3) << radius;
    }
    std::printf("radius %g: %.3f of the ridge is left, %.3f with the usual spread\n", radius, left[1], left[0]);
    EXPECT_LT(left[1], 0.93) << radius;
    EXPECT_GT(left[1], 0.4) << radius;
    EXPECT_LT(1 - left[0], 0.5 * (1 - left[1])) << radius << ": that is what it is for";
  }
}

// What a pass of stamps leaves of a bump on a plate, as a share of its height.
double leftOfBump(double radius, float strength, double together) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -15), {1.5 * radius, 1.5 * radius, 30}, 1);
  const double ball = 0.25 * radius, high = 0.1 * radius;
  const Version bump = apply(block, Brush::of(Method::add), {{{0, 0, high - ball}, {0, 0, high - ball}, ball}});
  auto brush = std::make_shared<Brush>(*smoothing(Method::smooth));
  brush->quality.together = together;
  std::vector<Stamp> stamps = line({-0.8 * radius, 0, 0}, {0.8 * radius, 0, 0}, radius);
  for (Stamp& each : stamps) each.strength = strength;
  const Version after = apply(bump, brush, stamps);
  closedSurface(after);
  Sampler sampler(after);
  double z = -5;
  while (sampler.trilinear(Vec3d(0, 0, z)) < 0) z += 0.005;
  return z / high;
}

TEST(Smooth, LargeStampsTogetherDoWhatTheyDoOneAfterTheOther) {
  for (const double radius : {40.0, 72.0})
    for (const float strength : {0.2f, 0.5f, 1.0f}) {
      const double one = leftOfBump(radius, strength, 0), together = leftOfBump(radius, strength, 48);
      std::printf("radius %g strength %g: %.3f of the bump is left, together %.3f\n", radius, double(strength), one,
                  together);
      EXPECT_LT(one, 0.9);
      EXPECT_NEAR(together, one, 0.04) << radius << " " << strength;
    }
}

// Four of them at most, and no more than the quality says; each that is left comes at the stroke's end.
TEST(Smooth, WhatIsShownLagsByLessThanFourStamps) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 30);
  for (const double together : {0.0, 6.5, 48.0}) {
    auto brush = std::make_shared<Brush>(*smoothing(Method::smooth));
    brush->quality.together = together;
    BrushStroke stroke(base, brush);
    const size_t most = together == 0 ? 1 : together < 12 ? 2 : 4;
    uint64_t before = 0;
    for (size_t i = 0; i < 12; ++i) {
      stroke.apply(Stamp{{60, -20 + 3.0 * double(i), 0}, {60, -17 + 3.0 * double(i), 0}, 32});
      const bool computed = stroke.touched() > before;
      before = stroke.touched();
      EXPECT_EQ(computed, (i + 1) % most == 0) << together << " stamp " << i;
    }
    stroke.apply(Stamp{{60, 20, 0}, {60, 20, 0}, 32});
    const Version shown = stroke.publish();
    EXPECT_EQ(stroke.finish() == shown, false) << together;
  }
}

// A stroke that comes out of the air does what one does that begins on the clay: what reached nothing counts nothing.
TEST(Smooth, LargeStampsInTheAirChangeNothingOfThoseThatFollow) {
  const Version base = apply(makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 30), Brush::of(Method::carve),
                             {{{60, 0, 0}, {60, 0, 0}, 9}});
  const auto leave = [&](size_t inTheAir) {
    BrushStroke stroke(base, smoothing(Method::smooth));
    for (size_t i = 0; i < inTheAir; ++i) stroke.apply(Stamp{{260, 0, 0}, {258, 0, 0}, 40});
    for (int i = 0; i < 7; ++i) stroke.apply(Stamp{{60, -12 + 4.0 * i, 0}, {60, -8 + 4.0 * i, 0}, 40});
    return stroke.finish().hash();
  };
  const uint64_t alone = leave(0);
  EXPECT_NE(alone, base.hash());
  EXPECT_EQ(leave(4), alone);
  EXPECT_EQ(leave(40), alone);
}

TEST(Smooth, MirroredStampsLeaveMirroredBitsOnEverySimdTarget) {
  // symmetric about x = -0.5 voxels
  const Version sphere = makeSphere(Store::make(), Grid{}, Vec3d(-0.25, 0.3, 0.1), 15);
  const Version base = apply(sphere, Brush::of(Method::carve), {{{-0.5, 0, 32}, {-0.5, 0, 32}, 8}});
  struct Case {
    Method method;
    double radius;
  };
  // The last of them: three applications together.
  for (const auto [method, radius] : {Case{Method::smoothKeep, 8}, Case{Method::smoothKeep, 24},
                                      Case{Method::smooth, 24}, Case{Method::smooth, 40}}) {
    uint64_t reference = 0;
    tests::forEachSimdTarget([&, method = method, radius = radius](const std::string& name) {
      BrushStroke stroke(base, smoothing(method));
      for (int i = 0; i < 3; ++i) {
        const Stamp stamp{{4.25 + i, 2, 28}, {5, 3, 27}, radius};
        Stamp image = stamp;
        image.a.x() = -1 - stamp.a.x();
        image.b.x() = -1 - stamp.b.x();
        stroke.apply(std::vector{stamp, image});
      }
      const Version after = stroke.finish();
      if (reference == 0) reference = after.hash();
      EXPECT_EQ(after.hash(), reference) << name;
      after.forEachBrick([&](const Brick& brick) {
        const Slot other = after.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
        ASSERT_FALSE(other.isTile());
        for (int i = 0; i < kBrickVoxels; ++i) ASSERT_EQ(brick.phi(i), other.brick()->phi(i ^ 0x1c0));
      });
    });
  }
}

}  // namespace
}  // namespace argil::clay
