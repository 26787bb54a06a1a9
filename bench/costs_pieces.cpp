// What operations on whole pieces were said to take before they began, beside what they take.

#include <ctime>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/bench.h"
#include "bench/costs.h"
#include "bench/known_shapes.h"
#include "clay/base/job.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/tools/piece_cost.h"

namespace argil::bench {

namespace {

constexpr int kScenes = 3;  // of each operation

double processSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + double(t.tv_nsec) * 1e-9;
}

// A ball with a groove, and one beside it that overlaps.
engine::Document randomPieces(engine::Random& random) {
  engine::Document document;
  engine::Quality quality;
  for (int i = 0; i < 2; ++i) {
    if (i == 0 || random.unit() < 0.5)
      quality.clay.voxelsAcross = std::exp(random.between(std::log(150), std::log(400)));
    engine::Piece piece;
    piece.name = i == 0 ? "Ball" : "Other";
    piece.version = ballOf(quality, gridOf(quality));
    if (i == 0) piece.version = ringOn(kRings[1], piece.version, {});
    if (i == 1) piece.pose.translation = random.inBall() * kBallMm;
    document.add(std::move(piece));
  }
  return document;
}

// Values of a sensible use, from all over it.
engine::PieceArguments randomArguments(const engine::PieceJob& row, const engine::Document& document,
                                       engine::Random& random) {
  engine::PieceArguments arguments = engine::standardArguments(row, document);
  arguments.pieces.clear();
  for (int i = 0; i < row.pieces; ++i) arguments.pieces.push_back(document.pieces[static_cast<size_t>(i)].id);
  const double voxel = document.pieces[0].version.grid().voxelMm;
  // What is said of printing fits a model, and not any number: a peg must find room, a base be under it.
  const bool asStands = row.group == "Print";
  for (const auto& parameter : row.parameters) {
    double low = parameter.low, high = parameter.high;
    if (asStands && parameter.id != "kind" && parameter.id != "density") continue;
    if (parameter.id == "density") low = 10, high = 40;
    if (parameter.id == "distance") low = -3, high = 3;
    if (parameter.id == "inner" || parameter.id == "outer") low = 0.5, high = 3;
    if (parameter.id == "passes") low = 1, high = 10;
    if (parameter.id == "angle") low = -60, high = 60;
    if (parameter.id == "width") low = 30, high = 120;
    if (parameter.id == "blend") low = 0, high = 2;
    if (parameter.id == "voxel") low = voxel * 0.7, high = voxel * 2;
    if (parameter.unit == "mm" && row.makesNew() && parameter.id != "voxel") low = 8, high = 25;
    if (parameter.id == "tube") high = 7, low = 3;
    if (parameter.id == "round") low = 0, high = 3;
    if (parameter.id == "from") low = high = 0;
    if (parameter.id == "to") low = high = 100;
    if (parameter.id == "smooth") low = 0, high = 2;
    if (parameter.unit == "mm" && row.id == "mask-cavity") low = 1, high = 4;
    if (parameter.id.starts_with("points")) low = high = 4;
    // What fits both pieces, as often as not.
    const bool asSuits = parameter.id == "voxel" && row.pieces == 2 && random.unit() < 0.6;
    parameter.change(arguments, asSuits ? 0 : random.between(low, high));
  }
  arguments.plane = {random.inBall() * 5, random.inBall().normalized()};
  if (random.unit() < 0.5) arguments.plane.normal = Vec3d::Unit(static_cast<int>(random.below(3)));
  if (row.takesCurve && !row.takesBox)
    for (int i = 0; i < 12; ++i) arguments.pointsMm.push_back({12 * std::cos(0.5 * i), 9 * std::sin(0.5 * i), 0});
  arguments.closed = row.takesCurve && !row.takesBox;
  if (row.takesBox) {
    const Vec3d low = Vec3d::Constant(-1.1 * kBallMm), high = Vec3d::Constant(1.1 * kBallMm);
    arguments.change<engine::LatticeValues>().boxMm = std::array{low, high};
    for (int i = 0; i < 64; ++i) {
      const Vec3d t = Vec3d(i / 16, i / 4 % 4, i % 4) / 3;
      const bool inner = (t.array() > 0).all() && (t.array() < 1).all();
      arguments.pointsMm.push_back(low + t.cwiseProduct(high - low) + random.inBall() * (inner ? 2 : 0));
    }
  }
  return arguments;
}

// Half of the first piece.
void maskSome(engine::Document& document, engine::Random& random) {
  const engine::PieceJob& row = *engine::findPieceJob("mask-lasso");
  const engine::PieceArguments arguments = randomArguments(row, document, random);
  document.pieces[0] = engine::runPieceJob(row, document, arguments).changed.at(0);
}

// The first piece with walls of 3 mm around a hollow.
void hollowOut(engine::Document& document) {
  const engine::PieceJob& row = *engine::findPieceJob("shell");
  engine::PieceArguments arguments = engine::standardArguments(row, document);
  arguments.pieces = {document.pieces[0].id};
  for (const auto& parameter : row.parameters)
    if (parameter.id == "inner" || parameter.id == "outer")
      parameter.change(arguments, parameter.id == "inner" ? 3 : 0);
  document.pieces[0] = engine::runPieceJob(row, document, arguments).changed.at(0);
}

double bytesOf(const clay::Version& version) {
  clay::Surface surface(true, clay::Grade::crisp);
  surface.update(version);
  return static_cast<double>(version.stats().bytes() + surface.usage().bytes);
}

}  // namespace

