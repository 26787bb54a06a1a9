// The curve guide: points that are dragged; a drag of the curve between them puts a new one there.

#include "clay/base/error.h"
#include "haptics/scene/polyline.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr int kStepsPerPoint = 14;

void applyPoint(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (guide && size_t(handle.index) < guide->pointsMm.size()) guide->pointsMm[size_t(handle.index)] += change.move;
}

void applyInsert(Subject& subject, const Handle& handle, const Change& change) {
  auto* guide = std::get_if<Guide>(&subject);
  if (!guide || size_t(handle.index) >= guide->pointsMm.size()) return;
  guide->pointsMm.insert(guide->pointsMm.begin() + handle.index + 1, Vec3d(handle.anchor + change.move));
}

}  // namespace

std::vector<Vec3d> sampleCurve(const std::vector<Vec3d>& points, bool closed, std::vector<size_t>* starts) {
  std::vector<Vec3d> samples;
  std::vector<size_t> first;
  try {
    const haptics::Polyline curve(points, closed);
    // Arc lengths of the given points, in order: each is the first place from the one before on that meets it.
    const size_t count = points.size() + (closed ? 1 : 0);
    const double length = curve.lengthMm();
    double from = 0;
    for (size_t i = 0; i < count; ++i) {
      double here = i == 0 ? 0 : length;
      if (i > 0 && i + 1 < count) {
        const auto start = curve.at(from);
        here = curve.arcLengthMm(curve.slide(points[i], start));
        // A bead that got stuck at a bend: the nearest place of all.
        if ((curve.at(here).point - points[i]).norm() > 1e-3 * length)
          here = curve.arcLengthMm(curve.nearest(points[i]));
        here = std::max(from, here);
      }
      for (int step = i == 0 ? kStepsPerPoint : 1; step <= kStepsPerPoint; ++step)
        samples.push_back(curve.at(from + (here - from) * step / kStepsPerPoint).point);
      first.push_back(samples.size() - 1);
      from = here;
    }
  } catch (const Error&) {
    samples = points;
    first.clear();
    for (size_t i = 0; i < points.size(); ++i) first.push_back(i);
  }
  if (starts) *starts = std::move(first);
  return samples;
}

void buildCurve(Build& build, const Guide& guide, const Stance& stance) {
  if (guide.pointsMm.empty()) return;
  std::vector<size_t> starts;
  const std::vector<Vec3d> samples = sampleCurve(guide.pointsMm, guide.closed, &starts);
  const render::Colour colour = faded(guideColour(guide), stance.strength);
  const Target target{Target::Kind::thing, guide.id};
  build.line(samples, colour, stance.selected ? 3.5f : 2.5f);
  if (!stance.grabbed) return;
  if (!stance.selected) {
    Handle body;
    body.target = target;
    body.name = "body";
    body.anchor = samples.front();
    body.form = Form::unseen;
    body.points = samples;
    body.body = body.besideClay = body.anchorIsGrab = true;
    body.apply = applyRigid;
    build.handles.push_back(body);
    return;
  }
  for (size_t i = 0; i + 1 < starts.size(); ++i) {
    Handle between;
    between.target = target;
    between.name = "insert";
    between.index = int(i);
    between.form = Form::unseen;
    between.points.assign(samples.begin() + ptrdiff_t(starts[i]), samples.begin() + ptrdiff_t(starts[i + 1]) + 1);
    between.anchor = between.points.front();
    between.body = between.anchorIsGrab = between.toSurface = true;
    between.apply = applyInsert;
    build.handles.push_back(between);
  }
  for (size_t i = 0; i < guide.pointsMm.size(); ++i) {
    Handle dot;
    dot.target = target;
    dot.name = "point";
    dot.index = int(i);
    dot.anchor = guide.pointsMm[i];
    dot.points = {guide.pointsMm[i]};
    dot.colour = widget_colours::kHandle;
    dot.toSurface = true;
    dot.apply = applyPoint;
    build.handles.push_back(dot);
  }
}

}  // namespace argil::studio
