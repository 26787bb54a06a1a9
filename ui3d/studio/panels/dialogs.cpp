// New clay, preferences.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "engine/document/cost.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {

engine::MachineSpeed speedOf(Memory& memory) {
  if (memory.machine) return *memory.machine;
  if (!memory.measuring.valid()) memory.measuring = std::async(std::launch::async, engine::machineSpeed);
  if (memory.measuring.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    memory.machine = memory.measuring.get();
  return memory.machine.value_or(engine::MachineSpeed());
}

void drawNewClay(Context& context, Memory& memory) {
  if (!kit::beginDialog("New clay", "Add clay", 380, 0, &memory.newClayOpen)) return;
  NewClay& clay = memory.newClay;
  static constexpr std::array<std::string_view, 2> kShapes{"Block", "Ball"};
  kit::segmented("shape", kShapes, clay.shape);
  const auto length = [&clay](std::string_view id, std::string_view name, double& value, double low, double standard) {
    kit::number({id, name, "", "mm", low * clay.scale, 1000 * clay.scale, standard * clay.scale, true}, value);
  };
  engine::ClayPlan plan;
  if (clay.shape == 0) {
    length("x", "Width", clay.xMm, 1, 60);
    length("y", "Depth", clay.yMm, 1, 60);
    length("z", "Height", clay.zMm, 1, 40);
    const double most = 0.5 * std::min({clay.xMm, clay.yMm, clay.zMm});
    clay.roundMm = std::min(clay.roundMm, most);
    kit::number({"round", "Rounding of edges", "", "mm", 0, most, std::min(4.0 * clay.scale, most)}, clay.roundMm);
    plan.areaMm2 = 2 * (clay.xMm * clay.yMm + clay.yMm * clay.zMm + clay.zMm * clay.xMm);
    plan.slant = 1;
  } else {
    length("radius", "Radius", clay.radiusMm, 0.5, 30);
    plan.areaMm2 = 4 * std::numbers::pi * clay.radiusMm * clay.radiusMm;
  }
  kit::number({"voxel", "Voxel", "Finer shows more and costs more.", "mm", std::max(0.001, 0.01 * clay.scale),
               std::min(1000.0, 10 * clay.scale), 0.5 * clay.scale, true},
              clay.voxelMm);
  kit::toggle(kHalfMemory, clay.halfMemory, kHalfMemoryHelp);
  plan.voxelMm = clay.voxelMm;
  plan.precision = clay.halfMemory ? clay::Precision::fixed16 : clay::Precision::float32;
  plan.tipMm = context.state.tool().radiusMm;
  const engine::ClayCost cost = engine::costOf(plan, speedOf(memory));
  const auto thousands = [](double count) { return kit::counted(uint64_t(std::round(count / 1000)) * 1000); };
  kit::fact("Voxels, about", thousands(cost.activeVoxels));
  kit::fact("Triangles, about", thousands(cost.triangles));
  kit::fact("Memory, about", kit::bytes(uint64_t(cost.bytes)));
  kit::fact("A dab of " + kit::written(plan.tipMm) + " mm", kit::written(cost.dabMs) + " ms");
  kit::fact("Rims of cuts within", kit::written(cost.edgeMm) + " mm");
  kit::gap(6);
  ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - 2 * 96 - kGap);
  if (kit::button("Cancel", kit::Weight::plain, 96)) memory.newClayOpen = false;
  ImGui::SameLine();
  if (kit::mainButton("Add", 96)) {
    clay.add(context.bench);
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
  static constexpr std::array<std::string_view, 8> kScales{
      "As the display says", "75 %", "100 %", "125 %", "150 %", "200 %", "250 %", "300 %"};
  static constexpr std::array<float, 8> kFactors{0, 0.75f, 1, 1.25f, 1.5f, 2, 2.5f, 3};
  int scale = int(std::find(kFactors.begin(), kFactors.end(), context.state.interfaceScale) - kFactors.begin());
  if (kit::choice("Size", kScales, scale, "Of everything flat."))
    context.state.interfaceScale = kFactors[size_t(scale)];
  kit::toggle("Snap widgets", context.state.snapWidgets, "Dragged widgets snap to guides, clay and grid.");
  drawRows(handsRows(), context.state);
  kit::toggle("Fold panels", context.state.foldPanels,
              "Where they would leave the clay less than 60 % of the window: then they open over it.");
  kit::toggle("Start page", context.state.startPage, "When Argil starts without a file.");
  kit::toggle("Light background", context.state.look.lightBackground, "Behind the clay.");
  kit::gap(6);
  if (kit::button("Keys…", kit::Weight::plain, 96)) {
    open = false;
    context.state.shown.shortcuts = true;
  }
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - 96);
  if (kit::mainButton("Done", 96)) open = false;
  kit::endDialog(open);
}

}  // namespace argil::studio
