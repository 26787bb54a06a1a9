// Meshes that stay quads: quads that are halved, and where they go.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>

#include "clay/base/error.h"
#include "clay/cage/fit_quads.h"
#include "clay/cage/flat_quads.h"
#include "clay/cage/unfold_quads.h"
#include "clay/field/primitives.h"
#include "clay/field/region_work.h"
#include "clay/mesh/reduce.h"
#include "clay/store/store.h"
#include "clay/unwrap/charts.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid(double voxelMm = 0.5) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}

/// Smooth, and no mirror image of itself.
Version potato() {
  Version clay = makeSphere(Store::make(), grid(1), {1, 2, 3}, 16);
  for (const auto& [at, radius] : {std::pair{Vec3d(9, 8, 9), 13.0}, {Vec3d(-12, 7, -3), 9.0}})
    clay = combine(clay, makeSphere(Store::make(), grid(1), at, radius), Combination::join, {.blendMm = 8});
  return clay;
}

/// A ball with many thin legs, up to so far from its middle.
Version urchin(double far = 20) {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 12);
  for (int i = 0; i < 14; ++i) {
    const double z = 1 - (2 * i + 1) / 14.0, round = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
    const Vec3d way(round * std::cos(turn), round * std::sin(turn), z);
    clay = combine(clay, makeRod(Store::make(), grid(), 10 * way, far * way, 1.2), Combination::join);
  }
  return clay;
}

double creaseLength(const QuadMesh& mesh) {
  double sum = 0;
  const QuadTopology topology(mesh);
  for (const auto& each : topology.edges())
    if (each.crease) sum += (mesh.positions[each.from] - mesh.positions[each.to]).norm();
  return sum;
}

TEST(ScaledJacobian, IsTheSineOfTheWorstCorner) {
  QuadMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 2, 0}, {1, 0.5, 0}, {1.5, 0, 0}, {4, 2, 0}, {1, 2, 0}};
  EXPECT_DOUBLE_EQ(scaledJacobian(mesh, {0, 1, 2, 3}), 1);
  EXPECT_DOUBLE_EQ(scaledJacobian(mesh, {3, 2, 1, 0}), 1) << "seen from behind";
  EXPECT_NEAR(scaledJacobian(mesh, {0, 1, 6, 7}), 2 / std::sqrt(5.0), 1e-12) << "a parallelogram";
  EXPECT_LT(scaledJacobian(mesh, {0, 1, 4, 3}), -0.2) << "a corner bends inwards";
  EXPECT_DOUBLE_EQ(scaledJacobian(mesh, {0, 5, 1, 3}), 0) << "a corner of half a turn";
  EXPECT_DOUBLE_EQ(scaledJacobian(mesh, {0, 0, 1, 3}), 0) << "a side without a length";
  mesh.quads = {{0, 1, 2, 3}, {0, 5, 1, 3}};
  EXPECT_DOUBLE_EQ(shapesOf(mesh).mean, 0.5);
  EXPECT_DOUBLE_EQ(shapesOf(mesh).least, 0);
}

TEST(HalvedQuads, AreFourForEachAndKeepShapeAndCreases) {
  const Version block = makeBlock(Store::make(), grid(), {1, 2, 3}, {30, 20, 12}, 0);
  const CageMaker maker(block, 120, true, 2, WorkPart(nullptr));
  const QuadMesh coarse = maker.make(WorkPart(nullptr)).mesh, fine = halved(coarse);
  const QuadTopology before(coarse), after(fine);
  EXPECT_EQ(fine.quads.size(), 4 * coarse.quads.size());
  EXPECT_EQ(fine.positions.size(), coarse.positions.size() + before.edges().size() + coarse.quads.size());
  EXPECT_EQ(after.irregular(), before.irregular());
  EXPECT_EQ(fine.corners, coarse.corners);
  EXPECT_EQ(fine.corners.size(), 8u);
  EXPECT_GT(creaseLength(coarse), 200);
  EXPECT_NEAR(creaseLength(fine), creaseLength(coarse), 1e-9);
  // Each quad lies within the one that it is a quarter of, faces as it does and shares its corner.
  for (size_t f = 0; f < fine.quads.size(); ++f) {
    const auto &of = coarse.quads[f / 4], &q = fine.quads[f];
    EXPECT_EQ(q[0], of[f % 4]);
    const Vec3d middle =
        0.25 * (coarse.positions[of[0]] + coarse.positions[of[1]] + coarse.positions[of[2]] + coarse.positions[of[3]]);
    EXPECT_LT((fine.positions[q[2]] - middle).norm(), 1e-12);
  }
}

