#include "ui3d/studio/view/face.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"

namespace argil::studio {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Vec3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

const Json& member(const Json& json, const char* name) {
  static const Json none;
  if (!json.is_object()) return none;
  const auto found = json.find(name);
  return found == json.end() ? none : *found;
}

bool take(const Json& json, Vec3d& into) {
  if (!json.is_array() || json.size() != 3) return false;
  Vec3d read;
  for (size_t i = 0; i < 3; ++i) {
    if (!json[i].is_number()) return false;
    read[Eigen::Index(i)] = json[i].get<double>();
  }
  if (!read.allFinite()) return false;
  into = read;
  return true;
}

bool takeView(const Json& json, Camera& camera) {
  render::View view = camera.view();
  if (!take(member(json, "position"), view.position) || !take(member(json, "target"), view.target)) return false;
  take(member(json, "up"), view.up);
  if (const Json& opening = member(json, "opening"); opening.is_number()) view.openingDegrees = opening.get<double>();
  if (const Json& parallel = member(json, "orthographic"); parallel.is_boolean())
    view.projection = parallel.get<bool>() ? render::Projection::orthographic : render::Projection::perspective;
  try {
    // Beyond that a zoom would not get back.
    if (!(view.heightAtTarget() >= Camera::kLeastHeightMm && view.heightAtTarget() <= Camera::kMostHeightMm))
      return false;
    camera.set(view);
  } catch (const Error&) {
    return false;
  }
  return true;
}

void takeSection(const Json& json, StudioState& state) {
  render::Section section;
  if (!take(member(json, "point"), section.pointMm) || !take(member(json, "normal"), section.normal)) return;
  const double length = section.normal.norm();
  if (!(length > 1e-6 && std::isfinite(length))) return;
  section.normal /= length;
  state.section = section;
  state.look.section.reset();
  if (const Json& shown = member(json, "shown"); shown.is_boolean() && shown.get<bool>()) state.look.section = section;
}

void takeTool(const Json& json, StudioState& state) {
  const Json& id = member(json, "id");
  const engine::ToolRow* row = id.is_string() ? engine::findTool(id.get<std::string>()) : nullptr;
  if (!row) return;
  state.toolId = row->id;
  engine::Tool& tool = state.tool();
  for (const auto& parameter : row->parameters) {
    const Json& value = member(member(json, "numbers"), std::string(parameter.id).c_str());
    if (!value.is_number()) continue;
    const double number = value.get<double>();
    if (number >= parameter.low && number <= parameter.high) parameter.change(tool, number);
  }
}

}  // namespace

std::string faceText(const StudioState& state, const Camera& camera) {
  const render::View& view = camera.view();
  Json json;
  json["view"] = {{"position", numbers(view.position)},
                  {"target", numbers(view.target)},
                  {"up", numbers(view.up)},
                  {"opening", view.openingDegrees},
                  {"orthographic", view.projection == render::Projection::orthographic}};
  if (const auto& section = state.look.section ? state.look.section : state.section)
    json["section"] = {{"point", numbers(section->pointMm)},
                       {"normal", numbers(section->normal)},
                       {"shown", state.look.section.has_value()}};
  json["shading"] = render::shadingNames()[size_t(state.look.shading)];
  json["matcap"] = render::matcapNames()[size_t(state.look.matcap)];
  json["tool"]["id"] = state.toolId;
  const auto tool = state.tools.find(state.toolId);
  if (const engine::ToolRow* row = engine::findTool(state.toolId); row && tool != state.tools.end())
    for (const auto& parameter : row->parameters)
      json["tool"]["numbers"][std::string(parameter.id)] = parameter.get(tool->second);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool applyFace(const std::string& text, StudioState& state, Camera& camera) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  // A document that was saved without a section is not to be seen through that of another.
  state.section.reset();
  state.look.section.reset();
  takeSection(member(json, "section"), state);
  if (const Json& name = member(json, "shading"); name.is_string())
    if (const auto shading = render::shadingNamed(name.get<std::string>())) state.look.shading = *shading;
  if (const Json& name = member(json, "matcap"); name.is_string())
    if (const auto matcap = render::matcapNamed(name.get<std::string>())) state.look.matcap = *matcap;
  takeTool(member(json, "tool"), state);
  return takeView(member(json, "view"), camera);
}

}  // namespace argil::studio
