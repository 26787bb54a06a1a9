#include "engine/plugins/plugins.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "engine/plugins/felt_guides.h"
#include "engine/plugins/plugin_device.h"
#include "engine/plugins/plugin_work.h"
#include "engine/text/json_text.h"
#include "engine/text/script_place.h"
#include "engine/tools/added_jobs.h"
#include "haptics/devices/added_devices.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"
#include "io/models/added_formats.h"

namespace argil::engine {

namespace fs = std::filesystem;

namespace {

fs::path absoluteFrom(const char* variable) {
  const char* value = std::getenv(variable);
  const fs::path path(value ? value : "");
  return path.is_absolute() ? path : fs::path();
}

fs::path below(const char* variable, const char* inHome, const char* rest) {
  if (const fs::path base = absoluteFrom(variable); !base.empty()) return base / rest;
  if (const fs::path home = absoluteFrom("HOME"); !home.empty()) return home / inHome / rest;
  return {};
}

constexpr size_t kDigits = 64;  // of a checksum

// What is kept of an enabled plugin: the checksum of plugin.json, and behind a '+' that of its library.
std::string joined(const std::string& checksum, const std::string& library) {
  return library.empty() ? checksum : checksum + "+" + library;
}
std::string librarysDigits(const std::string& joined) {
  return joined.size() > kDigits ? joined.substr(kDigits + 1) : std::string();
}

std::string requireLibrary(const FoundPlugin& found) {
  if (found.plugin.library.empty()) return {};
  std::string checksum = libraryChecksum(found.plugin, found.folder);
  if (checksum.empty())
    throw Error(fmt::format("{} cannot be read: it is not built, or was made for another machine",
                            libraryOf(found.plugin, found.folder, {}).file.string()));
  return checksum;
}

}  // namespace

std::string_view nameOf(PluginState state) {
  switch (state) {
    case PluginState::enabled:
      return "enabled";
    case PluginState::disabled:
      return "not enabled";
    case PluginState::changed:
      return "changed since it was enabled";
    case PluginState::broken:
      return "broken";
    case PluginState::hidden:
      return "hidden by another of the same id";
  }
  return "";
}

std::vector<fs::path> pluginFolders() {
  std::vector<fs::path> folders;
  if (const char* path = std::getenv("ARGIL_PLUGIN_PATH"))
    for (std::string_view rest = path; !rest.empty();) {
      const size_t end = std::min(rest.find(':'), rest.size());
      if (end > 0) folders.emplace_back(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  if (const fs::path own = below("XDG_DATA_HOME", ".local/share", "argil/plugins"); !own.empty())
    folders.push_back(own);
  folders.emplace_back("/usr/share/argil/plugins");
  return folders;
}

fs::path pluginSettings() {
  return below("XDG_CONFIG_HOME", ".config", "argil/plugins.json");
}

Plugins::Plugins(const std::vector<fs::path>& folders, fs::path settings) : settings_(std::move(settings)) {
  std::error_code none;
  if (!settings_.empty() && fs::exists(settings_, none)) try {
      const io::FileBytes content = io::readFile(settings_);
      const io::Input input{content.bytes(), settings_.string()};
      const nlohmann::json json = parseJson(input.text(), input.name, "settings of plugins are {...}");
      const Place root(json, input.name, "");
      root.keys({"enabled"});
      if (!root.at("enabled").value().is_object()) root.at("enabled").fail("must be an object {...}");
      for (const auto& [id, checksum] : json["enabled"].items())
        enabled_[id] = Place(checksum, input.name, "enabled." + id).text();
    } catch (const Error& error) {
      enabled_.clear();
      problem_ = error.what();
    }
  look(folders);
}

void Plugins::look(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    std::vector<fs::path> here;
    std::error_code problem;
    for (fs::directory_iterator it(folder, problem), end; !problem && it != end; it.increment(problem))
      if (it->path().filename().string().ends_with(kPluginEnding)) here.push_back(it->path());
    std::sort(here.begin(), here.end());
    for (const fs::path& each : here) {
      if (found_.size() == kMost) return;
      FoundPlugin found;
      found.folder = each;
      try {
        found.plugin = readPlugin(each);
        const auto enabled = enabled_.find(found.plugin.id);
        found.state = find(found.plugin.id)                                         ? PluginState::hidden
                      : enabled == enabled_.end()                                   ? PluginState::disabled
                      : enabled->second.substr(0, kDigits) == found.plugin.checksum ? PluginState::enabled
                                                                                    : PluginState::changed;
      } catch (const std::exception& error) {
        found.problem = error.what();
      }
      found_.push_back(std::move(found));
    }
  }
}

void Plugins::compareLibraries() {
  for (FoundPlugin& each : found_) {
    if (each.plugin.library.empty() || each.state == PluginState::broken || each.state == PluginState::hidden) continue;
    const std::string checksum = libraryChecksum(each.plugin, each.folder);
    if (checksum.empty()) {
      each.problem = fmt::format("{} cannot be read: it is not built, or was made for another machine",
                                 libraryOf(each.plugin, each.folder, {}).file.string());
      each.state = PluginState::broken;
    } else if (each.state == PluginState::enabled && librarysDigits(enabled_.at(each.plugin.id)) != checksum) {
      each.state = PluginState::changed;
    }
  }
}

const FoundPlugin* Plugins::find(std::string_view id) const {
  const auto found = std::find_if(found_.begin(), found_.end(), [&](const FoundPlugin& each) {
    return each.plugin.id == id && each.state != PluginState::broken && each.state != PluginState::hidden;
  });
  return found == found_.end() ? nullptr : &*found;
}

void Plugins::change(std::string_view id, bool enabled) {
  const FoundPlugin* plugin = find(id);
  if (!plugin) {
    for (const FoundPlugin& each : found_)
      if (each.state == PluginState::broken && each.folder.stem() == fs::path(id)) throw Error(each.problem);
    throw Error(
        fmt::format("there is no plugin {}; argil plugins lists those that are there", io::shown(std::string(id))));
  }
  if (settings_.empty()) throw Error("there is no home to keep settings in: set HOME or XDG_CONFIG_HOME");
  if (!problem_.empty()) throw Error(problem_);
  auto now = enabled_;
  if (enabled)
    now[plugin->plugin.id] = joined(plugin->plugin.checksum, requireLibrary(*plugin));
  else
    now.erase(plugin->plugin.id);
  nlohmann::ordered_json json;
  json["enabled"] = nlohmann::ordered_json::object();
  for (const auto& [each, checksum] : now) json["enabled"][each] = checksum;
  const std::string text = json.dump(2) + "\n";
  std::error_code problem;
  fs::create_directories(settings_.parent_path(), problem);
  io::AtomicFile file(settings_);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
  enabled_ = std::move(now);
  found_[static_cast<size_t>(plugin - found_.data())].state = enabled ? PluginState::enabled : PluginState::disabled;
}

void Plugins::enable(std::string_view id) {
  change(id, true);
}
void Plugins::disable(std::string_view id) {
  change(id, false);
}

namespace {

// The first plugin that brings an ending has it for the life of the program.
void addFormat(const Plugin::Format& format, const std::shared_ptr<PluginProcesses>& processes) {
  static std::mutex mutex;
  static std::map<std::string, std::string> whose;  // of endings
  const std::lock_guard lock(mutex);
  if (const auto [it, fresh] = whose.try_emplace(format.ending, format.id); !fresh) {
    if (it->second == format.id) return;
    throw Error(fmt::format("{} brings the ending {} already", it->second, format.ending));
  }
  io::AddedFormat added{format.name, format.ending, {}, {}};
  if (format.reads)
    added.read = [format, processes](const fs::path& file, Job* job) {
      const io::FileBytes content = io::readFile(file, job);
      io::ModelFile model;
      try {
        model = importByPlugin(*processes, format.id, content.bytes(), job);
      } catch (const Cancelled&) {
        throw;
      } catch (const Error& error) {
        throw Error(fmt::format("{}: {}", io::displayName(file), error.what()), error.kind());
      }
      model.format = format.name;
      if (format.unitMm > 0) model.unitMm = format.unitMm;
      return model;
    };
  if (format.writes)
    added.write = [format, processes](io::AtomicFile& file, const io::ModelView& model, Job* job) {
      exportByPlugin(*processes, format.id, file, model, PluginFrame{model.frame, model.frames}, job);
    };
  added.frameEnding = format.frameEnding;
  io::addFormat(std::move(added));
}

// The image of the values that were asked for last: strokes follow each other with the same.
auto cached(decltype(AddedTool::image) make) -> decltype(AddedTool::image) {
  struct Last {
    std::mutex mutex;
    std::vector<float> values;
    std::shared_ptr<const clay::HeightImage> image;
  };
  return [make = std::move(make), last = std::make_shared<Last>()](std::span<const float> values) {
    const std::lock_guard lock(last->mutex);
    if (!last->image || !std::equal(values.begin(), values.end(), last->values.begin(), last->values.end())) {
      last->image = make(values);
      last->values.assign(values.begin(), values.end());
    }
    return last->image;
  };
}

void addOperation(const Plugin::Operation& operation, const ToolOrigin& origin,
                  const std::shared_ptr<PluginProcesses>& processes) {
  std::vector<std::string> numbers;
  for (const AddedTool::Number& number : operation.numbers) numbers.push_back(number.id);
  addedJobs().add({origin, operation.id, operation.name, operation.help, operation.doing, operation.numbers,
                   [=](const clay::Version& version, std::span<const float> values, Job* job) {
                     return operateByPlugin(*processes, operation.id, numbers, values, version, job);
                   }});
}

}  // namespace

void Plugins::load() {
  for (FoundPlugin& each : found_) {
    if (each.state == PluginState::broken || each.state == PluginState::hidden) continue;
    if (each.state == PluginState::enabled) {
      load(each);
      continue;
    }
    for (const Plugin::Brush& brush : each.plugin.brushes)
      addedTools().explain(
          brush.tool.id,
          fmt::format("{} is of the plugin {}, which {}: argil plugins enable {}", brush.tool.id, each.plugin.name,
                      each.state == PluginState::changed ? "has changed since it was enabled" : "is not enabled",
                      each.plugin.id));
  }
}

void Plugins::load(FoundPlugin& found) {
  try {
    std::shared_ptr<PluginProcesses> processes;
    if (!found.plugin.library.empty())
      processes = std::make_shared<PluginProcesses>(
          libraryOf(found.plugin, found.folder, librarysDigits(enabled_.at(found.plugin.id))));
    for (const Plugin::Brush& brush : found.plugin.brushes) {
      AddedTool tool = brush.tool;
      tool.origin.checksum = enabled_.at(found.plugin.id);  // of its library too
      if (brush.facts) tool.external = std::make_shared<const PluginBrush>(*brush.facts, processes);
      addedTools().add(tool);
    }
    for (const Plugin::Texture& texture : found.plugin.textures) {
      AddedTool tool = texture.tool;
      tool.origin.checksum = enabled_.at(found.plugin.id);
      std::vector<std::string> numbers;
      for (const AddedTool::Number& number : tool.numbers) numbers.push_back(number.id);
      tool.image = cached(
          [=, id = tool.id](std::span<const float> values) { return imageByPlugin(*processes, id, numbers, values); });
      addedTools().add(tool);
    }
    const ToolOrigin origin{found.plugin.id, found.plugin.version, enabled_.at(found.plugin.id)};
    for (const Plugin::Format& format : found.plugin.formats) addFormat(format, processes);
    for (const Plugin::Guide& guide : found.plugin.guides)
      feltGuides().add({origin, guide.id, guide.name, guide.help, guide.numbers, processes});
    for (const Plugin::Device& device : found.plugin.devices)
      haptics::addDevice({device.id, device.name, device.sheet,
                          [device, library = processes->library()] { return openPluginDevice(device, library); }});
    for (const Plugin::Operation& operation : found.plugin.operations) addOperation(operation, origin, processes);
  } catch (const Error& error) {
    found.state = PluginState::broken;
    found.problem = fmt::format("{}: {}", found.folder.string(), error.what());
  }
}

}  // namespace argil::engine
