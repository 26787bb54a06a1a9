// argil bench plugins: what a brush costs that is a formula, or runs in a process of its own, beside the built-in one
// that does the same: edit alone, and edit to changed triangles. Each dab is made by all of them in turn.

#include <algorithm>
#include <random>
#include <vector>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/brush/formula.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/plugins/plugin.h"
#include "engine/saving/session.h"

namespace argil::bench {

namespace {

using namespace clay;

constexpr double kMillions = 12;
constexpr int kDabs = 300;
constexpr int kWarm = 10;

struct Way {
  std::string name;
  std::shared_ptr<const Brush> brush;
  Samples edit, all;
};

std::shared_ptr<const Brush> byFormula(const char* text) {
  auto brush = std::make_shared<Brush>();
  brush->operations.push_back({Property::distance, Method::formula});
  brush->formula = std::make_shared<const Formula>(text, std::vector<std::string>());
  return brush;
}

// A brush of an example's library, with its numbers as they begin.
std::shared_ptr<const Brush> byPlugin(const std::filesystem::path& folder) {
  const engine::Plugin plugin = engine::readPlugin(folder);
  const engine::Plugin::Brush& found = plugin.brushes.at(0);
  auto brush = std::make_shared<Brush>();
  brush->operations.push_back({Property::distance, Method::external});
  brush->external = std::make_shared<const engine::PluginBrush>(
      found.facts.value(), std::make_shared<engine::PluginProcesses>(engine::libraryOf(plugin, folder, {})));
  for (const auto& number : found.tool.numbers) brush->values.push_back(static_cast<float>(number.standard));
  return brush;
}

void dab(const BenchModel& model, Surface& surface, Way& way, const Vec3d& at, double radius, int threads,
         bool counts) {
  Version after;
  {
    // What begins and ends a stroke is no part of a dab.
    BrushStroke stroke(model.version, way.brush, {}, threads);
    const Stopwatch inside;
    stroke.apply({at, at, radius, 0.5f});
    after = stroke.publish();
    const double edit = inside.us();
    const Stopwatch drawn;
    (void)surface.update(after);
    if (counts) {
      way.edit.add(edit);
      way.all.add(edit + drawn.us());
    }
  }
  (void)surface.update(model.version);
  after = Version();
  while (model.version.store()->collect()) {
  }
}

}  // namespace

void benchPlugins(BenchReport& report, const BenchOptions& options) {
  if (options.folder.empty())
    throw Error("plugins: name the folder with the built examples: argil bench plugins --folder build/release/plugins");
  const BenchModel model = benchSphere(std::min(options.largest, kMillions));
  const int threads = options.threads > 0 ? options.threads : engine::Session::strokeThreads();
  Surface surface;
  (void)surface.update(model.version);
  const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
  // Up to 10 voxels the built-in smoothing takes the mean that the formula and the library have written down; at 20 it
  // takes that of wide-mean, its transcription there; beyond, wider ones.
  for (const double radius : {10.0, 20.0, 60.0}) {
    std::vector<Way> ways;
    ways.push_back({"built-in", Brush::of(Method::smooth), {}, {}});
    ways.push_back({"formula", byFormula("phi + weight * (mean - phi)"), {}, {}});
    ways.push_back({"library", byPlugin(options.folder / "soften.argil-plugin"), {}, {}});
    ways.push_back({"wide-mean", byPlugin(options.folder / "wide-mean.argil-plugin"), {}, {}});
    ways.push_back({"clay-strips", byPlugin(options.folder / "clay-strips.argil-plugin"), {}, {}});
    report.heading(fmt::format("Smoothing, {}, radius {:g} voxels, {} threads", model.name, radius, threads));
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    for (int i = -kWarm; i < kDabs; ++i) {
      const Vec3d at = centre + Vec3d(normal(random), normal(random), normal(random)).normalized() * model.radiusVoxels;
      for (size_t k = 0; k < ways.size(); ++k)
        dab(model, surface, ways[(k + static_cast<size_t>(i + kWarm)) % ways.size()], at, radius, threads, i >= 0);
      if (options.job) options.job->step(0);
    }
    for (const Way& way : ways)
      for (const bool all : {false, true}) {
        const Samples &mine = all ? way.all : way.edit, &peer = all ? ways[0].all : ways[0].edit;
        BenchResult result =
            mine.result(fmt::format("plugins/{}/{}/r{:g}", all ? "triangles" : "edit", way.name, radius));
        result.threads = threads;
        result.peer = peer.median();
        result.peerName = "built-in";
        result.ratio = peer.median() / mine.median();
        result.note = fmt::format("{:.2f} times the built-in", mine.median() / peer.median());
        report.add(result);
      }
  }
}

}  // namespace argil::bench
