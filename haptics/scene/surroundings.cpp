#include "haptics/scene/surroundings.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

const Pose kWorld;
constexpr double kOnSurface = 0.05;  // Of the resolution: a point this near to a surface lies on it.

}  // namespace

void Surroundings::clear() noexcept {
  count_ = clayCount_ = workedOn_ = movingCount_ = 0;
  for (Thing& thing : things_) thing = {};
  for (Motion& motion : motions_) motion = {};
}

void Surroundings::use(size_t index, Touchable& touchable, const Pose& pose, uint32_t material, bool hard,
                       bool changed) ARGIL_REALTIME {
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

// The scene has it there in this tick. True when it is somewhere else at once.
bool Surroundings::follow(Motion& m, const Pose& to, bool same) const ARGIL_REALTIME {
  if (!m.known || !same) {
    m = {};
    m.at = m.before = m.to = to;
    m.known = true;
    return true;
  }
  m.sinceS += periodS_;
  if (to.translation != m.to.translation || to.rotation.coeffs() != m.to.rotation.coeffs()) {
    m.to = to;
    m.gentle = m.sinceS > kRestS;
    m.leftS = m.gentle ? 0 : m.sinceS;
    m.sinceS = 0;
    m.moving = true;
  } else if (m.moving && m.sinceS > kRestS) {
    m.at = m.before = to;
    m.moving = false;
    return true;
  }
  return false;
}

bool Surroundings::reset(const Scene& scene, bool withClay, std::span<Touchable* const> keepOuts, bool keepOutsChanged,
                         double periodS) ARGIL_REALTIME {
  periodS_ = periodS;
  countBefore_ = count_;
  count_ = 0;
  movingCount_ = 0;
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
    if (stays) continue;
    things_[index] = {};
    if (index < kFirstKeepOut) motions_[index] = {};
  }
  for (size_t i = 0; i < clayCount_; ++i) {
    const bool felt = withClay || i >= workedOn_;
    Motion& motion = motions_[i];
    if (!felt) motion = {};  // What is worked on is where the tool works on it.
    bool changed = follow(motion, scene.pieces[i].pose, clay_[i].reads(scene.pieces[i]));
    changed = clay_[i].resetClay(scene.pieces[i]) || changed;
    if (changed) clay_[i].move(motion.at);
    if (!felt) continue;
    use(i, clay_[i], motion.at, scene.pieces[i].material, false, changed);
    if (motion.moving) moving_[movingCount_++] = static_cast<int>(i);
  }
  for (size_t i = 0; i < partCount; ++i) {
    const size_t index = kFirstPart + i;
    Motion& motion = motions_[index];
    bool changed = follow(motion, scene.parts[i].pose, parts_[i].reads(scene.parts[i]));
    changed = parts_[i].reset(scene.parts[i], scene.tool.radiusMm) || changed;
    if (changed) parts_[i].move(motion.at);
    use(index, parts_[i], motion.at, scene.parts[i].material, false, changed);
    if (motion.moving) moving_[movingCount_++] = static_cast<int>(index);
  }
  for (size_t i = 0; i < keepOutCount; ++i) use(kFirstKeepOut + i, *keepOuts[i], kWorld, 0, true, keepOutsChanged);
  return changed_ || count_ != countBefore_;
}

void Surroundings::startMotion(const Vec3d& p, std::span<const int> touching, double gentleMm) ARGIL_REALTIME {
  for (size_t k = 0; k < movingCount_; ++k) {
    const int thing = moving_[k];
    Motion& m = motions_[size_t(thing)];
    double share = 1;
    if (m.gentle) {
      const double all = (carried(m.at, m.to, p) - p).norm();
      if (std::find(touching.begin(), touching.end(), thing) != touching.end() && all > gentleMm)
        share = gentleMm / all;
    } else if (m.leftS > periodS_) {
      share = periodS_ / m.leftS;
      m.leftS -= periodS_;
    }
    m.start = m.before = m.at;
    m.goal = mix(m.at, m.to, share);
  }
}

double Surroundings::way(const Vec3d& p, double from, double to) const ARGIL_REALTIME {
  double longest = 0;
  for (size_t k = 0; k < movingCount_; ++k) {
    const Motion& m = motions_[size_t(moving_[k])];
    longest = std::max(longest,
                       (mix(m.start, m.goal, to).applyInverse(p) - mix(m.start, m.goal, from).applyInverse(p)).norm());
  }
  return longest;
}

// It is felt there from now on, and what is known of it went along.
void Surroundings::felt(size_t index, const Pose& at) ARGIL_REALTIME {
  Motion& m = motions_[index];
  m.before = m.at;
  m.at = at;
  Thing& thing = things_[index];
  thing.from = carried(m.before, at, thing.from);
  thing.near = carried(m.before, at, thing.near);
  if (index < kFirstPart)
    clay_[index].move(at);
  else
    parts_[index - kFirstPart].move(at);
}

void Surroundings::advance(double part) ARGIL_REALTIME {
  for (size_t k = 0; k < movingCount_; ++k) {
    const Motion& m = motions_[size_t(moving_[k])];
    felt(size_t(moving_[k]), part <= 0 ? m.start : mix(m.start, m.goal, part));
  }
}

void Surroundings::holdIfGentle(int thing) ARGIL_REALTIME {
  if (!moves(thing) || !motions_[size_t(thing)].gentle) return;
  Motion& m = motions_[size_t(thing)];
  m.start = m.goal = m.at;
}

void Surroundings::endMotion() ARGIL_REALTIME {
  for (size_t k = 0; k < movingCount_; ++k) {
    Motion& m = motions_[size_t(moving_[k])];
    m.moving = m.at.translation != m.to.translation || m.at.rotation.coeffs() != m.to.rotation.coeffs();
  }
}

Vec3d Surroundings::carriedBy(int thing, const Vec3d& place) const ARGIL_REALTIME {
  if (!moves(thing)) return place;
  return carried(motions_[size_t(thing)].before, motions_[size_t(thing)].at, place);
}

Vec3d Surroundings::turnedBy(int thing, const Vec3d& direction) const ARGIL_REALTIME {
  if (!moves(thing)) return direction;
  return motions_[size_t(thing)].at.rotation * (motions_[size_t(thing)].before.rotation.conjugate() * direction);
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
