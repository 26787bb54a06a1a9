#include <imgui.h>
#include <imgui_stdlib.h>

#include <cmath>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using engine::Document;
using engine::Id;
using engine::Thing;

constexpr float kHeight = 30, kSmallButton = 24;
constexpr const char* kPayload = "thing";

void change(Context& context, const Thing& thing, const char* verb, void (*what)(Thing&)) {
  context.bench.edit(verb + (" " + thing.name), [id = thing.id, what](Document& d) {
    if (Thing* t = d.thing(id)) what(*t);
  });
}

void rename(Context& context, Memory& memory, const Thing& thing, float width) {
  ImGui::SetNextItemWidth(width);
  if (!memory.renameBegun) ImGui::SetKeyboardFocusHere();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {6, 6});
  const bool entered = ImGui::InputText("##name", &memory.renameText,
                                        ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopStyleVar();
  const bool left = memory.renameBegun && !ImGui::IsItemActive();
  if (ImGui::IsItemActive()) memory.renameBegun = true;
  if (!entered && !left) return;
  memory.renaming = 0;
  if (!memory.renameText.empty() && memory.renameText != thing.name) {
    context.bench.edit("Rename " + thing.name, [id = thing.id, name = memory.renameText](Document& d) {
      if (Thing* t = d.thing(id)) t->name = name;
    });
  }
}

void menu(Context& context, Memory& memory, const Thing& thing) {
  if (ImGui::MenuItem("Rename")) {
    memory.renaming = thing.id;
    memory.renameBegun = false;
    memory.renameText = thing.name;
  }
  if (!context.state.isSelected(thing.id)) context.state.selected = thing.id;
  for (const char* id : {"view.focus", "edit.hide", "edit.lock", "edit.moveUp", "edit.moveDown", "edit.delete"}) {
    const Action* action = findAction(id);
    if (action && ImGui::MenuItem(action->name.c_str(), shortcutOf(*action, context.state).c_str()))
      runAction(context, id);
  }
}

// One row; `place` is its place in its list.
void row(Context& context, Memory& memory, const Thing& thing, const float* colour, int place) {
  const Document& document = *context.now.document;
  ImGui::PushID(int(thing.id));
  const float width = ImGui::GetContentRegionAvail().x, main = width - 2 * kSmallButton;
  const ImVec2 origin = ImGui::GetCursorScreenPos(), mouse = ImGui::GetIO().MousePos;
  const bool inRow = ImGui::IsWindowHovered() && mouse.y >= origin.y && mouse.y < origin.y + kHeight;
  if (memory.renaming == thing.id) {
    rename(context, memory, thing, main);
  } else {
    const bool chosen = context.state.isSelected(thing.id);
    const bool pressed = ImGui::InvisibleButton("row", {main, kHeight});
    if (pressed && ImGui::GetIO().KeyCtrl) {
      context.state.toggleSelected(thing.id);
    } else if (pressed) {
      context.state.selected = thing.id;
      if (document.piece(thing.id) && document.active != thing.id) {
        context.bench.edit(
            "Work on " + thing.name,
            [id = thing.id](Document& d) {
              if (d.piece(id)) d.active = id;
            },
            "active");
      }
    }
    const bool hovered = ImGui::IsItemHovered();
    const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
    if (hovered && ImGui::IsMouseDoubleClicked(0)) {
      memory.renaming = thing.id;
      memory.renameBegun = false;
      memory.renameText = thing.name;
    }
    if (ImGui::BeginPopupContextItem("menu")) {
      kit::beginMenuRows();
      ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {14, 8});
      menu(context, memory, thing);
      ImGui::PopStyleVar();
      ImGui::EndPopup();
    }
    const std::array<int, 2> dragged{int(thing.id), place};
    if (ImGui::BeginDragDropSource(ImGuiDragDropFlags_SourceNoPreviewTooltip)) {
      ImGui::SetDragDropPayload(kPayload, dragged.data(), sizeof dragged);
      ImGui::EndDragDropSource();
    }
    if (ImGui::BeginDragDropTarget()) {
      if (const ImGuiPayload* payload = ImGui::AcceptDragDropPayload(kPayload)) {
        const auto [id, from] = *static_cast<const std::array<int, 2>*>(payload->Data);
        const bool sameList = (document.piece(Id(id)) != nullptr) == (document.piece(thing.id) != nullptr) &&
                              (document.part(Id(id)) != nullptr) == (document.part(thing.id) != nullptr);
        if (const int by = place - from; sameList && by != 0) {
          context.bench.edit("Move " + document.thing(Id(id))->name + " in the list", [id = Id(id), by](Document& d) {
            for (int i = 0; i < std::abs(by); ++i) d.reorder(id, by < 0 ? -1 : 1);
          });
        }
      }
      ImGui::EndDragDropTarget();
    }
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const Colours& c = colours();
    if (chosen || hovered) list.AddRectFilled(a, {b.x + 2 * kSmallButton, b.y}, chosen ? c.soft : c.fieldHover, kRound);
    const ImU32 ink = thing.visible ? c.text : c.dim;
    const float middle = (a.y + b.y) / 2;
    if (colour) {
      list.AddRectFilled({a.x + 8, middle - 7}, {a.x + 22, middle + 7},
                         ImGui::ColorConvertFloat4ToU32({colour[0], colour[1], colour[2], thing.visible ? 1 : 0.4f}),
                         3);
      if (document.active == thing.id)
        list.AddRect({a.x + 5.5f, middle - 9.5f}, {a.x + 24.5f, middle + 9.5f}, c.accent, 5, 0, 1.5f);
    } else {
      drawIcon(list, iconOf(document, thing.id), {a.x + 15, middle}, 17, ink);
    }
    ImGui::SetCursorScreenPos({a.x + 32, std::floor(middle - ImGui::GetTextLineHeight() / 2)});
    const engine::Piece* piece = document.piece(thing.id);
    kit::elided(thing.name + (piece && piece->hideMasked ? ", part hidden" : ""), main - 36, ink);
    ImGui::SetCursorScreenPos(a);
    ImGui::Dummy({main, kHeight});  // The item that the eye stands beside.
  }
  ImGui::SameLine(0, 0);
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + (kHeight - kSmallButton) / 2);
  if (kit::iconButton("eye", thing.visible ? "eye" : "eyeOff", kSmallButton, kit::Lit::off,
                      thing.visible ? "Hide: hidden things are not felt either" : "Show")) {
    if (thing.visible)
      change(context, thing, "Hide", [](Thing& t) { t.visible = false; });
    else
      change(context, thing, "Show", [](Thing& t) { t.visible = true; });
  }
  ImGui::SameLine(0, 0);
  if (kit::iconButton("lock",
                      thing.locked ? "lock"
                      : inRow      ? "unlock"
                                   : "none",
                      kSmallButton, kit::Lit::off,
                      thing.locked ? "Unlock" : "Lock: neither edited nor moved, still felt")) {
    if (thing.locked)
      change(context, thing, "Unlock", [](Thing& t) { t.locked = false; });
    else
      change(context, thing, "Lock", [](Thing& t) { t.locked = true; });
  }
  ImGui::SetCursorScreenPos({origin.x, origin.y + kHeight + 1});
  ImGui::PopID();
}

