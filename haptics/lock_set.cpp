#include "haptics/lock_set.h"

#include <algorithm>

namespace argil::haptics {
namespace {

constexpr int kNewton = 12;         // Steps to where a curve meets another lock.
constexpr double kMetMm = 1e-11;

void shorten(Vec3d& v, double by) noexcept {
  const double length = v.norm();
  if (length <= by) v.setZero();
  else v *= (length - by) / length;
}

}  // namespace

void LockSet::reset() noexcept {
  count_ = countBefore_ = 0;
  conflict_ = false;
  aside_.setZero();
  back_.setZero();
}

void LockSet::add(uint32_t id, const Subspace& set) ARGIL_REALTIME {
  if (count_ == kMostLocks) {
    conflict_ = true;
    return;
  }
  Lock& lock = locks_[size_t(count_++)];
  lock.id = id;
  lock.set = set;
  lock.curve = nullptr;
  lock.curveId = 0;
}

void LockSet::add(uint32_t id, const Polyline& curve) ARGIL_REALTIME {
  add(id, Subspace());
  if (conflict_) return;
  locks_[size_t(count_ - 1)].curve = &curve;
  locks_[size_t(count_ - 1)].curveId = curve.id();
}

// The affine sets of all locks at a place, met one after the other. `foot`: that of p on the curves, if there are any. Without
// `works` only those that work are met; with it each is tried and told of.
Subspace LockSet::common(const Vec3d& p, Vec3d* foot, std::array<bool, kMostLocks>* works) const ARGIL_REALTIME {
  Subspace all;
  for (int i = 0; i < count_; ++i) {
    const Lock& lock = locks_[size_t(i)];
    if (!works && !lock.works) continue;
    bool met = false;
    if (lock.curve) {
      const Polyline::Place place = lock.curve->slide(p, lock.place);
      met = all.intersect(Subspace::line(place.point, place.tangent));
      if (met && foot) *foot = place.point;
    } else {
      met = all.intersect(lock.set);
    }
    if (works) (*works)[size_t(i)] = met;
  }
  return all;
}

Vec3d LockSet::snapTrue(const Vec3d& p) const ARGIL_REALTIME {
  if (!curved_) return flat_.nearest(p);
  Vec3d x = p;
  for (int i = 0; i < kNewton; ++i) {
    Vec3d foot = x;
    const Subspace all = common(x, &foot, nullptr);
    if (all.dimension > 0) return all.nearest(foot);
    const double step = (all.origin - x).norm();
    x = all.origin;
    if (step < kMetMm) break;
  }
  return x;
}

void LockSet::finish(const Vec3d& proxy, const Vec3d& hand, double slideMm, bool lostHold) ARGIL_REALTIME {
  const bool was = countBefore_ > 0;
  if (count_ == 0 && !was && !lostHold && settled()) return;
  const Vec3d on = proxy - aside_;
  curved_ = false;
  for (int i = 0; i < count_; ++i) {
    Lock& lock = locks_[size_t(i)];
    if (!lock.curve) continue;
    curved_ = true;
    const Lock* old = nullptr;
    for (int j = 0; j < countBefore_; ++j)
      if (before_[size_t(j)].id == lock.id && before_[size_t(j)].curveId == lock.curveId) old = &before_[size_t(j)];
    lock.place = old ? lock.curve->slide(on, old->place) : lock.curve->nearest(proxy);
  }
  std::array<bool, kMostLocks> works{};
  flat_ = common(on, nullptr, &works);
  bool same = count_ == countBefore_;
  for (int i = 0; i < count_; ++i) {
    Lock& lock = locks_[size_t(i)];
    lock.works = works[size_t(i)];
    conflict_ = conflict_ || !lock.works;
    same = same && lock.same(before_[size_t(i)]);
  }
  if (!same || lostHold) {
    aside_.setZero();
    if (count_ > 0) aside_ = proxy - snapTrue(proxy);
    back_ = at(proxy).along(proxy - hand);
  }
  // Both at once change the force by no more than one would.
  const double part = aside_.isZero(0) || back_.isZero(0) ? 1.0 : 0.7;
  shorten(aside_, part * slideMm);
  shorten(back_, part * slideMm);
  for (int i = 0; i < count_; ++i) before_[size_t(i)] = locks_[size_t(i)];
  countBefore_ = count_;
}

Vec3d LockSet::goal(const Vec3d& hand) const ARGIL_REALTIME {
  const Vec3d wanted = hand + back_;
  return curved_ && count_ > 0 ? snap(wanted) : wanted;
}

Subspace LockSet::at(const Vec3d& p) const ARGIL_REALTIME {
  if (count_ == 0) return Subspace();
  Subspace set = curved_ ? common(p - aside_, nullptr, nullptr) : flat_;
  set.origin += aside_;
  return set;
}

Vec3d LockSet::snap(const Vec3d& p) const ARGIL_REALTIME {
  if (count_ == 0) return p;
  return snapTrue(p - aside_) + aside_;
}

}  // namespace argil::haptics
