// The program argil-bench, which `argil bench` starts: figures of this machine, beside other libraries'. Exit codes as
// of argil: 0 done, 1 the work failed, 2 the call is wrong.

#include <CLI/CLI.hpp>

#include <cstdio>

#include <fmt/format.h>

#include "bench/bench.h"
#include "clay/base/error.h"
#include "clay/base/interrupt.h"
#include "haptics/threads/guard.h"

namespace {

using namespace argil;

int run(int argc, char** argv) {
  CLI::App app{"Measures this machine, a day's work on it (day), or the feel of simulated devices (buzz, stability).",
               "argil bench"};
  bench::BenchOptions options;
  app.add_option("names", options.names, bench::benchNames() + "; all but day and stability when left out");
  app.add_option("--json", options.json, "Figures as JSON");
  app.add_option("--figure", options.figure, "Figure as SVG (buzz or stability)");
  app.add_flag("--overwrite", options.overwrite,
               "Replace figures and pages that exist already; without it they are refused");
  app.add_option("--largest", options.largest, "Million active voxels of the largest model")->capture_default_str();
  app.add_option("--seconds", options.seconds, "Of the paced servo")->capture_default_str();
  app.add_option(
         "--from", options.from,
         "tradeoff: a table measured before, in place of measuring; pairs: kept ratios, none to be exceeded by a fifth")
      ->check(CLI::ExistingFile);
  app.add_option("--folder", options.folder, "Where files are written; that of temporary files when left out");
  app.add_option("--stroke", options.longestS, "day: seconds of the hand in one stroke")->capture_default_str();
  app.add_option("--cell", options.cellSeconds, "day, edit-tools: a stroke that takes more seconds of work is cut off")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "day: threads of strokes; 0: as many as the studio takes")
      ->capture_default_str();
  app.add_option("--tips", options.tips, "day, edit-tools: radii of the tools' tips, voxels");
  app.add_option("--sculpts", options.sculpts, "cad: random sculpts")->capture_default_str();
  app.add_option("--hours", options.hours, "day: simulated hours")->capture_default_str();
  app.add_option("--tools", options.tools, "day, edit-tools: the tools that are measured; all when left out");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    fmt::print(stderr, "argil: bench: {}; see argil bench --help\n", e.what());
    return 2;
  }
  if (options.names.empty())
    fmt::print(stderr, "All but day and stability are measured, which takes an hour or more; a name measures one.\n");
  options.job = &interruptibleJob();
  bench::runBenchmarks(options);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const haptics::Guard guard;  // Before any thread: it zeroes the devices should this process die.
    return run(argc, argv);
  } catch (const Error& e) {
    fmt::print(stderr, "argil: bench: {}\n", e.what());
    return e.kind() == Error::Kind::input ? 2 : 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "argil: bench: {}\n", e.what());
    return 1;
  }
}
