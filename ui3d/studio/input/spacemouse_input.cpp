#include "ui3d/studio/input/spacemouse_input.h"

#include <algorithm>
#include <cmath>

#include "haptics/devices/spacemouse.h"

namespace argil::studio {
namespace {

constexpr double kLookS = 2;
constexpr double kLongestS = 0.25;  // After a longer pause a reading only begins anew.
constexpr float kRest = 1e-3f;

haptics::SpaceMouseOptions optionsOf() {
  haptics::SpaceMouseOptions options;
  options.boxMm.setConstant(1e9);  // A view has no walls.
  return options;
}

bool plugged() {
  const auto nodes = haptics::hidNodes();
  return std::any_of(nodes.begin(), nodes.end(),
                     [](const haptics::HidNode& n) { return haptics::isSpaceMouse(n.vendor, n.product); });
}

}  // namespace

SpaceMouseInput::SpaceMouseInput() = default;
SpaceMouseInput::~SpaceMouseInput() = default;

void SpaceMouseInput::yield(bool free) {
  free_ = free;
  if (!free) device_.reset();
}

std::optional<std::array<float, 6>> SpaceMouseInput::poll(double nowS) {
  if (!free_) return std::nullopt;
  if (!device_) {
    if (nowS - lookedS_ < kLookS) return std::nullopt;
    lookedS_ = nowS;
    if (!plugged()) return std::nullopt;
    device_ = haptics::openSpaceMouse(optionsOf());
    lastS_ = -1;
  }
  haptics::DeviceState state;
  if (!device_->read(nowS, state)) {
    lastS_ = -1;
    return std::nullopt;
  }
  // The driver gives a place that its velocities add up to: the difference gives them back.
  const Vec3d& p = state.pose.translation;
  const Eigen::Quaterniond& q = state.pose.rotation;
  const double dt = nowS - lastS_;
  const Vec3d moved = p - Vec3d(before_[0], before_[1], before_[2]);
  const Eigen::AngleAxisd turned(q * Eigen::Quaterniond(before_[6], before_[3], before_[4], before_[5]).conjugate());
  const bool fresh = lastS_ >= 0 && dt > 0 && dt < kLongestS;
  before_ = {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
  lastS_ = nowS;
  if (!fresh) return std::nullopt;
  const haptics::SpaceMouseOptions options;
  const Vec3d t = moved / (dt * options.topSpeedMms), r = turned.axis() * (turned.angle() / (dt * options.topTurnRads));
  std::array<float, 6> axes;
  for (int i = 0; i < 2; ++i) {
    const Vec3d& v = i ? r : t;  // x right, y away from the person, z up.
    axes[size_t(3 * i)] = float(std::clamp(v.x(), -1.0, 1.0));
    axes[size_t(3 * i + 1)] = float(std::clamp(v.z(), -1.0, 1.0));
    axes[size_t(3 * i + 2)] = float(std::clamp(-v.y(), -1.0, 1.0));
  }
  if (std::all_of(axes.begin(), axes.end(), [](float a) { return std::abs(a) < kRest; })) return std::nullopt;
  return axes;
}

}  // namespace argil::studio
