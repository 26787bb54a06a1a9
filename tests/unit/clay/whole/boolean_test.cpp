// Two clays become one: against distances that are known.

#include "clay/whole/boolean.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/resample.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::clayVolume;
using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

const Vec3d kOther(9, 8, 0);  // the spheres meet at about a right angle

Version sphere(const std::shared_ptr<Store>& store, const Vec3d& centre, double radius, double voxel = 0.5) {
  Grid grid;
  grid.voxelMm = voxel;
  return makeSphere(store, grid, centre, radius);
}

double lens(double d, double r, double s) {  // volume of what two spheres share
  return M_PI * std::pow(r + s - d, 2) * (d * d + 2 * d * (r + s) - 3 * std::pow(r - s, 2)) / (12 * d);
}

// Distance from p to the crease where the surfaces of the two balls meet: a circle about the line between them.
double toCrease(const Vec3d& p) {
  const double d = kOther.norm(), along = (d * d + 144 - 64) / (2 * d), radius = std::sqrt(144 - along * along);
  const Vec3d axis = kOther / d;
  return std::hypot(p.dot(axis) - along, (p - p.dot(axis) * axis).norm() - radius);
}

// Distance from p to the part of a ball's surface that lies on the wanted side of the other ball. The point of a
// spherical cap that is nearest to p is the sphere's if that is in the cap, else it lies on the cap's rim, the crease.
double toCap(const Vec3d& p, const Vec3d& centre, double radius, const Vec3d& other, double otherRadius, bool inside) {
  const Vec3d foot = centre + (p - centre).normalized() * radius;
  return ((foot - other).norm() < otherRadius) == inside ? std::abs((p - centre).norm() - radius) : toCrease(p);
}

TEST(Boolean, TwoSpheres) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 12), b = sphere(store, kOther, 8);
  const double shared = lens(kOther.norm(), 12, 8), ball = 4.0 / 3 * M_PI;
  const auto da = [](const Vec3d& p) { return p.norm() - 12; };
  const auto db = [](const Vec3d& p) { return (p - kOther).norm() - 8; };
  const struct {
    Combination how;
    std::function<double(const Vec3d&)> exact;
    double volume;
    bool innerA, innerB;  // the part of each surface that stays is that within the other ball
  } cases[] = {
      {Combination::join, [&](const Vec3d& p) { return std::min(da(p), db(p)); }, ball * (1728 + 512) - shared, false,
       false},
      {Combination::cut, [&](const Vec3d& p) { return std::max(da(p), -db(p)); }, ball * 1728 - shared, false, true},
      {Combination::intersect, [&](const Vec3d& p) { return std::max(da(p), db(p)); }, shared, true, true}};
  for (const auto& each : cases) {
    const Version result = combine(a, b, each.how);
    // Beside a sign change nothing was changed.
    uint64_t crossing = 0;
    result.forEachBrick([&](const Brick& brick) {
      for (int v = 0; v < kBrickVoxels; ++v) {
        if ((v & 7) == 7 || (brick.phi(v) < 0) == (brick.phi(v + 1) < 0)) continue;
        const Coord at = brick.coord * 8 + Coord{v >> 6, (v >> 3) & 7, v & 7};
        EXPECT_NEAR(brick.phi(v), each.exact(result.grid().toWorld(at.toVec3d())) / 0.5, 1e-4);
        ++crossing;
      }
    });
    EXPECT_GT(crossing, 500u);
    EXPECT_NEAR(clayVolume(result) * 0.125 / each.volume, 1, 0.004);
    // In the whole band distances are those to the new surface; the CSG of distances is off by a voxel and more there.
    const testing::FieldError error = errorAgainst(result, [&](const Vec3d& p) {
      const double distance = std::min(toCap(p, Vec3d::Zero(), 12, kOther, 8, each.innerA),
                                       toCap(p, kOther, 8, Vec3d::Zero(), 12, each.innerB));
      return each.exact(p) < 0 ? -distance : distance;
    });
    std::printf("%s\n", error.text().c_str());
    EXPECT_LE(error.bandMax, 0.25) << error.text();
    EXPECT_LE(error.bandRms, 0.01) << error.text();
    expectProperBand(result, 1.1);
    expectClosed(result);
  }
}

