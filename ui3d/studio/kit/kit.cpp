#include "ui3d/studio/kit/kit.h"

#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"

namespace argil::studio::kit {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoNav;

const char* first(std::string_view s) {
  return s.data();
}
const char* last(std::string_view s) {
  return s.data() + s.size();
}
ImVec2 size(std::string_view s) {
  return s.empty() ? ImVec2(0, 0) : ImGui::CalcTextSize(first(s), last(s));
}

// The ground of something that can be pressed, from how it is pressed.
ImU32 ground(bool hovered, bool held) {
  return held ? colours().fieldPress : hovered ? colours().fieldHover : colours().field;
}

bool escapeTaken = false;               // In this frame, by something that stood over the dialogs.
ImGuiID menuOnTop = 0;                  // The window of the menu that was drawn last.
int menuStep = 0;                       // By which the open menu of the bar changes in this frame.
bool menuMarks = false;                 // The first row of the menu on top is to be marked.
std::set<ImGuiID> rowsWithMenus;        // Rows that open a menu of their own.
const ImGuiWindow* enterFor = nullptr;  // The dialog whose main button Enter presses in this frame.

bool keyPressed(ImGuiKey key) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), false);
}

// Enter presses the main button of the dialog that is being drawn. Not a button that looks like one: a choice that is
// lit would be undone.
bool entered() {
  if (!enterFor || ImGui::GetCurrentWindow()->RootWindow != enterFor ||
      (GImGui->CurrentItemFlags & ImGuiItemFlags_Disabled))
    return false;
  enterFor = nullptr;
  return true;
}

void outline(const ImVec2& a, const ImVec2& b) {
  ImGui::GetWindowDrawList()->AddRect(a, b, colours().line, kRound, 0, 1);
}

}  // namespace

void beginFrame() {
  ImGui::GetStyle().Colors[ImGuiCol_ModalWindowDimBg].w = kDimming;
  escapeTaken = false;
  enterFor = nullptr;
}
void takeEscape() {
  escapeTaken = true;
}
bool escapeIsTaken() {
  return escapeTaken;
}

void steerMenus() {
  ImGuiContext& g = *GImGui;
  ImGuiIO& io = g.IO;
  menuStep = 0;
  const ImGuiWindow* top = g.OpenPopupStack.empty() ? nullptr : g.OpenPopupStack.back().Window;
  // Panels and dialogs know no steps by keys: they are on for menus alone. Those of a gamepad, as ImGui's own keys lack
  // Enter.
  io.BackendFlags |= ImGuiBackendFlags_HasGamepad;
  if (!top || !top->Active || (top->ID != menuOnTop && !(top->Flags & ImGuiWindowFlags_ChildMenu))) {
    io.ConfigFlags &= ~ImGuiConfigFlags_NavEnableGamepad;
    if (g.OpenPopupStack.empty()) menuMarks = false;
    return;
  }
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableGamepad;
  const auto down = [&](ImGuiKey key) { return io.KeysDown[io.KeyMap[key]]; };
  const auto pressed = [&](ImGuiKey key) { return down(key) && io.KeysDownDuration[io.KeyMap[key]] < 0; };
  const bool across =
      (top->Flags & ImGuiWindowFlags_ChildMenu) && (pressed(ImGuiKey_LeftArrow) || pressed(ImGuiKey_RightArrow));
  const bool marked = !g.NavDisableHighlight && g.NavId != 0;
  // The first arrow after a menu was opened by the mouse marks its first row.
  const bool arrow = pressed(ImGuiKey_DownArrow) || pressed(ImGuiKey_UpArrow);
  static bool swallows = false;  // The arrows, until they come up.
  if (arrow && !marked && g.HoveredIdPreviousFrame != g.NavId) swallows = menuMarks = true;
  if (menuMarks && g.NavWindow == top && g.NavId != 0) {
    g.NavDisableHighlight = false;
    g.NavDisableMouseHover = true;
    menuMarks = false;
  }
  // Right goes into the marked row's own menu, else to the next one of the bar; Left out of a menu in a menu, else
  // back.
  const bool inner = g.OpenPopupStack.Size > 1, opens = marked && rowsWithMenus.contains(g.NavId);
  if (across && pressed(ImGuiKey_RightArrow) && !opens) menuStep = 1;
  if (across && pressed(ImGuiKey_LeftArrow) && !inner) menuStep = -1;
  swallows |= menuStep != 0;
  swallows &=
      down(ImGuiKey_DownArrow) || down(ImGuiKey_UpArrow) || down(ImGuiKey_LeftArrow) || down(ImGuiKey_RightArrow);
  if (swallows) return;
  const auto send = [&](ImGuiNavInput input, bool on) { io.NavInputs[input] = on ? 1.0f : 0.0f; };
  send(ImGuiNavInput_DpadUp, down(ImGuiKey_UpArrow));
  send(ImGuiNavInput_DpadDown, down(ImGuiKey_DownArrow));
  send(ImGuiNavInput_DpadLeft, inner && down(ImGuiKey_LeftArrow));
  send(ImGuiNavInput_DpadRight, opens && down(ImGuiKey_RightArrow));
  send(ImGuiNavInput_Activate, down(ImGuiKey_Enter) || down(ImGuiKey_Space));
}

