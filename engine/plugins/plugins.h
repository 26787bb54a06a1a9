#pragma once
// The plugins that are there, and which of them the person has enabled.

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/plugins/plugin.h"

namespace argil::engine {

enum class PluginState : uint8_t {
  enabled,
  disabled,  ///< Nobody has enabled it.
  changed,   ///< It is not as it was when it was enabled: to be enabled anew.
  broken,    ///< It cannot be read.
  hidden,    ///< A folder before it has one of the same id.
};
[[nodiscard]] std::string_view nameOf(PluginState state);

struct FoundPlugin {
  std::filesystem::path folder;
  PluginState state = PluginState::broken;
  Plugin plugin;        ///< Unless broken.
  std::string problem;  ///< Why it is broken.
};

/// Where plugins are looked for, the first counts: $ARGIL_PLUGIN_PATH (folders with ':' between them),
/// $XDG_DATA_HOME/argil/plugins or ~/.local/share/argil/plugins, /usr/share/argil/plugins.
[[nodiscard]] std::vector<std::filesystem::path> pluginFolders();
/// $XDG_CONFIG_HOME/argil/plugins.json or ~/.config/argil/plugins.json: what is enabled. Empty without a home.
[[nodiscard]] std::filesystem::path pluginSettings();

/// What lies in some folders, read and compared with what is enabled; no plugin's code runs. One thread.
class Plugins {
 public:
  /// Looks at each folder in `folders` whose name ends in ".argil-plugin", sorted by name, kMost at most. Never throws
  /// for what lies there. Settings that cannot be read enable nothing (problem()).
  /// Libraries are not looked at: of a plugin that has one only plugin.json is compared.
  explicit Plugins(const std::vector<std::filesystem::path>& folders = pluginFolders(),
                   std::filesystem::path settings = pluginSettings());

  /// Looks at the libraries too: a plugin whose library is not there or another one is changed or broken then. Reads
  /// them whole.
  void compareLibraries();

  [[nodiscard]] std::span<const FoundPlugin> found() const { return found_; }
  /// Null: there is none that can be read.
  [[nodiscard]] const FoundPlugin* find(std::string_view id) const;
  [[nodiscard]] const std::string& problem() const { return problem_; }

  /// From now on, as it is now; written at once. Throws Error: no such plugin, no place for settings. Its tools are
  /// there from load() on.
  void enable(std::string_view id);
  void disable(std::string_view id);

  /// Makes the brushes of those that are enabled part of the program's tables; what goes wrong makes the plugin broken.
  /// Tells the tables why tools of the others are not there.
  void load();

  static constexpr size_t kMost = 1000;

 private:
  void look(const std::vector<std::filesystem::path>& folders);
  void change(std::string_view id, bool enabled);
  void load(FoundPlugin& found);

  std::filesystem::path settings_;
  std::map<std::string, std::string, std::less<>> enabled_;  // id to checksum
  std::vector<FoundPlugin> found_;
  std::string problem_;
};

}  // namespace argil::engine
