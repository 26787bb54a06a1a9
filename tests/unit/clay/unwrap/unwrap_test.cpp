// Meshes of quads cut into charts, laid out on a picture, and what is baked into it.

#include "clay/unwrap/unwrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "clay/base/error.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/fit_quads.h"
#include "clay/field/primitives.h"
#include "clay/mesh/reduce.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/unwrap/bake.h"
#include "clay/unwrap/charts.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid(double voxelMm = 0.5) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

std::array<Vec3d, 4> cornersOf(const QuadMesh& mesh, size_t quad) {
  const auto& q = mesh.quads[quad];
  return {mesh.positions[q[0]], mesh.positions[q[1]], mesh.positions[q[2]], mesh.positions[q[3]]};
}

/// A ball, a ring, a ball with arms, a block with a hole, two bodies.
const std::vector<QuadMesh>& meshes() {
  static const std::vector<QuadMesh> made = []() -> std::vector<QuadMesh> {
    const auto cage = [](const Version& version, size_t quads) {
      return coarseCage(version, quads, WorkPart(nullptr)).mesh;
    };
    const auto store = [] { return Store::make(); };
    Version arms = makeSphere(store(), grid(), Vec3d::Zero(), 10);
    for (const Vec3d& way : {Vec3d(20, 3, 0), Vec3d(-4, 18, 2), Vec3d(0, -5, 19)})
      arms = combine(arms, makeRod(store(), grid(), Vec3d::Zero(), way, 3), Combination::join);
    Version holed = makeBlock(store(), grid(), Vec3d::Zero(), {30, 20, 10}, 1);
    holed = combine(holed, makeCylinder(store(), grid(), Vec3d::Zero(), 5, 20), Combination::cut);
    const Version two = combine(makeSphere(store(), grid(), {-15, 0, 0}, 8), makeSphere(store(), grid(), {15, 0, 0}, 5),
                                Combination::join);
    return {cage(makeSphere(store(), grid(), Vec3d::Zero(), 10), 24),
            cage(makeTorus(store(), grid(), Vec3d::Zero(), 12, 4), 300), cage(arms, 400), cage(holed, 300),
            cage(two, 200)};
  }();
  return made;
}

// Each pixel of the picture belongs to one triangle at most, none is turned over, charts keep their distance.
TEST(Unwrap, NothingIsFoldedNorLiesOnAnything) {
  for (const QuadMesh& mesh : meshes()) {
    const UvMap map = unwrapped(mesh, {}, WorkPart(nullptr));
    ASSERT_EQ(map.corners.size(), mesh.quads.size());
    EXPECT_LE(map.charts, 15u);
    EXPECT_LE(map.stretch, 1.05);
    EXPECT_GE(map.stretch, 1);
    EXPECT_GT(map.covered, 0.4) << mesh.quads.size() << " " << map.charts;
    constexpr int kPixels = 1024;
    std::vector<int> owner(size_t(kPixels) * kPixels, -1);
    std::vector<uint32_t> vertexOf(map.places.size(), UINT32_MAX);
    std::set<uint32_t> charts;
    double covered = 0, stretch = 0, surface = 0;
    for (size_t f = 0; f < mesh.quads.size(); ++f) {
      charts.insert(map.chart[f]);
      for (size_t k = 0; k < 4; ++k) {
        uint32_t& vertex = vertexOf[map.corners[f][k]];
        ASSERT_TRUE(vertex == UINT32_MAX || vertex == mesh.quads[f][k]) << "a place of two vertices";
        vertex = mesh.quads[f][k];
        ASSERT_GE(map.places[map.corners[f][k]].minCoeff(), 0);
        ASSERT_LE(map.places[map.corners[f][k]].maxCoeff(), 1);
      }
      const std::array<Vec3d, 4> corners = cornersOf(mesh, f);
      for (const auto& t : trianglesOf(corners)) {
        const std::array<Vec2d, 3> p = {map.places[map.corners[f][t[0]]], map.places[map.corners[f][t[1]]],
                                        map.places[map.corners[f][t[2]]]};
        const double area = 0.5 * cross(p[1] - p[0], p[2] - p[0]);
        ASSERT_GT(area, 0) << "turned over";
        covered += area;
        // How lengths grow from the picture to the surface, by its own sum.
        const Vec3d b = corners[t[1]] - corners[t[0]], c = corners[t[2]] - corners[t[0]];
        const Vec2d u = p[1] - p[0], v = p[2] - p[0];
        const Vec3d alongX = (b * v.y() - c * u.y()) / (2 * area), alongY = (c * u.x() - b * v.x()) / (2 * area);
        const double own = 0.5 * b.cross(c).norm();
        stretch += own * (alongX.squaredNorm() + alongY.squaredNorm()) / 2;
        surface += own;
        const auto low = [&](int axis) { return std::min({p[0][axis], p[1][axis], p[2][axis]}) * kPixels; };
        const auto high = [&](int axis) { return std::max({p[0][axis], p[1][axis], p[2][axis]}) * kPixels; };
        for (int y = std::max(0, int(low(1))); y <= std::min(kPixels - 1, int(high(1))); ++y)
          for (int x = std::max(0, int(low(0))); x <= std::min(kPixels - 1, int(high(0))); ++x) {
            const Vec2d q((x + 0.5) / kPixels, (y + 0.5) / kPixels);
            constexpr double kIn = 1e-12;
            if (cross(p[1] - p[0], q - p[0]) < kIn || cross(p[2] - p[1], q - p[1]) < kIn ||
                cross(p[0] - p[2], q - p[2]) < kIn)
              continue;
            ASSERT_EQ(owner[size_t(y) * kPixels + size_t(x)], -1) << "two on one place";
            owner[size_t(y) * kPixels + size_t(x)] = int(map.chart[f]);
          }
      }
    }
    EXPECT_EQ(charts.size(), map.charts);
    EXPECT_NEAR(covered, map.covered, 1e-6);
    EXPECT_NEAR(std::sqrt(stretch / surface * covered / surface), map.stretch, 1e-6);
    EXPECT_NEAR(map.mmOfSide, std::sqrt(surface / covered), 1e-6 * map.mmOfSide);
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x + 1 < kPixels; ++x) {
        const int a = owner[size_t(y) * kPixels + size_t(x)], b = owner[size_t(y) * kPixels + size_t(x) + 1];
        ASSERT_TRUE(a == b || a < 0 || b < 0) << "charts side by side";
      }
  }
}

