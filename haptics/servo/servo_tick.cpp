#include "haptics/servo/servo_tick.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "haptics/threads/delay_meter.h"

namespace argil::haptics {
namespace {

double checkedPeriod(double periodS) {
  if (!(periodS >= 1.0 / 8001 && periodS <= 0.01)) throw Error("servo: the rate must be 100 to 8000 Hz");
  return periodS;
}

}  // namespace

ServoTick::ServoTick(Device& device, Published<Scene>& scene, SampleRing& samples, double periodS,
                     std::string_view contact)
    : device_(device),
      scene_(scene),
      samples_(samples),
      contact_(makeContact(contact)),
      heat_(device.sheet(), checkedPeriod(periodS)),
      safety_(device.sheet(), periodS),
      periodS_(periodS),
      ticked_(periodS),
      measured_(periodS),
      velocity_(periodS, device.sheet().resolutionMm),
      coupling_(coupleTo(device.sheet(), periodS)),
      passivity_(device.sheet(), periodS) {}

void ServoTick::couple(const Coupling& coupling, bool controlled, double delayS) {
  coupling_ = coupling;
  controlled_ = controlled;
  follows_ = false;
  passivity_ = Passivity(device_.sheet(), periodS_, delayS);
}

// A loop that is later bears less stiffness. What is touched goes over to it gently: contact eases stiffness.
void ServoTick::followDelay() ARGIL_REALTIME {
  const double delay = device_.delayS();
  if (!follows_ || delay == delayS_) return;
  delayS_ = delay;
  coupling_ = coupleTo(device_.sheet(), periodS_, std::clamp(delay, 0.0, DelayMeter::kMostS));
  passivity_.setDelay(delay);
}

void ServoTick::reset() noexcept {
  contact_->reset();
  safety_.reset();
  ticked_.reset();
  measured_.reset();
  velocity_.reset();
  passivity_.reset();
}

void ServoTick::park(double timeS) ARGIL_REALTIME {
  heatUp(ticked_.next(timeS));
  device_.write(timeS, Vec3d::Zero());
  held_.setZero();
  ticked_.reset();
  measured_.reset();
  velocity_.reset();
  passivity_.interrupt();
  safety_.restart();
  scene_.park();
}

// The last command was in force since the last tick; a device that hears nothing for longer lets go by itself.
void ServoTick::heatUp(const TickClock::Step& step) ARGIL_REALTIME {
  const double pushed = std::min(step.heldS, std::max(periodS_, kWatchdogSeconds));
  heat_.felt(held_, pushed);
  if (step.heldS > pushed) heat_.felt(Vec3d::Zero(), step.heldS - pushed);
}

uint32_t ServoTick::run(double timeS, bool late) ARGIL_REALTIME {
  uint32_t flags = late ? uint32_t{kOverrun} : 0u;
  const Scene* scene = scene_.enter();
  followDelay();
  DeviceState state;
  const bool fresh = device_.read(timeS, state);
  const bool sane = fresh && safety_.plausible(state);
  // Read after the device's read(): whatever the device knows a command by is no newer than this.
  const ForceGate::Word gate = device_.gate().word();
  // What stops forces stops no mouse: it has none.
  const bool shut = !ForceGate::open(gate) && !device_.sheet().pointing;
  const TickClock::Step step = ticked_.next(timeS);
  heatUp(step);
  if (step.gap) {
    measured_.reset();
    velocity_.reset();
    passivity_.interrupt();
  }
  // The motors are or were at zero. What a person did is no interruption.
  const bool pointing = device_.sheet().pointing, byPerson = ForceGate::stoppedBy(StopOwner::user, gate);
  if (!pointing && (byPerson || ForceGate::changed(StopOwner::user, gate, gate_)))
    safety_.restart();
  else if (!fresh || shut || (gate != gate_ && !pointing) || step.gap)
    safety_.interrupt(step.heldS);
  gate_ = gate;
  double measuredS = 0;

  sample_.index = index_++;
  sample_.timeS = timeS;
  const uint64_t editedFrom = scene ? scene->editedFrom : editedFrom_;
  feltAfter_ = editedFrom != editedFrom_ && editedFrom < sample_.index ? sample_.index - editedFrom : 0;
  editedFrom_ = editedFrom;
  Vec3d raw = Vec3d::Zero(), touched = raw;
  Reactions reactions;
  if (!scene) flags |= kNoScene;
  if (sane && scene) {
    state_ = state;
    const Vec3d* held = sample_.flags & kTouching ? &sample_.proxy : nullptr;
    sample_.device =
        workspace_.toWorld(scene->workspace, device_.sheet(), state.pose, state.buttons, step.seconds, held);
    flags |= (workspace_.panning() ? uint32_t{kPanning} : 0u) | (workspace_.clutched() ? uint32_t{kClutched} : 0u);
    measuredS = measured_.next(timeS - state.ageS).elapsedS();
    const Vec3d velocity = velocity_.add(state.pose.translation, measuredS);
    Contact::Input in;
    in.hand = sample_.device.translation;
    in.velocity = workspace_.velocityToWorld(velocity);
    in.periodS = step.seconds;
    in.topStiffnessNmm = coupling_.stiffnessNmm;
    in.topDampingNsmm = device_.sheet().topDampingNsmm;
    in.dampingNsmm = controlled_ ? 0 : coupling_.dampingNsmm;
    in.peakForceN = device_.sheet().peakForceN;
    in.pointing = device_.sheet().pointing;
    // A hand that nothing holds back would sink into the clay: the tool rests then, unless a person wants no force or
    // the clay does not hold it back anyway.
    const bool works = device_.sheet().dofOut == 0 || byPerson || safety_.felt() || scene->tool.work == Work::lay;
    in.operate = works && scene->tool.work && (state.buttons & scene->tool.buttons) != 0;
    in.buttons = state.buttons;
    in.sampleIndex = sample_.index;
    const Contact::Output out = contact_->tick(*scene, in);
    flags |= out.flags;
    raw = touched = workspace_.toDevice(out.force);
    reactions.all = out.reactions;
    reactions.count = out.reactionCount;
    // Walls on top of a contact that takes the whole peak saturate, which is no fault; a contact over the peak is for
    // safety to judge.
    if (scene->workspace.walls.on && raw.norm() <= in.peakForceN) {
      raw += workspace_.wallForce();
      if (const double size = raw.norm(); size > in.peakForceN) {
        raw *= in.peakForceN / size;
        flags |= kClamped;
      }
    }
    if (controlled_) {
      Passivity::Input energy;
      energy.position = state.pose.translation;
      energy.velocity = velocity;
      energy.force = raw;
      energy.storedNmm = workspace_.wallEnergyNmm();
      // Half of force times stretch: right for a spring of any stiffness. Device millimetres.
      const double stretched =
          workspace_.grip() *
          std::max(0.0, 0.5 * (out.force - out.ambient).dot(out.proxy - in.hand) / workspace_.scale());
      energy.storedNmm += stretched;
      // What is cut damps by itself.
      if (stretched > 0 && !(out.flags & kCutting)) energy.dampingNsmm = coupling_.dampingNsmm;
      energy.elapsedS = step.elapsedS();
      energy.active = out.active || workspace_.panning() || workspace_.grip() < 1;
      raw = passivity_.apply(energy);
    }
    sample_.proxy = out.proxy;
    sample_.cutPoint = out.cutPoint;
    sample_.depthMm = out.depthMm;
    sample_.planes = static_cast<uint32_t>(out.planes);
    sample_.pressure = state.pressure;
    sample_.buttons = state.buttons;
    sample_.tool = scene->tool.id;
  } else {
    measured_.reset();
    velocity_.reset();  // No speed comes from a gap.
    passivity_.interrupt();
  }

  const Vec3d force = safety_.apply(raw, state, fresh, flags, heat_.limitN(), {step.elapsedS(), measuredS}, shut);
  passivity_.commanded(force, step.elapsedS());
  device_.write(timeS, force);
  held_ = force;
  sample_.forceN = workspace_.turnToWorld(force);
  // A faulty tick never cuts.
  if (flags & (kStopped | kStale | kNoScene)) flags &= ~uint32_t{kCutting};
  sample_.flags = flags;
  if (!samples_.push(sample_)) flags |= kQueueFull;
  latest_.store(sample_);
  // A hand that is pushed less than contact asked for pushes back no more than that.
  const double asked = touched.squaredNorm(),
               share = asked > 0 ? std::clamp(force.dot(touched) / asked, 0.0, 1.0) : 0.0;
  for (size_t i = 0; i < size_t(reactions.count); ++i) {
    reactions.all[i].forceN *= share;
    reactions.all[i].torqueNmm *= share;
  }
  reactions.index = sample_.index;
  reactions_.store(reactions);
  return flags;
}

}  // namespace argil::haptics
