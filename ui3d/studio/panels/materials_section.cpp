// Materials of a piece: what voxels are made of that the material tool has set. Names, colours and how they feel.

#include <algorithm>
#include <cmath>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"

namespace argil::studio {
namespace {

using engine::Document;
using engine::MaterialRow;
using engine::Piece;

constexpr float kPatch = 14;

// One step for each number that is dragged.
void change(Context& context, const Piece& piece, size_t index, std::string_view what, std::string_view key,
            std::function<void(MaterialRow&)> how) {
  const std::string merge =
      key.empty() ? std::string() : std::string(key) + "." + std::to_string(piece.id) + "." + std::to_string(index);
  context.bench.edit(
      std::string(what) + " of " + piece.materials[index].name,
      [id = piece.id, index, how = std::move(how)](Document& d) {
        Piece* each = d.piece(id);
        if (each && index < each->materials.size()) how(each->materials[index]);
      },
      merge);
}

// A line of the list; `number` is what the channel holds.
bool line(int number, std::string_view name, const std::array<float, 3>& colour, bool chosen) {
  ImGui::PushID(number);
  const float width = ImGui::GetContentRegionAvail().x;
  const bool pressed = ImGui::InvisibleButton("material", {width, kRow});
  const bool hovered = ImGui::IsItemHovered();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (chosen || hovered) list.AddRectFilled(a, b, chosen ? colours().soft : colours().fieldHover, kRound);
  const float middle = std::floor((a.y + b.y) / 2), text = std::floor(middle - ImGui::GetTextLineHeight() / 2);
  list.AddRectFilled({a.x + 7, middle - kPatch / 2}, {a.x + 7 + kPatch, middle + kPatch / 2},
                     ImGui::ColorConvertFloat4ToU32({colour[0], colour[1], colour[2], 1}), 3);
  ImGui::SetCursorScreenPos({a.x + 29, text});
  kit::elided(name, width - 29 - 30, colours().text);
  const std::string digits = std::to_string(number);
  ImGui::SetCursorScreenPos({b.x - 8 - ImGui::CalcTextSize(digits.c_str()).x, text});
  kit::dimText(digits);
  ImGui::SetCursorScreenPos({a.x, b.y + 1});
  ImGui::PopID();
  return pressed;
}

void chosenRow(Context& context, Memory& memory, const Piece& piece, size_t index) {
  const MaterialRow& row = piece.materials[index];
  kit::gap(4);
  ImGui::PushID(int(index) + 1);
  const bool other = memory.materialOf != std::pair(piece.id, index);
  if (other || (!memory.materialTyping && memory.materialName != row.name)) memory.materialName = row.name;
  memory.materialOf = {piece.id, index};
  if (kit::textField("##name", memory.materialName, 0, "Name") && !memory.materialName.empty() &&
      memory.materialName != row.name)
    change(context, piece, index, "Name", "", [name = memory.materialName](MaterialRow& each) { each.name = name; });
  memory.materialTyping = ImGui::IsItemActive();
  bool coloured = row.colour.has_value();
  if (kit::toggle("Colour of its own", coloured, "Shown where nothing is painted; else the piece's colour.")) {
    change(context, piece, index, "Colour", "", [coloured, colour = piece.colour](MaterialRow& each) {
      each.colour.reset();
      if (coloured) each.colour = colour;
    });
  }
  if (row.colour) {
    const auto byte = [](float part) { return double(std::lround(std::clamp(part, 0.0f, 1.0f) * 255)); };
    double colour = byte((*row.colour)[0]) * 65536 + byte((*row.colour)[1]) * 256 + byte((*row.colour)[2]);
    const kit::Change touched = kit::colour("Colour", colour, "Of the clay that has this material.");
    if (touched.changed) {
      const auto rgb = static_cast<uint32_t>(colour);
      change(context, piece, index, "Colour", "material-colour", [rgb](MaterialRow& each) {
        each.colour = {float(rgb >> 16 & 255) / 255, float(rgb >> 8 & 255) / 255, float(rgb & 255) / 255};
      });
    }
    if (touched.ended) context.bench.endMerge();
  }
  if (feelHeading(context, memory)) {
    haptics::Material material = row.material;
    const auto touched = drawRows(materialRows(), material);
    if (touched.changed)
      change(context, piece, index, touched.name, touched.id,
             [set = touched.set](MaterialRow& each) { set(each.material); });
    if (touched.ended) context.bench.endMerge();
  }
  // Voxels hold numbers: only the last row can go without another one taking its place.
  if (index + 1 == piece.materials.size() &&
      kit::button("Remove", kit::Weight::plain, ImGui::GetContentRegionAvail().x, "trash")) {
    context.bench.edit("Remove " + row.name, [id = piece.id, index](Document& d) {
      if (Piece* each = d.piece(id); each && each->materials.size() == index + 1) each->materials.pop_back();
    });
  }
  ImGui::PopID();
}

}  // namespace

bool laysMaterial(const Context& context) {
  const engine::ToolRow* row = engine::findTool(context.state.toolId);
  return row && row->id != "invisible" && engine::findParameter(*row, "material");
}

void materialsSection(Context& context, Memory& memory, const Piece& piece) {
  kit::heading("Materials");
  ImGui::PushID("materials");
  ImGui::BeginDisabled(piece.locked);
  const bool lays = laysMaterial(context);
  const int rows = int(piece.materials.size());
  int chosen = lays ? context.state.tool().material : memory.material;
  const int before = chosen;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {kGap, 1});
  if (line(0, "As the piece", piece.colour, chosen == 0)) chosen = 0;
  for (int i = 0; i < rows; ++i)
    if (line(i + 1, piece.materials[size_t(i)].name, piece.materials[size_t(i)].colour.value_or(piece.colour),
             chosen == i + 1))
      chosen = i + 1;
  ImGui::PopStyleVar();
  if (lays && chosen > rows && chosen != 255)
    kit::wrapped("Material " + std::to_string(chosen) + " is not there yet: it looks and feels like the piece.",
                 colours().warning);
  const Action* add = findAction("clay.materialAdd");
  if (kit::button("Add a material", kit::Weight::plain, ImGui::GetContentRegionAvail().x, "plus")) {
    addMaterial(context, piece);
    chosen = rows + 1;
  }
  kit::tooltip(add->help, shortcutOf(*add, context.state));
  if (chosen != before) {
    memory.material = chosen;
    if (lays) context.state.tool().material = chosen;
  }
  if (chosen > 0 && chosen <= rows) chosenRow(context, memory, piece, size_t(chosen - 1));
  ImGui::EndDisabled();
  ImGui::PopID();
}

}  // namespace argil::studio