// Halved once and twice: as many as asked for but for what four leave over, of the same irregular vertices, none
// folded, around all of the clay; the same for any count of threads.
TEST(FlatQuads, AreHalvedFromACoarserCage) {
  const Version clay = potato();
  const size_t irregular = QuadTopology(flatQuads(clay, 500, false, 2, WorkPart(nullptr)).mesh).irregular();
  const CageMaker maker(clay, 500, true, 2, WorkPart(nullptr));
  EXPECT_LE(irregular, QuadTopology(maker.make(WorkPart(nullptr)).mesh).irregular()) << "the best of some";
  double before = 0.4;
  for (const auto& [asked, halvings] : {std::pair{size_t{500}, 0}, {size_t{2000}, 1}, {size_t{8000}, 2}}) {
    const FlatQuads made = flatQuads(clay, asked, false, 2, WorkPart(nullptr));
    EXPECT_EQ(made.halvings, halvings);
    EXPECT_FALSE(made.mirror);
    EXPECT_LE(made.mesh.quads.size(), asked);
    EXPECT_GE(double(made.mesh.quads.size()), 0.95 * double(asked));
    const QuadTopology topology(made.mesh);
    EXPECT_EQ(topology.irregular(), irregular);
    EXPECT_EQ(made.mesh.positions.size(), made.mesh.quads.size() + 2);
    EXPECT_GT(shapesOf(made.mesh).least, 0.2);
    const double rms = deviation(made.maker->surface(), trianglesOf(made.mesh)).rmsMm;
    EXPECT_LT(rms, 0.6 * before) << "a quarter, if the clay's own quads were much smaller";
    before = rms;
  }
  EXPECT_EQ(flatQuads(clay, 2000, false, 1, WorkPart(nullptr)).mesh.positions,
            flatQuads(clay, 2000, false, 2, WorkPart(nullptr)).mesh.positions);
}

// Thin legs make a poor cage of few quads, and many handles may make none: what is asked for is drawn itself then.
TEST(FlatQuads, AreDrawnThemselvesWhereACoarserCageIsPoor) {
  const FlatQuads legs = flatQuads(urchin(), 2000, false, 2, WorkPart(nullptr));
  EXPECT_EQ(legs.halvings, 0);
  EXPECT_GE(legs.mesh.quads.size(), 1900u);
  Version holed = makeBlock(Store::make(), grid(), Vec3d::Zero(), {70, 70, 4}, 0);
  for (int i = 0; i < 36; ++i)
    holed = combine(holed,
                    makeBlock(Store::make(), grid(), {11.0 * (i % 6) - 27.5, 11.0 * (i / 6) - 27.5, 0}, {6, 6, 10}, 0),
                    Combination::cut);
  const FlatQuads holes = flatQuads(holed, 2000, false, 2, WorkPart(nullptr));
  EXPECT_EQ(holes.halvings, 0);
  EXPECT_EQ(int64_t(holes.mesh.positions.size()) - int64_t(holes.mesh.quads.size()), 2 * (1 - 36));
}

/// A body with arms and eyes on both sides of a plane across the x axis.
Version beast(double atMm, Version clay) {
  for (const int side : {-1, 1}) {
    clay = combine(clay, makeSphere(Store::make(), grid(), {atMm + side * 14.0, 6, 9}, 7), Combination::join);
    clay = combine(clay, makeRod(Store::make(), grid(), {atMm + side * 8.0, 0, -10}, {atMm + side * 12.0, 4, -28}, 3.5),
                   Combination::join);
  }
  return clay;
}
Version body(double atMm) {
  return makeSphere(Store::make(), grid(), {atMm, 0, 0}, 18);
}

