// Moulds of two halves: what comes off and what does not.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/mould/best_pull.h"
#include "clay/mould/mould.h"
#include "clay/mould/parting_surface.h"
#include "clay/mould/pull_faces.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/deform.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::bandFaults;
using testing::clayVolume;
using testing::expectClosed;

const WorkPart kNobodyWaits(nullptr);

Grid grid(double voxelMm = 1) {
  Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = Vec3d(0.13, -0.2, 0.07);
  return grid;
}
Version ball(const Vec3d& at, double radius, double voxelMm = 1) {
  return makeSphere(Store::make(), grid(voxelMm), at, radius);
}
Version rod(const Vec3d& from, const Vec3d& to, double radius, double voxelMm = 1) {
  return makeRod(Store::make(), grid(voxelMm), from, to, radius);
}
Version block(const Vec3d& at, const Vec3d& size, double voxelMm = 1) {
  return makeBlock(Store::make(), grid(voxelMm), at, size, 0);
}
Version turned(const Version& version, const Eigen::Matrix3d& turn) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = turn;
  return resample(version, version.grid(), pose);
}
Eigen::Matrix3d tilt(double degrees, const Vec3d& about) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, about.normalized()).toRotationMatrix();
}

// Balls, rods and blocks, joined and taken away.
Version anything(unsigned seed) {
  std::mt19937 random(seed);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  const auto place = [&](double reach) { return Vec3d(in(-reach, reach), in(-reach, reach), in(-reach, reach)); };
  Version clay = ball(Vec3d::Zero(), in(6, 9));
  for (int i = 0; i < 6; ++i) {
    const Vec3d at = place(9);
    const Version other = i % 3 == 0   ? ball(at, in(3, 7))
                          : i % 3 == 1 ? rod(at, at + place(14) + Vec3d(0, 0, 4), in(2, 4))
                                       : block(at, Vec3d(in(4, 12), in(4, 12), in(4, 12)));
    clay = combine(clay, other, i == 4 ? Combination::cut : Combination::join);
  }
  return clay;
}

MouldOptions bare(double wallMm = 6) {
  MouldOptions options;
  options.pull = Vec3d::UnitZ();
  options.wallMm = wallMm;
  options.keys = options.vents = false;
  options.sprueMm = 0;
  return options;
}

// Visits the voxels of a box around a mould.
template <class Visit>
void forEachVoxel(const Mould& mould, const Visit& visit) {
  BoxMm box = boundsOf(mould.upper);
  const BoxMm other = boundsOf(mould.lower);
  const Grid& grid = mould.upper.grid();
  const Vec3d low = grid.toVoxel(box.low.cwiseMin(other.low)), high = grid.toVoxel(box.high.cwiseMax(other.high));
  for (int x = int(std::floor(low.x())); x <= int(high.x()) + 1; ++x)
    for (int y = int(std::floor(low.y())); y <= int(high.y()) + 1; ++y)
      for (int z = int(std::floor(low.z())); z <= int(high.z()) + 1; ++z) visit(Vec3d(x, y, z));
}

// How deep what moves along z is in what stays, voxels, in 64 steps to where it is clear of it.
double deepestOnTheWay(const Version& moved, double way, const Version& stays) {
  const BoxMm box = boundsOf(moved);
  const double far = (box.high.z() - box.low.z()) / moved.grid().voxelMm;
  std::vector<Vec3d> inside;
  std::vector<double> deep;
  Sampler of(moved), in(stays);
  const Grid& grid = moved.grid();
  const Vec3d low = grid.toVoxel(box.low), high = grid.toVoxel(box.high);
  for (int x = int(low.x()); x <= int(high.x()) + 1; ++x)
    for (int y = int(low.y()); y <= int(high.y()) + 1; ++y)
      for (int z = int(low.z()); z <= int(high.z()) + 1; ++z)
        if (const auto phi = double(of.trilinear({double(x), double(y), double(z)})); phi < 0)
          inside.emplace_back(x, y, z), deep.push_back(-phi);
  EXPECT_FALSE(inside.empty());
  double deepest = 0;
  for (int step = 1; step <= 64; ++step)
    for (size_t i = 0; i < inside.size(); ++i)
      deepest =
          std::max(deepest, std::min(deep[i], -double(in.trilinear(inside[i] + Vec3d(0, 0, way * far * step / 64)))));
  return deepest;
}

