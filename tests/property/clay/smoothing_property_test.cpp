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

TEST(Smooth, MirroredStampsLeaveMirroredBitsOnEverySimdTarget) {
  // symmetric about x = -0.5 voxels
  const Version sphere = makeSphere(Store::make(), Grid{}, Vec3d(-0.25, 0.3, 0.1), 15);
  const Version base = apply(sphere, Brush::of(Method::carve), {{{-0.5, 0, 32}, {-0.5, 0, 32}, 8}});
  for (const double radius : {8.0, 24.0}) {
    uint64_t reference = 0;
    tests::forEachSimdTarget([&](const std::string& name) {
      BrushStroke stroke(base, smoothing(Method::smoothKeep));
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
