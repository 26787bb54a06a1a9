#include "ui3d/studio/files/settings.h"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/print/print_check.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kMostBedMm = 100000;
constexpr double kLeastSizeMm = 1e-3, kMostSizeMm = 1e7;  // Of what tools may be sized for.

// Those over the picture begin closed.
bool remembered(const PanelRow& panel) {
  return panel.dock != Dock::middle;
}

void take(const Json& json, std::string_view name, bool& into) {
  if (const auto found = json.find(name); found != json.end() && found->is_boolean()) into = found->get<bool>();
}

template <class Number>
void take(const Json& json, std::string_view name, Number& into, double low, double high) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_number()) return;
  const double value = found->get<double>();
  if (value >= low && value <= high) into = Number(value);
}

template <class Choice>
void choose(const Json& json, std::string_view name, Choice& into, int count) {
  int value = int(into);
  take(json, name, value, 0, count - 1);
  into = Choice(value);
}

Json part(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

// A row for each plain value: the part of the file that it stands in, its name there, where it is in the state, and the
// least and the greatest that it may be (of choices: how many there are).
template <class State, class Row>
void eachValue(State& state, const Row& row) {
  row("", "pointer_depth", state.pointerDepthMm, 0, 1);
  row("", "pen_curve", state.penCurve, -1, 1);
  row("", "size_by", state.sizeBy, 3);
  row("", "sized_for_mm", state.sizedForMm, kLeastSizeMm, kMostSizeMm);
  row("", "snap", state.snapWidgets);
  row("", "fold_panels", state.foldPanels);
  row("", "start_page", state.startPage);
  row("", "undo_memory_gib", state.undoGiB, 0, 64);
  for (const PanelRow& panel : panelTable())
    if (remembered(panel)) row("panels", panel.id, state.shown.*panel.shown);
  auto& look = state.look;
  row("look", "shading", look.shading, 3);
  row("look", "matcap", look.matcap, 6);
  row("look", "cavity_strength", look.cavityStrength, 0, 2);
  row("look", "fade_strength", look.depthFadeStrength, 0, 1);
  row("look", "cavity", look.cavity);
  row("look", "keyShadow", look.keyShadow);
  row("look", "cursorShadow", look.cursorShadow);
  row("look", "beam", look.beam);
  row("look", "depthFade", look.depthFade);
  row("look", "grid", look.grid);
  row("look", "scaleBar", look.scaleBar);
  row("look", "xray", look.xray);
  row("look", "lightBackground", look.lightBackground);
  row("stereo", "mode", state.stereo.mode, 6);
  row("stereo", "eyes", state.stereo.eyeDistancePart, 0, 0.2);
  row("stereo", "convergence", state.stereo.convergencePart, 0.2, 5);
  row("stereo", "swap", state.stereo.swapEyes);
  row("quality", "supersample", state.quality.supersample, 1, 4);
  row("quality", "key_shadow", state.quality.keyShadow);
  row("quality", "cavity", state.quality.cavity);
  row("quality", "detail", state.quality.detailPixels, 0, 8);
  row("quality", "shadow_pixels", state.quality.shadowPixels, 256, 8192);
  row("quality", "grade", state.surface, 3);
  row("quality", "frames_per_second", state.framesPerSecond, StudioState::kLeastFrames, StudioState::kMostFrames);
  row("touch", "steps", state.touchQuality.contactSteps, 1, 64);
  row("touch", "searches", state.touchQuality.contactSearches, 4, 200);
  row("touch", "smooth", state.touchQuality.smoothNormals);
  auto& workspace = state.workspace;
  row("workspace", "scale", workspace.scale, 0.01, 100);
  row("workspace", "depth_mm", workspace.depthMm, -500, 500);
  row("workspace", "frame", workspace.frame, 3);
  row("workspace", "glide_mms", workspace.glideMms, 0, 1000);
  row("walls", "on", workspace.walls.on);
  row("walls", "share", workspace.walls.share, 0.1, 1);
  row("walls", "stiffness_nmm", workspace.walls.stiffnessNmm, 0.01, 10);
  row("walls", "rest_mm", workspace.walls.restMm, 0, 10);
  row("walls", "speed_mmsn", workspace.walls.speedMmsN, 0, 1000);
  row("import", "voxel_given", state.imports.voxelGiven);
  row("import", "voxel", state.imports.voxelMm, 0.01, 10);
  row("import", "half_memory", state.imports.halfMemory);
  row("print", "process", state.print.process, 0, int(engine::kPrintProcesses) - 1);
  row("print", "wall_mm", state.print.wallMm, 0.05, 20);
  row("print", "gap_mm", state.print.gapMm, 0.05, 20);
  row("print", "outlet_mm", state.print.outletMm, 0, 20);
  row("print", "draft_degrees", state.print.draftDegrees, 0.1, 45);
  row("print", "bed_width_mm", state.print.bedMm.x(), 1, kMostBedMm);
  row("print", "bed_depth_mm", state.print.bedMm.y(), 1, kMostBedMm);
  row("print", "bed_height_mm", state.print.bedMm.z(), 1, kMostBedMm);
}

struct WriteValue {
  Json& json;
  template <class Value, class... Bounds>
  void operator()(const char* inPart, std::string_view name, const Value& value, Bounds...) const {
    Json& place = *inPart ? json[inPart][std::string(name)] : json[std::string(name)];
    if constexpr (std::is_enum_v<Value>)
      place = int(value);
    else
      place = value;
  }
};

struct ReadValue {
  const Json& json;
  template <class Value, class... Bounds>
  void operator()(const char* inPart, std::string_view name, Value& into, Bounds... bounds) const {
    const auto found = *inPart ? json.find(inPart) : json.end();
    if (*inPart && (found == json.end() || !found->is_object())) return;
    const Json& place = *inPart ? *found : json;
    if constexpr (std::is_enum_v<Value>)
      choose(place, name, into, bounds...);
    else
      take(place, name, into, bounds...);
  }
};

}  // namespace

