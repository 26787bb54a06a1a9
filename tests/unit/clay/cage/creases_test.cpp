// Creases of a clay as edges of its cage and of its patches.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "clay/cage/cage_maker.h"
#include "clay/cage/crease_map.h"
#include "clay/cage/fit_cage.h"
#include "clay/cage/fit_quads.h"
#include "clay/cage/quad_web.h"
#include "clay/field/primitives.h"
#include "clay/mesh/surface_faces.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

const Vec3d kMiddle(1, 2, 3), kSize(60, 40, 30);
constexpr double kBore = 12;

Grid grid(double voxelMm = 0.5) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}
Version boredBlock() {
  return combine(makeBlock(Store::make(), grid(), kMiddle, kSize, 0),
                 makeCylinder(Store::make(), grid(), kMiddle, kBore, 60), Combination::cut);
}
Surface fine(const Version& version) {
  Surface surface(true, Grade::fine);
  surface.update(version);
  return surface;
}
// The creases of a clay for cages with edges of about so many mm, and what they are marked on.
struct Creased {
  explicit Creased(const Version& version, double evenMm)
      : surface(fine(version)), mesh(surface.toMesh()), tree(mesh), map(surface, mesh, evenMm) {}
  Surface surface;
  TriangleMesh mesh;
  NearestTriangle tree;
  CreaseMap map;
};

// How far a place lies off the twelve edges of the block and the two circles of the bore.
double offEdges(const Vec3d& mm) {
  const Vec3d p = (mm - kMiddle).cwiseAbs(), half = kSize / 2;
  double least = std::hypot(std::hypot(p.x(), p.y()) - kBore, p.z() - half.z());
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double along = std::max(p[axis] - half[axis], 0.0);
    least = std::min(least, Vec3d(p[a] - half[a], p[b] - half[b], along).norm());
  }
  return least;
}

TEST(CreaseMap, HasTheEdgesOfTheClay) {
  const Creased creased(boredBlock(), 5);
  const CreaseMap& map = creased.map;
  double length = 0, most = 0, sum = 0;
  for (const Vec3d& each : map.places()) {
    most = std::max(most, offEdges(each));
    sum += offEdges(each) * offEdges(each);
  }
  EXPECT_LT(most, 0.25);
  EXPECT_LT(std::sqrt(sum / double(map.places().size())), 0.03);
  // Whatever lies on an edge has a crease beside it, along the edge.
  uint32_t hint = UINT32_MAX;
  for (double x = -29; x < 29; x += 0.37) {
    const CreaseMap::Hit hit = map.nearest(kMiddle + Vec3d(x, 20, -15), hint);
    EXPECT_LT(hit.squared, 0.01);
    EXPECT_GT(std::abs(hit.along.x()), 0.9) << x;
    ++length;
  }
  // The corners of the block, each once.
  EXPECT_EQ(map.meetings(), 8u);
  ASSERT_EQ(map.corners().size(), 8u);
  for (const Vec3d& each : map.corners())
    EXPECT_LT(((each - kMiddle).cwiseAbs() - kSize / 2).norm(), 0.05) << each.transpose();
}

TEST(CreaseMap, HasNoneWhereClayIsRound) {
  EXPECT_TRUE(Creased(makeSphere(Store::make(), grid(), kMiddle, 20), 0.5).map.empty());
  EXPECT_TRUE(Creased(makeBlock(Store::make(), grid(), kMiddle, kSize, 4), 0.5).map.empty());
  // Nor where it is too short.
  EXPECT_TRUE(Creased(boredBlock(), 5000).map.empty());
}

// Where faces lie exactly on planes of the grid, two rows of vertices stand on an edge.
TEST(CreaseMap, HasThemWhereverTheGridLies) {
  for (const double voxel : {0.4, 0.5, 0.37, 1.0}) {
    const Creased creased(makeBlock(Store::make(), grid(voxel), kMiddle, kSize, 0), 5);
    EXPECT_EQ(creased.map.meetings(), 8u) << voxel;
    EXPECT_EQ(creased.map.corners().size(), 8u) << voxel;
    double length = 0;
    uint32_t hint = UINT32_MAX;
    for (double x = -29; x < 29; x += 0.21)
      length += creased.map.nearest(kMiddle + Vec3d(x, -20, 15), hint).squared < 1e-4 ? 0.21 : 0;
    EXPECT_GT(length, 57) << voxel;
    for (const Eigen::Vector3f& normal : SurfaceCells(creased.mesh.positions, creased.mesh.triangles).normals)
      ASSERT_GT(normal.cwiseAbs().maxCoeff(), 0.99f) << "a sliver between two rows of vertices";
  }
}

TEST(CreaseMap, HasTheRimOfABowlAndNoCornerOnIt) {
  const Version bowl = combine(makeBlock(Store::make(), grid(), kMiddle, kSize, 0),
                               makeSphere(Store::make(), grid(), kMiddle + Vec3d(0, 0, 15), 8), Combination::cut);
  const Creased closed(bowl, 4);
  uint32_t hint = UINT32_MAX;
  EXPECT_LT(closed.map.nearest(kMiddle + Vec3d(8, 0, 15), hint).squared, 0.01);
  EXPECT_EQ(closed.map.corners().size(), 8u);
}

