#pragma once
// What was measured of speed against accuracy, its fronts, and the presets that follow from them.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/document/quality.h"

namespace argil::bench {

/// A workload at a quality. Errors are of the deterministic result; costs are processor time in that of a partner which
/// ran right before and after.
struct TradeoffRow {
  engine::QualityPart part = engine::QualityPart::clay;
  std::string axes;          ///< "band=4 voxels-across=128": those of the part that differ from a quality's beginning.
  std::string workload;      ///< Such as "groove".
  double rms = 0, most = 0;  ///< In `unit`.
  std::string unit;          ///< "mm" or "N".
  double cost = 0, costLow = 0, costHigh = 0;  ///< Median, and the ends of its 95 % interval.
  double bytes = 0;                            ///< Of the clay that is left; 0: has none.
};

/// Rows of docs/tradeoff.csv. Reading throws Error for what is no such file.
[[nodiscard]] std::string tradeoffCsv(const std::vector<TradeoffRow>& rows);
[[nodiscard]] std::vector<TradeoffRow> readTradeoffCsv(const std::filesystem::path& file);

/// A quality over all workloads of its part: geometric means of what it is beside the quality that all begin as.
struct TradeoffPoint {
  std::string axes;
  double error = 1, cost = 1, costLow = 1, costHigh = 1, bytes = 1;
};
/// Errors below this, of a workload's unit, count as this: nobody sees or feels less.
inline constexpr double kLeastErrorMm = 1e-4, kLeastErrorN = 1e-3;
/// Those that have a row for every workload, in the order of the rows.
[[nodiscard]] std::vector<TradeoffPoint> pointsOf(const std::vector<TradeoffRow>& rows, engine::QualityPart part);

/// Of these, those beside which no other is better by more than 1 % in error and 3 % in cost or has one of both equal
/// and the other better; from the cheapest to the dearest.
[[nodiscard]] std::vector<TradeoffPoint> frontOf(std::vector<TradeoffPoint> points);
/// The largest factor by which a point of `front` is off the nearest step of `other`: 1 where all are covered.
[[nodiscard]] double coverage(const std::vector<TradeoffPoint>& front, const std::vector<TradeoffPoint>& other);

/// draft: least error among those within 1.25 times the cheapest. fine: cheapest among those within 1.1 times the least
/// error. balanced: least cost × error. Of those within a quarter of the best the one nearer to what a quality begins
/// as (fewer axes that differ), then the better one. No preset's are: another servo rate, which is the device's; stamps
/// so far apart that clay trails the hand. Touch has the fine one in all.
struct TradeoffPresets {
  std::string draft, balanced, fine;
};
[[nodiscard]] TradeoffPresets presetsOf(const std::vector<TradeoffPoint>& points, engine::QualityPart part);

/// "band=4 passes=2" as a quality, and back: the axes of the part that differ.
[[nodiscard]] engine::Quality qualityOf(const std::string& axes);
[[nodiscard]] std::string axesOf(const engine::Quality& quality, engine::QualityPart part);

}  // namespace argil::bench
