// Disks laid flat.

#include "clay/unwrap/flatten.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::clay {
namespace {

using std::numbers::pi;

/// A grid of n × m quads, two triangles each, over a map of the unit square.
template <class Map>
SurfaceDisk grid(int n, int m, const Map& map) {
  SurfaceDisk disk;
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) disk.positions.push_back(map(double(i) / n, double(j) / m));
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      disk.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      disk.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  for (int i = 0; i < n; ++i) disk.boundary.push_back(at(i, 0));
  for (int j = 0; j < m; ++j) disk.boundary.push_back(at(n, j));
  for (int i = n; i > 0; --i) disk.boundary.push_back(at(i, m));
  for (int j = m; j > 0; --j) disk.boundary.push_back(at(0, j));
  return disk;
}

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// No triangle is turned over, and all together are as large as on the surface.
void expectWhole(const SurfaceDisk& disk, const FlatDisk& flat) {
  double surface = 0, plane = 0;
  for (const auto& t : disk.triangles) {
    const Vec3d &a = disk.positions[t[0]], &b = disk.positions[t[1]], &c = disk.positions[t[2]];
    surface += 0.5 * (b - a).cross(c - a).norm();
    const double area = 0.5 * cross(flat.places[t[1]] - flat.places[t[0]], flat.places[t[2]] - flat.places[t[0]]);
    ASSERT_GT(area, 0);
    plane += area;
  }
  EXPECT_NEAR(plane / surface, 1, 1e-9);
}

TEST(Flatten, WhatCanBeUnrolledKeepsItsLengths) {
  const auto plane = [](double u, double v) { return Vec3d(30 * u + 5 * v, 10 * v, 3 * u - v); };
  const auto tube = [](double u, double v) {
    const double angle = 1.9 * pi * u;
    return Vec3d(10 * std::cos(angle), 10 * std::sin(angle), 40 * v);
  };
  for (const SurfaceDisk& disk : {grid(12, 7, plane), grid(40, 16, tube)}) {
    const auto flat = laidFlat(disk, 100);
    ASSERT_TRUE(flat);
    expectWhole(disk, *flat);
    EXPECT_LT(flat->stretch, 1 + 1e-4);
    EXPECT_FALSE(crossesItself(flat->places, disk.boundary));
    for (size_t i = 0; i < disk.boundary.size(); ++i) {
      const uint32_t a = disk.boundary[i], b = disk.boundary[(i + 1) % disk.boundary.size()];
      EXPECT_NEAR((flat->places[a] - flat->places[b]).norm() / (disk.positions[a] - disk.positions[b]).norm(), 1, 0.02);
    }
  }
}

// Half a ball, as equal areas have it: singular values cos(t/2) and its inverse, RMS 1.035. Less is possible, not 1.
TEST(Flatten, HalfABallIsStretchedAsLittleAsItComes) {
  const SurfaceDisk disk = grid(24, 24, [](double u, double v) {
    // From a square to a disk, and up on the ball.
    const double x = 2 * u - 1, y = 2 * v - 1, dx = x * std::sqrt(1 - y * y / 2), dy = y * std::sqrt(1 - x * x / 2);
    const double r = std::min(1.0, std::hypot(dx, dy)), t = 0.5 * pi * r, s = r > 0 ? std::sin(t) / r : 0.5 * pi;
    return Vec3d(10 * s * dx, 10 * s * dy, 10 * std::cos(t));
  });
  const auto flat = laidFlat(disk, 100);
  ASSERT_TRUE(flat);
  expectWhole(disk, *flat);
  EXPECT_LT(flat->stretch, 1.045);
  EXPECT_GT(flat->stretch, 1.01);
  EXPECT_FALSE(crossesItself(flat->places, disk.boundary));
  const auto early = laidFlat(disk, 2);
  ASSERT_TRUE(early);
  EXPECT_GT(early->stretch, flat->stretch) << "more rounds stretch less";
}

TEST(Flatten, WithoutAreaThereIsNone) {
  SurfaceDisk disk = grid(3, 3, [](double u, double v) { return Vec3d(u, v, 0); });
  disk.positions[5] = disk.positions[6];
  EXPECT_FALSE(laidFlat(disk, 10));
}

TEST(Flatten, AnOutlineThatPassesOverItselfIsFound) {
  const std::vector<uint32_t> four = {0, 1, 2, 3};
  EXPECT_FALSE(crossesItself({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, four));
  EXPECT_TRUE(crossesItself({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, four));
  // A comb whose last tooth reaches into the first: by its first and last side, too.
  EXPECT_TRUE(crossesItself({{0, 0}, {4, 0}, {4, 2}, {-1, 1}, {2, -1}}, {0, 1, 2, 3, 4}));
  EXPECT_FALSE(crossesItself({{0, 0}, {4, 0}, {4, 2}, {1, 1}, {0, 2}}, {0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace argil::clay
