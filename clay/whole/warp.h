#pragma once
// Maps of space that clay is deformed by.

#include <Eigen/LU>
#include <memory>
#include <vector>

#include "clay/base/vec.h"

namespace argil::clay {

/// An axis-aligned box, mm.
struct BoxMm {
  Vec3d low = Vec3d::Zero(), high = Vec3d::Zero();
};

/// Where every point of the clay goes; in mm of the piece. Maps must be defined everywhere, continuous, and
/// differentiable but for creases. All of them use add, multiply, divide and square root alone, so that deformed clay
/// has equal bits on every CPU. Const members may be called from any number of threads.
class Warp {
 public:
  virtual ~Warp() = default;
  /// Where `p` goes, and the derivative there (column i: d map / d p_i).
  [[nodiscard]] virtual Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const = 0;
  /// The part of space in which the map must not fold when it is applied to clay that fills `piece`. Throws Error when
  /// it cannot be applied to such clay.
  [[nodiscard]] virtual BoxMm domain(const BoxMm& piece) const { return piece; }
  /// Every point of the box stays where it is.
  [[nodiscard]] virtual bool fixes(const BoxMm&) const { return false; }
};

/// Several warps, one after the other: each takes what the one before it has moved.
class WarpChain : public Warp {
 public:
  /// At least one, none null.
  explicit WarpChain(std::vector<std::shared_ptr<const Warp>> warps) : warps_(std::move(warps)) {}
  [[nodiscard]] Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const override;
  [[nodiscard]] BoxMm domain(const BoxMm& piece) const override { return warps_.front()->domain(piece); }
  [[nodiscard]] bool fixes(const BoxMm& box) const override;

 private:
  std::vector<std::shared_ptr<const Warp>> warps_;
};

/// What bend, twist and taper have in common: a line, and the range along it, measured from `originMm`, over which the
/// deformation grows. What lies before `fromMm` stays, what lies behind `toMm` follows as it is.
struct WarpAxis {
  Vec3d originMm = Vec3d::Zero();
  Vec3d direction = Vec3d::UnitZ();  ///< Need not be of length one.
  double fromMm = 0, toMm = 1;       ///< from < to.
};

/// Turns about the axis by an angle that grows evenly along it; volume is kept.
class Twist : public Warp {
 public:
  /// Angle in rad, at most 20 turns. Throws Error for numbers that are not finite, no direction or an empty range.
  Twist(const WarpAxis& axis, double angle);
  [[nodiscard]] Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const override;
  [[nodiscard]] bool fixes(const BoxMm& box) const override;

 private:
  WarpAxis axis_;
  double angle_;
};

/// Scales across the axis by a factor that goes evenly from 1 to `factor`.
class Taper : public Warp {
 public:
  /// Factor 0.05 to 20. Throws Error as Twist.
  Taper(const WarpAxis& axis, double factor);
  [[nodiscard]] Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const override;
  [[nodiscard]] bool fixes(const BoxMm& box) const override;

 private:
  WarpAxis axis_;
  double factor_;
};

/// Bends the axis into an arc of a circle towards a direction across it. The axis keeps its length; what lies farther
/// than the arc's centre would fold and is refused.
class Bend : public Warp {
 public:
  /// Angle in rad, below a full turn; `towards` is made square to the axis. Throws Error as Twist, or when `towards` is
  /// along the axis.
  Bend(const WarpAxis& axis, const Vec3d& towards, double angle);
  [[nodiscard]] Vec3d map(const Vec3d& p, Eigen::Matrix3d& jacobian) const override;
  [[nodiscard]] bool fixes(const BoxMm& box) const override;

 private:
  WarpAxis axis_;
  Vec3d towards_;
  double angle_;
};

/// Sine and cosine by add and multiply alone, to 1e-15 for |angle| up to 1e3: those of the C library differ between
/// CPUs in the last bit.
struct Turn {
  double sine, cosine;
};
[[nodiscard]] Turn turnBy(double angle);

}  // namespace argil::clay
