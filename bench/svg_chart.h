#pragma once
// Charts as SVG text: panels of lines and points with axes, a legend and a caption. For figures that commands write.

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace argil::bench {

/// One line or set of marks. Series of the same name in several panels share a row of the legend: give them the same
/// look.
struct ChartSeries {
  enum class Line { none, solid, dashed, dotted };
  enum class Mark { none, dot, square, triangle, cross };
  std::string name;  ///< In the legend; empty: not in it.
  /// x, y. A point that is not finite (or not above zero on a logarithmic axis) breaks the line.
  std::vector<std::array<double, 2>> points;
  int colour = 0;  ///< Index into eight colours that colour-blind people tell apart; 0 is black.
  Line line = Line::solid;
  Mark mark = Mark::none;
};

struct ChartAxis {
  std::string label;  ///< With its unit.
  bool logarithmic = false;
  std::optional<double> from, to;  ///< Ends; what is missing is taken from the points. What lies beyond is clipped.
  std::vector<std::string> names;  ///< Instead of numbers: name i stands at i, ends are −0.5 and size − 0.5.
};

struct ChartPanel {
  std::string title;
  ChartAxis x, y;
  std::vector<ChartSeries> series;  ///< Later ones are drawn on top.
};

/// Panels row by row under one title, one legend for all, a caption at the foot.
struct Chart {
  std::string title;
  std::vector<ChartPanel> panels;
  int columns = 1;
  double panelWidth = 460, panelHeight = 320;  ///< Pixels, axes and labels included.
  std::vector<std::string> caption;            ///< Lines at the foot.

  /// The whole file. Throws Error when there is no panel, or an axis has no extent or a logarithmic one reaches zero.
  [[nodiscard]] std::string svg() const;
};

}  // namespace argil::bench
