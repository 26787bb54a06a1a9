// Menu, quick bar, the rail of panels on the right edge, status line.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/document/guide_table.h"
#include "ui3d/studio/files/save_words.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

constexpr std::array kMenus{"File", "Edit", "Clay", "Piece", "Tool", "Guides", "View", "Touch", "Window", "Help"};
constexpr double kStrokeTold = 0.3;  // Seconds after its end a stroke that is still worked on is spoken of.

// A thin line between groups of a bar.
void divide() {
  ImGui::SameLine(0, 9);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddLine({at.x, at.y + 4}, {at.x, at.y + kBarButton - 4}, colours().line, 1);
  ImGui::Dummy({1, kBarButton});
  ImGui::SameLine(0, 9);
}

void menuItem(Context& context, const Action& action) {
  const bool enabled = !action.enabled || action.enabled(context),
             checked = action.checked && action.checked(context, action.argument);
  const std::string keys = shortcutOf(action, context.state);
  if (ImGui::MenuItem(action.name.c_str(), keys.substr(0, keys.find(' ')).c_str(), checked, enabled))
    action.run(context, action.argument);
}

// A menu for each group of operations on whole pieces.
void pieceMenu(Context& context) {
  std::string_view group;
  bool open = false;
  for (const engine::PieceJob& job : engine::pieceJobs()) {
    const Action* action = findAction("piece." + std::string(job.id));
    if (!action) continue;
    if (job.group != group) {
      if (open) ImGui::EndMenu();
      group = job.group;
      open = kit::beginMenuInMenu(std::string(group).c_str());
      if (open) kit::beginMenuRows();
    }
    if (open) menuItem(context, *action);
  }
  if (open) ImGui::EndMenu();
}

// A mouse that is not over the picture is silent too: nothing that a person need know.
bool forcesAil(const Context& context, const Memory& memory) {
  const haptics::ServoState state = memory.touch.state;
  return forcesStopped(memory) || state == haptics::ServoState::hung ||
         (state == haptics::ServoState::silent && !context.bench.usesPointer());
}

}  // namespace

std::string strokeWords(std::string_view tool, double leftS, double fromS) {
  std::string words(tool);
  words += ": the stroke is being worked into the clay";
  if (fromS > 0 && leftS > 0 && leftS <= fromS) words += ", " + std::to_string(int(100 * (1 - leftS / fromS))) + " %";
  return words + "…";
}

bool forcesStopped(const Memory& memory) {
  // A stop by the person leaves the servo's own state as it was: the sentence alone tells.
  return memory.touch.state == haptics::ServoState::stopped || memory.touch.sentence.starts_with("Forces are stopped");
}

void runAction(Context& context, std::string_view id) {
  const Action* action = findAction(id);
  if (action && (!action->enabled || action->enabled(context))) action->run(context, action->argument);
}

bool actionButton(Context& context, std::string_view id, std::string_view icon, float edge, std::string_view letters) {
  const Action* action = findAction(id);
  if (!action) return false;
  const bool enabled = !action->enabled || action->enabled(context),
             checked = action->checked && action->checked(context, action->argument);
  ImGui::BeginDisabled(!enabled);
  const bool pressed = kit::iconButton(action->id.c_str(), icon, edge,
                                       !checked                  ? kit::Lit::off
                                       : id.starts_with("tool.") ? kit::Lit::full
                                                                 : kit::Lit::soft,
                                       action->name + ". " + action->help, shortcutOf(*action, context.state), letters);
  ImGui::EndDisabled();
  if (pressed) action->run(context, action->argument);
  return pressed;
}

std::string_view iconOf(const engine::Document& document, engine::Id id) {
  if (document.piece(id)) return "block";
  if (document.part(id)) return "sphere";
  const engine::Guide* guide = document.guide(id);
  return guide ? engine::rowOf(guide->kind).icon : "point";
}

