#include "bench/bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/day.h"
#include "clay/base/error.h"
#include "engine/document/machine_speed.h"
#include "engine/tools/tool_table.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/output_files.h"

namespace argil::bench {

namespace {

constexpr uint64_t kEnoughForP99 = 100, kEnoughForP999 = 1000;

struct Benchmark {
  std::string_view name;
  void (*run)(BenchReport& report, const BenchOptions& options);
  bool byDefault = true;
  bool draws = false;  // --figure
};

// Extremes and stability are not about this machine, their figures are the same everywhere; a day takes hours.
constexpr std::array kBenchmarks = {
    Benchmark{.name = "edit", .run = benchEdit},
    Benchmark{.name = "edit-tools", .run = benchEditTools, .byDefault = false},
    Benchmark{.name = "surface", .run = benchSurface},
    Benchmark{.name = "fine", .run = benchFine},
    Benchmark{.name = "touch", .run = benchTouch},
    Benchmark{.name = "render", .run = benchRender},
    Benchmark{.name = "save", .run = benchSave},
    Benchmark{.name = "undo", .run = benchUndo},
    Benchmark{.name = "io", .run = benchIo},
    Benchmark{.name = "whole", .run = benchWhole},
    Benchmark{.name = "day", .run = benchDay, .byDefault = false},
    Benchmark{.name = "day-strokes", .run = benchDayStrokes, .byDefault = false},
    Benchmark{.name = "day-pieces", .run = benchDayPieces, .byDefault = false},
    Benchmark{.name = "day-hours", .run = benchDayHours, .byDefault = false},
    Benchmark{.name = "day-import", .run = benchDayImport, .byDefault = false},
    Benchmark{.name = "buzz", .run = benchBuzz, .draws = true},
    Benchmark{.name = "extremes", .run = benchExtremes, .byDefault = false},
    Benchmark{.name = "costs", .run = benchCosts},
    Benchmark{.name = "pairs", .run = benchPairs, .byDefault = false},
    Benchmark{.name = "plugins", .run = benchPlugins, .byDefault = false},
    Benchmark{.name = "print", .run = benchPrint, .byDefault = false},
    Benchmark{.name = "cad", .run = benchCad, .byDefault = false},
    Benchmark{.name = "cad-quads", .run = benchCadQuads, .byDefault = false},
    Benchmark{.name = "looks", .run = benchLooks, .byDefault = false},
    Benchmark{.name = "tradeoff", .run = benchTradeoff, .byDefault = false},
    Benchmark{.name = "stability", .run = benchStability, .byDefault = false, .draws = true},
};

std::string machine() {
  if (const std::string name = engine::processorName(); !name.empty())
    return fmt::format("{}, {} cores", name, std::thread::hardware_concurrency());
  return fmt::format("{} cores", std::thread::hardware_concurrency());
}

}  // namespace

double Samples::quantile(double q) const {
  if (us_.empty()) return 0;
  const auto at =
      static_cast<ptrdiff_t>(std::min(q * static_cast<double>(us_.size()), static_cast<double>(us_.size() - 1)));
  std::nth_element(us_.begin(), us_.begin() + at, us_.end());
  return us_[static_cast<size_t>(at)];
}

double Samples::mean() const {
  return us_.empty() ? 0 : std::accumulate(us_.begin(), us_.end(), 0.0) / static_cast<double>(us_.size());
}

BenchResult Samples::result(std::string name) const {
  BenchResult r;
  r.name = std::move(name);
  r.n = us_.size();
  r.median = median();
  if (r.n >= kEnoughForP99) r.p99 = quantile(0.99);
  if (r.n >= kEnoughForP999) r.p999 = quantile(0.999);
  return r;
}

void BenchReport::heading(const std::string& text) const {
  fmt::print("\n{}\n", text);
}

void BenchReport::add(BenchResult r) {
  if (r.peer && !r.ratio && r.median > 0) r.ratio = *r.peer / r.median;
  std::string line = fmt::format("  {:<30} median {:>11.2f} {}", r.name, r.median, r.unit);
  if (r.p99) line += fmt::format("  p99 {:>9.2f}", *r.p99);
  if (r.p999) line += fmt::format("  p99.9 {:>9.2f}", *r.p999);
  line += fmt::format("  n {}", r.n);
  if (r.threads != 1) line += fmt::format("  threads {}", r.threads);
  if (r.peer) line += fmt::format("  | {} {:.2f}: {:.2f}×", r.peerName, *r.peer, *r.ratio);
  if (r.bricks) line += fmt::format("  bricks {}", *r.bricks);
  if (r.chunks) line += fmt::format("  nodes {}", *r.chunks);
  if (r.triangles) line += fmt::format("  triangles {}", *r.triangles);
  if (r.bytes) line += fmt::format("  bytes {}", *r.bytes);
  if (r.memory) line += fmt::format("  memory {}", *r.memory);
  if (r.hash) line += fmt::format("  hash {:016x}", *r.hash);
  if (!r.note.empty()) line += "  " + r.note;
  fmt::print("{}\n", line);
  std::fflush(stdout);  // A run of hours that is cut off has told what it knew.
  results_.push_back(std::move(r));
}

void BenchReport::write(const std::filesystem::path& file, const std::string& bench) const {
  nlohmann::ordered_json json;
  json["bench"] = bench;
  json["machine"] = machine();
  json["results"] = nlohmann::ordered_json::array();
  for (const BenchResult& r : results_) {
    nlohmann::ordered_json row;
    row["name"] = r.name;
    row["unit"] = r.unit;
    row["median"] = r.median;
    if (r.p99) row["p99"] = *r.p99;
    if (r.p999) row["p999"] = *r.p999;
    row["n"] = r.n;
    row["threads"] = r.threads;
    if (r.peer) row["peer"] = *r.peer;
    if (r.ratio) row["ratio"] = *r.ratio;
    if (r.bricks) row["bricks"] = *r.bricks;
    if (r.chunks) row["chunks"] = *r.chunks;
    if (r.triangles) row["triangles"] = *r.triangles;
    if (r.bytes) row["bytes"] = *r.bytes;
    if (r.memory) row["memory"] = *r.memory;
    if (r.hash) row["hash"] = fmt::format("{:016x}", *r.hash);
    json["results"].push_back(std::move(row));
  }
  const std::string text = json.dump(2) + "\n";
  io::AtomicFile out(file);
  out.write(std::as_bytes(std::span(text)));
  out.commit();
}

std::string benchNames() {
  std::string names;
  for (const Benchmark& each : kBenchmarks) names += (names.empty() ? "" : ", ") + std::string(each.name);
  return names;
}

void runBenchmarks(const BenchOptions& options) {
  std::vector<const Benchmark*> chosen;
  for (const std::string& name : options.names) {
    const auto row =
        std::find_if(kBenchmarks.begin(), kBenchmarks.end(), [&](const Benchmark& each) { return each.name == name; });
    if (row == kBenchmarks.end())
      throw Error(fmt::format("{}: there is no such benchmark; choose from {}", name, benchNames()));
    chosen.push_back(row);
  }
  if (options.names.empty())
    for (const Benchmark& each : kBenchmarks)
      if (each.byDefault) chosen.push_back(&each);
  if (!(options.largest >= 0.8 && options.largest <= 1000))
    throw Error("--largest: give 0.8 to 1000 million active voxels");
  if (!(options.seconds >= 1 && options.seconds <= 3600)) throw Error("--seconds: give 1 to 3600 s");
  if (!(options.longestS >= 1 && options.longestS <= 600)) throw Error("--stroke: give 1 to 600 s");
  if (!(options.cellSeconds > 0 && options.cellSeconds <= 3600)) throw Error("--cell: give up to 3600 s");
  if (!(options.threads >= 0 && options.threads <= 64)) throw Error("--threads: give 0 to 64");
  if (!(options.hours > 0 && options.hours <= 48)) throw Error("--hours: give up to 48 h");
  for (const double tip : options.tips)
    if (!(tip >= 1 && tip <= 1000)) throw Error("--tips: give radii of 1 to 1000 voxels");
  for (const std::string& tool : options.tools)
    if (!engine::findTool(tool)) throw Error(fmt::format("--tools: there is no tool {}; argil tools lists them", tool));
  const auto drawing = std::count_if(chosen.begin(), chosen.end(), [](const Benchmark* each) { return each->draws; });
  if (!options.figure.empty() && drawing != 1)
    throw Error("--figure: name one benchmark that draws a figure, buzz or stability");
  const io::Files outputs{options.json, options.figure};
  io::requireNewFiles({&options.from, 1}, outputs, options.overwrite);
  BenchReport report;
  std::string all;
  for (const Benchmark* each : chosen) {
    all += (all.empty() ? "" : " ") + std::string(each->name);
    each->run(report, options);
  }
  if (!options.json.empty()) report.write(options.json, all);
}

}  // namespace argil::bench
