#include "clay/cage/unfold_quads.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "clay/cage/cage_maker.h"
#include "clay/cage/flat_quads.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid() {
  Grid grid;
  grid.voxelMm = 0.5;
  return grid;
}

size_t badOf(const QuadMesh& mesh, double least = 0.2) {
  return static_cast<size_t>(std::count_if(mesh.quads.begin(), mesh.quads.end(),
                                           [&](const auto& quad) { return scaledJacobian(mesh, quad) < least; }));
}

double offOf(const NearestTriangle& tree, const Vec3d& p) {
  return std::sqrt(tree.nearest(p, UINT32_MAX).squared);
}

void unfold(QuadMesh& mesh, const CageMaker& maker) {
  unfoldQuads(mesh, maker.surface(), maker.tree(), maker.creases(), WorkPart(nullptr));
}

TEST(UnfoldQuads, WhatFoldsMovesAlongTheSurfaceAndTheRestStays) {
  const Version clay = makeSphere(Store::make(), grid(), {1, 2, 3}, 16);
  const FlatQuads made = flatQuads(clay, 400, false, 1, WorkPart(nullptr));
  QuadMesh mesh = made.mesh;
  ASSERT_EQ(badOf(mesh, 0.35), 0u);
  unfold(mesh, *made.maker);
  EXPECT_EQ(mesh.positions, made.mesh.positions) << "nothing folds";
  // Every eleventh vertex by the length of an edge, any way along the surface.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<bool> near(mesh.positions.size());
  for (uint32_t v = 0; v < mesh.positions.size() / 2; v += 11) {
    const Vec3d out = (mesh.positions[v] - Vec3d(1, 2, 3)).normalized();
    const Vec3d way = out.cross(Vec3d(number(random), number(random), number(random))).normalized();
    mesh.positions[v] += 2.5 * way;
  }
  for (const auto& quad : mesh.quads)
    if (scaledJacobian(mesh, quad) < 0.35)
      for (const uint32_t v : quad) near[v] = true;
  for (int ring = 0; ring < 6; ++ring) {
    const std::vector<bool> before = near;
    for (const auto& quad : mesh.quads)
      if (std::ranges::any_of(quad, [&](uint32_t v) { return bool(before[v]); }))
        for (const uint32_t v : quad) near[v] = true;
  }
  const QuadMesh folded = mesh;
  ASSERT_GT(badOf(folded), 15u);
  unfold(mesh, *made.maker);
  EXPECT_EQ(badOf(mesh), 0u);
  size_t kept = 0;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_NEAR(offOf(made.maker->tree(), mesh.positions[v]), offOf(made.maker->tree(), folded.positions[v]), 0.05);
    kept += mesh.positions[v] == folded.positions[v];
    if (!near[v]) {
      EXPECT_EQ(mesh.positions[v], folded.positions[v]);
    }
  }
  EXPECT_GT(kept, mesh.positions.size() / 3);
}

// Where two rows of vertices stand on one crease a surface has triangles without area, which have no normal.
TEST(UnfoldQuads, WhatLiesOnATriangleWithoutAreaMovesToo) {
  const Version clay = makeSphere(Store::make(), grid(), {1, 2, 3}, 16);
  const FlatQuads made = flatQuads(clay, 400, false, 1, WorkPart(nullptr));
  QuadMesh mesh = made.mesh;
  TriangleMesh surface = made.maker->surface();
  for (uint32_t v = 0; v < mesh.positions.size(); v += 23) {
    Vec3d& at = mesh.positions[v];
    const Vec3d out = (at - Vec3d(1, 2, 3)).normalized();
    at += 2.5 * out.unitOrthogonal();
    const auto first = static_cast<uint32_t>(surface.positions.size());
    surface.positions.push_back(at);
    surface.triangles.push_back({first, first, first});
  }
  ASSERT_GT(badOf(mesh), 15u);
  const QuadMesh folded = mesh;
  const NearestTriangle tree(surface);
  unfoldQuads(mesh, surface, tree, made.maker->creases(), WorkPart(nullptr));
  EXPECT_EQ(badOf(mesh), 0u);
  int moved = 0;
  for (uint32_t v = 0; v < mesh.positions.size(); v += 23) moved += mesh.positions[v] != folded.positions[v];
  EXPECT_GT(moved, 10) << "neighbours alone could unfold some";
}

TEST(UnfoldQuads, VerticesOfCreasesStayOnThemAndCornersWhereTheyAre) {
  const Version block = makeBlock(Store::make(), grid(), Vec3d(0.1, 0.1, 0.1), {30, 24, 18}, 0);
  const FlatQuads made = flatQuads(block, 300, false, 1, WorkPart(nullptr));
  ASSERT_FALSE(made.mesh.creases.empty());
  ASSERT_GE(made.mesh.corners.size(), 8u);
  QuadMesh mesh = made.mesh;
  const QuadTopology topology(mesh);
  const auto isCorner = [&](uint32_t v) { return std::ranges::count(mesh.corners, v) > 0; };
  size_t moved = 0;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (topology.creasesAt(v) == 0 || isCorner(v) || v % 3 != 0) continue;
    uint32_t hint = UINT32_MAX;
    mesh.positions[v] += 2.7 * made.maker->creases().nearest(mesh.positions[v], hint).along;
    ++moved;
  }
  ASSERT_GT(moved, 5u);
  ASSERT_GT(badOf(mesh), badOf(made.mesh) + 3);
  unfold(mesh, *made.maker);
  EXPECT_LE(badOf(mesh), badOf(made.mesh));
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    uint32_t hint = UINT32_MAX;
    if (topology.creasesAt(v) != 0) {
      EXPECT_LT(made.maker->creases().nearest(mesh.positions[v], hint).squared, 0.01);
    }
    if (isCorner(v)) {
      EXPECT_EQ(mesh.positions[v], made.mesh.positions[v]);
    }
  }
}

