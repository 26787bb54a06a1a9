// The keep-out box: each face is dragged on its own.

#include <algorithm>

#include "ui3d/studio/widgets/box_frame.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

/// The opposite face stays.
void applyFace(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (!guide) return;
  const int axis = handle.index / 2;
  const double before = guide->sizeMm[axis];
  guide->sizeMm[axis] = std::max(kLeastSizeMm, before + change.move.dot(handle.axis));
  guide->pose.translation += 0.5 * (guide->sizeMm[axis] - before) * handle.axis;
}

}  // namespace

void buildKeepOutBox(Build& build, const Guide& guide, const Stance& stance) {
  const BoxFrame box{guide.pose, 0.5 * guide.sizeMm};
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  const Target target{Target::Kind::thing, guide.id};
  build.fill(box.triangles(), faded(colour, stance.selected ? 0.10f : 0.06f));
  Handle body;
  for (const auto& edge : box.edges()) {
    build.line({edge[0], edge[1]}, colour, stance.selected ? 2.6f : 1.8f);
    if (!stance.grabbed) continue;
    body.target = target;
    body.name = "body";
    body.anchor = guide.pose.translation;
    body.form = Form::unseen;
    body.points = {edge[0], edge[1]};
    body.body = true;
    body.besideClay = !stance.selected;
    body.apply = applyRigid;
    build.handles.push_back(body);
    ++body.index;
  }
  if (!stance.grabbed || !stance.selected) return;
  for (int face = 0; face < 6; ++face) {
    Handle dot;
    dot.target = target;
    dot.name = "face";
    dot.index = face;
    dot.way = Way::along;
    dot.anchor = box.faceCentre(face);
    dot.axis = box.normal(face);
    dot.points = {dot.anchor};
    // Behind: faint.
    dot.colour = faded(axisColour(face / 2), dot.axis.dot(build.world.screen.toEye(dot.anchor)) > 0 ? 1.f : 0.45f);
    dot.aligns = true;
    dot.apply = applyFace;
    build.handles.push_back(dot);
  }
}

}  // namespace argil::studio
