#include "bench/svg_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::bench {

namespace {

// Okabe and Ito's palette.
constexpr std::array<const char*, 8> kColours = {"#000000", "#0072b2", "#d55e00", "#009e73",
                                                 "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a"};
constexpr double kLeft = 64, kRight = 14, kTop = 30, kBottom = 48;  // Around the axes of a panel.
constexpr double kTitle = 34, kRow = 18, kFoot = 10;
constexpr double kCharacter = 6.6;  // Width of a letter at 12 px, about.

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

size_t letters(const std::string& text) {  // UTF-8.
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string text(double x, double y, const std::string& what, const char* anchor, double size, const char* extra = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{:g}\"{}>{}</text>\n", x, y,
                     anchor, size, extra, escaped(what));
}

struct Tick {
  double at;
  std::string label;
};

/// An axis with its ends found and where a value stands on it, 0 to 1.
class Scale {
 public:
  Scale(const ChartAxis& axis, const std::vector<ChartSeries>& series, size_t coordinate) : log_(axis.logarithmic) {
    if (!axis.names.empty()) {
      lo_ = -0.5;
      hi_ = static_cast<double>(axis.names.size()) - 0.5;
      log_ = false;
      for (size_t i = 0; i < axis.names.size(); ++i) ticks_.push_back({static_cast<double>(i), axis.names[i]});
      return;
    }
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const ChartSeries& s : series)
      for (const auto& p : s.points)
        if (std::isfinite(p[coordinate]) && (!log_ || p[coordinate] > 0)) {
          least = std::min(least, p[coordinate]);
          most = std::max(most, p[coordinate]);
        }
    const double margin = log_ ? 1.0 : 0.05 * (most - least);
    lo_ = axis.from.value_or(least - (log_ ? 0.0 : margin));
    hi_ = axis.to.value_or(most + (log_ ? 0.0 : margin));
    if (log_ && !axis.from) lo_ *= 0.85;
    if (log_ && !axis.to) hi_ *= 1.18;
    if (!(std::isfinite(lo_) && std::isfinite(hi_) && hi_ > lo_ && (!log_ || lo_ > 0)))
      throw Error(
          fmt::format("chart: the axis '{}' has no extent, or reaches zero though it is logarithmic", axis.label));
    if (log_)
      ticksOfDecades();
    else
      ticksOfSteps();
  }

  [[nodiscard]] bool known(double v) const { return std::isfinite(v) && (!log_ || v > 0); }
  [[nodiscard]] double at(double v) const {
    return log_ ? std::log(v / lo_) / std::log(hi_ / lo_) : (v - lo_) / (hi_ - lo_);
  }
  [[nodiscard]] const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  void ticksOfSteps() {
    const double rough = (hi_ - lo_) / 6, decade = std::pow(10, std::floor(std::log10(rough)));
    const double step = decade * (rough / decade > 5 ? 10 : rough / decade > 2 ? 5 : rough / decade > 1 ? 2 : 1);
    for (double i = std::ceil(lo_ / step - 1e-9); i * step <= hi_ + 1e-9 * step; ++i)
      ticks_.push_back({i * step, fmt::format("{:.6g}", i * step + 0.0)});
  }
  void ticksOfDecades() {
    // Few decades: 1, 2, 5 are named; many: only their beginnings.
    const bool few = hi_ / lo_ < 2000;
    for (int e = static_cast<int>(std::floor(std::log10(lo_))); e <= std::log10(hi_); ++e)
      for (int m = 1; m <= 9; ++m) {
        const double v = m * std::pow(10, e);
        if (v < lo_ * (1 - 1e-9) || v > hi_ * (1 + 1e-9)) continue;
        ticks_.push_back({v, m == 1 || (few && (m == 2 || m == 5)) ? fmt::format("{:.6g}", v) : ""});
      }
  }

  double lo_ = 0, hi_ = 1;
  bool log_;
  std::vector<Tick> ticks_;
};

std::string mark(ChartSeries::Mark kind, double x, double y, const char* colour) {
  switch (kind) {
    case ChartSeries::Mark::none:
      return "";
    case ChartSeries::Mark::dot:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"/>\n", x, y, colour);
    case ChartSeries::Mark::square:
      return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"7\" height=\"7\" fill=\"{}\"/>\n", x - 3.5, y - 3.5,
                         colour);
    case ChartSeries::Mark::triangle:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l4.5 8h-9z\" fill=\"{}\"/>\n", x, y - 5, colour);
    case ChartSeries::Mark::cross:
      return fmt::format(
          "<path d=\"M{:.1f} {:.1f}l7 7m0 -7l-7 7\" stroke=\"{}\" stroke-width=\"1.8\" fill=\"none\"/>\n", x - 3.5,
          y - 3.5, colour);
  }
  return "";
}

const char* dashes(ChartSeries::Line line) {
  return line == ChartSeries::Line::dashed   ? " stroke-dasharray=\"7 4\""
         : line == ChartSeries::Line::dotted ? " stroke-dasharray=\"2 3\""
                                             : "";
}

const char* colourOf(const ChartSeries& s) {
  return kColours[static_cast<size_t>(s.colour) % kColours.size()];
}