TEST(Unwrap, TheSameAgainAndFewerWhereMoreStretchIsAllowed) {
  const QuadMesh mesh = meshes()[2];
  const UvMap once = unwrapped(mesh, {.threads = 1}, WorkPart(nullptr));
  for (const int threads : {1, 2, 5}) {
    const UvMap again = unwrapped(mesh, {.threads = threads}, WorkPart(nullptr));
    EXPECT_EQ(once.places, again.places) << threads;
    EXPECT_EQ(once.corners, again.corners) << threads;
    EXPECT_EQ(once.mmOfSide, again.mmOfSide) << threads;
  }
  const auto charts = [&](double stretch) { return chartsOf(mesh, stretch, 1, 2, WorkPart(nullptr)); };
  const std::vector<Chart> strict = charts(1.002), loose = charts(1.1);
  EXPECT_GT(strict.size(), loose.size());
  for (const Chart& each : strict) EXPECT_LE(each.flat.stretch, 1.002);
  for (const Chart& each : loose) EXPECT_LE(each.flat.stretch, 1.1);
}

// A coil of three turns can be unrolled without stretch, but then lies on itself.
TEST(Unwrap, WhatWouldLieOnItselfIsCut) {
  Version coil = Version::empty(Store::make(), grid());
  const auto at = [](int step) {
    const double angle = step * 0.35;
    return Vec3d(14 * std::cos(angle), 14 * std::sin(angle), 1.1 * angle);
  };
  for (int i = 0; i < 54; ++i) {
    const Version rod = makeRod(Store::make(), grid(), at(i), at(i + 1), 2);
    coil = i == 0 ? rod : combine(coil, rod, Combination::join);
  }
  const QuadMesh mesh = coarseCage(coil, 600, WorkPart(nullptr)).mesh;
  for (const Chart& chart : chartsOf(mesh, 1.05, 1, 1, WorkPart(nullptr)))
    EXPECT_FALSE(crossesItself(chart.flat.places, chart.disk.boundary));
}

TEST(Unwrap, JoiningEndsWhereThereAreFewEnough) {
  for (const size_t few : {15, 9}) EXPECT_EQ(chartsOf(meshes()[2], 1.05, few, 1, WorkPart(nullptr)).size(), few);
}

