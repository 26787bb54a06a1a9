// What operations on whole pieces say that they take.

#include "engine/tools/piece_cost.h"

#include <gtest/gtest.h>

#include "clay/base/error.h"
#include "clay/base/memory_guard.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/resample.h"

namespace argil::engine {
namespace {

clay::Version ball(double radius, const Vec3d& at = Vec3d::Zero(), double voxel = 0.5) {
  clay::Grid grid;
  grid.voxelMm = voxel;
  return clay::makeSphere(clay::Store::make(), grid, at, radius);
}

Document two() {
  Document document = Document::of(ball(10));
  Piece other;
  other.name = "Other";
  other.version = ball(6, Vec3d::Zero(), 0.4);
  other.pose.translation = Vec3d(12, 0, 0);
  document.add(std::move(other));
  return document;
}

PieceArguments of(const PieceJob& row, const Document& document) {
  PieceArguments arguments = standardArguments(row, document);
  if (row.pieces == 2) arguments.pieces = {document.pieces[0].id, document.pieces[1].id};
  return arguments;
}

// What does something to clay says what it takes before; and twice the clay takes more.
TEST(PieceCosts, AreSaidBeforeTheWorkBegins) {
  const Document small = two();
  Document large = small;
  for (Piece& piece : large.pieces) {
    clay::Grid grid = piece.version.grid();
    grid.voxelMm /= 2;
    piece.version = clay::resample(piece.version, grid, Eigen::Isometry3d::Identity());
  }
  for (const PieceJob& row : pieceJobs()) {
    SCOPED_TRACE(row.id);
    if (row.id == "mask-hide" || row.id == "mask-show" || row.id == "mask-soften") continue;  // Of no mask: nothing.
    PieceArguments arguments = of(row, small);
    arguments.pointsMm = {{-5, 0, 0}, {5, 0, 0}, {0, 8, 0}};
    const PieceCost cost = costOf(row, small, arguments, MachineSpeed());
    EXPECT_GT(cost.coreSeconds, 0);
    EXPECT_LT(cost.coreSeconds, 60);
    // What only moves pieces makes no clay.
    EXPECT_EQ(cost.bytes > 0, row.group != "Mask" && row.id != "lay-flat" && row.id != "nest");
    const MachineSpeed slow{{160, 8, 1.5}};
    EXPECT_NEAR(costOf(row, small, arguments, slow).coreSeconds, 2 * cost.coreSeconds, 1e-9 * cost.coreSeconds);
    if (row.pieces == 0 || row.id == "resample" || row.pieces == 2) continue;  // Their voxels are said by hand.
    EXPECT_GT(costOf(row, large, arguments, MachineSpeed()).coreSeconds, 3 * cost.coreSeconds);
  }
}

// Clay that is made is as large as was said; the rest of what is said is for `argil bench costs`.
TEST(PieceCosts, TakeTheMemoryThatTheySaid) {
  const Document document = two();
  for (const char* id : {"join", "cut", "offset", "smooth-all", "resample", "cut-plane", "bend", "cylinder", "cone",
                         "ring", "ellipsoid"}) {
    SCOPED_TRACE(id);
    const PieceJob& row = *findPieceJob(id);
    const PieceArguments arguments = of(row, document);
    const PieceCost said = costOf(row, document, arguments, MachineSpeed());
    const PieceResult result = runPieceJob(row, document, arguments);
    double bytes = 0;
    for (const auto* pieces : {&result.changed, &result.added})
      for (const Piece& piece : *pieces) {
        clay::Surface surface(true, clay::Grade::crisp);
        surface.update(piece.version);
        bytes += static_cast<double>(piece.version.stats().bytes() + surface.usage().bytes);
      }
    EXPECT_GT(said.bytes, 0.55 * bytes);
    EXPECT_LT(said.bytes, 1.5 * bytes);
  }
}

TEST(PieceCosts, WhatDoesNotFitIsRefusedBeforeItBegins) {
  const Document document = two();
  const PieceJob& row = *findPieceJob("smooth-all");
  const PretendedMemory little([] { return MemoryRoom{uint64_t{8} << 30, MemoryGuard::kLeastReserve + (1 << 16)}; });
  try {
    (void)runPieceJob(row, document, of(row, document));
    FAIL() << "it fits into nothing";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("Smooth all of "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("of memory"), std::string::npos) << error.what();
  }
}

TEST(PieceCosts, AreSaidInFewWords) {
  EXPECT_EQ(sentence({0.01, 0}, 2), "less than 0.1 s");
  EXPECT_EQ(sentence({0.6, 2.1e8}, 2), "about 0.3 s, 210 MB");
  EXPECT_EQ(sentence({7.1, 5.83e10}, 1), "about 7 s, 58.3 GB");
  EXPECT_EQ(sentence({1200, 0}, 2), "about 10 min");
}

}  // namespace
}  // namespace argil::engine
