#pragma once
// What a tool has from a file: the image that it embosses, or the shape of its tip.

#include "engine/document/tool.h"

namespace argil::engine {

/// Reads the image or the shape that the tool names. Throws Error. Nothing for a tool that needs none or has it.
void loadToolFile(Tool& tool);

}  // namespace argil::engine
