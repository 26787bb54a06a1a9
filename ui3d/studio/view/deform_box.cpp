#include "ui3d/studio/view/deform_box.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/store/sampler.h"
#include "clay/whole/deform.h"

namespace argil::studio {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kLeastRange = 1;  // Percent of the extent: a range must have a length.

// Where the way from each point of the lattice to the middle of its box meets the clay; where it meets none, the point.
std::vector<Vec3d> placesUnder(const clay::Lattice& lattice, const clay::Version& version) {
  clay::Sampler sampler(version);
  const clay::Grid& grid = version.grid();
  const Vec3d middle = (lattice.box().low + lattice.box().high) / 2;
  std::vector<Vec3d> places;
  for (size_t i = 0; i < lattice.points().size(); ++i) {
    const Vec3d from = lattice.restPoint(i);
    const int steps = std::max(1, static_cast<int>(std::ceil((middle - from).norm() / grid.voxelMm)));
    Vec3d place = from;
    for (int k = 0; k <= steps; ++k) {
      const Vec3d at = from + (middle - from) * (static_cast<double>(k) / steps);
      const Vec3d voxel = grid.toVoxel(at).array().round();
      if (sampler.voxel(
              {static_cast<int32_t>(voxel.x()), static_cast<int32_t>(voxel.y()), static_cast<int32_t>(voxel.z())}) >= 0)
        continue;
      place = at;
      break;
    }
    places.push_back(place);
  }
  return places;
}

std::shared_ptr<const clay::Warp> together(std::vector<std::shared_ptr<const clay::Warp>> warps) {
  if (warps.empty()) return nullptr;
  if (warps.size() == 1) return warps.front();
  return std::make_shared<clay::WarpChain>(std::move(warps));
}

}  // namespace

DeformBox DeformBox::around(const engine::Piece& piece) {
  const clay::BoxMm bounds = clay::boundsOf(piece.version);
  // As close around the clay as a deformation allows: a point far from it would hardly move it.
  const clay::Grid& grid = piece.version.grid();
  const Vec3d beyond = Vec3d::Constant((static_cast<double>(grid.band) + 1) * grid.voxelMm);
  DeformBox box{.piece = piece.id,
                .pose = piece.pose,
                .base = piece.version,
                .bounds = bounds,
                .lattice = clay::Lattice({bounds.low - beyond, bounds.high + beyond}),
                .clayPlaces = {}};
  box.clayPlaces = placesUnder(box.lattice, box.base);
  return box;
}

void DeformBox::setCounts(const std::array<int, 3>& counts) {
  lattice = clay::Lattice(lattice.box(), counts);
  clayPlaces = placesUnder(lattice, base);
}

void DeformBox::rest() {
  setCounts(lattice.counts());
  bendDegrees = twistDegrees = 0;
  taperPercent = 100;
}

std::shared_ptr<const clay::Warp> DeformBox::warpAfterLattice() const {
  clay::WarpAxis along;
  along.originMm = (bounds.low + bounds.high) / 2;
  along.direction = Vec3d::Unit(axis);
  const double size = bounds.high[axis] - bounds.low[axis], from = std::min(fromPercent, 100 - kLeastRange);
  along.fromMm = size * (from / 100 - 0.5);
  along.toMm = size * (std::max(toPercent, from + kLeastRange) / 100 - 0.5);
  std::vector<std::shared_ptr<const clay::Warp>> warps;
  // Bent last: the others go along the axis while it is straight.
  if (taperPercent != 100) warps.push_back(std::make_shared<clay::Taper>(along, taperPercent / 100));
  if (twistDegrees != 0) warps.push_back(std::make_shared<clay::Twist>(along, twistDegrees * kDegree));
  if (bendDegrees != 0) {
    const clay::Turn turn = clay::turnBy(bendTowards * kDegree);
    warps.push_back(std::make_shared<clay::Bend>(
        along, turn.cosine * Vec3d::Unit((axis + 1) % 3) + turn.sine * Vec3d::Unit((axis + 2) % 3),
        bendDegrees * kDegree));
  }
  return together(std::move(warps));
}

std::shared_ptr<const clay::Warp> DeformBox::warp() const {
  std::vector<std::shared_ptr<const clay::Warp>> warps;
  if (lattice.moved()) warps.push_back(std::make_shared<clay::Lattice>(lattice));
  if (auto after = warpAfterLattice()) warps.push_back(std::move(after));
  return together(std::move(warps));
}

bool DeformBox::sameShape(const DeformBox& o) const {
  if (lattice.counts() != o.lattice.counts() || lattice.points() != o.lattice.points()) return false;
  if (bendDegrees != o.bendDegrees || twistDegrees != o.twistDegrees || taperPercent != o.taperPercent) return false;
  if (bendDegrees == 0 && twistDegrees == 0 && taperPercent == 100) return true;
  return axis == o.axis && fromPercent == o.fromPercent && toPercent == o.toPercent &&
         (bendDegrees == 0 || bendTowards == o.bendTowards);
}

}  // namespace argil::studio
