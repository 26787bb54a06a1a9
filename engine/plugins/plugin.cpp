#include "engine/plugins/plugin.h"

#include <sha256.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "engine/text/formula_tool_text.h"
#include "engine/text/json_text.h"
#include "engine/text/script_place.h"
#include "io/bytes/atomic_file.h"

namespace argil::engine {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostBytes = 1 << 20, kMostBrushes = 100;
std::string checksumOf(std::string_view text) {
  char digits[SHA256_DIGEST_STRING_LENGTH];
  return SHA256Data(reinterpret_cast<const uint8_t*>(text.data()), text.size(), digits);
}

std::string idOf(const Place& place) {
  const std::string& id = place.text();
  const bool dots = id.find('.') != std::string::npos && id.front() != '.' && id.back() != '.';
  const bool letters = std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
  });
  if (id.size() > 40 || !dots || !letters)
    place.fail(
        fmt::format("{}: give 40 small letters, digits, '-' and '_' at most, with a '.', such as "
                    "\"org.example.ripples\"",
                    io::shown(id)));
  return id;
}

}  // namespace

Plugin parsePlugin(std::string_view text, const std::string& name) {
  const nlohmann::json json = parseJson(text, name, "a plugin is {...}");
  const Place root(json, name, "");
  root.keys({"format", "id", "name", "version", "licence", "help", "brushes"});
  if (const double format = root.at("format").number(1, 1e6); format != kPluginFormat)
    root.at("format").fail(fmt::format("{:g} is of a newer Argil; this one knows {}", format, kPluginFormat));
  Plugin plugin;
  plugin.id = idOf(root.at("id"));
  plugin.name = root.at("name").text();
  plugin.version = root.at("version").text();
  plugin.licence = root.at("licence").text();
  plugin.help = root.at("help").text();
  const std::vector<Place> brushes = root.at("brushes").items();
  if (brushes.empty() || brushes.size() > kMostBrushes)
    root.at("brushes").fail(fmt::format("{} of them: give 1 to {}", brushes.size(), kMostBrushes));
  for (const Place& each : brushes) {
    plugin.brushes.push_back(readFormulaTool(each, plugin.id + "." + each.at("id").text(), {"id"}));
    plugin.brushes.back().plugin = plugin.id;
    for (size_t i = 0; i + 1 < plugin.brushes.size(); ++i)
      if (plugin.brushes[i].id == plugin.brushes.back().id) each.at("id").fail("another brush has that id");
  }
  plugin.checksum = checksumOf(text);
  return plugin;
}

Plugin readPlugin(const fs::path& folder) {
  const fs::path file = folder / kPluginFile;
  if (std::error_code problem; fs::file_size(file, problem) > kMostBytes && !problem)
    throw Error(fmt::format("{}: {} bytes and more: {} is the most", file.string(), kMostBytes, kMostBytes));
  const io::FileBytes content = io::readFile(file);
  const io::Input input{content.bytes(), file.string()};
  return parsePlugin(input.text(), file.string());
}

void newPlugin(std::string_view kind, const fs::path& folder) {
  if (kind != "formula") throw Error(fmt::format("plugins new {}: known are formula", io::shown(std::string(kind))));
  if (fs::exists(folder)) throw Error(fmt::format("{} is there already: give another name", folder.string()));
  const std::string title =
      folder.filename().string().ends_with(kPluginEnding) ? folder.stem().string() : folder.filename().string();
  std::string name = title;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return std::isalnum(c) ? char(std::tolower(c)) : '-'; });
  const std::string text = fmt::format(R"json({{
  "format": 1,
  "id": "local.{}",
  "name": "{}",
  "version": "1.0.0",
  "licence": "CC0-1.0",
  "help": "Says in one line what it is for.",
  "brushes": [
    {{
      "id": "ripple",
      "name": "Ripple",
      "help": "Draws rings around the path of the tip.",
      "formula": "phi - height * weight * sin(6.2832 * r * radius / pitch)",
      "falloff": "smooth",
      "strength": 0.5,
      "inverts": true,
      "numbers": [
        {{"id": "height", "name": "Height", "help": "Of a ring, each stamp.", "unit": "mm", "low": 0.001, "high": 10,
         "standard": 0.1, "logarithmic": true}},
        {{"id": "pitch", "name": "Pitch", "help": "From ring to ring.", "unit": "mm", "low": 0.01, "high": 100,
         "standard": 2, "logarithmic": true}}
      ]
    }}
  ]
}}
)json",
                                       name.substr(0, 30), title.substr(0, 60));
  (void)parsePlugin(text, (folder / kPluginFile).string());
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) throw Error(fmt::format("{}: {}", folder.string(), problem.message()));
  io::AtomicFile file(folder / kPluginFile);
  file.write(std::as_bytes(std::span(text)));
  file.commit(false);
}

}  // namespace argil::engine
