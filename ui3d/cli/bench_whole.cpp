// argil bench whole: operations on a whole piece, how smoothly they tell their progress and how soon they stop.

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetRebuild.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "clay/boolean.h"
#include "clay/brush.h"
#include "clay/offset.h"
#include "clay/primitives.h"
#include "clay/resample.h"
#include "clay/store.h"
#include "clay/surface.h"
#include "clay/vdb_bridge.h"
#include "engine/jobs.h"
#include "ui3d/cli/bench.h"
#include "ui3d/cli/bench_models.h"

namespace argil::cli {

namespace {

using namespace clay;

constexpr int kCancels = 5;
constexpr uint64_t kSeed = 20261120;
constexpr auto kLook = std::chrono::milliseconds(2);

using Operation = std::function<Version(Job*)>;

struct Run {
  double us = 0, longestGapUs = 0;
  Samples dabs;
};

// What the hand does meanwhile: a dab on another piece, and its surface.
class Hand {
 public:
  Hand() : model_(benchSphere(1)), random_(kSeed) { surface_.update(model_.version); }
  void dab(Samples& samples) {
    std::normal_distribution<double> normal;
    const Vec3d at = model_.version.grid().toVoxel(Vec3d(3, 5, 7)) + Vec3d(normal(random_), normal(random_), normal(random_)).normalized() * model_.radiusVoxels;
    Version after;
    Stopwatch watch;
    {
      BrushStroke stroke(model_.version, brush_);
      stroke.apply({at, at, 20});
      after = stroke.publish();
    }
    surface_.update(after);
    samples.add(watch.us());
    surface_.update(model_.version);
    after = Version();
    while (model_.version.store()->collect()) {
    }
  }

 private:
  BenchModel model_;
  std::mt19937_64 random_;
  std::shared_ptr<const Brush> brush_ = Brush::of(Method::carve);
  Surface surface_;
};

// Watches the job from beside it, as a face does.
Run timed(const Operation& operation, Hand& hand) {
  Run run;
  Stopwatch watch;
  engine::BackgroundJob job([&](Job& j) { (void)operation(&j); });
  double last = 0, seen = -1;
  while (!job.done()) {
    std::this_thread::sleep_for(kLook);
    hand.dab(run.dabs);
    const double now = watch.us(), fraction = job.job().fraction();
    if (fraction == seen) continue;
    run.longestGapUs = std::max(run.longestGapUs, now - last);
    last = now;
    seen = fraction;
  }
  run.us = watch.us();
  run.longestGapUs = std::max(run.longestGapUs, run.us - last);
  job.wait();
  return run;
}

// Microseconds from cancel() to the return.
double cancelled(const Operation& operation, double afterUs) {
  engine::BackgroundJob job([&](Job& j) { (void)operation(&j); });
  std::this_thread::sleep_for(std::chrono::microseconds(static_cast<int64_t>(afterUs)));
  Stopwatch watch;
  job.job().cancel();
  try {
    job.wait();
  } catch (const Cancelled&) {
  }
  return watch.us();
}

void measure(BenchReport& report, Hand& hand, const std::string& name, const Operation& operation, std::optional<double> peerUs, const char* peerName) {
  Samples alone;
  for (int i = 0; i < 300; ++i) {
    std::this_thread::sleep_for(kLook);
    hand.dab(alone);
  }
  const Run run = timed(operation, hand);
  std::mt19937_64 random(kSeed);
  Samples cancels;
  for (int i = 0; i < kCancels; ++i) cancels.add(cancelled(operation, run.us * std::uniform_real_distribution<double>(0.02, 0.9)(random)));
  BenchResult r;
  r.name = "whole/" + name;
  r.median = run.us;
  r.n = 1;
  r.threads = static_cast<int>(std::thread::hardware_concurrency());
  r.peer = peerUs;
  r.peerName = peerName;
  r.note = fmt::format("longest between two reports {:.0f} ms; {} cancels at random: back after {:.0f} ms at most", run.longestGapUs / 1e3, kCancels,
                       cancels.quantile(1) / 1e3);
  report.add(r);
  if (run.dabs.count() < 20) return;
  BenchResult beside = run.dabs.result("whole/dab-beside-" + name);
  beside.note = fmt::format("on another piece meanwhile; alone {:.0f} us median, {:.0f} us p99: {:.2f}× and {:.2f}×", alone.median(), alone.quantile(0.99),
                            run.dabs.median() / alone.median(), run.dabs.quantile(0.99) / alone.quantile(0.99));
  report.add(beside);
}

}  // namespace

void benchWhole(BenchReport& report, const BenchOptions& options) {
  const double size = std::min(options.largest, 48.0);
  report.heading(fmt::format("whole: operations on a sphere of 40 mm with {:g} million active voxels, all cores; seed {}", size, kSeed));
  const BenchModel model = benchSphere(size);
  const Version& sphere = model.version;
  const Grid& grid = sphere.grid();
  const Version other = makeSphere(Store::make(), grid, Vec3d(30, 20, 7), 35);
  const auto levelSet = [](const Version& v) { return std::static_pointer_cast<openvdb::FloatGrid>(toVdb(v).grid); };

  double csg, rebuilt;
  {
    const auto a = levelSet(sphere), b = levelSet(other);
    Stopwatch watch;
    openvdb::tools::csgUnion(*a, *b);
    csg = watch.us();
  }
  {
    const auto a = levelSet(sphere);
    Stopwatch watch;
    (void)openvdb::tools::levelSetRebuild(*a, 0.0f, grid.band);
    rebuilt = watch.us();
  }
  const auto freed = [&](Version v) {  // what a cancelled or finished run leaves in the sphere's store
    v = Version();
    while (sphere.store()->collect()) {
    }
    return v;
  };
  Hand hand;
  measure(report, hand, "join/" + model.name, [&](Job* job) { return freed(combine(sphere, other, Combination::join, {}, job)); }, csg, "csgUnion");
  const double wall = 6 * grid.voxelMm;
  measure(report, hand, "shell-6-voxels/" + model.name, [&](Job* job) { return shell(sphere, wall, 0, 0, job); }, rebuilt, "levelSetRebuild of one side");
  Grid coarse = grid;
  coarse.voxelMm *= 1.5;
  measure(report, hand, "resample-1.5/" + model.name, [&](Job* job) { return resample(sphere, coarse, Eigen::Isometry3d::Identity(), 0, job); }, rebuilt, "levelSetRebuild");
}

}  // namespace argil::cli