int menuStepAcross() {
  return menuStep;
}

void openMenu(const char* name) {
  if (!GImGui->OpenPopupStack.empty()) ImGui::ClosePopupToLevel(0, false);
  ImGui::OpenPopup(name);
  menuMarks = true;
}

bool beginMenuInMenu(const char* name) {
  rowsWithMenus.insert(ImGui::GetID(name));
  return ImGui::BeginMenu(name);
}

void beginMenuRows() {
  sharpen(*ImGui::GetWindowDrawList());
  ImGuiWindow* window = ImGui::GetCurrentWindow();
  menuOnTop = window->ID;
  if (GImGui->BeginPopupStack.Size == 1) rowsWithMenus.clear();  // Rows of all menus of the bar have the same names.
  if (menuMarks && GImGui->NavWindow == window && GImGui->NavId == 0) ImGui::NavInitWindow(window, true);
}

int arrowStep() {
  const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
  return (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0);
}

void sharpen(ImDrawList& list) {
  list._FringeScale = 1 / pixelScale();
}

bool begin(const char* name, const Rect& rect, ImU32 colour, ImVec2 padding, ImGuiWindowFlags flags) {
  ImGui::SetNextWindowPos({rect.left, rect.top});
  ImGui::SetNextWindowSize({std::max(1.0f, rect.width()), std::max(1.0f, rect.height())});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, padding);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colour);
  const bool open = ImGui::Begin(name, nullptr, kFixed | ImGuiWindowFlags_NoBringToFrontOnFocus | flags);
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  sharpen(*ImGui::GetWindowDrawList());
  return open;
}

bool beginCard(const char* name, ImVec2 at, ImVec2 pivot, float width, float mostHeight) {
  ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
  ImGui::SetNextWindowSizeConstraints({width, 1}, {width, mostHeight > 0 ? mostHeight : 100000});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 8);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  const bool open =
      ImGui::Begin(name, nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PopStyleVar(2);
  sharpen(*ImGui::GetWindowDrawList());
  return open;
}