void group(const char* name, size_t count) {
  if (ImGui::GetCursorPosY() > ImGui::GetCursorStartPos().y + 1) kit::gap(8);
  ImGui::PushFont(fonts().small);
  kit::dimText(std::string(name) + "  " + std::to_string(count));
  ImGui::PopFont();
}

}  // namespace

void thingsPanel(Context& context, Memory& memory) {
  const Document& document = *context.now.document;
  const float foot = 34;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {kGap, 1});
  ImGui::BeginChild("list", {0, ImGui::GetContentRegionAvail().y - foot});
  kit::sharpen(*ImGui::GetWindowDrawList());
  if (document.pieces.empty() && document.parts.empty() && document.guides.empty()) {
    kit::gap(6);
    kit::wrapped("Nothing here yet. Add a block or a ball, open a file, or place a guide.", colours().dim);
  }
  int place = 0;
  if (!document.pieces.empty()) group("CLAY", document.pieces.size());
  for (const engine::Piece& piece : document.pieces) row(context, memory, piece, piece.colour.data(), place++);
  place = 0;
  if (!document.parts.empty()) group("PARTS", document.parts.size());
  for (const engine::Part& part : document.parts) row(context, memory, part, part.colour.data(), place++);
  place = 0;
  if (!document.guides.empty()) group("GUIDES", document.guides.size());
  for (const engine::Guide& guide : document.guides) row(context, memory, guide, nullptr, place++);
  ImGui::EndChild();
  ImGui::PopStyleVar();

  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {2, 2});
  actionButton(context, "clay.add", "plus", 28);
  ImGui::SameLine();
  actionButton(context, "file.import", "import", 28);
  ImGui::SameLine(ImGui::GetWindowWidth() - 3 * 30 + 2);
  actionButton(context, "edit.moveUp", "up", 28);
  ImGui::SameLine();
  actionButton(context, "edit.moveDown", "down", 28);
  ImGui::SameLine();
  actionButton(context, "edit.delete", "trash", 28);
  ImGui::PopStyleVar();
}

}  // namespace argil::studio