// Mould

TEST(Mould, HalvesComeApartWhateverTheClay) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Version clay = anything(seed);
    MouldOptions options;
    options.wallMm = 10;
    options.ventMm = 3;
    options.clearanceMm = 0.2;
    if (seed % 2 == 0) options.pull = Vec3d(0.3, -0.2, 1);
    const Mould mould = makeMould(clay, options, 2, kNobodyWaits);
    const Version here = turned(clay, mould.turn);
    EXPECT_LE(deepestOnTheWay(mould.upper, 1, mould.lower), 0.1) << seed;
    EXPECT_LE(deepestOnTheWay(mould.upper, 1, here), 0.1) << seed;
    EXPECT_LE(deepestOnTheWay(mould.lower, -1, here), 0.1) << seed;
    EXPECT_GE(mould.sprues, 1);
    const auto faults = bandFaults(mould.upper);
    EXPECT_EQ(faults.besideTile, 0u) << seed;
    EXPECT_LE(faults.steepest, 1.8) << seed;
    expectClosed(mould.upper, 0);
    expectClosed(mould.lower, 0);
  }
}

TEST(Mould, WhatIsInNeitherHalfIsWhatHasClayAboveAndBelow) {
  for (unsigned seed = 11; seed <= 16; ++seed) {
    const Version clay = anything(seed);
    const Mould mould = makeMould(clay, bare(), 2, kNobodyWaits);
    Sampler of(clay), up(mould.upper), down(mould.lower);
    const BoxMm box = boundsOf(clay);
    const int low = int(std::floor(clay.grid().toVoxel(box.low).z())) - 2,
              high = int(clay.grid().toVoxel(box.high).z()) + 2;
    uint64_t gaps = 0, both = 0, wrong = 0, all = 0;
    const double edge = 6;  // voxels of the block's wall: its outer faces are not looked at
    forEachVoxel(mould, [&](const Vec3d& p) {
      const Vec3d mm = clay.grid().toWorld(p);
      if (((mm - box.low).array() < 1 - edge).any() || ((box.high - mm).array() < 1 - edge).any()) return;
      ++all;
      double above = 9, below = 9;
      for (int z = low; z <= high; ++z) {
        const auto phi = double(of.trilinear({p.x(), p.y(), double(z)}));
        if (z >= p.z()) above = std::min(above, phi);
        if (z <= p.z()) below = std::min(below, phi);
      }
      const double cast = std::max(above, below), half = double(std::min(up.trilinear(p), down.trilinear(p)));
      both += up.trilinear(p) < -0.6f && down.trilinear(p) < -0.6f;
      wrong += cast < -0.6 && half < 0;
      gaps += cast > 0.6 && half > 0.6;
    });
    EXPECT_GT(all, 10000u);
    EXPECT_EQ(both, 0u) << seed;
    EXPECT_EQ(wrong, 0u) << seed;
    EXPECT_EQ(gaps, 0u) << seed;
  }
}

TEST(Mould, OfABallIsCutAtItsEquator) {
  const Version clay = ball({1, 2, 3}, 20, 0.5);
  const Mould mould = makeMould(clay, bare(), 2, kNobodyWaits);
  EXPECT_LT(mould.steepestDegrees, 3);
  EXPECT_LT(mould.undercutMm3, 0.5);
  EXPECT_NEAR(boundsOf(mould.lower).high.z(), 3, 0.6);
  EXPECT_NEAR(boundsOf(mould.upper).low.z(), 3, 0.6);
  const BoxMm box = boundsOf(clay);
  const double outer = (box.high - box.low + Vec3d::Constant(12)).prod() / 0.125;
  EXPECT_NEAR((clayVolume(mould.upper) + clayVolume(mould.lower) + clayVolume(clay)) / outer, 1, 1e-3);
}

