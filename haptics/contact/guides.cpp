#include "haptics/contact/guides.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kForceShare = 0.5;      // Of the peak, for all soft guides: clay stays felt.
constexpr double kStiffnessShare = 0.5;  // Of the sheet's top, for one soft guide.
constexpr double kDampingShare = 0.5;    // Of the sheet's top, for one soft guide.
// In peaks a second: how fast soft guides rise and are let go; with locks that move at once it stays unfelt.
constexpr double kSoftPerS = 4;
constexpr double kRiseS = 0.05;  // A soft guide comes to full strength in no less.
// Of the peak: a change of force that is larger than this and than twice what the way explains is a leap.
constexpr double kLeap = 0.001;

}  // namespace

void Guides::reset() noexcept {
  stateCount_ = 0;
  locks_.reset();
  keepOutCount_ = 0;
  keepOutsChanged_ = false;
  force_.setZero();
  carry_.setZero();
  begun_ = false;
}

uint32_t Guides::flags() const noexcept {
  return locks_.conflict() ? uint32_t{kGuideConflict} : 0u;
}

// A guide stops to work or is gone.
void Guides::drop(State& state, bool& lostHold) ARGIL_REALTIME {
  carry_ += state.force;
  state.force.setZero();
  state.weight = 0;
  state.caught = state.held = false;
  if (state.works && Guide::roleOf(state.kind) == GuideRole::keepOut) keepOutsChanged_ = lostHold = true;
  state.works = false;
}

// Brings the states into the order of the scene's guides, found by id; those of guides that are gone are dropped.
void Guides::match(const Scene& scene, bool& lostHold) ARGIL_REALTIME {
  const size_t count = std::min(scene.guides.size(), kMaxGuides);
  size_t known = stateCount_;
  for (size_t i = 0; i < count; ++i) {
    const Guide& guide = scene.guides[i];
    size_t j = i;
    while (j < known && states_[j].id != guide.id) ++j;
    if (j >= known) {
      // New: its place is made free at the end. There is room for as many again as a scene may hold.
      j = known++;
      states_[j] = State();
      states_[j].id = guide.id;
      states_[j].kind = guide.shape.index();
    }
    if (j != i) {
      std::swap(states_[i], states_[j]);
      keepOutsChanged_ = true;
    }
    if (states_[i].kind != guide.shape.index()) {
      drop(states_[i], lostHold);
      states_[i].kind = guide.shape.index();
    }
  }
  for (size_t i = count; i < known; ++i) drop(states_[i], lostHold);
  stateCount_ = count;
}

void Guides::addLock(const Guide& guide, State& state, const Vec3d& proxy, const Vec3d& touchNormal) ARGIL_REALTIME {
  if (const auto* point = std::get_if<LockToPoint>(&guide.shape)) {
    locks_.add(guide.id, Subspace::at(point->point));
  } else if (const auto* line = std::get_if<LockToLine>(&guide.shape)) {
    locks_.add(guide.id, Subspace::line(line->point, line->direction));
  } else if (const auto* plane = std::get_if<LockToPlane>(&guide.shape)) {
    locks_.add(guide.id, Subspace::plane(plane->point, plane->normal));
  } else if (const auto* curve = std::get_if<LockToCurve>(&guide.shape)) {
    locks_.add(guide.id, *curve->curve);
  } else {
    if (!state.held && !touchNormal.isZero(0)) {
      state.held = true;
      state.point = proxy;
      state.normal = touchNormal;
    }
    if (state.held) locks_.add(guide.id, Subspace::line(state.point, state.normal));
  }
}

// A hand that points feels no pull: what catches it holds it, as far as the well reaches.
void Guides::addLockOfWell(const Guide& guide, const Vec3d& hand) ARGIL_REALTIME {
  if (const auto* points = std::get_if<WellAtPoints>(&guide.shape)) {
    const Vec3d* nearest = nullptr;
    for (const Vec3d& point : points->points) {
      if (!nearest || (point - hand).squaredNorm() < (*nearest - hand).squaredNorm()) nearest = &point;
    }
    if (nearest) locks_.add(guide.id, Subspace::at(*nearest));
  } else if (const auto* curve = std::get_if<WellAtCurve>(&guide.shape)) {
    locks_.add(guide.id, *curve->curve);
  } else if (const auto* plane = std::get_if<WellAtPlane>(&guide.shape)) {
    locks_.add(guide.id, Subspace::plane(plane->point, plane->normal));
  }
}

