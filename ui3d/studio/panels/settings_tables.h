#pragma once
// The tables of everything that can be set beside tools: looks, stereo, quality, touch, guides, materials.

#include <span>

#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

[[nodiscard]] std::span<const Row<render::Look>> lookRows();
[[nodiscard]] std::span<const Row<render::Stereo>> stereoRows();
[[nodiscard]] std::span<const Row<render::Quality>> qualityRows();
/// Where the surface's vertices stand, and how often it is drawn.
[[nodiscard]] std::span<const Row<StudioState>> pictureRows();
/// Of the document's strokes, of touch: rows of engine::qualityAxes().
[[nodiscard]] std::span<const engine::Parameter<engine::Quality>> strokeQualityRows();
[[nodiscard]] std::span<const engine::Parameter<engine::Quality>> touchQualityRows();
[[nodiscard]] std::span<const Row<haptics::Workspace>> workspaceRows();
/// Pan walls, by themselves: shown while they are on.
[[nodiscard]] std::span<const Row<haptics::PanWalls>> wallRows();
[[nodiscard]] std::span<const engine::Parameter<haptics::Material>> materialRows();
/// What a well needs.
[[nodiscard]] std::span<const engine::Parameter<engine::Guide>> wellRows();
/// Edges of a keep-out box, or what is drawn of a plane or a line.
[[nodiscard]] std::span<const engine::Parameter<engine::Guide>> sizeRows(engine::Guide::Kind kind);
/// How often strokes are repeated around an axis.
[[nodiscard]] std::span<const engine::Parameter<engine::Symmetry>> symmetryRows();
/// Whether a parameter has an effect as the tool is set. A soft cut has no tip's shape, a hard one no depth of its own.
/// A device cuts hard: its tip rules the depth. `pointer`: mouse or pen is in hand.
[[nodiscard]] bool counts(const engine::Parameter<engine::Tool>& parameter, const engine::Tool& tool, bool pointer);
/// Of the studio itself: how deep the pointer goes, how large the interface is.
[[nodiscard]] std::span<const engine::Parameter<StudioState>> handRows();
/// Of all tools: how pens press, what sizes go with.
[[nodiscard]] std::span<const engine::Parameter<StudioState>> handsRows();
/// What undo may cost.
[[nodiscard]] std::span<const engine::Parameter<StudioState>> undoRows();

}  // namespace argil::studio
