#pragma once
// Files that a new plugin begins with: those of the examples, compiled into the program (engine/CMakeLists.txt).

#include <span>
#include <string_view>

namespace argil::engine {

struct PluginTemplate {
  struct File {
    std::string_view name, text;
  };
  std::string_view kind;      ///< "brush".
  std::string_view id, name;  ///< Of the plugin in its texts: others take their place.
  std::string_view brush;     ///< End of its tool's id; empty: it has none.
  std::span<const File> files;
};
/// Null: there is none of that kind.
[[nodiscard]] const PluginTemplate* findPluginTemplate(std::string_view kind);

}  // namespace argil::engine
