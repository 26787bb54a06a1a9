#pragma once
// Whether a plugin does what it promises.

#include <filesystem>
#include <string>
#include <vector>

namespace argil::engine {

struct PluginCheck {
  std::string name;     ///< What was tried: "org.example.ripples.ripple: mirrors to the bit".
  std::string problem;  ///< Empty: it holds. Of a library, it begins with the name of the fault: nameOf(PluginFault).
  std::string measured = {};  ///< What came of it, where that is a figure.
};

/// Tries all brushes of the plugin in `folder`, with their numbers as they begin, at both ends and at random, on a ball
/// of clay; a library in processes of their own. What cannot be read is the only result. Some seconds a brush.
[[nodiscard]] std::vector<PluginCheck> checkPlugin(const std::filesystem::path& folder);

}  // namespace argil::engine
