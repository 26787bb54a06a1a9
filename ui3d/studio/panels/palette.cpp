#include <algorithm>
#include <cmath>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {

void drawPalette(Context& context, Memory& memory) {
  bool& open = context.state.shown.palette;
  const bool begins = open && !memory.paletteOpen;
  memory.paletteOpen = open;
  if (begins) {
    memory.paletteTyped.clear();
    memory.paletteChosen = 0;
  }
  constexpr float kHeight = 32;
  constexpr int kRows = 11;
  if (!kit::beginDialog("Palette", nullptr, 560, 66 + kRows * kHeight, &open)) return;
  const std::string before = memory.paletteTyped;
  const bool entered = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false) ||
                       ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_KeyPadEnter), false);
  kit::textField("##typed", memory.paletteTyped, 0, "What shall be done? Type a part of its name",
                 ImGui::IsWindowAppearing() || begins);
  std::vector<const Action*> found = searchActions(memory.paletteTyped);
  const bool none = found.empty();
  if (none) found = nearestActions(memory.paletteTyped);
  int& chosen = memory.paletteChosen;
  const int least = none ? -1 : 0;  // What was not asked for is not run by Enter alone.
  if (memory.paletteTyped != before) chosen = least;
  const int shift = kit::arrowStep();
  chosen = std::clamp(chosen + shift, least, int(found.size()) - 1);

  const Action* run = nullptr;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, 0});
  ImGui::BeginChild("found");
  kit::sharpen(*ImGui::GetWindowDrawList());
  if (none) {
    kit::gap(10);
    kit::wrapped("No results. The nearest are:", colours().dim);
    kit::gap(6);
  }
  for (int i = 0; i < int(found.size()); ++i) {
    const Action& action = *found[size_t(i)];
    const bool enabled = !action.enabled || action.enabled(context);
    ImGui::PushID(i);
    if (ImGui::InvisibleButton("action", {ImGui::GetContentRegionAvail().x, kHeight}) && enabled) run = &action;
    const bool hovered = ImGui::IsItemHovered();
    if (hovered && (ImGui::GetIO().MouseDelta.x != 0 || ImGui::GetIO().MouseDelta.y != 0)) chosen = i;
    const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const Colours& c = colours();
    if (chosen == i) {
      list.AddRectFilled(a, b, c.soft, kRound);
      if (shift != 0) ImGui::SetScrollHereY(shift > 0 ? 1.0f : 0.0f);
    }
    const float y = std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2);
    const bool checked = action.checked && action.checked(context, action.argument);
    if (checked) list.AddCircleFilled({a.x + 12, (a.y + b.y) / 2}, 3, c.accent);
    list.AddText({a.x + 24, y}, enabled ? c.text : c.dim, action.name.c_str());
    const float named = ImGui::CalcTextSize(action.name.c_str()).x + 38;
    const std::string keys = shortcutOf(action, context.state);
    const std::string key = keys.substr(0, keys.find(' '));
    const float right = ImGui::CalcTextSize(key.c_str()).x + 12;
    list.AddText({b.x - right, y}, c.dim, key.c_str());
    ImGui::PushFont(fonts().small);
    const ImVec4 clip{a.x + named, a.y, b.x - right - 12, b.y};
    list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), {a.x + named, y + 1}, c.dim, action.help.c_str(), nullptr, 0,
                 &clip);
    ImGui::PopFont();
    ImGui::PopID();
  }
  ImGui::EndChild();
  ImGui::PopStyleVar();
  if (entered && chosen >= 0) {
    const Action* action = found[size_t(chosen)];
    if (!action->enabled || action->enabled(context)) run = action;
  }
  if (run) open = false;
  kit::endDialog(open);
  if (run) run->run(context, run->argument);
}

}  // namespace argil::studio
