// argil tools: the table of tools, and the scene of one; the table of operations.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "engine/session/tool_demo.h"
#include "engine/text/operation_text.h"
#include "engine/text/parameter_text.h"
#include "engine/text/script.h"
#include "engine/text/script_page.h"
#include "engine/tools/tool_table.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

void print(bool json) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string_view group;
  for (const engine::ToolRow& row : engine::toolTable()) {
    if (json) {
      nlohmann::ordered_json each{
          {"id", row.id}, {"name", row.name}, {"group", row.group}, {"help", row.help}, {"opposite", row.opposite}};
      for (const auto& parameter : row.parameters)
        each["parameters"].push_back({{"id", parameter.id},
                                      {"name", parameter.name},
                                      {"help", parameter.help},
                                      {"values", engine::valuesOf(parameter)}});
      rows.push_back(each);
      continue;
    }
    if (row.group != group) fmt::print("{}{}\n", group.empty() ? "" : "\n", row.group);
    group = row.group;
    std::string own;
    for (const auto& parameter : engine::ownParameters(row))
      own += (own.empty() ? "" : ", ") + std::string(parameter.id);
    fmt::print("  {:<12} {:<15} {} ({})\n", row.id, row.name, row.help, own);
  }
  if (json) fmt::print("{}\n", rows.dump(2));
}

// What a script may say of an operation.
void printOperations(bool json) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string_view group;
  for (const engine::PieceJob& row : engine::pieceJobs()) {
    if (json) {
      nlohmann::ordered_json each{{"id", row.id},     {"name", row.name},     {"group", row.group},
                                  {"help", row.help}, {"pieces", row.pieces}, {"takes", engine::keysOf(row)}};
      each["parameters"] = nlohmann::ordered_json::array();
      for (const auto& parameter : row.parameters)
        each["parameters"].push_back({{"key", engine::keyOf(parameter)},
                                      {"name", parameter.name},
                                      {"help", parameter.help},
                                      {"values", engine::valuesOf(parameter)},
                                      {"standard", engine::scriptValue(parameter, parameter.standard)}});
      rows.push_back(each);
      continue;
    }
    if (row.group != group) fmt::print("{}{}\n", group.empty() ? "" : "\n", row.group);
    group = row.group;
    fmt::print("  {:<14} {}\n", row.id, row.help);
    for (const auto& parameter : row.parameters) {
      const auto standard = engine::scriptValue(parameter, parameter.standard);
      fmt::print("    {:<16} {:<22} {}: {}\n", engine::keyOf(parameter), engine::valuesOf(parameter),
                 standard.is_number() ? fmt::format("{:g}", parameter.standard) : standard.dump(), parameter.help);
    }
    fmt::print("    {}\n", fmt::join(engine::keysOf(row), ", "));
  }
  if (json) fmt::print("{}\n", rows.dump(2));
}

void printQuality(bool json) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const auto shown = [](const engine::Parameter<engine::Quality>& row, double value) -> std::string {
    const auto as = engine::scriptValue(row, value);
    return as.is_number() ? fmt::format("{:g}", value) : as.is_string() ? as.get<std::string>() : as.dump();
  };
  if (!json) fmt::print("{:<18} {:<22} {:>8} {:>8} {:>8}\n", "", "", "draft", "balanced", "fine");
  std::string_view part;
  for (const engine::QualityAxis& axis : engine::qualityAxes()) {
    const auto& row = axis.row;
    if (json) {
      nlohmann::ordered_json each{{"part", engine::nameOf(axis.part)},
                                  {"id", row.id},
                                  {"name", row.name},
                                  {"help", row.help},
                                  {"unit", row.unit},
                                  {"low", row.low},
                                  {"high", row.high},
                                  {"begins", row.get({})}};
      for (const engine::QualityPreset& preset : engine::qualityPresets())
        each[std::string(preset.id)] = row.get(preset.quality);
      rows.push_back(each);
      continue;
    }
    if (engine::nameOf(axis.part) != part) fmt::print("{}\n", engine::nameOf(axis.part));
    part = engine::nameOf(axis.part);
    fmt::print("  {:<16} {:<22}", row.id, engine::valuesOf(row));
    for (const engine::QualityPreset& preset : engine::qualityPresets())
      fmt::print(" {:>8}", shown(row, row.get(preset.quality)));
    fmt::print("  {}\n", row.help);
  }
  if (json) fmt::print("{}\n", rows.dump(2));
}

}  // namespace

void tools(const ToolsOptions& options) {
  if (options.scripts) {
    fmt::print("{}", engine::scriptPage());
    return;
  }
  if (options.quality) return printQuality(options.json);
  if (options.operations) {
    if (!options.demo.empty()) throw Error("--operations and --demo: give one of them; a scene shows a tool");
    if (!options.ids) return printOperations(options.json);
    for (const engine::PieceJob& row : engine::pieceJobs()) fmt::print("{}\n", row.id);
    return;
  }
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
