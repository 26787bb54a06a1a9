#include "ui3d/studio/panels/layout.h"

#include <algorithm>
#include <cmath>

#include "ui3d/studio/panels/panel_table.h"

namespace argil::studio {

Layout layOut(float width, float height, const PanelsShown& shown, int toolRows) {
  Layout l;
  l.menu = {0, 0, width, kMenuHeight};
  l.bar = {0, kMenuHeight, width, kMenuHeight + kBarHeight};
  l.status = {0, height - kStatusHeight, width, height};
  const float top = l.bar.bottom, bottom = std::max(top + 1, l.status.top);
  float left = 0, right = width - kRailWidth;
  l.rail = {right, top, width, bottom};
  if (shown.tools) {
    const int rows = std::max(1, int((bottom - top - 3 * kToolPad - 20) / (kToolEdge + 2)));
    l.toolColumns = std::clamp((toolRows + rows - 1) / rows, 1, 4);
    const float wide = float(l.toolColumns) * (kToolEdge + 2) - 2 + 2 * kToolPad;
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
