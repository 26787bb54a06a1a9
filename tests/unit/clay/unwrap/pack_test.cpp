// Shapes side by side in a square.

#include "clay/unwrap/pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "clay/base/error.h"
#include "clay/unwrap/compact.h"

namespace argil::clay {
namespace {

using std::numbers::pi;

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A fan of triangles around its first place.
struct Shape {
  std::vector<Vec2d> places;
  std::vector<std::array<uint32_t, 3>> triangles;
};

Shape star(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> part(0.4, 1);
  Shape shape;
  shape.places.push_back(Vec2d::Zero());
  constexpr int kPoints = 9;
  const double wide = part(random);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * pi * i / kPoints, r = size * part(random);
    shape.places.push_back(Vec2d(r * std::cos(angle), wide * r * std::sin(angle)));
    shape.triangles.push_back({0, uint32_t(i + 1), uint32_t((i + 1) % kPoints + 1)});
  }
  return shape;
}

/// Four corners.
Shape rectangle(double width, double height) {
  return {{{0, 0}, {width, 0}, {width, height}, {0, height}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// Two long thin spikes at a right angle, so that others may cross them far from all corners.
Shape spikes(double length) {
  return {{{0, 0}, {length, 0.2}, {0.5, 0.5}, {0.2, length}}, {{0, 1, 2}, {0, 2, 3}}};
}

std::vector<FlatShape> flat(const std::vector<Shape>& shapes) {
  std::vector<FlatShape> out;
  for (const Shape& each : shapes) out.push_back({&each.places, &each.triangles});
  return out;
}

double areaOf(const std::vector<Shape>& shapes) {
  double area = 0;
  for (const Shape& each : shapes)
    for (const auto& t : each.triangles)
      area += 0.5 * cross(each.places[t[1]] - each.places[t[0]], each.places[t[2]] - each.places[t[0]]);
  return area;
}

double toSegment(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

/// By outlines: all inside, none nearer to another than the margin nor across it. `fan`: the first place is inside.
void expectApart(const std::vector<Shape>& shapes, const Packing& packing, double margin, bool fan) {
  EXPECT_NEAR(packing.covered, areaOf(shapes) / (packing.sideMm * packing.sideMm), 1e-12);
  std::vector<std::vector<Vec2d>> outlines;
  for (size_t i = 0; i < shapes.size(); ++i) {
    const Eigen::Rotation2Dd turn(packing.placed[i].turn);
    std::vector<Vec2d> outline;
    for (size_t k = fan ? 1 : 0; k < shapes[i].places.size(); ++k) {
      outline.push_back((turn * shapes[i].places[k] + packing.placed[i].moveMm) / packing.sideMm);
      EXPECT_GE(outline.back().minCoeff(), 0.5 * margin - 1e-9);
      EXPECT_LE(outline.back().maxCoeff(), 1 - 0.5 * margin + 1e-9);
    }
    outlines.push_back(outline);
  }
  for (size_t a = 0; a < outlines.size(); ++a)
    for (size_t b = 0; b < outlines.size(); ++b)
      for (size_t k = 0; a != b && k < outlines[a].size(); ++k)
        for (size_t j = 0; j < outlines[b].size(); ++j) {
          const Vec2d &p = outlines[a][k], &p2 = outlines[a][(k + 1) % outlines[a].size()], &q = outlines[b][j],
                      &q2 = outlines[b][(j + 1) % outlines[b].size()];
          ASSERT_GE(toSegment(p, q, q2), margin - 1e-9) << a << " and " << b;
          ASSERT_FALSE(cross(p2 - p, q - p) * cross(p2 - p, q2 - p) < 0 &&
                       cross(q2 - q, p - q) * cross(q2 - q, p2 - q) < 0)
              << a << " across " << b;
        }
}

TEST(Pack, NoneIsNearerThanTheMarginAndAllAreInside) {
  std::mt19937 random(3);
  for (int round = 0; round < 4; ++round) {
    std::vector<Shape> shapes;
    const int count = round == 0 ? 1 : 3 * round + 2;
    for (int i = 0; i < count; ++i) shapes.push_back(star(random, round == 3 && i > 0 ? 2 : 10));
    constexpr double kMargin = 1.0 / 128;
    const Packing packing = packed(flat(shapes), kMargin, 2, WorkPart(nullptr));
    EXPECT_GT(packing.covered, 0.4);
    expectApart(shapes, packing, kMargin, true);
  }
}

TEST(Pack, SpikesDoNotCross) {
  const std::vector<Shape> shapes(12, spikes(10));
  expectApart(shapes, packed(flat(shapes), 1.0 / 512, 2, WorkPart(nullptr)), 1.0 / 512, false);
}

// What is placed one after the other leaves gaps, which pushing closes.
TEST(Pack, ShapesArePushedTogether) {
  std::mt19937 random(11);
  std::vector<Shape> shapes;
  for (int i = 0; i < 15; ++i) shapes.push_back(star(random, i % 3 == 0 ? 10 : 6));
  const std::vector<FlatShape> all = flat(shapes);
  // In rows of four, with room between them.
  Packing loose;
  loose.sideMm = 96;
  for (int i = 0; i < 15; ++i) loose.placed.push_back({0.1 * i, Vec2d(12 + 24 * (i % 4), 12 + 24 * (i / 4))});
  loose.covered = areaOf(shapes) / (loose.sideMm * loose.sideMm);
  constexpr double kMargin = 1.0 / 512;
  expectApart(shapes, loose, kMargin, true);
  const Packing once = compacted(all, {loose}, kMargin, 1, WorkPart(nullptr));
  expectApart(shapes, once, kMargin, true);
  EXPECT_GT(once.covered, 7 * loose.covered);
  EXPECT_GT(packed(all, kMargin, 2, WorkPart(nullptr)).covered, 0.74) << "0.72 without turns";
  for (const int threads : {2, 5}) {
    const Packing again = compacted(all, {loose}, kMargin, threads, WorkPart(nullptr));
    EXPECT_EQ(again.sideMm, once.sideMm);
    for (size_t i = 0; i < all.size(); ++i) EXPECT_EQ(again.placed[i].moveMm, once.placed[i].moveMm);
  }
  Job job;
  job.cancel();
  EXPECT_THROW((void)compacted(all, {loose}, kMargin, 2, WorkPart(&job)), Cancelled);
}

// Nothing goes in better than squares side by side: they stay.
TEST(Pack, APackingNeverBecomesWorse) {
  const std::vector<Shape> shapes(16, rectangle(10, 10));
  constexpr double kMargin = 1.0 / 512;
  Packing full;
  full.sideMm = 40 / (1 - 4 * kMargin);
  const double apart = 10 + kMargin * full.sideMm;
  for (int i = 0; i < 16; ++i)
    full.placed.push_back({0, Vec2d::Constant(0.5 * kMargin * full.sideMm) + apart * Vec2d(i % 4, i / 4)});
  full.covered = 1600 / (full.sideMm * full.sideMm);
  const Packing after = compacted(flat(shapes), {full}, kMargin, 2, WorkPart(nullptr));
  EXPECT_LE(after.sideMm, full.sideMm);
  expectApart(shapes, after, kMargin, false);
}

// A needle of 1 : 100 000 beside a star: the square is as wide as it is long, and no more memory is taken for it.
TEST(Pack, ANeedleGoesIn) {
  std::mt19937 random(5);
  const std::vector<Shape> shapes = {star(random, 3), rectangle(1e4, 0.1)};
  const Packing packing = packed(flat(shapes), 1.0 / 512, 1, WorkPart(nullptr));
  EXPECT_GT(packing.sideMm, 7000);
  EXPECT_LT(packing.sideMm, 12000);
}

// Specks beside a large one have the margin of the square around them, thousands of times as wide as they are.
TEST(Pack, SpecksGoInAndTakeNoMemory) {
  std::mt19937 random(6);
  std::vector<Shape> shapes = {star(random, 1000), star(random, 500)};
  for (int i = 0; i < 20; ++i) shapes.push_back(star(random, 1e-4));
  const Packing packing = packed(flat(shapes), 1.0 / 512, 2, WorkPart(nullptr));
  EXPECT_GT(packing.covered, 0.3);
  expectApart(shapes, packing, 1.0 / 512, true);
}

// Ten times as many take no more than a hundred times as long: pairs are looked at, not all their points.
TEST(Pack, TwoHundredGoIn) {
  std::mt19937 random(8);
  std::vector<Shape> shapes;
  for (int i = 0; i < 200; ++i) shapes.push_back(star(random, i % 5 == 0 ? 10 : 4));
  const auto begin = std::chrono::steady_clock::now();
  const Packing packing = packed(flat(shapes), 1.0 / 512, 2, WorkPart(nullptr));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(5));
  EXPECT_GT(packing.covered, 0.5);
  expectApart(shapes, packing, 1.0 / 512, true);
}

TEST(Pack, WithoutAnAreaThereIsNone) {
  const std::vector<Shape> shapes = {{{{0, 0}, {1, 0}, {2, 0}}, {{0, 1, 2}}}};
  EXPECT_THROW((void)packed(flat(shapes), 0.01, 1, WorkPart(nullptr)), Error);
}

// Sixteen squares fill a square but for what margins take.
TEST(Pack, SquaresLieSideBySide) {
  std::vector<Shape> shapes;
  for (int i = 0; i < 16; ++i) {
    Shape shape = rectangle(10, 10);
    for (Vec2d& p : shape.places) p = Eigen::Rotation2Dd(0.3 * i) * p;
    shapes.push_back(shape);
  }
  EXPECT_GT(packed(flat(shapes), 1.0 / 512, 1, WorkPart(nullptr)).covered, 0.85);
}

}  // namespace
}  // namespace argil::clay
