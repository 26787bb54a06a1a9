// argil plugins: what is there, and what to do with one.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "engine/plugins/check_plugin.h"
#include "engine/plugins/new_plugin.h"
#include "engine/plugins/plugins.h"
#include "engine/text/parameter_text.h"
#include "engine/tools/tool_table.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

using engine::FoundPlugin;
using engine::PluginState;

nlohmann::ordered_json jsonOf(const FoundPlugin& found) {
  nlohmann::ordered_json json{{"folder", found.folder.string()}, {"state", engine::nameOf(found.state)}};
  if (found.state == PluginState::broken) {
    json["problem"] = found.problem;
    return json;
  }
  const engine::Plugin& plugin = found.plugin;
  json.update({{"id", plugin.id},
               {"name", plugin.name},
               {"version", plugin.version},
               {"licence", plugin.licence},
               {"help", plugin.help},
               {"checksum", plugin.checksum},
               {"brings", nlohmann::ordered_json::array()}});
  for (const engine::Brought& brought : engine::broughtBy(plugin)) {
    nlohmann::ordered_json numbers = nlohmann::ordered_json::array();
    for (const auto& number : brought.numbers)
      numbers.push_back({{"id", number.id},
                         {"name", number.name},
                         {"help", number.help},
                         {"unit", number.unit},
                         {"low", number.low},
                         {"high", number.high},
                         {"standard", number.standard}});
    nlohmann::ordered_json each{
        {"kind", brought.kind}, {"id", brought.id}, {"name", brought.name}, {"help", brought.help}};
    if (!brought.formula.empty()) each["formula"] = brought.formula;
    each["numbers"] = std::move(numbers);
    json["brings"].push_back(std::move(each));
  }
  return json;
}

// "2 brushes, 1 guide".
std::string counted(const engine::Plugin& plugin) {
  std::string text;
  const std::vector<engine::Brought> all = engine::broughtBy(plugin);
  for (auto first = all.begin(); first != all.end();) {
    const auto last = std::find_if(first, all.end(), [&](const engine::Brought& b) { return b.kind != first->kind; });
    const auto count = last - first;
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", count, first->kind,
                        count == 1               ? ""
                        : first->kind == "brush" ? "es"
                                                 : "s");
    first = last;
  }
  return text;
}

void list(const engine::Plugins& plugins, bool json) {
  if (json) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const FoundPlugin& each : plugins.found()) all.push_back(jsonOf(each));
    fmt::print("{}\n", all.dump(2));
    return;
  }
  if (!plugins.problem().empty()) fmt::print("{}\n", plugins.problem());
  if (plugins.found().empty()) {
    fmt::print("There are no plugins. They are looked for in\n");
    for (const auto& folder : engine::pluginFolders()) fmt::print("  {}\n", folder.string());
  }
  for (const FoundPlugin& each : plugins.found()) {
    if (each.state == PluginState::broken)
      fmt::print("{:<28} {}: {}\n", each.folder.stem().string(), engine::nameOf(each.state), each.problem);
    else
      fmt::print("{:<28} {}: {} {}, {}. {} ({})\n", each.plugin.id, engine::nameOf(each.state), each.plugin.name,
                 each.plugin.version, counted(each.plugin), each.plugin.help, each.folder.string());
  }
}

void describe(const engine::Plugins& plugins, const std::string& id, bool json) {
  const FoundPlugin* found = plugins.find(id);
  if (!found) throw Error(fmt::format("there is no plugin {}; argil plugins lists those that are there", id));
  if (json) {
    fmt::print("{}\n", jsonOf(*found).dump(2));
    return;
  }
  const engine::Plugin& plugin = found->plugin;
  fmt::print("{} {} ({}), {}\n{}\n", plugin.name, plugin.version, plugin.id, engine::nameOf(found->state), plugin.help);
  fmt::print("  folder      {}\n  licence     {}\n  checksum    {}\n", found->folder.string(), plugin.licence,
             plugin.checksum);
  fmt::print("{}\n", engine::mayOf(plugin));
  if (!plugin.library.empty())
    fmt::print("  library     {}\n", engine::libraryOf(plugin, found->folder, {}).file.string());
  for (const engine::Brought& brought : engine::broughtBy(plugin)) {
    fmt::print("\n{}: a {} ({})\n  {}\n", brought.name, brought.kind, brought.id, brought.help);
    if (!brought.formula.empty()) fmt::print("  formula     {}\n", brought.formula);
    for (const auto& number : brought.numbers)
      fmt::print("  {:<11} {:g} to {:g}{}{}, {:g}: {}\n", number.id, number.low, number.high,
                 number.unit.empty() ? "" : " ", number.unit, number.standard, number.help);
  }
}

}  // namespace

void plugins(const PluginsOptions& options) {
  if (!options.make.empty()) {
    const std::string& folder = options.make[1];
    engine::newPlugin(options.make[0], folder);
    const auto has = [&](const char* file) { return std::filesystem::exists(std::filesystem::path(folder) / file); };
    fmt::print(
        "{} is there.{} argil plugins check {} tries it{}, once it lies in one of the folders that argil plugins "
        "names and is enabled.\n",
        folder, has("build.sh") ? fmt::format(" sh {}/build.sh compiles it.", folder) : "", folder,
        has("try.json") ? fmt::format("; {}/try.json uses it", folder) : "; it is used");
    return;
  }
  if (!options.check.empty()) {
    bool good = true;
    for (const engine::PluginCheck& check : engine::checkPlugin(options.check)) {
      const std::string& more = check.problem.empty() ? check.measured : check.problem;
      fmt::print("{} {}{}{}\n", check.problem.empty() ? "ok    " : "FAILED", check.name, more.empty() ? "" : ": ",
                 more);
      good = good && check.problem.empty();
    }
    if (!good) throw Error(fmt::format("{}: not as it should be", options.check), Error::Kind::work);
    return;
  }
  engine::Plugins plugins;
  plugins.compareLibraries();
  if (!options.enable.empty()) {
    plugins.enable(options.enable);
    fmt::print("{} is enabled. {}\n", options.enable, engine::mayOf(plugins.find(options.enable)->plugin));
  } else if (!options.disable.empty()) {
    plugins.disable(options.disable);
    fmt::print("{} is not enabled any longer\n", options.disable);
  } else if (!options.describe.empty()) {
    describe(plugins, options.describe, options.json);
  } else {
    list(plugins, options.json);
  }
}

}  // namespace argil::cli
