#pragma once
// Where everything flat stands: fixed docks around the picture.

#include <span>
#include <string_view>

#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/view/panel_table.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// Rectangles in interface units, empty for what is hidden. Those that are docked do not overlap; together with `free`
/// they fill the window. A dock that would leave the clay too little room is folded: it is empty, or one of them stands
/// over `free`.
struct Layout {
  kit::Rect menu, bar, tools, settings, upper, lower, rail, status;
  kit::Rect free;
  kit::Rect clear;  ///< `free` less the folded panel that stands over it.
  /// Also of hidden docks: where they would go.
  bool toolsFolded = false, settingsFolded = false, sideFolded = false;
  int toolColumns = 2;
  bool toolHeadings = false;  ///< There is room for the names of groups of tools; else a line parts them.
  bool toolsScroll = false;   ///< The window is too low for all of them.
  float railEdge = 0;         ///< Of the rail's buttons.
  bool railFoot = true;       ///< There is room for palette, keys and preferences at its foot.

  [[nodiscard]] bool folded(Dock dock) const;
};

inline constexpr float kMenuHeight = 28, kBarHeight = 44, kStatusHeight = 26, kRailWidth = 42;
/// Of the buttons on the right edge and among the tools.
inline constexpr float kRailEdge = 36, kToolEdge = 32, kToolPad = 5;
inline constexpr float kRailGap = 10;  ///< Between the docks' buttons.
/// Between buttons; between groups, without and with their names.
inline constexpr float kToolGap = 2, kToolLine = 7, kToolHeading = 19;
inline constexpr float kSettingsWidth = 236, kSideWidth = 288;
inline constexpr float kSettingsLeast = 204;   ///< The settings may shrink to this rather than be folded.
inline constexpr double kClayPart = 0.6;       ///< Of the window's area that is the clay's before a dock is folded.
inline constexpr double kLeastClayPart = 0.3;  ///< The same for a person who wants the docks to stay.
/// The smallest window that holds everything. A smaller one is drawn at a smaller scale: see scaleThatFits().
inline constexpr float kLeastWindowWidth = 640, kLeastWindowHeight = 360;

/// `toolGroups`: so many buttons each group of tools has. There are as few columns as the window's height allows, two
/// at least; each group begins a row. Folded first is the right side, then the settings, then the tools. `over`: see
/// StudioState::over.
[[nodiscard]] Layout layOut(float width, float height, const PanelsShown& shown, std::span<const int> toolGroups,
                            std::string_view over = {}, double clayPart = kClayPart);

/// A panel can be seen: docked, in the middle, or over the clay.
[[nodiscard]] bool isSeen(const Layout& layout, const StudioState& state, const PanelRow& row);
/// Shows or hides a panel, where it is folded over the clay.
void turnPanel(const Layout& layout, StudioState& state, const PanelRow& row);

/// The width of a picture, seen from the window's middle, that no dock covers on either side, as a part of its height.
[[nodiscard]] double freeAspect(const kit::Rect& free, float width, float height);

/// Which groups of buttons the bar has room for. Undo and redo are always there.
struct BarGroups {
  int numbers = 2;     ///< Of the tool.
  float number = 152;  ///< Their width.
  bool symmetry = true, shading = true, view = true;
};
inline constexpr float kBarButton = 30;
/// `folded`: so many docks have a button in the bar; `stop`: the width of the button that stops forces, 0 where there
/// is none.
[[nodiscard]] BarGroups barGroups(float width, int folded, float stop);
/// How wide they are.
[[nodiscard]] float barWidth(const BarGroups& groups, int folded, float stop);

/// The scale, pixels a unit, at which a window of so many pixels has room for everything: the one that is wanted, or
/// less.
[[nodiscard]] float scaleThatFits(float wanted, int width, int height);

/// The window as it opens first, from the work area of the screen (pixels) and its scale: maximised where a window with
/// air around it would be small.
struct FirstWindow {
  bool maximised = false;
  int width = 0, height = 0;  ///< When it is not.
};
[[nodiscard]] FirstWindow firstWindow(int workWidth, int workHeight, float scale);

}  // namespace argil::studio
