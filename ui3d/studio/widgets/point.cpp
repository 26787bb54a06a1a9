// The point guide.

#include "ui3d/studio/widgets/build.h"

#include <numbers>

namespace argil::studio {

void buildPoint(Build& build, const engine::Guide& guide, const Stance& stance) {
  const Vec3d at = guide.pose.translation;
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  const double arm = (stance.selected ? 13 : 10) * build.unit(at);
  for (int i = 0; i < 3; ++i)
    build.line({at - arm * Vec3d::Unit(i), at + arm * Vec3d::Unit(i)}, colour, stance.selected ? 3.f : 2.f);
  if (guide.feel == engine::Guide::Feel::well) {
    const auto& axes = build.world.screen.axes();
    build.closedLine(arc(at, axes.right, axes.up, guide.rangeMm, 0, 2 * std::numbers::pi, 48), faded(colour, 0.45f),
                     1.2f);
  }
  if (!stance.grabbed) return;
  Handle dot;
  dot.target = {Target::Kind::thing, guide.id};
  dot.name = "point";
  dot.anchor = at;
  dot.points = {at};
  dot.colour = stance.selected ? widget_colours::kHandle : colour;
  dot.toSurface = true;
  dot.body = !stance.selected;
  dot.besideClay = !stance.selected;
  dot.apply = applyRigid;
  if (!stance.gizmo) build.handles.push_back(dot);
}

}  // namespace argil::studio
