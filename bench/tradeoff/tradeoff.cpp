// Speed against accuracy: every axis of a quality by itself, and many together, each with what it costs and how far its
// result is off; the front of both, and the presets that follow from it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "bench/bench.h"
#include "bench/tradeoff/front.h"
#include "bench/tradeoff/page.h"
#include "bench/tradeoff/work.h"
#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "engine/document/random.h"
#include "haptics/base/clock.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/output_files.h"

namespace argil::bench {

namespace {

using engine::Quality;
using engine::QualityAxis;
using engine::QualityPart;

// Values that an axis is tried at by itself, beside the one that it begins as.
struct Levels {
  std::string_view id;
  std::vector<double> values;
};
const std::vector<Levels>& levels() {
  static const std::vector<Levels> all{
      {"voxels-across", {96, 128, 192, 384, 512}},
      {"band", {2, 4, 6}},
      {"half-memory", {1}},
      {"spacing", {0.02, 0.05, 0.2, 0.4}},
      {"min-spacing", {0.1, 0.25, 1, 2}},
      {"tolerance", {0.01, 0.03, 0.3, 1}},
      {"passes", {2, 3, 4, 16}},
      {"drift", {0.25, 0.5, 2}},
      {"trail", {1, 4, 8, 32}},
      {"together", {0, 6, 24, 48}},
      {"flow-step", {0.02, 0.06, 0.25, 0.5, 1}},
      {"level-rounds", {1, 2, 5, 8}},
      {"contact-steps", {1, 2, 4, 16, 64}},
      {"contact-searches", {4, 8, 12, 40, 200}},
      {"smooth-normals", {0}},
      {"servo-hz", {250, 500, 2000, 4000}},
      {"surface", {0, 2}},
  };
  return all;
}

// What pays by itself, together.
std::vector<std::vector<std::pair<std::string_view, double>>> combinations() {
  std::vector<std::vector<std::pair<std::string_view, double>>> all;
  for (const double spacing : {0.05, 0.1, 0.2, 0.4})
    for (const double tolerance : {0.01, 0.1})
      for (const double drift : {1.0, 2.0})
        all.push_back({{"spacing", spacing}, {"tolerance", tolerance}, {"drift", drift}});
  for (const double across : {96.0, 192.0, 384.0})
    for (const double band : {2.0, 4.0}) all.push_back({{"voxels-across", across}, {"band", band}});
  for (const double steps : {2.0, 4.0})
    for (const double smooth : {0.0, 1.0})
      all.push_back({{"contact-steps", steps}, {"contact-searches", 8}, {"smooth-normals", smooth}});
  return all;
}

// Qualities of many axes at once: each axis is cut into as many slices as there are, and each slice is used once.
constexpr int kTogether[] = {6, 14, 10, 0};

std::vector<std::string> design(QualityPart part) {
  std::vector<std::string> points{""};
  std::set<std::string> known{""};
  const auto add = [&](const Quality& quality) {
    std::string axes = axesOf(quality, part);
    if (known.insert(axes).second) points.push_back(std::move(axes));
  };
  std::vector<const Levels*> own;
  for (const Levels& each : levels()) {
    const QualityAxis& axis = *engine::findQualityAxis(each.id);
    if (axis.part != part) continue;
    own.push_back(&each);
    for (const double value : each.values) {
      Quality quality;
      axis.row.set(quality, value);
      add(quality);
    }
  }
  for (const auto& values : combinations()) {
    Quality quality;
    for (const auto& [id, value] : values)
      if (const QualityAxis& axis = *engine::findQualityAxis(id); axis.part == part) axis.row.set(quality, value);
    add(quality);
  }
  const int count = kTogether[static_cast<size_t>(part)];
  engine::Random random(20 + static_cast<uint64_t>(part));
  std::vector<Quality> many(static_cast<size_t>(count));
  for (const Levels* each : own) {
    const QualityAxis& axis = *engine::findQualityAxis(each->id);
    std::vector<double> values = each->values;
    values.push_back(axis.row.get(Quality()));
    std::sort(values.begin(), values.end());
    std::vector<size_t> order(many.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    for (size_t i = 0; i < many.size(); ++i) axis.row.set(many[order[i]], values[i * values.size() / many.size()]);
  }
  for (const Quality& quality : many) add(quality);
  return points;
}

// Processor time of the calling thread: works run side by side, each in one thread.
class ThreadStopwatch {
 public:
  [[nodiscard]] double us() const { return static_cast<double>(haptics::threadWorkNs() - start_) * 1e-3; }

 private:
  int64_t start_ = haptics::threadWorkNs();
};

// A fixed piece of arithmetic of some fifty milliseconds: what the costs of a part's beginning are counted in.
double yardstick() {
  const ThreadStopwatch watch;
  constexpr size_t kNumbers = size_t{1} << 14;
  thread_local std::vector<float> numbers(kNumbers, 1.25f);
  for (int pass = 0; pass < 1200; ++pass)
    for (size_t i = 1; i + 1 < kNumbers; ++i)
      numbers[i] = 0.5f * numbers[i] + 0.25f * (numbers[i - 1] + numbers[i + 1]) + 1e-6f;
  volatile float kept = numbers[kNumbers / 2];
  (void)kept;
  return watch.us();
}

struct Cost {
  double median = 0, low = 0, high = 0;
  int runs = 0;
};

// Of ratios, with the ends of what the median would be in 95 of 100 drawings.
Cost costOf(const std::vector<double>& ratios) {
  const auto median = [](std::vector<double> v) {
    std::sort(v.begin(), v.end());
    const size_t half = v.size() / 2;
    return v.size() % 2 == 1 ? v[half] : 0.5 * (v[half - 1] + v[half]);
  };
  constexpr int kDrawings = 400;
  engine::Random random(7);
  std::vector<double> medians;
  for (int i = 0; i < kDrawings; ++i) {
    std::vector<double> drawn;
    for (size_t k = 0; k < ratios.size(); ++k) drawn.push_back(ratios[random.below(ratios.size())]);
    medians.push_back(median(drawn));
  }
  std::sort(medians.begin(), medians.end());
  return {median(ratios), medians[kDrawings / 40], medians[kDrawings - 1 - kDrawings / 40],
          static_cast<int>(ratios.size())};
}

// A partner before and after each run: what slows the machine slows both. What all begin as has the yardstick for a
// partner, and is the partner of everything else, as it asks the same of caches and memory.
Cost measured(TradeoffWork& work, const Quality& quality, const Cost* standard) {
  constexpr size_t kLeast = 3, kMost = 5;
  constexpr double kWithin = 0.02;
  const auto partner = [&] {
    if (!standard) return yardstick();
    const ThreadStopwatch watch;
    work.run({});
    return watch.us() / standard->median;
  };
  std::vector<double> ratios;
  Cost cost;
  work.run(quality);  // what is made once, and caches
  double before = partner();
  while (ratios.size() < kMost) {
    const ThreadStopwatch watch;
    work.run(quality);
    const double us = watch.us(), after = partner();
    ratios.push_back(2 * us / (before + after));
    before = after;
    if (ratios.size() < kLeast) continue;
    cost = costOf(ratios);
    if (cost.high - cost.low <= 2 * kWithin * cost.median) break;
  }
  work.run(quality);  // whose error is looked at
  return cost;
}

constexpr unsigned kMostThreads = 4;  // more wait for memory

constexpr QualityPart kParts[] = {QualityPart::clay, QualityPart::strokes, QualityPart::touch, QualityPart::surface};

// Refuses the folder whose page or table is there already; a table that is read again stays.
void requireFolder(const BenchOptions& options) {
  if (options.folder.empty()) return;
  io::Files outputs;
  for (const char* name : {"tradeoff.csv", "tradeoff.svg", "tradeoff.md"}) outputs.push_back(options.folder / name);
  std::error_code error;
  if (!options.from.empty() && std::filesystem::equivalent(options.from, outputs[0], error))
    outputs.erase(outputs.begin());
  io::requireNewFiles({&options.from, 1}, outputs, options.overwrite);
}

// The presets; beside a table that is in the folder already, how well each front covers the other; then what is there
// is replaced.
void finish(BenchReport& report, const std::vector<TradeoffRow>& rows, const std::filesystem::path& folder) {
  std::vector<TradeoffRow> kept;
  if (!folder.empty() && std::filesystem::exists(folder / "tradeoff.csv"))
    kept = readTradeoffCsv(folder / "tradeoff.csv");
  report.heading("presets, and how far this front and the one that is kept are off each other");
  for (const QualityPart part : kParts) {
    const auto now = pointsOf(rows, part), before = pointsOf(kept, part);
    const TradeoffPresets presets = presetsOf(now, part);
    BenchResult result;
    result.name = fmt::format("tradeoff/front/{}", engine::nameOf(part));
    result.unit = "×";
    result.n = frontOf(now).size();
    result.median = before.empty() ? 1 : std::max(coverage(frontOf(now), before), coverage(frontOf(before), now));
    result.note = fmt::format("draft [{}], balanced [{}], fine [{}]", presets.draft, presets.balanced, presets.fine);
    if (!before.empty()) {
      const TradeoffPresets then = presetsOf(before, part);
      result.note += then.draft == presets.draft && then.balanced == presets.balanced && then.fine == presets.fine
                         ? "; as kept"
                         : fmt::format("; kept are [{}], [{}], [{}]", then.draft, then.balanced, then.fine);
    }
    report.add(result);
  }
  if (!folder.empty()) writeTradeoff(rows, folder);
}

}  // namespace

void benchTradeoff(BenchReport& report, const BenchOptions& options) {
  if (!options.from.empty()) {
    if (options.folder.empty()) throw Error("tradeoff: --from makes a page again: give it a --folder");
    requireFolder(options);
    return finish(report, readTradeoffCsv(options.from), options.folder);
  }
  requireFolder(options);
  // Each work with all of its points, one after the other, as what they are measured by is the work itself.
  struct Task {
    QualityPart part;
    std::unique_ptr<TradeoffWork> work;
    std::vector<TradeoffRow> rows;
  };
  std::vector<Task> tasks;
  std::map<QualityPart, std::vector<std::string>> points;
  size_t all = 0;
  for (const QualityPart part : kParts) {
    points[part] = design(part);
    for (std::unique_ptr<TradeoffWork>& work : tradeoffWork(part)) {
      tasks.push_back({part, std::move(work), {}});
      all += points[part].size();
    }
  }
  std::mutex mutex;  // of the report, and of what is done
  size_t done = 0;
  const auto measure = [&](Task& task) {
    Cost standard;
    for (const std::string& axes : points[task.part]) {
      const Quality quality = qualityOf(axes);
      const Cost cost = measured(*task.work, quality, axes.empty() ? nullptr : &standard);
      if (axes.empty()) standard = cost;
      const TradeoffError error = task.work->error();
      task.rows.push_back({task.part, axes, task.work->name, error.rms, error.most, task.work->unit, cost.median,
                           cost.low, cost.high, error.bytes});
      BenchResult result;
      result.name = fmt::format("tradeoff/{}/{}/{}", engine::nameOf(task.part), axes.empty() ? "standard" : axes,
                                task.work->name);
      result.unit = "×";
      result.median = cost.median;
      result.n = static_cast<uint64_t>(cost.runs);
      result.note = fmt::format("off by {:.3g} {} RMS, {:.3g} at most", error.rms, task.work->unit, error.most);
      const std::lock_guard lock(mutex);
      report.add(result);
      if (options.job) options.job->step(static_cast<double>(++done) / static_cast<double>(all));
    }
    task.work.reset();
  };
  clay::parallelBlocks(
      tasks.size(), static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, kMostThreads)),
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) measure(tasks[i]);
      },
      1);
  // As a table: part by part, point by point.
  std::vector<TradeoffRow> rows;
  for (const QualityPart part : kParts)
    for (size_t point = 0; point < points[part].size(); ++point)
      for (const Task& task : tasks)
        if (task.part == part) rows.push_back(task.rows[point]);
  finish(report, rows, options.folder);
}

}  // namespace argil::bench
