#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "clay/mesh/triangulate.h"

namespace argil::clay {
namespace {

using Triangle = std::array<uint32_t, 3>;
using Polygon = std::vector<Vec3d>;

Polygon flat(std::initializer_list<std::pair<double, double>> corners) {
  Polygon polygon;
  for (const auto& [x, y] : corners) polygon.emplace_back(x, y, 0);
  return polygon;
}

Vec3d areaOf(const Polygon& polygon) {
  Vec3d sum = Vec3d::Zero();
  for (size_t i = 0; i < polygon.size(); ++i) sum += polygon[i].cross(polygon[(i + 1) % polygon.size()]) / 2;
  return sum;
}

// Sum of the triangles' areas, each without a sign: only where they neither overlap nor leave the polygon is it the
// polygon's own.
double coveredBy(const Polygon& polygon, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) sum += (polygon[b] - polygon[a]).cross(polygon[c] - polygon[a]).norm() / 2;
  return sum;
}

std::vector<Triangle> trianglesOf(const Polygon& polygon, bool expected = true) {
  std::vector<Triangle> triangles;
  Triangulator triangulator;
  EXPECT_EQ(triangulator.add(polygon, triangles), expected);
  EXPECT_EQ(triangles.size(), polygon.size() - 2);
  return triangles;
}

// From every first corner, since where a polygon begins must not matter, and turned into a plane that no axis lies in.
void expectCovered(Polygon polygon, double area) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Vec3d(1, -2, 0.7).normalized()));
  ASSERT_NEAR(areaOf(polygon).norm(), area, 1e-9 * area);
  for (const bool turned : {false, true}) {
    if (turned)
      for (Vec3d& p : polygon) p = turn * p + Vec3d(30, -70, 900);
    for (size_t first = 0; first < polygon.size(); ++first) {
      std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
      const std::vector<Triangle> triangles = trianglesOf(polygon);
      EXPECT_NEAR(coveredBy(polygon, triangles), area, 1e-9 * area) << "first corner " << first;
      const Vec3d normal = areaOf(polygon);
      for (const auto& [a, b, c] : triangles)
        EXPECT_GE((polygon[b] - polygon[a]).cross(polygon[c] - polygon[a]).dot(normal), -1e-9 * area * area);
    }
  }
}

TEST(Triangulate, ConvexPolygonsAreFans) {
  EXPECT_EQ(trianglesOf(flat({{0, 0}, {2, 0}, {2, 1}, {0, 1}})), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(trianglesOf(flat({{0, 0}, {2, 0}, {3, 1}, {2, 2}, {0, 2}})),
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(Triangulate, ConcavePolygonsAreCoveredOnce) {
  expectCovered(flat({{0, 0}, {4, 0}, {1, 1}, {0, 4}}), 4);                                  // a dart
  expectCovered(flat({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}), 3);                  // an L
  expectCovered(flat({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}), 7);  // a U
  expectCovered(flat({{0, 0}, {9, 0}, {9, 3}, {6, 1}, {5, 3}, {4, 1}, {3, 3}, {2, 1}, {0, 3}}),
                18);  // a comb
}

TEST(Triangulate, ASpiralIsCovered) {
  // A band of width 0.5 between r = 1 + t / 4 and half a unit more, of eight turns.
  Polygon outer, inner;
  for (int i = 0; i <= 400; ++i) {
    const double t = 0.125 * i, r = 1 + t / 4;
    outer.emplace_back((r + 0.5) * std::cos(t), (r + 0.5) * std::sin(t), 0);
    inner.emplace_back(r * std::cos(t), r * std::sin(t), 0);
  }
  Polygon spiral = outer;
  spiral.insert(spiral.end(), inner.rbegin(), inner.rend());
  EXPECT_NEAR(coveredBy(spiral, trianglesOf(spiral)), areaOf(spiral).norm(), 1e-8);
}

TEST(Triangulate, HolesBehindBridgesStayOpen) {
  // A square of 10 with a hole of 2, one with two holes on one bridge, and one whose bridge starts at a reflex corner.
  expectCovered(flat({{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}, {4, 4}, {4, 6}, {6, 6}, {6, 4}, {4, 4}}), 96);
  expectCovered(flat({{0, 0},
                      {10, 0},
                      {10, 10},
                      {0, 10},
                      {0, 0},
                      {1, 2},
                      {1, 3},
                      {2, 3},
                      {5, 5},
                      {5, 6},
                      {6, 6},
                      {6, 5},
                      {5, 5},
                      {2, 3},
                      {2, 2},
                      {1, 2}}),
                98);
  expectCovered(
      flat({{0, 0}, {10, 0}, {10, 10}, {5, 10}, {5, 5}, {3, 3}, {3, 2}, {2, 2}, {2, 3}, {3, 3}, {5, 5}, {0, 5}}),
      100 - 25 - 1);
}

TEST(Triangulate, CornersOnAnEdgeGetTrianglesWithArea) {
  const Polygon square = flat({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}});
  for (const auto& [a, b, c] : trianglesOf(square))
    EXPECT_GT((square[b] - square[a]).cross(square[c] - square[a]).z(), 0.5);
  const Polygon triangle = flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {0, 3}});
  for (const auto& [a, b, c] : trianglesOf(triangle))
    EXPECT_GT((triangle[b] - triangle[a]).cross(triangle[c] - triangle[a]).z(), 0.5);
}

