#include "haptics/touchable.h"

namespace argil::haptics {

bool TouchableClay::reset(const Piece& piece) ARGIL_REALTIME {
  const clay::Grid& grid = piece.version.grid();
  // Addresses of records are reused, ids are per store: both together name a version.
  const bool same = record_ == piece.version.record() && id_ == piece.version.id() && voxelMm_ == grid.voxelMm &&
                    origin_ == grid.originMm && pose_.translation == piece.pose.translation &&
                    pose_.rotation.coeffs() == piece.pose.rotation.coeffs();
  surface_.reset(piece.version);
  record_ = piece.version.record();
  id_ = piece.version.id();
  voxelMm_ = grid.voxelMm;
  origin_ = grid.originMm;
  pose_ = piece.pose;
  if (!same) {
    const Eigen::Matrix3d turn = pose_.rotation.toRotationMatrix();
    toVoxel_ = turn.transpose() / voxelMm_;
    toWorld_ = turn * voxelMm_;
    offset_ = origin_ / voxelMm_;
  }
  return !same;
}

Nearest TouchableClay::nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME {
  const Vec3d at = toVoxel(p);
  Vec3d near = Vec3d::Zero();
  if (hint) near = toVoxel(*hint);
  const SurfacePoint found = surface_.nearest(at, reachMm / voxelMm_, hint ? &near : nullptr);
  const double sign = surface_.inside(at) ? -1.0 : 1.0;
  if (!found.found) return {false, p, sign * reachMm};
  return {true, toWorld(found.point), sign * found.distance * voxelMm_};
}

Vec3d TouchableClay::normal(const Vec3d& point) ARGIL_REALTIME {
  Vec3f gradient;
  surface_.sampler().tricubic(toVoxel(point), gradient);
  const double length = double(gradient.norm());
  return length > 1e-3 ? Vec3d(toWorld_ * gradient.cast<double>() / (length * voxelMm_)) : Vec3d::Zero();
}

}  // namespace argil::haptics