TEST(Boolean, SharesWhatTheOtherDoesNotReach) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 40), b = sphere(store, Vec3d(40, 0, 0), 4);
  const Version joined = combine(a, b, Combination::join);
  uint64_t same = 0, all = 0;
  joined.forEachBrick([&](const Brick& brick) {
    ++all;
    same += a.find(brick.coord).brick() == &brick;
  });
  EXPECT_GT(double(same) / double(all), 0.95);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::join), a);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::cut), a);
  EXPECT_EQ(combine(a, Version::empty(store, a.grid()), Combination::intersect).stats().bricks, 0u);
  EXPECT_EQ(combine(a, a, Combination::join).hash(), a.hash());
  EXPECT_EQ(combine(a, a, Combination::cut).stats().bricks, 0u);
  // Where a has nothing, b comes as it is.
  EXPECT_EQ(combine(Version::empty(store, a.grid()), a, Combination::join).hash(), a.hash());
}

TEST(Boolean, OtherStoreAndGrid) {
  const Version a = sphere(Store::make(), Vec3d::Zero(), 12), b = sphere(Store::make(), kOther, 8, 0.4);
  const Version result = combine(a, b, Combination::join, {.threads = 2});
  const double volume = 4.0 / 3 * M_PI * (1728 + 512) - lens(kOther.norm(), 12, 8);
  EXPECT_NEAR(clayVolume(result) * 0.125 / volume, 1, 0.004);
  EXPECT_EQ(result.store(), a.store());
  expectClosed(result);
}

TEST(Boolean, BlendRunsTheSurfacesTogether) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 12), b = sphere(store, kOther, 8);
  double before = 0;
  for (const double mm : {0.0, 2.0, 5.0}) {
    const Version result = combine(a, b, Combination::join, {.blendMm = mm, .threads = 2});
    const double volume = clayVolume(result);
    EXPECT_GT(volume, before * 1.0005);  // the seam fills
    before = volume;
    // The surface is where the smooth minimum of both distances is zero: it departs from the sharp one by a quarter of
    // the width at most, and not at all where one surface is farther away than the width.
    Surface surface(false);
    surface.update(result);
    double worst = 0, filled = 0;
    for (const Vec3d& p : surface.toMesh().positions) {
      const double da = p.norm() - 12, db = (p - kOther).norm() - 8, near = std::max(mm - std::abs(da - db), 0.0);
      worst = std::max(worst, std::abs(std::min(da, db) - (mm > 0 ? near * near / (4 * mm) : 0)));
      filled = std::max(filled, std::min(da, db));
    }
    EXPECT_LE(worst / 0.5, mm > 0 ? 0.1 : 0.5)
        << "voxels, at a blend of " << mm << " mm";  // draft vertices cut a crease off
    if (mm > 0) {
      EXPECT_NEAR(filled, mm / 4, 0.05 * 0.5 + 0.03 * mm);
    }
    expectProperBand(result, 1.2);
    expectClosed(result);
  }
  EXPECT_THROW((void)combine(a, b, Combination::join, {.blendMm = 100}), Error);
  EXPECT_THROW((void)combine(a, b, Combination::join, {.blendMm = -1}), Error);
}

TEST(Boolean, CancelLeavesNothing) {
  const auto store = Store::make();
  const Version a = sphere(store, Vec3d::Zero(), 40), b = sphere(store, kOther, 30);
  const uint64_t hash = a.hash();
  Job job;
  job.cancel();
  EXPECT_THROW((void)combine(a, b, Combination::join, {}, &job), Cancelled);
  EXPECT_EQ(a.hash(), hash);
  EXPECT_EQ(store->usage().bricks, a.stats().bricks + b.stats().bricks);
}

}  // namespace
}  // namespace argil::clay
