#include "haptics/devices/simulated.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kMaxDelayS = 0.015;
constexpr double kSteeredMms = 800;  // Of a hand that is steered.
constexpr double kMmPerM = 1000.0;   // N / kg is m/s².

}  // namespace

SimulatedDevice::SimulatedDevice(DeviceSheet sheet, HandPath path, const Options& options)
    : sheet_(std::move(sheet)), path_(std::move(path)), options_(options) {
  if (!(options.delayS >= 0 && options.delayS <= kMaxDelayS))
    throw Error("simulated device: the delay must be 0 to 0.015 s");
  if (!(options.fineStepS >= 1e-6 && options.fineStepS <= 1e-3))
    throw Error("simulated device: the fine step must be 1e-6 to 1e-3 s");
  if (!(options.hand.massKg >= 0 && options.hand.dampingNsmm >= 0 && options.hand.stiffnessNmm >= 0 &&
        sheet_.massKg > 0))
    throw Error("simulated device: masses, damping and stiffness must not be negative");
  if (path_.empty()) throw Error("simulated device: the hand path holds no points");
  wanted_ = path_.at(0, hint_);
  position_ = wanted_.position;
}

void SimulatedDevice::startAt(const Vec3d& position) noexcept {
  HandPoint there = wanted_;
  there.position = position;
  steer(there);
  wanted_ = there;
  position_ = position;
  velocity_.setZero();
}

bool SimulatedDevice::read(double timeS, DeviceState& state) ARGIL_REALTIME {
  word_ = gate().word();
  advance(timeS);
  state.pose.translation = position_;
  if (options_.encoderSteps && sheet_.resolutionMm > 0) {
    for (int a = 0; a < 3; ++a)
      state.pose.translation[a] = sheet_.resolutionMm * std::nearbyint(position_[a] / sheet_.resolutionMm);
  }
  state.pose.rotation = wanted_.rotation;
  state.pressure = wanted_.pressure;
  state.buttons = wanted_.buttons;
  return true;
}

void SimulatedDevice::write(double timeS, const Vec3d& forceN) ARGIL_REALTIME {
  // More writes than the delay line holds: the oldest would have been replaced anyway.
  if (commandCount_ == kCommands) {
    firstCommand_ = (firstCommand_ + 1) % kCommands;
    --commandCount_;
  }
  Command& command = commands_[(firstCommand_ + commandCount_++) % kCommands];
  command.dueS = timeS + options_.delayS;
  command.word = word_;
  command.force = forceN;
  const double size = forceN.norm();
  if (size > sheet_.peakForceN) command.force *= sheet_.peakForceN / size;
}

void SimulatedDevice::advance(double timeS) ARGIL_REALTIME {
  // A servo that was away for long must not be held up by catching up: a tenth of a second at most.
  const auto steps = static_cast<uint64_t>(std::max(0.0, std::floor(timeS / options_.fineStepS + 1e-6)));
  const auto most = static_cast<uint64_t>(0.1 / options_.fineStepS);
  if (steps > stepsDone_ + most) stepsDone_ = steps - most;
  while (stepsDone_ < steps) {
    step(double(stepsDone_) * options_.fineStepS);
    ++stepsDone_;
  }
}

void SimulatedDevice::step(double timeS) ARGIL_REALTIME {
  const double dt = options_.fineStepS;
  // The newest command that is due, held until the next one is.
  while (commandCount_ > 0 && commands_[firstCommand_].dueS <= timeS + 1e-9) {
    motor_ = commands_[firstCommand_].force;
    motorWord_ = commands_[firstCommand_].word;
    firstCommand_ = (firstCommand_ + 1) % kCommands;
    --commandCount_;
  }
  // While the gate is shut there is no force, and none from before comes back.
  if (const ForceGate::Word now = gate().word(); !ForceGate::open(now) || now != motorWord_) motor_.setZero();

  const HandPoint before = wanted_;
  isSteered_ |= steered_.load(steeredTo_);
  if (isSteered_) {
    const Vec3d way = steeredTo_.position - before.position;
    const double most = kSteeredMms * dt, length = way.norm();
    wanted_ = steeredTo_;
    if (length > most) wanted_.position = before.position + (most / length) * way;
  } else {
    wanted_ = path_.at(timeS + dt, hint_);
  }
  if (options_.prescribed) {
    position_ = wanted_.position;
    velocity_ = (wanted_.position - before.position) / dt;
    return;
  }
  const HandModel& hand = options_.hand;
  const double mass = sheet_.massKg + hand.massKg;
  const double perMass = kMmPerM * dt / mass;
  // The hand's damper acts on the speed relative to the wanted one; a jump of the path is no speed.
  Vec3d wantedVelocity = (wanted_.position - before.position) / dt;
  if (wantedVelocity.norm() > sheet_.topSpeedMms) wantedVelocity.setZero();
  // Spring and dampers implicit: the energy cannot grow by integration, at any step.
  const Vec3d force =
      motor_ + wanted_.forceN + hand.stiffnessNmm * (wanted_.position - position_) + hand.dampingNsmm * wantedVelocity;
  const double resist = hand.dampingNsmm + sheet_.dampingNsmm + hand.stiffnessNmm * dt;
  velocity_ = (velocity_ + perMass * force) / (1.0 + perMass * resist);
  // Coulomb friction takes speed away, never reverses it.
  const double speed = velocity_.norm();
  const double taken = perMass * sheet_.frictionN;
  if (speed <= taken)
    velocity_.setZero();
  else
    velocity_ *= 1.0 - taken / speed;
  position_ += dt * velocity_;
}

double SimulatedDevice::energyNmm() const noexcept {
  const double mass = sheet_.massKg + options_.hand.massKg;
  return 0.5 * mass * velocity_.squaredNorm() / kMmPerM +
         0.5 * options_.hand.stiffnessNmm * (wanted_.position - position_).squaredNorm();
}

}  // namespace argil::haptics