TEST(Unwrap, WhatIsOpenOrAPointIsRefusedAndCancelledIsLeft) {
  QuadMesh mesh = meshes()[0];
  QuadMesh open = mesh;
  open.quads.pop_back();
  EXPECT_THROW((void)unwrapped(open, {}, WorkPart(nullptr)), Error);
  QuadMesh point = mesh;
  for (Vec3d& each : point.positions) each = Vec3d::Zero();
  EXPECT_THROW((void)unwrapped(point, {}, WorkPart(nullptr)), Error);
  Job job;
  job.cancel();
  EXPECT_THROW((void)unwrapped(mesh, {}, WorkPart(&job)), Cancelled);
}

// Quads drawn together into a point or a line: they take no room, and the rest is as it was.
TEST(Unwrap, QuadsWithoutAnAreaDoNoHarm) {
  for (const double keep : {0.0, 1e-15, 1e-6}) {
    QuadMesh mesh = meshes()[2];
    const Vec3d at = mesh.positions[mesh.quads[7][0]];
    for (const uint32_t v : mesh.quads[7]) mesh.positions[v] = at + keep * (mesh.positions[v] - at);
    const uint32_t from = mesh.quads[60][0];
    mesh.positions[mesh.quads[60][1]] = mesh.positions[from];
    const UvMap map = unwrapped(mesh, {}, WorkPart(nullptr));
    EXPECT_GT(map.covered, 0.4);
    EXPECT_LT(map.stretch, 1.06);
    for (const Vec2d& each : map.places) {
      ASSERT_TRUE(each.allFinite());
      ASSERT_GE(each.minCoeff(), 0);
      ASSERT_LE(each.maxCoeff(), 1);
    }
  }
}

// Of any quad, bent or not convex: two triangles that make it up and lie on its side, where that is possible.
TEST(Unwrap, AQuadIsCutAlongTheDiagonalThatKeepsBothTrianglesUpright) {
  const auto upright = [](const std::array<Vec3d, 4>& c) {
    double least = INFINITY;
    for (const auto& t : trianglesOf(c)) least = std::min(least, (c[t[1]] - c[t[0]]).cross(c[t[2]] - c[t[0]]).z());
    return least;
  };
  EXPECT_GT(upright({Vec3d(0, 0, 0), {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}), 0);
  // Corner 2 is drawn in: along 1 to 3 one triangle would be turned over, though that is shorter.
  EXPECT_GT(upright({Vec3d(0, 0, 0), {2, 0, 0}, {0.6, 0.6, 0}, {0, 2, 0}}), 0);
  EXPECT_GT(upright({Vec3d(2, 0, 0), {0.6, 0.6, 0}, {0, 2, 0}, {0, 0, 0}}), 0);
  // Where either does, the shorter one.
  const std::array<std::array<uint8_t, 3>, 2> across = {{{1, 2, 3}, {1, 3, 0}}};
  EXPECT_EQ(trianglesOf({Vec3d(-3, 0, 0), {0, -1, 0}, {3, 0, 0}, {0, 1, 0}}), across);
}

TEST(FitQuads, FlatQuadsLieAroundTheSurfaceAndNotInsideIt) {
  const Version ball = makeSphere(Store::make(), grid(), Vec3d::Zero(), 20);
  const CageMaker maker(ball, 150, false, 1, WorkPart(nullptr));
  QuadMesh mesh = maker.make(WorkPart(nullptr)).mesh;
  const auto rms = [&](const QuadMesh& quads) { return deviation(maker.surface(), trianglesOf(quads)).rmsMm; };
  const double before = rms(mesh);
  QuadMesh two = mesh;
  fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 1, WorkPart(nullptr));
  fitQuads(two, maker.surface(), maker.tree(), maker.creases(), 2, WorkPart(nullptr));
  EXPECT_EQ(mesh.positions, two.positions);
  EXPECT_LT(rms(mesh), 0.5 * before);
  double mean = 0;
  for (const Vec3d& p : mesh.positions) mean += (p.norm() - 20) / double(mesh.positions.size());
  EXPECT_GT(mean, 0) << "corners stand out a little";
}

