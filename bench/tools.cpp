// The part of `argil bench edit` that goes through the table of tools: what a stamp of each costs.

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "bench/tools.h"
#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "engine/tools/tool_table.h"

namespace argil::bench {
namespace {

using namespace clay;

constexpr double kRadius = 20;  // voxels
constexpr int kStamps = 120;

}  // namespace

void benchTools(BenchReport& report, const std::vector<double>& sizes, Job* job) {
  report.heading(
      fmt::format("each tool: a stamp of {} voxels in a stroke whose stamps are a tenth of a radius apart, "
                  "redistancing included; the edit alone, one thread",
                  kRadius));
  for (const double size : sizes) {
    const BenchModel model = benchSphere(size);
    const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
    const double step = 0.1 * kRadius / model.radiusVoxels;
    for (const engine::ToolRow& row : engine::toolTable()) {
      if (row.file != engine::ToolFile::none) continue;
      if (job) job->step(0);
      engine::Tool tool = engine::standardTool(row);
      tool.radiusMm = kRadius * model.version.grid().voxelMm;
      tool.heightMm = tool.radiusMm / 5;
      const auto brush = engine::brushOf(tool, model.version.grid(), model.version);
      Samples samples;
      Editor::Counts counts;
      uint64_t touched = 0;
      {
        BrushStroke stroke(model.version, brush);
        const auto at = [&](int i) {
          return Vec3d(centre + model.radiusVoxels *
                                    Vec3d(std::cos(0.3 + i * step), std::sin(0.3 + i * step), 0.2).normalized());
        };
        for (int i = 0; i < kStamps; ++i) {
          Stamp stamp{at(i), at(i + 1), kRadius, static_cast<float>(tool.strength)};
          const Vec3d normal = (stamp.a - centre).normalized(), x = Vec3d(-normal.y(), normal.x(), 0).normalized();
          stamp.axes << x.cast<float>(), normal.cross(x).cast<float>(), normal.cast<float>();
          Stopwatch watch;
          stroke.apply(stamp);
          const Version shown = stroke.publish();
          if (i >= 20) samples.add(watch.us());
        }
        counts = stroke.counts();
        touched = stroke.touched();
        (void)stroke.finish();
      }
      while (model.version.store()->collect()) {
      }
      BenchResult r = samples.result(fmt::format("edit/tool-{}/{}", row.id, model.name));
      r.bricks = touched / kStamps;
      r.bytes = counts.bytes() / kStamps;
      report.add(r);
    }
  }
}

}  // namespace argil::bench