void benchPieceCosts(BenchReport& report, const BenchOptions& options, const engine::MachineSpeed& machine) {
  report.heading("what operations were said to take, beside what they take");
  engine::Random random(12);
  std::vector<double> off[2];
  constexpr const char* kWhat[] = {"seconds", "bytes"};
  const auto rows = engine::pieceJobs();
  for (size_t i = 0; i < rows.size() * kScenes; ++i) {
    if (options.job) options.job->step(static_cast<double>(i) / static_cast<double>(rows.size() * kScenes));
    const engine::PieceJob& row = rows[i / kScenes];
    engine::Document document = randomPieces(random);
    if (row.group == "Mask") maskSome(document, random);
    if (row.id == "drain" || row.id == "infill") hollowOut(document);
    const engine::PieceArguments arguments = randomArguments(row, document, random);
    const engine::PieceCost said = engine::costOf(row, document, arguments, machine);
    const double from = processSeconds();
    engine::PieceResult made;
    try {
      made = engine::runPieceJob(row, document, arguments);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      report.heading(fmt::format("{} of scene {}: {}", row.id, i % kScenes, e.what()));
      continue;
    }
    double is[2] = {processSeconds() - from, 0};
    uint64_t in = 0, out = 0;
    for (const engine::Id id : arguments.pieces) in += document.piece(id)->version.stats().bricks;
    for (const auto* pieces : {&made.changed, &made.added})
      for (const engine::Piece& piece : *pieces) {
        const engine::Piece* before = document.piece(piece.id);
        if (before != nullptr && before->version == piece.version) continue;  // moved
        is[1] += bytesOf(piece.version);
        out += piece.version.stats().bricks;
      }
    const double predicted[2] = {said.coreSeconds, said.bytes};
    for (int k = 0; k < 2; ++k) {
      BenchResult result;
      result.name = fmt::format("costs/{}/{}/{}", row.id, i % kScenes, kWhat[k]);
      result.unit = "×";
      result.median = is[k] > 0 ? predicted[k] / is[k] : 1;
      std::string values;
      for (const auto& parameter : row.parameters)
        values += fmt::format(", {} {:.3g}", parameter.id, parameter.get(arguments));
      result.note = fmt::format("said {:.4g}, is {:.4g}; {} bricks, then {}; voxels of {:.3g} mm{}", predicted[k],
                                is[k], in, out, document.pieces[0].version.grid().voxelMm, values);
      // What takes no time is no matter, and what masks take is not said.
      if ((is[0] < 0.02 && predicted[0] < 0.02) || (k == 1 && row.group == "Mask")) continue;
      report.keep(result);
      off[k].push_back(result.median);
      if (std::abs(std::log(result.median)) > std::log(1.25)) report.add(result);
    }
  }
  for (int k = 0; k < 2; ++k) {
    BenchResult result;
    result.name = fmt::format("costs/operations/{}", kWhat[k]);
    result.unit = "×";
    result.n = off[k].size();
    const auto [least, most] = std::minmax_element(off[k].begin(), off[k].end());
    const auto within = std::count_if(off[k].begin(), off[k].end(),
                                      [](double each) { return std::abs(std::log(each)) <= std::log(1.25); });
    result.note =
        fmt::format("said over is: {:.2f} to {:.2f}, {} of {} within a quarter", *least, *most, within, off[k].size());
    std::nth_element(off[k].begin(), off[k].begin() + static_cast<ptrdiff_t>(off[k].size() / 2), off[k].end());
    result.median = off[k][off[k].size() / 2];
    report.add(result);
  }
}

}  // namespace argil::bench
