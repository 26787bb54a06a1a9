// Every tool in its group, the handles of things and the kinds of guides: each one click away.

#include <cmath>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

constexpr std::array<std::string_view, 3> kGizmo{"move", "rotate", "scale"};
constexpr std::array<std::string_view, 7> kGuides{"plane", "line", "point", "curve", "box", "ruler", "angle"};

// Before a group: its name where there is room, else a line; lines only between groups.
void part(const Memory& memory, std::string_view name, bool first) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  if (memory.layout.toolHeadings) {
    ImGui::PushFont(fonts().small);
    ImGui::GetWindowDrawList()->AddText({at.x + 2, std::floor(at.y + kToolHeading - 2 - ImGui::GetTextLineHeight())},
                                        colours().dim, name.data(), name.data() + name.size());
    ImGui::PopFont();
    ImGui::Dummy({width, kToolHeading - kToolGap});
  } else if (!first) {
    const float y = at.y + std::floor((kToolLine - kToolGap) / 2) + 0.5f;
    ImGui::GetWindowDrawList()->AddLine({at.x + 2, y}, {at.x + width - 2, y}, colours().line, 1);
    ImGui::Dummy({width, kToolLine - kToolGap});
  }
}

}  // namespace

std::vector<int> toolGroups() {
  std::vector<int> counts;
  std::string_view group;
  for (const engine::ToolRow& tool : engine::toolTable()) {
    if (counts.empty() || tool.group != group) counts.push_back(0);
    group = tool.group;
    ++counts.back();
  }
  counts.push_back(int(kGizmo.size()) + 1);
  counts.push_back(int(kGuides.size()));
  return counts;
}

void drawTools(Context& context, Memory& memory) {
  if (memory.layout.tools.empty()) return;
  kit::begin("Tools", memory.layout.tools, colours().bar, {kToolPad, kToolPad},
             memory.layout.toolsScroll ? 0 : ImGuiWindowFlags_NoScrollbar);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {kToolGap, kToolGap});
  int column = 0;
  const auto begin = [&](std::string_view name, bool first = false) {
    column = 0;
    part(memory, name, first);
  };
  const auto place = [&] {
    if (column > 0) ImGui::SameLine(0, kToolGap);
    column = (column + 1) % memory.layout.toolColumns;
  };
  std::string_view group;
  for (const engine::ToolRow& tool : engine::toolTable()) {
    if (tool.group != group) begin(tool.group, group.empty());
    group = tool.group;
    place();
    actionButton(context, "tool." + std::string(tool.id), hasIcon(tool.id) ? tool.id : tool.icon, kToolEdge, tool.name);
  }
  begin("Handles");
  for (const std::string_view mode : kGizmo) {
    place();
    actionButton(context, "gizmo." + std::string(mode), mode, kToolEdge);
  }
  place();
  actionButton(context, "guides.snap", "snap", kToolEdge);
  begin("Guides");
  for (const std::string_view kind : kGuides) {
    place();
    actionButton(context, "guides." + std::string(kind), kind, kToolEdge);
  }
  ImGui::PopStyleVar();
  kit::end();
}

}  // namespace argil::studio
