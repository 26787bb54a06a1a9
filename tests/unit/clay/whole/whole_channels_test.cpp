// Colour, material and mask through operations on a whole piece: a painted sphere whose colours are known at each
// place.

#include <gtest/gtest.h>

#include <functional>

#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/store/channel_reader.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/deform.h"
#include "clay/whole/lattice.h"
#include "clay/whole/mirror.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

constexpr ChannelBytes kRed{200, 10, 20, 255, 1, 0}, kBlue{10, 20, 210, 255, 2, 255}, kGreen{5, 220, 30, 255, 3, 0};

using Rule = std::function<ChannelBytes(const Vec3d& mm)>;

// All of the band has the colours that the rule gives its places.
Version painted(const Version& clay, const Rule& rule) {
  Editor editor(clay);
  clay.forEachBrick([&](const Brick& brick) {
    ChannelBlock block{ChannelPlace{}};
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      if (std::abs(brick.phi(v)) < clay.grid().band) block.set(v, rule(clay.grid().toWorld(at.toVec3d())));
    }
    block.store(editor, brick.coord);
  });
  return editor.commit();
}

Version sphere(const std::shared_ptr<Store>& store, const Vec3d& centre, double radius, double voxel = 0.5) {
  Grid grid;
  grid.voxelMm = voxel;
  return makeSphere(store, grid, centre, radius);
}

ChannelBytes twoColours(const Vec3d& p) {
  return p.x() < 0 ? kRed : kBlue;
}

// Compares voxels that are beside the surface (`beside`) or in the band with what the rule says of their place. Where
// it says different things of the place's surroundings, about `slackMm` off, all of them are right. Looks at distances
// up to `upTo` voxels.
void expectColours(const Version& clay, const Rule& rule, double slackMm, float upTo = 3) {
  uint64_t beside = 0, band = 0, wrongBeside = 0, wrongBand = 0, outside = 0;
  clay.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      ChannelBytes bytes;
      for (const Channel channel : kAllChannels) bytes[indexOf(channel)] = clay.find(channel, brick.coord).value(v);
      if (!(std::abs(brick.phi(v)) < clay.grid().band)) {
        outside += bytes != ChannelBytes{};
        continue;
      }
      const Vec3d p = clay.grid().toWorld(at.toVec3d());
      bool right = bytes == rule(p), sure = true;
      for (int i = 0; i < 27; ++i)
        sure &= i == 13 || rule(p + slackMm * Vec3d(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1).normalized()) == rule(p);
      right |= !sure;
      if (std::abs(brick.phi(v)) > upTo) continue;
      ++band;
      wrongBand += !right;
      if (std::abs(brick.phi(v)) > 1) continue;
      ++beside;
      wrongBeside += !right;
    }
  });
  EXPECT_GT(beside, 500u);
  EXPECT_EQ(wrongBeside, 0u) << "of " << beside << " beside the surface";
  EXPECT_EQ(wrongBand, 0u) << "of " << band << " in the band";
  EXPECT_EQ(outside, 0u) << "have a channel where there is no band";
  // What has no brick of distances has none of a channel either.
  for (const Channel channel : kAllChannels)
    clay.forEachBrick(channel, [&](const ChannelBrick& brick) { EXPECT_NE(clay.find(brick.coord).brick(), nullptr); });
}

class WholeChannels : public ::testing::Test {
 protected:
  Version clay_ = painted(sphere(Store::make(), Vec3d::Zero(), 8), twoColours);
};

TEST_F(WholeChannels, PaintedAsItIs) {
  expectColours(clay_, twoColours, 0);
}

TEST_F(WholeChannels, OffsetTakesTheNearestPlaceOfTheSurface) {
  for (const double mm : {0.4, 1.3, 9.0, -0.4, -4.0}) {
    SCOPED_TRACE(mm);
    expectColours(offset(clay_, mm, 2), twoColours, 0.5 * std::max(1.0, (8 + mm) / 8));  // a voxel of the old surface
  }
  EXPECT_EQ(offset(clay_, 3, 1).hash(), offset(clay_, 3, 3).hash());
}

