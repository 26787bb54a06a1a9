#include "haptics/scene/touchable.h"

#include <algorithm>

namespace argil::haptics {
namespace {

constexpr int kMostLooks = 128;  // Along the way into clay.

}  // namespace

bool TouchableClay::reset(const Piece& piece) ARGIL_REALTIME {
  const bool moved =
      pose_.translation != piece.pose.translation || pose_.rotation.coeffs() != piece.pose.rotation.coeffs();
  const bool changed = resetClay(piece);
  if (!moved) return changed;
  pose_ = piece.pose;
  orient();
  return true;
}

bool TouchableClay::resetClay(const Piece& piece) ARGIL_REALTIME {
  const clay::Grid& grid = piece.version.grid();
  // Addresses of records are reused, ids are per store: both together name a version.
  const bool same = record_ == piece.version.record() && id_ == piece.version.id() && voxelMm_ == grid.voxelMm &&
                    origin_ == grid.originMm && hideMasked_ == piece.hideMasked;
  surface_.reset(piece.version, piece.hideMasked);
  hideMasked_ = piece.hideMasked;
  record_ = piece.version.record();
  store_ = piece.version.store().get();
  id_ = piece.version.id();
  voxelMm_ = grid.voxelMm;
  origin_ = grid.originMm;
  version_ = &piece.version;
  rows_ = piece.rows && piece.version.has(clay::Channel::material) ? piece.rows.get() : nullptr;
  material_ = piece.material;
  if (!same) {
    rowBrick_ = {INT32_MIN, 0, 0};
    orient();
  }
  return !same;
}

void TouchableClay::move(const Pose& to) ARGIL_REALTIME {
  free_ = carried(pose_, to, free_);
  pose_ = to;
  orient();
}

void TouchableClay::orient() ARGIL_REALTIME {
  const Eigen::Matrix3d turn = pose_.rotation.toRotationMatrix();
  toVoxel_ = turn.transpose() / voxelMm_;
  toWorld_ = turn * voxelMm_;
  offset_ = origin_ / voxelMm_;
}

uint32_t TouchableClay::material(Coord voxel) ARGIL_REALTIME {
  if (!mixed()) return material_;
  const Coord brick = voxel >> 3;
  if (brick != rowBrick_) {
    rowBrick_ = brick;
    rowSlot_ = version_->find(clay::Channel::material, brick);
  }
  return (*rows_)[rowSlot_.value(clay::Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7))];
}

// In clay, unless it came in through clay that is hidden: what is left is then a sheet, felt from behind. Clay that
// grew over a free place is solid.
bool TouchableClay::solid(const Vec3d& world, const Vec3d& at) ARGIL_REALTIME {
  const bool inside = surface_.inside(at);
  if (!surface_.hides()) {
    within_ = freeKnown_ = false;
    return inside;
  }
  if (!inside) {
    free_ = world;
    freeKnown_ = true;
    within_ = false;
    return false;
  }
  if (within_ || !freeKnown_) return !within_;
  const Vec3d from = toVoxel(free_);
  const int steps = std::clamp(static_cast<int>(2 * (at - from).norm()), 1, kMostLooks);
  for (int i = 0; i <= steps && !within_; ++i) {
    const Vec3d here = from + (at - from) * (double(i) / steps);
    if (!surface_.inside(here)) continue;
    within_ = i > 0 && surface_.hidden(here);
    break;
  }
  return !within_;
}

Nearest TouchableClay::nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME {
  const Vec3d at = toVoxel(p);
  Vec3d near = Vec3d::Zero();
  if (hint) near = toVoxel(*hint);
  const SurfacePoint found = surface_.nearest(at, reachMm / voxelMm_, hint ? &near : nullptr);
  // Less than a voxel is asked of places on the surface itself, which say nothing about the side.
  const double sign = reachMm < voxelMm_ ? (surface_.inside(at) && !(within_ && surface_.hides()) ? -1.0 : 1.0)
                      : solid(p, at)     ? -1.0
                                         : 1.0;
  if (!found.found) return {false, p, sign * reachMm};
  return {true, toWorld(found.point), sign * found.distance * voxelMm_};
}

Vec3d TouchableClay::normal(const Vec3d& point) ARGIL_REALTIME {
  if (surface_.hides()) {
    // The rim of what is left is an edge, though the field goes on.
    const Vec3d at = toVoxel(point);
    for (int axis = 0; axis < 3; ++axis)
      if (surface_.hidden(Vec3d(at + Vec3d::Unit(axis))) || surface_.hidden(Vec3d(at - Vec3d::Unit(axis))))
        return Vec3d::Zero();
  }
  Vec3f gradient;
  surface_.sampler().tricubic(toVoxel(point), gradient);
  const double length = double(gradient.norm());
  return length > 1e-3 ? Vec3d(toWorld_ * gradient.cast<double>() / (length * voxelMm_)) : Vec3d::Zero();
}

}  // namespace argil::haptics