// Beside the crease where the clay meets the surface between the halves distances are to the crease, and where that
// surface is steep they are to it and not along the pull.
TEST(Mould, HalvesHoldDistances) {
  const Version clay = ball({1, 2, 3}, 20, 0.5);
  const Mould cut = makeMould(clay, bare(), 2, kNobodyWaits);
  Sampler up(cut.upper);
  const auto at = [&](double out, double below) {
    return double(up.trilinear(clay.grid().toVoxel({1 + 20 + 0.5 * out, 2, 3 - 0.5 * below})));
  };
  EXPECT_NEAR(at(-1.5, 1.5), std::hypot(1.5, 1.5), 0.3);
  EXPECT_NEAR(at(-1, 2), std::hypot(1, 2), 0.3);
  EXPECT_NEAR(at(4, 1), 1, 0.1);

  const Version askew = rod({-20, 0, -17}, {20, 0, 17}, 5, 0.5);  // 40° to the horizontal
  const Mould mould = makeMould(askew, bare(), 2, kNobodyWaits);
  EXPECT_GT(mould.steepestDegrees, 30);
  Sampler over(mould.upper);
  std::vector<double> slopes;
  for (double x = -10; x <= 10; x += 0.5) {
    // Two millimetres beside the rod: up to where the upper half begins.
    for (double z = -20; z < 20; z += 0.05) {
      const Vec3d p = askew.grid().toVoxel({x, 7, z});
      if (over.trilinear(p) >= 0) continue;
      Vec3d gradient;
      for (int axis = 0; axis < 3; ++axis)
        gradient[axis] =
            (double(over.trilinear(p + Vec3d::Unit(axis))) - double(over.trilinear(p - Vec3d::Unit(axis)))) / 2;
      slopes.push_back(gradient.norm());
      break;
    }
  }
  ASSERT_GT(slopes.size(), 30u);
  std::sort(slopes.begin(), slopes.end());
  EXPECT_NEAR(slopes[slopes.size() / 2], 1, 0.05);
}

// Of a block of more columns than are solved heights between are interpolated; what has clay on one side goes by that.
TEST(Mould, NothingIsMissingWhereHeightsAreInterpolated) {
  Version clay = block(Vec3d::Zero(), Vec3d(1040, 6, 4));
  for (int i = 0; i < 12; ++i) {
    // A zigzag that is thin and steep.
    const double x = 526 + 1.5 * i, z = i % 2 == 0 ? -6 : 6;
    clay = combine(clay, rod({x, -3, z}, {x, 3, z}, 2), Combination::join);
    clay = combine(clay, rod({x, 0, z}, {x + 1.5, 0, -z}, 2), Combination::join);
  }
  const Mould mould = makeMould(clay, bare(), 2, kNobodyWaits);
  Sampler of(clay), up(mould.upper), down(mould.lower);
  uint64_t gaps = 0, all = 0;
  for (int x = 500; x < 548; ++x)
    for (int y = -6; y <= 6; ++y)
      for (int z = -12; z <= 12; ++z) {
        double above = 9, below = 9;
        for (int k = -20; k <= 20; ++k) {
          const auto phi = double(of.trilinear({double(x), double(y), double(k)}));
          (k >= z ? above : below) = std::min(k >= z ? above : below, phi);
          if (k == z) below = std::min(below, phi);
        }
        ++all;
        const Vec3d p(x, y, z);
        gaps += std::max(above, below) > 0.8 && double(std::min(up.trilinear(p), down.trilinear(p))) > 0.8;
      }
  EXPECT_GT(all, 10000u);
  EXPECT_EQ(gaps, 0u);
}

