#include "haptics/safety.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

bool finite(const DeviceState& state) { return state.pose.translation.allFinite() && state.pose.rotation.coeffs().allFinite(); }

}  // namespace

const char* sentence(Fault fault) noexcept {
  switch (fault) {
    case Fault::none: return "no fault";
    case Fault::notFinite: return "a force or a device position was not a finite number";
    case Fault::commandTooLarge: return "forces over twice the device's peak were asked for";
    case Fault::tooFast: return "the device moved faster than its sheet allows";
    case Fault::implausible: return "the device told a place far outside of its reach";
  }
  return "unknown fault";
}

Safety::Safety(const DeviceSheet& sheet, double periodS)
    : peak_(sheet.peakForceN),
      slewStep_(sheet.peakForceN * periodS / kSlewPeakSeconds),
      // One tick to spare, so that the fade is over within its time whatever the rounding.
      fadeStep_(sheet.peakForceN / std::max(1.0, std::floor(kFadeSeconds / periodS) - 1.0)),
      // Two steps of the encoder on top: its own noise is no speed.
      fastMm_(sheet.topSpeedMms * periodS * (kSpeedTicks - 1) + 2 * sheet.resolutionMm) {}

bool Safety::plausible(const DeviceState& state) const ARGIL_REALTIME {
  return finite(state) && state.pose.translation.norm() <= kFarthestMm;
}

void Safety::restart() ARGIL_REALTIME {
  last_.setZero();
  trailCount_ = trailNext_ = rawOver_ = 0;
  started_ = false;
}

void Safety::reset() noexcept {
  restart();
  fault_.store(Fault::none, std::memory_order_relaxed);
}

void Safety::trip(Fault fault) ARGIL_REALTIME {
  if (this->fault() == Fault::none) fault_.store(fault, std::memory_order_relaxed);
}

bool Safety::tooFast(const Vec3d& position) ARGIL_REALTIME {
  trail_[static_cast<size_t>(trailNext_)] = position;
  trailNext_ = (trailNext_ + 1) % kSpeedTicks;
  trailCount_ = std::min(trailCount_ + 1, kSpeedTicks);
  if (trailCount_ < kSpeedTicks) return false;
  return (position - trail_[static_cast<size_t>(trailNext_)]).norm() > fastMm_;
}

Vec3d Safety::apply(const Vec3d& raw, const DeviceState& state, bool fresh, uint32_t& flags, double mostN) ARGIL_REALTIME {
  const bool there = fresh && plausible(state);
  if (fresh) {
    if (!there) trip(finite(state) ? Fault::implausible : Fault::notFinite);
    else if (!raw.allFinite()) trip(Fault::notFinite);
    else {
      rawOver_ = raw.norm() > kRawOverFactor * peak_ ? rawOver_ + 1 : 0;
      if (rawOver_ >= kRawOverTicks) trip(Fault::commandTooLarge);
      if (tooFast(state.pose.translation)) trip(Fault::tooFast);
    }
  } else {
    trailCount_ = 0;  // A gap in time is no speed.
  }

  if (fault() != Fault::none) {
    flags |= kStopped;
    const double size = last_.norm();
    if (!there || !(size > fadeStep_)) last_.setZero();
    else last_ *= (size - fadeStep_) / size;
    return last_;
  }
  if (!fresh) {
    flags |= kStale;
    started_ = false;  // Comes back through the gentle start.
    last_.setZero();
    return last_;
  }
  if (!started_) {
    if (raw.norm() > kStartFraction * peak_) {
      flags |= kWaiting;
      last_.setZero();
      return last_;
    }
    started_ = true;
  }

  Vec3d force = raw;
  if (const double size = force.norm(), most = std::min(peak_, std::max(0.0, mostN)); size > most) {
    force *= most / size;
    flags |= most < peak_ ? kWarm : kClamped;
  }
  const Vec3d change = force - last_;
  if (const double size = change.norm(); size > slewStep_) {
    force = last_ + change * (slewStep_ / size);
    flags |= kSlewed;
  }
  // Rounding must not carry it over the limit that hardware checks.
  if (const double size = force.norm(); size > peak_) force *= peak_ / (size * (1 + 1e-15));
  last_ = force;
  return last_;
}

}  // namespace argil::haptics