TEST(Triangulate, PolygonsThatAreNearlyFlatAreCovered) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-0.05, 0.05);
  for (int round = 0; round < 50; ++round) {
    Polygon u = flat({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}});
    for (Vec3d& p : u) p.z() = off(random);
    // Seen from above the triangles cover the U, and nothing of its slot.
    double sum = 0;
    for (const auto& [a, b, c] : trianglesOf(u)) sum += std::abs((u[b] - u[a]).cross(u[c] - u[a]).z()) / 2;
    EXPECT_NEAR(sum, 7, 1e-9);
  }
}

TEST(Triangulate, RandomStarsAreCovered) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> radius(0.2, 1);
  for (int round = 0; round < 300; ++round) {
    Polygon star;
    const int corners = 4 + round % 97;
    for (int i = 0; i < corners; ++i) {
      const double r = radius(random), at = 2 * M_PI * i / corners;
      star.emplace_back(7 + r * std::cos(at), r * std::sin(at), 3);
    }
    double area = 0;
    for (int i = 0; i < corners; ++i)
      area += (star[i] - Vec3d(7, 0, 3)).cross(star[(i + 1) % corners] - Vec3d(7, 0, 3)).z() / 2;
    EXPECT_NEAR(coveredBy(star, trianglesOf(star)), area, 1e-9) << corners;
  }
}

// A wall around a random walk through a tree of unit squares: right angles, collinear corners, and places where it
// touches itself.
TEST(Triangulate, RandomMazesAreCovered) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    constexpr int kSide = 12;
    bool cell[kSide][kSide] = {};
    std::vector<std::array<int, 2>> grown{{kSide / 2, kSide / 2}};
    cell[kSide / 2][kSide / 2] = true;
    const auto filled = [&](int x, int y) { return x >= 0 && y >= 0 && x < kSide && y < kSide && cell[x][y]; };
    constexpr int kSteps[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    for (int tries = 0; tries < 400; ++tries) {
      const auto [x, y] = grown[random() % grown.size()];
      const auto& step = kSteps[random() % 4];
      const int nx = x + step[0], ny = y + step[1];
      if (nx < 1 || ny < 1 || nx >= kSide - 1 || ny >= kSide - 1 || filled(nx, ny)) continue;
      int beside = 0;
      for (const auto& side : kSteps) beside += filled(nx + side[0], ny + side[1]);
      if (beside != 1) continue;  // a tree has no holes
      cell[nx][ny] = true;
      grown.push_back({nx, ny});
    }
    // The walk keeps the cells to its left.
    int x = kSide / 2, y = kSide / 2;
    while (filled(x, y - 1)) --y;
    const int firstX = x, firstY = y;
    int direction = 0;
    Polygon polygon;
    do {
      polygon.emplace_back(x, y, 0);
      x += kSteps[direction][0], y += kSteps[direction][1];
      const auto ahead = [&](int turn) {
        constexpr int kLeft[4][2] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}};
        const int d = (direction + turn + 4) % 4;
        return filled(x + kLeft[d][0], y + kLeft[d][1]) &&
               !filled(x + kLeft[(d + 3) % 4][0], y + kLeft[(d + 3) % 4][1]);
      };
      for (const int turn : {1, 0, -1}) {
        if (!ahead(turn)) continue;
        direction = (direction + turn + 4) % 4;
        break;
      }
    } while (x != firstX || y != firstY || direction != 0);
    const double area = double(grown.size());
    ASSERT_NEAR(areaOf(polygon).z(), area, 1e-9);
    EXPECT_NEAR(coveredBy(polygon, trianglesOf(polygon)), area, 1e-9) << round;
  }
}

TEST(Triangulate, WhatCrossesItselfIsToldAndKeepsItsCount) {
  trianglesOf(flat({{0, 0}, {2, 2}, {2, 0}, {0, 2}}), false);                  // a bow tie
  trianglesOf(flat({{0, 0}, {4, 4}, {4, 0}, {1, 5}, {6, 3}, {0, 3}}), false);  // a tangle
}

TEST(Triangulate, NoSizeIsTooLargeOrTooSmall) {
  const Polygon dart = flat({{0, 0}, {4, 0}, {1, 1}, {0, 4}});
  const std::vector<Triangle> expected = trianglesOf(dart);
  for (const double size : {1e-300, 1e-40, 1e40, 1e300}) {
    Polygon sized = dart;
    for (Vec3d& p : sized) p *= size;
    EXPECT_EQ(trianglesOf(sized), expected) << size;
  }
}

TEST(Triangulate, WhatHasNoAreaIsCoveredByAnything) {
  trianglesOf(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}}));
  trianglesOf(flat({{1, 1}, {1, 1}, {1, 1}, {1, 1}}));
}

TEST(Triangulate, ManyCornersTakeLittleTime) {
  Polygon comb;  // 5 000 teeth
  for (int i = 0; i < 5'000; ++i) {
    comb.emplace_back(i, 0, 0);
    comb.emplace_back(i + 0.5, -50.0 - i % 7, 0);
  }
  comb.emplace_back(5e3, 10, 0), comb.emplace_back(0, 10, 0);
  EXPECT_NEAR(coveredBy(comb, trianglesOf(comb)), areaOf(comb).norm(), 1e-3);
}

}  // namespace
}  // namespace argil::clay
