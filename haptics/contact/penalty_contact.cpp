#include "haptics/contact/penalty_contact.h"

#include <algorithm>

#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kFlat = 1e-3;  // A gradient shorter than this, in voxels per voxel, has no direction.

// Central differences over one voxel on each side: each axis sees the field's jump, whichever side of it the hand is
// on.
Vec3d gradient(clay::Sampler& field, const Vec3d& at) ARGIL_REALTIME {
  Vec3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d step = Vec3d::Unit(axis);
    g[axis] = 0.5 * (double(field.trilinear(at + step)) - double(field.trilinear(at - step)));
  }
  return g;
}

}  // namespace

void PenaltyContact::reset() noexcept {
  normal_.fill(Vec3d::Zero());
}

Contact::Output PenaltyContact::tick(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Output out;
  out.proxy = out.cutPoint = input.hand;
  const size_t count = std::min(scene.pieces.size(), kMaxPieces);
  for (size_t i = 0; i < count; ++i) {
    const Piece& source = scene.pieces[i];
    TouchableClay& piece = pieces_[i];
    piece.reset(source);
    clay::Sampler& field = piece.surface().sampler();
    const Vec3d at = piece.toVoxel(input.hand);
    const double band = double(field.band()), voxel = piece.voxelMm();
    const double radius = std::min(scene.tool.radiusMm, (band - 1) * voxel);
    const double depth = radius - double(field.trilinear(at)) * voxel;
    if (!(depth > 0)) {
      normal_[i].setZero();
      continue;
    }
    const Vec3d g = gradient(field, at);
    if (const double slope = g.norm(); slope > kFlat) normal_[i] = source.pose.rotation * (g / slope);
    if (normal_[i].isZero()) continue;  // Begun deep inside: no side to push to.
    const double k =
        std::min(scene.materials[source.material].stiffnessNmm, input.topStiffnessNmm) / scene.workspace.scale;
    // Damping pushes outwards or less outwards, never inwards.
    const double damping = input.dampingNsmm / scene.workspace.scale;
    out.force += normal_[i] * std::max(0.0, k * depth - damping * input.velocity.dot(normal_[i]));
    out.depthMm = std::max(out.depthMm, depth);
    ++out.planes;
    out.flags |= kTouching;
  }
  if (const double size = out.force.norm(); size > input.peakForceN) {
    out.force *= input.peakForceN / size;
    out.flags |= kClamped;
  }
  return out;
}

}  // namespace argil::haptics
