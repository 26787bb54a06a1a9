// Scrape, fill and flatten: towards the plane of what is under the tip, and no further.

#include <map>
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

std::shared_ptr<const Brush> building(float height, float amount = 1) {
  auto brush = std::make_shared<Brush>(*Brush::of(Method::build, amount));
  brush->height = height;
  return brush;
}

// Level clay rises by about the height a pass, and again with the next: a bead that is as wide as the tip heaps up. Its
// rim is smooth.
TEST(Level, BuildLaysItsHeightAPassAndHeapsUp) {
  for (const double tip : {6.0, 12.0, 24.0, 48.0})
    for (const float amount : {1.0f, -1.0f}) {
      const auto height = static_cast<float>(0.15 * tip);
      const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -1.5 * tip), {6 * tip, 4 * tip, 3 * tip}, 1);
      double last = 0;
      Version now = block;
      for (int pass = 1; pass <= 3; ++pass) {
        SCOPED_TRACE(::testing::Message() << tip << ' ' << amount << ' ' << pass);
        now = apply(now, building(height, amount), line({-2 * tip, 0.3, 0}, {2 * tip, 0.3, 0}, tip));
        const auto top = [&](double y) {
          Sampler sampler(now);
          double z = amount * 2 * tip;
          if (amount > 0)
            while (sampler.trilinear(Vec3d(0.2, y, z)) >= 0) z -= 0.01;
          else
            for (z = -tip; sampler.trilinear(Vec3d(0.2, y, z)) < 0;) z += 0.01;
          return amount * z;
        };
        std::printf("tip %g amount %g pass %d: %.3f heights\n", tip, double(amount), pass, (top(0.3) - last) / height);
        EXPECT_GT(top(0.3) - last, 0.5 * height);
        EXPECT_LT(top(0.3) - last, 1.3 * height);
        last = top(0.3);
        // From the middle to the rim it falls evenly: no step, no lip beside it.
        for (double t = 0; t < 1.2; t += 0.1) {
          EXPECT_LT(std::abs(top(0.3 + (t + 0.1) * tip) - top(0.3 + t * tip)), 0.35 * last + 0.1) << t;
          EXPECT_GT(top(0.3 + t * tip), -0.15) << t;
        }
      }
      closedSurface(now);
      const FieldErrors errors = fieldErrors(now);
      EXPECT_LE(errors.rms, 0.05) << tip;
      EXPECT_LE(errors.worst, 0.25) << tip;
    }
}

