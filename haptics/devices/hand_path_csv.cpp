// Hand paths from CSV files: the house's own layout, and others by the names of their columns.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "clay/base/error.h"
#include "haptics/devices/hand_path.h"

namespace argil::haptics {
namespace {

enum Role : size_t { kTime, kX, kY, kZ, kQx, kQy, kQz, kQw, kFx, kFy, kFz, kPressure, kButtons, kRoles };

constexpr std::array<std::string_view, kRoles> kHouse = {"t_s", "x_mm", "y_mm", "z_mm", "qx",       "qy",     "qz",
                                                         "qw",  "fx_n", "fy_n", "fz_n", "pressure", "buttons"};
constexpr std::array<std::string_view, kRoles> kRoleNames = {"t",  "x",  "y",  "z",  "qx",       "qy",     "qz",
                                                             "qw", "fx", "fy", "fz", "pressure", "buttons"};

// Names that others use, with what a number is to be multiplied by; lengths follow the file's units instead.
struct Alias {
  std::string_view name;
  Role role;
  double scale;
};
constexpr Alias kAliases[] = {
    {"t", kTime, 1},
    {"t_s", kTime, 1},
    {"time", kTime, 1},
    {"time_s", kTime, 1},
    {"timestamp", kTime, 1},
    {"t_ms", kTime, 1e-3},
    {"time_ms", kTime, 1e-3},
    {"t_us", kTime, 1e-6},
    {"time_us", kTime, 1e-6},
    {"x", kX, 1},
    {"px", kX, 1},
    {"pos_x", kX, 1},
    {"position_x", kX, 1},
    {"x_mm", kX, 1},
    {"y", kY, 1},
    {"py", kY, 1},
    {"pos_y", kY, 1},
    {"position_y", kY, 1},
    {"y_mm", kY, 1},
    {"z", kZ, 1},
    {"pz", kZ, 1},
    {"pos_z", kZ, 1},
    {"position_z", kZ, 1},
    {"z_mm", kZ, 1},
    {"qx", kQx, 1},
    {"qi", kQx, 1},
    {"quat_x", kQx, 1},
    {"qy", kQy, 1},
    {"qj", kQy, 1},
    {"quat_y", kQy, 1},
    {"qz", kQz, 1},
    {"qk", kQz, 1},
    {"quat_z", kQz, 1},
    {"qw", kQw, 1},
    {"qr", kQw, 1},
    {"quat_w", kQw, 1},
    {"fx", kFx, 1},
    {"fx_n", kFx, 1},
    {"force_x", kFx, 1},
    {"fy", kFy, 1},
    {"fy_n", kFy, 1},
    {"force_y", kFy, 1},
    {"fz", kFz, 1},
    {"fz_n", kFz, 1},
    {"force_z", kFz, 1},
    {"pressure", kPressure, 1},
    {"buttons", kButtons, 1},
};

struct Unit {
  std::string_view name;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"ft", 304.8}};

std::string_view trimmed(std::string_view cell) {
  while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
  return cell;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const size_t comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// A piece of the file as a sentence may quote it: one line of at most 40 characters.
std::string quoted(std::string_view text) {
  constexpr size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...'" : "'");
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

void assign(HandPoint& p, Role role, double value) {
  const auto i = static_cast<int>(role);
  if (role == kTime)
    p.timeS = value;
  else if (role <= kZ)
    p.position[i - kX] = value;
  else if (role <= kQw)
    p.rotation.coeffs()[i - kQx] = value;  // Eigen's order: x, y, z, w.
  else if (role <= kFz)
    p.forceN[i - kFx] = value;
  else if (role == kPressure)
    p.pressure = static_cast<float>(value);
  else
    p.buttons = static_cast<uint32_t>(value);
}

/// What a column of the file holds.
struct Column {
  std::optional<Role> role;
  double scale = 1;
  bool filter = false;
};

/// The columns that a header names; throws Error. `where` begins each sentence.
class Header {
 public:
  Header(const std::vector<std::string_view>& cells, const std::string& where, const HandPathLayout* layout)
      : where_(where) {
    if (layout)
      byLayout(cells, *layout);
    else
      byHouse(cells);
    std::array<int, kRoles> count{};
    for (const Column& c : columns)
      if (c.role && ++count[*c.role] == 2)
        fail("two columns hold " + std::string(kRoleNames[*c.role]) + "; say which with a column list such as x=tip_x");
    for (size_t needed = kTime; needed <= kZ; ++needed)
      if (!count[needed])
        fail(layout ? "no column is known as " + std::string(kRoleNames[needed]) +
                          "; name it with a column list such as " + std::string(kRoleNames[needed]) + "=NAME"
                    : "the column " + std::string(kHouse[needed]) + " is missing");
    const int rotations = count[kQx] + count[kQy] + count[kQz] + count[kQw];
    if (rotations != 0 && rotations != 4) fail("a rotation needs all of qx, qy, qz, qw");
  }
  std::vector<Column> columns;
  std::string filter;  // What the filter column must hold.

 private:
  [[noreturn]] void fail(const std::string& sentence) const { throw Error(where_ + ": " + sentence); }

  void byHouse(const std::vector<std::string_view>& cells) {
    for (std::string_view cell : cells) {
      const auto found = std::find(kHouse.begin(), kHouse.end(), cell);
      if (found == kHouse.end())
        fail(
            "unknown column " + quoted(cell) +
            "; a hand path has the columns t_s, x_mm, y_mm, z_mm; a file of another layout needs its units to be said");
      columns.push_back({static_cast<Role>(found - kHouse.begin()), 1, false});
    }
  }

  void byLayout(const std::vector<std::string_view>& cells, const HandPathLayout& layout) {
    const auto unit =
        std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return u.name == layout.units; });
    if (unit == std::end(kUnits))
      fail("the units '" + layout.units + "' are unknown; choose one of mm, um, cm, m, in, ft");
    columns.resize(cells.size());
    const auto column = [&](std::string_view name) -> Column& {
      for (size_t i = 0; i < cells.size(); ++i)
        if (cells[i] == name) return columns[i];
      fail("there is no column '" + std::string(name) + "'");
    };
    const auto pair = [&](std::string_view text) {
      const size_t equals = text.find('=');
      if (equals == std::string_view::npos) fail("'" + std::string(text) + "' is not of the form name=value");
      return std::pair(trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1)));
    };
    std::array<bool, kRoles> named{};
    if (!layout.columns.empty())
      for (std::string_view entry : split(layout.columns)) {
        const auto [roleName, name] = pair(entry);
        const auto role = std::find(kRoleNames.begin(), kRoleNames.end(), roleName);
        if (role == kRoleNames.end())
          fail("nothing in a hand path is called '" + std::string(roleName) +
               "'; there are t, x, y, z, qx to qw, fx to fz, pressure, buttons");
        column(name).role = static_cast<Role>(role - kRoleNames.begin());
        named[*column(name).role] = true;
      }
    for (size_t i = 0; i < cells.size(); ++i) {
      if (columns[i].role) continue;
      const std::string name = lower(cells[i]);
      const auto alias =
          std::find_if(std::begin(kAliases), std::end(kAliases), [&](const Alias& a) { return a.name == name; });
      if (alias == std::end(kAliases) || named[alias->role]) continue;
      columns[i] = {alias->role, alias->scale, false};
    }
    for (Column& c : columns)
      if (c.role && *c.role >= kX && *c.role <= kZ) c.scale = unit->mm;
    if (!layout.rows.empty()) {
      const auto [name, value] = pair(layout.rows);
      column(name).filter = true;
      filter = value;
    }
  }

  std::string where_;
};

