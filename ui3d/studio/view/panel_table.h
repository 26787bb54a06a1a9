#pragma once
// The panels that there are.

#include <span>
#include <string_view>

#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// Where a panel stands.
enum class Dock : uint8_t {
  tools,     ///< The narrow column on the left edge.
  settings,  ///< Beside it.
  upper,     ///< Right, above; one is seen at a time.
  lower,     ///< Right, below; one is seen at a time.
  middle,    ///< Over the picture, until it is closed.
};

struct PanelRow {
  std::string_view id, name, help;  ///< help: one sentence.
  std::string_view icon;            ///< See icons.h.
  std::string_view shortcut;        ///< As it ships.
  Dock dock = Dock::lower;
  bool PanelsShown::*shown = nullptr;
};

[[nodiscard]] std::span<const PanelRow> panelTable();
[[nodiscard]] const PanelRow* findPanel(std::string_view id);
/// Shows a panel, in place of the others of its dock where one is seen at a time; or hides it.
void showPanel(PanelsShown& shown, const PanelRow& row, bool on);

}  // namespace argil::studio
