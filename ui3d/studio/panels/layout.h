#pragma once
// Where everything flat stands: fixed docks around the picture.

#include <span>

#include "ui3d/studio/panels/kit.h"
#include "ui3d/studio/studio_state.h"

namespace argil::studio {

/// Rectangles in interface units, empty for what is hidden. No two overlap; together with `free` they fill the window.
struct Layout {
  kit::Rect menu, bar, tools, settings, upper, lower, rail, status;
  kit::Rect free;
  int toolColumns = 2;
  bool toolHeadings = false;  ///< There is room for the names of groups of tools; else a line parts them.
};

inline constexpr float kMenuHeight = 28, kBarHeight = 44, kStatusHeight = 26, kRailWidth = 42;
inline constexpr float kRailEdge = 36, kToolEdge = 32, kToolPad = 5;  ///< Of the buttons on the right edge and among the tools.
inline constexpr float kToolGap = 2, kToolLine = 7, kToolHeading = 19;  ///< Between buttons; between groups, without and with their names.
inline constexpr float kSettingsWidth = 236, kSideWidth = 288;

/// `toolGroups`: so many buttons each group of tools has. There are as few columns as the window's height allows, two at least; each group begins a row.
[[nodiscard]] Layout layOut(float width, float height, const PanelsShown& shown, std::span<const int> toolGroups);

}  // namespace argil::studio
