#include "haptics/contact/lock_set.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

// A bead moves by so many times the hand's way: as it does when the hand is within 3/4 of the bend's radius.
constexpr double kBeadLead = 4;

void shorten(Vec3d& v, double by) noexcept {
  const double length = v.norm();
  if (length <= by)
    v.setZero();
  else
    v *= (length - by) / length;
}

}  // namespace

void LockSet::reset() noexcept {
  count_ = countBefore_ = 0;
  curve_ = nullptr;
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

// Meets the locks in their order. True when they are those of the last tick.
bool LockSet::meet() ARGIL_REALTIME {
  flat_ = Subspace();
  curve_ = count_ > 0 ? locks_[0].curve : nullptr;
  bool same = count_ == countBefore_;
  for (int i = 0; i < count_; ++i) {
    const Lock& lock = locks_[size_t(i)];
    same = same && lock.same(before_[size_t(i)]);
    if (curve_ || lock.curve)
      conflict_ = conflict_ || i > 0;
    else
      conflict_ = !flat_.intersect(lock.set) || conflict_;
  }
  return same;
}

Vec3d LockSet::snapTrue(const Vec3d& p) const ARGIL_REALTIME {
  return curve_ ? curve_->slide(p, bead_).point : flat_.nearest(p);
}

void LockSet::finish(const Vec3d& proxy, const Vec3d& hand, double slideMm, bool lostHold) ARGIL_REALTIME {
  if (count_ == 0 && countBefore_ == 0 && !lostHold && settled()) return;
  const bool same = meet();
  if (!same || lostHold) {
    const bool known = curve_ && countBefore_ > 0 && before_[0].curveId == curve_->id();
    if (curve_) bead_ = known ? curve_->slide(proxy, bead_) : curve_->nearest(proxy);
    aside_.setZero();
    if (count_ > 0) aside_ = proxy - snapTrue(proxy);
    // Of a curve all of it: what is square to it here moves the bead elsewhere.
    back_ = curve_ ? Vec3d(proxy - hand) : at(proxy).along(proxy - hand);
  } else if (curve_) {
    bead_ = curve_->slide(proxy - aside_, bead_);
  }
  // Both at once change the force by no more than one would.
  const double part = aside_.isZero(0) || back_.isZero(0) ? 1.0 : 0.7;
  shorten(aside_, part * slideMm);
  shorten(back_, part * slideMm);
  runMm_ = slideMm + (same ? kBeadLead * (hand - hand_).norm() : 0.0);
  hand_ = hand;
  for (int i = 0; i < count_; ++i) before_[size_t(i)] = locks_[size_t(i)];
  countBefore_ = count_;
}

Vec3d LockSet::goal(const Vec3d& hand) const ARGIL_REALTIME {
  const Vec3d wanted = hand + back_;
  if (!curve_) return wanted;
  // Inside of a bend, farther from it than its radius, the nearest place leaps: the bead runs there.
  const Polyline::Place there = curve_->slide(wanted - aside_, bead_);
  // On the same piece the way is hardly longer than straight: no need to measure it.
  if (there.piece == bead_.piece && 1.2 * (there.point - bead_.point).norm() <= runMm_) return there.point + aside_;
  const double from = curve_->arcLengthMm(bead_), length = curve_->lengthMm();
  double way = curve_->arcLengthMm(there) - from;
  if (curve_->closed()) way = std::remainder(way, length);
  if (std::abs(way) <= runMm_) return there.point + aside_;
  double to = from + std::copysign(runMm_, way);
  if (curve_->closed()) to -= std::floor(to / length) * length;
  return curve_->at(to).point + aside_;
}

Subspace LockSet::at(const Vec3d& p) const ARGIL_REALTIME {
  if (count_ == 0) return Subspace();
  if (!curve_) {
    Subspace set = flat_;
    set.origin += aside_;
    return set;
  }
  const Polyline::Place place = curve_->slide(p - aside_, bead_);
  return Subspace::line(place.point + aside_, place.tangent);
}

Vec3d LockSet::snap(const Vec3d& p) const ARGIL_REALTIME {
  if (count_ == 0) return p;
  return snapTrue(p - aside_) + aside_;
}

}  // namespace argil::haptics