void drawMenu(Context& context, Memory& memory) {
  kit::begin("Menu", memory.layout.menu, colours().bar, {6, 0},
             ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoScrollbar);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {14, 7});
  if (ImGui::BeginMenuBar()) {
    if (std::exchange(memory.menuWished, false)) kit::openMenu(kMenus.front());
    if (const int step = kit::menuStepAcross(); step != 0)
      for (size_t i = 0; i < kMenus.size(); ++i)
        if (ImGui::IsPopupOpen(kMenus[i])) {
          kit::openMenu(kMenus[(i + kMenus.size() + size_t(step)) % kMenus.size()]);
          break;
        }
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8, 8});
    for (const char* group : kMenus) {
      if (!ImGui::BeginMenu(group)) continue;
      kit::beginMenuRows();
      if (std::string_view(group) == "Piece") pieceMenu(context);
      std::string prefix;
      for (const Action& action : actions()) {
        // Formats are chosen in the export; by name they are found in the palette.
        if (action.group != group || action.id.starts_with("file.export.") || action.id.starts_with("piece.")) continue;
        // Rows of one family stand together.
        const std::string family = action.id.substr(0, action.id.find('.'));
        if (!prefix.empty() && family != prefix) ImGui::Separator();
        prefix = family;
        menuItem(context, action);
      }
      if (std::string_view(group) == "Help") {
        ImGui::Separator();
        ImGui::MenuItem("Argil " ARGIL_VERSION, nullptr, false, false);
      }
      ImGui::EndMenu();
    }
    ImGui::PopStyleVar();
    ImGui::EndMenuBar();
  }
  ImGui::PopStyleVar();
  kit::end();
}

void drawBar(Context& context, Memory& memory) {
  kit::begin("Bar", memory.layout.bar, colours().panel, {8, (kBarHeight - kBarButton) / 2},
             ImGuiWindowFlags_NoScrollbar);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const kit::Rect& rect = memory.layout.bar;
  for (const float y : {rect.top + 0.5f, rect.bottom - 0.5f}) kit::frameLine({rect.left, y}, {rect.right, y});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {2, 2});
  const bool stopped = forcesStopped(memory), stoppable = !context.bench.usesPointer() || stopped;
  const float stopWidth = std::max(kit::buttonWidth("Resume forces", "play"), kit::buttonWidth("Stop forces", "stop"));
  // What is folded is opened from here, as the rail does it on the other side.
  const int folded = int(memory.layout.toolsFolded) + int(memory.layout.settingsFolded);
  const BarGroups groups = barGroups(rect.width(), folded, stoppable ? stopWidth : 0);
  for (const auto& [id, isFolded] :
       {std::pair{"tools", memory.layout.toolsFolded}, {"settings", memory.layout.settingsFolded}}) {
    if (!isFolded) continue;
    actionButton(context, std::string("panel.") + id, findPanel(id)->icon, kBarButton);
    ImGui::SameLine();
  }
  if (folded > 0) {
    ImGui::SameLine(0, 0);
    divide();
  }
  actionButton(context, "edit.undo", "undo", kBarButton);
  ImGui::SameLine();
  actionButton(context, "edit.redo", "redo", kBarButton);

  const engine::ToolRow* tool = engine::findTool(context.state.toolId);
  if (groups.numbers > 0) divide();
  // Two numbers of the tool at the most: the rest is in the settings.
  int numbers = 0;
  for (const auto& row : tool ? engine::ownParameters(*tool) : std::span<const engine::Parameter<engine::Tool>>()) {
    if (numbers == groups.numbers || !row.choices.empty() || row.unit == "colour" || row.unit == "on" ||
        !counts(row, context.state.tool(), context.bench.usesPointer()))
      continue;
    if (numbers++ > 0) ImGui::SameLine(0, 6);
    ImGui::SetCursorPosY((kBarHeight - kRow) / 2);
    ImGui::PushID("bar");
    (void)drawRow(row, context.state.tool(), groups.number);
    ImGui::PopID();
  }
  ImGui::SameLine();
  ImGui::SetCursorPosY((kBarHeight - kBarButton) / 2);
  if (groups.symmetry) {
    divide();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(list, "symmetry", {at.x + 10, at.y + kBarButton / 2}, 18, colours().dim);
    ImGui::Dummy({24, kBarButton});
    for (const char* axis : {"x", "y", "z"}) {
      ImGui::SameLine();
      const char letter[2] = {static_cast<char>(axis[0] - 32), 0};
      actionButton(context, std::string("symmetry.") + axis, "", kBarButton, letter);
    }
    ImGui::SameLine();
    actionButton(context, "tool.straight", "straight", kBarButton);
  }
  if (groups.shading) {
    divide();
    for (const auto& [id, icon] :
         {std::pair{"shading.matcap", "matcap"}, {"shading.lit", "lit"}, {"shading.material", "material"}}) {
      actionButton(context, id, icon, kBarButton);
      ImGui::SameLine();
    }
    ImGui::SameLine(0, 0);
  }
  if (groups.view) {
    divide();
    for (const auto& [id, icon] : {std::pair{"view.projection", "ortho"},
                                   {"view.section", "section"},
                                   {"look.xray", "xray"},
                                   {"view.all", "focus"}}) {
      actionButton(context, id, icon, kBarButton);
      ImGui::SameLine();
    }
    const bool stereo = context.state.stereo.mode != render::StereoMode::mono;
    if (kit::iconButton("stereo", "stereo", kBarButton, stereo ? kit::Lit::soft : kit::Lit::off,
                        "Stereo on or off; the View panel has its modes")) {
      context.state.stereo.mode = stereo ? render::StereoMode::mono : render::StereoMode::anaglyph;
    }
  }

  if (stoppable) {
    const char* words = stopped ? "Resume forces" : "Stop forces";
    ImGui::SameLine(rect.width() - stopWidth - 8);
    ImGui::SetCursorPosY((kBarHeight - kRow) / 2);
    if (kit::button(words, stopped ? kit::Weight::chief : kit::Weight::danger, stopWidth, stopped ? "play" : "stop"))
      runAction(context, stopped ? "touch.resume" : "touch.stop");
    const Action* action = findAction(stopped ? "touch.resume" : "touch.stop");
    kit::tooltip(action->help, shortcutOf(*action, context.state));
  }
  ImGui::PopStyleVar();
  kit::end();
}

