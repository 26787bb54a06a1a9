// argil tools: the table of tools, and the scene of one.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clay/error.h"
#include "engine/script.h"
#include "engine/tool_demo.h"
#include "engine/tool_table.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

std::string unitOf(const engine::Parameter<engine::Tool>& parameter) {
  if (!parameter.choices.empty()) return fmt::format("{}", fmt::join(parameter.choices, " | "));
  if (parameter.unit == "on") return "true | false";
  if (parameter.unit == "colour") return "#rrggbb";
  return fmt::format("{:g} to {:g}{}", parameter.low, parameter.high, parameter.unit == "share" || parameter.unit.empty() ? "" : " " + std::string(parameter.unit));
}

void print(bool json) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string_view group;
  for (const engine::ToolRow& row : engine::toolTable()) {
    if (json) {
      nlohmann::ordered_json each{{"id", row.id}, {"name", row.name}, {"group", row.group}, {"help", row.help}, {"opposite", row.opposite}};
      for (const auto& parameter : row.parameters)
        each["parameters"].push_back({{"id", parameter.id}, {"name", parameter.name}, {"help", parameter.help}, {"values", unitOf(parameter)}});
      rows.push_back(each);
      continue;
    }
    if (row.group != group) fmt::print("{}{}\n", group.empty() ? "" : "\n", row.group);
    group = row.group;
    std::string own;
    for (const auto& parameter : engine::ownParameters(row)) own += (own.empty() ? "" : ", ") + std::string(parameter.id);
    fmt::print("  {:<12} {:<15} {} ({})\n", row.id, row.name, row.help, own);
  }
  if (json) fmt::print("{}\n", rows.dump(2));
}

}  // namespace

void tools(const ToolsOptions& options) {
  if (options.ids) {
    for (const engine::ToolRow& row : engine::toolTable()) fmt::print("{}\n", row.id);
    return;
  }
  if (options.demo.empty()) return print(options.json);
  const engine::ToolRow* row = engine::findTool(options.demo);
  if (!row) throw Error(fmt::format("--demo {}: there is no such tool; argil tools lists them", options.demo));
  fmt::print("{}", engine::formatScript(engine::toolDemo(*row)));
}

}  // namespace argil::cli
