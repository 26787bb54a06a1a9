#include "haptics/servo_tick.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "clay/error.h"

namespace argil::haptics {
namespace {

constexpr double kVelocityCutoffHz = 40;  // Of the low-pass on encoder differences: above what a hand does on purpose.
constexpr double kDampingFraction = 0.5;  // Of the sheet's top damping, left room for what the filter's lag costs.

constexpr double kFarthestMm = 1e7;        // A device farther off is not a device.

double checkedPeriod(double periodS) {
  if (!(periodS >= 1.0 / 8001 && periodS <= 0.01)) throw Error("servo: the rate must be 100 to 8000 Hz");
  return periodS;
}

}  // namespace

ServoTick::ServoTick(Device& device, Published<Scene>& scene, SampleRing& samples, double periodS, std::string_view contact)
    : device_(device),
      scene_(scene),
      samples_(samples),
      contact_(makeContact(contact)),
      safety_(device.sheet(), checkedPeriod(periodS)),
      periodS_(periodS),
      smoothing_(1 - std::exp(-2 * std::numbers::pi * kVelocityCutoffHz * periodS)) {}

void ServoTick::reset() noexcept {
  contact_->reset();
  safety_.reset();
  moving_ = false;
}

void ServoTick::park(double timeS) ARGIL_REALTIME {
  device_.write(timeS, Vec3d::Zero());
  scene_.park();
}

void ServoTick::estimateVelocity(const Vec3d& position) ARGIL_REALTIME {
  if (moving_) velocity_ += smoothing_ * ((position - position_) / periodS_ - velocity_);
  else velocity_.setZero();
  position_ = position;
  moving_ = true;
}

uint32_t ServoTick::run(double timeS, bool late) ARGIL_REALTIME {
  uint32_t flags = late ? uint32_t{kOverrun} : 0u;
  const Scene* scene = scene_.enter();
  DeviceState state;
  const bool fresh = device_.read(timeS, state);
  const bool sane = state.pose.translation.allFinite() && state.pose.translation.cwiseAbs().maxCoeff() < kFarthestMm &&
                    state.pose.rotation.coeffs().allFinite();

  sample_.index = index_++;
  sample_.timeS = timeS;
  Vec3d raw = Vec3d::Zero();
  if (!scene) flags |= kNoScene;
  if (fresh && sane && scene) {
    state_ = state;
    const Workspace& workspace = scene->workspace;
    sample_.device = workspace.toWorld(state.pose);
    estimateVelocity(sample_.device.translation);
    Contact::Input in;
    in.hand = sample_.device.translation;
    in.velocity = velocity_;
    in.periodS = periodS_;
    in.topStiffnessNmm = device_.sheet().topStiffnessNmm;
    in.dampingNsmm = kDampingFraction * device_.sheet().topDampingNsmm;
    in.peakForceN = device_.sheet().peakForceN;
    in.operate = scene->tool.operation && (state.buttons & scene->tool.buttons) != 0;
    in.buttons = state.buttons;
    in.sampleIndex = sample_.index;
    const Contact::Output out = contact_->tick(*scene, in);
    flags |= out.flags;
    raw = workspace.pose.rotation.conjugate() * out.force;
    sample_.proxy = out.proxy;
    sample_.cutPoint = out.cutPoint;
    sample_.depthMm = out.depthMm;
    sample_.planes = static_cast<uint32_t>(out.planes);
    sample_.pressure = state.pressure;
    sample_.buttons = state.buttons;
    sample_.tool = scene->tool.id;
  } else {
    moving_ = false;  // The last place is kept; no speed comes from a gap.
    if (fresh && !sane) raw.setConstant(std::numeric_limits<double>::quiet_NaN());  // Safety stops on it.
  }

  const Vec3d force = safety_.apply(raw, state, fresh, flags);
  device_.write(timeS, force);
  sample_.forceN = scene ? Vec3d(scene->workspace.pose.rotation * force) : force;
  // A faulty tick never cuts.
  if (flags & (kStopped | kStale | kNoScene)) flags &= ~uint32_t{kCutting};
  sample_.flags = flags;
  if (!samples_.push(sample_)) flags |= kQueueFull;
  latest_.store(sample_);
  return flags;
}

}  // namespace argil::haptics