// A distance just below the band is the band itself once it is stored in 16 bits.
TEST_F(WholeChannels, OffsetOfSixteenBitsLeavesNoneWhereValuesWereRoundedToTheBand) {
  Grid grid;
  grid.voxelMm = 1;
  const Version block =
      painted(makeBlock(Store::make(Precision::fixed16), grid, Vec3d::Zero(), Vec3d::Constant(40), 0), twoColours);
  const Version thicker = offset(block, 1.00002, 2);
  uint64_t rounded = 0, outside = 0;
  thicker.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (std::abs(brick.phi(v)) < grid.band) continue;
      ++rounded;
      for (const Channel channel : kAllChannels) outside += thicker.find(channel, brick.coord).value(v) != 0;
    }
  });
  EXPECT_GT(rounded, 0u);
  EXPECT_EQ(outside, 0u);
}

TEST_F(WholeChannels, ShellsHaveTheSameOnBothWalls) {
  for (const auto& [inner, outer] : {std::pair{2.5, 0.0}, std::pair{0.0, 2.5}, std::pair{1.5, 1.5}}) {
    SCOPED_TRACE(inner);
    expectColours(shell(clay_, inner, outer, 2), twoColours, 0.5);
  }
  EXPECT_EQ(shell(clay_, 1.5, 1.5, 1).hash(), shell(clay_, 1.5, 1.5, 3).hash());
}

TEST_F(WholeChannels, ResampleTakesThePlace) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.rotate(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  pose.pretranslate(Vec3d(5, 6, 7));
  const Rule there = [&](const Vec3d& p) { return twoColours(pose.inverse() * p); };
  for (const double voxel : {0.4, 1.1}) {
    SCOPED_TRACE(voxel);
    Grid grid;
    grid.voxelMm = voxel;
    grid.originMm = Vec3d(1.1, 2.2, -0.3);
    expectColours(resample(clay_, grid, pose, 2), there, 1.16 * std::max(voxel, 0.5));
  }
  Grid grid = clay_.grid();
  grid.voxelMm = 0.8;
  EXPECT_EQ(resample(clay_, grid, pose, 1).hash(), resample(clay_, grid, pose, 3).hash());
  // Whole voxels: the bytes go along.
  grid = clay_.grid();
  Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
  shift.translate(Vec3d(2.5, -1.5, 4));
  EXPECT_EQ(resample(resample(clay_, grid, shift, 2), grid, shift.inverse(), 2).hash(), clay_.hash());
}

TEST_F(WholeChannels, SmoothingLeavesThemInPlace) {
  for (const int passes : {1, 3, 6}) expectColours(smoothAll(clay_, passes, true, 2), twoColours, 0.26);
}

TEST_F(WholeChannels, MirrorTakesThemAlong) {
  // What lies above the plane, and its image below.
  for (const Vec3d& normal : {Vec3d(1, 0, 0), Vec3d(1, 2, 0.5)}) {
    const Vec3d n = normal.normalized(), point(1.25, 0, 0);
    const Rule both = [&](const Vec3d& p) {
      const double away = n.dot(p - point);
      return twoColours(away < 0 ? Vec3d(p - 2 * away * n) : p);
    };
    expectColours(mirrorHalf(clay_, point, normal, 2), both, 0.58);
  }
}

TEST_F(WholeChannels, ALatticeTakesThemAlong) {
  Lattice lattice({Vec3d::Constant(-12), Vec3d::Constant(12)}, {2, 2, 2});
  for (size_t i = 0; i < lattice.points().size(); ++i)
    lattice.setPoint(i, lattice.points()[i].cwiseProduct(Vec3d(1, 1.2, 0.9)) + Vec3d(3.1, 0, 0));
  const Version moved = deform(clay_, lattice, Store::make(), nullptr, 2);
  expectColours(
      moved, [](const Vec3d& p) { return twoColours(p - Vec3d(3.1, 0, 0)); }, 0.75);
}

