#include "haptics/velocity_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::haptics {
namespace {

constexpr double kLongestS = 0.016;    // A window longer than this lags behind what a hand does on purpose.
constexpr double kSmoothingHz = 150;   // Of the low-pass on the slope: it halves the noise for a millisecond of lag.
constexpr double kMarginSteps = 1.0;   // Both ends of a line are off by half a step at most.

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

Vec3d VelocityFilter::add(const Vec3d& position) ARGIL_REALTIME {
  newest_ = count_ ? (newest_ + 1) % (kWindow + 1) : 0;
  if (count_ == 0) velocity_.setZero();
  ring_[static_cast<size_t>(newest_)] = position;
  count_ = std::min(count_ + 1, kWindow + 1);
  const int reach = std::min(count_ - 1, longest_);
  for (int axis = 0; axis < 3; ++axis) {
    // Slopes per tick of lines through the newest position that pass within the margin of every position so far.
    double least = -1e300, most = 1e300, slope = 0;
    int at = newest_;
    for (int back = 1; back <= reach; ++back) {
      at = at ? at - 1 : kWindow;
      const double gone = position[axis] - ring_[static_cast<size_t>(at)][axis], inverse = kInverse.of[back];
      const double candidate = gone * inverse;
      if (candidate < least || candidate > most) break;
      slope = candidate;
      least = std::max(least, (gone - margin_) * inverse);
      most = std::min(most, (gone + margin_) * inverse);
    }
    velocity_[axis] += smoothing_ * (slope / periodS_ - velocity_[axis]);
  }
  return velocity_;
}

}  // namespace argil::haptics
