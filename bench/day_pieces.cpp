// argil bench day, part (b): what a piece costs when there are many.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bench/day.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/session.h"
#include "engine/session/surfaces.h"

namespace argil::bench {
namespace {

using namespace clay;

constexpr double kRadiusMm = 8, kVoxelMm = 0.5, kApartMm = 20;
constexpr int kStrokes = 40, kPoints = 60, kBatch = 4;

engine::Document documentOf(int count) {
  engine::Document document;
  const int edge = static_cast<int>(std::ceil(std::cbrt(count)));
  Grid grid;
  grid.voxelMm = kVoxelMm;
  for (int i = 0; i < count; ++i) {
    engine::Piece piece;
    piece.version = makeSphere(Store::make(), grid, Vec3d::Zero(), kRadiusMm);
    piece.pose.translation = kApartMm * Vec3d(i % edge, i / edge % edge, i / edge / edge);
    document.add(std::move(piece));
  }
  return document;
}

uint64_t clayBytes(const engine::Document& document) {
  uint64_t bytes = 0;
  for (const engine::Piece& piece : document.pieces) bytes += piece.version.stats().bytes();
  return bytes;
}

// As the edit loop does it: points, a version, a scene for the hand, the changed surface.
void stroke(engine::Session& session, engine::Surfaces& surfaces, int number, Samples& batches) {
  engine::Tool tool;
  tool.radiusMm = 1.5;
  session.beginStroke(tool);
  const haptics::Scene base;
  for (int i = 0; i < kPoints; i += kBatch) {
    const Stopwatch watch;
    for (int k = i; k < i + kBatch; ++k) {
      const double turn = 0.02 * k, lean = 0.15 * number;
      session.addPoint(0.004 * k, kRadiusMm * Vec3d(std::cos(turn) * std::cos(lean), std::sin(turn),
                                                    std::cos(turn) * std::sin(lean)));
    }
    session.publish();
    const engine::DocumentPtr now = session.document();
    const auto scene = std::make_unique<const haptics::Scene>(engine::sceneOf(*now, base));
    surfaces.follow(*now, 0);
    batches.add(watch.us());
    (void)surfaces.take();
  }
  const Stopwatch watch;
  session.endStroke();
  surfaces.follow(*session.document(), 0);
  batches.add(watch.us());
  (void)surfaces.take();
}

}  // namespace

void benchDayPieces(BenchReport& report, const BenchOptions& options) {
  const DayLimits limits;
  report.heading(
      fmt::format("day, pieces: spheres of {} mm, voxels of {} mm, each with a store of its own; a batch is {} points, "
                  "a version, a "
                  "scene and the changed surface; {} strokes of {} points, all undone and redone",
                  kRadiusMm, kVoxelMm, kBatch, kStrokes, kPoints));
  double alone = 0;
  for (const int count : {1, 64, 1000}) {
    if (options.job) options.job->step(0);
    const uint64_t before = bytesInUse();
    const Stopwatch making;
    engine::Document document = documentOf(count);
    const double madeUs = making.us();
    const uint64_t clay = clayBytes(document);
    const uint64_t made = bytesInUse() - before;
    engine::Session session(std::move(document));
    engine::Surfaces surfaces;
    surfaces.follow(*session.document(), 0);
    (void)surfaces.take();
    Samples batches, undo;
    for (int i = 0; i < kStrokes; ++i) stroke(session, surfaces, i, batches);
    for (const bool back : {true, false})
      for (int i = 0; i < kStrokes; ++i) {
        const Stopwatch watch;
        if (back)
          session.undo();
        else
          session.redo();
        surfaces.follow(*session.document(), 0);
        undo.add(watch.us());
        (void)surfaces.take();
      }
    if (count == 1) alone = batches.median();
    BenchResult r = batches.result(fmt::format("day/pieces/{}/batch", count));
    const double ratio = batches.median() / alone;
    r.note = fmt::format("{:.2f}× one piece's{}", ratio, ratio > limits.pieces ? " !" : "");
    report.add(std::move(r));
    r = undo.result(fmt::format("day/pieces/{}/undo", count));
    r.note = "undo or redo of a stroke, and its surface";
    report.add(std::move(r));
    r = {};
    r.name = fmt::format("day/pieces/{}/memory", count);
    r.unit = "bytes a piece";
    // Stores as small as these take their memory from malloc, so it is all in the figure.
    r.median = (double(made) - double(clay)) / count;
    r.n = static_cast<uint64_t>(count);
    r.bytes = clay / static_cast<uint64_t>(count);
    r.note = fmt::format("beside the clay of the piece (bytes){}; made in {:.1f} ms each",
                         r.median > double(limits.pieceBytes) ? " !" : "", madeUs / 1e3 / count);
    report.add(std::move(r));
  }
}

}  // namespace argil::bench
