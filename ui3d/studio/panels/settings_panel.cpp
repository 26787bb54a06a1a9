#include <cctype>
#include <cmath>
#include <filesystem>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"

namespace argil::studio {

namespace {

// The image or the shape that a tool works with.
void fileRow(Context& context, const engine::ToolRow& row) {
  if (row.file == engine::ToolFile::none) return;
  engine::Tool& tool = context.state.tool();
  const bool image = row.file == engine::ToolFile::image;
  const float width = ImGui::GetContentRegionAvail().x, wide = kit::buttonWidth("Choose…");
  const float top = ImGui::GetCursorPosY();
  ImGui::SetCursorPosY(top + std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
  if (tool.file.empty()) {
    kit::elided(image ? "No image yet" : "No shape yet", width - wide - kGap, colours().warning);
  } else {
    kit::elided(std::filesystem::path(tool.file).filename().string(), width - wide - kGap, colours().text);
    kit::tooltip(tool.file);
  }
  ImGui::SameLine(ImGui::GetCursorStartPos().x + width - wide);
  ImGui::SetCursorPosY(top);
  if (kit::button("Choose…", tool.file.empty() ? kit::Weight::chief : kit::Weight::plain, wide))
    context.state.wishes.dialog = "toolFile";
  kit::tooltip(image ? "A picture: what is bright in it stands out."
                     : "A mesh: the stroke lays it along, or cuts it out.");
}

void hand(Context& context, const engine::ToolRow& row) {
  drawRows(engine::heldParameters(row), context.state.tool());
  const Action* straight = findAction("tool.straight");
  kit::toggle(straight->name, context.state.straight, straight->help + " Key: " + shortcutOf(*straight, context.state));
}

// Clay that is not seen must not be forgotten.
void hiddenPart(Context& context) {
  const engine::Piece* piece = context.now.document->piece(context.state.selected);
  if (!piece) piece = context.now.document->workedOn();
  if (!piece || !piece->hideMasked) return;
  const Action* action = findAction("piece.mask-show");
  kit::wrapped("Part of " + piece->name + " is hidden.", colours().warning);
  if (kit::button(action->name, kit::Weight::plain, ImGui::GetContentRegionAvail().x, "eye"))
    runAction(context, action->id);
  kit::tooltip(action->help, shortcutOf(*action, context.state));
  kit::gap(6);
}

void symmetry(Context& context) {
  kit::heading("Symmetry");
  const float each = std::floor((ImGui::GetContentRegionAvail().x - 2 * kGap) / 3);
  for (const auto& [axis, letter] : {std::pair{"symmetry.x", "X"}, {"symmetry.y", "Y"}, {"symmetry.z", "Z"}}) {
    if (letter[0] != 'X') ImGui::SameLine();
    const Action* action = findAction(axis);
    if (kit::button(letter, action->checked(context, action->argument) ? kit::Weight::chief : kit::Weight::plain, each))
      runAction(context, axis);
    kit::tooltip(action->help, shortcutOf(*action, context.state));
  }
  engine::Symmetry symmetry = context.now.document->symmetry;
  const auto touched = drawRows(symmetryRows(), symmetry);
  if (touched.changed && symmetry.turns != context.now.document->symmetry.turns) context.bench.setSymmetry(touched.set);
}

}  // namespace

void maskButtons(Context& context) {
  kit::heading("Mask");
  const float half = std::floor((ImGui::GetContentRegionAvail().x - kGap) / 2);
  bool left = true;
  for (const engine::PieceJob& job : engine::pieceJobs()) {
    const Action* action = job.group == "Mask" ? findAction("piece." + std::string(job.id)) : nullptr;
    if (!action || (context.state.drawnCurve && context.state.drawnCurve->job == &job)) continue;
    if (!left) ImGui::SameLine();
    left = !left;
    ImGui::BeginDisabled(!action->enabled(context));
    if (kit::button(job.brief.empty() ? job.name : job.brief, kit::Weight::plain, half)) runAction(context, action->id);
    ImGui::EndDisabled();
    kit::tooltip(action->help, shortcutOf(*action, context.state));
  }
}

void settingsPanel(Context& context, Memory& memory) {
  hiddenPart(context);
  if (context.state.drawnCurve) {
    drawnCurveSection(context);
    return;
  }
  if (context.state.planeCut) {
    planeCutSection(context);
    return;
  }
  if (context.state.deformBox) {
    deformSection(context);
    return;
  }
  const engine::ToolRow* row = engine::findTool(context.state.toolId);
  if (row) {
    const std::string_view icon = hasIcon(row->id) ? row->id : row->icon;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(*ImGui::GetWindowDrawList(), icon, {at.x + 10, at.y + 9}, 20, colours().accent);
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + (hasIcon(icon) ? 28 : 0));
    ImGui::PushFont(fonts().strong);
    kit::text(row->name);
    ImGui::PopFont();
    kit::wrapped(row->help, colours().dim);
    kit::gap(4);
    fileRow(context, *row);
    const bool lays = laysMaterial(context);
    const bool pointer = context.bench.usesPointer();
    for (const auto& parameter : engine::ownParameters(*row))
      if ((!lays || parameter.id != "material") && counts(parameter, context.state.tool(), pointer))
        (void)drawRow(parameter, context.state.tool());
    if (row->opposite == row->id)
      kit::toggle("Inverted", context.state.tool().inverted, "The other way round; Ctrl held does it for a stroke.");
    if (!row->operations.empty() && row->operations.front().property == clay::Property::mask) maskButtons(context);
    kit::gap(2);
    if (kit::button(memory.handOpen ? "Hand and pressure  −" : "Hand and pressure  +", kit::Weight::plain,
                    ImGui::GetContentRegionAvail().x))
      memory.handOpen = !memory.handOpen;
    if (memory.handOpen) hand(context, *row);
  }
  if (row && row->work == haptics::Work::cut && context.bench.usesPointer() && !context.state.tool().soft)
    drawRows(handRows(), context.state);
  const engine::Piece* selected = context.now.document->piece(context.state.selected);
  const engine::Piece* piece = selected ? selected : context.now.document->piece(context.now.document->active);
  if (piece && laysMaterial(context)) materialsSection(context, memory, *piece);
  symmetry(context);
  inspector(context, memory);
}

}  // namespace argil::studio