bool beginDialog(const char* name, const char* title, float width, float height, bool* open, float right) {
  if (!*open && !ImGui::IsPopupOpen(name)) return false;
  if (*open && !ImGui::IsPopupOpen(name)) ImGui::OpenPopup(name);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float wide = std::min(width, display.x - 16), most = display.y - 16;
  const float top = std::min(0.12f * display.y, display.y - 8 - std::min(height, most));  // Of one without a title.
  ImGui::SetNextWindowPos({std::floor(right > 0 ? right : display.x / 2), std::floor(title ? display.y / 2 : top)},
                          ImGuiCond_Always, {right > 0 ? 1.0f : 0.5f, title ? 0.5f : 0.0f});
  if (right > 0) ImGui::GetStyle().Colors[ImGuiCol_ModalWindowDimBg].w = 0;
  if (height > 0)
    ImGui::SetNextWindowSize({wide, std::min(height, most)});
  else
    ImGui::SetNextWindowSizeConstraints({wide, 1}, {wide, most});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 8);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {18, 16});
  const bool drawn =
      ImGui::BeginPopupModal(name, nullptr, kFixed | (height > 0 ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
  ImGui::PopStyleVar(2);
  if (!drawn) return false;
  if (!*open) {  // Closed by somebody else.
    ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    return false;
  }
  sharpen(*ImGui::GetWindowDrawList());
  const ImGuiWindow* window = ImGui::GetCurrentWindow();
  const bool onTop = GImGui->OpenPopupStack.Size == GImGui->BeginPopupStack.Size;
  const bool outside = !title && ImGui::IsMouseClicked(0) && !window->Rect().Contains(ImGui::GetIO().MousePos) &&
                       !ImGui::IsWindowAppearing();
  if (onTop && (outside || (keyPressed(ImGuiKey_Escape) && !escapeTaken && !numberIsTyped()))) *open = false;
  // A text that is being typed has its own use for Enter; so has the key press that brought the dialog.
  const bool typing = GImGui->ActiveId != 0 && GImGui->ActiveId == GImGui->InputTextState.ID;
  if (onTop && !typing && !ImGui::IsWindowAppearing() &&
      (keyPressed(ImGuiKey_Enter) || keyPressed(ImGuiKey_KeyPadEnter)))
    enterFor = window;
  if (title) {
    ImGui::PushFont(fonts().strong);
    ImGui::TextUnformatted(title);
    ImGui::PopFont();
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - 22);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 3);
    if (iconButton("close", "close", 22, Lit::off, "Close", "Escape")) *open = false;
    gap(4);
  }
  return true;
}

void end() {
  ImGui::End();
}
void endCard() {
  ImGui::End();
}
void endDialog(bool open) {
  if (!open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void heading(std::string_view words) {
  if (ImGui::GetCursorPosY() > ImGui::GetCursorStartPos().y + 1) {
    gap(5);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddLine(at, {at.x + ImGui::GetContentRegionAvail().x, at.y}, colours().line, 1);
    gap(5);
  }
  ImGui::PushFont(fonts().strong);
  elided(words, ImGui::GetContentRegionAvail().x, colours().text);
  ImGui::PopFont();
}

bool fold(std::string_view name, bool& open, std::string_view help) {
  gap(2);
  ImGui::PushID(first(name), last(name));
  if (ImGui::InvisibleButton("fold", {ImGui::GetContentRegionAvail().x, kRow})) open = !open;
  ImGui::PopID();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  if (ImGui::IsItemHovered()) list.AddRectFilled(a, b, c.fieldHover, kRound);
  const float x = a.x + 8, y = std::floor((a.y + b.y) / 2);
  const ImU32 ink = open ? c.text : c.dim;
  if (open)
    list.AddTriangleFilled({x - 4, y - 2.5f}, {x + 4, y - 2.5f}, {x, y + 3}, ink);
  else
    list.AddTriangleFilled({x - 2.5f, y - 4}, {x + 3, y}, {x - 2.5f, y + 4}, ink);
  list.AddText({a.x + 20, std::floor(y - ImGui::GetTextLineHeight() / 2)}, ink, first(name), last(name));
  tooltip(help);
  return open;
}

void gap(float height) {
  ImGui::Dummy({1, height - ImGui::GetStyle().ItemSpacing.y > 0 ? height - ImGui::GetStyle().ItemSpacing.y : 0});
}

void text(std::string_view words) {
  ImGui::TextUnformatted(first(words), last(words));
}

void dimText(std::string_view words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colours().dim);
  ImGui::TextUnformatted(first(words), last(words));
  ImGui::PopStyleColor();
}

void wrapped(std::string_view words, ImU32 colour) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(first(words), last(words));
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

void elided(std::string_view words, float width, ImU32 colour) {
  const ImVec2 at = ImGui::GetCursorScreenPos(), needed = size(words);
  ImGui::Dummy({std::min(width, needed.x), ImGui::GetTextLineHeight()});
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  const float right = at.x + width;
  ImGui::RenderTextEllipsis(ImGui::GetWindowDrawList(), at, {right, at.y + needed.y + 3}, right, right, first(words),
                            last(words), &needed);
  ImGui::PopStyleColor();
  if (needed.x > width) tooltip(words);
}

std::string sentence(std::string_view words) {
  std::string whole(words);
  if (!whole.empty()) whole[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(whole[0])));
  if (!whole.empty() && std::string_view(".!?:").find(whole.back()) == std::string_view::npos) whole += '.';
  return whole;
}

