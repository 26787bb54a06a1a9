#include "engine/text/tool_text.h"

#include <algorithm>
#include <cmath>

#include "engine/text/formula_tool_text.h"
#include "engine/text/parameter_text.h"
#include "engine/text/quality_text.h"
#include "engine/tools/added_tools.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

using nlohmann::ordered_json;

constexpr double kMostTurn = 360;

// What a slider spans is not what a script may ask for: its clay may be a watch or a ship.
void read(const Parameter<Tool>& parameter, const Place& place, Tool& tool) {
  if (parameter.unit == "mm")
    return parameter.set(tool, parameter.id == "radius" ? place.positive() : place.number(0, kMaxMm));
  if (parameter.unit == "°") return parameter.set(tool, place.number(-kMostTurn, kMostTurn));
  readValue(parameter, place, tool, parameter.id == "strength" ? 0 : parameter.low, parameter.high);
}

const ToolRow& rowAt(const Place& place) {
  const Place id = place.at("tool");
  // What brings its formula along needs no plugin.
  if (const auto brush = place.maybe("brush")) return addedTools().addBeside(readFormulaTool(*brush, id.text()));
  const ToolRow* row = findTool(id.text());
  if (!row) {
    if (const std::string why = addedTools().whyNot(id.text()); !why.empty()) id.fail(why);
    std::string known;
    for (const ToolRow& each : toolTable()) known += (known.empty() ? "" : ", ") + std::string(each.id);
    id.fail(fmt::format("unknown {}; known are {}", io::shown(id.text()), known));
  }
  if (const auto plugin = place.maybe("plugin"); plugin && row->origin && !row->formula) {
    // What another version would make of it nobody knows.
    plugin->keys({"id", "version", "checksum"});
    if (plugin->at("checksum").text() != row->origin->checksum)
      plugin->fail(fmt::format("needs {} {}, and {} is enabled; leave \"plugin\" out to use that",
                               io::shown(plugin->at("id").text()), io::shown(plugin->at("version").text()),
                               row->origin->version));
  }
  return *row;
}

Vec3d six(const std::vector<Place>& numbers, size_t first) {
  Vec3d v;
  for (int axis = 0; axis < 3; ++axis) v[axis] = numbers[first + size_t(axis)].number(-kMaxMm, kMaxMm);
  return v;
}

}  // namespace

uint32_t readColour(const Place& place) {
  const std::string& text = place.text();
  uint32_t colour = 0;
  bool good = text.size() == 7 && text[0] == '#';
  for (size_t i = 1; good && i < 7; ++i) {
    const char c = text[i];
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                             : -1;
    good = digit >= 0;
    colour = colour * 16 + uint32_t(digit);
  }
  if (!good) place.fail("must be a colour such as \"#c8402e\"");
  return colour;
}

void putTool(ordered_json& object, const Tool& tool, const StrokeQuality& usual) {
  const ToolRow& row = rowOf(tool);
  const Tool standard = scriptTool(row);
  object["tool"] = row.id;
  for (const Parameter<Tool>& parameter : row.parameters) {
    const double value = parameter.get(tool);
    if (!std::isfinite(value)) throw Error("a script cannot hold a number that is not finite", Error::Kind::work);
    if (parameter.id == "radius" || value != parameter.get(standard))
      object[keyOf(parameter)] = valueOf(parameter, tool);
  }
  if (tool.inverted) object["inverted"] = true;
  if (row.file != ToolFile::none) object["file"] = tool.file;
  if (const AddedTool* added = addedTools().addedAs(row)) {
    if (!AddedTools::repeats(*added))
      object["plugin"] = {{"id", row.origin->id}, {"version", row.origin->version}, {"checksum", row.origin->checksum}};
    else
      object["brush"] = formulaToolJson(*added);
  }
  if (!(tool.quality == usual)) object["quality"] = strokeQualityJson(tool.quality);
}

void checkToolKeys(const Place& place, std::vector<std::string_view> others) {
  if (!place.value().is_object()) place.fail("must be an object {...}");
  const ToolRow& row = rowAt(place);
  std::vector<std::string> keys;
  keys.reserve(row.parameters.size());
  for (const Parameter<Tool>& parameter : row.parameters) keys.push_back(keyOf(parameter));
  others.insert(others.end(), keys.begin(), keys.end());
  others.insert(others.end(), {"tool", "inverted", "quality"});
  if (row.file != ToolFile::none) others.push_back("file");
  if (row.formula) others.push_back("brush");
  if (row.origin && !row.formula) others.push_back("plugin");
  place.keys(others);
}

Tool readTool(const Place& place, const StrokeQuality& usual) {
  const ToolRow& row = rowAt(place);
  Tool tool = scriptTool(row);
  tool.quality = usual;
  if (const auto quality = place.maybe("quality")) tool.quality = readStrokeQuality(*quality);
  (void)place.at("radius_mm");
  for (const Parameter<Tool>& parameter : row.parameters) {
    const std::string key = keyOf(parameter);
    if (const auto value = place.maybe(key.c_str())) read(parameter, *value, tool);
  }
  if (const auto inverted = place.maybe("inverted")) tool.inverted = inverted->truth();
  if (tool.inverted && row.opposite != row.id)
    place.at("inverted").fail(fmt::format("{} cannot be inverted; its opposite is {}", row.id, row.opposite));
  if (row.file != ToolFile::none) {
    if (const auto file = place.maybe("file")) tool.file = file->text();
  }
  return tool;
}

void putImages(ordered_json& object, const StrokeImages& images, const char* mirrorKey) {
  for (const MirrorPlane& mirror : images.mirrors) {
    const Vec3d &p = mirror.pointMm, &n = mirror.normal;
    if (!p.allFinite() || !n.allFinite())
      throw Error("a script cannot hold a number that is not finite", Error::Kind::work);
    object[mirrorKey].push_back({p.x(), p.y(), p.z(), n.x(), n.y(), n.z()});
  }
  if (images.turns > 1) {
    const Vec3d &p = images.axisPointMm, &a = images.axis;
    object["radial"] = {{"turns", images.turns}, {"axis", {p.x(), p.y(), p.z(), a.x(), a.y(), a.z()}}};
  }
}

StrokeImages readImages(const Place& place, const char* mirrorKey) {
  StrokeImages images;
  if (const auto planes = place.maybe(mirrorKey)) {
    for (const Place& plane : planes->items()) {
      const auto numbers = plane.items();
      if (numbers.size() != 6)
        plane.fail(fmt::format("must be 6 numbers [px, py, pz, nx, ny, nz], and has {}", numbers.size()));
      images.mirrors.push_back({six(numbers, 0), six(numbers, 3)});
      if (!(images.mirrors.back().normal.norm() > 1e-6))
        plane.fail("its normal is no direction; [0, 0, 0, 1, 0, 0] mirrors in x");
    }
    if (images.mirrors.size() > kMostMirrors) planes->fail(fmt::format("at most {} planes", kMostMirrors));
  }
  if (const auto radial = place.maybe("radial")) {
    radial->keys({"turns", "axis"});
    images.turns = int(radial->at("turns").number(1, kMostTurns));
    const auto numbers = radial->at("axis").items();
    if (numbers.size() != 6)
      radial->at("axis").fail(fmt::format("must be 6 numbers [px, py, pz, ax, ay, az], and has {}", numbers.size()));
    images.axisPointMm = six(numbers, 0);
    images.axis = six(numbers, 3);
    if (!(images.axis.norm() > 1e-6)) radial->at("axis").fail("is no direction; [0, 0, 0, 0, 0, 1] turns about z");
  }
  return images;
}

}  // namespace argil::engine
