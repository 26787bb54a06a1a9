// Bodies, cavities and halves.

#include "clay/field/loose_parts.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/mirror.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::clayVolume;
using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

Grid half() {
  Grid grid;
  grid.voxelMm = 0.5;
  return grid;
}

Version ball(const std::shared_ptr<Store>& store, const Vec3d& centre, double radius) {
  return makeSphere(store, half(), centre, radius);
}

TEST(LooseParts, SplitsTouchingBandsAndSharesTheRest) {
  const auto store = Store::make();
  // 1.2 voxels between the first two: their bands overlap.
  const Version a = ball(store, Vec3d::Zero(), 10), b = ball(store, Vec3d(16.6, 0, 0), 6),
                c = ball(store, Vec3d(0, 40, 0), 3);
  const Version all = combine(combine(a, b, Combination::join), c, Combination::join);
  const std::vector<double> volumes = bodyVolumes(all);
  ASSERT_EQ(volumes.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(volumes[i] / (4.0 / 3 * M_PI * std::pow(i == 0 ? 10 : i == 1 ? 6 : 3, 3)), 1, 0.02);
  const std::vector<Version> parts = splitParts(all);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_LT(errorAgainst(parts[0], [](const Vec3d& p) { return p.norm() - 10; }).surfaceMax, 0.4);
  EXPECT_LT(errorAgainst(parts[1], [](const Vec3d& p) { return (p - Vec3d(16.6, 0, 0)).norm() - 6; }).surfaceMax, 0.4);
  EXPECT_EQ(parts[2].hash(), c.hash());
  for (const Version& part : parts) {
    expectClosed(part);
    expectProperBand(part, 1.1);
  }
  EXPECT_EQ(splitParts(a).size(), 1u);
  EXPECT_EQ(splitParts(a)[0], a);
}

// More bodies than are taken out at once, their bands touching: each part is one of the balls, whole and alone.
TEST(LooseParts, SplitsHundredsOfBodies) {
  const auto store = Store::make();
  constexpr int kAlong = 14;
  const auto radiusOf = [](int i) { return i % 7 == 3 ? 2.5 : 2.0; };
  std::vector<Version> rows;
  for (int x = 0; x < kAlong; ++x) {
    for (int y = 0; y < kAlong; ++y) {
      const Version one = ball(store, Vec3d(5.7 * x, 5.7 * y, 0), radiusOf(x * kAlong + y));
      if (y == 0)
        rows.push_back(one);
      else
        rows.back() = combine(rows.back(), one, Combination::join);
    }
  }
  Version all = rows[0];
  for (size_t i = 1; i < rows.size(); ++i) all = combine(all, rows[i], Combination::join);
  const std::vector<Version> parts = splitParts(all);
  ASSERT_EQ(parts.size(), size_t(kAlong) * kAlong);
  const std::vector<double> volumes = bodyVolumes(all);
  std::vector<bool> seen(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    const std::vector<double> own = bodyVolumes(parts[i]);
    ASSERT_EQ(own.size(), 1u);
    EXPECT_EQ(own[0], volumes[i]) << "largest first";
    const Surface surface = [&] {
      Surface made(false, Grade::fine);
      made.update(parts[i], 2);
      return made;
    }();
    const TopologyReport skin = checkTopology(surface.toMesh());
    EXPECT_TRUE(skin.closed());
    const Vec3d middle = (skin.low + skin.high) / 2;
    const auto x = int(std::lround(middle.x() / 5.7)), y = int(std::lround(middle.y() / 5.7));
    const int which = x * kAlong + y;
    ASSERT_TRUE(which >= 0 && which < int(seen.size()) && !seen[size_t(which)]);
    seen[size_t(which)] = true;
    EXPECT_LT((middle - Vec3d(5.7 * x, 5.7 * y, 0)).norm(), 0.05);
    EXPECT_NEAR(skin.volume / (4.0 / 3 * M_PI * std::pow(radiusOf(which), 3)), 1, 0.03);
    expectProperBand(parts[i], 1.1);
  }
}

// In noise every pattern of corners occurs, folded faces on both sides among them.
TEST(LooseParts, BodiesAndCavitiesAreTheShellsOfTheSurface) {
  std::mt19937 random(5);
  for (const double share : {0.2, 0.35, 0.5, 0.65, 0.8, 0.9}) {
    SCOPED_TRACE(share);
    std::bernoulli_distribution inside(share);
    Editor editor(Version::empty(Store::make(), half()));
    for (int b = 0; b < 27; ++b) {
      float phi[kBrickVoxels];
      for (float& p : phi) p = inside(random) ? -0.5f : 0.5f;
      editor.setVoxels(Coord{b / 9 - 1, b / 3 % 3 - 1, b % 3 - 1}, phi);
    }
    const Version noise = editor.commit();
    const SpeckTest none = [](Coord, double) { return false; };
    const uint64_t bodies = removeSpecks(noise, Tile::inside, 0, none, WorkPart(nullptr)).left;
    const uint64_t cavities = removeSpecks(noise, Tile::outside, 0, none, WorkPart(nullptr)).left;
    Surface surface(false, Grade::fine);
    surface.update(noise, 2);
    EXPECT_EQ(bodies + cavities, checkTopology(surface.toMesh()).bodies);
    EXPECT_EQ(bodies, bodyVolumes(noise).size());
  }
}

TEST(LooseParts, CrumbsGoAndTheLargestStays) {
  const auto store = Store::make();
  const Version a = ball(store, Vec3d::Zero(), 10),
                all = combine(a, ball(store, Vec3d(30, 0, 0), 2), Combination::join);
  const Cleaned kept = removeCrumbs(all, 20), cleaned = removeCrumbs(all, 40);
  EXPECT_EQ(kept.count, 0u);
  EXPECT_EQ(kept.version, all);
  EXPECT_EQ(cleaned.count, 1u);
  EXPECT_NEAR(cleaned.volumeMm3, 33.5, 3);  // counted in voxels
  EXPECT_EQ(cleaned.version.hash(), a.hash());
  EXPECT_EQ(removeCrumbs(a, 1e9).version, a);
  EXPECT_THROW((void)removeCrumbs(a, -1), Error);
}

TEST(LooseParts, VoidsFillAndDimplesStay) {
  const auto store = Store::make();
  const Version a = ball(store, Vec3d::Zero(), 14);
  const Version dimpled = combine(a, ball(store, Vec3d(14, 0, 0), 4), Combination::cut);
  const Version hollow = combine(combine(dimpled, ball(store, Vec3d(-3, 0, 0), 3), Combination::cut),
                                 ball(store, Vec3d(-3, 8, 0), 1.5), Combination::cut);
  const Cleaned filled = fillVoids(hollow);
  EXPECT_EQ(filled.count, 2u);
  EXPECT_NEAR(filled.volumeMm3 / (4.0 / 3 * M_PI * (27 + 1.5 * 1.5 * 1.5)), 1, 0.03);
  EXPECT_EQ(bodyVolumes(filled.version), bodyVolumes(dimpled));
  expectClosed(filled.version);
  EXPECT_EQ(fillVoids(a).version, a);
}

TEST(Mirror, HalvesAreBitEqualOnABrickFace) {
  const auto store = Store::make();
  const Version lopsided = combine(ball(store, Vec3d::Zero(), 12), ball(store, Vec3d(9, 5, 3), 6), Combination::join);
  const double plane = 0.5 * -0.5;  // voxel −1/2
  const Version mirrored = mirrorHalf(lopsided, Vec3d(plane, 0, 0), Vec3d::UnitX(), 2);
  uint64_t looked = 0;
  mirrored.forEachBrick([&](const Brick& brick) {
    const Slot other = mirrored.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
    for (int v = 0; v < kBrickVoxels; ++v) {
      ASSERT_EQ(brick.phi(v), other.phi(Brick::offset(7 - (v >> 6), (v >> 3) & 7, v & 7), 3));
      ++looked;
    }
  });
  EXPECT_GT(looked, 10000u);
  expectClosed(mirrored);
  // The kept side is the one that the normal points to: it has the lump, and beyond the plane's band nothing of it
  // changed.
  Sampler now(mirrored), before(lopsided);
  for (int x = 4; x < 40; ++x) EXPECT_EQ(now.voxel({x, 10, 6}), before.voxel({x, 10, 6}));
  EXPECT_GT(clayVolume(mirrored), clayVolume(lopsided));
  EXPECT_LT(clayVolume(mirrorHalf(lopsided, Vec3d(plane, 0, 0), -Vec3d::UnitX(), 2)), clayVolume(lopsided));
}

TEST(Mirror, AnyPlane) {
  const Vec3d n = Vec3d(1, 0.4, -0.2).normalized(), at(2, 1, 0);
  const Version sphere = ball(Store::make(), Vec3d::Zero(), 12);
  const Version mirrored = mirrorHalf(sphere, at, n, 2);
  // Away from the crease.
  Sampler sampler(mirrored);
  double worst = 0;
  mirrored.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Vec3d p = mirrored.grid().toWorld((brick.coord * 8 + Coord{v >> 6, (v >> 3) & 7, v & 7}).toVec3d());
      const double side = n.dot(p - at);
      if (std::abs(side) < 2.5) continue;
      const Vec3d q = side > 0 ? p : Vec3d(p - 2 * side * n);
      const double exact = (q.norm() - 12) / 0.5;
      if (std::abs(exact) < 1) worst = std::max(worst, std::abs(brick.phi(v) - exact));
    }
  });
  std::printf("mirrored over a slanted plane: %.4f voxel at most\n", worst);
  EXPECT_LT(worst, 0.02);
  expectClosed(mirrored);
  EXPECT_THROW((void)mirrorHalf(sphere, at, Vec3d::Zero()), Error);
  EXPECT_THROW((void)mirrorHalf(sphere, Vec3d(20, 0, 0), Vec3d::UnitX()), Error);
}

}  // namespace
}  // namespace argil::clay
