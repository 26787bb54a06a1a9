// Quads along guides, and more of them where the clay is masked.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "clay/base/error.h"
#include "clay/cage/fit_cage.h"
#include "clay/cage/flat_quads.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

constexpr double kRadius = 20;

Grid grid() {
  Grid grid;
  grid.voxelMm = 0.5;
  return grid;
}
Version ball() {
  return makeSphere(Store::make(), grid(), {1, 2, 3}, kRadius);
}

// Round the ball, so far from its middle; ringAt: about a slanted axis.
GuideLoop ringAround(const Vec3d& axis, double height) {
  const Vec3d x = axis.unitOrthogonal(), y = axis.cross(x);
  const double radius = std::sqrt(kRadius * kRadius - height * height);
  GuideLoop loop;
  for (int i = 0; i < 90; ++i) {
    const double turn = 2 * std::numbers::pi * i / 90;
    loop.push_back(Vec3d(1, 2, 3) + height * axis + radius * (std::cos(turn) * x + std::sin(turn) * y));
  }
  return loop;
}
GuideLoop ringAt(double height) {
  return ringAround(Vec3d(1, 2, 2).normalized(), height);
}
double lengthOf(const GuideLoop& loop) {
  double length = 0;
  for (size_t i = 0; i < loop.size(); ++i) length += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return length;
}
double distanceTo(const GuideLoop& loop, const Vec3d& p) {
  double least = HUGE_VAL;
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec3d &a = loop[i], d = loop[(i + 1) % loop.size()] - a;
    least = std::min(least, (p - a - std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm());
  }
  return least;
}
// Of edges whose ends and middle lie on the curve.
double along(const QuadMesh& mesh, const GuideLoop& loop, double off) {
  double length = 0;
  const QuadTopology topology(mesh);
  for (const auto& edge : topology.edges()) {
    const Vec3d &a = mesh.positions[edge.from], &b = mesh.positions[edge.to];
    if (distanceTo(loop, a) < off && distanceTo(loop, b) < off && distanceTo(loop, 0.5 * (a + b)) < 3 * off)
      length += (b - a).norm();
  }
  return length;
}

TEST(QuadWishes, EdgesFollowGuides) {
  const Version clay = ball();
  CageWishes wishes;
  wishes.guides = {ringAt(0), ringAt(13)};
  const FlatQuads plain = flatQuads(clay, 300, false, 2, WorkPart(nullptr)),
                  guided = flatQuads(clay, 300, false, 2, WorkPart(nullptr), wishes);
  for (const GuideLoop& loop : wishes.guides) {
    EXPECT_LT(along(plain.mesh, loop, 0.25), 0.3 * lengthOf(loop));
    EXPECT_GT(along(guided.mesh, loop, 0.25), 0.95 * lengthOf(loop));
  }
  EXPECT_EQ(plain.met.onGuidesMm, 0);
  EXPECT_NEAR(guided.met.onGuidesMm / (lengthOf(wishes.guides[0]) + lengthOf(wishes.guides[1])), 1, 0.05);
  // They are no creases, and the ball is as round as it was.
  EXPECT_TRUE(std::ranges::all_of(guided.mesh.creases, [](uint8_t bits) { return bits == 0; }));
  EXPECT_EQ(int64_t(guided.mesh.positions.size()) - int64_t(guided.mesh.quads.size()), 2);
  EXPECT_GT(shapesOf(guided.mesh).least, 0.2);
}

TEST(QuadWishes, ACurveAcrossCreasesEndsAtNone) {
  // A ring around a block crosses four of its edges.
  const Version clay = makeBlock(Store::make(), grid(), {0, 0, 0}, {40, 30, 20}, 0);
  CageWishes wishes;
  GuideLoop loop;
  for (const auto& [y, z] : {std::pair{-15.0, -10.0}, {15.0, -10.0}, {15.0, 10.0}, {-15.0, 10.0}})
    loop.emplace_back(7, y, z);
  wishes.guides = {loop};
  const FlatQuads made = flatQuads(clay, 200, false, 2, WorkPart(nullptr), wishes);
  EXPECT_GT(along(made.mesh, loop, 0.3), 0.95 * lengthOf(loop));
  // The block's own edges stay creases: twelve of them.
  double creases = 0;
  const QuadTopology topology(made.mesh);
  for (const auto& edge : topology.edges())
    if (edge.crease) creases += (made.mesh.positions[edge.from] - made.mesh.positions[edge.to]).norm();
  EXPECT_NEAR(creases, 4 * (40 + 30 + 20), 4);
  // It crosses each of them at one vertex.
  for (const auto& edge : topology.edges())
    EXPECT_GT((made.mesh.positions[edge.from] - made.mesh.positions[edge.to]).norm(), 1.2);
}

TEST(QuadWishes, GuidesMayCross) {
  CageWishes wishes;
  wishes.guides = {ringAt(0)};
  GuideLoop other;
  for (int i = 0; i < 90; ++i) {
    const double turn = 2 * std::numbers::pi * i / 90;
    other.push_back(Vec3d(1, 2, 3) + kRadius * Vec3d(std::cos(turn), 0, std::sin(turn)));
  }
  wishes.guides.push_back(other);
  const FlatQuads made = flatQuads(ball(), 200, false, 2, WorkPart(nullptr), wishes);
  for (const GuideLoop& loop : wishes.guides) EXPECT_GT(along(made.mesh, loop, 0.3), 0.95 * lengthOf(loop));
  const QuadTopology topology(made.mesh);
  for (const auto& edge : topology.edges())
    EXPECT_GT((made.mesh.positions[edge.from] - made.mesh.positions[edge.to]).norm(), 0.8);
}

