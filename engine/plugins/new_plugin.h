#pragma once
// What somebody who writes a plugin begins with.

#include <filesystem>
#include <string_view>

namespace argil::engine {

/// Makes `folder` with a plugin that works, of a kind: "formula", or "brush", "texture", "operation", "format",
/// "guide", "device", a library in C that its build.sh compiles with nothing but what lies there. Of tools
/// `folder`/try.json uses it. Throws Error: another kind, the folder is there already.
void newPlugin(std::string_view kind, const std::filesystem::path& folder);

}  // namespace argil::engine