// Whatever it begins with: never farther off than before.
TEST(FitQuads, NothingBecomesWorse) {
  const Version thin = combine(makeBlock(Store::make(), grid(), Vec3d::Zero(), {40, 30, 1.5}, 0),
                               makeSphere(Store::make(), grid(), {0, 0, 8}, 7), Combination::join);
  const CageMaker maker(thin, 60, false, 1, WorkPart(nullptr));
  const QuadMesh cage = maker.make(WorkPart(nullptr)).mesh;
  const auto off = [&](const QuadMesh& mesh) {
    double sum = 0;
    for (size_t f = 0; f < mesh.quads.size(); ++f)
      for (const double u : {1.0 / 6, 0.5, 5.0 / 6})
        for (const double v : {1.0 / 6, 0.5, 5.0 / 6}) {
          const std::array<Vec3d, 4> c = cornersOf(mesh, f);
          sum += maker.tree()
                     .nearest((1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + u * v * c[2] + (1 - u) * v * c[3])
                     .squared;
        }
    return sum;
  };
  std::mt19937 random(3);
  for (int round = 0; round < 12; ++round) {
    QuadMesh mesh = cage;
    std::uniform_real_distribution<double> shake(-2.0 * round, 2.0 * round);
    for (Vec3d& each : mesh.positions) each += Vec3d(shake(random), shake(random), shake(random));
    const double before = off(mesh);
    fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 1, WorkPart(nullptr));
    EXPECT_LE(off(mesh), before * (1 + 1e-9)) << round;
  }
}

// --- Baking.

struct Baked {
  Version version = makeSphere(Store::make(), grid(), {3, -2, 1}, 20);
  CageMaker maker{version, 200, false, 1, WorkPart(nullptr)};
  QuadMesh mesh = maker.make(WorkPart(nullptr)).mesh;
  UvMap map = unwrapped(mesh, {}, WorkPart(nullptr));
  UvFrames frames = framesOf(mesh, map);
  [[nodiscard]] BakedPictures at(int pixels, int threads) const {
    return baked(
        version, maker.surface(), maker.tree(), mesh, map, pixels,
        [&](uint32_t, const Vec3d& p) {
          return std::array<uint8_t, 3>{uint8_t(100 + 4 * (p.x() - 3)), uint8_t(100 + 4 * (p.y() + 2)),
                                        uint8_t(100 + 4 * (p.z() - 1))};
        },
        threads, WorkPart(nullptr));
  }
};

// Made once: seconds.
const Baked& theBall() {
  static const Baked ball;
  return ball;
}

TEST(Bake, PicturesSayWhatTheClayIsThere) {
  const Baked& ball = theBall();
  constexpr int kPixels = 256;
  const BakedPictures pictures = ball.at(kPixels, 2);
  EXPECT_EQ(pictures.missed, 0);
  EXPECT_GT(pictures.heightMm, 0.05);
  EXPECT_LT(pictures.heightMm, 2);
  size_t looked = 0;
  for (size_t f = 0; f < ball.mesh.quads.size(); ++f)
    for (const auto& t : trianglesOf(cornersOf(ball.mesh, f))) {
      std::array<Vec2d, 3> p;
      for (size_t k = 0; k < 3; ++k) p[k] = ball.map.places[ball.map.corners[f][t[k]]];
      for (int y = 0; y < kPixels; ++y)
        for (int x = 0; x < kPixels; ++x) {
          const Vec2d q((x + 0.5) / kPixels, 1 - (y + 0.5) / kPixels);
          const double whole = cross(p[1] - p[0], p[2] - p[0]);
          const double v = cross(q - p[0], p[2] - p[0]) / whole, w = cross(p[1] - p[0], q - p[0]) / whole;
          if (v < 1e-9 || w < 1e-9 || v + w > 1 - 1e-9) continue;
          const std::array<double, 3> weights = {1 - v - w, v, w};
          Vec3d at = Vec3d::Zero(), normal = at, tangent = at;
          for (size_t k = 0; k < 3; ++k) {
            const uint32_t place = ball.map.corners[f][t[k]];
            EXPECT_EQ(ball.frames.vertices[place], ball.mesh.quads[f][t[k]]);
            at += weights[k] * ball.mesh.positions[ball.mesh.quads[f][t[k]]];
            normal += weights[k] * ball.frames.normals[place];
            tangent += weights[k] * ball.frames.tangents[place];
          }
          normal.normalize();
          tangent = (tangent - normal * normal.dot(tangent)).normalized();
          const size_t i = size_t(y) * kPixels + size_t(x);
          const double height = (2.0 * pictures.heights[i] / 65535 - 1) * pictures.heightMm;
          const Vec3d there = at + height * normal, middle(3, -2, 1);
          ASSERT_NEAR((there - middle).norm(), 20, 0.02);
          const auto part = [&](size_t k) { return 2.0 * pictures.normals[3 * i + k] / 255 - 1; };
          const Vec3d said = part(0) * tangent + part(1) * normal.cross(tangent) + part(2) * normal;
          ASSERT_GT(said.normalized().dot((there - middle).normalized()), std::cos(0.02));
          for (int k = 0; k < 3; ++k)
            ASSERT_NEAR(pictures.colours[3 * i + size_t(k)], 100 + 4 * (there - middle)[k], 1.5);
          ++looked;
        }
    }
  EXPECT_GT(looked, size_t(0.9 * ball.map.covered * kPixels * kPixels));
}