// Of each vertex how many creases end there; those of two are lines.
std::map<size_t, int> ends(const QuadMesh& mesh) {
  const QuadTopology topology(mesh);
  std::map<size_t, int> count;
  for (uint32_t v = 0; v < topology.vertexCount(); ++v) ++count[topology.creasesAt(v)];
  return count;
}

TEST(CreaseMap, MarksClosedLinesOnACoarseMesh) {
  const Version version = boredBlock();
  const Creased creased(version, 5);
  QuadMesh mesh = quadsOf(fine(version));
  creased.map.mark(mesh, creased.tree);
  std::map<size_t, int> count = ends(mesh);
  EXPECT_EQ(count[3], 8) << "corners of the block";
  EXPECT_GT(count[2], 500);
  EXPECT_EQ(count[1] + count[4], 0);
  const QuadTopology topology(mesh);
  for (const QuadTopology::Edge& edge : topology.edges()) {
    if (!edge.crease) continue;
    EXPECT_LT(offEdges(0.5 * (mesh.positions[edge.from] + mesh.positions[edge.to])), 0.5);
  }
}

// Lines keep their corners and stay whole, whatever is done to the mesh: as many vertices at which three creases meet,
// none at which one ends, and the same count of closed lines.
TEST(QuadWeb, CreasesStayLinesBetweenTheSameCorners) {
  const Version version = combine(makeBlock(Store::make(), grid(1), kMiddle, kSize, 0),
                                  makeCylinder(Store::make(), grid(1), kMiddle, kBore, 60), Combination::cut);
  QuadMesh mesh = quadsOf(fine(version));
  const Creased creased(version, 5);
  creased.map.mark(mesh, creased.tree);
  std::map<size_t, int> before = ends(mesh);
  ASSERT_EQ(before[3], 8);
  for (unsigned seed = 0; seed < 4; ++seed) {
    QuadWeb web(mesh);
    std::mt19937 random(seed);
    size_t shorter = 0;
    const auto creases = [&] {
      size_t count = 0;
      for (uint32_t f = 0; f < web.quads(); ++f)
        for (int s = 0; web.isThere(f) && s < 4; ++s) count += web.creases(f) >> s & 1;
      return count;
    };
    for (int i = 0; i < 80000; ++i) {
      const auto f = static_cast<uint32_t>(random() % web.quads());
      if (!web.isThere(f)) continue;
      const int corner = static_cast<int>(random() % 4), step = random() % 2 ? 1 : -1;
      if (random() % 3 != 0) {
        if (web.gainOfTurn(f, corner, step)) web.turn(f, corner, step);
      } else if (web.gainOfCollapse(f, corner)) {
        const auto q = web.quad(f);
        const bool both = web.isOnCrease(q[size_t(corner)]) && web.isOnCrease(q[size_t(corner + 2) & 3]);
        const size_t now = both ? creases() : 0;
        web.collapse(f, corner);
        if (both) {
          EXPECT_EQ(creases(), now - 4);  // two edges, from either side
          ++shorter;
        }
      } else {
        (void)web.removeInset(f);
      }
    }
    const QuadMesh left = web.mesh();
    std::map<size_t, int> after = ends(left);  // throws where the two sides of an edge disagree
    EXPECT_EQ(after[3], 8) << seed;
    EXPECT_EQ(after[1] + after[4] + after[5], 0) << seed;
    EXPECT_LT(after[2], before[2]) << seed;
    EXPECT_GT(shorter, 5u) << seed;
    EXPECT_LT(left.quads.size(), mesh.quads.size() / 2) << seed;
  }
}

// As few as go around it: the shape is kept, and its corners with it.
TEST(FitPatches, OfFewQuadsKeepShapeAndCorners) {
  const Version block = combine(makeBlock(Store::make(), grid(1), kMiddle, kSize, 0),
                                makeCylinder(Store::make(), grid(1), kMiddle, kBore, 60), Combination::cut);
  const FittedPatches made = fitPatches(block, 32, 2, WorkPart(nullptr));
  EXPECT_LE(made.surface.patches.size(), 32u);
  EXPECT_EQ(made.cage.shape, 0) << "a body with a hole";
  EXPECT_GE(made.surface.cage.corners.size(), 8u) << "those of the block";
  EXPECT_LT(made.deviation.mostMm(), 4);
}

