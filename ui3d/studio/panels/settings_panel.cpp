#include <cmath>

#include "ui3d/studio/panels/icons.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/panels/theme.h"

namespace argil::studio {

void settingsPanel(Context& context, Memory& memory) {
  const engine::ToolRow* row = engine::findTool(context.state.toolId);
  if (row) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(*ImGui::GetWindowDrawList(), row->icon, {at.x + 10, at.y + 9}, 20, colours().accent);
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + (hasIcon(row->icon) ? 28 : 0));
    ImGui::PushFont(fonts().strong);
    kit::text(row->name);
    ImGui::PopFont();
    kit::wrapped(row->help, colours().dim);
    kit::gap(4);
    drawRows(engine::ownParameters(*row), context.state.tool());
    if (row->opposite == row->id) kit::toggle("Inverted", context.state.tool().inverted, "The other way round; Ctrl held does it for a stroke.");
    kit::gap(2);
    if (kit::button(memory.handOpen ? "Hand and pressure  −" : "Hand and pressure  +", kit::Weight::plain, ImGui::GetContentRegionAvail().x)) memory.handOpen = !memory.handOpen;
    if (memory.handOpen) drawRows(engine::heldParameters(*row), context.state.tool());
  }
  if (context.bench.usesPointer()) drawRows(handRows(), context.state);
  deformSection(context);

  kit::heading("Symmetry");
  const float each = std::floor((ImGui::GetContentRegionAvail().x - 2 * kGap) / 3);
  for (const auto& [axis, letter] : {std::pair{"symmetry.x", "X"}, {"symmetry.y", "Y"}, {"symmetry.z", "Z"}}) {
    if (letter[0] != 'X') ImGui::SameLine();
    const Action* action = findAction(axis);
    if (kit::button(letter, action->checked(context, action->argument) ? kit::Weight::chief : kit::Weight::plain, each)) runAction(context, axis);
    kit::tooltip(action->help, shortcutOf(*action, context.state));
  }
  inspector(context, memory);
}

}  // namespace argil::studio
