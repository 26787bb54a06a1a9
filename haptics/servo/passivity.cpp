#include "haptics/servo/passivity.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

// A tool that hovers at the edge of an encoder step seems to move by a step in this time.
constexpr double kStepS = 0.008;
// Damping that was needed goes slowly: one that comes and goes with each encoder step chatters.
constexpr double kHoldS = 0.02;
// Times what a held force leaks: slow motion takes up little and must not ask for all there is.
constexpr double kMostNeeded = 2.0;
constexpr double kForgetS = 0.2;  // Old leaks are let go: a hand that glides cannot pay them back along the normal.
// No more is remembered than the damper takes up in so many ticks at kReferenceMms.
constexpr double kMostLackingTicks = 20;
constexpr double kReferenceMms = 100;
constexpr double kMostDelayS = 0.015;
constexpr double kTrickleS = 4;  // Fills the tank in so long: about a milliwatt.

}  // namespace

Passivity::Passivity(const DeviceSheet& sheet, double periodS, double delayS)
    : periodS_(periodS),
      slow_(sheet.resolutionMm / kStepS),
      most_(sheet.topDampingNsmm),
      mostLacking_(kMostLackingTicks * sheet.topDampingNsmm * kReferenceMms * kReferenceMms * periodS),
      hold_(std::exp(-periodS / kHoldS)),
      forget_(std::exp(-periodS / kForgetS)),
      // A spring stretched to the peak: one full push out of clay that grew.
      tank_(0.5 * sheet.peakForceN * sheet.peakForceN / sheet.topStiffnessNmm,
            0.5 * sheet.peakForceN * sheet.peakForceN / sheet.topStiffnessNmm / kTrickleS) {
  if (!(delayS >= 0 && delayS <= kMostDelayS)) throw Error("passivity control: the delay must be 0 to 0.015 s");
  setDelay(delayS);
  reset();
}

void Passivity::setDelay(double delayS) ARGIL_REALTIME {
  delayS_ = std::clamp(delayS, 0.0, kMostDelayS);
  lateS_ = 0.5 * periodS_ + delayS_;
  const double late = delayS_ / periodS_;
  lateTicks_ = static_cast<size_t>(late);
  lateRest_ = late - std::floor(late);
}

void Passivity::reset() noexcept {
  for (Vec3d& c : commands_) c.setZero();
  heldS_.fill(periodS_);
  regular_ = kHistory;
  tank_.reset();
  known_ = owing_ = false;
  paid_ = lacking_ = added_ = 0;
}

void Passivity::commanded(const Vec3d& force, double elapsedS) ARGIL_REALTIME {
  const bool regular = elapsedS == kOnePeriod || elapsedS == periodS_;
  heldS_[newest_] = regular ? periodS_ : std::max(0.0, elapsedS);
  regular_ = regular ? std::min(regular_ + 1, kHistory) : 0;
  newest_ = (newest_ + 1) % kHistory;
  commands_[newest_] = force;
}

// Mean force on the hand since the last tick.
Vec3d Passivity::acted(double elapsedS) const ARGIL_REALTIME {
  if (lateTicks_ == 0 && lateRest_ == 0) return commands_[newest_];
  if (elapsedS != periodS_ || regular_ < lateTicks_ + 1) {
    // The commands that were the newest from elapsedS + delay to delay ago, each by its share.
    Vec3d sum = Vec3d::Zero();
    double skip = delayS_, left = elapsedS;
    size_t at = newest_;
    for (size_t back = 0; back < kHistory && left > 0; ++back) {
      const double held = back == 0 ? elapsedS : heldS_[at];
      const double counts = std::min(left, std::max(0.0, held - skip));
      skip = std::max(0.0, skip - held);
      sum += counts * commands_[at];
      left -= counts;
      at = (at + kHistory - 1) % kHistory;
    }
    return elapsedS > 0 ? Vec3d(sum / elapsedS) : sum;
  }
  const Vec3d& then = commands_[(newest_ + kHistory - lateTicks_) % kHistory];
  if (lateRest_ == 0) return then;
  return (1 - lateRest_) * then + lateRest_ * commands_[(newest_ + kHistory - lateTicks_ - 1) % kHistory];
}

double Passivity::speedAlong(const Input& in) ARGIL_REALTIME {
  const double push = in.force.norm();
  return push > 1e-9 ? in.velocity.dot(in.force) / push : 0.0;
}

// Less push while the hand gives way, more while it comes on; never turned round.
Vec3d Passivity::damped(const Input& in) const ARGIL_REALTIME {
  const double damping = in.dampingNsmm + added_, push = in.force.norm();
  if (damping == 0 || push < 1e-9) return in.force;
  // A speed that the steps of the encoders may have made up is no speed.
  const double along = speedAlong(in), speed = along - std::clamp(along, -slow_, slow_);
  return in.force * std::max(0.0, 1 - damping * speed / push);
}

// Damping for what is lacking, from now on.
void Passivity::control(const Input& in, double spring, double elapsedS, double holds) ARGIL_REALTIME {
  added_ *= holds;
  if (lacking_ > 0) {
    // A tick that was late is followed by another one, most often: a force is held, and damps, that much longer.
    const double expected = std::max(elapsedS, periodS_),
                 late = expected > periodS_ ? 0.5 * expected + delayS_ : lateS_;
    const double speed = speedAlong(in), most = std::min(most_, kMostNeeded * spring * late);
    added_ = std::max(added_, std::min(most, lacking_ / (expected * std::max(speed * speed, 1e-12))));
  }
  if (added_ < 1e-3 * most_) added_ = 0;
}

Vec3d Passivity::apply(const Input& in) ARGIL_REALTIME {
  const Vec3d moved = in.position - position_;
  position_ = in.position;
  const bool regular = in.elapsedS == kOnePeriod || in.elapsedS == periodS_;
  const double elapsed = regular ? periodS_ : std::max(0.0, in.elapsedS);
  tank_.pass(elapsed);
  if (!known_) {
    known_ = true;
    paid_ = in.storedNmm;
    owing_ = false;
    lacking_ = added_ = 0;
    return damped(in);
  }
  paid_ -= acted(elapsed).dot(moved);
  double shortage = in.storedNmm - paid_;
  if (shortage <= 0) {
    tank_.fill(-shortage);
    shortage = 0;
    owing_ = false;
  } else if (in.active || owing_) {
    shortage -= tank_.draw(shortage);
    owing_ = shortage > 0;
  }
  paid_ = std::max(0.0, in.storedNmm - shortage);
  Input asked = in;
  if (owing_) {
    // The tank is empty: the spring pushes as one that holds what was paid.
    asked.force *= in.storedNmm > 0 ? std::sqrt(paid_ / in.storedNmm) : 0.0;
    shortage = 0;
  }
  const double spring = in.storedNmm > 0 ? in.force.squaredNorm() / (2 * in.storedNmm) : 0.0;
  // A step of an encoder looks like a motion of a whole step in one tick, though most of it was made before.
  const double push = in.force.norm(), step = push > 0 ? std::abs(moved.dot(in.force)) / push : 0.0;
  const double seen = std::min(step, std::abs(speedAlong(in)) * elapsed);
  const double forgets = regular ? forget_ : std::exp(-elapsed / kForgetS),
               holds = regular ? hold_ : std::exp(-elapsed / kHoldS);
  lacking_ = std::clamp(forgets * (shortage - 0.5 * spring * step * (step - seen)), 0.0, mostLacking_);
  if (!owing_) paid_ = in.storedNmm - lacking_;
  control(in, spring, elapsed, holds);
  return damped(asked);
}

}  // namespace argil::haptics