void frameLine(ImVec2 from, ImVec2 to) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRect(ImGui::GetWindowPos(), {ImGui::GetWindowPos().x + ImGui::GetWindowWidth(),
                                            ImGui::GetWindowPos().y + ImGui::GetWindowHeight()});
  list.AddLine(from, to, colours().line, 1);
  list.PopClipRect();
}

void tooltip(std::string_view words, std::string_view shortcut) {
  if (words.empty() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) || ImGui::IsMouseDown(0)) return;
  if (GImGui->HoveredIdTimer < 0.35f && GImGui->HoveredId != 0) return;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {9, 7});
  ImGui::BeginTooltip();
  sharpen(*ImGui::GetWindowDrawList());
  ImGui::PushTextWrapPos(280);
  ImGui::TextUnformatted(first(words), last(words));
  if (!shortcut.empty()) dimText("Key: " + std::string(shortcut));
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

bool iconButton(const char* id, std::string_view icon, float edge, Lit lit, std::string_view tip,
                std::string_view shortcut, std::string_view letters, bool quiet) {
  const bool pressed = ImGui::InvisibleButton(id, {edge, edge});
  const bool hovered = ImGui::IsItemHovered(), held = ImGui::IsItemActive();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  const float alpha = ImGui::GetStyle().Alpha;
  if (lit != Lit::off)
    list.AddRectFilled(a, b, ImGui::GetColorU32(ImGui::ColorConvertU32ToFloat4(lit == Lit::full ? c.accent : c.soft)),
                       kRound);
  else if (hovered || held || !quiet)
    list.AddRectFilled(a, b, ImGui::GetColorU32(ImGui::ColorConvertU32ToFloat4(ground(hovered, held))), kRound);
  ImVec4 ink = ImGui::ColorConvertU32ToFloat4(lit == Lit::full                        ? c.onAccent
                                              : hovered || !quiet || lit == Lit::soft ? c.text
                                                                                      : c.dim);
  ink.w *= alpha;
  const ImU32 colour = ImGui::ColorConvertFloat4ToU32(ink);
  const ImVec2 centre{(a.x + b.x) / 2, (a.y + b.y) / 2};
  if (!drawIcon(list, icon, centre, std::round(std::min(edge * 0.62f, 22.0f)), colour)) {
    const std::string_view shown = (letters.empty() ? icon : letters).substr(0, 2);
    const ImVec2 needed = size(shown);
    list.AddText({std::floor(centre.x - needed.x / 2), std::floor(centre.y - needed.y / 2)}, colour, first(shown),
                 last(shown));
  }
  tooltip(tip, shortcut);
  return pressed;
}

float buttonWidth(std::string_view words, std::string_view icon) {
  return std::ceil(size(words).x) + 24 + (icon.empty() ? 0 : 22);
}

bool button(std::string_view words, Weight weight, float width, std::string_view icon) {
  const float needed = buttonWidth(words, icon);
  if (width < 0) width = ImGui::GetContentRegionAvail().x;
  if (width == 0) width = needed;
  ImGui::PushID(first(words), last(words));
  const bool pressed = ImGui::InvisibleButton("button", {width, kRow});
  ImGui::PopID();
  const bool hovered = ImGui::IsItemHovered(), held = ImGui::IsItemActive();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  const auto faded = [](ImU32 colour) { return ImGui::GetColorU32(ImGui::ColorConvertU32ToFloat4(colour)); };
  const ImU32 fill = weight == Weight::chief ? c.accent : weight == Weight::danger ? c.stop : ground(hovered, held);
  const ImU32 ink = faded(weight == Weight::chief ? c.onAccent : weight == Weight::danger ? c.onStop : c.text);
  list.AddRectFilled(a, b, faded(fill), kRound);
  if (weight == Weight::plain)
    outline(a, b);
  else if (hovered)
    list.AddRect(a, b, faded(c.text), kRound, 0, 1);
  const float content = needed - 24;
  float x = std::floor((a.x + b.x - content) / 2);
  if (!icon.empty()) {
    drawIcon(list, icon, {x + 8, (a.y + b.y) / 2}, 17, ink);
    x += 22;
  }
  if (needed > width + 0.5f) {
    const float edge = b.x - 6;
    const ImVec2 whole = size(words);
    x = a.x + 6 + (icon.empty() ? 0 : 22);
    ImGui::PushStyleColor(ImGuiCol_Text, ink);
    ImGui::RenderTextEllipsis(&list, {x, std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2)}, {edge, b.y}, edge,
                              edge, first(words), last(words), &whole);
    ImGui::PopStyleColor();
    if (whole.x > edge - x) tooltip(words);
  } else {
    list.AddText({x, std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2)}, ink, first(words), last(words));
  }
  return pressed;
}