void drawRail(Context& context, Memory& memory) {
  kit::begin("Rail", memory.layout.rail, colours().bar, {3, kToolPad}, ImGuiWindowFlags_NoScrollbar);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {2, 2});
  Dock last = Dock::upper;
  const float edge = memory.layout.railEdge;
  for (const PanelRow& panel : panelTable()) {
    if (panel.dock != Dock::upper && panel.dock != Dock::lower) continue;
    if (panel.dock != last) kit::gap(kRailGap);
    last = panel.dock;
    actionButton(context, "panel." + std::string(panel.id), panel.icon, edge);
  }
  if (memory.layout.railFoot) {  // Else by menu and key.
    ImGui::SetCursorPosY(memory.layout.rail.height() - 3 * (edge + 2) - kToolPad + 2);
    for (const char* id : {"palette", "shortcuts", "preferences"})
      actionButton(context, std::string("panel.") + id, findPanel(id)->icon, edge);
  }
  ImGui::PopStyleVar();
  kit::end();
}

void drawStatus(Context& context, Memory& memory) {
  const kit::Rect& rect = memory.layout.status;
  kit::begin("Status", rect, colours().bar, {10, 0}, ImGuiWindowFlags_NoScrollbar);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  kit::frameLine({rect.left, rect.top + 0.5f}, {rect.right, rect.top + 0.5f});
  ImGui::PushFont(fonts().small);
  const Colours& c = colours();
  const float y = std::floor((kStatusHeight - ImGui::GetTextLineHeight()) / 2) + 0.0f;

  const Keeping keeping = savingWords(context.now.file, std::chrono::system_clock::now());
  // Right to left: what matters most stays when the window is narrow.
  const FrameFigures& f = context.state.figures;
  const haptics::StylusSample& s = memory.touch.latest;
  std::vector<std::pair<std::string, float>> right;
  right.emplace_back(keeping.words, 0);
  right.emplace_back(memory.touch.device.empty()   ? "no device"
                     : context.bench.usesPointer() ? "mouse or pen"
                                                   : memory.touch.device,
                     0);
  right.emplace_back(kit::written(std::round(f.framesPerSecond)) + " frames/s", 96);
  right.emplace_back(kit::counted(f.triangles) + " triangles", 128);
  char text[96];
  std::snprintf(text, sizeof text, "x %.2f  y %.2f  z %.2f mm", s.proxy.x(), s.proxy.y(), s.proxy.z());
  right.emplace_back(text, 210);
  if (!context.bench.usesPointer()) {
    std::snprintf(text, sizeof text, "%.2f N", s.forceN.norm());
    right.emplace_back(text, 56);
  }
  float x = rect.width() - 10;
  for (const auto& [words, least] : right) {
    const bool first = &words == &right.front().first;
    const float needed = std::max(least, std::ceil(ImGui::CalcTextSize(words.c_str()).x));
    if (x - needed < 0.33f * rect.width()) break;
    x -= needed;
    ImGui::SetCursorPos({x, y});
    if (first && keeping.ails)
      kit::elided(words, needed, c.warning);
    else
      kit::dimText(words);
    x -= 14;
    list.AddLine({x + 7, rect.top + 7}, {x + 7, rect.bottom - 6}, c.line, 1);
  }

  std::string doing;
  ImU32 colour = c.text;
  const std::vector<engine::JobView> jobs = context.bench.jobs();
  const engine::ToolRow* tool = engine::findTool(context.state.toolId);
  const engine::Workbench::StrokeWork work = context.bench.strokeWork();
  if (tool && work.on && !memory.handCuts && context.timeS - memory.releasedS > kStrokeTold) {
    doing = strokeWords(tool->name, work.leftS, memory.strokeFromS);
  } else if (!jobs.empty())
    doing = jobs.front().name + (jobs.size() > 1 ? " and " + std::to_string(jobs.size() - 1) + " more" : "") + "…";
  else if (forcesAil(context, memory)) {
    doing = kit::sentence(memory.touch.sentence);
    colour = c.warning;
  } else if (context.now.document->pieces.empty())
    doing = "No clay yet: add a block, or open a file";
  else if (!context.now.document->workedOn()) {
    doing = "The active piece is hidden or locked: it cannot be worked on";
    colour = c.warning;
  } else if (context.state.drawnCurve)
    doing = std::string(context.state.drawnCurve->job->name) + ": " + context.state.drawnCurve->hint();
  else if (context.state.planeCut)
    doing = std::string(context.state.planeCut->job->name) + ": " + context.state.planeCut->hint();
  else if (context.state.deformBox)
    doing = "Deform box: pull its points, or set numbers. Enter: apply. Esc: the clay as it was";
  else if (tool && tool->file != engine::ToolFile::none && context.state.tool().file.empty()) {
    doing = std::string(tool->name) + (tool->file == engine::ToolFile::image
                                           ? " needs an image: choose one in the settings"
                                           : " needs a shape: choose one in the settings");
    colour = c.warning;
  } else if (tool && context.state.straight)
    doing = std::string(tool->name) + " on " + context.now.document->workedOn()->name +
            ": drag a straight line over the clay. Ctrl: opposite, Shift: smooth";
  else if (const engine::Piece* other = context.now.document->piece(context.state.otherPiece))
    doing = other->name + ": click to work on it, Ctrl+click to select it too; a drag turns the view";
  else if (tool) {
    const bool several = context.now.document->pieces.size() > 1;
    doing = std::string(tool->name) + " on " + context.now.document->workedOn()->name;
    doing += context.now.inStroke ? "…"
             : several            ? ": drag on it. Click another piece to work on that. Ctrl: opposite, Shift: smooth"
                                  : ": drag on the clay. Ctrl: opposite, Shift: smooth, [ and ]: size";
  }
  ImGui::SetCursorPos({10, y});
  kit::elided(doing, std::max(20.0f, x - 20), colour);
  ImGui::PopFont();
  kit::end();
}

}  // namespace argil::studio
