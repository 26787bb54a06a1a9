#pragma once
// The quality that a person works with: that of the document's strokes, of touch and of the picture, as one thing.

#include <string_view>

#include "engine/document/document.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// As it is now. What new clay is made with is not in it: its dialog asks for a voxel.
[[nodiscard]] engine::Quality chosenQuality(const StudioState& state, const engine::Document& document);
/// Of a preset of engine::qualityPresets(): chosen by eye, no front stands behind it.
[[nodiscard]] render::Quality pictureOf(std::string_view preset);
/// Whether all that a preset says of strokes, touch and picture stands as it says.
[[nodiscard]] bool isChosen(std::string_view preset, const StudioState& state, const engine::Document& document);

}  // namespace argil::studio
