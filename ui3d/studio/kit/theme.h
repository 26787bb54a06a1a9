#pragma once
// Colours, sizes and fonts of everything flat.

#include <imgui.h>

#include <span>
#include <string>

#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// One theme: quiet greys and one accent, far from the clay's own colours. Every text colour has a contrast of 4.5 or
/// more to what it stands on (WCAG 2, AA).
struct Colours {
  ImU32 panel, bar, field, fieldHover, fieldPress;  ///< Surfaces: of panels, of bars, of what can be pressed.
  ImU32 line;                                       ///< Between things.
  ImU32 text, dim;                                  ///< On all surfaces above.
  ImU32 accent, onAccent;                           ///< What is chosen, and text on it.
  ImU32 soft;                                       ///< Behind a chosen row; `text` stands on it.
  ImU32 level;                                      ///< The filled part of a slider; `text` stands on it.
  ImU32 good, warning, error;                       ///< Texts of messages, on panel and bar.
  ImU32 stop, onStop;                               ///< The stop button.
};
[[nodiscard]] const Colours& coloursOf(Theme theme);
/// Of the theme in force.
[[nodiscard]] const Colours& colours();

/// WCAG 2 contrast of two opaque colours: 1 to 21.
[[nodiscard]] double contrast(ImU32 a, ImU32 b);

/// Pairs of text and what it stands on.
struct TextPair {
  const char* name;
  ImU32 text, ground;
};
[[nodiscard]] std::vector<TextPair> textPairs(Theme theme);

struct Fonts {
  ImFont *body = nullptr, *strong = nullptr, *small = nullptr, *title = nullptr;
};
/// Colours, sizes and font for a theme and a scale; before NewFrame(), when one of them changed. Makes the font's
/// picture anew.
void applyTheme(Theme theme, float scale);
/// Of the last applyTheme(); null pointers before it.
[[nodiscard]] const Fonts& fonts();
/// The font file that is used: the first of those known that is installed; empty: ImGui's own letters.
[[nodiscard]] std::string fontFile(bool strong);

// Interface units.
inline constexpr float kTextSize = 14.5f, kSmallSize = 13, kTitleSize = 24;
inline constexpr float kRow = 28;         ///< Height of a row that can be pressed.
inline constexpr float kGap = 6;          ///< Between rows.
inline constexpr float kPad = 12;         ///< From a panel's edge to what is in it.
inline constexpr float kRound = 5;        ///< Corners.
inline constexpr float kDimming = 0.35f;  ///< Opacity of the black over everything behind a dialog.

/// Pixels a unit, as applyTheme() was told.
[[nodiscard]] float pixelScale();

}  // namespace argil::studio
