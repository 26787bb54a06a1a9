#include "haptics/servo/safety.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

bool finite(const DeviceState& state) {
  return state.pose.translation.allFinite() && state.pose.rotation.coeffs().allFinite();
}

}  // namespace

const char* sentence(Fault fault) noexcept {
  switch (fault) {
    case Fault::none:
      return "no fault";
    case Fault::notFinite:
      return "a force or a device position was not a finite number";
    case Fault::commandTooLarge:
      return "forces over twice the device's peak were asked for";
    case Fault::tooFast:
      return "the device moved faster than its sheet allows";
    case Fault::implausible:
      return "the device told a place far outside of its reach";
  }
  return "unknown fault";
}

Safety::Safety(const DeviceSheet& sheet, double periodS)
    : motor_(!sheet.pointing),
      periodS_(periodS),
      peak_(sheet.peakForceN),
      slewStep_(sheet.peakForceN * periodS / kSlewPeakSeconds),
      // One tick to spare, so that the fade is over within its time whatever the rounding.
      fadeStep_(sheet.peakForceN / std::max(1.0, std::floor(kFadeSeconds / periodS) - 1.0)),
      // Two steps of the encoder on top: its own noise is no speed.
      fastMm_(sheet.topSpeedMms * periodS * (kSpeedTicks - 1) + 2 * sheet.resolutionMm),
      fastMms_(sheet.topSpeedMms) {}

bool Safety::plausible(const DeviceState& state) const ARGIL_REALTIME {
  return finite(state) && (!motor_ || state.pose.translation.norm() <= kFarthestMm);
}

void Safety::restart() ARGIL_REALTIME {
  interrupt(0);
  start_ = Start::waiting;
}

void Safety::interrupt(double seconds) ARGIL_REALTIME {
  last_.setZero();
  trailCount_ = trailNext_ = regular_ = rawOver_ = 0;
  awayS_ += seconds;
  returnedS_ = 0;
  if (start_ != Start::waiting) start_ = awayS_ > kAwaySeconds ? Start::waiting : Start::returning;
}

void Safety::reset() noexcept {
  restart();
  fault_.store(Fault::none, std::memory_order_relaxed);
}

void Safety::trip(Fault fault) ARGIL_REALTIME {
  if (!motor_ || this->fault() != Fault::none) return;
  faults_.fetch_add(1);
  fault_.store(fault, std::memory_order_relaxed);
}

bool Safety::tooFast(const Vec3d& position, double measuredS) ARGIL_REALTIME {
  if (measuredS == 0) return false;  // Nothing new.
  const bool regular = measuredS == kOnePeriod || measuredS == periodS_;
  regular_ = regular ? std::min(regular_ + 1, kSpeedTicks) : 0;
  trail_[static_cast<size_t>(trailNext_)] = position;
  took_[static_cast<size_t>(trailNext_)] = regular ? periodS_ : measuredS;
  trailNext_ = (trailNext_ + 1) % kSpeedTicks;
  trailCount_ = std::min(trailCount_ + 1, kSpeedTicks);
  if (trailCount_ < kSpeedTicks) return false;
  double allowed = fastMm_;
  if (regular_ < kSpeedTicks - 1) {
    double span = 0;
    for (size_t i = 0; i < kSpeedTicks; ++i) span += took_[i];
    span -= took_[static_cast<size_t>(trailNext_)];  // Up to the oldest position.
    // Positions that came together are judged no more strictly than regular ones: a glitch in a short time would be a
    // speed.
    allowed = std::max(allowed, allowed + fastMms_ * (span - periodS_ * (kSpeedTicks - 1)));
  }
  return (position - trail_[static_cast<size_t>(trailNext_)]).norm() > allowed;
}

Vec3d Safety::apply(const Vec3d& raw, const DeviceState& state, bool fresh, uint32_t& flags, double mostN,
                    const TickTimes& times, bool shut) ARGIL_REALTIME {
  // In periods.
  const double ticked = times.tickS == kOnePeriod || times.tickS == periodS_ ? 1.0 : times.tickS / periodS_;
  const bool there = fresh && plausible(state);
  if (fresh) {
    if (!there)
      trip(finite(state) ? Fault::implausible : Fault::notFinite);
    else if (!raw.allFinite())
      trip(Fault::notFinite);
    else {
      rawOver_ = raw.norm() > kRawOverFactor * peak_ ? rawOver_ + 1 : 0;
      if (rawOver_ >= kRawOverTicks) trip(Fault::commandTooLarge);
      if (tooFast(state.pose.translation, times.measuredS)) trip(Fault::tooFast);
    }
  } else {
    trailCount_ = 0;  // A gap in time is no speed.
  }

  if (fault() != Fault::none) {
    flags |= kStopped | (shut ? uint32_t{kCut} : 0u);
    const double size = last_.norm(), step = fadeStep_ * std::max(1.0, ticked);
    if (!there || shut || !(size > step))
      last_.setZero();
    else
      last_ *= (size - step) / size;
    return last_;
  }
  if (!fresh) {
    flags |= kStale;
    interrupt(0);
    return last_;
  }
  if (shut) {
    flags |= kCut | (raw.norm() > kStartFraction * peak_ && start_ == Start::waiting ? uint32_t{kWaiting} : 0u);
    last_.setZero();
    return last_;
  }
  if (!raw.allFinite()) {  // Of a pointer: for any other it is a fault.
    last_.setZero();
    return last_;
  }
  if (start_ == Start::waiting && motor_ && raw.norm() > kStartFraction * peak_) {
    flags |= kWaiting;
    last_.setZero();
    return last_;
  }
  awayS_ = 0;
  double back = 1;
  if (start_ == Start::returning && motor_) {
    returnedS_ += std::clamp(ticked, 0.0, 1.0) * periodS_;
    back = returnedS_ / kReturnSeconds;
  }
  if (back >= 1) start_ = Start::felt;

  Vec3d force = raw;
  if (const double size = force.norm(), most = std::min(peak_, std::max(0.0, mostN)); size > most) {
    force *= most / size;
    flags |= most < peak_ ? kWarm : kClamped;
  }
  if (back < 1) {
    flags |= kReturning;
    if (const double size = force.norm(), most = back * peak_; size > most) force *= most / size;
  }
  const Vec3d change = force - last_;
  const double steepest = slewStep_ * std::clamp(ticked, 0.0, 1.0);
  if (const double size = change.norm(); size > steepest) {
    force = last_ + change * (steepest / size);
    flags |= kSlewed;
  }
  // Rounding must not carry it over the limit that hardware checks.
  if (const double size = force.norm(); size > peak_) force *= peak_ / (size * (1 + 1e-15));
  last_ = force;
  return last_;
}

bool Watchdog::look(const Heartbeat& heart, ForceGate& gate, double nowS) noexcept {
  const bool silent = heart.silent(nowS);
  const bool fell = silent && !holds_;
  if (fell) mine_ = gate.stop(StopOwner::watchdog);
  if (!silent) end(gate);
  holds_ = silent;
  return fell;
}

void Watchdog::end(ForceGate& gate) noexcept {
  if (holds_) (void)gate.resume(StopOwner::watchdog, mine_);
  holds_ = false;
}

}  // namespace argil::haptics
