// What the fine surface promises: sharp where the clay is sharp, as the draft elsewhere, closed always.

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "tests/unit/clay/sharp_shapes.h"

namespace argil::clay {
namespace {

using namespace testing;

std::vector<Vec3d> edgesOf(const TurnedBox& box) {
  std::vector<Vec3d> points;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 4; ++side)
      for (int i = -100; i <= 100; ++i) {
        Vec3d p;
        p[axis] = i * 0.01 * box.half[axis];
        p[(axis + 1) % 3] = (side & 1 ? 1 : -1) * box.half[(axis + 1) % 3];
        p[(axis + 2) % 3] = (side & 2 ? 1 : -1) * box.half[(axis + 2) % 3];
        points.push_back(box.centre + box.axes * p);
      }
  return points;
}

struct Grades {
  SurfaceError draft, fine;
  uint64_t folded = 0, triangles = 0;
};

Grades measure(const Version& version, const std::function<double(const Vec3d&)>& distance,
               const std::vector<Vec3d>& crease) {
  Grades grades;
  const TriangleMesh draft = meshOf(version, Grade::draft), fine = meshOf(version, Grade::fine);
  grades.draft = surfaceError(draft, distance, crease);
  grades.fine = surfaceError(fine, distance, crease);
  grades.folded = foldedEdges(fine);
  grades.triangles = fine.triangles.size();
  EXPECT_TRUE(checkTopology(fine).closed());
  EXPECT_EQ(draft.triangles.size(), fine.triangles.size());
  EXPECT_EQ(draft.positions.size(), fine.positions.size());
  return grades;
}

TEST(SharpFeatures, EdgesAndCornersOfBoxesAreWhereTheyShould) {
  const uint64_t seed = 7;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> shift(-1, 1);
  const auto store = Store::make();
  for (int turn = 0; turn < 6; ++turn) {
    TurnedBox box;
    box.half = Vec3d(14, 12, 10);
    if (turn > 0) box.centre = Vec3d(shift(random), shift(random), shift(random));
    if (turn > 1) box.axes = randomTurn(random);
    for (const bool cut : {false, true}) {
      const Version version = clayOf(store, 24, [&](const Vec3d& p) { return cut ? box.cut(p) : box.distance(p); });
      const Grades g = measure(
          version, [&](const Vec3d& p) { return box.distance(p); }, edgesOf(box));
      EXPECT_LE(g.fine.most(), 0.15) << "seed " << seed << " turn " << turn << " cut " << cut;
      EXPECT_GE(g.draft.most(), 5 * g.fine.most());
      EXPECT_LE(g.folded, g.triangles / 200);
    }
  }
}

TEST(SharpFeatures, AnAxisAlignedBlock) {
  const auto store = Store::make();
  Grid grid;
  grid.voxelMm = 1;
  TurnedBox box;
  box.centre = Vec3d(0.3, 0.6, 0.1);
  const Version version = makeBlock(store, grid, box.centre, 2 * box.half, 0);
  const Grades g = measure(
      version, [&](const Vec3d& p) { return box.distance(p); }, edgesOf(box));
  EXPECT_LE(g.fine.most(), 0.06);
  EXPECT_GE(g.draft.most(), 0.4);
  EXPECT_EQ(g.folded, 0u);
}

// A hollow of the shape of a box: the same edges, concave.
TEST(SharpFeatures, ConcaveEdges) {
  const uint64_t seed = 8;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  TurnedBox box;
  box.half = Vec3d(12, 10, 9);
  box.axes = randomTurn(random);
  const auto hollow = [&](const Vec3d& p) { return std::max(p.norm() - 30, -box.cut(p)); };
  const Grades g = measure(
      clayOf(store, 33, hollow), [&](const Vec3d& p) { return std::max(p.norm() - 30, -box.distance(p)); },
      edgesOf(box));
  EXPECT_LE(g.fine.creaseMax, 0.05) << "seed " << seed;
  EXPECT_GE(g.draft.creaseMax, 5 * g.fine.creaseMax);
}

// Two balls cut into each other and joined: creases between curved faces, convex and concave, as a ball tool leaves
// them.
TEST(SharpFeatures, CreasesBetweenCurvedFaces) {
  const uint64_t seed = 9;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  for (int turn = 0; turn < 2; ++turn) {
    const Eigen::Matrix3d axes = randomTurn(random);
    const Vec3d centre = axes * Vec3d(0, 0, 15);
    const double ring = std::sqrt(20.0 * 20 - 15 * 15);
    std::vector<Vec3d> crease;
    for (int i = 0; i < 1000; ++i)
      crease.push_back(axes * Vec3d(ring * std::cos(i * EIGEN_PI / 500), ring * std::sin(i * EIGEN_PI / 500), 0));
    for (const bool joined : {false, true}) {
      const auto both = [&](const Vec3d& p) {
        const double a = (p - centre).norm() - 20, b = (p + centre).norm() - 20;
        return joined ? std::min(a, b) : std::max(a, b);
      };
      const Grades g = measure(clayOf(store, 38, both), both, crease);
      EXPECT_LE(g.fine.most(), 0.3) << "seed " << seed << " turn " << turn << " joined " << joined;
      EXPECT_GE(g.draft.creaseMax, 2 * g.fine.creaseMax);
      EXPECT_LT(g.fine.rms, g.draft.rms);
    }
  }
}

// Rounded by less than a voxel up to several: never worse than the draft, and within a quarter of a voxel.
TEST(SharpFeatures, RoundedEdges) {
  const uint64_t seed = 10;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  struct Row {
    double round, most, better;
  };
  for (const Row& row :
       {Row{0.25, 0.25, 3}, Row{0.5, 0.25, 2.5}, Row{1, 0.25, 1.8}, Row{2, 0.2, 1.3}, Row{4, 0.12, 1.2}}) {
    TurnedBox box;
    box.half = Vec3d(12, 11, 10);
    box.round = row.round;
    box.axes = randomTurn(random);
    const auto distance = [&](const Vec3d& p) { return box.distance(p); };
    const Grades g = measure(clayOf(store, 22, distance), distance, {});
    EXPECT_LE(g.fine.most(), row.most) << "seed " << seed << " round " << row.round;
    EXPECT_GE(g.draft.most(), row.better * g.fine.most()) << "seed " << seed << " round " << row.round;
    EXPECT_LT(g.fine.rms, 0.7 * g.draft.rms);
  }
}

// What is round is no worse than in the draft.
TEST(SharpFeatures, NoCreasesWhereThereAreNone) {
  const auto store = Store::make();
  for (const double radius : {1.5, 2.0, 3.0, 5.0, 8.0, 20.0}) {
    const auto ball = [&](const Vec3d& p) { return (p - Vec3d(0.2, 0.3, 0.4)).norm() - radius; };
    const Grades g = measure(clayOf(store, static_cast<int>(radius) + 4, ball), ball, {});
    EXPECT_LE(g.fine.most(), g.draft.most() + 1e-6) << radius;
    EXPECT_LE(g.fine.rms, g.draft.rms + 1e-6) << radius;
    EXPECT_EQ(g.folded, 0u);
  }
}

}  // namespace
}  // namespace argil::clay
