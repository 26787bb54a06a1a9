#include "ui3d/studio/view/panel_table.h"

#include <algorithm>
#include <array>

namespace argil::studio {
namespace {

using P = PanelsShown;
constexpr std::array kPanels{
    PanelRow{"tools", "Tools", "The tools that work on the clay.", "tools", "F2", Dock::tools, &P::tools},
    PanelRow{"settings", "Settings", "What the tool in hand does, and symmetry.", "settings", "F3", Dock::settings,
             &P::settings},
    PanelRow{"things", "Things", "Pieces of clay, parts and guides.", "things", "F4", Dock::upper, &P::things},
    PanelRow{"history", "History", "Every step, to go back to or forward.", "history", "F5", Dock::upper, &P::history},
    PanelRow{"view", "View", "How the clay is shaded and seen, by one eye or by two.", "view", "F6", Dock::lower,
             &P::view},
    PanelRow{"touch", "Touch", "The device in the hand, its forces, its limits, the stop.", "touch", "F7", Dock::lower,
             &P::touch},
    PanelRow{"quality", "Quality", "Speed against looks, and what each costs.", "quality", "F8", Dock::lower,
             &P::quality},
    PanelRow{"facts", "Document", "Sizes and costs of what is open.", "facts", "F9", Dock::lower, &P::facts},
    PanelRow{"print", "Print check", "What stands in the way of printing the piece.", "print", "F12", Dock::lower,
             &P::print},
    PanelRow{"messages", "Messages", "What was said since the start.", "messages", "F10", Dock::lower, &P::messages},
    PanelRow{"exporting", "Export", "Writes the clay for printers and other programs.", "export", "", Dock::middle,
             &P::exporting},
    PanelRow{"palette", "Command palette", "Finds everything that can be done by its name.", "search", "Ctrl+P Space",
             Dock::middle, &P::palette},
    PanelRow{"shortcuts", "Keys", "All shortcuts, to look up and to change.", "keys", "F1", Dock::middle,
             &P::shortcuts},
    PanelRow{"preferences", "Preferences", "Theme and size of the interface.", "preferences", "Ctrl+,", Dock::middle,
             &P::preferences},
    PanelRow{"plugins", "Plugins", "Brushes of other people: which are there, what they may, which are enabled.",
             "plugins", "", Dock::middle, &P::plugins},
    PanelRow{"firstStart", "Start page", "What to begin with: new clay, a file, what was opened before.", "home", "",
             Dock::middle, &P::firstStart},
};

}  // namespace

std::span<const PanelRow> panelTable() {
  return kPanels;
}

const PanelRow* findPanel(std::string_view id) {
  const auto row = std::find_if(kPanels.begin(), kPanels.end(), [&](const PanelRow& each) { return each.id == id; });
  return row == kPanels.end() ? nullptr : &*row;
}

void showPanel(PanelsShown& shown, const PanelRow& row, bool on) {
  if (on && (row.dock == Dock::upper || row.dock == Dock::lower)) {
    for (const PanelRow& other : kPanels) {
      if (other.dock == row.dock) shown.*other.shown = false;
    }
  }
  shown.*row.shown = on;
}

}  // namespace argil::studio