TEST(Mould, FillsWhatIsUndercutAndSaysHowMuch) {
  // A bore that ends in the block, across the pull.
  const Version clay =
      combine(block(Vec3d::Zero(), Vec3d(40, 30, 30), 0.5), rod({-5, 0, 0}, {30, 0, 0}, 6, 0.5), Combination::cut);
  const Mould mould = makeMould(clay, bare(), 2, kNobodyWaits);
  const double bore = std::numbers::pi * 36 * 25;
  EXPECT_NEAR(mould.undercutMm3 / bore, 1, 0.01);
  // Along the bore nothing is undercut.
  MouldOptions along = bare();
  along.pull = Vec3d::UnitX();
  EXPECT_NEAR(makeMould(clay, along, 2, kNobodyWaits).undercutMm3 / bore, 0, 0.002);
  // A hollow that nothing leads into is filled too.
  const Version hollow = shell(ball(Vec3d::Zero(), 15), 4, 0);
  const double inner = clayVolume(ball(Vec3d::Zero(), 15)) - clayVolume(hollow);
  EXPECT_NEAR(makeMould(hollow, bare(), 2, kNobodyWaits).undercutMm3 / inner, 1, 0.01);
}

TEST(Mould, TheHalvesHaveTheClaysOwnFaces) {
  const Version clay = ball(Vec3d::Zero(), 16, 0.5);
  MouldOptions options = bare();
  options.pull = Vec3d(0.2, 0.5, 1);
  const Mould mould = makeMould(clay, options, 2, kNobodyWaits);
  EXPECT_LT((mould.turn * options.pull->normalized() - Vec3d::UnitZ()).norm(), 1e-9);
  Sampler up(mould.upper), down(mould.lower);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2.0 * i + 1) / 2000, r = std::sqrt(1 - z * z), turn = 2.4 * i;
    if (std::abs(z) < 0.1) continue;
    const Vec3d p(16 * r * std::cos(turn), 16 * r * std::sin(turn), 16 * z);
    most = std::max(most, std::abs(double((z > 0 ? up : down).trilinear(clay.grid().toVoxel(p)))));
  }
  EXPECT_LT(most, 0.05);
}

TEST(Mould, KeysFitWithTheirClearanceAndInOneWayOnly) {
  const Version clay = ball({1, 2, 3}, 14, 0.5);
  MouldOptions options = bare(12);
  options.keys = true;
  options.clearanceMm = 0.6;
  const Mould mould = makeMould(clay, options, 2, kNobodyWaits);
  ASSERT_EQ(mould.keys, 4);
  const Grid& grid = clay.grid();
  const BoxMm box = boundsOf(clay);
  Sampler up(mould.upper), down(mould.lower);
  // From the middle of the wall's corner upwards: how high the key is, and its hole.
  std::vector<double> heights;
  for (int corner = 0; corner < 4; ++corner) {
    Vec3d at = box.low - Vec3d::Constant(6);
    if (corner & 1) at.x() = box.high.x() + 6;
    if (corner & 2) at.y() = box.high.y() + 6;
    double key = 0, hole = 0;
    for (double z = 3; z < 12; z += 0.05) {
      const Vec3d p = grid.toVoxel({at.x(), at.y(), z});
      if (down.trilinear(p) < 0) key = z;
      if (up.trilinear(p) > 0) hole = z;
    }
    // Sideways, half way up.
    double wide = 0, free = 0;
    for (double x = 0; x < 6; x += 0.05) {
      const Vec3d p = grid.toVoxel({at.x() + x, at.y(), (3 + key) / 2});
      if (down.trilinear(p) < 0) wide = x;
      if (up.trilinear(p) > 0) free = x;
    }
    EXPECT_NEAR(free - wide, 0.6, 0.2);
    heights.push_back(key - 3);
    EXPECT_NEAR(hole - key, 0.6, 0.15);
    EXPECT_GT(key - 3, 1);
  }
  EXPECT_NEAR(heights[0] / heights[3], 0.75, 0.1);
  EXPECT_NEAR(heights[1] / heights[3], 1, 0.1);
  // Where the wall has no room for them there are none.
  options.wallMm = 4;
  EXPECT_EQ(makeMould(clay, options, 2, kNobodyWaits).keys, 0);
}