// Of a mesh that stays quads too.
TEST(FitQuads, CreasesAreEdgesOfTheMesh) {
  const CageMaker maker(boredBlock(), 300, true, 2, WorkPart(nullptr));
  const QuadMesh cage = maker.make(WorkPart(nullptr)).mesh;
  QuadMesh mesh = cage;
  fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 2, WorkPart(nullptr));
  ASSERT_EQ(mesh.corners.size(), 8u);
  for (const uint32_t v : mesh.corners) EXPECT_LT((mesh.positions[v] - cage.positions[v]).norm(), 1e-9);
  const QuadTopology topology(mesh);
  double length = 0, most = 0;
  for (const QuadTopology::Edge& edge : topology.edges()) {
    if (!edge.crease) continue;
    most = std::max({most, offEdges(mesh.positions[edge.from]), offEdges(mesh.positions[edge.to])});
    length += (mesh.positions[edge.from] - mesh.positions[edge.to]).norm();
  }
  EXPECT_LT(most, 0.02);
  EXPECT_GT(length, 0.95 * maker.creases().lengthMm());
  // Its places lie a little beside the edges, to and fro.
  EXPECT_NEAR(maker.creases().lengthMm(), 4 * kSize.sum() + 4 * M_PI * kBore, 10);
  const auto rms = [&](const QuadMesh& quads) {
    double sum = 0;
    for (const auto& q : quads.quads) {
      const Vec3d middle =
          0.25 * (quads.positions[q[0]] + quads.positions[q[1]] + quads.positions[q[2]] + quads.positions[q[3]]);
      sum += maker.tree().nearest(middle).squared;
    }
    return std::sqrt(sum / double(quads.quads.size()));
  };
  EXPECT_LT(rms(mesh), 0.9 * rms(cage));
}

// Where faces are round around them as well.
TEST(FitQuads, CornersStay) {
  const Version bitten = combine(makeBlock(Store::make(), grid(), kMiddle, kSize, 0),
                                 makeSphere(Store::make(), grid(), kMiddle + Vec3d(0, 20, 15), 12), Combination::cut);
  const CageMaker maker(bitten, 200, true, 2, WorkPart(nullptr));
  const QuadMesh cage = maker.make(WorkPart(nullptr)).mesh;
  QuadMesh mesh = cage;
  fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 2, WorkPart(nullptr));
  ASSERT_GE(mesh.corners.size(), 10u);
  for (const uint32_t v : mesh.corners) EXPECT_LT((mesh.positions[v] - cage.positions[v]).norm(), 1e-9);
  EXPECT_NE(mesh.positions, cage.positions);
}

// Whatever the grid and the count: every crease is one line of edges, the corners are those of the plate.
TEST(FitPatches, OfAThinPlateHaveItsEdges) {
  for (const double voxel : {0.4, 0.5}) {
    const FittedPatches made =
        fitPatches(makeBlock(Store::make(), grid(voxel), kMiddle, Vec3d(80, 60, 3), 0), 100, 2, WorkPart(nullptr));
    const QuadTopology topology(made.surface.cage);
    double length = 0;
    for (const QuadTopology::Edge& edge : topology.edges())
      if (edge.crease) length += (made.surface.cage.positions[edge.from] - made.surface.cage.positions[edge.to]).norm();
    EXPECT_NEAR(length, 4 * (80 + 60 + 3), 0.5) << voxel;
    EXPECT_EQ(made.surface.cage.corners.size(), 8u) << voxel;
    EXPECT_LT(made.deviation.mostMm(), 0.02) << voxel;
    EXPECT_EQ(made.deviation.foldsMm.size(), 0u) << voxel;
  }
}

TEST(FitPatches, FollowCreases) {
  const FittedPatches made = fitPatches(boredBlock(), 300, 2, WorkPart(nullptr));
  const QuadTopology topology(made.surface.cage);
  double most = 0, length = 0;
  for (const QuadTopology::Edge& edge : topology.edges())
    for (int k = 0; edge.crease && k < 32; ++k) {
      const auto at = [&](int i) {
        const double t = kPatchSpans * i / 32.0, whole = kPatchSpans;
        const double places[4][2] = {{t, 0}, {whole, t}, {whole - t, whole}, {0, whole - t}};
        return made.surface.at(edge.quad[0], places[edge.side[0]][0], places[edge.side[0]][1]);
      };
      most = std::max(most, offEdges(at(k)));
      length += (at(k + 1) - at(k)).norm();
    }
  const double whole = 4 * kSize.sum() + 4 * M_PI * kBore;
  std::printf("%zu faces; creases %.1f of %.1f mm, %.4f mm off at most; faces %.4f, clay %.4f\n",
              made.surface.patches.size(), length, whole, most, made.deviation.fromPatches.max,
              made.deviation.fromClay.max);
  EXPECT_LT(most, 0.02);
  EXPECT_NEAR(length, whole, 0.5);
  // Without creases 0.064 and 0.063 with a third more faces.
  EXPECT_LT(made.deviation.fromPatches.max, 0.02);
  EXPECT_LT(made.deviation.fromClay.max, 0.02);
  EXPECT_LT(made.deviation.boundMm, 0.03);
  EXPECT_LT(made.deviation.foldsMm.size(), 4u);
}

}  // namespace
}  // namespace argil::clay