void expectMirrored(const FlatQuads& made, size_t inPlane) {
  ASSERT_TRUE(made.mirror);
  ASSERT_EQ(made.image.size(), made.mesh.positions.size());
  const QuadTopology topology(made.mesh);
  size_t own = 0;
  for (uint32_t v = 0; v < made.image.size(); ++v) {
    ASSERT_EQ(made.image[made.image[v]], v);
    own += made.image[v] == v;
    const Vec3d &p = made.mesh.positions[v], &q = made.mesh.positions[made.image[v]];
    if (made.image[v] == v) {
      EXPECT_EQ(p[made.mirror->axis], made.mirror->atMm);
    } else {
      EXPECT_TRUE(q == made.mirror->imageOf(p) || p == made.mirror->imageOf(q)) << v;
    }
  }
  EXPECT_GE(own, inPlane);
  // Each quad's image is a quad, the other way round.
  std::set<std::array<uint32_t, 4>> quads;
  const auto turned = [](std::array<uint32_t, 4> q) {
    std::rotate(q.begin(), std::min_element(q.begin(), q.end()), q.end());
    return q;
  };
  for (const auto& q : made.mesh.quads) quads.insert(turned(q));
  for (const auto& q : made.mesh.quads)
    EXPECT_TRUE(quads.contains(turned({made.image[q[3]], made.image[q[2]], made.image[q[1]], made.image[q[0]]})));
}

// To the bit, wherever the plane lies among the voxels; creases of the clay that cross it stay.
// What a layout lacks as it ends: irregular vertices and bad quads, and distances (NOTES.md, "Layouts").
double lackOf(const QuadMesh& mesh, const CageMaker& maker) {
  double lack = 8 + double(QuadTopology(mesh).irregular());
  for (const auto& quad : mesh.quads) lack += scaledJacobian(mesh, quad) < 0.2 ? 4 : 0;
  const Deviation off = deviation(maker.surface(), trianglesOf(mesh));
  return lack * lack * (off.rmsMm + 0.2 * off.most());
}

TEST(FlatQuads, AreTheBestOfFourLayouts) {
  for (const Version& clay : {urchin(), potato()}) {
    const FlatQuads made = flatQuads(clay, 450, false, 1, WorkPart(nullptr));
    const FlatQuads again = flatQuads(clay, 450, false, 3, WorkPart(nullptr));
    ASSERT_EQ(made.mesh.quads, again.mesh.quads);
    ASSERT_EQ(made.mesh.positions, again.mesh.positions);
    const double own = lackOf(made.mesh, *made.maker);
    double most = 0;
    for (const size_t count : {size_t{450}, size_t{443}})
      for (const bool regular : {true, false}) {
        QuadMesh mesh = made.maker->make(WorkPart(nullptr), count, regular).mesh;
        unfoldQuads(mesh, made.maker->surface(), made.maker->tree(), made.maker->creases(), WorkPart(nullptr));
        fitQuads(mesh, made.maker->surface(), made.maker->tree(), made.maker->creases(), 1, WorkPart(nullptr));
        const double lack = lackOf(mesh, *made.maker);
        EXPECT_LT(own, 1.05 * lack) << count << (regular ? " regular" : " near");  // both ways, not from places alone
        most = std::max(most, lack);
      }
    EXPECT_GT(most, 1.1 * own) << "they differ";
  }
}

TEST(FlatQuads, LayoutsThatMayGoFartherHaveFewerIrregularVertices) {
  size_t near = 0, regular = 0;
  for (const Version& clay : {urchin(), potato()}) {
    const CageMaker maker(clay, 450, true, 2, WorkPart(nullptr));
    near += QuadTopology(maker.make(WorkPart(nullptr), 450, false).mesh).irregular();
    regular += QuadTopology(maker.make(WorkPart(nullptr), 450, true).mesh).irregular();
  }
  std::printf("%zu and %zu irregular vertices\n", near, regular);
  EXPECT_LT(regular, near);
}

TEST(WorkPart, BesideAnotherTellsNothingAndCanBeCancelled) {
  Job job;
  WorkPart(&job, 0.2, 0.6).step(0.5);
  const WorkPart beside = WorkPart(&job).beside().part(0.5, 1);
  beside.step(0.5);
  EXPECT_DOUBLE_EQ(job.fraction(), 0.4);
  job.cancel();
  EXPECT_THROW(beside.step(0.6), Cancelled);
}

