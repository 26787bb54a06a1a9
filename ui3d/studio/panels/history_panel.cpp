#include <cmath>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {

void historyPanel(Context& context, Memory& memory) {
  const size_t steps = context.now.history ? context.now.history->size() : 0, done = context.now.done;
  constexpr float kHeight = 26;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {kGap, 0});
  ImGui::BeginChild("steps");
  kit::sharpen(*ImGui::GetWindowDrawList());
  ImGuiListClipper clipper;
  clipper.Begin(int(steps) + 1, kHeight);
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const size_t step = size_t(i);
      ImGui::PushID(i);
      if (ImGui::InvisibleButton("step", {ImGui::GetContentRegionAvail().x, kHeight}) && step != done)
        context.bench.goTo(step);
      const bool hovered = ImGui::IsItemHovered();
      const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
      ImDrawList& list = *ImGui::GetWindowDrawList();
      const Colours& c = colours();
      if (step == done || hovered) list.AddRectFilled(a, b, step == done ? c.soft : c.fieldHover, kRound);
      const float middle = (a.y + b.y) / 2;
      if (step <= done)
        list.AddCircleFilled({a.x + 12, middle}, step == done ? 4.0f : 2.5f, step == done ? c.accent : c.dim);
      else
        list.AddCircle({a.x + 12, middle}, 2.5f, c.dim, 0, 1);
      const ImVec2 after = ImGui::GetCursorPos();
      ImGui::SetCursorScreenPos({a.x + 24, std::floor(middle - ImGui::GetTextLineHeight() / 2)});
      kit::elided(step == 0 ? std::string_view("Beginning") : std::string_view((*context.now.history)[step - 1]),
                  b.x - a.x - 30, step > done ? c.dim : c.text);
      ImGui::SetCursorPos(after);
      ImGui::PopID();
    }
  }
  clipper.End();
  if (memory.historyShown != done) {
    const float y = float(done) * kHeight, seen = ImGui::GetWindowHeight();
    if (y < ImGui::GetScrollY())
      ImGui::SetScrollY(y);
    else if (y + kHeight > ImGui::GetScrollY() + seen)
      ImGui::SetScrollY(y + kHeight - seen);
    memory.historyShown = done;
  }
  ImGui::EndChild();
  ImGui::PopStyleVar();
}

}  // namespace argil::studio
