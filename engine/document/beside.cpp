#include "engine/document/beside.h"

#include <limits>

namespace argil::engine {
namespace {

constexpr double kStepsAMm = 1000;  // Places that can be read: thousandths of a mm.
constexpr double kGap = 0.1;        // Between them, as a part of the new thing's width.

clay::BoxMm nothing() {
  const double far = std::numeric_limits<double>::infinity();
  return {Vec3d::Constant(far), Vec3d::Constant(-far)};
}

void add(clay::BoxMm& box, const clay::BoxMm& more) {
  box.low = box.low.cwiseMin(more.low);
  box.high = box.high.cwiseMax(more.high);
}

}  // namespace

clay::BoxMm boundsOf(const Piece& piece) {
  clay::BoxMm box = nothing();
  if (!piece.version || piece.version.stats().bricks == 0) return box;
  const clay::BoxMm own = clay::boundsOf(piece.version);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at =
        piece.pose.apply(Vec3d((corner & 1 ? own.high : own.low).x(), (corner & 2 ? own.high : own.low).y(),
                               (corner & 4 ? own.high : own.low).z()));
    add(box, {at, at});
  }
  return box;
}

clay::BoxMm boundsOf(const Part& part) {
  clay::BoxMm box = nothing();
  if (!part.mesh) return box;
  for (const Vec3d& position : part.mesh->positions) {
    const Vec3d at = part.pose.apply(position);
    add(box, {at, at});
  }
  return box;
}

clay::BoxMm boundsOf(const Document& document) {
  clay::BoxMm box = nothing();
  for (const Piece& piece : document.pieces) add(box, boundsOf(piece));
  for (const Part& part : document.parts) add(box, boundsOf(part));
  return box;
}

Vec3d moveBeside(const Document& document, const clay::BoxMm& box) {
  const clay::BoxMm all = boundsOf(document);
  if (!(all.low.x() <= all.high.x()) || !(box.low.x() <= box.high.x())) return Vec3d::Zero();
  const double gap = kGap * (box.high.x() - box.low.x());
  const Vec3d move(all.high.x() + gap - box.low.x(), (all.low.y() + all.high.y() - box.low.y() - box.high.y()) / 2,
                   all.low.z() - box.low.z());
  return (move * kStepsAMm).array().round().matrix() / kStepsAMm;
}

}  // namespace argil::engine
