#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

void edit(Context& context, Memory& memory, const Action& action, float width) {
  const bool begins = std::exchange(memory.keyBegins, false);
  if (begins) memory.keyText = shortcutOf(action, context.state);
  const bool done = kit::textField("##keys", memory.keyText, width, "Ctrl+Shift+K", begins);
  if (!done && (begins || ImGui::IsItemActive() || ImGui::IsItemFocused())) return;
  if (done) {
    try {
      setShortcut(context.state, action, memory.keyText);
      memory.keyProblem.clear();
    } catch (const Error& error) {
      memory.keyProblem = error.what();
    }
  }
  memory.keyEdited.clear();
}

}  // namespace

void drawShortcuts(Context& context, Memory& memory) {
  bool& open = context.state.shown.shortcuts;
  if (!kit::beginDialog("Shortcuts", "Keys", 660, 600, &open)) {
    memory.keyEdited.clear();
    memory.keyProblem.clear();
    return;
  }
  kit::wrapped(
      "Drag with the left button on clay: the tool. Middle or right button: turn; with Shift: move; wheel: nearer and "
      "farther. "
      "Ctrl held: the opposite tool; Shift held: smooth; F and a drag: the tool's size. "
      "A click on another piece works on it; Ctrl and a click selects it too. "
      "A pen: its button and a drag turn; its button and the tip together move; a click of its button (or the right "
      "one of a mouse) opens a ring of undo, redo, "
      "size, zoom and move; pressure as each tool's settings say; its other end is the opposite tool, or smooths. "
      "Click a key below to change it.",
      colours().dim);
  kit::textField("##filter", memory.keyFilter, 0, "Search");
  if (!memory.keyProblem.empty()) kit::wrapped(memory.keyProblem, colours().error);
  ImGui::BeginChild("list", {0, ImGui::GetContentRegionAvail().y - kRow - kGap});
  kit::sharpen(*ImGui::GetWindowDrawList());
  std::string group;
  const std::vector<const Action*> found = searchActions(memory.keyFilter);
  for (const Action& action : actions()) {
    if (std::find(found.begin(), found.end(), &action) == found.end()) continue;
    if (action.group != group) kit::heading(group = action.group);
    ImGui::PushID(action.id.c_str());
    const float width = ImGui::GetContentRegionAvail().x, field = 190;
    const float top = ImGui::GetCursorPosY();
    ImGui::SetCursorPosY(top + std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
    kit::elided(action.name, width - field - 40, colours().text);
    kit::tooltip(action.help);
    ImGui::SameLine(width - field - 26);
    ImGui::SetCursorPosY(top);
    if (memory.keyEdited == action.id) {
      edit(context, memory, action, field);
    } else {
      const std::string keys = shortcutOf(action, context.state);
      if (kit::button(keys.empty() ? "–" : keys, kit::Weight::plain, field)) {
        memory.keyEdited = action.id;
        memory.keyBegins = true;
        memory.keyProblem.clear();
      }
    }
    if (context.state.keys.contains(action.id)) {
      ImGui::SameLine(0, 2);
      if (kit::iconButton("reset", "undo", 22, kit::Lit::off, "As it shipped: " + action.shortcut)) {
        try {
          resetShortcut(context.state, action);
          memory.keyProblem.clear();
        } catch (const Error& error) {
          memory.keyProblem = error.what();
        }
      }
    }
    ImGui::PopID();
  }
  ImGui::EndChild();
  ImGui::BeginDisabled(context.state.keys.empty());
  if (kit::button("All as shipped")) context.state.keys.clear();
  ImGui::EndDisabled();
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - 96);
  if (kit::mainButton("Done", 96)) open = false;
  kit::endDialog(open);
}

}  // namespace argil::studio
