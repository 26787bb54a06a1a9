// Cages whose quads do not bend inwards, and smooth faces that fold over themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "clay/cage/fit_cage.h"
#include "clay/cage/net_fit.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

// A body with limbs and ears: flat ellipsoids that leave a ball at any angle, where quads have to turn sharply.
Version limbs(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Grid grid;
  grid.voxelMm = 0.5;
  const auto store = Store::make();
  Version clay = makeSphere(store, grid, Vec3d::Zero(), 15);
  for (int i = 0; i < 6; ++i) {
    const Vec3d way = Vec3d(u(random), u(random), u(random)).normalized() * 16;
    Vec3d size(2 + 2 * std::abs(u(random)), 2 + 2 * std::abs(u(random)), 2 + 2 * std::abs(u(random)));
    size[i % 3] = 9 + 4 * u(random);
    clay = combine(clay, makeEllipsoid(store, grid, way, size), Combination::join);
  }
  return clay;
}

// Corners of quads that face into the clay.
int inwards(const QuadMesh& cage) {
  std::vector<Vec3d> normals(cage.positions.size(), Vec3d::Zero());
  for (const auto& q : cage.quads) {
    const Vec3d area = (cage.positions[q[2]] - cage.positions[q[0]]).cross(cage.positions[q[3]] - cage.positions[q[1]]);
    for (const uint32_t v : q) normals[v] += area;
  }
  int count = 0;
  for (const auto& q : cage.quads)
    for (size_t s = 0; s < 4; ++s) {
      const Vec3d& p = cage.positions[q[s]];
      const Vec3d corner = (cage.positions[q[(s + 1) & 3]] - p).cross(cage.positions[q[(s + 3) & 3]] - p);
      count += corner.dot(normals[q[s]]) < 0;
    }
  return count;
}

TEST(CoarseCage, CornersFaceOutwards) {
  int quads = 0, bad = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    const CoarseCage cage = coarseCage(limbs(seed), 160, WorkPart(nullptr));
    quads += int(cage.mesh.quads.size());
    bad += inwards(cage.mesh);
  }
  std::printf("%d of %d corners face inwards\n", bad, 4 * quads);
  EXPECT_LE(bad, 45) << "61 where none is unfolded";
}

// The cage that is best in its try is not the best one at the end: its patches lie 0.27 mm off.
TEST(LongFitPatches, TakeTheBestOfSomeCagesWhereTheyFold) {
  const FittedPatches fitted = fitPatches(limbs(1), 160, 2, WorkPart(nullptr));
  EXPECT_FALSE(fitted.deviation.foldsMm.empty()) << "else it says nothing";
  EXPECT_LT(fitted.deviation.mostMm(), 0.19) << "0.21 where it is evened out for a few folds fewer";
}

// A mean of what is beside it would draw each row beside the rim of a bore onto the rim, until faces over it fold.
TEST(FitPatches, DoNotFoldBesideTheRimOfABore) {
  Grid grid;
  grid.voxelMm = 0.4;
  const Version clay = combine(makeSphere(Store::make(), grid, Vec3d::Zero(), 30),
                               makeCylinder(Store::make(), grid, Vec3d(0, 0, -45), 9, 90, 1), Combination::cut);
  for (const size_t faces : {100, 200}) {
    const FittedPatches fitted = fitPatches(clay, faces, 2, WorkPart(nullptr));
    EXPECT_TRUE(fitted.deviation.foldsMm.empty()) << faces << ": " << fitted.deviation.foldsMm.size();
    EXPECT_LT(fitted.deviation.boundMm, 0.12);
  }
}

