// Bodies, cavities, halves and evened surfaces.

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
#include "clay/whole/smooth_all.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole_checks.h"

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

TEST(SmoothAll, KeepsTheVolumeOfASphereAndRoundsABox) {
  const auto store = Store::make();
  const Version sphere = ball(store, Vec3d::Zero(), 20);  // 40 voxels
  const double before = clayVolume(sphere);
  const Version smooth = smoothAll(sphere, 1, true, 2), shrunk = smoothAll(sphere, 1, false, 2);
  std::printf("one pass over a sphere of 40 voxels: volume %+.5f %% kept, %+.5f %% not\n",
              100 * (clayVolume(smooth) / before - 1), 100 * (clayVolume(shrunk) / before - 1));
  EXPECT_NEAR(clayVolume(smooth) / before, 1, 1e-4);
  EXPECT_LT(clayVolume(shrunk) / before, 1 - 1e-4);
  EXPECT_LT(errorAgainst(smooth, [](const Vec3d& p) { return p.norm() - 20; }).surfaceMax, 0.02);
  const Version block = makeBlock(store, half(), Vec3d::Zero(), Vec3d(16, 16, 16), 0);
  const Version round = smoothAll(block, 4, false, 2);
  Sampler was(block), is(round);
  EXPECT_GT(is.trilinear(half().toVoxel(Vec3d(7.8, 7.8, 7.8))),
            was.trilinear(half().toVoxel(Vec3d(7.8, 7.8, 7.8))) + 0.5);
  EXPECT_NEAR(is.trilinear(half().toVoxel(Vec3d(8, 0, 0))), 0, 0.05);
  expectClosed(round);
  expectProperBand(round, 1.1);
  EXPECT_THROW((void)smoothAll(block, 0, false), Error);
}

// Four passes read four voxels farther than one: what lies beside the surface keeps its slope.
TEST(SmoothAll, LeavesDistancesOfALargeSphere) {
  const auto store = Store::make();
  const Version smooth = smoothAll(ball(store, Vec3d::Zero(), 20), 4, false, 2);
  double sum = 0, squares = 0, most = -1e9, least = 1e9;
  uint64_t count = 0;
  smooth.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      const double exact = (smooth.grid().toWorld(at.toVec3d()).norm() - 20) / smooth.grid().voxelMm;
      if (std::abs(exact) > 1.2) continue;
      const double off = brick.phi(v) - exact;
      sum += off, squares += off * off, ++count;
      most = std::max(most, off), least = std::min(least, off);
    }
  });
  const double mean = sum / double(count), spread = std::sqrt(squares / double(count) - mean * mean);
  std::printf("four passes over a sphere of 40 voxels: smaller by %.4f voxel, %.5f RMS beside that, %.4f to %.4f\n",
              mean, spread, least - mean, most - mean);
  EXPECT_GT(mean, 0);
  EXPECT_LT(most - least, 0.01);
}

// What is worked on together is nothing that the clay knows of, and by how many not even its last bit.
TEST(SmoothAll, DoesTheSameWhereverThePieceLies) {
  for (const Precision precision : {Precision::float32, Precision::fixed16}) {
    const auto store = Store::make(precision);
    Version clay = makeBlock(store, half(), Vec3d(1, 2, 3), Vec3d(50, 40, 30), 0);
    for (const Vec3d& at : {Vec3d(26, 3, 4), Vec3d(-9, 20, 8), Vec3d(4, -7, 18)})
      clay = combine(clay, ball(store, at, 9), Combination::cut);
    clay = combine(clay, ball(store, Vec3d(-20, -16, 14), 2), Combination::join);
    const Version smooth = smoothAll(clay, 6, false, 1);
    EXPECT_EQ(smoothAll(clay, 6, false, 3).hash(), smooth.hash());
    for (const Coord bricks : {Coord{5, 0, 0}, Coord{-3, 9, 14}}) {
      Editor editor(Version::empty(Store::make(precision), half()));
      clay.forEachBrick([&](const Brick& brick) {
        BrickValues room;
        editor.setVoxels(brick.coord + bricks, brick.values(room));
      });
      for (int i = 0; i < 8000; ++i)
        if (const Coord at{i / 400 - 10, i / 20 % 20 - 10, i % 20 - 10}; clay.find(at) == Slot(Tile::inside))
          editor.setTile(at + bricks, Tile::inside);
      const Version there = smoothAll(editor.commit(), 6, false, 2);
      uint64_t count = 0;
      float worst = 0;
      smooth.forEachBrick([&](const Brick& brick) {
        BrickValues one, other;
        const Slot slot = there.find(brick.coord + bricks);
        ASSERT_FALSE(slot.isTile());
        const BrickValues &here = brick.values(one), &moved = slot.values(other, 3);
        // Distances that are on their way to the last bit when the passes end know where a block of bricks ends.
        for (int v = 0; v < kBrickVoxels; ++v) worst = std::max(worst, std::abs(here[v] - moved[v]));
        ++count;
      });
      EXPECT_EQ(there.stats().bricks, count);
      EXPECT_GT(count, 500u);
      EXPECT_LT(worst, precision == Precision::float32 ? 2e-6f : 3e-4f);
    }
  }
}

// So much that the surface has to move farther than the band's end forgives.
TEST(SmoothAll, KeepsTheVolumeOfASmallBall) {
  const Version small = ball(Store::make(), Vec3d::Zero(), 4);  // 8 voxels
  const double before = clayVolume(small);
  const Version shrunk = smoothAll(small, 12, false, 2), kept = smoothAll(small, 12, true, 2);
  EXPECT_LT(clayVolume(shrunk) / before, 0.95);
  EXPECT_NEAR(clayVolume(kept) / before, 1, 2e-4);
  EXPECT_LT(errorAgainst(kept, [](const Vec3d& p) { return p.norm() - 4; }).surfaceMax, 0.05);
  expectProperBand(kept, 1.1);
}

}  // namespace
}  // namespace argil::clay
