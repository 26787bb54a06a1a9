// New clay, preferences, the first page.

#include <algorithm>
#include <cmath>
#include <utility>

#include "ui3d/studio/panels/icons.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/panel_table.h"
#include "ui3d/studio/panels/theme.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

// One of the three things to begin with.
bool bigButton(std::string_view icon, std::string_view name, std::string_view help) {
  const float width = ImGui::GetContentRegionAvail().x, height = 58;
  ImGui::PushID(name.data());
  const bool pressed = ImGui::InvisibleButton("big", {width, height});
  ImGui::PopID();
  const bool hovered = ImGui::IsItemHovered();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  list.AddRectFilled(a, b, hovered ? c.fieldHover : c.field, 7);
  list.AddRect(a, b, hovered ? c.accent : c.line, 7, 0, 1);
  drawIcon(list, icon, {a.x + 31, (a.y + b.y) / 2}, 26, c.accent);
  ImGui::PushFont(fonts().strong);
  list.AddText({a.x + 60, a.y + 11}, c.text, name.data(), name.data() + name.size());
  ImGui::PopFont();
  list.AddText({a.x + 60, a.y + 31}, c.dim, help.data(), help.data() + help.size());
  return pressed;
}

}  // namespace

void drawNewClay(Context& context, Memory& memory) {
  if (!kit::beginDialog("New clay", "Add clay", 380, 0, &memory.newClayOpen)) return;
  NewClay& clay = memory.newClay;
  static constexpr std::array<std::string_view, 2> kShapes{"Block", "Ball"};
  kit::segmented("shape", kShapes, clay.shape);
  const auto length = [](std::string_view id, std::string_view name, double& value, double low, double standard) {
    kit::number({id, name, "", "mm", low, 1000, standard, true}, value);
  };
  double voxels = 0;
  if (clay.shape == 0) {
    length("x", "Width", clay.xMm, 1, 60);
    length("y", "Depth", clay.yMm, 1, 60);
    length("z", "Height", clay.zMm, 1, 40);
    const double most = 0.5 * std::min({clay.xMm, clay.yMm, clay.zMm});
    clay.roundMm = std::min(clay.roundMm, most);
    kit::number({"round", "Rounding of edges", "", "mm", 0, most, std::min(4.0, most)}, clay.roundMm);
    voxels = 2 * (clay.xMm * clay.yMm + clay.yMm * clay.zMm + clay.zMm * clay.xMm) / (clay.voxelMm * clay.voxelMm);
  } else {
    length("radius", "Radius", clay.radiusMm, 0.5, 30);
    voxels = 4 * 3.14159265358979 * clay.radiusMm * clay.radiusMm / (clay.voxelMm * clay.voxelMm);
  }
  kit::number({"voxel", "Voxel", "Finer shows more and costs more.", "mm", 0.01, 10, 0.5, true}, clay.voxelMm);
  kit::toggle(kHalfMemory, clay.halfMemory, kHalfMemoryHelp);
  // Two triangles a voxel of the surface; a half more on average for how a curved surface crosses them.
  kit::fact("Triangles, about", kit::counted(uint64_t(std::round(3 * voxels / 1000)) * 1000));
  kit::gap(6);
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * 96 - kGap);
  if (kit::button("Cancel", kit::Weight::plain, 96)) memory.newClayOpen = false;
  ImGui::SameLine();
  if (kit::button("Add", kit::Weight::chief, 96)) {
    const engine::Workbench::NewClay how{
        .voxelMm = clay.voxelMm,
        .precision = clay.halfMemory ? clay::Precision::fixed16 : clay::Precision::float32,
        .beside = true};
    if (clay.shape == 0) context.bench.addBlock(Vec3d(clay.xMm, clay.yMm, clay.zMm), clay.roundMm, how);
    else context.bench.addSphere(clay.radiusMm, how);
    memory.newClayOpen = false;
    context.state.shown.firstStart = false;
  }
  kit::endDialog(memory.newClayOpen);
}

