#include "ui3d/studio/kit/layout.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace argil::studio {
namespace {

constexpr int kMostColumns = 8;

// Which docks stand beside the clay.
struct Docked {
  bool tools = false, settings = false, side = false;
};

// `between`: before each group.
float toolsHeight(std::span<const int> groups, int columns, float between) {
  float height = 2 * kToolPad;
  for (const int count : groups) height += between + float((count + columns - 1) / columns) * (kToolEdge + kToolGap);
  return height;
}

float toolsWidth(int columns) {
  return float(columns) * (kToolEdge + kToolGap) - kToolGap + 2 * kToolPad;
}

// Where the clay's part of the window is decided.
struct Room {
  float width, height, top, bottom, tools;
  double clayPart;

  [[nodiscard]] double needed() const {
    return clayPart * double(width) * double(height) / std::max(1.0, double(bottom - top));
  }
  [[nodiscard]] double left(const Docked& d, float settings) const {
    return double(width) - double(kRailWidth) - (d.tools ? double(tools) : 0) - (d.settings ? double(settings) : 0) -
           (d.side ? double(kSideWidth) : 0);
  }
  // How wide the settings may be with these docks; 0: the clay would have too little.
  [[nodiscard]] float settingsWidth(const Docked& d) const {
    const double most = left(d, 0) - needed();
    if (!d.settings) return most >= 0 ? kSettingsWidth : 0;
    const float least = d.side ? kSettingsWidth : kSettingsLeast;  // They shrink only once the side is folded.
    return most >= double(least) ? std::min(kSettingsWidth, float(std::floor(most))) : 0;
  }
};

}  // namespace

bool Layout::folded(Dock dock) const {
  switch (dock) {
    case Dock::tools:
      return toolsFolded;
    case Dock::settings:
      return settingsFolded;
    case Dock::upper:
    case Dock::lower:
      return sideFolded;
    case Dock::middle:
      return false;
  }
  return false;
}

Layout layOut(float width, float height, const PanelsShown& shown, std::span<const int> toolGroups,
              std::string_view over, double clayPart) {
  Layout l;
  l.menu = {0, 0, width, kMenuHeight};
  l.bar = {0, kMenuHeight, width, kMenuHeight + kBarHeight};
  l.status = {0, height - kStatusHeight, width, height};
  const float top = l.bar.bottom, bottom = std::max(top + 1, l.status.top);
  l.rail = {width - kRailWidth, top, width, bottom};

  // As many buttons as there are panels on the right, and three at the foot where there is room.
  std::array<int, 2> beside{0, 0};
  bool upper = false, lower = false;
  for (const PanelRow& row : panelTable()) {
    if (row.dock == Dock::upper) ++beside[0], upper |= shown.*row.shown;
    if (row.dock == Dock::lower) ++beside[1], lower |= shown.*row.shown;
  }
  const int buttons = beside[0] + beside[1];
  const float inside = bottom - top - 2 * kToolPad;
  l.railEdge = std::clamp(std::floor((inside - kRailGap) / float(buttons)) - 2, 8.0f, kRailEdge);
  l.railFoot = float(buttons + 3) * (l.railEdge + 2) + 2 * kRailGap <= inside;

  while (l.toolColumns < kMostColumns && toolsHeight(toolGroups, l.toolColumns, kToolLine) > bottom - top)
    ++l.toolColumns;
  l.toolHeadings = toolsHeight(toolGroups, l.toolColumns, kToolHeading) <= bottom - top;
  l.toolsScroll = toolsHeight(toolGroups, l.toolColumns, kToolLine) > bottom - top;
  const float toolsWide = toolsWidth(l.toolColumns) + (l.toolsScroll ? 9.0f : 0.0f);

  const Room room{width, height, top, bottom, toolsWide, clayPart};
  const Docked wanted{shown.tools, shown.settings, upper || lower};
  Docked docked;
  float settingsWide = kSettingsWidth;
  for (const Docked& keep :
       {Docked{true, true, true}, Docked{true, true, false}, Docked{true, false, false}, Docked{}}) {
    docked = {keep.tools && wanted.tools, keep.settings && wanted.settings, keep.side && wanted.side};
    settingsWide = room.settingsWidth(docked);
    if (settingsWide > 0) break;
  }
  // A hidden dock is folded when there would be no room for it beside those that stand there.
  const auto crowds = [&](bool Docked::*dock) {
    if (docked.*dock) return false;
    Docked more = docked;
    more.*dock = true;
    return wanted.*dock || room.settingsWidth(more) == 0;
  };
  l.toolsFolded = crowds(&Docked::tools);
  l.settingsFolded = crowds(&Docked::settings);
  l.sideFolded = crowds(&Docked::side);

  float left = 0, right = l.rail.left;
  if (docked.tools) {
    l.tools = {left, top, left + toolsWide, bottom};
    left = l.tools.right;
  }
  if (docked.settings) {
    l.settings = {left, top, left + settingsWide, bottom};
    left = l.settings.right;
  }
  if (docked.side) {
    const kit::Rect side{right - kSideWidth, top, right, bottom};
    // Lists need less height than settings do.
    const float middle = !upper ? top : !lower ? bottom : std::floor(top + 0.44f * (bottom - top));
    if (upper) l.upper = {side.left, top, side.right, middle};
    if (lower) l.lower = {side.left, middle, side.right, bottom};
    right = side.left;
  }
  l.free = {left, top, std::max(left, right), bottom};

  l.clear = l.free;
  const PanelRow* opened = over.empty() ? nullptr : findPanel(over);
  if (opened && l.folded(opened->dock)) {
    const auto fromLeft = [&](float wide) {
      return kit::Rect{l.free.left, top, std::min(l.free.left + wide, l.free.right), bottom};
    };
    if (opened->dock == Dock::tools) l.tools = fromLeft(toolsWide);
    if (opened->dock == Dock::settings) l.settings = fromLeft(kSettingsWidth);
    const kit::Rect side{std::max(l.free.left, l.free.right - kSideWidth), top, l.free.right, bottom};
    if (opened->dock == Dock::upper) l.upper = side;
    if (opened->dock == Dock::lower) l.lower = side;
    if (opened->dock == Dock::tools)
      l.clear.left = l.tools.right;
    else if (opened->dock == Dock::settings)
      l.clear.left = l.settings.right;
    else
      l.clear.right = side.left;
  }
  return l;
}

