#include "ui3d/studio/panels/panels.h"

#include <imgui_internal.h>

#include <algorithm>
#include <utility>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

using DrawPanel = void (*)(Context&, Memory&);

// What draws a panel of a dock where one is seen at a time.
DrawPanel drawerOf(std::string_view id) {
  for (const auto& [name, draw] : {std::pair<std::string_view, DrawPanel>{"things", thingsPanel},
                                   {"history", historyPanel},
                                   {"view", viewPanel},
                                   {"touch", touchPanel},
                                   {"quality", qualityPanel},
                                   {"facts", factsPanel},
                                   {"print", printPanel},
                                   {"messages", messagesPanel}}) {
    if (name == id) return draw;
  }
  return nullptr;
}

// The title of a dock's panel, with tabs where the dock has two to choose from.
void titles(Context& context, const Layout& layout, Dock dock) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  const PanelRow* closed = nullptr;
  for (const PanelRow& row : panelTable()) {
    if (row.dock != dock) continue;
    const bool on = isSeen(layout, context.state, row);
    if (!on && dock != Dock::upper) continue;
    ImGui::PushFont(fonts().strong);
    const ImVec2 size = ImGui::CalcTextSize(row.name.data(), row.name.data() + row.name.size());
    ImGui::PushID(row.id.data());
    const bool pressed = ImGui::InvisibleButton("title", {size.x, 24});
    ImGui::PopID();
    const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
    list.AddText({a.x, a.y + 2}, on || ImGui::IsItemHovered() ? c.text : c.dim, row.name.data(),
                 row.name.data() + row.name.size());
    ImGui::PopFont();
    if (on && dock == Dock::upper) list.AddRectFilled({a.x, b.y - 2}, {b.x, b.y}, c.accent);
    if (pressed && !on) turnPanel(layout, context.state, row);
    ImGui::SameLine(0, 16);
    if (on) closed = &row;
  }
  ImGui::SameLine(ImGui::GetWindowWidth() - kPad - 22);
  if (kit::iconButton("hide", "close", 22, kit::Lit::off, "Hide this panel; the icons on the right bring it back") &&
      closed)
    turnPanel(layout, context.state, *closed);
}

void dock(Context& context, Memory& memory, const char* name, Dock which, const kit::Rect& rect) {
  if (rect.empty()) return;
  kit::begin(name, rect, colours().panel, {kPad, 8}, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  kit::frameLine({rect.left + 0.5f, rect.top}, {rect.left + 0.5f, rect.bottom});
  if (rect.top > memory.layout.bar.bottom + 1)
    kit::frameLine({rect.left, rect.top + 0.5f}, {rect.right, rect.top + 0.5f});
  titles(context, memory.layout, which);
  for (const PanelRow& row : panelTable()) {
    if (row.dock != which || !isSeen(memory.layout, context.state, row)) continue;
    ImGui::BeginChild(row.id.data(), {0, 0}, false, which == Dock::upper ? ImGuiWindowFlags_NoScrollbar : 0);
    kit::sharpen(*ImGui::GetWindowDrawList());
    drawerOf(row.id)(context, memory);
    ImGui::EndChild();
    break;
  }
  kit::end();
}

void settings(Context& context, Memory& memory) {
  const kit::Rect& rect = memory.layout.settings;
  if (rect.empty()) return;
  kit::begin("Settings", rect, colours().panel, {kPad, 10});
  kit::frameLine({rect.right - 0.5f, rect.top}, {rect.right - 0.5f, rect.bottom});
  settingsPanel(context, memory);
  kit::end();
}

// Escape closes what is on top: a menu or a list, else a dialog (which does it itself), else the panel over the clay.
// So does a click beside that panel.
void fold(StudioState& state) {
  const ImGuiContext& g = *GImGui;
  const bool typing = g.ActiveId != 0 && g.ActiveId == g.InputTextState.ID;
  const int popups = g.OpenPopupStack.Size;
  const bool escape = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false) && !typing;
  if (popups > 0) {
    // Menus as a whole: a submenu would open again under the hand.
    int level = popups;
    while (level > 0 && !(g.OpenPopupStack[level - 1].Window &&
                          (g.OpenPopupStack[level - 1].Window->Flags & ImGuiWindowFlags_Modal)))
      --level;
    if (escape && level < popups) {
      ImGui::ClosePopupToLevel(level, true);
      kit::takeEscape();
    }
    return;
  }
  const bool beside = (ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1) || ImGui::IsMouseClicked(2)) &&
                      !ImGui::GetIO().WantCaptureMouse;
  if ((escape || beside) && !state.over.empty()) {
    state.over.clear();
    if (escape) kit::takeEscape();
  }
}

// When the hand ended its stroke, and how much of it was to be worked on then.
void followStroke(Context& context, Memory& memory) {
  const bool cuts = (memory.touch.latest.flags & haptics::kCutting) != 0;
  if (std::exchange(memory.handCuts, cuts) && !cuts) {
    memory.releasedS = context.timeS;
    memory.strokeFromS = context.bench.strokeWork().leftS;
  }
  memory.moves |= !cuts && context.bench.strokeWork().on;
}

