#pragma once
// Small drawings, as vectors.

#include <imgui.h>

#include <string_view>

namespace argil::studio {

/// `name`: of an icon, or a drawing itself ("M4 20 L20 4"), as a plugin brings it. Draws it in a square of `size` about
/// `centre`. False when there is none of that name: nothing is drawn.
bool drawIcon(ImDrawList& list, std::string_view name, ImVec2 centre, float size, ImU32 colour);
[[nodiscard]] bool hasIcon(std::string_view name);

}  // namespace argil::studio