TEST(Mould, ASprueOnTheHighestPeakAndVentsOnTheOthers) {
  Version clay = block(Vec3d::Zero(), Vec3d(50, 20, 10), 0.5);
  clay = combine(clay, rod({-18, 0, 0}, {-18, 0, 20}, 4, 0.5), Combination::join);
  clay = combine(clay, rod({18, 0, 0}, {18, 0, 14}, 4, 0.5), Combination::join);
  clay = combine(clay, rod({0, 0, 0}, {0, 0, 5.7}, 4, 0.5), Combination::join);  // too low to catch air
  MouldOptions options = bare();
  options.sprueMm = 5;
  options.vents = true;
  options.ventMm = 2;
  const Mould mould = makeMould(clay, options, 2, kNobodyWaits);
  EXPECT_EQ(mould.sprues, 1);
  EXPECT_EQ(mould.vents, 1);
  Sampler up(mould.upper);
  const auto open = [&](double x, double from) {
    for (double z = from; z < 40; z += 0.5)
      if (up.trilinear(clay.grid().toVoxel({x, 0, z})) < 0) return false;
    return true;
  };
  EXPECT_TRUE(open(-18, 20));
  EXPECT_TRUE(open(18, 14));
  EXPECT_FALSE(open(0, 6));
  // Without a sprue the highest peak has a vent as well.
  options.sprueMm = 0;
  EXPECT_EQ(makeMould(clay, options, 2, kNobodyWaits).vents, 2);
}

TEST(Mould, IsTheSameForAnyCountOfThreads) {
  const Version clay = anything(5);
  MouldOptions options;
  options.wallMm = 8;
  options.ventMm = 3;
  const Mould one = makeMould(clay, options, 1, kNobodyWaits);
  for (const int threads : {2, 5}) {
    const Mould other = makeMould(clay, options, threads, kNobodyWaits);
    EXPECT_EQ(other.upper.hash(), one.upper.hash());
    EXPECT_EQ(other.lower.hash(), one.lower.hash());
    EXPECT_EQ(other.undercutMm3, one.undercutMm3);
  }
}

TEST(Mould, SaysWhatIsOutOfRange) {
  const Version clay = ball(Vec3d::Zero(), 8);
  const auto refuses = [&](const std::function<void(MouldOptions&)>& change) {
    MouldOptions options;
    options.ventMm = 3;
    change(options);
    EXPECT_THROW((void)makeMould(clay, options, 1, kNobodyWaits), Error);
  };
  refuses([](MouldOptions& o) { o.wallMm = 3; });
  refuses([](MouldOptions& o) { o.wallMm = NAN; });
  refuses([](MouldOptions& o) { o.clearanceMm = -1; });
  refuses([](MouldOptions& o) { o.sprueMm = 2; });
  refuses([](MouldOptions& o) { o.ventMm = 1; });
  refuses([](MouldOptions& o) { o.pull = Vec3d::Zero(); });
  refuses([](MouldOptions& o) { o.pull = Vec3d(NAN, 0, 1); });
  EXPECT_THROW((void)makeMould(Version::empty(Store::make(), grid()), bare(), 1, kNobodyWaits), Error);
  Job job;
  job.cancel();
  EXPECT_THROW((void)makeMould(clay, bare(), 1, WorkPart(&job)), Cancelled);
}

// PartingHeights

