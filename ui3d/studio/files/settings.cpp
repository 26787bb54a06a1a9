#include "ui3d/studio/files/settings.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kLeastSizeMm = 1e-3, kMostSizeMm = 1e7;  // Of what tools may be sized for.

// Those over the picture begin closed.
bool remembered(const PanelRow& panel) {
  return panel.dock != Dock::middle;
}

struct LookSwitch {
  const char* name;
  bool render::Look::*member;
};
constexpr LookSwitch kLook[] = {{"cavity", &render::Look::cavity},
                                {"keyShadow", &render::Look::keyShadow},
                                {"cursorShadow", &render::Look::cursorShadow},
                                {"beam", &render::Look::beam},
                                {"depthFade", &render::Look::depthFade},
                                {"grid", &render::Look::grid},
                                {"scaleBar", &render::Look::scaleBar},
                                {"xray", &render::Look::xray},
                                {"lightBackground", &render::Look::lightBackground}};

void take(const Json& json, std::string_view name, bool& into) {
  if (const auto found = json.find(name); found != json.end() && found->is_boolean()) into = found->get<bool>();
}

template <class Number>
void take(const Json& json, const char* name, Number& into, double low, double high) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_number()) return;
  const double value = found->get<double>();
  if (value >= low && value <= high) into = Number(value);
}

template <class Choice>
void choose(const Json& json, const char* name, Choice& into, int count) {
  int value = int(into);
  take(json, name, value, 0, count - 1);
  into = Choice(value);
}