fs::path settingsFile() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config)
    return fs::path(config) / "argil" / "studio.json";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".config" / "argil" / "studio.json";
  return {};
}

std::string settingsText(const StudioState& state) {
  Json json;
  const Theme theme = state.keptTheme ? state.keptTheme->theme : state.theme;
  json["theme"] = theme == Theme::light ? "light" : "dark";
  json["interface_scale"] = state.interfaceScale;
  json["tool"] = state.toolId;
  for (const auto& [id, tool] : state.tools) {
    const engine::ToolRow* row = engine::findTool(id);
    if (!row) continue;
    Json& values = json["tools"][id];
    for (const auto& parameter : row->parameters) values[std::string(parameter.id)] = parameter.get(tool);
    if (tool.inverted) values["inverted"] = true;
    if (!tool.file.empty()) values["file"] = tool.file;
  }
  eachValue(state, WriteValue{json});
  // A background that was switched by hand since is kept.
  if (state.keptTheme && state.look.lightBackground == (state.theme == Theme::light))
    json["look"]["lightBackground"] = state.keptTheme->lightBackground;
  json["keys"] = Json::object();
  for (const auto& [action, keys] : state.keys) json["keys"][action] = keys;
  json["recent"] = state.recentFiles;
  json["folder"] = state.lastFolder;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool applySettings(const std::string& text, StudioState& state) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  if (const auto theme = json.find("theme"); theme != json.end() && theme->is_string())
    state.theme = *theme == "light" ? Theme::light : Theme::dark;
  state.look.lightBackground = state.theme == Theme::light;
  double scale = state.interfaceScale;
  take(json, "interface_scale", scale, 0, 4);
  state.interfaceScale = scale == 0 || scale >= 0.75 ? float(scale) : 0;
  if (const auto tool = json.find("tool");
      tool != json.end() && tool->is_string() && engine::findTool(tool->get<std::string>()))
    state.toolId = tool->get<std::string>();
  eachValue(state, ReadValue{json});
  const Json tools = part(json, "tools"), keys = part(json, "keys");
  for (const auto& [id, values] : tools.items()) {
    const engine::ToolRow* row = engine::findTool(id);
    if (!row || !values.is_object()) continue;
    engine::Tool tool = state.newTool(*row);
    for (const auto& parameter : row->parameters) {
      // Before there was a curve of all pens nobody had chosen that pressure rules nothing.
      if (!json.contains("pen_curve") && parameter.id.ends_with("_by_pressure")) continue;
      double value = parameter.get(tool);
      take(values, std::string(parameter.id).c_str(), value, parameter.low, parameter.high);
      parameter.change(tool, value);
    }
    if (row->opposite == row->id) take(values, "inverted", tool.inverted);
    if (const auto file = values.find("file");
        row->file != engine::ToolFile::none && file != values.end() && file->is_string())
      tool.file = file->get<std::string>();
    state.tools[id] = tool;
  }
  for (const auto& [action, shortcut] : keys.items())
    if (shortcut.is_string()) state.keys[action] = shortcut.get<std::string>();
  if (const auto recent = json.find("recent"); recent != json.end() && recent->is_array())
    for (const Json& file : *recent)
      if (file.is_string() && state.recentFiles.size() < StudioState::kMostRecent)
        state.recentFiles.push_back(file.get<std::string>());
  if (const auto folder = json.find("folder"); folder != json.end() && folder->is_string())
    state.lastFolder = folder->get<std::string>();
  return true;
}

void loadSettings(StudioState& state) {
  std::ifstream in(settingsFile());
  std::ostringstream text;
  text << in.rdbuf();
  applySettings(text.str(), state);
}

bool saveSettings(const StudioState& state) {
  const fs::path file = settingsFile();
  if (file.empty()) return false;
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  // Of this program alone: two windows that are closed at once do not write into each other's.
  const fs::path temporary = file.string() + "." + std::to_string(getpid()) + ".new";
  std::ofstream out(temporary);
  out << settingsText(state) << std::flush;
  const bool written = bool(out);
  out.close();
  if (written) fs::rename(temporary, file, failed);
  const bool kept = written && !failed;
  if (!kept) fs::remove(temporary, failed);
  return kept;
}

}  // namespace argil::studio
