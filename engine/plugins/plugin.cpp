#include "engine/plugins/plugin.h"

#include <sha256.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "engine/text/formula_tool_text.h"
#include "engine/text/json_text.h"
#include "engine/text/script_place.h"
#include "io/bytes/atomic_file.h"

namespace argil::engine {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostBytes = 1 << 20, kMostThings = 100;
constexpr std::array<std::pair<std::string_view, clay::Renew>, 3> kLeaves{
    {{"distances", clay::Renew::none}, {"slopes", clay::Renew::slopes}, {"values", clay::Renew::all}}};

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

// A name of a file, no path.
std::string libraryName(const Place& place) {
  const std::string& name = place.text();
  if (name.empty() || name.size() > 100 || name.front() == '.' || name.find('/') != std::string::npos)
    place.fail(fmt::format("{} is no name of a file", io::shown(name)));
  return name;
}

Plugin::Brush brushOf(const Place& place, const Plugin& plugin) {
  const std::string id = plugin.id + "." + place.at("id").text();
  const auto bricks = place.maybe("bricks");
  Plugin::Brush brush;
  if (bricks) {
    if (plugin.library.empty()) bricks->fail("is of a brush in a library, and none is named: give \"library\"");
    if (const auto formula = place.maybe("formula")) formula->fail("stands beside \"bricks\": give one of them");
    bricks->keys({"margin", "leaves"});
    brush.tool = readToolFacts(place, id, {"id", "bricks"});
    brush.facts.emplace();
    brush.facts->id = id;
    const double margin = bricks->at("margin").number(0, 4);
    if (margin != 0 && margin != 1 && margin != 2 && margin != 4) bricks->at("margin").fail("is none of 0, 1, 2, 4");
    brush.facts->margin = static_cast<int>(margin);
    brush.facts->leaves = bricks->at("leaves").oneOf<clay::Renew>(kLeaves);
    for (const AddedTool::Number& number : brush.tool.numbers) brush.facts->numbers.push_back(number.id);
    // What it is computed by is known once it is loaded; all else is looked at here.
    AddedTool tool = brush.tool;
    tool.formula = "phi";
    requireTool(place, tool);
  } else {
    brush.tool = readFormulaTool(place, id, {"id"});
  }
  return brush;
}

std::string endingAt(const Place& place) {
  const std::string& ending = place.text();
  if (ending.size() < 2 || ending.size() > 20 || ending[0] != '.' ||
      std::any_of(ending.begin() + 1, ending.end(),
                  [](char c) { return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_'); }))
    place.fail(fmt::format("{} is no ending: give one such as \".xyz\", in small letters", io::shown(ending)));
  return ending;
}

Plugin::Format formatOf(const Place& place, const Plugin& plugin) {
  place.keys({"id", "name", "ending", "reads", "writes", "frames", "unit_mm"});
  Plugin::Format format;
  format.id = plugin.id + "." + place.at("id").text();
  format.name = place.at("name").text();
  format.ending = endingAt(place.at("ending"));
  if (const auto reads = place.maybe("reads")) format.reads = reads->truth();
  if (const auto writes = place.maybe("writes")) format.writes = writes->truth();
  if (const auto frames = place.maybe("frames")) format.frameEnding = endingAt(*frames);
  if (const auto unit = place.maybe("unit_mm")) format.unitMm = unit->number(1e-6, 1e6);
  if (!format.reads && !format.writes) place.fail("is neither read nor written: give \"reads\" or \"writes\" as true");
  if (!format.frameEnding.empty() && (format.reads || !format.writes))
    place.at("frames").fail("is of what is written alone");
  return format;
}

Plugin::Operation operationOf(const Place& place, const Plugin& plugin) {
  place.keys({"id", "name", "help", "doing", "numbers"});
  Plugin::Operation operation;
  operation.id = plugin.id + "." + place.at("id").text();
  operation.name = place.at("name").text();
  operation.help = place.at("help").text();
  operation.doing = place.at("doing").text();
  if (const auto numbers = place.maybe("numbers")) operation.numbers = readNumbers(*numbers);
  try {
    checkNumbers(operation.numbers, operation.id);
  } catch (const Error& error) {
    place.fail(error.what());
  }
  return operation;
}

Plugin::Guide guideOf(const Place& place, const Plugin& plugin) {
  place.keys({"id", "name", "help", "numbers"});
  Plugin::Guide guide;
  guide.id = plugin.id + "." + place.at("id").text();
  guide.name = place.at("name").text();
  guide.help = place.at("help").text();
  if (const auto numbers = place.maybe("numbers")) guide.numbers = readNumbers(*numbers);
  try {
    checkNumbers(guide.numbers, guide.id);
  } catch (const Error& error) {
    place.fail(error.what());
  }
  return guide;
}

// Kinds of nodes that a device may be; never a disk, a camera or a keyboard's own.
constexpr std::array<std::string_view, 5> kNodes{"/dev/hidraw", "/dev/ttyACM", "/dev/ttyUSB", "/dev/bus/usb/",
                                                 "/dev/argil-"};

std::string nodeAt(const Place& place) {
  const std::string& node = place.text();
  const bool known = std::any_of(kNodes.begin(), kNodes.end(), [&](auto kind) { return node.starts_with(kind); });
  const bool letters = std::all_of(node.begin(), node.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' || c == '*' ||
           c == '-' || c == '_';
  });
  if (!known || !letters || node.size() > 100)
    place.fail(fmt::format("{}: give what begins with one of {}, with '*' for any letters", io::shown(node),
                           fmt::join(kNodes, ", ")));
  return node;
}

Plugin::Device deviceOf(const Place& place, const Plugin& plugin) {
  place.keys({"id", "name", "help", "measures", "drives", "workspace_mm", "peak_n", "continuous_n", "stiffness_n_mm",
              "damping_ns_mm", "resolution_mm", "rate_hz", "buttons", "nodes"});
  Plugin::Device device;
  device.id = plugin.id + "." + place.at("id").text();
  device.name = place.at("name").text();
  device.help = place.at("help").text();
  haptics::DeviceSheet& sheet = device.sheet;
  sheet.name = device.id;
  sheet.like = device.name;
  const auto axes = [&](const char* key, int least) {
    const double value = place.at(key).number(0, 6);
    if (value != least && value != least + 3)
      place.at(key).fail(fmt::format("{:g}: give {} or {}", value, least, least + 3));
    return static_cast<int>(value);
  };
  sheet.dofIn = axes("measures", 3);
  sheet.dofOut = axes("drives", 0);
  const std::vector<Place> edges = place.at("workspace_mm").items();
  if (edges.size() != 3) place.at("workspace_mm").fail("give three edges");
  for (int k = 0; k < 3; ++k) sheet.workspaceMm[k] = edges[static_cast<size_t>(k)].number(1, 5000);
  sheet.resolutionMm = place.at("resolution_mm").number(1e-6, 10);
  sheet.rateHz = place.at("rate_hz").number(20, 4000);
  sheet.buttons = static_cast<int>(place.at("buttons").number(0, 32));
  if (sheet.dofOut > 0) {
    sheet.peakForceN = place.at("peak_n").number(0.01, 50);
    sheet.continuousForceN = place.at("continuous_n").number(0.01, sheet.peakForceN);
    sheet.topStiffnessNmm = place.at("stiffness_n_mm").number(0.001, 20);
    sheet.topDampingNsmm = place.at("damping_ns_mm").number(0, 1);
  }
  if (const auto nodes = place.maybe("nodes"))
    for (const Place& each : nodes->items()) device.nodes.push_back(nodeAt(each));
  return device;
}

}  // namespace

Plugin parsePlugin(std::string_view text, const std::string& name) {
  const nlohmann::json json = parseJson(text, name, "a plugin is {...}");
  const Place root(json, name, "");
  root.keys({"format", "id", "name", "version", "licence", "help", "library", "brushes", "formats", "operations",
             "guides", "textures", "devices"});
  if (const double format = root.at("format").number(1, 1e6); format != kPluginFormat)
    root.at("format").fail(fmt::format("{:g} is of a newer Argil; this one knows {}", format, kPluginFormat));
  Plugin plugin;
  plugin.id = idOf(root.at("id"));
  plugin.name = root.at("name").text();
  plugin.version = root.at("version").text();
  plugin.licence = root.at("licence").text();
  plugin.help = root.at("help").text();
  if (const auto library = root.maybe("library")) plugin.library = libraryName(*library);
  plugin.checksum = checksumOf(text);
  const auto listOf = [&](const char* key) {
    const auto list = root.maybe(key);
    std::vector<Place> items = list ? list->items() : std::vector<Place>();
    if (list && (items.empty() || items.size() > kMostThings))
      list->fail(fmt::format("{} of them: give 1 to {}", items.size(), kMostThings));
    if (list && std::string_view(key) != "brushes" && plugin.library.empty())
      list->fail("are of a library, and none is named: give \"library\"");
    return items;
  };
  const std::vector<Place> brushes = listOf("brushes"), formats = listOf("formats"), operations = listOf("operations"),
                           guides = listOf("guides"), textures = listOf("textures"), devices = listOf("devices");
  if (brushes.empty() && formats.empty() && operations.empty() && guides.empty() && textures.empty() && devices.empty())
    root.fail("brings nothing: give \"brushes\", \"formats\", \"operations\", \"guides\", \"textures\" or \"devices\"");
  for (const Place& each : devices) plugin.devices.push_back(deviceOf(each, plugin));
  for (const Place& each : guides) plugin.guides.push_back(guideOf(each, plugin));
  for (const Place& each : formats) plugin.formats.push_back(formatOf(each, plugin));
  for (const Place& each : operations) plugin.operations.push_back(operationOf(each, plugin));
  for (const Place& each : textures) {
    AddedTool tool = readToolFacts(each, plugin.id + "." + each.at("id").text(), {"id"});
    if (each.maybe("formula")) each.at("formula").fail("is of brushes alone");
    tool.origin = {plugin.id, plugin.version, plugin.checksum};
    // Its image is known once the library is loaded; all else is looked at here.
    AddedTool looked = tool;
    looked.image = [](std::span<const float>) { return std::shared_ptr<const clay::HeightImage>(); };
    requireTool(each, looked);
    plugin.textures.push_back({std::move(tool)});
  }
  for (const Place& each : brushes) {
    plugin.brushes.push_back(brushOf(each, plugin));
    plugin.brushes.back().tool.origin = {plugin.id, plugin.version, plugin.checksum};
    for (size_t i = 0; i + 1 < plugin.brushes.size(); ++i)
      if (plugin.brushes[i].tool.id == plugin.brushes.back().tool.id) each.at("id").fail("another brush has that id");
  }
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

std::vector<Brought> broughtBy(const Plugin& plugin) {
  std::vector<Brought> all;
  for (const auto& [tool, facts] : plugin.brushes)
    all.push_back({"brush", tool.id, tool.name, tool.help, facts ? "" : tool.formula, tool.numbers});
  for (const auto& [tool] : plugin.textures)
    all.push_back({"texture", tool.id, tool.name, tool.help, "", tool.numbers});
  for (const Plugin::Operation& each : plugin.operations)
    all.push_back({"operation", each.id, each.name, each.help, "", each.numbers});
  for (const Plugin::Format& each : plugin.formats)
    all.push_back({"format",
                   each.id,
                   each.name,
                   fmt::format("Files that end in {}: {}{}{}.", each.ending, each.reads ? "read" : "",
                               each.reads && each.writes ? " and " : "", each.writes ? "written" : ""),
                   "",
                   {}});
  for (const Plugin::Guide& each : plugin.guides)
    all.push_back({"guide", each.id, each.name, each.help, "", each.numbers});
  for (const Plugin::Device& each : plugin.devices) all.push_back({"device", each.id, each.name, each.help, "", {}});
  return all;
}

std::string mayOf(const Plugin& plugin) {
  if (plugin.library.empty()) return "May compute with what a brush is given, and nothing else.";
  std::vector<std::string> nodes;
  for (const Plugin::Device& device : plugin.devices)
    nodes.insert(nodes.end(), device.nodes.begin(), device.nodes.end());
  return nodes.empty()
             ? "May run code in a process of its own, which opens no file, no connection and no other process."
             : fmt::format(
                   "May run code in a process of its own, which reads and writes {}, and opens no other file, no "
                   "connection and no other process.",
                   fmt::join(nodes, ", "));
}

PluginLibrary libraryOf(const Plugin& plugin, const fs::path& folder, std::string checksum) {
  const fs::path absolute = fs::absolute(folder);
  return {plugin.id,           plugin.name, plugin.version,
          std::move(checksum), absolute,    absolute / kPluginMachine / plugin.library};
}

std::string libraryChecksum(const Plugin& plugin, const fs::path& folder) {
  if (plugin.library.empty()) return {};
  return fileChecksum(libraryOf(plugin, folder, {}).file);
}

}  // namespace argil::engine
