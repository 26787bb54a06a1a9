// What instruction counts do not see, memory and threads, beside a yardstick of its kind that runs right before and
// after: ratios of processor time, which a busy machine leaves about as they are. Beside a line that is kept a gate.

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "clay/store/vdb_bridge.h"
#include "clay/surface/surface.h"
#include "engine/document/machine_speed.h"

namespace argil::bench {

namespace {

using namespace clay;

constexpr int kPairs = 15, kThreads = 2;
constexpr double kWorse = 1.2;  // times the kept ratio
constexpr double kDabMillions = 12, kSurfaceMillions = 3;

struct Pair {
  const char* name;
  const char* yardstick;
  std::function<void()> work, beside;
};

// Where dabs go: all over the ball, so that every one finds cold memory.
std::vector<Vec3d> places(const BenchModel& model, int count) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
  std::vector<Vec3d> all;
  while (static_cast<int>(all.size()) < count)
    all.push_back(centre + Vec3d(normal(random), normal(random), normal(random)).normalized() * model.radiusVoxels);
  return all;
}

// The last line of this processor: name, ratio.
std::map<std::string, double> kept(const std::filesystem::path& file, const std::string& processor) {
  std::ifstream in(file);
  std::map<std::string, double> ratios;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    std::string day, of, name, ratio;
    if (!std::getline(cells, day, ',') || !std::getline(cells, of, ',') || !std::getline(cells, name, ',') ||
        !std::getline(cells, ratio, ',') || of != processor)
      continue;
    try {
      ratios[name] = std::stod(ratio);
    } catch (const std::exception&) {
      throw Error(fmt::format("{}: {:?} is no ratio", file.string(), ratio));
    }
  }
  return ratios;
}

void collectAll(const Version& version) {
  while (version.store()->collect()) {
  }
}

}  // namespace

void benchPairs(BenchReport& report, const BenchOptions& options) {
  report.heading("memory and threads, beside a yardstick before and after");
  const BenchModel large = benchSphere(kDabMillions), small = benchSphere(kSurfaceMillions);
  const std::vector<Vec3d> at = places(large, 100);
  const auto brush = Brush::of(Method::carve);
  std::vector<std::byte> from(size_t{64} << 20), to(from.size());
  openvdb::initialize();
  const auto grid = std::static_pointer_cast<openvdb::FloatGrid>(toVdb(small.version).grid);
  const auto copy = [&] { std::memcpy(to.data(), from.data(), from.size()); };
  const auto threadedPeer = [&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kThreads);
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0, 0);
  };
  const std::vector<Pair> pairs{
      {"dabs", "memcpy of 64 MB",
       [&] {
         for (const Vec3d& p : at) {
           BrushStroke stroke(large.version, brush);
           stroke.apply({p, p, 20});
           (void)stroke.publish();
         }
         collectAll(large.version);
       },
       copy},
      {"stroke-threads", "memcpy of 64 MB",
       [&] {
         BrushStroke stroke(small.version, brush, {}, kThreads);
         for (int i = 0; i < 6; ++i) {
           const Vec3d way = (at[static_cast<size_t>(i)] - large.version.grid().toVoxel(Vec3d(3, 5, 7))).normalized();
           const Vec3d p = small.version.grid().toVoxel(Vec3d(3, 5, 7)) + way * small.radiusVoxels;
           stroke.apply({p, p, 120});
         }
         (void)stroke.finish();
         collectAll(small.version);
       },
       copy},
      {"surface-threads", "volumeToMesh",
       [&] {
         Surface surface;
         surface.update(small.version, kThreads);
       },
       threadedPeer},
  };
  const std::string here = engine::processorName();
  const auto before = options.from.empty() ? std::map<std::string, double>() : kept(options.from, here);
  std::string worse;
  for (const Pair& pair : pairs) {
    Samples ratios;
    const auto timed = [](const std::function<void()>& work) {
      const CoreStopwatch watch;
      work();
      return watch.us();
    };
    pair.work();
    double last = timed(pair.beside);
    for (int i = 0; i < kPairs; ++i) {
      if (options.job) options.job->step(i / double(kPairs));
      const double us = timed(pair.work), next = timed(pair.beside);
      ratios.add(2 * us / (last + next));
      last = next;
    }
    BenchResult result;
    result.name = fmt::format("pairs/{}", pair.name);
    result.unit = "×";
    result.n = kPairs;
    result.median = ratios.median();
    result.note =
        fmt::format("of {}; a quarter {:.3g} to {:.3g}", pair.yardstick, ratios.quantile(0.25), ratios.quantile(0.75));
    if (const auto it = before.find(pair.name); it != before.end()) {
      result.note += fmt::format("; kept {:.3g}, {:+.0f} %", it->second, 100 * (result.median / it->second - 1));
      if (result.median > kWorse * it->second) worse += (worse.empty() ? "" : ", ") + std::string(pair.name);
    } else if (!options.from.empty()) {
      result.note += "; nothing is kept of this processor";
    }
    report.add(result);
  }
  if (!worse.empty())
    throw Error(fmt::format("pairs: {} took more than {:.0f} % longer than what is kept", worse, 100 * (kWorse - 1)),
                Error::Kind::work);
}

}  // namespace argil::bench
