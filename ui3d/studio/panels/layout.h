#pragma once
// Where everything flat stands: fixed docks around the picture.

#include "ui3d/studio/panels/kit.h"
#include "ui3d/studio/studio_state.h"

namespace argil::studio {

/// Rectangles in interface units, empty for what is hidden. No two overlap; together with `free` they fill the window.
struct Layout {
  kit::Rect menu, bar, tools, settings, upper, lower, rail, status;
  kit::Rect free;
  int toolColumns = 1;
};

inline constexpr float kMenuHeight = 28, kBarHeight = 44, kStatusHeight = 26, kRailWidth = 42;
inline constexpr float kToolEdge = 36, kToolPad = 5;           ///< Of the buttons in the tools' column.
inline constexpr float kSettingsWidth = 236, kSideWidth = 288;

/// `toolRows`: buttons in the column of tools, of which there are more columns when the window is too low for one.
[[nodiscard]] Layout layOut(float width, float height, const PanelsShown& shown, int toolRows);

}  // namespace argil::studio