TEST(FlatQuads, OfAMirroredClayAreMirrored) {
  for (const auto& [at, asked] : {std::pair{0.0, size_t{500}}, {3.75, size_t{2000}}, {-11.17, size_t{300}}}) {
    const FlatQuads made = flatQuads(beast(at, body(at)), asked, true, 2, WorkPart(nullptr));
    expectMirrored(made, 8);
    EXPECT_EQ(made.mirror->axis, 0);
    EXPECT_NEAR(made.mirror->atMm, at, 0.1);
    EXPECT_LE(made.mesh.quads.size(), asked);
    EXPECT_GE(double(made.mesh.quads.size()), 0.93 * double(asked));
    EXPECT_EQ(int64_t(made.mesh.positions.size()) - int64_t(made.mesh.quads.size()), 2);
    EXPECT_LT(deviation(made.maker->surface(), trianglesOf(made.mesh)).rmsMm, asked == 2000 ? 0.04 : 0.3);
  }
  const FlatQuads block =
      flatQuads(makeBlock(Store::make(), grid(), {1, 2, 3}, {30, 20, 12}, 0), 400, true, 2, WorkPart(nullptr));
  expectMirrored(block, 8);
  EXPECT_EQ(block.mesh.corners.size(), 8u);
  EXPECT_NEAR(creaseLength(block.mesh), 248, 0.5);
  const Version two = combine(makeSphere(Store::make(), grid(), {20, 0, 0}, 9),
                              makeSphere(Store::make(), grid(), {-20, 0, 0}, 9), Combination::join);
  const FlatQuads apart = flatQuads(two, 300, true, 2, WorkPart(nullptr));
  expectMirrored(apart, 0);
  EXPECT_EQ(int64_t(apart.mesh.positions.size()) - int64_t(apart.mesh.quads.size()), 4);
}

// One voxel more on one side, and they are not.
TEST(FlatQuads, OfAClayThatIsNoMirrorImageAreNot) {
  const Version clay =
      combine(beast(0, body(0)), makeSphere(Store::make(), grid(), {12, -9, 0}, 4.4), Combination::join);
  EXPECT_FALSE(flatQuads(clay, 300, true, 2, WorkPart(nullptr)).mirror);
}

TEST(FlatQuads, RefuseWhatCagesRefuse) {
  EXPECT_THROW((void)flatQuads(Version::empty(Store::make(), grid()), 9000, false, 2, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)flatQuads(potato(), 23, false, 2, WorkPart(nullptr)), Error);
  Job job;
  job.cancel();
  EXPECT_THROW((void)flatQuads(potato(), 9000, false, 2, WorkPart(&job)), Cancelled);
}

// How far the clay goes on from the quads, mm.
double farthestOf(const FlatQuads& made) {
  const TriangleMesh triangles = trianglesOf(made.mesh);
  const NearestTriangle tree(triangles);
  double most = 0;
  for (const Vec3d& p : made.maker->surface().positions) most = std::max(most, tree.nearest(p).squared);
  return std::sqrt(most);
}

/// Two hollows between walls of 0.5 to 0.8 mm.
Version tray(double voxelMm) {
  Version clay = makeBlock(Store::make(), grid(voxelMm), Vec3d::Zero(), {30, 20, 8}, 0);
  for (const double x : {-7.45, 7.45})
    clay =
        combine(clay, makeBlock(Store::make(), grid(voxelMm), Vec3d(x, 0, 3), {14.1, 18.6, 12.6}, 0), Combination::cut);
  return clay;
}

// The two sides of a thin wall lie so near to each other that a quad between them, within the wall, is near to both:
// row by row the wall would become lower until it is gone.
TEST(FlatQuads, KeepThinWalls) {
  const FlatQuads made = flatQuads(tray(0.3), 250, false, 2, WorkPart(nullptr));
  std::printf("%zu quads, %.2f mm off\n", made.mesh.quads.size(), farthestOf(made));
  EXPECT_EQ(made.tooFarMm, 0);
  EXPECT_LE(made.mesh.quads.size(), 250u);
  EXPECT_LT(farthestOf(made), 2);
}

