#include "bench/tradeoff/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "bench/svg_chart.h"
#include "io/bytes/atomic_file.h"

namespace argil::bench {

namespace {

using engine::QualityAxis;
using engine::QualityPart;

struct Part {
  QualityPart part;
  const char* title;
  const char* about;
};
constexpr std::array kParts{
    Part{QualityPart::clay, "Clay as it is made",
         "A ball of 20 mm, with a groove, a rim and a ridge around it, known in closed form; scans beside their mesh. "
         "Error: how far the crisp surface lies off, both ways."},
    Part{QualityPart::strokes, "Strokes",
         "Eight tools of 3 mm drawn over that ball in zigzag at 0.31 mm voxels. Error: of all distances in the band, "
         "beside the same stroke with every axis at its dearest."},
    Part{QualityPart::touch, "Touch",
         "A ball of 1 mm glides around the shapes at 20, 100 and 400 mm/s. Error: of the force that the hand holds, "
         "beside 8000 ticks a second with every axis at its dearest."},
    Part{QualityPart::surface, "Surface",
         "The same shapes drawn and written. Error: how far the triangles lie off, both ways."},
};

std::string called(const std::string& axes) {
  return axes.empty() ? "as it begins" : fmt::format("`{}`", axes);
}

void write(const std::filesystem::path& file, const std::string& text) {
  io::AtomicFile out(file);
  out.write(std::as_bytes(std::span(text)));
  out.commit();
}

ChartSeries series(const char* name, int colour, ChartSeries::Mark mark) {
  ChartSeries one;
  one.name = name;
  one.colour = colour;
  one.mark = mark;
  one.line = ChartSeries::Line::none;
  return one;
}

ChartPanel panelOf(const Part& part, const std::vector<TradeoffPoint>& points, const TradeoffPresets& presets) {
  using Mark = ChartSeries::Mark;
  ChartPanel panel;
  panel.title = part.title;
  panel.x.label = "cost, × as it begins";
  panel.y.label = "error, × as it begins";
  panel.x.logarithmic = panel.y.logarithmic = true;
  ChartSeries all = series("a quality", 7, Mark::dot), stairs = series("front", 1, Mark::none);
  for (const TradeoffPoint& p : points) all.points.push_back({p.cost, p.error});
  stairs.line = ChartSeries::Line::solid;
  double last = 0;
  for (const TradeoffPoint& p : frontOf(points)) {
    if (last > 0) stairs.points.push_back({p.cost, last});
    stairs.points.push_back({p.cost, last = p.error});
  }
  panel.series = {all, stairs};
  const auto mark = [&](const char* name, const std::string& axes, int colour, Mark with) {
    ChartSeries one = series(name, colour, with);
    for (const TradeoffPoint& p : points)
      if (p.axes == axes) one.points.push_back({p.cost, p.error});
    panel.series.push_back(one);
  };
  mark("draft", presets.draft, 2, Mark::triangle);
  mark("balanced", presets.balanced, 3, Mark::square);
  mark("fine", presets.fine, 4, Mark::cross);
  return panel;
}

void describe(const Part& part, const std::vector<TradeoffRow>& rows, const std::vector<TradeoffPoint>& points,
              const TradeoffPresets& presets, std::string& page) {
  page += fmt::format(
      "\n## {}\n\n{}\n\nWhat each axis buys by itself, as a factor of what a quality begins as:\n\n"
      "| axis | it is | at | cost | error | bytes |\n|---|---|---|---|---|---|\n",
      part.title, part.about);
  for (const QualityAxis& axis : engine::qualityAxes()) {
    if (axis.part != part.part) continue;
    const std::string begins = fmt::format("{}=", axis.row.id);
    bool first = true;
    for (const TradeoffPoint& p : points) {
      if (p.axes.rfind(begins, 0) != 0 || p.axes.find(' ') != std::string::npos) continue;
      page += fmt::format("| {} | {} | {} | {:.2f} | {:.2f} | {:.2f} |\n", first ? std::string(axis.row.name) : "",
                          first ? fmt::format("{:g}", axis.row.get({})) : "", p.axes.substr(begins.size()), p.cost,
                          p.error, p.bytes);
      first = false;
    }
  }
  page += "\nThe front, cheapest first:\n\n| cost | its 95 % | error | quality |\n|---|---|---|---|\n";
  for (const TradeoffPoint& p : frontOf(points)) {
    std::string name = called(p.axes);
    if (p.axes == presets.draft) name += " **draft**";
    if (p.axes == presets.balanced) name += " **balanced**";
    if (p.axes == presets.fine) name += " **fine**";
    page += fmt::format("| {:.2f} | {:.2f} to {:.2f} | {:.3f} | {} |\n", p.cost, p.costLow, p.costHigh, p.error, name);
  }
  page += "\nAs it begins, by workload:\n\n| workload | RMS | most | cost, yardsticks | MB |\n|---|---|---|---|---|\n";
  for (const TradeoffRow& r : rows)
    if (r.part == part.part && r.axes.empty())
      page += fmt::format("| {} | {:.3g} {} | {:.3g} | {:.3g} | {:.1f} |\n", r.workload, r.rms, r.unit, r.most, r.cost,
                          r.bytes * 1e-6);
}

}  // namespace

void writeTradeoff(const std::vector<TradeoffRow>& measured, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write(folder / "tradeoff.csv", tradeoffCsv(measured));
  // As they are kept: rounded, so that the page can be made again of them.
  const std::vector<TradeoffRow> rows = readTradeoffCsv(folder / "tradeoff.csv");
  Chart chart;
  chart.title = "Speed against accuracy";
  chart.columns = 2;
  chart.caption = {
      "Each dot is a quality: geometric means over the workloads of its part, as factors of what a quality "
      "begins as. Lower left is better."};
  std::string page = R"(# Speed against accuracy

Made by `argil bench tradeoff --folder docs --overwrite`: every axis of a quality by itself, and many at once. Costs are
processor time in that of the same work as it begins, which ran right before and after, repeated until the median is
known within 2 % or five times; of that work itself in yardsticks, a fixed piece of arithmetic of some 50 ms.
[tradeoff.csv](tradeoff.csv) has every row; `--from docs/tradeoff.csv` makes this page again.

Presets follow from the points by one rule. *Draft*: the least error among those within 1.25 times the cheapest. *Fine*:
the cheapest among those within 1.1 times the least error. *Balanced*: the least product of cost and error, where 1 % of
time stops buying 1 % of accuracy. Of those within a quarter of the best the one with the fewest axes changed: more than two
runs disagree about. No preset has

- stamps more than 0.2 radii or a voxel apart: the clay that is seen and felt trails the hand by so much, which at 5 mm
  and 50 mm/s is 20 ms;
- another rate of the servo: that is the device's, and stiffness goes with it;
- anything but the fine touch: a tick takes 2 µs of its 1000 (`argil bench touch`), there is nothing to buy for less;
- anything but the fine surface in files: that is paid once.

![Fronts](tradeoff.svg)

| preset | clay | strokes | touch | surface |
|---|---|---|---|---|
)";
  std::vector<TradeoffPresets> presets;
  for (const Part& part : kParts) {
    const auto points = pointsOf(rows, part.part);
    presets.push_back(presetsOf(points, part.part));
    chart.panels.push_back(panelOf(part, points, presets.back()));
  }
  const auto row = [&](const char* name, std::string TradeoffPresets::*which) {
    page += fmt::format("| {} |", name);
    for (const TradeoffPresets& each : presets) page += fmt::format(" {} |", called(each.*which));
    page += "\n";
  };
  row("draft", &TradeoffPresets::draft);
  row("balanced", &TradeoffPresets::balanced);
  row("fine", &TradeoffPresets::fine);
  for (size_t i = 0; i < kParts.size(); ++i)
    describe(kParts[i], rows, pointsOf(rows, kParts[i].part), presets[i], page);
  write(folder / "tradeoff.svg", chart.svg());
  write(folder / "tradeoff.md", page);
}

}  // namespace argil::bench