// Strength rises slowly where a guide begins, so its energy is paid before it can be given out; a leap of its force
// (another point, another strand, other data) goes into what is let go little by little (carry_).
void Guides::addForce(const Guide& guide, State& state, const Scene& scene, TouchableClay* clay,
                      const Contact::Input& input, const SoftLimits& limits) ARGIL_REALTIME {
  const Pull pull = softPull(guide, scene, clay, input.hand, input.velocity, input.buttons, limits, state.memory);
  const double rate = kSoftPerS * input.peakForceN * input.periodS;
  state.caught = pull.within && (state.caught || pull.caught);
  if (!state.caught) state.weight = 0;
  Vec3d force = state.weight * pull.force;
  if (std::isfinite(pull.stiffnessNmm)) {
    const double explained = pull.stiffnessNmm * (begun_ ? (input.hand - at_).norm() : 0.0);
    explained_ = std::max(explained_, explained);
    if ((force - state.force).norm() > kLeap * input.peakForceN + 2 * explained) carry_ += state.force - force;
  }
  if (state.caught && state.weight < 1) {
    ++risingNow_;
    const double most = rate / (std::max(pull.mostN, 1e-9) * rising_);
    state.weight = std::min(1.0, state.weight + std::min(most, input.periodS / kRiseS));
    force = state.weight * pull.force;
  }
  state.force = force;
  force_ += force;
}

void Guides::begin(const Scene& scene, const Contact::Input& input, const Vec3d& proxy,
                   const Vec3d& touchNormal) ARGIL_REALTIME {
  keepOutsChanged_ = false;
  keepOutCount_ = 0;
  force_.setZero();
  locks_.begin();
  if (scene.guides.empty() && stateCount_ == 0 && carry_.isZero(0) && locks_.settled()) {
    begun_ = false;
    return;
  }
  bool lostHold = false;
  match(scene, lostHold);

  const double scale = scene.workspace.scale;
  const SoftLimits limits{kForceShare * input.peakForceN, kStiffnessShare * input.topStiffnessNmm / scale,
                          kDampingShare * input.topDampingNsmm / scale, input.periodS};
  rising_ = std::max(1, std::exchange(risingNow_, 0));
  explained_ = 0;
  size_t clays = 0;
  for (size_t i = 0; i < stateCount_; ++i) {
    const Guide& guide = scene.guides[i];
    State& state = states_[i];
    const bool worked = state.works;
    TouchableClay* clay = nullptr;
    if (guide.piece() >= 0 && clays < clays_.size()) clay = &clays_[clays++];
    if (guide.whileButtons != 0 && (guide.whileButtons & input.buttons) == 0) {
      if (worked) drop(state, lostHold);
      continue;
    }
    state.works = true;
    switch (guide.role()) {
      case GuideRole::lock:
        addLock(guide, state, proxy, touchNormal);
        break;
      case GuideRole::keepOut:
        keepOutsChanged_ = state.keepOut.reset(guide, scene, clay) || !worked || keepOutsChanged_;
        keepOuts_[size_t(keepOutCount_++)] = &state.keepOut;
        break;
      case GuideRole::soft:
        addForce(guide, state, scene, clay, input, limits);
        if (input.pointing && state.caught) addLockOfWell(guide, input.hand);
        break;
    }
  }
  // Through the stiffest coupling that there may be the set's speed is a speed of force as well.
  double slide = input.pointing ? kPointingSlideMms : kSlideMms;
  if (!input.pointing && input.peakForceN > 0 && input.topStiffnessNmm > 0)
    slide = std::min(slide, kGuideForcePerS * input.peakForceN / input.topStiffnessNmm);
  locks_.finish(proxy, input.hand, slide * scale * input.periodS, lostHold);

  // With the hand's way it fades faster, as fast as guides change along it: what it can give out is bounded however
  // fast that is.
  const double letGo = kSoftPerS * input.peakForceN * input.periodS + explained_, carried = carry_.norm();
  if (carried > letGo)
    carry_ *= (carried - letGo) / carried;
  else
    carry_.setZero();
  force_ += carry_;
  if (const double size = force_.norm(), most = kForceShare * input.peakForceN; size > most) force_ *= most / size;
  at_ = input.hand;
  begun_ = true;
}

}  // namespace argil::haptics
