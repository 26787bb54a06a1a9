#include "haptics/devices/hand_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

bool finite(const HandPoint& p) {
  return std::isfinite(p.timeS) && p.position.allFinite() && p.rotation.coeffs().allFinite() && p.forceN.allFinite() &&
         std::isfinite(p.pressure);
}

}  // namespace

HandPath::HandPath(std::vector<HandPoint> points) : points_(std::move(points)) {
  for (size_t i = 0; i < points_.size(); ++i) {
    if (!finite(points_[i]))
      throw Error("hand path: point " + std::to_string(i) + " holds a number that is not finite");
    if (i && points_[i].timeS <= points_[i - 1].timeS)
      throw Error("hand path: the time of point " + std::to_string(i) + " is not after the one before it");
    points_[i].rotation.normalize();
  }
}

HandPath HandPath::unchecked(std::vector<HandPoint> points) {
  HandPath path;
  path.points_ = std::move(points);
  return path;
}

double HandPath::durationS() const noexcept {
  return points_.empty() ? 0 : points_.back().timeS;
}

HandPoint HandPath::at(double timeS, size_t& hint) const ARGIL_REALTIME {
  if (points_.empty()) return {};
  if (hint >= points_.size() || points_[hint].timeS > timeS) hint = 0;
  while (hint + 1 < points_.size() && points_[hint + 1].timeS <= timeS) ++hint;
  HandPoint result = points_[hint];
  result.timeS = timeS;
  if (hint + 1 == points_.size() || timeS <= points_[hint].timeS) return result;
  const HandPoint &a = points_[hint], &b = points_[hint + 1];
  const double s = (timeS - a.timeS) / (b.timeS - a.timeS);
  result.position = a.position + s * (b.position - a.position);
  result.forceN = a.forceN + s * (b.forceN - a.forceN);
  result.rotation = a.rotation.slerp(s, b.rotation);
  return result;
}

HandPath HandPath::hold(const Vec3d& position, double seconds, uint32_t buttons) {
  HandPoint a;
  a.position = position;
  a.buttons = buttons;
  a.pressure = buttons ? 1.0f : 0.0f;
  HandPoint b = a;
  b.timeS = seconds;
  return HandPath({a, b});
}

HandPath HandPath::line(const Vec3d& a, const Vec3d& b, double seconds, uint32_t buttons, double stepS) {
  const int steps = std::max(1, static_cast<int>(std::ceil(seconds / stepS)));
  std::vector<HandPoint> points(static_cast<size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    HandPoint& p = points[static_cast<size_t>(i)];
    const double s = double(i) / steps;
    p.timeS = s * seconds;
    p.position = a + s * s * s * (10 + s * (6 * s - 15)) * (b - a);
    p.buttons = buttons;
    p.pressure = buttons ? 1.0f : 0.0f;
  }
  return HandPath(std::move(points));
}

HandPath HandPath::circle(const Vec3d& centre, const Vec3d& start, const Vec3d& axis, double turns, double seconds,
                          uint32_t buttons, double stepS) {
  const int steps = std::max(1, static_cast<int>(std::ceil(seconds / stepS)));
  std::vector<HandPoint> points(static_cast<size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    HandPoint& p = points[static_cast<size_t>(i)];
    const double s = double(i) / steps;
    p.timeS = s * seconds;
    p.position = centre + Eigen::AngleAxisd(2 * std::numbers::pi * turns * s, axis) * (start - centre);
    p.buttons = buttons;
    p.pressure = buttons ? 1.0f : 0.0f;
  }
  return HandPath(std::move(points));
}

HandPath HandPath::then(const HandPath& next) const {
  HandPath result = *this;
  const double shift = durationS() + 1e-6;  // Keeps times increasing where one path ends and the other begins.
  for (HandPoint p : next.points_) {
    p.timeS += points_.empty() ? 0 : shift;
    result.points_.push_back(p);
  }
  return result;
}

}  // namespace argil::haptics
