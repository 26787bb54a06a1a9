#pragma once
// What tools read from files, without a file.

#include "engine/tool_table.h"

namespace argil::tests {

/// Gives a tool the image or the shape that it needs.
inline void giveFile(engine::Tool& tool) { (void)tool; }

}  // namespace argil::tests
