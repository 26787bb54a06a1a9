#pragma once
// What panels, actions and widgets work with in a frame.

#include <memory>

#include "engine/session/workbench.h"
#include "render/view/view.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

class Camera;

/// Of one frame; the references outlive it.
struct Context {
  engine::Workbench& bench;
  const engine::Snapshot& now;
  StudioState& state;
  Camera& camera;
  const render::Renderer& renderer;  ///< Bounds and picking.
  double timeS = 0;                  ///< Since the studio began.
  double frameS = 0;                 ///< Since the last frame.
  float width = 1280, height = 720;  ///< Of the window in interface units.
  float scale = 1;                   ///< Pixels a unit.
};

}  // namespace argil::studio
