#include "bench/tradeoff/front.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "clay/base/error.h"

namespace argil::bench {

namespace {

using engine::Quality;
using engine::QualityAxis;
using engine::QualityPart;

constexpr const char* kHead = "part,quality,workload,rms,most,unit,cost,cost low,cost high,bytes";
constexpr double kDraft = 1.25, kFine = 1.1, kTie = 1.25;
// Radii and voxels from a stamp to the next: beyond, the clay that is seen and felt trails a tool of 5 mm at 50 mm/s by
// more than 20 ms.
constexpr double kMostSpacing = 0.2, kMostLeastSpacing = 1;
constexpr double kSameError = 1.01, kSameCost = 1.03;

QualityPart partNamed(const std::string& name) {
  for (const QualityAxis& axis : engine::qualityAxes())
    if (engine::nameOf(axis.part) == name) return axis.part;
  throw Error(fmt::format("the trade-off has no part {:?}", name));
}

double counted(const TradeoffRow& row) {
  return std::max(row.rms, row.unit == "N" ? kLeastErrorN : kLeastErrorMm);
}

// The rate is the device's, and stiffness goes with it.
bool mayBeChosen(const Quality& q) {
  return q.servoHz == Quality().servoHz && q.strokes.spacing <= kMostSpacing &&
         q.strokes.minSpacingVoxels <= kMostLeastSpacing;
}

int differing(const std::string& axes) {
  return static_cast<int>(std::count(axes.begin(), axes.end(), '='));
}

}  // namespace

std::string tradeoffCsv(const std::vector<TradeoffRow>& rows) {
  std::string text = std::string(kHead) + "\n";
  for (const TradeoffRow& r : rows)
    text += fmt::format("{},{},{},{:.4g},{:.4g},{},{:.4g},{:.4g},{:.4g},{:.0f}\n", engine::nameOf(r.part), r.axes,
                        r.workload, r.rms, r.most, r.unit, r.cost, r.costLow, r.costHigh, r.bytes);
  return text;
}

std::vector<TradeoffRow> readTradeoffCsv(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || line != kHead) throw Error(file.string() + ": is no table of trade-offs");
  std::vector<TradeoffRow> rows;
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (cells.size() != 10) throw Error(fmt::format("{}: line {} has not ten cells", file.string(), rows.size() + 2));
    const auto number = [&](size_t i) {
      try {
        return std::stod(cells[i]);
      } catch (const std::exception&) {
        throw Error(fmt::format("{}: line {}: {:?} is no number", file.string(), rows.size() + 2, cells[i]));
      }
    };
    rows.push_back({partNamed(cells[0]), cells[1], cells[2], number(3), number(4), cells[5], number(6), number(7),
                    number(8), number(9)});
  }
  return rows;
}

std::vector<TradeoffPoint> pointsOf(const std::vector<TradeoffRow>& rows, QualityPart part) {
  std::map<std::string, const TradeoffRow*> standard;
  std::vector<std::string> order;
  std::map<std::string, std::vector<const TradeoffRow*>> byPoint;
  for (const TradeoffRow& row : rows) {
    if (row.part != part) continue;
    if (row.axes.empty()) standard[row.workload] = &row;
    if (byPoint[row.axes].empty()) order.push_back(row.axes);
    byPoint[row.axes].push_back(&row);
  }
  std::vector<TradeoffPoint> points;
  for (const std::string& axes : order) {
    const auto& of = byPoint[axes];
    if (of.size() != standard.size()) continue;
    double error = 0, cost = 0, low = 0, high = 0, bytes = 0;
    for (const TradeoffRow* row : of) {
      const TradeoffRow& beside = *standard.at(row->workload);
      error += std::log(counted(*row) / counted(beside));
      cost += std::log(row->cost / beside.cost);
      low += std::log(row->costLow / beside.cost);
      high += std::log(row->costHigh / beside.cost);
      bytes += std::log(std::max(row->bytes, 1.0) / std::max(beside.bytes, 1.0));
    }
    const double n = static_cast<double>(of.size());
    points.push_back(
        {axes, std::exp(error / n), std::exp(cost / n), std::exp(low / n), std::exp(high / n), std::exp(bytes / n)});
  }
  return points;
}

