#pragma once
// Whether a plugin does what it promises.

#include <filesystem>
#include <string>
#include <vector>

namespace argil::engine {

struct PluginCheck {
  std::string name;     ///< Of what was tried, "org.example.ripples.ripple: nothing beyond the tip".
  std::string problem;  ///< Empty: it holds.
};

/// Tries all brushes of the plugin in `folder`, with their numbers as they begin, at both ends and at random, on a ball
/// of clay. What cannot be read is the only result. About a second a brush.
[[nodiscard]] std::vector<PluginCheck> checkPlugin(const std::filesystem::path& folder);

}  // namespace argil::engine
