// The plane guide: a sheet that is moved along its normal, tilted at two edges, sized at its corners.

#include <algorithm>
#include <cmath>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

/// The centre stays: the corner and its opposite move alike.
void applyCorner(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (!guide) return;
  const Vec3d local = guide->pose.applyInverse(handle.anchor + change.move);
  guide->sizeMm.x() = std::max(kLeastSizeMm, 2 * std::abs(local.x()));
  guide->sizeMm.y() = std::max(kLeastSizeMm, 2 * std::abs(local.y()));
}

}  // namespace

void buildPlane(Build& build, const Guide& guide, const Stance& stance) {
  const Eigen::Matrix3d axes = guide.pose.rotation.toRotationMatrix();
  const Sheet sheet{guide.pose.translation, axes.col(0), axes.col(1), 0.5 * guide.sizeMm.x(), 0.5 * guide.sizeMm.y()};
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  const Target target{Target::Kind::thing, guide.id};
  build.fill(sheet.triangles(), faded(colour, stance.selected ? 0.06f : 0.03f));
  build.fill(sheet.rim(), faded(colour, stance.selected ? 0.16f : 0.10f));
  build.closedLine(sheet.corners(), colour, stance.selected ? 3.f : 2.f);
  if (guide.feel == Guide::Feel::keepOut) {
    // The free side.
    const double unit = build.unit(sheet.centre);
    build.line({sheet.centre, sheet.centre + 20 * unit * sheet.normal()}, colour, 2.f);
  }
  if (!stance.grabbed) return;

  Handle body;
  body.target = target;
  body.name = "body";
  body.way = Way::along;
  body.anchor = sheet.centre;
  body.axis = sheet.normal();
  body.form = Form::unseen;
  body.points = sheet.corners();
  body.points.push_back(Vec3d(body.points.front()));
  body.body = true;
  body.besideClay = !stance.selected;
  body.aligns = true;
  body.apply = applyRigid;
  build.handles.push_back(body);
  if (!stance.selected) return;

  if (!stance.gizmo) sheetHandles(build, sheet, target, sheet.centre, colour, true);
  const auto corners = sheet.corners();
  for (int i = 0; i < 4; ++i) {
    Handle corner;
    corner.target = target;
    corner.name = "corner";
    corner.index = i;
    corner.way = Way::inPlane;
    corner.anchor = corners[size_t(i)];
    corner.axis = sheet.normal();
    corner.points = {corners[size_t(i)]};
    corner.colour = widget_colours::kHandle;
    corner.apply = applyCorner;
    build.handles.push_back(corner);
  }
}

}  // namespace argil::studio
