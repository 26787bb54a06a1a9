#pragma once
// Texts over the picture, below the panels, drawn with Dear ImGui: they stay sharp and clear of what covers the
// picture.

#include <array>

#include "render/view/view.h"
#include "ui3d/studio/view/studio_state.h"
#include "ui3d/studio/widgets/widgets.h"

namespace argil::studio {

/// The colour as it can be read on the label's ground in that theme: darker or lighter where it has too little
/// contrast.
[[nodiscard]] render::Colour readableOn(const render::Colour& ink, Theme theme);
/// Draws it centred on its place, on a plate that keeps it readable over any clay. Within a frame of ImGui.
void drawLabel(const Widgets::Label& label, Theme theme);
/// A length that is true in the plane through the view's target, and the spacing of the grid; bottom left in `free`
/// (left, top, right, bottom). Sizes in interface units.
void drawScaleBar(const render::View& view, const std::array<float, 4>& free, float width, float height,
                  const StudioState& state);

}  // namespace argil::studio