bool isSeen(const Layout& layout, const StudioState& state, const PanelRow& row) {
  return layout.folded(row.dock) ? state.over == row.id : state.shown.*row.shown;
}

void turnPanel(const Layout& layout, StudioState& state, const PanelRow& row) {
  if (!layout.folded(row.dock))
    showPanel(state.shown, row, !(state.shown.*row.shown));
  else if (state.over == row.id)
    state.over.clear();
  else
    state.over = row.id;
}

double freeAspect(const kit::Rect& free, float width, float height) {
  const double half = std::min(double(width) / 2 - double(free.left), double(free.right) - double(width) / 2);
  return std::clamp(2 * half, 0.2 * double(width), double(width)) / std::max(1.0, double(height));
}

float barWidth(const BarGroups& groups, int folded, float stop) {
  constexpr float kLine = 19, kEach = kBarButton + 2;
  float width = 8 + 2 * kEach;
  if (folded > 0) width += float(folded) * kEach + kLine;
  if (groups.numbers > 0) width += kLine + float(groups.numbers) * (groups.number + 6);
  if (groups.symmetry) width += kLine + 26 + 4 * kEach;
  if (groups.shading) width += kLine + 3 * kEach;
  if (groups.view) width += kLine + 5 * kEach;
  return width + (stop > 0 ? stop + 16 : 8);
}

BarGroups barGroups(float width, int folded, float stop) {
  BarGroups groups;
  const auto fits = [&] { return barWidth(groups, folded, stop) <= width; };
  // What menus and palette have too goes first.
  if (!fits()) groups.number = 112;
  if (!fits()) groups.view = false;
  if (!fits()) groups.shading = false;
  if (!fits()) groups.numbers = 1;
  if (!fits()) groups.symmetry = false;
  if (!fits()) groups.numbers = 0;
  return groups;
}

float scaleThatFits(float wanted, int width, int height) {
  if (width <= 0 || height <= 0) return wanted;
  const float most = std::min(float(width) / kLeastWindowWidth, float(height) / kLeastWindowHeight);
  return std::max(0.5f, std::min(wanted, most));
}

FirstWindow firstWindow(int workWidth, int workHeight, float scale) {
  constexpr double kPart = 0.85;                           // Of the work area: the desktop is seen around it.
  constexpr double kWidth = 1760, kHeight = 960;           // Units that a window with air around it should have,
  constexpr double kMostWidth = 2560, kMostHeight = 1440;  // and those beyond which more is of no use to start with.
  const double s = scale > 0 ? double(scale) : 1, width = kPart * workWidth, height = kPart * workHeight;
  if (width < kWidth * s || height < kHeight * s) return {true, int(width), int(height)};
  return {false, int(std::min(width, kMostWidth * s)), int(std::min(height, kMostHeight * s))};
}

}  // namespace argil::studio
