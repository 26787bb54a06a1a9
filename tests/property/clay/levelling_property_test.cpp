// Scrape, fill and flatten: towards the plane of what is under the tip, and no further.

#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/property/clay/brush_checks.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

using namespace testing;

// A flat top at z = 0 with a bump at x = -10 and a dent at x = 10, both 3 deep.
Version uneven() {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -10), {60, 60, 20}, 1);
  const Version bump = apply(block, Brush::of(Method::add), {{{-10, 0, -5}, {-10, 0, -5}, 8}});
  return apply(bump, Brush::of(Method::carve), {{{10, 0, 5}, {10, 0, 5}, 8}});
}

double heightAt(const Version& version, double x, double y) {
  Sampler sampler(version);
  double z = -15;
  while (sampler.trilinear(Vec3d(x, y, z)) < 0) z += 0.01;
  return z;
}

TEST(Level, ScrapeTakesBumpsFillTakesDentsFlattenBoth) {
  const Version base = uneven();
  ASSERT_NEAR(heightAt(base, -10, 0), 3, 0.1);
  ASSERT_NEAR(heightAt(base, 10, 0), -3, 0.1);
  for (const Method method : {Method::scrape, Method::fill, Method::flatten}) {
    const Version after = apply(base, Brush::of(method), line({-20, 0, 0}, {20, 0, 0}, 14), 3);
    const double bump = heightAt(after, -10, 0), dent = heightAt(after, 10, 0);
    if (method == Method::fill)
      EXPECT_GT(bump, 2);
    else
      EXPECT_LT(bump, 0.6);
    if (method == Method::scrape)
      EXPECT_LT(dent, -2);
    else
      EXPECT_GT(dent, -0.6);
    Surface surface(false);
    surface.update(after);
    const TopologyReport report = checkTopology(surface.toMesh());
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.bodies, 1u);  // nothing that floats, nothing hollow
    const FieldErrors errors = fieldErrors(after);
    EXPECT_LE(errors.rms, 0.05);
    EXPECT_LE(errors.worst, 0.25);
  }
}

TEST(Level, APlaneStaysWhereItIs) {
  // Slanted, so that no voxel lies on it.
  Editor editor(Version::empty(Store::make(), Grid{}));
  const Vec3d n = Vec3d(0.3, 0.2, 1).normalized();
  for (int b = 0; b < 20 * 20 * 20; ++b) {
    const Coord brick{b / 400 - 10, b / 20 % 20 - 10, b % 20 - 10};
    float phi[kBrickVoxels];
    for (int i = 0; i < kBrickVoxels; ++i)
      phi[i] = static_cast<float>(n.dot((brick * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d()));
    editor.setVoxels(brick, phi);
  }
  const Version base = editor.commit();
  for (const Method method : {Method::scrape, Method::fill, Method::flatten}) {
    const Version after = apply(base, Brush::of(method), line({-10, 0, 3}, {10, 0, -3}, 14), 3);
    Sampler sampler(after);
    for (int x = -20; x <= 20; ++x)
      for (int y = -15; y <= 15; ++y) {
        const Vec3d p(x, y, -(n.x() * x + n.y() * y) / n.z());
        EXPECT_NEAR(sampler.trilinear(p), 0, 0.01) << static_cast<int>(method) << ' ' << x << ' ' << y;
      }
  }
}

// Beside a cliff there is air below the plane: it stays air, and the cliff stands.
TEST(Level, AirBesideACliffIsNotFilled) {
  const Version base = makeBlock(Store::make(), Grid{}, Vec3d(-10, 0, -10), {20, 40, 20}, 1);  // its side at x = 0
  const Version after = apply(base, Brush::of(Method::fill), line({-6, -20, 0}, {-6, 20, 0}, 16), 3);
  double farthest = 0;
  for (const Vec3d& p : closedSurface(after)) farthest = std::max(farthest, p.x());
  EXPECT_LE(farthest, 1.5);
}

TEST(Level, MirroredStampsLeaveMirroredBitsOnEverySimdTarget) {
  // symmetric about x = -0.5 voxels
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(-0.25, 0.3, 0.1), 15);
  uint64_t reference = 0;
  tests::forEachSimdTarget([&](const std::string& name) {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> u(-1, 1);
    BrushStroke stroke(base, Brush::of(Method::flatten));
    for (int i = 0; i < 8; ++i) {
      const Vec3d a = Vec3d(0.5 + 0.5 * u(random), u(random), 0.3).normalized() * 29;
      Stamp stamp{a, a + Vec3d(u(random), u(random), u(random)), 10, 0.9f}, image = stamp;
      image.a.x() = -1 - stamp.a.x();
      image.b.x() = -1 - stamp.b.x();
      stroke.apply(std::vector{stamp, image});
    }
    const Version after = stroke.finish();
    EXPECT_NE(after.hash(), base.hash());
    if (reference == 0) reference = after.hash();
    EXPECT_EQ(after.hash(), reference) << name;
    after.forEachBrick([&](const Brick& brick) {
      const Slot other = after.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
      ASSERT_FALSE(other.isTile());
      for (int i = 0; i < kBrickVoxels; ++i) ASSERT_EQ(brick.phi(i), other.brick()->phi(i ^ 0x1c0));
    });
  });
}

}  // namespace
}  // namespace argil::clay
