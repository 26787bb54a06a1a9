// argil bench buzz: three contacts on a field that jumps within a voxel, and the figure of it.

#include <span>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/svg_chart.h"
#include "haptics/analysis/buzz.h"
#include "haptics/contact/contact.h"
#include "haptics/devices/sheets.h"
#include "io/bytes/atomic_file.h"

namespace argil::bench {

namespace {

constexpr double kZoomFromS = 1.4, kZoomToS = 1.6;

ChartSeries series(const std::string& name, int colour, const haptics::BuzzRun& run, double fromS, double toS,
                   double (*value)(const haptics::BuzzTick&)) {
  ChartSeries s;
  s.name = name;
  s.colour = colour;
  for (const haptics::BuzzTick& tick : run.ticks)
    if (tick.timeS >= fromS && tick.timeS <= toS) s.points.push_back({tick.timeS, value(tick)});
  return s;
}

double forceOf(const haptics::BuzzTick& tick) {
  return tick.force.z();
}
double heightOf(const haptics::BuzzTick& tick) {
  return tick.hand.z();
}

}  // namespace

void benchBuzz(BenchReport& report, const BenchOptions& options) {
  const haptics::DeviceSheet& sheet = haptics::deviceSheet("premium15");
  report.heading(
      fmt::format("buzz: {} N/mm at a wall that a threshold cut out, voxels of {} mm, hand and {} in closed loop, 1 "
                  "kHz, one tick of delay",
                  haptics::kBuzzStiffnessNmm, haptics::kBuzzVoxelMm, sheet.like));
  Chart chart;
  chart.title = "A field that jumps within a voxel, pressed and glided along";
  chart.panelWidth = 900;
  chart.panelHeight = 260;
  chart.panels.resize(3);
  const char* titles[] = {"Force upwards", "Height of the tool", "Force, a fifth of a second of it"};
  const char* labels[] = {"force, N", "height, mm", "force, N"};
  for (size_t i = 0; i < 3; ++i) {
    chart.panels[i].title = titles[i];
    chart.panels[i].x.label = "time, s";
    chart.panels[i].y.label = labels[i];
  }
  chart.panels[2].x.from = kZoomFromS;
  chart.panels[2].x.to = kZoomToS;
  int colour = 1;
  std::vector<std::string> caption = {
      fmt::format("Wall of 4 voxels of {} mm, cut out by a threshold; ball of {} mm, {} N/mm; simulated {} and hand, "
                  "1 kHz, one tick of delay.",
                  haptics::kBuzzVoxelMm, haptics::kBuzzBallMm, haptics::kBuzzStiffnessNmm, sheet.like)};
  for (const char* name : {"penalty", "god-object", "proxy"}) {  // The quiet ones on top.
    const haptics::BuzzRun run = haptics::runBuzz(name, sheet);
    const auto figure = [&](const char* what, const char* unit, double value) {
      BenchResult r;
      r.name = fmt::format("buzz/{}/{}", name, what);
      r.unit = unit;
      r.median = value;
      r.n = run.ticks.size();
      report.add(r);
    };
    figure("tick-to-tick-rms", "% of peak", run.jumpRms);
    figure("swing-rms", "mm", run.swingMm);
    figure("reversals", "1/s", run.reversals);
    figure("far-side", "ticks", run.popped);
    chart.panels[0].series.push_back(series(name, colour, run, 0, 10, forceOf));
    chart.panels[1].series.push_back(series(name, colour, run, 0, 10, heightOf));
    chart.panels[2].series.push_back(series(name, colour, run, kZoomFromS, kZoomToS, forceOf));
    caption.push_back(
        fmt::format("{}: force changes by {:.2f} % of the device's peak from tick to tick (RMS), the tool turns round "
                    "{:.0f} times a second.",
                    name, run.jumpRms, run.reversals));
    ++colour;
  }
  caption.push_back(
      "No safety and no passivity control: contact alone. Made by: argil bench buzz --figure docs/buzz.svg "
      "--overwrite");
  chart.caption = std::move(caption);
  if (options.figure.empty()) return;
  const std::string svg = chart.svg();
  io::AtomicFile out(options.figure);
  out.write(std::as_bytes(std::span(svg)));
  out.commit();
}

}  // namespace argil::bench
