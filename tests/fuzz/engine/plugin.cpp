// plugin.json of anybody: read or refused, and what is read can be a tool.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "clay/base/error.h"
#include "engine/plugins/plugin.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const argil::engine::Plugin plugin =
        argil::engine::parsePlugin({reinterpret_cast<const char*>(data), size}, "plugin.json");
    for (const auto& brush : plugin.brushes)
      if (!brush.facts) argil::engine::checkTool(brush.tool);
  } catch (const argil::Error&) {
  }
  return 0;
}
