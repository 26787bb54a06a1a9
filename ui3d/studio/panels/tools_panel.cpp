#include "ui3d/studio/panels/icons.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/theme.h"

namespace argil::studio {
namespace {

constexpr std::array<std::string_view, 3> kGizmo{"move", "rotate", "scale"};
constexpr std::array<std::string_view, 7> kGuides{"plane", "line", "point", "curve", "box", "ruler", "angle"};

void separator() {
  kit::gap(3);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddLine({at.x + 4, at.y}, {at.x + ImGui::GetContentRegionAvail().x - 4, at.y}, colours().line, 1);
  kit::gap(5);
}

}  // namespace

int toolButtons() { return int(engine::toolTable().size() + kGizmo.size() + 1 + kGuides.size()); }

void drawTools(Context& context, Memory& memory) {
  if (!context.state.shown.tools) return;
  kit::begin("Tools", memory.layout.tools, colours().bar, {kToolPad, kToolPad}, ImGuiWindowFlags_NoScrollbar);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {2, 2});
  int column = 0;
  const auto place = [&] {
    if (column > 0) ImGui::SameLine(0, 2);
    column = (column + 1) % memory.layout.toolColumns;
  };
  for (const engine::ToolRow& tool : engine::toolTable()) {
    place();
    actionButton(context, "tool." + std::string(tool.id), tool.icon, kToolEdge, tool.name);
  }
  column = 0;
  separator();
  for (const std::string_view mode : kGizmo) {
    place();
    actionButton(context, "gizmo." + std::string(mode), mode, kToolEdge);
  }
  place();
  actionButton(context, "guides.snap", "snap", kToolEdge);
  column = 0;
  separator();
  for (const std::string_view kind : kGuides) {
    place();
    actionButton(context, "guides." + std::string(kind), kind, kToolEdge);
  }
  ImGui::PopStyleVar();
  kit::end();
}

}  // namespace argil::studio