bool mainButton(std::string_view words, float width, Weight weight) {
  const bool pressed = button(words, weight, width);
  return entered() || pressed;
}

bool toggle(std::string_view name, bool& on, std::string_view help) {
  ImGui::PushID(first(name), last(name));
  const float width = ImGui::GetContentRegionAvail().x;
  const bool pressed = ImGui::InvisibleButton("switch", {width, kRow - 2});
  ImGui::PopID();
  if (pressed) on = !on;
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  const auto faded = [](ImU32 colour) { return ImGui::GetColorU32(ImGui::ColorConvertU32ToFloat4(colour)); };
  const float middle = std::floor((a.y + b.y) / 2);
  list.AddText({a.x, std::floor(middle - ImGui::GetTextLineHeight() / 2)}, faded(c.text), first(name), last(name));
  const float height = 16, wide = 30;
  const ImVec2 p{b.x - wide, middle - height / 2}, q{b.x, middle + height / 2};
  list.AddRectFilled(p, q, faded(on ? c.accent : ground(ImGui::IsItemHovered(), false)), height / 2);
  if (!on) list.AddRect(p, q, faded(c.dim), height / 2, 0, 1);
  list.AddCircleFilled({on ? q.x - height / 2 : p.x + height / 2, middle}, 5, faded(on ? c.onAccent : c.dim));
  tooltip(help);
  return pressed;
}

bool segmented(const char* id, std::span<const std::string_view> names, int& chosen) {
  ImGui::PushID(id);
  const float whole = ImGui::GetContentRegionAvail().x, each = std::floor(whole / float(names.size()));
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const Colours& c = colours();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(origin, {origin.x + whole, origin.y + kRow}, c.field, kRound);
  bool changed = false;
  for (size_t i = 0; i < names.size(); ++i) {
    if (i > 0) ImGui::SameLine(0, 0);
    const float width = i + 1 == names.size() ? whole - each * float(i) : each;
    ImGui::PushID(int(i));
    if (ImGui::InvisibleButton("segment", {width, kRow}) && chosen != int(i)) {
      chosen = int(i);
      changed = true;
    }
    ImGui::PopID();
    const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
    const bool on = chosen == int(i);
    if (on || ImGui::IsItemHovered())
      list.AddRectFilled({a.x + 2, a.y + 2}, {b.x - 2, b.y - 2}, on ? c.accent : c.fieldHover, kRound - 1);
    const ImVec2 needed = size(names[i]);
    if (needed.x > b.x - a.x - 4) {
      ImGui::PushStyleColor(ImGuiCol_Text, on ? c.onAccent : c.text);
      ImGui::RenderTextEllipsis(&list, {a.x + 4, std::floor((a.y + b.y - needed.y) / 2)}, {b.x - 2, b.y}, b.x - 2,
                                b.x - 2, first(names[i]), last(names[i]), &needed);
      ImGui::PopStyleColor();
      tooltip(names[i]);
    } else {
      list.AddText({std::floor((a.x + b.x - needed.x) / 2), std::floor((a.y + b.y - needed.y) / 2)},
                   on ? c.onAccent : c.text, first(names[i]), last(names[i]));
    }
  }
  outline(origin, {origin.x + whole, origin.y + kRow});
  ImGui::PopID();
  return changed;
}

