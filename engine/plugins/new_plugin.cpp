#include "engine/plugins/new_plugin.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "clay/base/error.h"
#include "engine/plugins/plugin.h"
#include "engine/plugins/plugin_templates.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"

namespace argil::engine {

namespace fs = std::filesystem;

namespace {

void replaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

void write(const fs::path& file, std::string_view text) {
  io::AtomicFile atomic(file);
  atomic.write(std::as_bytes(std::span(text)));
  atomic.commit(false);
}

// A stroke over the top of a ball.
std::string trial(const std::string& tool) {
  return fmt::format(R"({{"argil": 1, "units": "mm",
 "setup": [{{"voxel_mm": 0.25}}, {{"sphere": {{"radius_mm": 20}}}}],
 "strokes": [{{"tool": "{}", "radius_mm": 5, "path": [[0, -10, 0, 17.3], [0.5, 0, 0, 20], [1, 10, 0, 17.3]]}}]}}
)",
                     tool);
}

}  // namespace

void newPlugin(std::string_view kind, const fs::path& given) {
  const PluginTemplate* plan = findPluginTemplate(kind);
  if (!plan)
    throw Error(fmt::format("plugins new {}: known are formula, brush, texture, operation, format, guide, device",
                            io::shown(kind)));
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (fs::exists(folder)) throw Error(fmt::format("{} is there already: give another name", folder.string()));
  const std::string title =
      folder.filename().string().ends_with(kPluginEnding) ? folder.stem().string() : folder.filename().string();
  std::string name = title.substr(0, 30);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return std::isalnum(c) ? char(std::tolower(c)) : '-'; });
  // Nothing of a name that is not plain reaches the texts.
  const std::string id = "local." + name;
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) throw Error(fmt::format("{}: {}", folder.string(), problem.message()));
  for (const PluginTemplate::File& file : plan->files) {
    std::string text(file.text);
    replaceAll(text, plan->id, id);
    replaceAll(text, plan->name, name);
    write(folder / file.name, text);
  }
  if (!plan->brush.empty()) write(folder / "try.json", trial(fmt::format("{}.{}", id, plan->brush)));
  (void)readPlugin(folder);
}

}  // namespace argil::engine
