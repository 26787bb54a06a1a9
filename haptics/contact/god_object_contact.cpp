#include "haptics/contact/god_object_contact.h"

#include <algorithm>
#include <cmath>

#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

// Lengths in voxels of the finest piece.
constexpr double kStep = 0.5;        // Through free space: shorter than any wall that the field can hold.
constexpr double kSlide = 0.5;       // Along tangent planes before the surface is looked for anew.
constexpr double kClearance = 0.01;  // The point rests this far outside: its next step begins in free space.
constexpr double kOnSurface = 1e-3;
constexpr double kStill = 1e-3;  // A shorter slide is none.

constexpr double kForget = 0.5;  // A plane that the point has left this far is forgotten.

constexpr int kSteps = 64;  // A tick, of both kinds: bounds its cost; what is left is for the next tick.
constexpr int kPlanes = 3;
constexpr int kNewton = 6;
constexpr int kBisections = 10;
constexpr double kFlat = 1e-3;        // A gradient shorter than this has no direction.
constexpr double kSamePlane = 0.995;  // Planes within 6° are one: the newer.

}  // namespace

GodObjectContact::Value GodObjectContact::value(const Vec3d& world) ARGIL_REALTIME {
  Value least{1e300, 0};
  for (size_t i = 0; i < used_.size(); ++i) {
    const double mm = double(used_[i].surface().sampler().trilinear(used_[i].toVoxel(world))) * used_[i].voxelMm();
    if (mm < least.mm) least = {mm, i};
  }
  return least;
}

// World direction, mm per mm.
Vec3d GodObjectContact::gradient(size_t piece, const Vec3d& world) ARGIL_REALTIME {
  Vec3f g;
  used_[piece].surface().sampler().trilinear(used_[piece].toVoxel(world), g);
  return (used_[piece].toWorld(g.cast<double>()) - used_[piece].toWorld(Vec3d::Zero())) / used_[piece].voxelMm();
}

// Along the gradient to the surface, just outside of it. False where the field says nothing.
bool GodObjectContact::project(Vec3d& at, Vec3d& normal) ARGIL_REALTIME {
  const double wanted = kClearance * voxel_;
  for (int i = 0; i < kNewton; ++i) {
    const Value v = value(at);
    const Vec3d g = gradient(v.piece, at);
    const double slope2 = g.squaredNorm();
    if (slope2 < kFlat * kFlat) return false;
    normal = g / std::sqrt(slope2);
    const double off = wanted - v.mm;
    if (std::abs(off) <= kOnSurface * voxel_) return true;
    at += g * std::clamp(off / slope2, -voxel_ / std::sqrt(slope2), voxel_ / std::sqrt(slope2));
  }
  return value(at).mm > 0;
}

// Straight towards the goal until clay; true when it was met.
bool GodObjectContact::march(const Vec3d& goal, int& steps) ARGIL_REALTIME {
  while (steps < kSteps) {
    const Vec3d way = goal - place_;
    const double length = way.norm();
    if (length <= 0) return false;
    const double part = std::min(1.0, kStep * voxel_ / length);
    ++steps;
    if (!(value(place_ + part * way).mm <= 0)) {
      if (part == 1.0) {
        place_ = goal;
        return false;
      }
      place_ += part * way;
      continue;
    }
    double free = 0, blocked = part;
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (free + blocked);
      (value(place_ + middle * way).mm > 0 ? free : blocked) = middle;
    }
    place_ += free * way;
    return true;
  }
  return false;
}

// To the surface, then in its tangent planes and down to it again, each part nearer to the hand than the one before.
void GodObjectContact::follow(const Vec3d& hand, Output& out) ARGIL_REALTIME {
  HalfSpace planes[kPlanes];
  int count = 0, steps = 0;
  while (march(hand, steps)) {
    Vec3d normal;
    if (!project(place_, normal)) {  // In the bottom of a crease the field is flat: it stays.
      out.planes = std::max(out.planes, 1);
      return;
    }
    int kept = 0;
    for (int i = 0; i < count; ++i)
      if (planes[i].normal.dot(normal) < kSamePlane &&
          planes[i].normal.dot(place_) < planes[i].offset + kForget * voxel_)
        planes[kept++] = planes[i];
    count = std::min(kept, kPlanes - 1);
    planes[count++] = {normal, normal.dot(place_)};
    const ActiveSet target = nearestAllowed(hand, planes, count);
    out.planes = target.feasible ? target.count : count;
    if (!target.feasible) return;
    Vec3d slide = target.x - place_;
    const double length = slide.norm();
    if (length < kStill * voxel_) return;
    if (const double longest = kSlide * voxel_; length > longest) slide *= longest / length;
    const Vec3d goal = place_ + slide;
    march(goal, steps);
  }
  if (steps >= kSteps)
    out.flags |= kIncomplete;
  else
    out.planes = 0;
}

Contact::Output GodObjectContact::tick(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Output out;
  used_ = std::span(pieces_).first(std::min(scene.pieces.size(), kMaxPieces));
  for (size_t i = 0; i < used_.size(); ++i) {
    used_[i].reset(scene.pieces[i]);
    voxel_ = i ? std::min(voxel_, used_[i].voxelMm()) : used_[i].voxelMm();
  }
  if (!begun_) place_ = input.hand;
  begun_ = true;
  if (used_.empty()) {
    place_ = input.hand;
  } else {
    // Clay grew over the point: out along the gradient where the field has one, else it is lost.
    Vec3d normal;
    if (value(place_).mm > 0 || project(place_, normal))
      follow(input.hand, out);
    else
      place_ = input.hand;
  }
  out.proxy = out.cutPoint = place_;
  if (out.planes == 0) return out;
  out.flags |= kTouching;
  const Vec3d stretch = place_ - input.hand;
  out.depthMm = stretch.norm();
  if (out.depthMm > 1e-9) {
    const double k =
        std::min(scene.materials[scene.pieces[0].material].stiffnessNmm, input.topStiffnessNmm) / scene.workspace.scale;
    const double damping = input.dampingNsmm / scene.workspace.scale;
    const Vec3d normal = stretch / out.depthMm;
    out.force = normal * std::max(0.0, k * out.depthMm - damping * input.velocity.dot(normal));
  }
  if (const double size = out.force.norm(); size > input.peakForceN) {
    out.force *= input.peakForceN / size;
    out.flags |= kClamped;
  }
  return out;
}

}  // namespace argil::haptics
