#pragma once
// What widgets stand in and work on. Made anew from a Context for each call; tests make it without a renderer or a
// workbench.

#include <functional>
#include <string>

#include "engine/document/document.h"
#include "ui3d/studio/view/cursor.h"
#include "ui3d/studio/view/studio_state.h"
#include "ui3d/studio/widgets/screen_map.h"

namespace argil::studio {

struct World {
  World(const engine::Document& in, StudioState& with, const ScreenMap& on) : document(in), state(with), screen(on) {}

  const engine::Document& document;
  StudioState& state;
  ScreenMap screen;
  double timeS = 0;
  double toolRadiusMm = 5;        ///< Within it the tip of a stylus grabs.
  render::Box bounds;             ///< Of all that is visible.
  Vec3d reachMm = Vec3d::Zero();  ///< Edges of the device's reach, at the hand, where it is shown; zero: it is not.

  PickSurface pick;                                 ///< Visible clay and parts, open where the section cuts.
  std::function<render::Box(engine::Id)> boundsOf;  ///< Of a piece or part, world.
  std::function<engine::Id(const Ray&)> pickThing;  ///< The piece or part under a ray; 0: none.
  /// As Workbench::edit and the like.
  std::function<void(std::string, std::function<void(engine::Document&)>, std::string)> edit;
  std::function<void()> endMerge;
  /// Scales a piece or a part along the world's axes about a place of the world.
  std::function<void(engine::Id, const Vec3d& factors, const Vec3d& aboutMm)> scale;
  std::function<void(const haptics::Workspace&)> setWorkspace;
};

}  // namespace argil::studio
