// Distances farther than the band: against shapes whose distances are known, and clay that was worked on.

#include "clay/field/distance_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/kernels/foot_kernels.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr float kReach = 14;  // voxels

struct Error {
  double rms = 0, worst = 0;
  size_t count = 0;
};

// Voxels of 1 mm; `exact` in voxels; boxes of odd sizes that cut the shape anywhere.
Error errorOn(const Version& version, const std::function<double(const Vec3d&)>& exact, double low, double high) {
  DistanceBox box;
  Error error;
  double sum = 0;
  const int edge = 37;
  for (int x = -2; x < 2; ++x)
    for (int y = -2; y < 2; ++y)
      for (int z = -2; z < 2; ++z) {
        const Coord first{x * edge, y * edge, z * edge};
        if (!box.fill(version, first, {edge, edge, edge}, {kReach, kReach})) continue;
        for (int i = 0; i < edge * edge * edge; ++i) {
          const Coord v = first + Coord{i / (edge * edge), i / edge % edge, i % edge};
          const double wanted = exact(version.grid().toWorld(v.toVec3d()));
          if (wanted < low || wanted > high) continue;
          const double off = std::abs(double(box.at(v)) - wanted);
          sum += off * off;
          error.worst = std::max(error.worst, off);
          ++error.count;
        }
      }
  error.rms = std::sqrt(sum / double(std::max<size_t>(error.count, 1)));
  return error;
}

Grid grid() {
  Grid grid;
  grid.voxelMm = 1;
  grid.originMm = Vec3d(0.3, -0.2, 0.1);
  return grid;
}

double ball(const Vec3d& p, const Vec3d& centre, double r) {
  return (p - centre).norm() - r;
}
double block(const Vec3d& p, const Vec3d& half) {
  const Vec3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

struct Shape {
  const char* name;
  Version version;
  std::function<double(const Vec3d&)> exact;
  double low, high, rms, worst;
};

TEST(DistanceBox, DistancesAreThoseOfKnownShapes) {
  const Vec3d aside(14, 3, -2), half(31, 22, 17);
  const auto sphere = [](double r, const Vec3d& at = Vec3d::Zero()) {
    return makeSphere(Store::make(), grid(), at, r);
  };
  const auto twoBalls = [&](const Vec3d& p) { return std::pair(ball(p, Vec3d::Zero(), 25), ball(p, aside, 22)); };
  const Version first = sphere(25), second = sphere(22, aside);
  const Shape shapes[] = {
      {"ball of 40", sphere(40), [](const Vec3d& p) { return ball(p, Vec3d::Zero(), 40); }, -13, 13, 0.0005, 0.005},
      {"ball of 8, outside", sphere(8), [](const Vec3d& p) { return ball(p, Vec3d::Zero(), 8); }, 1.5, 13, 0.001,
       0.006},
      {"ball of 8, inside", sphere(8), [](const Vec3d& p) { return ball(p, Vec3d::Zero(), 8); }, -7.5, -1.5, 0.002,
       0.01},
      {"ball of 4, outside", sphere(4), [](const Vec3d& p) { return ball(p, Vec3d::Zero(), 4); }, 1.5, 13, 0.002,
       0.012},
      {"block, outside", makeBlock(Store::make(), grid(), Vec3d::Zero(), 2 * half, 0),
       [&](const Vec3d& p) { return block(p, half); }, 1.5, 13, 0.015, 0.11},
      {"block, inside", makeBlock(Store::make(), grid(), Vec3d::Zero(), 2 * half, 0),
       [&](const Vec3d& p) { return block(p, half); }, -13, -1.5, 0.005, 0.1},
      {"ring", makeTorus(Store::make(), grid(), Vec3d::Zero(), 30, 10),
       [](const Vec3d& p) { return std::hypot(std::hypot(p.x(), p.y()) - 30, p.z()) - 10; }, -9.5, 13, 0.001, 0.03},
      {"two balls joined, outside", combine(first, second, Combination::join),
       [&](const Vec3d& p) { return std::min(twoBalls(p).first, twoBalls(p).second); }, 1.5, 13, 0.003, 0.1},
      {"two balls met, inside", combine(first, second, Combination::intersect),
       [&](const Vec3d& p) { return std::max(twoBalls(p).first, twoBalls(p).second); }, -13, -1.5, 0.005, 0.1},
  };
  for (const Shape& shape : shapes) {
    const Error error = errorOn(shape.version, shape.exact, shape.low, shape.high);
    std::printf("%-26s %8zu voxels, off by %.4f RMS, %.3f at most\n", shape.name, error.count, error.rms, error.worst);
    EXPECT_GT(error.count, 1000u);
    EXPECT_LT(error.rms, shape.rms) << shape.name;
    EXPECT_LT(error.worst, shape.worst) << shape.name;
  }
}

// Of boxes that the surface does not enter, too.
TEST(DistanceBox, DistancesAreRightUpToTheirReach) {
  const Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 40);
  DistanceBox box;
  int outside = 0;
  for (const float reach : {4.3f, 9.0f, 13.9f})
    for (int low = -60; low < 60; low += 5) {
      if (!box.fill(clay, {low, -7, 4}, {5, 11, 9}, {reach, reach})) continue;
      for (int i = 0; i < 5 * 11 * 9; ++i) {
        const Coord v = Coord{low, -7, 4} + Coord{i / 99, i / 9 % 11, i % 9};
        const double exact = ball(clay.grid().toWorld(v.toVec3d()), Vec3d::Zero(), 40);
        ASSERT_NEAR(box.at(v), std::clamp(exact, -double{reach}, double{reach}), 0.005) << low << " " << reach;
        outside += std::abs(exact) > reach - 1 && std::abs(exact) < reach;
      }
    }
  EXPECT_GT(outside, 1000);
}

