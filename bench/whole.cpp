// argil bench whole: operations on a whole piece, how smoothly they tell their progress and how soon they stop.

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetRebuild.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "bench/peak_memory.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/store/vdb_bridge.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "engine/document/jobs.h"

namespace argil::bench {

namespace {

using namespace clay;

// The first pays for memory that the machine may never have given to anybody: it stands beside the median.
constexpr int kRuns = 3;
constexpr int kCancels = 3;
constexpr double kLatestCancelUs = 10e6;  // into the work
constexpr double kLargestRebuild = 12;    // million active voxels: the peer's seconds and memory
constexpr double kLargest = 64;
constexpr int kAlone = 400;  // dabs before and after
constexpr uint64_t kSeed = 20261120;
constexpr auto kLook = std::chrono::milliseconds(2);

using Operation = std::function<Version(Job*)>;

struct Run {
  double us = 0, cpuSeconds = 0, longestGapUs = 0;
  uint64_t memory = 0, bricks = 0;
};

struct Peer {
  double us;
  std::string name;
};

double cpuSeconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + double(t.tv_nsec) * 1e-9;
}

// What the hand does meanwhile: a dab on another piece, and its surface.
class Hand {
 public:
  Hand() : model_(benchSphere(1)), random_(kSeed) { surface_.update(model_.version); }
  void dab(Samples& samples) {
    std::normal_distribution<double> normal;
    const Vec3d at = model_.version.grid().toVoxel(Vec3d(3, 5, 7)) +
                     Vec3d(normal(random_), normal(random_), normal(random_)).normalized() * model_.radiusVoxels;
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
Run timed(const Operation& operation, Hand& hand, Samples& dabs) {
  Run run;
  const PeakMemory peak;
  const double all = cpuSeconds(CLOCK_PROCESS_CPUTIME_ID), own = cpuSeconds(CLOCK_THREAD_CPUTIME_ID);
  Stopwatch watch;
  engine::BackgroundJob job([&](Job& j) {
    const Version result = operation(&j);
    run.bricks = result.stats().bricks;
    run.memory = peak.bytes();
    run.us = watch.us();
  });
  double last = 0, seen = -1;
  while (!job.done()) {
    std::this_thread::sleep_for(kLook);
    hand.dab(dabs);
    const double now = watch.us(), fraction = job.job().fraction();
    if (fraction == seen) continue;
    run.longestGapUs = std::max(run.longestGapUs, now - last);
    last = now;
    seen = fraction;
  }
  job.wait();
  run.longestGapUs = std::max(run.longestGapUs, run.us - last);
  run.cpuSeconds = cpuSeconds(CLOCK_PROCESS_CPUTIME_ID) - all - (cpuSeconds(CLOCK_THREAD_CPUTIME_ID) - own);
  return run;
}

struct Cancel {
  double usableUs, freeUs;
};

// From cancel() to the end of the next dab, and to the end of the work.
Cancel cancelled(const Operation& operation, Hand& hand, double afterUs) {
  engine::BackgroundJob job([&](Job& j) { (void)operation(&j); });
  std::this_thread::sleep_for(std::chrono::microseconds(static_cast<int64_t>(afterUs)));
  Samples dab;
  Stopwatch watch;
  job.job().cancel();
  hand.dab(dab);
  const double usable = watch.us();
  while (!job.done()) std::this_thread::sleep_for(std::chrono::microseconds(200));
  const double free = watch.us();
  try {
    job.wait();
  } catch (const Cancelled&) {
  }
  return {usable, free};
}

void alone(Hand& hand, Samples& samples) {
  for (int i = 0; i < kAlone; ++i) {
    std::this_thread::sleep_for(kLook);
    hand.dab(samples);
  }
}

// `runs` times; `free` frees what is left after each.
void measure(BenchReport& report, Hand& hand, const std::string& name, int runs, const Operation& operation,
             const std::function<void()>& free, const Peer& peer) {
  Samples still, beside, times;
  alone(hand, still);
  Run first, worst;
  for (int i = 0; i < runs; ++i) {
    const Run run = timed(operation, hand, beside);
    free();
    times.add(run.us);
    if (i == 0) first = run;
    worst.longestGapUs = std::max(worst.longestGapUs, run.longestGapUs);
  }
  std::mt19937_64 random(kSeed);
  double usable = 0, threads = 0;
  for (int i = 0; i < kCancels; ++i) {
    const double at =
        std::min(times.median(), kLatestCancelUs) * std::uniform_real_distribution<double>(0.02, 0.9)(random);
    const Cancel cancel = cancelled(operation, hand, at);
    free();
    usable = std::max(usable, cancel.usableUs);
    threads = std::max(threads, cancel.freeUs);
  }
  alone(hand, still);
  BenchResult r;
  r.name = "whole/" + name;
  r.median = times.median();
  r.n = times.count();
  r.threads = static_cast<int>(std::thread::hardware_concurrency());
  r.peer = peer.us;
  r.peerName = peer.name;
  r.bricks = first.bricks;
  r.memory = first.memory;
  r.note = fmt::format(
      "the first {:.2f} s, of which threads had {:.2f} s of cores; longest between two reports {:.0f} ms; {} cancels "
      "at random: a dab done after {:.1f} ms, threads free after {:.0f} ms at most",
      first.us / 1e6, first.cpuSeconds, worst.longestGapUs / 1e3, kCancels, usable / 1e3, threads / 1e3);
  report.add(r);
  if (beside.count() < 20) return;
  BenchResult dabs = beside.result("whole/dab-beside-" + name);
  dabs.note = fmt::format("on another piece meanwhile; alone {:.0f} us median, {:.0f} us p99: {:.2f}× and {:.2f}×",
                          still.median(), still.quantile(0.99), beside.median() / still.median(),
                          beside.quantile(0.99) / still.quantile(0.99));
  report.add(dabs);
}

openvdb::FloatGrid::Ptr levelSet(const Version& v) {
  return std::static_pointer_cast<openvdb::FloatGrid>(toVdb(v).grid);
}

template <class Work>
double timeOf(const Work& work) {
  Stopwatch watch;
  work();
  return watch.us();
}

}  // namespace

void benchWhole(BenchReport& report, const BenchOptions& options) {
  const double size = std::min(options.largest, kLargest);
  const BenchModel model = benchSphere(size);
  const Version& sphere = model.version;
  const Grid& grid = sphere.grid();
  report.heading(fmt::format(
      "whole: operations on a sphere of 40 mm with {:.1f} million active voxels in {} bricks, all cores; seed {}",
      double(sphere.activeVoxels()) / 1e6, sphere.stats().bricks, kSeed));
  const Version other = makeSphere(Store::make(), grid, Vec3d(30, 20, 7), 35);

  Peer csg, rebuilt;
  {
    const auto a = levelSet(sphere), b = levelSet(other);
    openvdb::FloatGrid::Ptr joined;
    const double copied = timeOf([&] { joined = openvdb::tools::csgUnionCopy(*a, *b); });
    joined.reset();
    const double stolen = timeOf([&] { openvdb::tools::csgUnion(*a, *b); });
    csg = {copied, fmt::format("csgUnionCopy (min alone, distances are not made anew; csgUnion, which takes both grids "
                               "apart for it, {:.0f})",
                               stolen)};
  }
  {
    const double million = std::min(size, kLargestRebuild);
    const auto a = levelSet(benchSphere(million).version);
    rebuilt.us = timeOf([&] { (void)openvdb::tools::levelSetRebuild(*a, 0.0f, grid.band); });
    rebuilt.name = "levelSetRebuild of one side";
    if (million < size) {
      rebuilt.us *= size / million;
      rebuilt.name += fmt::format(" (that of {:g}M times {:.2f})", million, size / million);
    }
  }
  Hand hand;
  const auto freeSphere = [&] {
    while (sphere.store()->collect()) {
    }
  };
  measure(
      report, hand, "join/" + model.name, 7,
      [&](Job* job) { return combine(sphere, other, Combination::join, {}, job); }, freeSphere, csg);
  const double wall = 6 * grid.voxelMm;
  measure(
      report, hand, "shell-6-voxels/" + model.name, kRuns, [&](Job* job) { return shell(sphere, wall, 0, 0, job); },
      freeSphere, rebuilt);
  Grid coarse = grid;
  coarse.voxelMm *= 1.5;
  measure(
      report, hand, "resample-1.5/" + model.name, kRuns,
      [&](Job* job) { return resample(sphere, coarse, Eigen::Isometry3d::Identity(), 0, job); }, freeSphere, rebuilt);
  constexpr int kPasses = 10;
  Peer filtered;
  {
    const double million = std::min(size, kLargestRebuild);
    const auto a = levelSet(benchSphere(million).version);
    openvdb::tools::LevelSetFilter<openvdb::FloatGrid> filter(*a);
    filtered.us = timeOf([&] {
      for (int pass = 0; pass < kPasses; ++pass) filter.mean(1);
    });
    filtered.us *= size / million;
    filtered.name = fmt::format("LevelSetFilter::mean, {} times, with {:g}M", kPasses, million);
  }
  measure(
      report, hand, "smooth-all-10/" + model.name, kRuns,
      [&](Job* job) { return smoothAll(sphere, kPasses, true, 0, job); }, freeSphere, filtered);
}

}  // namespace argil::bench