// Nor is a wall left out that a coarse grid has no point in: bodies and handles are the same without it.
TEST(CageMaker, KeepsWallsThinnerThanItsGrid) {
  for (const double x : {0.0, 0.48}) {
    Version box = makeBlock(Store::make(), grid(0.2), Vec3d::Zero(), {18, 12, 8}, 0);
    box = combine(box, makeBlock(Store::make(), grid(0.2), Vec3d(0, 0, 3), {14, 8, 11}, 0), Combination::cut);
    box = combine(box, makeBlock(Store::make(), grid(0.2), Vec3d(x, 0, 0), {0.4, 12, 8}, 0), Combination::join);
    FlatQuads fine;
    fine.maker = std::make_unique<CageMaker>(box, 200, true, 2, WorkPart(nullptr));
    fine.mesh = fine.maker->make(WorkPart(nullptr), 3500).mesh;
    EXPECT_LT(farthestOf(fine), 1) << x;
  }
}

// 14 long legs cannot all be gone around by so few quads.
TEST(FlatQuads, AreMoreWhereSoFewWouldLeaveAPartOut) {
  const Version clay = urchin(32);
  const FlatQuads made = flatQuads(clay, 60, false, 2, WorkPart(nullptr));
  std::printf("%zu quads, %.2f mm off in place of %.2f\n", made.mesh.quads.size(), farthestOf(made), made.tooFarMm);
  const double edge = std::sqrt(areaOf(clay) / 60) * 0.5;
  EXPECT_GT(made.tooFarMm, edge);
  EXPECT_GT(made.mesh.quads.size(), 60u);
  EXPECT_LE(made.mesh.quads.size(), 240u);
  EXPECT_LT(farthestOf(made), 1.1 * edge);
}

// Four handles ask for more quads than that.
TEST(FlatQuads, AreMoreWhereSoFewDoNotGoAround) {
  Version clay = makeBlock(Store::make(), grid(0.5), Vec3d(0, 0, -4), {40, 30, 8}, 0);
  for (const Vec3d& at : {Vec3d(-7.5, -5, 1), Vec3d(7.5, -5, 1), Vec3d(-7.5, 5, 1), Vec3d(7.5, 5, 1)}) {
    clay = combine(clay, makeBlock(Store::make(), grid(0.5), at, {2.2, 4.5, 4.5}, 0), Combination::join);
    clay = combine(clay, makeBlock(Store::make(), grid(0.5), at, {4, 2, 2}, 0), Combination::cut);
  }
  const FlatQuads made = flatQuads(clay, 36, false, 2, WorkPart(nullptr));
  std::printf("%zu quads, %.2f mm off\n", made.mesh.quads.size(), farthestOf(made));
  EXPECT_EQ(made.tooFarMm, HUGE_VAL);
  EXPECT_GT(made.mesh.quads.size(), 36u);
  EXPECT_LE(made.mesh.quads.size(), 144u);
  EXPECT_EQ(made.maker->shape(), -3);
  EXPECT_LT(farthestOf(made), std::sqrt(areaOf(clay) / 36) * 0.5);
}

// The nearest flat quads of a cage around thin legs would fold; as they are moved none becomes worse than a corner of
// 14 degrees, or than it was.
TEST(FitQuads, FoldsNoQuad) {
  const CageMaker maker(urchin(), 500, false, 2, WorkPart(nullptr));
  const QuadMesh before = maker.make(WorkPart(nullptr)).mesh;
  QuadMesh after = before;
  fitQuads(after, maker.surface(), maker.tree(), maker.creases(), 2, WorkPart(nullptr));
  size_t moved = 0;
  for (size_t f = 0; f < after.quads.size(); ++f)
    EXPECT_GE(scaledJacobian(after, after.quads[f]), std::min(0.25, scaledJacobian(before, before.quads[f])) - 1e-12);
  for (size_t v = 0; v < after.positions.size(); ++v) moved += after.positions[v] != before.positions[v];
  EXPECT_GT(moved, after.positions.size() / 2);
}