// What lies below is filled, what stands above stays: clay is laid up to a level.
// A brow on a ball, gone over twice: its foot lies on the rim of the tip, where flanks get steeper with every pass.
TEST(Level, WhatIsBuiltAgainHasNoPitsAtItsFoot) {
  constexpr double kBall = 60, kTip = 6.24;
  Grid grid;
  grid.voxelMm = 1;
  Version now = makeSphere(Store::make(), grid, Vec3d::Zero(), kBall);
  const auto on = [](double x, double z) { return Vec3d(x, -std::sqrt(kBall * kBall - x * x - z * z), z); };
  std::vector<Stamp> way;
  const std::vector<Vec3d> corners{on(-30, 16), on(-22, 20), on(-10, 18)};
  for (size_t k = 0; k + 1 < corners.size(); ++k) {
    const Vec3d step = corners[k + 1] - corners[k];
    const int count = static_cast<int>(std::ceil(step.norm() / (0.1 * kTip)));
    for (int i = 0; i < count; ++i) {
      const auto at = [&](int n) { return Vec3d(kBall * (corners[k] + step * n / count).normalized()); };
      way.push_back({at(i), at(i + 1), kTip});
    }
  }
  for (int pass = 0; pass < 3; ++pass) now = apply(now, building(static_cast<float>(0.2 * kTip)), way);
  Surface surface(false);
  surface.update(now);
  const TriangleMesh mesh = surface.toMesh();
  std::vector<Vec3d> around(mesh.positions.size(), Vec3d::Zero()), normal(mesh.positions.size(), Vec3d::Zero());
  std::vector<int> count(mesh.positions.size());
  for (const auto& t : mesh.triangles) {
    const Vec3d facet =
        (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (size_t k = 0; k < 3; ++k) {
      normal[t[k]] += facet;
      around[t[k]] += mesh.positions[t[(k + 1) % 3]];
      ++count[t[k]];
    }
  }
  double deepest = -1, highest = 0;
  for (size_t i = 0; i < count.size(); ++i) highest = std::max(highest, mesh.positions[i].norm() - kBall);
  for (size_t i = 0; i < count.size(); ++i)
    deepest = std::max(deepest, (around[i] / count[i] - mesh.positions[i]).dot(normal[i].normalized()));
  std::printf("%.2f voxels high; the deepest vertex lies %.3f voxel below those around it\n", highest, deepest);
  EXPECT_GT(highest, 0.4 * kTip);
  EXPECT_LT(deepest, 0.1);
}

TEST(Level, BuildLevels) {
  const Version base = uneven();
  const Version after = apply(base, building(2), line({-20, 0, 0}, {20, 0, 0}, 14));
  const double beside = heightAt(after, 0, 0);
  EXPECT_GT(beside, 1);
  EXPECT_GT(heightAt(after, 10, 0), -0.6) << "the dent, 3 deep, is all but full";
  EXPECT_LT(heightAt(after, -10, 0) - beside, 2.2) << "the bump, 3 high, stands out by less";
  EXPECT_GT(heightAt(after, -10, 0), 2.9) << "and nothing of it was taken";
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
  for (const Method method : {Method::scrape, Method::fill, Method::flatten})
    for (const double radius : {14.0, 40.0}) {  // below and above what takes bricks as pieces
      const Version after = apply(base, Brush::of(method), line({-10, 0, 3}, {10, 0, -3}, radius), 3);
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
  std::map<double, uint64_t> references;
  const auto check = [&](const std::string& name, double radius) {
    uint64_t& reference = references[radius];
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> u(-1, 1);
    BrushStroke stroke(base, Brush::of(Method::flatten));
    for (int i = 0; i < 8; ++i) {
      const Vec3d a = Vec3d(0.5 + 0.5 * u(random), u(random), 0.3).normalized() * 29;
      Stamp stamp{a, a + Vec3d(u(random), u(random), u(random)), radius, 0.9f}, image = stamp;
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
  };
  tests::forEachSimdTarget([&](const std::string& name) {
    check(name, 10);
    check(name, 33);  // bricks as pieces of the plane
  });
}

// A large blade takes what lies in a brick as one piece: its plane is that of the voxels, bumps, walls and all.
TEST(Level, ALargeBladeLevelsAsASmallOneDoes) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -20), {120, 120, 40}, 1);
  std::vector<Stamp> bumps;
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 60; ++i) {
    const Vec3d at(90 * u(random), 90 * u(random), -4);
    bumps.push_back({at, at, 6, 1});
  }
  const Version base = apply(block, Brush::of(Method::add), bumps);
  double low[2] = {9, 9}, high[2] = {-9, -9};
  for (const double radius : {31.9, 32.0}) {
    const Version after = apply(base, Brush::of(Method::scrape), line({-30, 0, 0}, {30, 0, 0}, radius), 6);
    for (int x = -30; x <= 30; x += 3)
      for (int y = -12; y <= 12; y += 3) {
        const double z = heightAt(after, x, y);
        low[radius == 32] = std::min(low[radius == 32], z), high[radius == 32] = std::max(high[radius == 32], z);
      }
  }
  std::printf("heights after scraping: voxels %.3f to %.3f, bricks %.3f to %.3f\n", low[0], high[0], low[1], high[1]);
  EXPECT_NEAR(low[0], low[1], 0.05);
  EXPECT_NEAR(high[0], high[1], 0.05);
  EXPECT_LT(high[1], 1.0);
}

}  // namespace
}  // namespace argil::clay
