#pragma once
// The tool in the picture: what is felt is what is seen.

#include <functional>
#include <optional>

#include "engine/document/tool.h"
#include "haptics/threads/sample_ring.h"
#include "render/view/overlays.h"
#include "render/view/view.h"

namespace argil::studio {

struct CursorOptions {
  bool dropAlongView = false;  ///< The beam goes away from the person instead of down.
  bool turns = true;  ///< The device measures how it is held; without it the stylus leans like a pen in a right hand.
  double fullForceN = 3;    ///< Force whose arrow is as long as the stylus: the device's peak.
  float heightUnits = 720;  ///< Of the window.
};

/// The ball is drawn true to scale, but never smaller than this radius in interface units, so that it is not lost in a
/// wide view.
inline constexpr double kLeastBallUnits = 3;

/// The ball at the proxy of a tick, shaft, glow at contact, arrow of the force. `footprint`: see footprintOf().
[[nodiscard]] render::Cursor makeCursor(const haptics::StylusSample& sample, const engine::Tool& tool,
                                        const render::View& view, const CursorOptions& options,
                                        const std::optional<render::Cursor::Footprint>& footprint = {});
/// A mouse or a pen: the tool's ring on the surface under it, and a dot. `pressed`: it works.
[[nodiscard]] render::Cursor pointerCursor(const render::Cursor::Footprint& surface, const engine::Tool& tool,
                                           const render::View& view, const CursorOptions& options,
                                           bool pressed = false);

/// The first surface along a direction of length one from a point.
using PickSurface =
    std::function<std::optional<render::Cursor::Footprint>(const Vec3d& originMm, const Vec3d& direction)>;
/// Where the tool of a tick rests on the surface, or would if it went on into the picture or along the drop: within
/// three radii of the ball's centre, else nothing. Two picks at most.
[[nodiscard]] std::optional<render::Cursor::Footprint> footprintOf(const haptics::StylusSample& sample,
                                                                   const engine::Tool& tool, const render::View& view,
                                                                   const PickSurface& pick);

/// Of the ball while it is free, by what it does to clay.
[[nodiscard]] render::Colour tintOf(const engine::Tool& tool);

}  // namespace argil::studio