void hear(Context& context, Memory& memory) {
  constexpr size_t kMost = 300;
  for (engine::Message& message : context.bench.takeMessages()) {
    memory.said.push_back({std::move(message), context.timeS, false});
  }
  while (memory.said.size() > kMost) memory.said.pop_front();
  memory.touch = context.bench.touch(isSeen(memory.layout, context.state, *findPanel("touch")));
  // What was just made is what the hand works on next.
  if (std::exchange(memory.madeSeen, context.now.madeCount) < context.now.madeCount &&
      context.now.document->thing(context.now.made))
    context.state.selected = context.now.made;
  followStroke(context, memory);
  memory.frameMs.push_back(float(context.state.figures.frameMs));
  if (memory.frameMs.size() > 240) memory.frameMs.erase(memory.frameMs.begin(), memory.frameMs.begin() + 40);
}

}  // namespace

Layout layoutOf(const Context& context) {
  if (context.state.stereo.splits()) {  // A panel would cover one eye's picture alone.
    Layout bare;
    bare.free = bare.clear = {0, 0, context.width, context.height};
    return bare;
  }
  return layOut(context.width, context.height, context.state.shown, toolGroups(), context.state.over,
                context.state.foldPanels ? kClayPart : kLeastClayPart);
}

struct Panels::State : Memory {};

Panels::Panels() : state_(std::make_unique<State>()) {}
Panels::~Panels() = default;

void Panels::draw(Context& context) {
  Memory& memory = *state_;
  // A tooltip waits for a hand at rest; a cursor blinks.
  memory.moves = isSeen(memory.layout, context.state, *findPanel("touch")) || ImGui::GetIO().WantTextInput ||
                 ImGui::IsAnyItemHovered() || ImGui::IsAnyItemActive();
  hear(context, memory);
  followPrint(context, memory);
  serveWishes(context, memory);
  kit::beginFrame();
  fold(context.state);
  memory.layout = layoutOf(context);
  if (const PanelRow* over = findPanel(context.state.over); over && !memory.layout.folded(over->dock))
    context.state.over.clear();
  ImGui::PushFont(fonts().body);
  const bool bare = memory.layout.menu.empty();
  if (!bare) {
    drawMenu(context, memory);
    drawBar(context, memory);
  }
  drawTools(context, memory);
  settings(context, memory);
  dock(context, memory, "Upper", Dock::upper, memory.layout.upper);
  dock(context, memory, "Lower", Dock::lower, memory.layout.lower);
  if (!bare) {
    drawRail(context, memory);
    drawStatus(context, memory);
  }
  drawFirstStart(context, memory);
  drawNotices(context, memory);
  drawFiles(context, memory);
  drawRecent(context, memory);
  drawAsked(context, memory);
  drawSave(context, memory);
  drawRecover(context, memory);
  drawExport(context, memory);
  drawNewClay(context, memory);
  drawOperation(context, memory);
  drawShortcuts(context, memory);
  drawPreferences(context, memory);
  drawPlugins(context, memory);
  drawPalette(context, memory);
  ImGui::PopFont();
}

void Panels::dropped(Context& context, const std::string& path) {
  const FileKind* kind = kindOf(path);
  if (!kind) {
    context.bench.tell(engine::Message::Level::warning,
                       path + ": files of this kind cannot be opened; meshes, .argil and .json can.");
  } else if (kind->imports) {
    state_->toBeAsked.emplace_back(path);
  } else {
    beginDocument(context, *state_, path);
  }
}

std::vector<std::pair<uint32_t, const render::Image*>> Panels::takePictures() {
  return studio::takePictures(state_->start);
}
void Panels::forgetPictures() {
  state_->start.sent = false;
}

bool Panels::letsThrough(const Context& context, const Shortcut& shortcut) {
  const Action* action = actionOf(shortcut, context.state);
  if (!action || GImGui->OpenPopupStack.empty()) return false;
  // Rows are chosen by these.
  if (shortcut.modifiers == 0 && (shortcut.key == Key(' ') || (shortcut.key >= Key::right && shortcut.key <= Key::up)))
    return false;
  int dialogs = 0;
  for (const ImGuiPopupData& popup : GImGui->OpenPopupStack)
    dialogs += popup.Window && (popup.Window->Flags & ImGuiWindowFlags_Modal) ? 1 : 0;
  if (dialogs > 0) {
    const PanelRow* panel = action->id.starts_with("panel.") ? findPanel(action->argument) : nullptr;
    return action->id == "window.fullScreen" ||
           (panel && panel->dock == Dock::middle && context.state.shown.*panel->shown);
  }
  ImGui::ClosePopupToLevel(0, true);
  return true;
}

void Panels::turnMenus() {
  if (GImGui->OpenPopupStack.empty())
    state_->menuWished = !state_->layout.menu.empty();
  else if (!ImGui::GetTopMostPopupModal())
    ImGui::ClosePopupToLevel(0, true);
}

bool Panels::moves() const {
  return state_->moves;
}

std::array<float, 4> Panels::free() const {
  const kit::Rect& free = state_->layout.free;
  return {free.left, free.top, free.right, free.bottom};
}

}  // namespace argil::studio