// Quads around a peg whose corners lie close together would come nearest to the clay as a spike within it.
TEST(FitQuads, GoAroundPegs) {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 12);
  for (int i = 0; i < 10; ++i) {
    const double z = 1 - (2 * i + 1) / 10.0, round = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
    const Vec3d way(round * std::cos(turn), round * std::sin(turn), z);
    clay = combine(clay, makeRod(Store::make(), grid(), 10 * way, 18 * way, 2.2), Combination::join);
  }
  for (const size_t count : {220, 300, 400, 500}) {
    const CageMaker maker(clay, count, true, 2, WorkPart(nullptr));
    QuadMesh mesh = maker.make(WorkPart(nullptr)).mesh;
    const Deviation before = deviation(maker.surface(), trianglesOf(mesh));
    fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 2, WorkPart(nullptr));
    const Deviation after = deviation(maker.surface(), trianglesOf(mesh));
    EXPECT_LT(after.most(), before.most());
    EXPECT_LT(after.rmsMm, 0.7 * before.rmsMm);
  }
}

/// Thick limbs with round ends.
Version starfish() {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 14);
  for (const Vec3d& end : {Vec3d(34, 3, 1), Vec3d(-30, 12, 4), Vec3d(2, -31, 9), Vec3d(5, 8, 33)})
    clay = combine(clay, makeRod(Store::make(), grid(), 0.3 * end, end, 5), Combination::join, {.blendMm = 6});
  return clay;
}

// Where a limb has few quads their corners stand off its tip, since edges cut what is round: less where corners count.
TEST(FitQuads, HoldCornersNearWhereTheyCount) {
  const Version clay = starfish();
  double free = 0, held = 0;
  for (const size_t count : {60, 80, 100, 120}) {
    const CageMaker maker(clay, count, false, 2, WorkPart(nullptr));
    const QuadMesh cage = maker.make(WorkPart(nullptr), 0, true).mesh;
    const auto corner = [&](bool corners) {
      QuadMesh mesh = cage;
      fitQuads(mesh, maker.surface(), maker.tree(), maker.creases(), 1, WorkPart(nullptr), corners);
      double most = 0;
      for (const Vec3d& p : mesh.positions) most = std::max(most, maker.tree().nearest(p, UINT32_MAX).squared);
      return std::sqrt(most);
    };
    const double a = corner(false), b = corner(true);
    std::printf("%zu quads: %.2f, held %.2f mm\n", count, a, b);
    free += a, held += b;
  }
  EXPECT_LT(held, 0.85 * free);
}

// Sizes follow from how far the same quads lay off before: smaller at the tips of an egg, where it bends most.
TEST(FlatQuads, AreSmallerWhereTheClayBendsMore) {
  const Version egg = makeEllipsoid(Store::make(), grid(), Vec3d::Zero(), {30, 10, 10});
  const FlatQuads made = flatQuads(egg, 600, false, 2, WorkPart(nullptr));
  std::array<double, 2> area{}, count{};  // tips, waist
  for (const auto& q : made.mesh.quads) {
    const std::vector<Vec3d>& at = made.mesh.positions;
    const double x = std::abs((at[q[0]] + at[q[1]] + at[q[2]] + at[q[3]]).x()) / 4;
    if (x > 15 && x < 26) continue;
    const size_t where = x < 15 ? 1 : 0;
    area[where] += 0.5 * (at[q[2]] - at[q[0]]).cross(at[q[3]] - at[q[1]]).norm();
    count[where] += 1;
  }
  const double tip = area[0] / count[0], waist = area[1] / count[1];
  std::printf("quads of %.2f mm² at the tips, %.2f at the waist\n", tip, waist);
  EXPECT_LT(tip, waist);  // 1.5 times as large where they are fitted once
  EXPECT_GT(tip, 0.3 * waist);
}

// Corners count as places.
TEST(FlatQuads, HaveNoSpikesAtTipsOfLimbs) {
  double sum = 0;
  for (const size_t count : {60, 80, 100}) {
    const FlatQuads made = flatQuads(starfish(), count, false, 2, WorkPart(nullptr));
    double most = 0;
    for (const Vec3d& p : made.mesh.positions) most = std::max(most, made.maker->tree().nearest(p, UINT32_MAX).squared);
    std::printf("%zu quads: corners %.2f mm off\n", count, std::sqrt(most));
    sum += std::sqrt(most);
  }
  EXPECT_LT(sum, 5.1) << "5.7 with corners that are free alone";
}

}  // namespace
}  // namespace argil::clay