void drawPreferences(Context& context, Memory&) {
  bool& open = context.state.shown.preferences;
  if (!kit::beginDialog("Preferences", "Preferences", 400, 0, &open)) return;
  static constexpr std::array<std::string_view, 2> kThemes{"Dark", "Light"};
  kit::dimText("Theme");
  int theme = int(context.state.theme);
  if (kit::segmented("theme", kThemes, theme)) runAction(context, "window.theme");
  static constexpr std::array<std::string_view, 8> kScales{"As the display says", "75 %", "100 %", "125 %", "150 %", "200 %", "250 %", "300 %"};
  static constexpr std::array<float, 8> kFactors{0, 0.75f, 1, 1.25f, 1.5f, 2, 2.5f, 3};
  int scale = int(std::find(kFactors.begin(), kFactors.end(), context.state.interfaceScale) - kFactors.begin());
  if (kit::choice("Size", kScales, scale, "Of everything flat.")) context.state.interfaceScale = kFactors[size_t(scale)];
  kit::toggle("Snap widgets", context.state.snapWidgets, "Dragged widgets snap to guides, clay and grid.");
  kit::toggle("Light background", context.state.look.lightBackground, "Behind the clay.");
  kit::gap(6);
  if (kit::button("Keys…", kit::Weight::plain, -1)) {
    open = false;
    context.state.shown.shortcuts = true;
  }
  kit::endDialog(open);
}

void drawFirstStart(Context& context, Memory& memory) {
  const kit::Rect& free = memory.layout.free;
  const engine::Document& document = *context.now.document;
  const bool empty = document.pieces.empty() && document.parts.empty() && document.guides.empty();
  if (!context.state.shown.firstStart || free.width() < 200) return;
  const bool room = free.height() > 420;
  kit::beginCard("First start", {std::floor((free.left + free.right) / 2), std::floor(free.top + (room ? 0.14f : 0.02f) * free.height())}, {0.5f, 0},
                 std::min(440.0f, free.width() - 24), free.height() - 110);
  ImGui::PushFont(fonts().title);
  kit::text("Argil");
  ImGui::PopFont();
  ImGui::SameLine(ImGui::GetWindowWidth() - kPad - 22);
  if (kit::iconButton("close", "close", 22, kit::Lit::off, "Close; it is in the Help menu")) context.state.shown.firstStart = false;
  kit::wrapped("Digital clay that you touch.", colours().dim);
  kit::gap(8);
  if (bigButton("block", "A block to carve", "60 × 60 × 40 mm, and the tool in hand")) runAction(context, "clay.block");
  if (bigButton("folder", "Open a file", "What was saved, or a model: 3MF, STL, OBJ, PLY, glTF…")) runAction(context, "file.open");
  if (bigButton("keys", "A tour of the keys", "What mouse, pen and keyboard do")) context.state.shown.shortcuts = true;
  if (!context.state.recentFiles.empty() && room) {
    kit::gap(6);
    kit::dimText("Opened before");
    for (size_t i = 0; i < std::min<size_t>(3, context.state.recentFiles.size()); ++i) {
      const std::string file = context.state.recentFiles[i];
      ImGui::PushID(int(i));
      const float width = ImGui::GetContentRegionAvail().x;
      if (ImGui::InvisibleButton("recent", {width, 24})) {
        beginDocument(context, memory, file);
      }
      const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
      if (ImGui::IsItemHovered()) ImGui::GetWindowDrawList()->AddRectFilled(a, b, colours().fieldHover, kRound);
      const ImVec2 after = ImGui::GetCursorPos();
      ImGui::SetCursorScreenPos({a.x + 6, a.y + 3});
      kit::elided(fs::path(file).filename().string() + "   " + fs::path(file).parent_path().string(), width - 12, colours().text);
      ImGui::SetCursorPos(after);
      ImGui::PopID();
    }
  }
  kit::endCard();
  if (!empty && !memory.firstStartSeen) context.state.shown.firstStart = false;  // Began with a document.
  memory.firstStartSeen = true;
}

}  // namespace argil::studio