Json part(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

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
  json["theme"] = state.theme == Theme::light ? "light" : "dark";
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
  json["pointer_depth"] = state.pointerDepthMm;
  json["pen_curve"] = state.penCurve;
  json["size_by"] = int(state.sizeBy);
  json["sized_for_mm"] = state.sizedForMm;
  json["snap"] = state.snapWidgets;
  json["fold_panels"] = state.foldPanels;
  json["start_page"] = state.startPage;
  for (const PanelRow& panel : panelTable())
    if (remembered(panel)) json["panels"][panel.id] = state.shown.*panel.shown;
  Json& look = json["look"];
  look["shading"] = int(state.look.shading);
  look["matcap"] = int(state.look.matcap);
  look["cavity_strength"] = state.look.cavityStrength;
  look["fade_strength"] = state.look.depthFadeStrength;
  for (const LookSwitch& row : kLook) look[row.name] = state.look.*row.member;
  json["stereo"] = {{"mode", int(state.stereo.mode)},
                    {"eyes", state.stereo.eyeDistancePart},
                    {"convergence", state.stereo.convergencePart},
                    {"swap", state.stereo.swapEyes}};
  json["quality"] = {{"supersample", state.quality.supersample},
                     {"key_shadow", state.quality.keyShadow},
                     {"cavity", state.quality.cavity},
                     {"detail", state.quality.detailPixels},
                     {"shadow_pixels", state.quality.shadowPixels}};
  json["quality"]["grade"] = int(state.surface);
  const haptics::Quality& touch = state.touchQuality;
  json["touch"] = {{"steps", touch.contactSteps}, {"searches", touch.contactSearches}, {"smooth", touch.smoothNormals}};
  const haptics::Workspace& workspace = state.workspace;
  json["workspace"] = {{"scale", workspace.scale},
                       {"depth_mm", workspace.depthMm},
                       {"frame", int(workspace.frame)},
                       {"glide_mms", workspace.glideMms}};
  json["walls"] = {{"on", workspace.walls.on},
                   {"share", workspace.walls.share},
                   {"stiffness_nmm", workspace.walls.stiffnessNmm},
                   {"rest_mm", workspace.walls.restMm},
                   {"speed_mmsn", workspace.walls.speedMmsN}};
  json["keys"] = Json::object();
  for (const auto& [action, keys] : state.keys) json["keys"][action] = keys;
  json["recent"] = state.recentFiles;
  json["folder"] = state.lastFolder;
  json["undo_memory_gib"] = state.undoGiB;
  json["import"] = {{"voxel_given", state.imports.voxelGiven},
                    {"voxel", state.imports.voxelMm},
                    {"half_memory", state.imports.halfMemory}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool applySettings(const std::string& text, StudioState& state) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  if (const auto theme = json.find("theme"); theme != json.end() && theme->is_string())
    state.theme = *theme == "light" ? Theme::light : Theme::dark;
  double scale = state.interfaceScale;
  take(json, "interface_scale", scale, 0, 4);
  state.interfaceScale = scale == 0 || scale >= 0.75 ? float(scale) : 0;
  if (const auto tool = json.find("tool");
      tool != json.end() && tool->is_string() && engine::findTool(tool->get<std::string>()))
    state.toolId = tool->get<std::string>();
  take(json, "pen_curve", state.penCurve, -1, 1);
  choose(json, "size_by", state.sizeBy, 3);
  take(json, "sized_for_mm", state.sizedForMm, kLeastSizeMm, kMostSizeMm);
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
  take(json, "pointer_depth", state.pointerDepthMm, 0, 1);
  take(json, "snap", state.snapWidgets);
  take(json, "fold_panels", state.foldPanels);
  take(json, "start_page", state.startPage);
  const Json imports = part(json, "import"), panels = part(json, "panels"), look = part(json, "look"),
             stereo = part(json, "stereo"), quality = part(json, "quality"), touch = part(json, "touch"),
             workspace = part(json, "workspace"), walls = part(json, "walls");
  for (const PanelRow& panel : panelTable())
    if (remembered(panel)) take(panels, panel.id, state.shown.*panel.shown);
  choose(look, "shading", state.look.shading, 3);
  choose(look, "matcap", state.look.matcap, 6);
  take(look, "cavity_strength", state.look.cavityStrength, 0, 2);
  take(look, "fade_strength", state.look.depthFadeStrength, 0, 1);
  for (const LookSwitch& row : kLook) take(look, row.name, state.look.*row.member);
  choose(stereo, "mode", state.stereo.mode, 6);
  take(stereo, "eyes", state.stereo.eyeDistancePart, 0, 0.2);
  take(stereo, "convergence", state.stereo.convergencePart, 0.2, 5);
  take(stereo, "swap", state.stereo.swapEyes);
  take(quality, "supersample", state.quality.supersample, 1, 4);
  take(quality, "key_shadow", state.quality.keyShadow);
  take(quality, "cavity", state.quality.cavity);
  take(quality, "detail", state.quality.detailPixels, 0, 8);
  take(quality, "shadow_pixels", state.quality.shadowPixels, 256, 8192);
  choose(quality, "grade", state.surface, 3);
  take(touch, "steps", state.touchQuality.contactSteps, 1, 64);
  take(touch, "searches", state.touchQuality.contactSearches, 4, 200);
  take(touch, "smooth", state.touchQuality.smoothNormals);
  take(workspace, "scale", state.workspace.scale, 0.01, 100);
  take(workspace, "depth_mm", state.workspace.depthMm, -500, 500);
  choose(workspace, "frame", state.workspace.frame, 3);
  take(workspace, "glide_mms", state.workspace.glideMms, 0, 1000);
  take(walls, "on", state.workspace.walls.on);
  take(walls, "share", state.workspace.walls.share, 0.1, 1);
  take(walls, "stiffness_nmm", state.workspace.walls.stiffnessNmm, 0.01, 10);
  take(walls, "rest_mm", state.workspace.walls.restMm, 0, 10);
  take(walls, "speed_mmsn", state.workspace.walls.speedMmsN, 0, 1000);
  for (const auto& [action, shortcut] : keys.items())
    if (shortcut.is_string()) state.keys[action] = shortcut.get<std::string>();
  if (const auto recent = json.find("recent"); recent != json.end() && recent->is_array())
    for (const Json& file : *recent)
      if (file.is_string() && state.recentFiles.size() < StudioState::kMostRecent)
        state.recentFiles.push_back(file.get<std::string>());
  if (const auto folder = json.find("folder"); folder != json.end() && folder->is_string())
    state.lastFolder = folder->get<std::string>();
  take(json, "undo_memory_gib", state.undoGiB, 0, 64);
  take(imports, "voxel_given", state.imports.voxelGiven);
  take(imports, "voxel", state.imports.voxelMm, 0.01, 10);
  take(imports, "half_memory", state.imports.halfMemory);
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
  const fs::path temporary = file.string() + ".new";
  std::ofstream out(temporary);
  out << settingsText(state) << std::flush;
  if (!out) return false;
  out.close();
  fs::rename(temporary, file, failed);
  return !failed;
}

}  // namespace argil::studio
