#include "haptics/passivity.h"

#include <algorithm>
#include <cmath>

#include "clay/error.h"

namespace argil::haptics {
namespace {

constexpr double kMechanism = 0.5;        // Of what the mechanism dissipates may leak; with all of it oscillations would not die away.
constexpr double kHoldS = 0.02;           // Damping that was needed goes slowly: one that comes and goes with each encoder step chatters.
constexpr double kForgetS = 0.2;          // Old leaks are let go: a hand that glides cannot pay them back along the normal.
constexpr double kMostLackingTicks = 20;  // No more is remembered than the damper takes up in so many ticks at kReferenceMms.
constexpr double kReferenceMms = 100;

}  // namespace

Passivity::Passivity(const DeviceSheet& sheet, double periodS, double delayS)
    : periodS_(periodS),
      damping_(kMechanism * sheet.dampingNsmm),
      friction_(kMechanism * sheet.frictionN),
      most_(sheet.topDampingNsmm),
      hold_(std::exp(-periodS / kHoldS)),
      forget_(std::exp(-periodS / kForgetS)),
      mostLacking_(kMostLackingTicks * sheet.topDampingNsmm * kReferenceMms * kReferenceMms * periodS),
      // A spring stretched to the peak: one full push out of clay that grew.
      tank_(0.5 * sheet.peakForceN * sheet.peakForceN / sheet.topStiffnessNmm) {
  if (!(delayS >= 0 && delayS <= 0.015)) throw Error("passivity control: the delay must be 0 to 0.015 s");
  const double late = delayS / periodS;
  lateTicks_ = static_cast<size_t>(late);
  lateRest_ = late - std::floor(late);
  reset();
}

void Passivity::reset() noexcept {
  for (Vec3d& c : commands_) c.setZero();
  tank_.reset();
  known_ = false;
  paid_ = lacking_ = added_ = 0;
}

void Passivity::commanded(const Vec3d& force) ARGIL_REALTIME {
  newest_ = (newest_ + 1) % kHistory;
  commands_[newest_] = force;
}

double Passivity::speedAlong(const Input& in) ARGIL_REALTIME {
  const double push = in.force.norm();
  return push > 1e-9 ? in.velocity.dot(in.force) / push : 0.0;
}

// Less push while the hand gives way, more while it comes on; never turned round.
Vec3d Passivity::damped(const Input& in) const ARGIL_REALTIME {
  const double damping = in.dampingNsmm + added_, push = in.force.norm();
  if (damping == 0 || push < 1e-9) return in.force;
  return in.force * std::max(0.0, 1 - damping * speedAlong(in) / push);
}

// Mean force on the hand since the last tick.
Vec3d Passivity::acted() const ARGIL_REALTIME {
  const Vec3d& then = commands_[(newest_ + kHistory - lateTicks_) % kHistory];
  if (lateRest_ == 0) return then;
  return (1 - lateRest_) * then + lateRest_ * commands_[(newest_ + kHistory - lateTicks_ - 1) % kHistory];
}

Vec3d Passivity::apply(const Input& in) ARGIL_REALTIME {
  const Vec3d moved = in.position - position_;
  position_ = in.position;
  if (!known_) {
    known_ = true;
    paid_ = in.storedNmm;
    lacking_ = added_ = 0;
    return damped(in);
  }
  paid_ -= acted().dot(moved);
  const double spare = paid_ - in.storedNmm;
  // What the mechanism itself takes up in this tick may leak.
  lacking_ = std::max(0.0, -spare - damping_ * moved.squaredNorm() / periodS_ - friction_ * moved.norm());
  if (spare > 0) tank_.fill(spare);
  Input asked = in;
  if (in.active && lacking_ > 0) {
    lacking_ -= tank_.draw(lacking_);
    if (lacking_ > 0) {
      // The tank is empty: the spring pushes no harder than what was paid for.
      asked.storedNmm = std::max(0.0, in.storedNmm - lacking_);
      asked.force *= in.storedNmm > 0 ? std::sqrt(asked.storedNmm / in.storedNmm) : 0.0;
      lacking_ = 0;
    }
  }
  lacking_ = std::min(forget_ * lacking_, mostLacking_);
  paid_ = asked.storedNmm - lacking_;
  added_ *= hold_;
  if (lacking_ > 0) {
    const double speed = speedAlong(in);
    added_ = std::max(added_, std::min(most_, lacking_ / (periodS_ * std::max(speed * speed, 1e-12))));
  }
  if (added_ < 1e-3 * most_) added_ = 0;
  return damped(asked);
}

}  // namespace argil::haptics
