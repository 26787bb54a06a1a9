#include "engine/models/script_file.h"

#include <variant>

#include "engine/models/tool_file.h"
#include "engine/tools/tool_table.h"
#include "io/bytes/input.h"

namespace argil::engine {

Script readScript(const std::filesystem::path& path) {
  const io::FileBytes file = io::readFile(path);
  Script script = parseScript({reinterpret_cast<const char*>(file.data.get()), file.size}, io::displayName(path));
  if (auto* import = std::get_if<ImportSetup>(&script.clay)) import->file = path.parent_path() / import->file;
  for (ScriptStroke& stroke : script.strokes) {
    if (!stroke.tool.file.empty()) stroke.tool.file = (path.parent_path() / stroke.tool.file).string();
    if (rowOf(stroke.tool).file != ToolFile::none) loadToolFile(stroke.tool);
  }
  return script;
}

}  // namespace argil::engine