TEST(PartingHeights, AreAMembraneBetweenItsBounds) {
  // Two pins hold a square at heights 10 and 30: between them heights rise steadily, nowhere beyond.
  MouldColumns columns;
  columns.width = 81, columns.height = 41;
  columns.bottom.assign(81 * 41, NAN);
  columns.top = columns.bottom;
  const auto pin = [&](int x, float from, float to) {
    for (int y = 0; y < 41; ++y) columns.bottom[columns.index(x, y)] = from, columns.top[columns.index(x, y)] = to;
  };
  pin(20, 10, 10);
  pin(60, 30, 30);
  pin(40, 5, 12);  // lower than a straight line would be
  const std::vector<float> heights = partingHeights(columns, kNobodyWaits);
  for (int x = 0; x < 81; ++x) {
    const double exact = x <= 20 ? 10 : x <= 40 ? 10 + 0.1 * (x - 20) : x <= 60 ? 12 + 0.9 * (x - 40) : 30;
    EXPECT_NEAR(heights[columns.index(x, 20)], exact, 0.05) << x;
  }
}

// PullFaces

TriangleMesh meshOf(const Version& version) {
  Surface surface(false);
  (void)surface.update(version, 2);
  return surface.toMesh();
}

// Möller and Trumbore's test, of every triangle.
bool somethingOn(const TriangleMesh& mesh, const Vec3d& from, const Vec3d& way) {
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t[0]], ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
    const Vec3d p = way.cross(ac);
    const double det = ab.dot(p);
    if (std::abs(det) < 1e-14) continue;
    const double u = (from - a).dot(p) / det;
    const Vec3d q = (from - a).cross(ab);
    const double v = way.dot(q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && ac.dot(q) / det > 0) return true;
  }
  return false;
}

TEST(PullFaces, AreWhatRaysSay) {
  size_t faces = 0, other = 0, undercut = 0;
  for (unsigned seed = 21; seed <= 24; ++seed) {
    const TriangleMesh mesh = meshOf(anything(seed));
    const Vec3d pull = Vec3d(0.1 * seed, 1, 0.7).normalized();
    const PullFaces found = pullFaces(mesh, pull, 0.1, 2, 2);
    ASSERT_EQ(found.sides.size(), mesh.triangles.size());
    double areas = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      const Vec3d a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      const Vec3d normal = (b - a).cross(c - a);
      areas += normal.norm() / 2;
      const double along = normal.normalized().dot(pull), way = along < 0 ? -1 : 1;
      const auto free = [&](double sign) {
        return !somethingOn(mesh, (a + b + c) / 3 + 0.1 * normal.normalized(), sign * pull);
      };
      const PullSide own = way < 0 ? PullSide::lower : PullSide::upper,
                     opposite = way < 0 ? PullSide::upper : PullSide::lower;
      const PullSide expected = free(way)                                 ? own
                                : std::abs(along) <= 0.0175 && free(-way) ? opposite
                                                                          : PullSide::undercut;
      ++faces;
      other += found.sides[i] != expected;
      undercut += expected == PullSide::undercut;
    }
    EXPECT_NEAR(found.upperMm2 + found.lowerMm2 + found.undercutMm2, areas, 1e-6 * areas);
  }
  EXPECT_GT(undercut, faces / 50);
  EXPECT_LE(double(other), 1e-4 * double(faces));
}

