#pragma once
// What tells the tools that move clay apart: tug, smudge, pinch, crease and twist, each in the file of its name. This
// module's own.

#include <cmath>
#include <memory>
#include <span>

#include "clay/brush/brush.h"
#include "clay/kernels/warp_kernels.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// A dab without a way counts as this much of one, in radii: what stamps of a stroke are apart.
inline constexpr double kDabWay = 0.1;
/// The largest of t · falloff(t): of what a tool moves that pulls towards its middle, or turns around it.
inline constexpr double kLeverage = 0.65;

/// How far the tip goes, voxels.
inline double wayOf(const Stamp& s) {
  const double length = (s.b - s.a).norm();
  return length > 0 ? length : kDabWay * s.largestRadius();
}

/// Lives as long as the stroke.
class WarpTool {
 public:
  virtual ~WarpTool() = default;
  /// How far a stamp moves clay at most, voxels; `share`: amount times strength, without its sign.
  [[nodiscard]] virtual double mostMove(const Stamp& stamp, double share) const = 0;
  /// Before the stamps of an application; the clay as it is then.
  virtual void begin(Sampler& before, std::span<const Stamp> images) { (void)before, (void)images; }
  /// How the i-th image moves clay: fills in all of `w` but its place, way and radii, which are there. `share`: amount
  /// times strength; `way`: as wayOf().
  virtual void describe(const Stamp& stamp, size_t i, float share, float way, WarpImage& w) const = 0;
};

[[nodiscard]] std::unique_ptr<WarpTool> makeTug();
[[nodiscard]] std::unique_ptr<WarpTool> makeSmudge();
[[nodiscard]] std::unique_ptr<WarpTool> makePinch();
[[nodiscard]] std::unique_ptr<WarpTool> makeCrease();
/// `angle`: rad on a way of a radius.
[[nodiscard]] std::unique_ptr<WarpTool> makeTwist(float angle);

}  // namespace argil::clay