TEST(Bake, TangentsFollowThePictureAndBelongToTheirNormals) {
  const Baked& ball = theBall();
  for (size_t i = 0; i < ball.map.places.size(); ++i) {
    EXPECT_NEAR(ball.frames.normals[i].norm(), 1, 1e-12);
    EXPECT_NEAR(ball.frames.tangents[i].norm(), 1, 1e-12);
    EXPECT_NEAR(ball.frames.normals[i].dot(ball.frames.tangents[i]), 0, 1e-12);
  }
  double mean = 0;
  for (size_t f = 0; f < ball.mesh.quads.size(); ++f)
    for (size_t k = 0; k < 4; ++k) {
      const uint32_t a = ball.map.corners[f][k], b = ball.map.corners[f][(k + 1) & 3];
      const Vec2d flat = (ball.map.places[b] - ball.map.places[a]).normalized();
      const Vec3d &n = ball.frames.normals[a], &t = ball.frames.tangents[a];
      const Vec3d way =
          (ball.mesh.positions[ball.mesh.quads[f][(k + 1) & 3]] - ball.mesh.positions[ball.mesh.quads[f][k]])
              .normalized();
      const double agree = Vec3d(flat.x() * t + flat.y() * n.cross(t)).dot(way);
      EXPECT_GT(agree, 0.5);
      mean += agree / double(4 * ball.mesh.quads.size());
    }
  EXPECT_GT(mean, 0.95);
}

TEST(Bake, TheSameForAnyThreadsAndOnBeyondTheCharts) {
  const Baked& ball = theBall();
  const BakedPictures one = ball.at(128, 1), two = ball.at(128, 2);
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.heights, two.heights);
  EXPECT_EQ(one.colours, two.colours);
  // What lies beside a chart's pixel is never the ground's grey.
  std::set<std::array<uint8_t, 3>> colours;
  for (size_t i = 0; i < one.heights.size(); ++i)
    colours.insert({one.colours[3 * i], one.colours[3 * i + 1], one.colours[3 * i + 2]});
  for (size_t f = 0; f < ball.mesh.quads.size(); ++f)
    for (const uint32_t corner : ball.map.corners[f]) {
      const Vec2d p = ball.map.places[corner];
      const int x = std::clamp(int(p.x() * 128), 0, 127), y = std::clamp(int((1 - p.y()) * 128), 0, 127);
      const size_t i = size_t(y) * 128 + size_t(x);
      const bool ground = one.colours[3 * i] == 128 && one.colours[3 * i + 1] == 128 && one.colours[3 * i + 2] == 128;
      EXPECT_FALSE(ground && one.normals[3 * i + 2] == 255 && one.normals[3 * i] == 128) << x << " " << y;
    }
  EXPECT_GT(colours.size(), 100u);
}

// A mesh that the clay is far from along no normal: told, and the nearest place is taken.
TEST(Bake, WhereTheNormalMeetsNothingTheNearestPlaceIsTaken) {
  const Baked& ball = theBall();
  QuadMesh far = ball.mesh;
  for (Vec3d& p : far.positions) p = Vec3d(3, -2, 1) + 2.5 * (p - Vec3d(3, -2, 1));
  const BakedPictures pictures =
      baked(ball.version, ball.maker.surface(), ball.maker.tree(), far, ball.map, 64, nullptr, 1, WorkPart(nullptr));
  EXPECT_EQ(pictures.missed, 1);
  EXPECT_TRUE(pictures.colours.empty());
  EXPECT_NEAR(pictures.heightMm, 30, 2);
}

}  // namespace
}  // namespace argil::clay
