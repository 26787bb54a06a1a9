// Operations on whole pieces as the studio and scripts call them.

#include "engine/tools/piece_jobs.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <utility>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "engine/document/beside.h"
#include "engine/session/workbench.h"

namespace argil::engine {
namespace {

clay::Version ball(double radius, const Vec3d& at = Vec3d::Zero(), double voxel = 0.5) {
  clay::Grid grid;
  grid.voxelMm = voxel;
  return clay::makeSphere(clay::Store::make(), grid, at, radius);
}

double volume(const clay::Version& version) {
  double sum = 0;
  for (const double v : clay::bodyVolumes(version)) sum += v;
  return sum;
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

TEST(PieceJobs, RowsAreNamedAndWithinTheirLimits) {
  std::set<std::string_view> ids;
  for (const PieceJob& row : pieceJobs()) {
    EXPECT_TRUE(ids.insert(row.id).second) << row.id;
    EXPECT_FALSE(row.name.empty() || row.help.empty() || row.doing.empty() || row.group.empty()) << row.id;
    EXPECT_EQ(row.help.back(), '.') << row.id;
    for (const auto& parameter : row.parameters) {
      EXPECT_LE(parameter.low, parameter.standard);
      EXPECT_LE(parameter.standard, parameter.high);
    }
  }
  for (const char* id : {"join", "cut", "intersect", "split", "offset", "shell", "smooth-all", "resample", "mirror",
                         "fill-voids", "remove-crumbs"})
    EXPECT_NE(findPieceJob(id), nullptr) << id;
  EXPECT_EQ(findPieceJob("melt-down"), nullptr);
}

// A sentence, or nothing to do; clay that is not there is not worked on.
TEST(PieceJobs, EmptyPiecesAreToldOf) {
  Document document = two();
  clay::Grid grid;
  for (Piece& piece : document.pieces) {
    piece.name = "Hollow";
    piece.version = clay::Version::empty(clay::Store::make(), grid);
  }
  for (const PieceJob& row : pieceJobs()) {
    if (row.pieces == 0) continue;
    SCOPED_TRACE(row.id);
    PieceArguments arguments = of(row, document);
    arguments.pointsMm = {{-5, 0, 0}, {5, 0, 0}, {0, 8, 0}};
    std::string said = "nothing";
    try {
      const PieceResult result = runPieceJob(row, document, arguments);
      for (const Piece& piece : result.changed) EXPECT_EQ(piece.version.stats().bricks, 0u);
    } catch (const Error& error) {
      said = error.what();
    }
    if (row.group == "Deform" || row.pieces == 2) {
      EXPECT_NE(said.find("Hollow is empty"), std::string::npos) << said;
    }
  }
}

TEST(PieceJobs, JoinsAcrossPosesAndVoxelSizes) {
  const Document before = two();
  const PieceJob& row = *findPieceJob("join");
  const PieceResult result = runPieceJob(row, before, of(row, before));
  Document after = before;
  applyPieceResult(result, before, after);
  ASSERT_EQ(after.pieces.size(), 1u);
  const double d = 12, lens = M_PI * std::pow(16 - d, 2) * (d * d + 2 * d * 16 - 3 * 16) / (12 * d);
  EXPECT_NEAR(volume(after.pieces[0].version) / (4.0 / 3 * M_PI * (1000 + 216) - lens), 1, 0.01);
}

// A piece's own rows stay; those that it lacks come behind them, and what is joined names them by their new numbers.
TEST(PieceJobs, JoiningBringsTheOthersMaterials) {
  Document before = two();
  const auto made = [](const clay::Version& clay, uint8_t material) {
    clay::Editor editor(clay);
    std::array<uint8_t, clay::kBrickVoxels> values;
    clay.forEachBrick([&](const clay::Brick& brick) {
      for (size_t v = 0; v < values.size(); ++v)
        values[v] = std::abs(brick.phi(int(v))) < clay.grid().band ? material : 0;
      editor.setChannel(clay::Channel::material, brick.coord, values);
    });
    return editor.commit();
  };
  MaterialRow chalk, rubber;
  chalk.name = "Chalk";
  rubber.name = "Rubber";
  before.pieces[0].materials = {chalk};
  before.pieces[1].materials = {chalk, rubber};
  before.pieces[1].version = made(before.pieces[1].version, 2);
  const struct {
    std::vector<MaterialRow> own, joined;
    int number;
  } cases[] = {{{chalk}, {chalk, rubber}, 2}, {{}, {chalk, rubber}, 2}, {{rubber}, {rubber, chalk}, 1}};
  for (const auto& each : cases) {
    before.pieces[0].materials = each.own;
    const PieceJob& row = *findPieceJob("join");
    Document after = before;
    applyPieceResult(runPieceJob(row, before, of(row, before)), before, after);
    ASSERT_EQ(after.pieces.size(), 1u);
    EXPECT_EQ(after.pieces[0].materials, each.joined);
    // Far out on the second ball.
    const clay::Version& joined = after.pieces[0].version;
    const Vec3d voxel = joined.grid().toVoxel(Vec3d(18, 0, 0));
    const Coord at{int(std::lround(voxel.x())), int(std::lround(voxel.y())), int(std::lround(voxel.z()))};
    EXPECT_EQ(joined.find(clay::Channel::material, at >> 3).value(clay::Brick::offset(at.x & 7, at.y & 7, at.z & 7)),
              each.number);
  }
}

TEST(PieceJobs, SplitMakesPiecesAndResampleSaysItsError) {
  Document document = two();
  document.pieces[1].pose.translation.x() = 30;
  const PieceJob &join = *findPieceJob("join"), &split = *findPieceJob("split"), &resample = *findPieceJob("resample");
  Document joined = document;
  applyPieceResult(runPieceJob(join, document, of(join, document)), document, joined);
  Document parts = joined;
  applyPieceResult(runPieceJob(split, joined, of(split, joined)), joined, parts);
  EXPECT_EQ(parts.pieces.size(), 2u);
  EXPECT_NEAR(volume(parts.pieces[1].version) / (4.0 / 3 * M_PI * 216), 1, 0.03);
  PieceArguments arguments = of(resample, joined);
  arguments.change<ResampleValues>().voxelMm = 1;
  const PieceResult result = runPieceJob(resample, joined, arguments);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_NE(result.notes[0].find("mm RMS"), std::string::npos);
}

TEST(PieceJobs, PrecisionGoesBothWaysAndSaysItsError) {
  Document document = two();
  const PieceJob& precision = *findPieceJob("precision");
  PieceArguments arguments = of(precision, document);
  const PieceResult result = runPieceJob(precision, document, arguments);
  ASSERT_EQ(result.changed.size(), 1u);
  ASSERT_EQ(result.notes.size(), 1u);
  // Half a step of band / 32 767, no more and no less, as some voxel of thousands lies in the middle of two.
  EXPECT_NE(result.notes[0].find("(4.6e-05 voxel)"), std::string::npos) << result.notes[0];
  const clay::Version fixed = result.changed[0].version;
  EXPECT_EQ(fixed.stats().precision, clay::Precision::fixed16);
  EXPECT_LT(double(fixed.stats().bytes()), 0.6 * double(document.pieces[0].version.stats().bytes()));
  Document after = document;
  applyPieceResult(result, document, after);
  EXPECT_TRUE(runPieceJob(precision, after, arguments).changed.empty()) << "it has that already";
  arguments.change<PrecisionValues>().precision = clay::Precision::float32;
  EXPECT_EQ(runPieceJob(precision, after, arguments).changed.at(0).version.stats().precision, clay::Precision::float32);
}

TEST(PieceJobs, RefusesWhatCannotBe) {
  Document document = two();
  const PieceJob &join = *findPieceJob("join"), &offset = *findPieceJob("offset");
  PieceArguments arguments = of(join, document);
  arguments.pieces.pop_back();
  EXPECT_THROW((void)runPieceJob(join, document, arguments), Error);
  arguments.pieces = {1, 1};
  EXPECT_THROW((void)runPieceJob(join, document, arguments), Error);
  arguments.pieces = {1, 99};
  EXPECT_THROW((void)runPieceJob(join, document, arguments), Error);
  arguments = of(offset, document);
  arguments.change<OffsetValues>().distanceMm = 1000;
  EXPECT_THROW((void)runPieceJob(offset, document, arguments), Error);
  document.pieces[0].locked = true;
  EXPECT_THROW((void)runPieceJob(offset, document, of(offset, document)), Error);
}

TEST(PieceJobs, WhatChangedMeanwhileStays) {
  const Document before = two();
  const PieceJob& offset = *findPieceJob("offset");
  const PieceResult result = runPieceJob(offset, before, of(offset, before));
  Document now = before;
  now.pieces[0].version = ball(9);
  EXPECT_THROW(applyPieceResult(result, before, now), Error);
}

TEST(PieceJobs, OneUndoStepInTheWorkbench) {
  Workbench::Options options;
  options.journal = false;
  options.realtime = false;
  Workbench bench(options);
  const auto settle = [&] {
    for (int i = 0; i < 3000 && (i < 3 || !bench.idle()); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  bench.addSphere(8, {.voxelMm = 0.5});
  settle();
  const DocumentPtr before = bench.snapshot()->document;
  ASSERT_EQ(before->pieces.size(), 1u);
  bench.operate("shell", standardArguments(*findPieceJob("shell"), *before));
  settle();
  const auto after = bench.snapshot();
  EXPECT_EQ(after->done, 2u);
  EXPECT_EQ(after->history->back(), "Shell");
  EXPECT_LT(volume(after->document->pieces[0].version), 0.7 * volume(before->pieces[0].version));
  bench.undo();
  settle();
  EXPECT_EQ(bench.snapshot()->document->pieces[0].version, before->pieces[0].version);
  bench.operate("nothing", {});
  const auto messages = bench.takeMessages();
  ASSERT_FALSE(messages.empty());
  EXPECT_EQ(messages.back().level, Message::Level::error);
}

// Voxels grow with the piece: no distance changes, so twice as large and half as large again is what there was, to the
// bit.
TEST(PieceJobs, ScaleIsExactAndWhatStandsGoesOnStanding) {
  Document document = Document::of(ball(10, {3, 4, 5}));
  document.pieces[0].pose.translation = {1, 2, 3};
  const PieceJob& row = *findPieceJob("scale");
  const auto scaledBy = [&](double percent) {
    PieceArguments arguments = of(row, document);
    row.parameters[0].change(arguments, percent);
    const PieceResult result = runPieceJob(row, document, arguments);
    Document after = document;
    applyPieceResult(result, document, after);
    return std::pair(after, result.notes);
  };
  const clay::BoxMm before = boundsOf(document.pieces[0]);
  const uint64_t hash = document.pieces[0].version.hash();
  const double size = volume(document.pieces[0].version);
  const auto [twice, notes] = scaledBy(200);
  const clay::BoxMm after = boundsOf(twice.pieces[0]);
  EXPECT_NEAR(after.low.z(), before.low.z(), 1e-9);
  EXPECT_NEAR((after.low + after.high).x(), (before.low + before.high).x(), 1e-9);
  EXPECT_NEAR((after.high - after.low).z(), 2 * (before.high - before.low).z(), 1e-9);
  EXPECT_NEAR(volume(twice.pieces[0].version), 8 * size, 1e-6 * size);
  EXPECT_EQ(twice.pieces[0].version.stats().bricks, document.pieces[0].version.stats().bricks);
  EXPECT_EQ(notes.size(), 1u);
  document = twice;
  const Document back = scaledBy(50).first;
  EXPECT_EQ(back.pieces[0].version.hash(), hash);
  EXPECT_NEAR((back.pieces[0].pose.translation - Vec3d(1, 2, 3)).norm(), 0, 1e-9);
  EXPECT_TRUE(runPieceJob(row, document, of(row, document)).changed.empty()) << "100 %";
  // Beyond what voxels may be: refused, nothing done.
  document = Document::of(ball(1000, Vec3d::Zero(), 50));
  PieceArguments huge = of(row, document);
  row.parameters[0].change(huge, 10000);
  EXPECT_THROW((void)runPieceJob(row, document, huge), Error);
}

// By a gizmo: the place about which a piece is scaled stays where it is, wherever it lies and however it is turned.
TEST(PieceJobs, ScaleAboutAPlaceLeavesThatPlaceWhereItIs) {
  const PieceJob& row = *findPieceJob("scale");
  for (const double percent : {50.0, 130.0, 200.0}) {
    for (const Vec3d& about : {Vec3d(0, 0, 0), Vec3d(4, 6, 8), Vec3d(-30, 12, 5)}) {
      Document document = Document::of(ball(10, {3, 4, 5}));
      document.pieces[0].pose.translation = {1, 2, 3};
      document.pieces[0].pose.rotation = Eigen::AngleAxisd(0.5, Vec3d(1, 2, -1).normalized());
      PieceArguments arguments = of(row, document);
      row.parameters[0].change(arguments, percent);
      arguments.change<ScaleValues>().aboutMm = about;
      const PieceResult result = runPieceJob(row, document, arguments);
      ASSERT_EQ(result.changed.size(), 1u);
      const Vec3d centre = document.pieces[0].pose.apply(Vec3d(3, 4, 5));
      const clay::BoxMm box = clay::boundsOf(result.changed[0].version);
      const Vec3d now = result.changed[0].pose.apply((box.low + box.high) / 2);
      EXPECT_LT((now - (about + percent / 100 * (centre - about))).norm(), 1e-6 * percent) << percent;
    }
  }
}

// A coarse bust and a fine ball: neither does the ball's voxel make the bust heavy, nor is its detail lost without a
// word.
TEST(PieceJobs, CombinationsSayWhatTheirVoxelsCost) {
  Document document = Document::of(ball(60, Vec3d::Zero(), 2));
  Piece fine;
  fine.name = "Ball";
  fine.version = ball(15, {60, 0, 0}, 0.5);
  document.add(fine);
  const Piece &bust = document.pieces[0], &small = document.pieces[1];
  const PieceJob &join = *findPieceJob("join"), &cut = *findPieceJob("cut");
  const uint64_t both = bust.version.stats().bytes() + small.version.stats().bytes();
  for (const bool turned : {false, true}) {
    const CombineCost cost = turned ? combineCost(join, small, bust, 0) : combineCost(join, bust, small, 0);
    EXPECT_GT(cost.voxelMm, 0.5);
    EXPECT_LT(cost.voxelMm, 2);
    EXPECT_LE(cost.bytes, 2.01 * double(both)) << "in whichever order they are named";
    PieceArguments arguments = of(join, document);
    if (turned) std::swap(arguments.pieces[0], arguments.pieces[1]);
    const PieceResult result = runPieceJob(join, document, arguments);
    EXPECT_DOUBLE_EQ(result.changed.at(0).version.grid().voxelMm, cost.voxelMm);
    EXPECT_NEAR(double(result.changed[0].version.stats().bytes()), double(cost.bytes), 0.5 * double(cost.bytes))
        << "about";
    ASSERT_FALSE(result.notes.empty());
    EXPECT_NE(result.notes[0].find("voxels of"), std::string::npos) << result.notes[0];
  }
  EXPECT_EQ(combineCost(cut, small, bust, 0).voxelMm, 0.5) << "what is cut into keeps its detail";
  EXPECT_EQ(combineCost(cut, bust, small, 0).voxelMm, 2);
  // As it is asked for.
  PieceArguments arguments = of(join, document);
  arguments.change<CombineValues>().voxelMm = 1;
  const PieceResult one = runPieceJob(join, document, arguments);
  EXPECT_EQ(one.changed.at(0).version.grid().voxelMm, 1);
  const double expected = 4.0 / 3 * 3.14159265358979 * 60 * 60 * 60;
  EXPECT_NEAR(volume(one.changed[0].version), expected, 0.05 * expected);
  EXPECT_EQ(combineCost(join, bust, small, 1).bytes, combineCost(join, small, bust, 1).bytes);
}

}  // namespace
}  // namespace argil::engine
