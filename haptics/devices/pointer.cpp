#include "haptics/devices/pointer.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kSteepest = 1.5;    // Of a pen's tilt, rad.
constexpr size_t kRing = 1024;       // Samples: a second of the fastest mouse.
constexpr size_t kMostLate = 256;    // Samples beyond the ring.
constexpr size_t kMostBehind = 64;   // Samples that wait: from here on several of a stroke share a tick.
constexpr double kArrivedMm = 0.01;  // From the point at which the buttons change,
constexpr int kMostWaitTicks = 100;  // unless it takes longer than this.

bool within(double value, double least, double most) {
  return value >= least && value <= most;
}

}  // namespace

PointerDevice::PointerDevice(const PointerOptions& options) : options_(options), fed_(kRing) {
  if (!within(options.wheelStepMm, 0, 100)) throw Error("pointer: a click of the wheel must be 0 to 100 mm");
  if (!within(options.penDepthMm, 0, 100)) throw Error("pointer: the depth of full pressure must be 0 to 100 mm");
  if (!within(options.smoothSeconds, 0, 0.1)) throw Error("pointer: the smoothing must be 0 to 0.1 s");
  sheet_.name = "pointer";
  sheet_.like = "mouse or pen";
  sheet_.dofIn = 6;
  sheet_.dofOut = 0;  // What the sheet says of forces is what contact reckons with.
  sheet_.workspaceMm = {400, 300, 300};
  sheet_.resolutionMm = 0.1;
  sheet_.topSpeedMms = 4000;  // A wrist on a mouse is faster than an arm in a mechanism.
  sheet_.buttons = 5;
  sheet_.pointing = true;
}

bool PointerDevice::feed(const PointerSample& s) noexcept {
  const double length = s.direction.norm();
  if (!s.origin.allFinite() || !(length > 1e-9) || !std::isfinite(length) || !within(s.wheel, -1e6, 1e6) ||
      !(s.pressure <= 1) || !within(s.tiltX, -kSteepest, kSteepest) || !within(s.tiltY, -kSteepest, kSteepest))
    return false;
  if (std::isfinite(s.surfaceMm)) surfaceMm_ = s.surfaceMm;
  const Vec3d direction = s.direction / length;
  const double pressed = std::max(0.0f, s.pressure);
  DeviceState state;
  state.pose.translation =
      s.origin + (surfaceMm_ + s.wheel * options_.wheelStepMm + pressed * options_.penDepthMm) * direction;
  if (!state.pose.translation.allFinite()) return false;
  // The stylus' own z looks back at the person; tilt leans it.
  state.pose.rotation = rotationBetween(Vec3d::UnitZ(), -direction) * Eigen::AngleAxisd(s.tiltX, Vec3d::UnitY()) *
                        Eigen::AngleAxisd(s.tiltY, Vec3d::UnitX());
  state.pressure = s.pressure >= 0 ? s.pressure : (s.buttons ? 1.0f : 0.0f);
  state.buttons = s.buttons;
  send({state, true});
  return true;
}

void PointerDevice::leave() noexcept {
  send({{}, false});
}

void PointerDevice::send(const Fed& fed) noexcept {
  present_.store(fed.present);
  while (!late_.empty() && fed_.push(late_.front())) late_.pop_front();
  if (late_.empty() && fed_.push(fed)) return;
  // Nobody reads just now. The newest motion takes the place of the one before it, but a change of the buttons stays.
  if (!late_.empty() && late_.back().state.buttons == fed.state.buttons && late_.back().present == fed.present)
    late_.back() = fed;
  else if (late_.size() < kMostLate)
    late_.push_back(fed);
  else
    late_.back() = fed;
}

bool PointerDevice::takes(const Fed& next, int followed, size_t waiting) const ARGIL_REALTIME {
  if (!wanted_.present || !moving_) return followed == 0;
  if (next.state.buttons == wanted_.state.buttons && next.present)
    return followed == 0 || wanted_.state.buttons == 0 || waiting > kMostBehind;
  if (followed > 0) return false;
  const double away = (wanted_.state.pose.translation - now_.pose.translation).norm();
  return away <= kArrivedMm || waitedTicks_ >= kMostWaitTicks;
}

bool PointerDevice::read(double timeS, DeviceState& state) ARGIL_REALTIME {
  int followed = 0;
  for (;;) {
    if (!hasNext_) hasNext_ = fed_.pop({&next_, 1}) == 1;
    if (!hasNext_) break;
    if (!takes(next_, followed, fed_.size())) {
      if (followed == 0) ++waitedTicks_;
      break;
    }
    wanted_ = next_;
    hasNext_ = false;
    waitedTicks_ = 0;
    ++followed;
  }
  if (!wanted_.present) {
    moving_ = false;
    return false;
  }
  const DeviceState& wanted = wanted_.state;
  const double dt = std::clamp(timeS - lastS_, 0.0, 0.05);
  lastS_ = timeS;
  if (!moving_) {
    now_ = wanted;  // Where it came back is where it is.
    moving_ = true;
  } else {
    // What comes late is not smoothed on top: a stroke's corners would be cut off.
    const double part = options_.smoothSeconds > 0 && !hasNext_ ? 1 - std::exp(-dt / options_.smoothSeconds) : 1;
    // As fast as the cursor: between two models, or across a large one, that is many metres a second.
    const Vec3d step = part * (wanted.pose.translation - now_.pose.translation);
    const Vec3d place = now_.pose.translation + step;
    const Eigen::Quaterniond rotation = now_.pose.rotation.slerp(part, wanted.pose.rotation);
    now_ = wanted;
    now_.pose.translation = place;
    now_.pose.rotation = rotation;
  }
  state = now_;
  return true;
}

std::string PointerDevice::status() const {
  return present_.load() ? "pointer: ready" : "pointer: waiting for the mouse or the pen; move it over the window";
}

}  // namespace argil::haptics