TEST(PullFaces, DraftOfConesIsTheirAngle) {
  for (const double degrees : {1.0, 3.0, 10.0}) {
    const double tangent = std::tan(degrees * std::numbers::pi / 180), height = 30;
    const Version cone = makeCone(Store::make(), grid(0.5), Vec3d::Zero(), 20, 20 - height * tangent, height);
    const TriangleMesh mesh = meshOf(cone);
    const PullFaces faces = pullFaces(mesh, Vec3d::UnitZ(), 0.05, 0, 2);
    size_t walls = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      const Vec3d a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      if (std::max({std::abs(a.z()), std::abs(b.z()), std::abs(c.z())}) > height / 2 - 2) continue;
      ++walls;
      EXPECT_NEAR(faces.drafts[i], degrees, 0.5);
    }
    EXPECT_GT(walls, 1000u);
    // Its wall has less draft than a degree more, and no less than a degree less.
    const double wall = std::numbers::pi * (40 - height * tangent) * height / std::cos(std::atan(tangent));
    EXPECT_NEAR(pullFaces(mesh, Vec3d::UnitZ(), 0.05, degrees + 1, 2).steepMm2 / wall, 1, 0.08);
    EXPECT_NEAR(pullFaces(mesh, Vec3d::UnitZ(), 0.05, degrees - 0.6, 2).steepMm2 / wall, 0, 0.05);
  }
}

TEST(PullFaces, AWallThatStandsUprightComesOffEitherWay) {
  // The walls of a bore that ends in the block: something lies above them, and nothing below.
  const TriangleMesh bored = meshOf(
      combine(block(Vec3d::Zero(), Vec3d(30, 30, 30), 0.5), rod({0, 0, -30}, {0, 0, 4}, 6, 0.5), Combination::cut));
  const PullFaces walls = pullFaces(bored, Vec3d::UnitZ(), 0.05, 1, 2);
  EXPECT_LT(walls.undercutMm2, 1e-3 * walls.upperMm2);

  const TriangleMesh mesh = meshOf(turned(block(Vec3d::Zero(), Vec3d(20, 24, 30)), tilt(30, Vec3d::UnitZ())));
  const PullFaces faces = pullFaces(mesh, Vec3d::UnitZ(), 0.1, 1, 2);
  EXPECT_LT(faces.undercutMm2, 1e-3 * (faces.upperMm2 + faces.lowerMm2));
}

// An upright prism or a frustum of `sides` sides, closed, in triangles as large as its faces, or in rings of them.
TriangleMesh prism(int sides, double low, double high, double height, int rings = 1) {
  TriangleMesh mesh;
  const auto n = static_cast<uint32_t>(sides);
  for (int ring = 0; ring <= rings; ++ring)
    for (uint32_t i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n, share = double(ring) / rings,
                   radius = low + share * (high - low);
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), share * height);
    }
  const auto top = static_cast<uint32_t>(rings) * n;
  for (uint32_t ring = 0; ring < top; ring += n)
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t j = (i + 1) % n;
      mesh.triangles.push_back({ring + i, ring + j, ring + n + i});
      mesh.triangles.push_back({ring + j, ring + n + j, ring + n + i});
    }
  for (uint32_t i = 2; i < n; ++i) {
    mesh.triangles.push_back({0, i, i - 1});
    mesh.triangles.push_back({top, top + i - 1, top + i});
  }
  return mesh;
}

