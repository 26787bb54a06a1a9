// argil bench edit-tools: what a stamp of each tool costs, at any size of tip and model, beside what is asked of it.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {
namespace {

using namespace clay;

constexpr int kWarm = 20, kStamps = 140;
constexpr double kMostOfSphere = 0.6;  // a larger tip leaves too little of the sphere to go on
constexpr double kMostRatio = 5, kMostP99 = 4;

// A tool whose stamp may take so many times as long as that of another.
struct Bound {
  std::string_view tool, beside;
};
constexpr std::array kBounds = {
    Bound{.tool = "smooth", .beside = "carve"},  Bound{.tool = "scrape", .beside = "carve"},
    Bound{.tool = "fill", .beside = "carve"},    Bound{.tool = "flatten", .beside = "carve"},
    Bound{.tool = "tug", .beside = "smooth"},    Bound{.tool = "smudge", .beside = "smooth"},
    Bound{.tool = "pinch", .beside = "smooth"},  Bound{.tool = "twist", .beside = "smooth"},
    Bound{.tool = "crease", .beside = "smooth"},
};

struct Stamps {
  Samples times;
  double meanUs = 0;  // of one stamp, with its share of what the stroke's end leaves to do: redistancing trails
  uint64_t bricks = 0, bytes = 0;  // of one stamp
};

// A stroke once around the sphere and on, whose stamps are a tenth of a radius apart.
Stamps stampsOf(const BenchModel& model, const engine::ToolRow& row, double radius, const BenchOptions& options) {
  engine::Tool tool = engine::standardTool(row);
  tool.radiusMm = radius * model.version.grid().voxelMm;
  tool.heightMm = tool.radiusMm / 5;
  const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
  const double step = 0.1 * radius / model.radiusVoxels;
  const auto at = [&](int i) {
    return Vec3d(centre +
                 model.radiusVoxels * Vec3d(std::cos(0.3 + i * step), std::sin(0.3 + i * step), 0.2).normalized());
  };
  Stamps result;
  Store& store = *model.version.store();
  {
    BrushStroke stroke(model.version, engine::brushOf(tool, model.version.grid(), model.version));
    const Stopwatch all;
    uint64_t stamps = 0;
    for (int i = 0; i < kStamps && (i < 2 * kWarm || all.us() < 1e6 * options.cellSeconds); ++i, ++stamps) {
      if (options.job) options.job->step(0);
      Stamp stamp{at(i), at(i + 1), radius, static_cast<float>(tool.strength)};
      const Vec3d normal = (stamp.a - centre).normalized(), x = Vec3d(-normal.y(), normal.x(), 0).normalized();
      stamp.axes << x.cast<float>(), normal.cross(x).cast<float>(), normal.cast<float>();
      const Stopwatch watch;
      Version shown;
      stroke.apply(stamp);
      shown = stroke.publish();
      if (i >= kWarm) result.times.add(watch.us());
      shown = {};
      while (store.wantsCollecting() && store.collect()) {  // as a session does beside the edit thread
      }
    }
    result.bricks = stroke.touched() / stamps;
    result.bytes = stroke.counts().bytes() / stamps;
    const Stopwatch end;
    (void)stroke.finish();
    result.meanUs = result.times.mean() + end.us() / double(stamps);
  }
  while (store.collect()) {
  }
  return result;
}

}  // namespace

void benchEditTools(BenchReport& report, const BenchOptions& options) {
  const std::vector<double> tips = options.tips.empty() ? std::vector<double>{5, 20, 60, 200} : options.tips;
  std::vector<double> sizes;
  for (const double size : {1.0, 48.0, 200.0})
    if (size <= options.largest) sizes.push_back(size);
  if (sizes.empty()) sizes.push_back(options.largest);
  report.heading(
      fmt::format("each tool: a stamp in a stroke whose stamps are a tenth of a radius apart, redistancing included; "
                  "its mean is that of the stroke with its end; the edit alone, one thread; a stroke is cut off after "
                  "{:g} s.\n! beside a figure: more than {:g} "
                  "times the other tool's mean, or a p99 of more than {:g} times the median (where stamps are computed "
                  "together, those between cost next to nothing)",
                  options.cellSeconds, kMostRatio, kMostP99));
  for (const double size : sizes) {
    const BenchModel model = benchSphere(size);
    for (const double radius : tips) {
      if (radius > kMostOfSphere * model.radiusVoxels) continue;
      std::map<std::string, double, std::less<>> means;
      for (const engine::ToolRow& row : engine::toolTable()) {
        if (row.file != engine::ToolFile::none) continue;
        if (!options.tools.empty() && std::ranges::find(options.tools, row.id) == options.tools.end()) continue;
        const Stamps stamps = stampsOf(model, row, radius, options);
        const double median = stamps.times.median(), p99 = stamps.times.quantile(0.99), mean = stamps.meanUs;
        means.emplace(row.id, mean);
        BenchResult r = stamps.times.result(fmt::format("edit/tool-{}/{:g}/{}", row.id, radius, model.name));
        r.p99 = p99;
        r.bricks = stamps.bricks;
        r.bytes = stamps.bytes;
        r.note = fmt::format("mean {:.2f}; p99 {:.1f}{} × median, {:.1f} × mean", mean, p99 / median,
                             p99 > kMostP99 * median ? "!" : "", p99 / mean);
        const auto bound = std::ranges::find(kBounds, std::string_view(row.id), &Bound::tool);
        if (bound != kBounds.end())
          if (const auto other = means.find(bound->beside); other != means.end())
            r.note += fmt::format("; {:.1f}{} × {}", mean / other->second, mean > kMostRatio * other->second ? "!" : "",
                                  bound->beside);
        report.add(std::move(r));
      }
    }
  }
}

}  // namespace argil::bench