TEST(DistanceBox, APlaceHasTheSameDistanceInEveryBox) {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 20);
  for (const Vec3d& at : {Vec3d(17, 3, 6), Vec3d(-9, 12, 10), Vec3d(2, -19, -5)})
    clay = combine(clay, makeSphere(Store::make(), grid(), at, 8), Combination::cut);
  DistanceBox one, other;
  const DistanceBox::Reach reach{kReach, kReach, true};
  ASSERT_TRUE(one.fill(clay, {-30, -30, -30}, {60, 60, 60}, reach));
  int feet = 0, voxels = 0;
  for (const Coord low : {Coord{-21, -3, 2}, Coord{3, 1, -16}, Coord{-2, -25, -11}}) {
    ASSERT_TRUE(other.fill(clay, low, {19, 22, 13}, reach));
    for (int i = 0; i < 19 * 22 * 13; ++i) {
      const Coord v = low + Coord{i / (22 * 13), i / 13 % 22, i % 13};
      ASSERT_NEAR(one.at(v), other.at(v), 1e-4) << v.x << " " << v.y << " " << v.z;
      ++voxels;
      feet += std::abs(one.at(v)) < kReach && one.foot(v) == other.foot(v);
    }
  }
  EXPECT_GT(feet, 0.9 * voxels);  // Of places that are equally near either may be it, and a voxel's rim is near.
}

TEST(DistanceBox, HasEqualBitsOnEverySimdTarget) {
  const Version ball = makeSphere(Store::make(), grid(), Vec3d(1, 2, 3), 19);
  std::vector<float> first;
  tests::forEachSimdTarget([&](const std::string& name) {
    DistanceBox box;
    ASSERT_TRUE(box.fill(ball, {-3, -2, -30}, {40, 30, 34}, {kReach, kReach}));
    std::vector<float> now;
    for (int i = 0; i < 40 * 30 * 34; ++i)
      now.push_back(box.at(Coord{-3 + i / (30 * 34), -2 + i / 34 % 30, -30 + i % 34}));
    if (first.empty()) first = now;
    EXPECT_EQ(now, first) << name;
  });
}