std::vector<TradeoffPoint> frontOf(std::vector<TradeoffPoint> points) {
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<TradeoffPoint> front;
  for (const TradeoffPoint& p : points) {
    const bool beaten = std::any_of(points.begin(), points.end(), [&](const TradeoffPoint& q) {
      return (q.error * kSameError < p.error && q.cost <= p.cost) ||
             (q.cost * kSameCost < p.cost && q.error <= p.error);
    });
    if (!beaten) front.push_back(p);
  }
  return front;
}

double coverage(const std::vector<TradeoffPoint>& front, const std::vector<TradeoffPoint>& other) {
  double worst = 1;
  for (const TradeoffPoint& p : front) {
    double best = INFINITY;
    for (const TradeoffPoint& q : other) best = std::min(best, std::max({1.0, q.error / p.error, q.cost / p.cost}));
    worst = std::max(worst, best);
  }
  return worst;
}

TradeoffPresets presetsOf(const std::vector<TradeoffPoint>& all, QualityPart part) {
  std::vector<TradeoffPoint> points;
  for (const TradeoffPoint& p : all)
    if (mayBeChosen(qualityOf(p.axes))) points.push_back(p);
  if (points.empty()) throw Error("there is no point to choose a preset from");
  // The least of `key` among those that are `allowed`; of nearly equal ones the plainest.
  const auto least = [&](auto allowed, auto key) {
    double smallest = INFINITY;
    for (const TradeoffPoint& p : points)
      if (allowed(p)) smallest = std::min(smallest, key(p));
    const TradeoffPoint* best = nullptr;
    const auto rank = [&](const TradeoffPoint& p) {
      return std::make_tuple(differing(p.axes), key(p), p.bytes, p.axes);
    };
    for (const TradeoffPoint& p : points)
      if (allowed(p) && key(p) <= kTie * smallest && (!best || rank(p) < rank(*best))) best = &p;
    return best->axes;
  };
  double cheapest = INFINITY, exactest = INFINITY;
  for (const TradeoffPoint& p : points) {
    cheapest = std::min(cheapest, p.cost);
    exactest = std::min(exactest, p.error);
  }
  TradeoffPresets presets;
  presets.draft =
      least([&](const auto& p) { return p.cost <= kDraft * cheapest; }, [](const auto& p) { return p.error; });
  presets.fine =
      least([&](const auto& p) { return p.error <= kFine * exactest; }, [](const auto& p) { return p.cost; });
  presets.balanced = least([](const auto&) { return true; }, [](const auto& p) { return p.cost * p.error; });
  // A tick takes 2 of its 1000 µs: there is nothing to buy for less.
  if (part == QualityPart::touch) presets.draft = presets.balanced = presets.fine;
  return presets;
}

Quality qualityOf(const std::string& axes) {
  Quality quality;
  std::istringstream stream(axes);
  for (std::string item; stream >> item;) {
    const size_t equals = item.find('=');
    const QualityAxis* axis = engine::findQualityAxis(item.substr(0, equals));
    if (!axis || equals == std::string::npos) throw Error(fmt::format("{:?} is no axis of a quality", item));
    axis->row.set(quality, std::stod(item.substr(equals + 1)));
  }
  return quality;
}

std::string axesOf(const Quality& quality, QualityPart part) {
  const Quality standard;
  std::string text;
  for (const QualityAxis& axis : engine::qualityAxes())
    if (axis.part == part && axis.row.get(quality) != axis.row.get(standard))
      text += fmt::format("{}{}={:g}", text.empty() ? "" : " ", axis.row.id, axis.row.get(quality));
  return text;
}

}  // namespace argil::bench