std::string drawSeries(const ChartSeries& s, const Scale& sx, const Scale& sy, double x0, double y0, double w,
                       double h) {
  std::string out, path, marks;
  bool pen = false;
  for (const auto& p : s.points) {
    if (!sx.known(p[0]) || !sy.known(p[1])) {
      pen = false;
      continue;
    }
    // Far beyond the frame there is nothing to see, and readers of SVG choke on huge numbers.
    const double x = x0 + w * std::clamp(sx.at(p[0]), -9.0, 9.0), y = y0 + h * (1 - std::clamp(sy.at(p[1]), -9.0, 9.0));
    path += fmt::format("{}{:.1f} {:.1f}", pen ? "L" : "M", x, y);
    marks += mark(s.mark, x, y, colourOf(s));
    pen = true;
  }
  if (s.line != ChartSeries::Line::none && !path.empty())
    out +=
        fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\" stroke-linejoin=\"round\"{}/>\n",
                    path, colourOf(s), dashes(s.line));
  return out + marks;
}

std::string drawPanel(const ChartPanel& panel, double left, double top, double width, double height, size_t index) {
  const double x0 = left + kLeft, y0 = top + kTop, w = width - kLeft - kRight, h = height - kTop - kBottom;
  const Scale sx(panel.x, panel.series, 0), sy(panel.y, panel.series, 1);
  std::string out = text(x0 + w / 2, top + 20, panel.title, "middle", 14, " font-weight=\"bold\"");
  for (const Tick& t : sx.ticks()) {
    const double x = x0 + w * sx.at(t.at);
    out += fmt::format("<path d=\"M{:.1f} {:.1f}v{:.1f}\" stroke=\"#{}\"/>\n", x, y0, h,
                       t.label.empty() ? "f3f3f3" : "dddddd");
    if (!t.label.empty()) out += text(x, y0 + h + 16, t.label, "middle", 12);
  }
  for (const Tick& t : sy.ticks()) {
    const double y = y0 + h * (1 - sy.at(t.at));
    out += fmt::format("<path d=\"M{:.1f} {:.1f}h{:.1f}\" stroke=\"#{}\"/>\n", x0, y, w,
                       t.label.empty() ? "f3f3f3" : "dddddd");
    if (!t.label.empty()) out += text(x0 - 6, y + 4, t.label, "end", 12);
  }
  out += text(x0 + w / 2, y0 + h + 36, panel.x.label, "middle", 13);
  out += fmt::format("<g transform=\"rotate(-90 {:.1f} {:.1f})\">{}</g>\n", left + 16, y0 + h / 2,
                     text(left + 16, y0 + h / 2, panel.y.label, "middle", 13));
  out += fmt::format(
      "<clipPath id=\"panel{}\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/></clipPath>\n",
      index, x0 - 5, y0 - 5, w + 10, h + 10);
  out += fmt::format("<g clip-path=\"url(#panel{})\">\n", index);
  for (const ChartSeries& s : panel.series) out += drawSeries(s, sx, sy, x0, y0, w, h);
  out += "</g>\n";
  out += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"#444444\"/>\n", x0, y0,
      w, h);
  return out;
}

}  // namespace

std::string Chart::svg() const {
  if (panels.empty() || columns < 1) throw Error("chart: there is no panel to draw");
  const size_t across = std::min(panels.size(), static_cast<size_t>(columns));
  const size_t down = (panels.size() + across - 1) / across;
  const double width = panelWidth * static_cast<double>(across);

  std::string body;
  for (size_t i = 0; i < panels.size(); ++i)
    body += drawPanel(panels[i], panelWidth * static_cast<double>(i % across),
                      kTitle + panelHeight * static_cast<double>(i / across), panelWidth, panelHeight, i);

  double x = 20, y = kTitle + panelHeight * static_cast<double>(down) + kRow;
  std::vector<std::string> seen;
  for (const ChartPanel& panel : panels)
    for (const ChartSeries& s : panel.series) {
      if (s.name.empty() || std::find(seen.begin(), seen.end(), s.name) != seen.end()) continue;
      seen.push_back(s.name);
      const double wide = 58 + kCharacter * static_cast<double>(letters(s.name));
      if (x > 20 && x + wide > width) {
        x = 20;
        y += kRow;
      }
      if (s.line != ChartSeries::Line::none)
        body += fmt::format("<path d=\"M{:.1f} {:.1f}h28\" stroke=\"{}\" stroke-width=\"1.8\"{}/>\n", x, y - 4,
                            colourOf(s), dashes(s.line));
      body += mark(s.mark, x + 14, y - 4, colourOf(s));
      body += text(x + 34, y, s.name, "start", 12);
      x += wide;
    }
  if (!seen.empty()) y += kRow;
  for (const std::string& line : caption) {
    y += 2;
    body += text(20, y, line, "start", 12, " fill=\"#444444\"");
    y += kRow - 2;
  }
  const double height = y + kFoot - kRow / 2;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"DejaVu Sans, Arial, "
      "sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{2}{3}</svg>\n",
      width, height, text(width / 2, 24, title, "middle", 17, " font-weight=\"bold\""), body);
}

}  // namespace argil::bench