HandPath read(std::string_view text, const std::string& name, const HandPathLayout* layout) {
  std::optional<Header> header;
  std::vector<HandPoint> points;
  size_t lineNumber = 0;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const auto where = [&] { return name + ", line " + std::to_string(lineNumber); };
  while (!text.empty()) {
    const size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++lineNumber;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const auto cells = split(line);
    if (!header) {
      header.emplace(cells, where(), layout);
      continue;
    }
    if (cells.size() != header->columns.size())
      throw Error(where() + ": " + std::to_string(cells.size()) + " values where the header names " +
                  std::to_string(header->columns.size()));
    HandPoint point;
    bool wanted = true;
    for (size_t i = 0; i < cells.size(); ++i) {
      const Column& column = header->columns[i];
      if (column.filter && cells[i] != header->filter) wanted = false;
      if (!column.role) continue;
      double value = 0;
      const auto [rest, code] = std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), value);
      value *= column.scale;
      if (code != std::errc() || rest != cells[i].data() + cells[i].size() || !std::isfinite(value))
        throw Error(where() + ": " + quoted(cells[i]) + " is not a finite number");
      if (*column.role == kButtons && (value < 0 || value > 4294967295.0))
        throw Error(where() + ": buttons must be 0 or a sum of powers of two");
      assign(point, *column.role, value);
    }
    if (!wanted) continue;
    if (!points.empty() && point.timeS <= points.back().timeS)
      throw Error(where() + ": the time is not after the one before it" +
                  (layout && layout->rows.empty()
                       ? "; where a file holds several paths choose one by a row filter such as demo=1"
                       : ""));
    if (point.rotation.norm() < 1e-6) throw Error(where() + ": the quaternion is zero");
    points.push_back(point);
  }
  if (points.empty())
    throw Error(name + ": no points of a hand path in it" +
                (layout && !layout->rows.empty() ? " with " + layout->rows : ""));
  // A clock of another's may begin anywhere; the house's own layout means what it says.
  if (layout)
    for (size_t i = points.size(); i-- > 0;) points[i].timeS -= points[0].timeS;
  return HandPath(std::move(points));
}

}  // namespace

HandPath HandPath::fromCsv(std::string_view text, const std::string& name) {
  return read(text, name, nullptr);
}

HandPath HandPath::fromCsv(std::string_view text, const std::string& name, const HandPathLayout& layout) {
  return read(text, name, &layout);
}

}  // namespace argil::haptics
