#include "haptics/touchable_part.h"

#include <algorithm>
#include <limits>

namespace argil::haptics {

bool TouchablePart::reset(const Part& part, double radiusMm) ARGIL_REALTIME {
  const PartMesh* mesh = part.mesh.get();
  const bool sameMesh = mesh_ == mesh && number_ == mesh->number();
  const bool same = sameMesh && pose_.translation == part.pose.translation && pose_.rotation.coeffs() == part.pose.rotation.coeffs();
  if (!same) {
    // No longer where they were; the triangle is still the best guess of where to begin.
    const uint32_t hint = sameMesh ? answers_[last_].triangle : PartMesh::kNone;
    answers_.fill({});
    answers_[last_] = {Vec3d::Constant(std::numeric_limits<double>::infinity()), hint};
  }
  mesh_ = mesh;
  number_ = mesh->number();
  pose_ = part.pose;
  resolution_ = std::min(mesh->resolutionMm(), radiusMm / 8);
  return !same;
}

Nearest TouchablePart::nearest(const Vec3d& p, double reachMm, const Vec3d*) ARGIL_REALTIME {
  const PartMesh::Hit hit = mesh_->nearest(pose_.applyInverse(p), reachMm, answers_[last_].triangle);
  if (hit.triangle == PartMesh::kNone) return {false, p, reachMm};
  last_ = (last_ + 1) % answers_.size();
  answers_[last_] = {pose_.apply(hit.point), hit.triangle};
  return {true, answers_[last_].point, hit.distance};
}

Vec3d TouchablePart::normal(const Vec3d& point) ARGIL_REALTIME {
  const Vec3d at = pose_.applyInverse(point);
  uint32_t triangle = PartMesh::kNone;
  for (const Answer& answer : answers_)
    if (answer.point == point) triangle = answer.triangle;
  // An older one: a search of next to no reach.
  if (triangle == PartMesh::kNone) triangle = mesh_->nearest(at, mesh_->resolutionMm(), answers_[last_].triangle).triangle;
  return pose_.rotation * mesh_->normal(triangle, at);
}

}  // namespace argil::haptics
