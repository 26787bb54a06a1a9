#include "haptics/devices/recorded.h"

#include <algorithm>
#include <cstdio>

#include "clay/base/error.h"

namespace argil::haptics {

RecordedDevice::RecordedDevice(HandPath path, Options options) : path_(std::move(path)), options_(std::move(options)) {
  if (path_.empty()) throw Error(options_.name + ": the hand path holds no points");
  sheet_.name = options_.name;
  sheet_.like = "a recorded hand";
  sheet_.dofIn = 6;
  sheet_.dofOut = 0;  // What the sheet says of forces is what contact reckons with.
  sheet_.resolutionMm = 1e-3;
  const auto& points = path_.points();
  Vec3d farthest = Vec3d::Constant(1);
  double fastest = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    farthest = farthest.cwiseMax(points[i].position.cwiseAbs());
    if (i > 0)
      fastest = std::max(
          fastest, (points[i].position - points[i - 1].position).norm() / (points[i].timeS - points[i - 1].timeS));
  }
  sheet_.workspaceMm = 2 * farthest;
  sheet_.topSpeedMms = std::max(sheet_.topSpeedMms, 1.5 * fastest);  // What a hand did is no fault of a mechanism.
}

bool RecordedDevice::read(double timeS, DeviceState& state) ARGIL_REALTIME {
  if (!started_) {
    started_ = true;
    startS_ = timeS;
  }
  const double first = path_.points().front().timeS;
  const double t = first + timeS - startS_;
  if (t > path_.durationS()) {
    if (options_.loop) {
      started_ = false;
      return false;
    }
    ended_.store(true, std::memory_order_relaxed);
    return false;
  }
  const HandPoint p = path_.at(t, hint_);
  playedS_.store(t, std::memory_order_relaxed);
  state.pose.translation = p.position;
  state.pose.rotation = p.rotation;
  state.pressure = p.pressure;
  state.buttons = p.buttons;
  return true;
}

std::string RecordedDevice::status() const {
  if (ended_.load()) return options_.name + ": played to its end";
  char text[64];
  std::snprintf(text, sizeof text, ": ready, %.1f of %.1f s played", playedS_.load(), path_.durationS());
  return options_.name + text;
}

}  // namespace argil::haptics
