#pragma once
// Rows of the tool table by plugins, as the program has them once they are enabled.

#include "engine/tools/tool_table.h"
#include "tests/support/plugins/plugin_folders.h"

namespace argil::tests {

/// The tool of the only brush of a plugin's folder, added to the table when it is asked for the first time. Of equal
/// folders' brushes there is one.
inline engine::Tool pluginTool(const std::filesystem::path& folder, const engine::PluginLimits& limits = {}) {
  const engine::Plugin plugin = engine::readPlugin(folder);
  engine::AddedTool tool = plugin.brushes.at(0).tool;
  if (const engine::ToolRow* row = engine::findTool(tool.id)) return engine::standardTool(*row);
  if (plugin.brushes[0].facts) tool.external = brushIn(folder, limits);
  return engine::standardTool(engine::addedTools().add(tool));
}

}  // namespace argil::tests
