#include "haptics/hand_path.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

#include "clay/error.h"

namespace argil::haptics {
namespace {

bool finite(const HandPoint& p) {
  return std::isfinite(p.timeS) && p.position.allFinite() && p.rotation.coeffs().allFinite() && p.forceN.allFinite() &&
         std::isfinite(p.pressure);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

constexpr std::array<std::string_view, 13> kColumns = {"t_s", "x_mm", "y_mm", "z_mm", "qx",       "qy",     "qz",
                                                       "qw",  "fx_n", "fy_n", "fz_n", "pressure", "buttons"};

void assign(HandPoint& p, size_t column, double value) {
  if (column == 0) p.timeS = value;
  else if (column <= 3) p.position[static_cast<int>(column) - 1] = value;
  else if (column <= 7) p.rotation.coeffs()[static_cast<int>(column) - 4] = value;  // Eigen's order: x, y, z, w.
  else if (column <= 10) p.forceN[static_cast<int>(column) - 8] = value;
  else if (column == 11) p.pressure = static_cast<float>(value);
  else p.buttons = static_cast<uint32_t>(value);
}

}  // namespace

HandPath::HandPath(std::vector<HandPoint> points) : points_(std::move(points)) {
  for (size_t i = 0; i < points_.size(); ++i) {
    if (!finite(points_[i])) throw Error("hand path: point " + std::to_string(i) + " holds a number that is not finite");
    if (i && points_[i].timeS <= points_[i - 1].timeS)
      throw Error("hand path: the time of point " + std::to_string(i) + " is not after the one before it");
    points_[i].rotation.normalize();
  }
}

HandPath HandPath::unchecked(std::vector<HandPoint> points) {
  HandPath path;
  path.points_ = std::move(points);
  return path;
}

HandPath HandPath::fromCsv(std::string_view text, const std::string& name) {
  std::vector<size_t> columns;
  std::vector<HandPoint> points;
  size_t lineNumber = 0;
  const auto where = [&] { return name + ", line " + std::to_string(lineNumber); };
  while (!text.empty()) {
    const size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++lineNumber;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const auto cells = split(line);
    if (columns.empty()) {
      for (std::string_view cell : cells) {
        const auto found = std::find(kColumns.begin(), kColumns.end(), cell);
        if (found == kColumns.end())
          throw Error(where() + ": unknown column '" + std::string(cell) + "'; a hand path has the columns t_s, x_mm, y_mm, z_mm");
        columns.push_back(static_cast<size_t>(found - kColumns.begin()));
      }
      for (size_t needed = 0; needed < 4; ++needed)
        if (std::find(columns.begin(), columns.end(), needed) == columns.end())
          throw Error(where() + ": the column " + std::string(kColumns[needed]) + " is missing");
      continue;
    }
    if (cells.size() != columns.size())
      throw Error(where() + ": " + std::to_string(cells.size()) + " values where the header names " + std::to_string(columns.size()));
    HandPoint point;
    for (size_t i = 0; i < cells.size(); ++i) {
      double value = 0;
      const auto [rest, code] = std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), value);
      if (code != std::errc() || rest != cells[i].data() + cells[i].size() || !std::isfinite(value))
        throw Error(where() + ": '" + std::string(cells[i]) + "' is not a finite number");
      if (columns[i] == 12 && (value < 0 || value > 4294967295.0)) throw Error(where() + ": buttons must be 0 or a sum of powers of two");
      assign(point, columns[i], value);
    }
    if (!points.empty() && point.timeS <= points.back().timeS) throw Error(where() + ": the time is not after the one before it");
    if (point.rotation.norm() < 1e-6) throw Error(where() + ": the quaternion is zero");
    points.push_back(point);
  }
  if (points.empty()) throw Error(name + ": no points of a hand path in it");
  return HandPath(std::move(points));
}

double HandPath::durationS() const noexcept { return points_.empty() ? 0 : points_.back().timeS; }

HandPoint HandPath::at(double timeS, size_t& hint) const ARGIL_REALTIME {
  if (points_.empty()) return {};
  if (hint >= points_.size() || points_[hint].timeS > timeS) hint = 0;
  while (hint + 1 < points_.size() && points_[hint + 1].timeS <= timeS) ++hint;
  HandPoint result = points_[hint];
  result.timeS = timeS;
  if (hint + 1 == points_.size() || timeS <= points_[hint].timeS) return result;
  const HandPoint &a = points_[hint], &b = points_[hint + 1];
  const double s = (timeS - a.timeS) / (b.timeS - a.timeS);
  result.position = a.position + s * (b.position - a.position);
  result.forceN = a.forceN + s * (b.forceN - a.forceN);
  result.rotation = a.rotation.slerp(s, b.rotation);
  return result;
}

HandPath HandPath::hold(const Vec3d& position, double seconds, uint32_t buttons) {
  HandPoint a;
  a.position = position;
  a.buttons = buttons;
  a.pressure = buttons ? 1.0f : 0.0f;
  HandPoint b = a;
  b.timeS = seconds;
  return HandPath({a, b});
}

HandPath HandPath::line(const Vec3d& a, const Vec3d& b, double seconds, uint32_t buttons, double stepS) {
  const int steps = std::max(1, static_cast<int>(std::ceil(seconds / stepS)));
  std::vector<HandPoint> points(static_cast<size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    HandPoint& p = points[static_cast<size_t>(i)];
    const double s = double(i) / steps;
    p.timeS = s * seconds;
    p.position = a + s * s * s * (10 + s * (6 * s - 15)) * (b - a);
    p.buttons = buttons;
    p.pressure = buttons ? 1.0f : 0.0f;
  }
  return HandPath(std::move(points));
}

HandPath HandPath::circle(const Vec3d& centre, const Vec3d& start, const Vec3d& axis, double turns, double seconds,
                          uint32_t buttons, double stepS) {
  const int steps = std::max(1, static_cast<int>(std::ceil(seconds / stepS)));
  std::vector<HandPoint> points(static_cast<size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    HandPoint& p = points[static_cast<size_t>(i)];
    const double s = double(i) / steps;
    p.timeS = s * seconds;
    p.position = centre + Eigen::AngleAxisd(2 * std::numbers::pi * turns * s, axis) * (start - centre);
    p.buttons = buttons;
    p.pressure = buttons ? 1.0f : 0.0f;
  }
  return HandPath(std::move(points));
}

HandPath HandPath::then(const HandPath& next) const {
  HandPath result = *this;
  const double shift = durationS() + 1e-6;  // Keeps times increasing where one path ends and the other begins.
  for (HandPoint p : next.points_) {
    p.timeS += points_.empty() ? 0 : shift;
    result.points_.push_back(p);
  }
  return result;
}

}  // namespace argil::haptics
