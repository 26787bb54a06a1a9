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
#include "clay/offset.h"
#include "clay/primitives.h"
#include "clay/resample.h"
#include "clay/store.h"
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
};

// Watches the job from beside it, as a face does.
Run timed(const Operation& operation) {
  Run run;
  Stopwatch watch;
  engine::BackgroundJob job([&](Job& j) { (void)operation(&j); });
  double last = 0, seen = -1;
  while (!job.done()) {
    std::this_thread::sleep_for(kLook);
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

void measure(BenchReport& report, const std::string& name, const Operation& operation, std::optional<double> peerUs, const char* peerName) {
  const Run run = timed(operation);
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
  measure(report, "join/" + model.name, [&](Job* job) { return freed(combine(sphere, other, Combination::join, {}, job)); }, csg, "csgUnion");
  const double wall = 6 * grid.voxelMm;
  measure(report, "shell-6-voxels/" + model.name, [&](Job* job) { return shell(sphere, wall, 0, 0, job); }, rebuilt, "levelSetRebuild of one side");
  Grid coarse = grid;
  coarse.voxelMm *= 1.5;
  measure(report, "resample-1.5/" + model.name, [&](Job* job) { return resample(sphere, coarse, Eigen::Isometry3d::Identity(), 0, job); }, rebuilt, "levelSetRebuild");
}

}  // namespace argil::cli
