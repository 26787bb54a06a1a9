#include "ui3d/studio/view/deform_box.h"

#include <algorithm>

#include "clay/whole/deform.h"

namespace argil::studio {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kLeastRange = 1;  // Percent of the extent: a range must have a length.

}  // namespace

DeformBox DeformBox::around(const engine::Piece& piece) {
  return {.piece = piece.id,
          .pose = piece.pose,
          .base = piece.version,
          .bounds = clay::boundsOf(piece.version),
          .lattice = clay::Lattice::around(clay::brickBoundsOf(piece.version))};
}

void DeformBox::setCounts(const std::array<int, 3>& counts) {
  lattice = clay::Lattice(lattice.box(), counts);
}

void DeformBox::rest() {
  setCounts(lattice.counts());
  bendDegrees = twistDegrees = 0;
  taperPercent = 100;
}

std::shared_ptr<const clay::Warp> DeformBox::warp() const {
  if (kind == Kind::lattice) return lattice.moved() ? std::make_shared<clay::Lattice>(lattice) : nullptr;
  clay::WarpAxis along;
  along.originMm = (bounds.low + bounds.high) / 2;
  along.direction = Vec3d::Unit(axis);
  const double size = bounds.high[axis] - bounds.low[axis], from = std::min(fromPercent, 100 - kLeastRange);
  along.fromMm = size * (from / 100 - 0.5);
  along.toMm = size * (std::max(toPercent, from + kLeastRange) / 100 - 0.5);
  switch (kind) {
    case Kind::bend: {
      if (bendDegrees == 0) return nullptr;
      const clay::Turn turn = clay::turnBy(bendTowards * kDegree);
      return std::make_shared<clay::Bend>(
          along, turn.cosine * Vec3d::Unit((axis + 1) % 3) + turn.sine * Vec3d::Unit((axis + 2) % 3),
          bendDegrees * kDegree);
    }
    case Kind::twist:
      return twistDegrees == 0 ? nullptr : std::make_shared<clay::Twist>(along, twistDegrees * kDegree);
    case Kind::taper:
      return taperPercent == 100 ? nullptr : std::make_shared<clay::Taper>(along, taperPercent / 100);
    case Kind::lattice:
      break;
  }
  return nullptr;
}

bool DeformBox::sameShape(const DeformBox& o) const {
  if (kind != o.kind) return false;
  if (kind == Kind::lattice) return lattice.counts() == o.lattice.counts() && lattice.points() == o.lattice.points();
  if (axis != o.axis || fromPercent != o.fromPercent || toPercent != o.toPercent) return false;
  return kind == Kind::bend    ? bendDegrees == o.bendDegrees && bendTowards == o.bendTowards
         : kind == Kind::twist ? twistDegrees == o.twistDegrees
                               : taperPercent == o.taperPercent;
}

}  // namespace argil::studio
