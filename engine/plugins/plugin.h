#pragma once
// A plugin: a folder that says in plugin.json what it brings.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/tools/added_tools.h"

namespace argil::engine {

struct Plugin {
  std::string id;  ///< Such as "org.argil.formulas".
  std::string name, version, licence, help;
  std::vector<FormulaTool> brushes;  ///< Their ids begin with that of the plugin.
  std::string checksum;              ///< SHA-256 of all that it consists of, in hexadecimal digits.
};

/// Of a plugin's folder; what else lies beside it is none.
inline constexpr std::string_view kPluginEnding = ".argil-plugin";
inline constexpr std::string_view kPluginFile = "plugin.json";
inline constexpr int kPluginFormat = 1;

/// Reads `folder`/plugin.json; runs nothing. Formulas are compiled, so what cannot work is told here. Throws Error that
/// names file and place.
[[nodiscard]] Plugin readPlugin(const std::filesystem::path& folder);
/// Of its text. `name` stands in messages.
[[nodiscard]] Plugin parsePlugin(std::string_view text, const std::string& name);

/// What a person who writes one begins with: "formula". Makes `folder` with a plugin.json that works. Throws Error: it
/// is there already, another kind.
void newPlugin(std::string_view kind, const std::filesystem::path& folder);

}  // namespace argil::engine