// Two crumbs beside a ball; `shaken`: where their vertices come to.
void expectBoxes(const std::array<Vec3d, 2>& shaken) {
  const std::array at{Vec3d(22, 5, -3), Vec3d(-20, 8, 4)};
  const Version clay = combine(combine(makeSphere(Store::make(), grid(), Vec3d::Zero(), 12),
                                       makeSphere(Store::make(), grid(), at[0], 1.2), Combination::join),
                               makeSphere(Store::make(), grid(), at[1], 1.2), Combination::join);
  const FlatQuads made = flatQuads(clay, 200, false, 1, WorkPart(nullptr));
  QuadMesh mesh = made.mesh;
  std::vector<int> crumb(mesh.positions.size(), -1);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  for (uint32_t v = 0; v < mesh.positions.size(); ++v)
    for (int k = 0; k < 2; ++k)
      if ((made.mesh.positions[v] - at[size_t(k)]).norm() < 3) {
        crumb[v] = k;
        mesh.positions[v] = shaken[size_t(k)] + 0.01 * Vec3d(number(random), number(random), number(random));
      }
  unfold(mesh, *made.maker);
  std::array<double, 2> volumes{};
  std::array<int, 2> quads{}, boxAt{-1, -1};
  for (const auto& quad : mesh.quads) {
    const int own = crumb[quad[0]];
    if (own < 0) continue;
    EXPECT_GT(scaledJacobian(mesh, quad), 0.9);
    int& k = boxAt[size_t(own)];
    if (k < 0) k = (mesh.positions[quad[0]] - at[0]).norm() < 3 ? 0 : 1;
    const auto p = [&](size_t s) -> Vec3d { return mesh.positions[quad[s]] - at[size_t(k)]; };
    volumes[size_t(own)] += (p(0).dot(p(1).cross(p(2))) + p(0).dot(p(2).cross(p(3)))) / 6;
    ++quads[size_t(own)];
    EXPECT_LT(p(0).norm(), 1.2 * std::sqrt(3.0));
  }
  EXPECT_NE(boxAt[0], boxAt[1]) << "each clay has one";
  for (size_t k = 0; k < 2; ++k) {
    ASSERT_EQ(quads[k], 6);
    EXPECT_NEAR(volumes[k], 4 * M_PI / 3 * std::pow(1.2, 3), 2) << "outwards";
  }
}

TEST(UnfoldQuads, ACrumbBecomesABoxAroundItsClay) {
  expectBoxes({Vec3d(22, 5, -3), Vec3d(-20, 8, 4)});
}

TEST(UnfoldQuads, ACrumbWhoseVerticesLieOnOtherClayBecomesABoxAroundItsOwn) {
  expectBoxes({Vec3d(12, 0, 0), Vec3d(-12, 0, 0)});
  expectBoxes({Vec3d(22, 5, -3), Vec3d(22, 5, -2)});
}

// Balls, rods, rings and blocks joined and cut as they come: of what they leave many creases are too short to be lines
// of the cage, or end within a face.
Version sculpt(unsigned seed) {
  std::mt19937 random(seed);
  const auto part = [&](double low, double high) {
    return low + (high - low) * std::uniform_real_distribution<double>()(random);
  };
  const auto place = [&](double reach) -> Vec3d {
    return {part(-reach, reach), part(-reach, reach), part(-reach, reach)};
  };
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), part(10, 16));
  for (int i = 0; i < 6; ++i) {
    Version tool = Version::empty(Store::make(), grid());
    if (i % 3 == 0) tool = makeRod(Store::make(), grid(), place(6), place(26), part(1.5, 4));
    if (i % 3 == 1) tool = makeTorus(Store::make(), grid(), place(10), part(8, 14), part(1.5, 4));
    if (i % 3 == 2) tool = makeBlock(Store::make(), grid(), place(14), {part(4, 16), part(4, 16), part(4, 16)}, 1);
    const Version next = combine(clay, tool, i == 4 ? Combination::cut : Combination::join);
    if (next.stats().bricks > 0) clay = next;
  }
  return clay;
}

TEST(LongUnfoldQuads, SculptsHaveFewBadQuads) {
  size_t all = 0, bad = 0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    const FlatQuads made = flatQuads(sculpt(seed), 500, false, 2, WorkPart(nullptr));
    all += made.mesh.quads.size();
    bad += badOf(made.mesh);
  }
  std::printf("%zu of %zu quads below 0.2\n", bad, all);
  EXPECT_LE(bad, 6u);
}

}  // namespace
}  // namespace argil::clay
