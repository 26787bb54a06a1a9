#include "haptics/servo/velocity_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::haptics {
namespace {

constexpr double kLongestS = 0.016;   // A window longer than this lags behind what a hand does on purpose.
constexpr double kSmoothingHz = 150;  // Of the low-pass on the slope: it halves the noise for a millisecond of lag.
constexpr double kMarginSteps = 1.0;  // Both ends of a line are off by half a step at most.
constexpr double kTogether = 0.1;     // Of a period: positions closer in time are one.

// A division is most of what a step back costs.
struct Inverses {
  double of[VelocityFilter::kWindow + 1];
  Inverses() {
    for (int i = 0; i <= VelocityFilter::kWindow; ++i) of[i] = i ? 1.0 / i : 0.0;
  }
};
const Inverses kInverse;

}  // namespace

VelocityFilter::VelocityFilter(double periodS, double stepMm)
    : periodS_(periodS),
      // Never quite zero: rounding of exact positions must not shorten the window.
      margin_(std::max(kMarginSteps * stepMm, 1e-9)),
      smoothing_(1 - std::exp(-2 * std::numbers::pi * kSmoothingHz * periodS)),
      longest_(std::clamp(static_cast<int>(std::lround(kLongestS / periodS)), 2, kWindow)) {}

Vec3d VelocityFilter::add(const Vec3d& position, double elapsedS) ARGIL_REALTIME {
  const double periods = pending_ + (elapsedS == kOnePeriod || elapsedS == periodS_ ? 1.0 : elapsedS / periodS_);
  if (count_ > 0 && !(periods > kTogether)) {
    pending_ = periods > 0 ? periods : 0;
    return velocity_;
  }
  pending_ = 0;
  return measure(position, periods);
}

Vec3d VelocityFilter::measure(const Vec3d& position, double periods) ARGIL_REALTIME {
  newest_ = count_ ? (newest_ + 1) % (kWindow + 1) : 0;
  if (count_ == 0) velocity_.setZero();
  ring_[static_cast<size_t>(newest_)] = position;
  took_[static_cast<size_t>(newest_)] = periods;
  regular_ = periods == 1.0 ? std::min(regular_ + 1, kWindow + 1) : 0;
  count_ = std::min(count_ + 1, kWindow + 1);
  const int reach = std::min(count_ - 1, regular_ >= longest_ ? longest_ : kWindow);
  const double smoothing =
      periods == 1.0 ? smoothing_ : 1 - std::exp(-2 * std::numbers::pi * kSmoothingHz * periods * periodS_);
  for (int axis = 0; axis < 3; ++axis) {
    // Slopes per period of lines through the newest position that pass within the margin of every position so far.
    double least = -1e300, most = 1e300, slope = 0, span = 0;
    int at = newest_;
    for (int back = 1; back <= reach; ++back) {
      span += took_[static_cast<size_t>(at)];
      if (back > 1 && span > longest_) break;  // As far back in time, however many positions came in it.
      at = at ? at - 1 : kWindow;
      const double gone = position[axis] - ring_[static_cast<size_t>(at)][axis];
      const double inverse = back <= regular_ ? kInverse.of[back] : 1 / span;
      const double candidate = gone * inverse;
      if (candidate < least || candidate > most) break;
      slope = candidate;
      least = std::max(least, (gone - margin_) * inverse);
      most = std::min(most, (gone + margin_) * inverse);
    }
    velocity_[axis] += smoothing * (slope / periodS_ - velocity_[axis]);
  }
  return velocity_;
}

}  // namespace argil::haptics