// Also where they cross aslant, four lines of the cage meet in one vertex, and not three in each of two; but where they
// hardly cross.
TEST(QuadWishes, GuidesCrossAtOneVertex) {
  std::mt19937 random(5);
  std::normal_distribution<double> any;
  const Version clay = ball();
  int fours = 0, threes = 0;
  for (int pair = 0; pair < 12; ++pair) {
    CageWishes wishes;
    for (int i = 0; i < 2; ++i) {
      const double x = any(random), y = any(random), z = any(random);
      wishes.guides.push_back(ringAround(Vec3d(x, y, z).normalized(), std::clamp(3 * any(random), -6.0, 6.0)));
    }
    const CageMaker maker(clay, 200, true, 1, WorkPart(nullptr), {}, wishes);
    const QuadMesh mesh = maker.make(WorkPart(nullptr)).mesh;
    const QuadTopology topology(mesh);
    std::vector<int> lines(mesh.positions.size());
    for (const auto& edge : topology.edges())
      if (edge.crease) ++lines[edge.from], ++lines[edge.to];
    fours += static_cast<int>(std::ranges::count(lines, 4));
    threes += static_cast<int>(std::ranges::count(lines, 3));
  }
  std::printf("%d crossings at one vertex, %d vertices where three lines meet\n", fours, threes);
  EXPECT_GE(fours, 19);  // of 24
  EXPECT_LE(threes, 8);
}

// The two ends of a short edge of creases are no crossing.
TEST(QuadWishes, CornersOfAThinPlateStayApart) {
  const Version plate = makeBlock(Store::make(), grid(), {0, 0, 0}, {24, 18, 2}, 0);
  const CageMaker maker(plate, 1000, true, 1, WorkPart(nullptr));
  const QuadMesh mesh = maker.make(WorkPart(nullptr)).mesh;
  const QuadTopology topology(mesh);
  std::vector<int> lines(mesh.positions.size());
  for (const auto& edge : topology.edges())
    if (edge.crease) ++lines[edge.from], ++lines[edge.to];
  EXPECT_EQ(std::ranges::count(lines, 3), 8);
  EXPECT_EQ(std::ranges::count(lines, 4), 0);
}

TEST(QuadWishes, WhatLeavesTheSurfaceIsNoGuide) {
  CageWishes wishes;
  wishes.guides = {ringAt(5)};
  for (Vec3d& p : wishes.guides[0]) p.z() += 4;
  const FlatQuads made = flatQuads(ball(), 200, false, 2, WorkPart(nullptr), wishes);
  EXPECT_EQ(made.met.onGuidesMm, 0);
  EXPECT_EQ(made.met.guides, 0u);
  EXPECT_EQ(made.met.guidesMm, 0);
}

TEST(QuadWishes, SmoothFacesFollowGuidesAndStaySmooth) {
  CageWishes wishes;
  wishes.guides = {ringAt(8)};
  const FittedPatches made = fitPatches(ball(), 120, 2, WorkPart(nullptr), wishes);
  EXPECT_NEAR(made.met.onGuidesMm / lengthOf(wishes.guides[0]), 1, 0.1);
  EXPECT_TRUE(std::ranges::all_of(made.cage.mesh.creases, [](uint8_t bits) { return bits == 0; }));
  EXPECT_TRUE(made.deviation.foldsMm.empty());
  EXPECT_LT(made.deviation.mostMm(), 0.05);
}

// The half of the ball above its middle.
Version maskedBall(double middle) {
  const Version clay = ball();
  Editor editor(clay);
  clay.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> values{};
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord voxel = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      if (clay.grid().toWorld(voxel.toVec3d()).z() > middle) values[size_t(v)] = 255;
    }
    editor.setChannel(Channel::mask, brick.coord, values);
  });
  return editor.commit();
}

TEST(QuadWishes, MoreQuadsLieWhereTheClayIsMasked) {
  const Version clay = maskedBall(3);
  const auto shareAbove = [](const QuadMesh& mesh) {
    size_t above = 0;
    for (const auto& q : mesh.quads) {
      double z = 0;
      for (const uint32_t v : q) z += mesh.positions[v].z() / 4;
      above += z > 3;
    }
    return double(above) / double(mesh.quads.size());
  };
  CageWishes wishes;
  for (const double density : {1.0, 4.0, 0.25}) {
    wishes.maskDensity = density;
    const FlatQuads made = flatQuads(clay, 400, false, 2, WorkPart(nullptr), wishes);
    SCOPED_TRACE(density);
    // Sizes go from one to the other over some millimetres, so that not all of the share is reached.
    EXPECT_NEAR(shareAbove(made.mesh), density / (1 + density), density == 1 ? 0.08 : 0.12);
    EXPECT_GT(made.mesh.quads.size(), 370u);
    if (density == 1)
      EXPECT_EQ(made.met.maskDensity, 0);
    else
      EXPECT_NEAR(std::log(made.met.maskDensity) / std::log(density), 1, 0.35);
  }
  // Nor do the rounds in which smooth faces come nearer take it back.
  wishes.maskDensity = 4;
  EXPECT_GT(fitPatches(clay, 200, 2, WorkPart(nullptr), wishes).met.maskDensity, 2.5);
  for (const double density : {0.0, 17.0, -1.0, double(NAN)}) {
    wishes.maskDensity = density;
    EXPECT_THROW((void)flatQuads(clay, 400, false, 1, WorkPart(nullptr), wishes), Error);
  }
}

}  // namespace
}  // namespace argil::clay
