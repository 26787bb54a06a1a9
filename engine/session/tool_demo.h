#pragma once
// A small scene for each tool: what the contact sheet of the documentation shows.

#include "engine/text/script.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {

/// A block with a bump and a furrow, and a stroke of the tool across it. Tools that need a file name "tile.pgm" or
/// "tile.stl".
[[nodiscard]] Script toolDemo(const ToolRow& row);

}  // namespace argil::engine
