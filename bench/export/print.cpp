// argil bench print: checks of a print, whole and after a stroke, beside walls measured on the mesh with a search tree.

#include <fmt/format.h>

#include <random>
#include <vector>

#include "bench/bench.h"
#include "bench/export/print_peers.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/field/necks.h"
#include "clay/field/primitives.h"
#include "clay/mesh/wall_thickness.h"
#include "clay/mould/best_pull.h"
#include "clay/mould/mould.h"
#include "clay/mould/pull_faces.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/surface/wall_map.h"
#include "clay/whole/boolean.h"
#include "engine/print/lay_flat.h"
#include "engine/print/print_check.h"
#include "engine/saving/session.h"

namespace argil::bench {

namespace {

using namespace clay;

constexpr int kDabs = 200;
constexpr int kRuns = 5;
constexpr double kLimitVoxels = 10;
constexpr size_t kPeerPoints = 20000;

// What carving strokes of one stamp cost the map that colours thin walls.
void strokes(BenchReport& report, const BenchOptions& options, const BenchModel& model, double radius, int threads) {
  Surface surface;
  WallMap map(kLimitVoxels, kLimitVoxels);
  map.follow(surface.update(model.version), threads);
  const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Samples map_, surface_;
  Version version = model.version;
  for (int i = 0; i < kDabs; ++i) {
    if (options.job) options.job->step(0);
    const Vec3d at = centre + Vec3d(normal(random), normal(random), normal(random)).normalized() * model.radiusVoxels;
    BrushStroke stroke(version, Brush::of(Method::carve));
    stroke.apply({at, at, radius});
    version = stroke.finish();
    const Stopwatch drawn;
    const SurfaceDelta delta = surface.update(version, threads);
    surface_.add(drawn.us());
    const Stopwatch measured;
    map.follow(delta, threads);
    map_.add(measured.us());
  }
  BenchResult result = map_.result(fmt::format("print/stroke/r{:g}/{}", radius, model.name));
  result.threads = threads;
  result.peer = surface_.median();
  result.peerName = "the surface";
  result.note =
      fmt::format("walls and gaps up to {:g} voxels; the surface itself {:.0f} us", kLimitVoxels, surface_.median());
  report.add(result);
}

// What it costs to look for ways out that are too narrow: of a solid ball, and of a hollow one with a bore.
void necks(BenchReport& report, const BenchOptions& options, const BenchModel& model, int threads) {
  const Grid& grid = model.version.grid();
  const Vec3d middle(3, 5, 7);
  const auto store = model.version.store();
  const double radius = model.radiusVoxels * grid.voxelMm, bore = 0.6 * kLimitVoxels * grid.voxelMm;
  const Version hollow = combine(
      combine(model.version, makeSphere(store, grid, middle, 0.8 * radius), Combination::cut),
      makeRod(store, grid, middle, middle + 2 * radius * Vec3d(0.3, 0.5, 0.8).normalized(), bore, 0), Combination::cut);
  for (const Version& clay : {model.version, hollow}) {
    Samples times;
    std::vector<Neck> found;
    for (int i = 0; i < kRuns; ++i) {
      const Stopwatch watch;
      found = narrowNecks(clay, kLimitVoxels * grid.voxelMm, threads, WorkPart(options.job));
      times.add(watch.us());
    }
    BenchResult result = times.result(fmt::format("print/necks/{}/{}", found.empty() ? "solid" : "hollow", model.name));
    result.threads = threads;
    result.note = found.empty() ? fmt::format("balls of radius {:g} voxels", kLimitVoxels)
                                : fmt::format("a bore of {:g} voxels, measured as {:.3g}", 0.6 * kLimitVoxels,
                                              found[0].radiusMm / grid.voxelMm);
    report.add(result);
  }
}

// What a mould of two halves costs, and the questions before it.
void moulds(BenchReport& report, const BenchOptions& options, const BenchModel& model, int threads) {
  Surface surface(false);
  (void)surface.update(model.version, threads);
  const TriangleMesh mesh = surface.toMesh();
  const double voxelMm = model.version.grid().voxelMm;
  const auto add = [&](const char* name, const Samples& times, std::string note) {
    BenchResult result = times.result(fmt::format("print/{}/{}", name, model.name));
    result.triangles = mesh.triangles.size();
    result.threads = threads;
    result.note = std::move(note);
    report.add(result);
  };
  Samples faces, best, mould, rests;
  const Vec3d pull = Vec3d(0.2, 0.3, 1).normalized();
  for (int i = 0; i < kRuns; ++i) {
    if (options.job) options.job->step(0);
    const Stopwatch watch;
    (void)pullFaces(mesh, pull, 0.1 * voxelMm, 2, threads);
    faces.add(watch.us());
    const Stopwatch laid;
    (void)engine::restsOf(model.version, {}, options.job);
    rests.add(laid.us());
  }
  add("pull", faces, "undercuts and draft along one direction");
  add("rests", rests, "ways to lie");
  const Stopwatch watch;
  const BestPull found = bestPull(mesh, voxelMm, threads, WorkPart(options.job));
  best.add(watch.us());
  add("best pull", best, fmt::format("{:.2g} % undercut", 100 * found.undercutShare));
  const Stopwatch making;
  const Mould made = makeMould(model.version, {.pull = Vec3d(Vec3d::UnitZ())}, threads, WorkPart(options.job));
  mould.add(making.us());
  add("mould", mould,
      fmt::format("{:.3g} mm3 undercut, {} keys, {} sprues, {} vents", made.undercutMm3, made.keys, made.sprues,
                  made.vents));
}

}  // namespace

void benchPrint(BenchReport& report, const BenchOptions& options) {
  const int threads = options.threads > 0 ? options.threads : engine::Session::strokeThreads();
  report.heading(fmt::format("A ball of 40 mm, and a shell of it, {} threads", threads));
  for (const double millions : benchSizes(std::min(options.largest, 12.0))) {
    const BenchModel model = benchSphere(millions);
    engine::PrintProcess process = engine::printProcess("sla");
    process.wallMm = process.gapMm = kLimitVoxels * model.version.grid().voxelMm;
    Samples whole, peer;
    for (int i = 0; i < kRuns; ++i) {
      const Stopwatch watch;
      (void)engine::checkPrint(model.version, {}, process, options.job);
      whole.add(watch.us());
    }
    Surface surface(false);
    (void)surface.update(model.version);
    const TriangleMesh mesh = surface.toMesh();
    const Stopwatch watch;
    (void)wallThickness(mesh, WorkPart(options.job), kPeerPoints, threads);
    peer.add(watch.us());
    BenchResult result = whole.result("print/whole/" + model.name);
    result.triangles = mesh.triangles.size();
    result.threads = threads;
    result.peer = peer.median();
    result.peerName = "walls alone, of 20 000 points of the mesh";
    result.ratio = peer.median() / whole.median();
    result.note =
        fmt::format("all checks, at each of {:.2f} M vertices", static_cast<double>(surface.vertexCount()) / 1e6);
    report.add(result);
    for (const double radius : {12.0, 50.0}) strokes(report, options, model, radius, threads);
    necks(report, options, model, threads);
    moulds(report, options, model, threads);
  }
  // Clay that is thin everywhere.
  const BenchModel model = benchSphere(benchSizes(options.largest).front());
  const Grid& grid = model.version.grid();
  const double inner = (model.radiusVoxels - 0.8 * kLimitVoxels) * grid.voxelMm;
  const Version shell =
      combine(model.version, makeSphere(Store::make(), grid, Vec3d(3, 5, 7), inner), Combination::cut);
  Surface surface;
  const SurfaceDelta delta = surface.update(shell, threads);
  Samples times;
  for (int i = 0; i < kRuns; ++i) {
    WallMap map(kLimitVoxels, kLimitVoxels);
    const Stopwatch watch;
    map.follow(delta, threads);
    times.add(watch.us());
  }
  BenchResult result = times.result("print/map/shell/" + model.name);
  result.threads = threads;
  result.note = fmt::format("a shell of eight voxels: {:.2f} us a vertex",
                            times.median() / static_cast<double>(surface.vertexCount()));
  report.add(result);
  benchPrintPeers(report, options);
}

}  // namespace argil::bench