Change colour(std::string_view name, double& value, std::string_view help) {
  ImGui::PushID(first(name), last(name));
  const float width = ImGui::GetContentRegionAvail().x, left = std::floor(width * 0.42f);
  ImGui::AlignTextToFramePadding();
  text(name);
  tooltip(help);
  ImGui::SameLine(left);
  const auto rgb = static_cast<uint32_t>(value);
  float parts[3] = {float(rgb >> 16 & 255) / 255, float(rgb >> 8 & 255) / 255, float(rgb & 255) / 255};
  Change change;
  ImGui::SetNextItemWidth(width - left);
  if (ImGui::ColorEdit3("##colour", parts,
                        ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel | ImGuiColorEditFlags_NoTooltip)) {
    const auto byte = [](float part) { return static_cast<uint32_t>(std::lround(std::clamp(part, 0.0f, 1.0f) * 255)); };
    value = double(byte(parts[0]) << 16 | byte(parts[1]) << 8 | byte(parts[2]));
    change.changed = true;
  }
  change.ended = ImGui::IsItemDeactivatedAfterEdit();
  ImGui::PopID();
  return change;
}

bool choice(std::string_view name, std::span<const std::string_view> names, int& chosen, std::string_view help) {
  ImGui::PushID(first(name), last(name));
  const float width = ImGui::GetContentRegionAvail().x, left = std::floor(width * 0.42f);
  ImGui::AlignTextToFramePadding();
  if (!name.empty()) {
    text(name);
    tooltip(help);
    ImGui::SameLine(left);
    ImGui::SetNextItemWidth(width - left + ImGui::GetCursorStartPos().x);
  } else {
    ImGui::SetNextItemWidth(width);
  }
  bool changed = false;
  const std::string shown(chosen >= 0 && size_t(chosen) < names.size() ? names[size_t(chosen)] : std::string_view());
  ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, 1);
  const bool open = ImGui::BeginCombo("##choice", shown.c_str(), ImGuiComboFlags_HeightLarge);
  ImGui::PopStyleVar();
  if (open) {
    // One list is open at a time. Arrows and Enter choose as the mouse does.
    static int marked = -1;
    if (ImGui::IsWindowAppearing()) marked = chosen;
    const int step = arrowStep();
    marked = std::clamp(marked + step, names.empty() ? -1 : 0, int(names.size()) - 1);
    const bool taken = marked >= 0 && (keyPressed(ImGuiKey_Enter) || keyPressed(ImGuiKey_KeyPadEnter));
    for (size_t i = 0; i < names.size(); ++i) {
      const bool pressed = ImGui::Selectable(std::string(names[i]).c_str(), marked == int(i));
      if (ImGui::IsItemHovered() && (ImGui::GetIO().MouseDelta.x != 0 || ImGui::GetIO().MouseDelta.y != 0))
        marked = int(i);
      if (step != 0 && marked == int(i)) ImGui::SetScrollHereY();
      if ((pressed || (taken && marked == int(i))) && chosen != int(i)) {
        chosen = int(i);
        changed = true;
      }
    }
    if (taken) ImGui::CloseCurrentPopup();
    ImGui::EndCombo();
  }
  ImGui::PopID();
  return changed;
}

void fact(std::string_view name, std::string_view value, ImU32 colour) {
  const float width = ImGui::GetContentRegionAvail().x, needed = size(value).x, named = size(name).x;
  const float x = ImGui::GetCursorPosX();
  dimText(name);
  ImGui::SameLine(0, 0);
  const float room = std::max(20.0f, width - named - 10);
  ImGui::SetCursorPosX(x + width - std::min(needed, room));
  elided(value, room, colour ? colour : colours().text);
}

bool textField(const char* id, std::string& words, float width, std::string_view hint, bool focus) {
  ImGui::SetNextItemWidth(width > 0 ? width : ImGui::GetContentRegionAvail().x);
  if (focus) ImGui::SetKeyboardFocusHere();
  ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, 1);
  const bool entered = ImGui::InputTextWithHint(
      id, std::string(hint).c_str(), &words, ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopStyleVar();
  return entered || ImGui::IsItemDeactivatedAfterEdit();
}

void bar(double part, float width, float height) {
  ImGui::Dummy({width, height});
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(a, b, colours().line, height / 2);
  const float filled = float(std::clamp(part, 0.0, 1.0)) * (b.x - a.x);
  if (filled > 1) list.AddRectFilled(a, {a.x + std::max(height, filled), b.y}, colours().accent, height / 2);
}

}  // namespace argil::studio::kit
