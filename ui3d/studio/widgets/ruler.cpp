// The ruler and the angle: points on the clay, and what lies between them.

#include <algorithm>
#include <cmath>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kTickUnits = 7, kArcUnits = 34;

void applyPoint(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (guide && size_t(handle.index) < guide->pointsMm.size()) guide->pointsMm[size_t(handle.index)] += change.move;
}

void addHandles(Build& build, const Guide& guide, const Stance& stance) {
  if (!stance.grabbed) return;
  Handle body;
  body.target = {Target::Kind::thing, guide.id};
  body.name = "body";
  body.form = Form::unseen;
  body.points = guide.pointsMm;
  body.body = body.anchorIsGrab = true;
  body.besideClay = !stance.selected;
  body.apply = applyRigid;
  build.handles.push_back(body);
  if (!stance.selected) return;
  for (size_t i = 0; i < guide.pointsMm.size(); ++i) {
    Handle dot;
    dot.target = body.target;
    dot.name = "point";
    dot.index = int(i);
    dot.anchor = guide.pointsMm[i];
    dot.points = {guide.pointsMm[i]};
    dot.colour = widget_colours::kHandle;
    dot.toSurface = true;
    if (i > 0) dot.beside.push_back(guide.pointsMm[i - 1]);
    if (i + 1 < guide.pointsMm.size()) dot.beside.push_back(guide.pointsMm[i + 1]);
    dot.apply = applyPoint;
    build.handles.push_back(dot);
  }
}

}  // namespace

void buildRuler(Build& build, const Guide& guide, const Stance& stance) {
  if (guide.pointsMm.size() < 2) return;
  const Vec3d a = guide.pointsMm[0], b = guide.pointsMm[1];
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  build.line({a, b}, colour, stance.selected ? 3.f : 2.2f);
  const Vec3d along = b - a;
  for (const Vec3d& end : {a, b}) {
    const Vec3d aside = along.cross(build.world.screen.toEye(end));
    if (!(aside.norm() > 1e-12)) continue;
    const Vec3d tick = kTickUnits * build.unit(end) * aside.normalized();
    build.line({end - tick, end + tick}, colour, stance.selected ? 3.f : 2.2f);
  }
  build.text(0.5 * (a + b), lengthText(along.norm()), colour);
  addHandles(build, guide, stance);
}

void buildAngle(Build& build, const Guide& guide, const Stance& stance) {
  if (guide.pointsMm.size() < 2) return;
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  build.line(guide.pointsMm, colour, stance.selected ? 3.f : 2.2f);
  if (guide.pointsMm.size() >= 3) {
    const Vec3d corner = guide.pointsMm[1], a = guide.pointsMm[0] - corner, b = guide.pointsMm[2] - corner;
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    const double radius = std::min({kArcUnits * build.unit(corner), 0.8 * a.norm(), 0.8 * b.norm()});
    const Vec3d x = a.normalized(), across = b - b.dot(x) * x;
    if (radius > 0 && across.norm() > 1e-12) {
      const std::vector<Vec3d> points = arc(corner, x, across.normalized(), radius, 0, angle, 24);
      build.line(points, colour, 2.f);
      build.text(corner + 1.25 * (points[12] - corner), angleText(angle), colour);
    } else {
      build.text(corner, angleText(angle), colour);
    }
  }
  addHandles(build, guide, stance);
}

}  // namespace argil::studio
