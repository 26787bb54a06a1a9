#pragma once
// Small drawings, as vectors.

#include <imgui.h>

#include <string_view>

namespace argil::studio {

/// Draws the icon of that name in a square of `size` about `centre`. False when there is none of that name: nothing is
/// drawn.
bool drawIcon(ImDrawList& list, std::string_view name, ImVec2 centre, float size, ImU32 colour);
[[nodiscard]] bool hasIcon(std::string_view name);

}  // namespace argil::studio
