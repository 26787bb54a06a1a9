#pragma once
// Plugins for tests: the examples as they were built, and bad ones.

#include <filesystem>
#include <fstream>
#include <string>

#include "engine/plugins/plugin.h"

namespace argil::tests {

/// The folder of a built example, "soften".
inline std::filesystem::path examplePlugin(const std::string& name) {
  return std::filesystem::path(ARGIL_PLUGINS) / (name + ".argil-plugin");
}

/// Writes the folder of a bad plugin into `folder`: its library as tests/support/plugins/bad.c was compiled for `name`.
inline std::filesystem::path badPlugin(const std::filesystem::path& folder, const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path made = folder / (name + std::string(engine::kPluginEnding));
  fs::create_directories(made / engine::kPluginMachine);
  fs::copy_file(fs::path(ARGIL_BAD_PLUGINS) / ("bad_" + name + ".so"), made / engine::kPluginMachine / "bad.so",
                fs::copy_options::overwrite_existing);
  std::ofstream(made / engine::kPluginFile) << R"({"format": 1, "id": "test.bad.)" << name << R"(", "name": "Bad )"
                                            << name << R"(", "version": "1.0.0", "licence": "CC0-1.0",
    "help": "For tests.", "library": "bad.so", "brushes": [{"id": "brush", "name": "Brush test", "help": "Raises a little.",
    "bricks": {"margin": 1, "leaves": "values"}, "adds": true}]})";
  return made;
}

/// The only brush of the library of a plugin's folder, in processes of its own.
inline std::shared_ptr<const engine::PluginBrush> brushIn(const std::filesystem::path& folder,
                                                          const engine::PluginLimits& limits = {}) {
  const engine::Plugin plugin = engine::readPlugin(folder);
  return std::make_shared<const engine::PluginBrush>(
      plugin.brushes.at(0).facts.value(),
      std::make_shared<engine::PluginProcesses>(engine::libraryOf(plugin, folder, {}), limits));
}

}  // namespace argil::tests
