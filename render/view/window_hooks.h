#pragma once
// What the renderer asks of a window, without knowing whose it is.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace argil::render {

struct WindowHooks {
  std::vector<std::string> instanceExtensions;  ///< Vulkan extensions that surfaces of this kind of window need.
  /// Makes a VkSurfaceKHR from a VkInstance; 0 when it cannot. The renderer destroys it.
  std::function<uint64_t(void* instance)> makeSurface;
  /// Pixels of the drawable part now; 0 × 0 while minimised.
  std::function<std::array<int, 2>()> size;
};

}  // namespace argil::render