TEST(PullFaces, CapsAndChamfersAreNoPartOfAWallsDraft) {
  for (const int sides : {3, 4, 8, 9, 32, 100})
    for (const int rings : {1, 5}) {
      SCOPED_TRACE(sides);
      const double side = 2 * 15 * std::sin(std::numbers::pi / sides);
      const PullFaces upright = pullFaces(prism(sides, 15, 15, 25, rings), Vec3d::UnitZ(), 0.003, 2, 2);
      EXPECT_NEAR(upright.steepMm2, sides * side * 25, 1e-6 * upright.upperMm2);
      // 3° where 2° are asked for is enough, 1° is not, and a kink from one to the other is none of either.
      const double inwards3 = 25 * std::tan(3 * std::numbers::pi / 180) / std::cos(std::numbers::pi / sides);
      const double inwards1 = 25 * std::tan(1 * std::numbers::pi / 180) / std::cos(std::numbers::pi / sides);
      EXPECT_EQ(pullFaces(prism(sides, 15, 15 - inwards3, 25, rings), Vec3d::UnitZ(), 0.003, 2, 2).steepMm2, 0);
      const TriangleMesh steep = prism(sides, 15, 15 - inwards1, 25, rings);
      const double walls =
          (15 + 15 - inwards1) * std::sin(std::numbers::pi / sides) * sides * 25 / std::cos(std::numbers::pi / 180);
      EXPECT_NEAR(pullFaces(steep, Vec3d::UnitZ(), 0.003, 2, 2).steepMm2 / walls, 1, 1e-3);
      // A cone of 3° on an upright prism: the prism's walls alone.
      TriangleMesh kinked = prism(sides, 15, 15, 50, 2);
      for (uint32_t i = 0; i < uint32_t(sides); ++i)
        kinked.positions[2 * uint32_t(sides) + i].head<2>() *= (15 - inwards3) / 15;
      EXPECT_NEAR(pullFaces(kinked, Vec3d::UnitZ(), 0.003, 2, 2).steepMm2 / (sides * side * 25), 1, 1e-6);
    }
}

TEST(PullFaces, CornersThatLieOffByLessThanTheSlackAreNoUndercut) {
  std::mt19937 random(7);
  for (const double noise : {0.0005, 0.001, 0.002})
    for (const int rings : {1, 3, 20}) {
      TriangleMesh mesh = prism(48, 10, 10, 30, rings);
      for (Vec3d& p : mesh.positions)
        for (int k = 0; k < 3; ++k) p[k] += std::uniform_real_distribution<double>(-noise, noise)(random);
      const PullFaces faces = pullFaces(mesh, Vec3d::UnitZ(), 3.5 * noise, 1, 2);
      EXPECT_EQ(faces.undercutMm2, 0) << noise << ", " << rings << " rings";
      EXPECT_NEAR(faces.steepMm2 / (2 * std::numbers::pi * 10 * 30), 1, 0.01);
    }
  // A groove of 0.05 mm around is one.
  TriangleMesh groove = prism(48, 10, 10, 30, 3);
  for (uint32_t i = 48; i < 96; ++i) groove.positions[i].head<2>() *= 9.95 / 10;
  EXPECT_GT(pullFaces(groove, Vec3d::UnitZ(), 0.003, 1, 2).undercutMm2, 100);
}

// BestPull

TEST(BestPull, IsTheAxisOfARingHoweverItLies) {
  const Version ring = makeTorus(Store::make(), grid(), Vec3d::Zero(), 20, 5);
  for (const Eigen::Matrix3d& turn :
       {tilt(0, Vec3d::UnitX()), tilt(90, Vec3d::UnitX()), tilt(37, Vec3d(1, 2, 0.3)), tilt(71, Vec3d(-1, 0.4, 2))}) {
    const BestPull best = bestPull(meshOf(turned(ring, turn)), 1, 2, kNobodyWaits);
    EXPECT_GT(std::abs(best.pull.dot(turn.col(2))), std::cos(1.5 * std::numbers::pi / 180));
    EXPECT_LT(best.undercutShare, 0.01);
  }
}

TEST(BestPull, LeadsAlongABore) {
  const Version drilled =
      combine(block(Vec3d::Zero(), Vec3d(30, 30, 30)), rod({-30, 0, 0}, {30, 0, 0}, 8), Combination::cut);
  EXPECT_GT(std::abs(bestPull(meshOf(drilled), 1, 2, kNobodyWaits).pull.x()), 0.999);
  EXPECT_THROW((void)bestPull({}, 1, 1, kNobodyWaits), Error);
}

TEST(BestPull, OfABallIsUpwards) {
  EXPECT_EQ(bestPull(meshOf(ball(Vec3d::Zero(), 15)), 1, 2, kNobodyWaits).pull, Vec3d(Vec3d::UnitZ()));
}

}  // namespace
}  // namespace argil::clay
