// Cuts, deformations and new pieces as rows of the table.

#include <gtest/gtest.h>

#include <cmath>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/deform.h"
#include "clay/whole/lattice.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {
namespace {

clay::TopologyReport topology(const clay::Version& version) {
  clay::Surface surface;
  surface.update(version);
  return clay::checkTopology(surface.toMesh());
}

// A block whose piece is turned by a right angle about z and moved: what is given in the world must arrive in it.
Document blockDocument() {
  Document document = Document::of(clay::makeBlock(clay::Store::make(), clay::Grid{}, Vec3d::Zero(), {30, 20, 10}, 1));
  document.pieces[0].pose = {Vec3d(100, 0, 0),
                             Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()))};
  return document;
}

PieceArguments argumentsFor(std::string_view row, const Document& document) {
  return standardArguments(*findPieceJob(row), document);
}

TEST(DeformJobs, APlaneInTheWorldKeepsTheSideThatItFaces) {
  Document document = blockDocument();
  PieceArguments arguments = argumentsFor("cut-plane", document);
  arguments.plane = {Vec3d(100, 5, 0), Vec3d(0, 1, 0)};  // The piece's x is the world's y: 10 of 30 mm stay.
  const PieceResult result = runPieceJob(*findPieceJob("cut-plane"), document, arguments);
  ASSERT_EQ(result.changed.size(), 1u);
  const clay::TopologyReport report = topology(result.changed[0].version);
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.low.x(), 5, 0.05);
  EXPECT_NEAR(report.high.x(), 15, 0.05);

  arguments.change<CutValues>().keep = 0;
  const PieceResult both = runPieceJob(*findPieceJob("cut-plane"), document, arguments);
  ASSERT_EQ(both.added.size(), 1u);
  EXPECT_NEAR(topology(both.added[0].version).high.x(), 5, 0.05);
  EXPECT_NE(both.added[0].version.store(), document.pieces[0].version.store());
  const Document before = document;
  applyPieceResult(both, before, document);
  EXPECT_EQ(document.pieces.size(), 2u);

  arguments.plane.pointMm.y() = 50;
  EXPECT_THROW((void)runPieceJob(*findPieceJob("cut-plane"), before, arguments), Error);
  arguments.change<CutValues>().keep = -1;
  EXPECT_THROW((void)runPieceJob(*findPieceJob("cut-plane"), before, arguments), Error);
}

TEST(DeformJobs, ALassoInTheWorldPunches) {
  const Document document = blockDocument();
  PieceArguments arguments = argumentsFor("cut-curve", document);
  arguments.closed = true;
  arguments.directionMm = -Vec3d::UnitZ();
  for (int i = 0; i < 40; ++i)
    arguments.pointsMm.push_back(Vec3d(100 + 4 * std::cos(i * 0.15708), 8 + 4 * std::sin(i * 0.15708), 50));
  const PieceResult result = runPieceJob(*findPieceJob("cut-curve"), document, arguments);
  const clay::TopologyReport report = topology(result.changed.at(0).version);
  EXPECT_NEAR(report.low.x(), 4, 0.1);  // World y 4 to 12.
  EXPECT_NEAR(report.high.x(), 12, 0.1);
  EXPECT_NEAR(report.high.y(), 4, 0.1);
}

TEST(DeformJobs, BendTwistTaperAndLatticeChangeThePieceAlone) {
  const Document document = blockDocument();
  for (const char* id : {"bend", "twist", "taper"}) {
    PieceArguments arguments = argumentsFor(id, document);
    arguments.change<AlongValues>().axis = 1;  // Along x.
    const PieceResult result = runPieceJob(*findPieceJob(id), document, arguments);
    ASSERT_EQ(result.changed.size(), 1u) << id;
    EXPECT_EQ(result.changed[0].id, document.pieces[0].id);
    EXPECT_NE(result.changed[0].version.hash(), document.pieces[0].version.hash()) << id;
    EXPECT_TRUE(topology(result.changed[0].version).closed()) << id;
    arguments.change<AlongValues>().from = 90;
    arguments.change<AlongValues>().to = 20;
    EXPECT_THROW((void)runPieceJob(*findPieceJob(id), document, arguments), Error) << id;
  }
  PieceArguments arguments = argumentsFor("lattice", document);
  EXPECT_THROW((void)runPieceJob(*findPieceJob("lattice"), document, arguments), Error);
  const Piece& piece = document.pieces[0];
  clay::Lattice box = clay::Lattice::around(clay::brickBoundsOf(piece.version));
  // All of it, up.
  for (const Vec3d& p : box.points()) arguments.pointsMm.push_back(piece.pose.apply(p + Vec3d(0, 0, 3)));
  const PieceResult result = runPieceJob(*findPieceJob("lattice"), document, arguments);
  EXPECT_NEAR(topology(result.changed.at(0).version).high.z(), 8, 0.05);
}