// Clay that was worked on has bounds beyond 1.5 voxels, too small by half here: they give way to what is measured.
TEST(DistanceBox, WhatIsNoDistanceGivesWay) {
  const Version ball40 = makeSphere(Store::make(), grid(), Vec3d::Zero(), 40);
  Editor editor(ball40);
  ball40.forEachBrick([&](const Brick& brick) {
    BrickValues room;
    std::array<float, kBrickVoxels> values;
    std::copy_n(brick.values(room), kBrickVoxels, values.begin());
    for (float& phi : values)
      if (std::abs(phi) > 1.5f && std::abs(phi) < 2.9f) phi = std::copysign(1.5f + (std::abs(phi) - 1.5f) / 2, phi);
    editor.setVoxels(brick.coord, values);
  });
  const Version clay = editor.commit();
  const auto exact = [](const Vec3d& p) { return ball(p, Vec3d::Zero(), 40); };
  const Error beside = errorOn(clay, exact, 1.9, 2.5), beyond = errorOn(clay, exact, 3, 8);
  std::printf("off by %.3f RMS, %.3f at most; beyond the band %.3f, %.3f\n", beside.rms, beside.worst, beyond.rms,
              beyond.worst);
  EXPECT_GT(beside.count, 1000u);
  EXPECT_LT(beside.rms, 0.2);  // 0.26 if they stayed; splines at 1.5 voxels see them too
}

TEST(DistanceBox, BeyondTheReachAllHasTheReach) {
  const Version ball20 = makeSphere(Store::make(), grid(), Vec3d::Zero(), 20);
  DistanceBox box;
  ASSERT_TRUE(box.fill(ball20, {16, 0, 0}, {40, 16, 16}, {6, 6}));
  for (int i = 0; i < 40 * 16 * 16; ++i) {
    const Coord v{16 + i / 256, i / 16 % 16, i % 16};
    const double exact = ball(ball20.grid().toWorld(v.toVec3d()), Vec3d::Zero(), 20);
    if (exact > 6.1) {
      ASSERT_EQ(box.at(v), 6) << v.x << " " << v.y << " " << v.z;
    } else {
      ASSERT_NEAR(box.at(v), std::clamp(exact, -6.0, 6.0), 0.01) << v.x << " " << v.y << " " << v.z;
    }
  }
  EXPECT_FALSE(box.fill(ball20, {64, 0, 0}, {16, 16, 16}, {6, 6}));
  EXPECT_EQ(box.uniform(), Tile::outside);
}

TEST(NearestPoints, AreThoseOfEachVoxel) {
  std::mt19937 random(7);
  PointRoom wide, narrow;
  for (const double spread : {3.0, 12.0, 40.0})
    for (const size_t count : {1u, 7u, 64u, 700u}) {
      std::normal_distribution<float> place(0, float(spread));
      std::vector<float> x, y, z;
      for (size_t i = 0; i < count; ++i)
        x.push_back(place(random)), y.push_back(place(random)), z.push_back(place(random));
      for (std::vector<float>* each : {&x, &y, &z}) each->resize(count + kBrickEdge, 0);
      const auto half = uint32_t(count / 2), all = uint32_t(count);
      const std::vector<PointRange> ranges{{half, all}, {0, half}};
      const float low[3] = {-5, 2, 0.25f}, middle[3] = {-1.5f, 5.5f, 3.75f};
      uint32_t first = kNoPoint, nearest[kBrickVoxels];
      float best = 1e30f;
      for (const PointRange& range : ranges) nearestOf({x.data(), y.data(), z.data()}, range, middle, best, first);
      ASSERT_LT(first, count);
      std::fill(std::begin(nearest), std::end(nearest), kNoPoint);
      const uint64_t rows = random() | uint64_t{random()} << 32;
      nearestPoints({x.data(), y.data(), z.data()}, ranges, first, low, rows, wide, narrow, nearest);
      for (int v = 0; v < kBrickVoxels; ++v) {
        if (!(rows >> (v / 8) & 1)) continue;
        const auto apart = [&](size_t i) {
          const float dx = x[i] - (low[0] + float(v >> 6)), dy = y[i] - (low[1] + float((v >> 3) & 7)),
                      dz = z[i] - (low[2] + float(v & 7));
          return dx * dx + dy * dy + dz * dz;
        };
        float least = apart(0);
        for (size_t i = 1; i < count; ++i) least = std::min(least, apart(i));
        ASSERT_LT(nearest[v], count);
        ASSERT_LE(apart(nearest[v]), least * 1.0001f + 1e-4f) << "voxel " << v << " of " << count << " points";
      }
    }
}

}  // namespace
}  // namespace argil::clay
