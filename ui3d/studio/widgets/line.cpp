// The line guide: endless; what is drawn in full has two ends that can be dragged.

#include <algorithm>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kBeyond = 2;  // Extents of the model: so far the faint rest is drawn.

/// The other end stays.
void applyEnd(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (!guide || handle.beside.empty()) return;
  const Vec3d other = handle.beside[0], end = handle.anchor + change.move;
  const Vec3d along = handle.index == 1 ? Vec3d(end - other) : Vec3d(other - end);
  const double length = along.norm();
  if (!(length >= kLeastSizeMm)) return;
  guide->pose.translation = 0.5 * (end + other);
  // The smallest turn, so that the frame about the line does not spin.
  guide->pose.rotation = (haptics::rotationBetween(guide->axis(), along) * guide->pose.rotation).normalized();
  guide->sizeMm.z() = length;
}

}  // namespace

void buildLine(Build& build, const Guide& guide, const Stance& stance) {
  const Vec3d along = guide.axis(), centre = guide.pose.translation;
  const Vec3d ends[2] = {centre - 0.5 * guide.sizeMm.z() * along, centre + 0.5 * guide.sizeMm.z() * along};
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  const Target target{Target::Kind::thing, guide.id};
  const double beyond = kBeyond * build.extentMm();
  build.line({ends[0], ends[1]}, colour, stance.selected ? 3.5f : 2.5f);
  build.line({ends[1], ends[1] + beyond * along}, faded(colour, 0.3f), 1.2f);
  build.line({ends[0], ends[0] - beyond * along}, faded(colour, 0.3f), 1.2f);
  if (!stance.grabbed) return;

  Handle body;
  body.target = target;
  body.name = "body";
  body.way = Way::free;
  body.anchor = centre;
  body.form = Form::unseen;
  body.points = {ends[0], ends[1]};
  body.body = true;
  body.besideClay = !stance.selected;
  body.apply = applyRigid;
  build.handles.push_back(body);
  if (!stance.selected) return;
  for (int i = 0; i < 2; ++i) {
    Handle end;
    end.target = target;
    end.name = "end";
    end.index = i;
    end.anchor = ends[i];
    end.points = {ends[i]};
    end.colour = widget_colours::kHandle;
    end.toSurface = true;
    end.beside = {ends[1 - i]};
    end.apply = applyEnd;
    build.handles.push_back(end);
  }
}

}  // namespace argil::studio