// The piece is turned by a right angle, so that its 30 mm lie along the world's y, its 20 mm along x.
TEST(DeformJobs, AStretchChangesOneLengthOfTheWorldAndKeepsItsPlane) {
  const Document document = blockDocument();
  const Vec3d size(20, 30, 10), low = Vec3d(100, 0, 0) - size / 2;
  const double before = topology(document.pieces[0].version).volume;
  for (int axis = 0; axis < 3; ++axis)
    for (const double factor : {0.13, 0.4, 1.3, 2.5, 7.9}) {
      SCOPED_TRACE(testing::Message() << axis << " × " << factor);
      PieceArguments arguments = argumentsFor("stretch", document);
      arguments.plane = {low, 3 * Vec3d::Unit(axis)};
      arguments.change<ScaleValues>().percent = 100 * factor;
      const PieceResult result = runPieceJob(*findPieceJob("stretch"), document, arguments);
      const clay::TopologyReport report = topology(result.changed.at(0).version);
      EXPECT_TRUE(report.closed());
      // Pressed to a rim far below a voxel: a third of one.
      const double tolerance = factor < 0.2 ? 0.15 : 0.06;
      EXPECT_NEAR(report.volume / before, factor, (factor < 0.2 ? 0.03 : 0.01) * factor);
      const haptics::Pose& pose = result.changed[0].pose;
      const Vec3d a = pose.apply(report.low), b = pose.apply(report.high);
      Vec3d expected = low + size;
      expected[axis] = low[axis] + factor * size[axis];
      EXPECT_LT((a.cwiseMin(b) - low).cwiseAbs().maxCoeff(), tolerance) << "what lies on the plane stays";
      EXPECT_LT((a.cwiseMax(b) - expected).cwiseAbs().maxCoeff(), tolerance);
      EXPECT_EQ(result.notes.size(), 1u);
    }
  // Slanted, through the middle: the volume alone is known.
  PieceArguments arguments = argumentsFor("stretch", document);
  arguments.plane = {Vec3d(100, 0, 0), Vec3d(1, 2, -1)};
  arguments.change<ScaleValues>().percent = 170;
  const PieceResult slanted = runPieceJob(*findPieceJob("stretch"), document, arguments);
  EXPECT_NEAR(topology(slanted.changed.at(0).version).volume / before, 1.7, 0.017);
  arguments.change<ScaleValues>().percent = 100;
  EXPECT_TRUE(runPieceJob(*findPieceJob("stretch"), document, arguments).changed.empty());
}

TEST(DeformJobs, NewPiecesAreClosedSolidsOfTheirSize) {
  const Document document;
  const double pi = 3.141592653589793;
  const std::pair<const char*, double> expected[] = {{"cylinder", pi * 400 * 50},
                                                     {"cone", pi * 625 * 50 / 3},
                                                     {"ring", 2 * pi * pi * 25 * 64},
                                                     {"ellipsoid", 4.0 / 3 * pi * 30 * 20 * 15}};
  for (const auto& [id, volume] : expected) {
    PieceArguments arguments = argumentsFor(id, document);
    const PieceResult result = runPieceJob(*findPieceJob(id), document, arguments);
    const clay::TopologyReport report = topology(result.added.at(0).version);
    EXPECT_TRUE(report.closed()) << id;
    EXPECT_NEAR(report.volume / volume, 1, 0.01) << id;
    arguments.change<SolidValues>().voxelMm = 900;
    EXPECT_THROW((void)runPieceJob(*findPieceJob(id), document, arguments), Error) << id;
  }
}

}  // namespace
}  // namespace argil::engine
