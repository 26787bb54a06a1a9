#include "engine/text/formula_tool_text.h"

#include <algorithm>
#include <array>
#include <vector>

#include "clay/base/error.h"

namespace argil::engine {

namespace {

constexpr std::array<std::pair<std::string_view, clay::Falloff>, 5> kFalloffs{{{"constant", clay::Falloff::constant},
                                                                               {"smooth", clay::Falloff::smooth},
                                                                               {"linear", clay::Falloff::linear},
                                                                               {"sharp", clay::Falloff::sharp},
                                                                               {"dome", clay::Falloff::dome}}};
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kUnits{
    {{"mm", "mm"}, {"share", "share"}, {"°", "°"}, {"", ""}}};

AddedTool::Number numberOf(const Place& place) {
  place.keys({"id", "name", "help", "unit", "low", "high", "standard", "logarithmic"});
  AddedTool::Number number;
  number.id = place.at("id").text();
  number.name = place.at("name").text();
  number.help = place.at("help").text();
  if (const auto unit = place.maybe("unit")) number.unit = unit->oneOf<std::string_view>(kUnits);
  number.low = place.at("low").number(-kMaxMm, kMaxMm);
  number.high = place.at("high").number(-kMaxMm, kMaxMm);
  number.standard = place.at("standard").number(-kMaxMm, kMaxMm);
  if (const auto logarithmic = place.maybe("logarithmic")) number.logarithmic = logarithmic->truth();
  return number;
}

}  // namespace

std::vector<AddedTool::Number> readNumbers(const Place& place) {
  std::vector<AddedTool::Number> numbers;
  for (const Place& each : place.items()) numbers.push_back(numberOf(each));
  return numbers;
}

nlohmann::ordered_json formulaToolJson(const AddedTool& tool) {
  nlohmann::ordered_json json{{"name", tool.name}, {"help", tool.help}};
  if (!tool.icon.empty()) json["icon"] = tool.icon;
  json["formula"] = tool.formula;
  for (const AddedTool::Number& number : tool.numbers) {
    nlohmann::ordered_json each{{"id", number.id}, {"name", number.name}, {"help", number.help}};
    if (!number.unit.empty()) each["unit"] = number.unit;
    each.update({{"low", number.low}, {"high", number.high}, {"standard", number.standard}});
    if (number.logarithmic) each["logarithmic"] = true;
    json["numbers"].push_back(std::move(each));
  }
  const auto falloff =
      std::find_if(kFalloffs.begin(), kFalloffs.end(), [&](const auto& each) { return each.second == tool.falloff; });
  json["falloff"] = falloff->first;
  json["strength"] = tool.strength;
  if (tool.inverts) json["inverts"] = true;
  if (tool.adds) json["adds"] = true;
  return json;
}

AddedTool readFormulaTool(const Place& place, std::string id, std::initializer_list<std::string_view> others) {
  AddedTool tool = readToolFacts(place, std::move(id), others);
  tool.formula = place.at("formula").text();
  requireTool(place, tool);
  return tool;
}

AddedTool readToolFacts(const Place& place, std::string id, std::initializer_list<std::string_view> others) {
  std::vector<std::string_view> keys(others);
  keys.insert(keys.end(), {"name", "help", "icon", "formula", "numbers", "falloff", "strength", "inverts", "adds"});
  place.keys(keys);
  AddedTool tool;
  tool.id = std::move(id);
  tool.name = place.at("name").text();
  tool.help = place.at("help").text();
  if (const auto icon = place.maybe("icon")) tool.icon = icon->text();
  if (const auto numbers = place.maybe("numbers")) tool.numbers = readNumbers(*numbers);
  if (const auto falloff = place.maybe("falloff")) tool.falloff = falloff->oneOf<clay::Falloff>(kFalloffs);
  if (const auto strength = place.maybe("strength")) tool.strength = strength->number(0, 1);
  if (const auto inverts = place.maybe("inverts")) tool.inverts = inverts->truth();
  if (const auto adds = place.maybe("adds")) tool.adds = adds->truth();
  return tool;
}

void requireTool(const Place& place, const AddedTool& tool) {
  try {
    checkTool(tool);
  } catch (const Error& error) {
    place.fail(error.what());
  }
}

}  // namespace argil::engine
