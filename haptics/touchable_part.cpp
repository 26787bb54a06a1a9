#include "haptics/touchable_part.h"

#include <algorithm>

namespace argil::haptics {

bool TouchablePart::reset(const Part& part, double radiusMm) ARGIL_REALTIME {
  const PartMesh* mesh = part.mesh.get();
  const bool sameMesh = mesh_ == mesh && number_ == mesh->number();
  const bool same = sameMesh && pose_.translation == part.pose.translation && pose_.rotation.coeffs() == part.pose.rotation.coeffs();
  if (!sameMesh) last_ = PartMesh::kNone;
  mesh_ = mesh;
  number_ = mesh->number();
  pose_ = part.pose;
  resolution_ = std::min(mesh->resolutionMm(), radiusMm / 8);
  return !same;
}

Nearest TouchablePart::nearest(const Vec3d& p, double reachMm, const Vec3d*) ARGIL_REALTIME {
  const PartMesh::Hit hit = mesh_->nearest(pose_.applyInverse(p), reachMm, last_);
  if (hit.triangle == PartMesh::kNone) return {false, p, reachMm};
  last_ = hit.triangle;
  return {true, pose_.apply(hit.point), hit.distance};
}

Vec3d TouchablePart::normal(const Vec3d& point) ARGIL_REALTIME {
  const Vec3d at = pose_.applyInverse(point);
  // The point need not be of the last answer: which triangle holds it is a search of no reach.
  const PartMesh::Hit hit = mesh_->nearest(at, mesh_->resolutionMm(), last_);
  if (hit.triangle == PartMesh::kNone) return Vec3d::Zero();
  const Vec3d normal = mesh_->normal(hit.triangle, hit.point);
  return pose_.rotation * normal;
}

}  // namespace argil::haptics
