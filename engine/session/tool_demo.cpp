#include "engine/session/tool_demo.h"

#include <cmath>

namespace argil::engine {
namespace {

constexpr double kHalfLength = 24, kSwing = 7;  // of the S that most tools draw, mm
constexpr int kPoints = 60;

ScriptStroke strokeOf(const Tool& tool, double pressMm, std::vector<Vec3d> places) {
  ScriptStroke stroke;
  stroke.tool = tool;
  stroke.onto = Onto{-Vec3d::UnitZ(), pressMm};
  for (size_t i = 0; i < places.size(); ++i) stroke.path.push_back({0.01 * double(i), places[i] + Vec3d(0, 0, 40)});
  return stroke;
}

std::vector<Vec3d> line(const Vec3d& from, const Vec3d& to) {
  std::vector<Vec3d> places;
  for (int i = 0; i <= kPoints; ++i) places.push_back(from + (to - from) * i / double(kPoints));
  return places;
}

std::vector<Vec3d> letterS() {
  std::vector<Vec3d> places;
  for (int i = 0; i <= kPoints; ++i) {
    const double u = 2.0 * i / kPoints - 1;  // −1 to 1
    // Without trigonometry: the scene is the same on every machine.
    places.push_back({kHalfLength * u, kSwing * 2.6 * u * (1 - u * u), 0});
  }
  return places;
}

}  // namespace

Script toolDemo(const ToolRow& row) {
  Script script;
  script.voxelMm = 0.4;
  script.clay = BlockSetup{{64, 44, 14}, 3, Vec3d::Zero()};
  Tool bump = scriptTool(*findTool("add")), furrow = scriptTool(*findTool("carve"));
  bump.radiusMm = 5;
  furrow.radiusMm = 2.5;
  script.strokes.push_back(strokeOf(bump, 5, {{-12, 3, 0}}));
  script.strokes.push_back(strokeOf(furrow, 2, line({13, -17, 0}, {13, 17, 0})));

  if (row.id == "material") script.materials = {{"Wax", {}, std::array{0.2f, 0.4f, 0.8f}}};

  Tool tool = scriptTool(row);
  tool.radiusMm = row.work == haptics::Work::rub ? 6 : 4;
  double press = row.work == haptics::Work::cut ? 2 : row.work == haptics::Work::lay ? 3 : tool.radiusMm;
  std::vector<Vec3d> places = letterS();
  if (row.group == "Move") {
    tool.radiusMm = press = 8;
    if (row.id == "tug" || row.id == "smudge") places = line({-12, 3, 0}, {2, -5, 0});
    if (row.id == "twist") places = line({13, 0, 0}, {13, 1.5, 0});
    if (row.id == "pinch") places = line({13, -11, 0}, {13, 11, 0});
    if (row.id == "pinch" || row.id == "smudge") tool.strength = 1;
  }
  int passes = 1;
  if (row.group == "Surface") {
    tool.heightMm = 2;
    if (row.operations[0].method != clay::Method::raise && row.id != "crease") {
      // Over the bump and the furrow, to and fro.
      tool.strength = 1;
      places = line({-22, 3, 0}, {22, 3, 0});
      passes = 4;
    }
  }
  if (row.file != ToolFile::none) {
    tool.file = row.file == ToolFile::image ? "tile.pgm" : "tile.stl";
    tool.radiusMm = 11;
    press = 11;
    places = {{0, 0, 0}};
  }
  if (row.id == "morph") {
    // The bump goes, the furrow stays.
    tool.morphTo = 0;
    places = line({-20, 3, 0}, {-4, 3, 0});
  }
  if (row.group == "Lab") tool.heightMm = 3;
  if (row.id == "blend" || row.id == "blur_mask") {
    // Something with a rim that can be softened.
    Tool before = scriptTool(*findTool(row.id == "blend" ? "paint" : "mask"));
    before.radiusMm = press / 2;  // The rim lies where the tool works, not at its own, where it does nothing.
    before.falloff = clay::Falloff::constant;
    script.strokes.push_back(strokeOf(before, press, letterS()));
    passes = 6;
    tool.strength = 1;
  }
  for (int i = 0; i < passes; ++i) script.strokes.push_back(strokeOf(tool, press, places));
  return script;
}

}  // namespace argil::engine
