#include "haptics/surroundings.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

const Pose kWorld;
constexpr double kOnSurface = 0.05;  // Of the resolution: a point this near to a surface lies on it.

}  // namespace

void Surroundings::clear() noexcept {
  count_ = clayCount_ = workedOn_ = 0;
  for (Thing& thing : things_) thing = {};
}

void Surroundings::use(size_t index, Touchable& touchable, const Pose& pose, uint32_t material, bool hard, bool changed) ARGIL_REALTIME {
  Thing& thing = things_[index];
  changed = changed || thing.touchable != &touchable;
  thing.touchable = &touchable;
  thing.pose = &pose;
  thing.material = material;
  thing.hard = hard;
  if (changed) thing.bound = -1;  // Where it was is still the best guess of where it is.
  changed_ = changed_ || changed;
  const double resolution = touchable.resolutionMm();
  resolution_ = count_ == 0 ? resolution : std::min(resolution_, resolution);
  used_[count_++] = static_cast<int>(index);
}

bool Surroundings::reset(const Scene& scene, bool withClay, std::span<Touchable* const> keepOuts, bool keepOutsChanged) ARGIL_REALTIME {
  countBefore_ = count_;
  count_ = 0;
  changed_ = false;
  resolution_ = 1;
  clayCount_ = std::min(scene.pieces.size(), kMaxPieces);
  workedOn_ = std::min(scene.workedOn, clayCount_);
  const size_t partCount = std::min(scene.parts.size(), kMaxParts);
  const size_t keepOutCount = std::min(keepOuts.size(), kMaxGuides);
  for (size_t i = 0; i < countBefore_; ++i) {
    const auto index = size_t(used_[i]);
    const bool stays = index < kFirstPart      ? index < clayCount_ && (withClay || index >= workedOn_)
                       : index < kFirstKeepOut ? index - kFirstPart < partCount
                                               : index - kFirstKeepOut < keepOutCount;
    if (!stays) things_[index] = {};
  }
  for (size_t i = 0; i < clayCount_; ++i) {
    const bool changed = clay_[i].reset(scene.pieces[i]);
    if (withClay || i >= workedOn_) use(i, clay_[i], scene.pieces[i].pose, scene.pieces[i].material, false, changed);
  }
  for (size_t i = 0; i < partCount; ++i) {
    const bool changed = parts_[i].reset(scene.parts[i], scene.tool.radiusMm);
    use(kFirstPart + i, parts_[i], scene.parts[i].pose, scene.parts[i].material, false, changed);
  }
  for (size_t i = 0; i < keepOutCount; ++i) use(kFirstKeepOut + i, *keepOuts[i], kWorld, 0, true, keepOutsChanged);
  return changed_ || count_ != countBefore_;
}

Around Surroundings::nearest(const Vec3d& p, double reachMm) ARGIL_REALTIME {
  Around best{{false, p, reachMm}, -1};
  for (size_t i = 0; i < count_; ++i) {
    Thing& thing = things_[size_t(used_[i])];
    // A surface comes nearer by no more than the way; from outside, that is: inside, bounds are not kept.
    if (thing.bound - (p - thing.from).norm() >= best.distance) continue;
    const Nearest n = thing.touchable->nearest(p, reachMm, thing.nearKnown ? &thing.near : nullptr);
    thing.from = p;
    thing.bound = n.distance;
    thing.nearKnown = n.found;
    if (n.found) thing.near = n.point;
    if (n.distance < best.distance) best = {n, used_[i]};
  }
  return best;
}

bool Surroundings::inside(const Vec3d& p) ARGIL_REALTIME {
  for (TouchableClay& piece : std::span(clay_).first(clayCount_))
    if (piece.surface().inside(piece.toVoxel(p))) return true;
  return false;
}

bool Surroundings::holds(int thing, const Vec3d& point) ARGIL_REALTIME {
  if (!there(thing)) return false;
  Touchable& touchable = *things_[size_t(thing)].touchable;
  return touchable.nearest(point, kOnSurface * touchable.resolutionMm(), &point).found;
}

}  // namespace argil::haptics