// A vertex of a ball's cage, drawn across a quad beside it: the fit alone does not find back.
TEST(FittedNet, UnfoldsWhereACornerWasDrawnAcrossItsQuad) {
  Grid grid;
  grid.voxelMm = 0.5;
  const Version ball = makeSphere(Store::make(), grid, Vec3d::Zero(), 20);
  QuadMesh cage = coarseCage(ball, 96, WorkPart(nullptr)).mesh;
  Surface surface(true, Grade::fine);
  surface.update(ball);
  const TriangleMesh clay = surface.toMesh();
  const NearestTriangle tree(clay);
  const CreaseMap none(surface, clay, 8);
  const auto& quad = cage.quads[11];
  const Vec3d across = 1.2 * cage.positions[quad[2]] - 0.2 * cage.positions[quad[0]];
  cage.positions[quad[0]] = 20 * across.normalized();
  const auto fitted = [&](int unfoldings, int threads) {
    return fittedNet(cage, clay, tree, none, {4, 8, 12, unfoldings}, threads, WorkPart(nullptr));
  };
  const PatchSurface folded = fitted(0, 2), even = fitted(10, 2);
  EXPECT_FALSE(foldsOf(folded, meshOf(folded, 8), 8).empty());
  EXPECT_TRUE(foldsOf(even, meshOf(even, 8), 8).empty());
  EXPECT_LT(deviationOf(even, clay, 4, 2, WorkPart(nullptr)).mostMm(), 0.02);
  EXPECT_EQ(even.points, fitted(10, 3).points) << "the same for any count of threads";
}

// A sheet of 8 × 8 squares, and the same with a vertex drawn across what is beside it.
TEST(PatchDeviation, KnowsFolds) {
  TriangleMesh sheet;
  for (uint32_t x = 0; x <= 8; ++x)
    for (uint32_t y = 0; y <= 8; ++y) sheet.positions.push_back(Vec3d(x, y, 0.2 * std::sin(x)));
  for (uint32_t x = 0; x < 8; ++x)
    for (uint32_t y = 0; y < 8; ++y) {
      const uint32_t a = x * 9 + y, b = a + 9;
      sheet.triangles.push_back({a, b, b + 1});
      sheet.triangles.push_back({a, b + 1, a + 1});
    }
  EXPECT_TRUE(foldsOf(sheet).empty());
  sheet.positions[4 * 9 + 4] += Vec3d(1.8, 0, 0);
  const std::vector<uint32_t> folds = foldsOf(sheet);
  ASSERT_FALSE(folds.empty());
  for (const uint32_t v : folds) EXPECT_LT((sheet.positions[v] - Vec3d(5, 4, 0)).norm(), 2.5);
  // An edge is none: two sides at 80 degrees.
  for (size_t i = 0; i < sheet.positions.size(); ++i) {
    const double x = double(i / 9), y = double(i % 9), beyond = std::max(x - 4, 0.0);
    sheet.positions[i] = Vec3d(std::min(x, 4.0) - 0.174 * beyond, y, -0.985 * beyond);
  }
  EXPECT_TRUE(foldsOf(sheet).empty());
}

// They are told with their places, those near one another once.
TEST(PatchDeviation, SaysWherePatchesFold) {
  Grid grid;
  grid.voxelMm = 0.5;
  const Version ball = makeSphere(Store::make(), grid, Vec3d::Zero(), 20);
  FittedPatches fitted = fitPatches(ball, 120, 2, WorkPart(nullptr));
  Surface surface(false);
  surface.update(ball);
  EXPECT_TRUE(deviationOf(fitted.surface, surface.toMesh(), 4, 2, WorkPart(nullptr)).foldsMm.empty());
  // Control points in the middle of a patch, drawn through one another.
  const auto& patch = fitted.surface.patches[7];
  const Vec3d at = fitted.surface.at(7, 3, 3);
  std::swap(fitted.surface.points[patch[5][6]], fitted.surface.points[patch[9][6]]);
  const PatchDeviation folded = deviationOf(fitted.surface, surface.toMesh(), 4, 2, WorkPart(nullptr));
  ASSERT_FALSE(folded.foldsMm.empty());
  ASSERT_LE(folded.foldsMm.size(), kMostFarPlaces);
  for (const Vec3d& each : folded.foldsMm) EXPECT_LT((each - at).norm(), 8);
}

}  // namespace
}  // namespace argil::clay
