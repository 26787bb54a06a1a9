#include "ui3d/studio/panels/layout.h"

#include <algorithm>
#include <cmath>

#include "ui3d/studio/panels/panel_table.h"

namespace argil::studio {
namespace {

constexpr int kMostColumns = 8;

// `between`: before each group.
float toolsHeight(std::span<const int> groups, int columns, float between) {
  float height = 2 * kToolPad;
  for (const int count : groups) height += between + float((count + columns - 1) / columns) * (kToolEdge + kToolGap);
  return height;
}

}  // namespace

Layout layOut(float width, float height, const PanelsShown& shown, std::span<const int> toolGroups) {
  Layout l;
  l.menu = {0, 0, width, kMenuHeight};
  l.bar = {0, kMenuHeight, width, kMenuHeight + kBarHeight};
  l.status = {0, height - kStatusHeight, width, height};
  const float top = l.bar.bottom, bottom = std::max(top + 1, l.status.top);
  float left = 0, right = width - kRailWidth;
  l.rail = {right, top, width, bottom};
  if (shown.tools) {
    while (l.toolColumns < kMostColumns && toolsHeight(toolGroups, l.toolColumns, kToolLine) > bottom - top) ++l.toolColumns;
    l.toolHeadings = toolsHeight(toolGroups, l.toolColumns, kToolHeading) <= bottom - top;
    const float wide = float(l.toolColumns) * (kToolEdge + kToolGap) - kToolGap + 2 * kToolPad;
    l.tools = {left, top, left + wide, bottom};
    left = l.tools.right;
  }
  if (shown.settings) {
    l.settings = {left, top, left + kSettingsWidth, bottom};
    left = l.settings.right;
  }
  bool upper = false, lower = false;
  for (const PanelRow& row : panelTable()) {
    upper |= row.dock == Dock::upper && shown.*row.shown;
    lower |= row.dock == Dock::lower && shown.*row.shown;
  }
  if (upper || lower) {
    const kit::Rect side{right - kSideWidth, top, right, bottom};
    // Lists need less height than settings do.
    const float middle = !upper ? top : !lower ? bottom : std::floor(top + 0.44f * (bottom - top));
    if (upper) l.upper = {side.left, top, side.right, middle};
    if (lower) l.lower = {side.left, middle, side.right, bottom};
    right = side.left;
  }
  l.free = {left, top, std::max(left, right), bottom};
  return l;
}

}  // namespace argil::studio
