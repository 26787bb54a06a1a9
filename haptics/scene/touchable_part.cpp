#include "haptics/scene/touchable_part.h"

#include <algorithm>

namespace argil::haptics {

bool TouchablePart::reads(const Part& part) const ARGIL_REALTIME {
  return mesh_ == part.mesh.get() && number_ == part.mesh->number();
}

bool TouchablePart::reset(const Part& part, double radiusMm) ARGIL_REALTIME {
  const bool same = reads(part);
  if (!same) answers_.fill({});
  mesh_ = part.mesh.get();
  number_ = mesh_->number();
  resolution_ = std::min(mesh_->resolutionMm(), radiusMm / 8);
  return !same;
}

void TouchablePart::move(const Pose& to) ARGIL_REALTIME {
  for (Answer& answer : answers_)
    if (answer.triangle != PartMesh::kNone) answer.point = carried(pose_, to, answer.point);
  pose_ = to;
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
  if (triangle == PartMesh::kNone)
    triangle = mesh_->nearest(at, mesh_->resolutionMm(), answers_[last_].triangle).triangle;
  return pose_.rotation * mesh_->normal(triangle, at);
}

}  // namespace argil::haptics