TEST_F(WholeChannels, CombiningKeepsThoseOfBoth) {
  constexpr float kNear = 2.5;  // farther off, distances beside the crease are first order, and either clay is right
  const Vec3d centre(6, 5.3, 0);
  const Version other = painted(sphere(Store::make(), centre, 5.3), [](const Vec3d&) { return kGreen; });
  const auto nearer = [&](const Vec3d& p, bool inward) {
    // Signed distances: of what two solids make, the surface is that of the one that says more.
    const double a = p.norm() - 8, b = (p - centre).norm() - 5.3;
    return (inward ? a > b : a < b) ? twoColours(p) : kGreen;
  };
  expectColours(
      combine(clay_, other, Combination::join), [&](const Vec3d& p) { return nearer(p, false); }, 1.01, kNear);
  expectColours(
      combine(clay_, other, Combination::intersect), [&](const Vec3d& p) { return nearer(p, true); }, 1.01, kNear);
  expectColours(
      combine(clay_, other, Combination::cut),
      [&](const Vec3d& p) { return p.norm() - 8 > 5.3 - (p - centre).norm() ? twoColours(p) : kGreen; }, 1.01, kNear);
  expectColours(
      combine(clay_, other, Combination::join, {.blendMm = 2, .threads = 2}),
      [&](const Vec3d& p) { return nearer(p, false); }, 1.51, kNear);
  // One without any takes those of the other.
  const Version plain = sphere(Store::make(), Vec3d::Zero(), 8);
  expectColours(
      combine(plain, other, Combination::join),
      [&](const Vec3d& p) { return p.norm() - 8 < (p - centre).norm() - 5.3 ? ChannelBytes{} : kGreen; }, 1.01, kNear);
}

TEST_F(WholeChannels, MaterialsOfTheSecondGetOtherNumbers) {
  const Vec3d centre(6, 5.3, 0);
  const Version other = painted(sphere(Store::make(), centre, 5.3), [](const Vec3d&) { return kGreen; });
  ChannelBytes becomes = kGreen;
  becomes[indexOf(Channel::material)] = 9;
  const Rule rule = [&](const Vec3d& p) { return p.norm() - 8 < (p - centre).norm() - 5.3 ? twoColours(p) : becomes; };
  expectColours(combine(clay_, other, Combination::join, {.materials = {0, 7, 8, 9}}), rule, 1.01, 2.5);
}

// Creases and thin places, where values are made anew after channels were carried: no voxel of the band is left
// without.
TEST_F(WholeChannels, NoVoxelIsLeftOutAtCreases) {
  const auto store = Store::make();
  const Rule green = [](const Vec3d&) { return kGreen; };
  Version clay = makeBlock(store, clay_.grid(), Vec3d::Zero(), Vec3d(9, 8, 7), 0);
  clay = combine(clay, sphere(Store::make(), Vec3d(3, 4, 2), 4.5), Combination::cut);
  clay = combine(clay, makeBlock(Store::make(), clay_.grid(), Vec3d(4, -3, 0), Vec3d(5, 1.2, 9), 0), Combination::join);
  clay = painted(clay, green);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.rotate(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  Grid fine;
  fine.voxelMm = 0.26;
  for (const Version& result :
       {resample(clay, fine, pose, 2), offset(clay, 0.8, 2), offset(clay, -0.3, 2), shell(clay, 0.8, 0.8, 2),
        smoothAll(clay, 1, true, 2), mirrorHalf(clay, Vec3d(0.3, 0, 0), Vec3d(1, 0.4, 0.2), 2),
        combine(clay, resample(clay, clay.grid(), pose, 2), Combination::join)})
    expectColours(result, green, 0);
}

TEST_F(WholeChannels, PartsThatGoTakeTheirsAlong) {
  const Version crumb = painted(sphere(Store::make(), Vec3d(30, 0, 0), 2), [](const Vec3d&) { return kGreen; });
  const Version both = combine(clay_, crumb, Combination::join);
  EXPECT_TRUE(both.find(Channel::cover, Coord{7, 0, 0}) != ChannelSlot() || both.has(Channel::cover));
  expectColours(removeCrumbs(both, 100).version, twoColours, 0);
}

}  // namespace
}  // namespace argil::clay
