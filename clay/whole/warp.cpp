#include "clay/whole/warp.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

constexpr double kTau = 6.283185307179586;

WarpAxis checked(const char* what, WarpAxis axis, double value) {
  if (!axis.originMm.allFinite() || !axis.direction.allFinite() || !std::isfinite(axis.fromMm) ||
      !std::isfinite(axis.toMm) || !std::isfinite(value))
    throw Error(fmt::format("{} with a number that is not finite: give finite ones", what));
  const double length = std::sqrt(axis.direction.squaredNorm());
  if (!(length > 1e-12))
    throw Error(fmt::format("{} about an axis without a direction: give one that is not zero", what));
  axis.direction /= length;
  if (!(axis.toMm - axis.fromMm > 1e-9))
    throw Error(fmt::format("{} over a range from {} to {} mm: it must end behind its beginning", what, axis.fromMm,
                            axis.toMm));
  return axis;
}

// 0 before the range, 1 behind it, and its derivative along the axis.
struct Growth {
  double t, slope;
};
Growth growth(const WarpAxis& axis, double along) {
  const double length = axis.toMm - axis.fromMm;
  const double t = (along - axis.fromMm) / length;
  if (t <= 0) return {0, 0};
  if (t >= 1) return {1, 0};
  return {t, 1 / length};
}

bool before(const WarpAxis& axis, const BoxMm& box) {
  const Vec3d centre = (box.low + box.high) / 2, half = (box.high - box.low) / 2;
  return (centre - axis.originMm).dot(axis.direction) + half.dot(axis.direction.cwiseAbs()) <= axis.fromMm;
}

}  // namespace

Turn turnBy(double angle) {
  const double quarters = std::floor(angle * (4 / kTau) + 0.5);
  // A quarter turn in two parts, of which the first has few enough bits for its multiples to be exact.
  const double r = (angle - quarters * 1.5707963267341256) - quarters * 6.077100506506192e-11;
  const double r2 = r * r;
  double sine = 0, cosine = 0;
  for (int n = 19; n >= 3; n -= 2) sine = (1 + sine) * (-r2 / (n * (n - 1)));
  for (int n = 20; n >= 2; n -= 2) cosine = (1 + cosine) * (-r2 / (n * (n - 1)));
  sine = r + r * sine;
  cosine = 1 + cosine;
  switch (static_cast<int64_t>(quarters) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

Twist::Twist(const WarpAxis& axis, double angle) : axis_(checked("twist", axis, angle)), angle_(angle) {
  if (std::abs(angle) > 20 * kTau) throw Error(fmt::format("twist by {} turns: give at most 20", angle / kTau));
}

Vec3d Twist::map(const Vec3d& p, Eigen::Matrix3d& jacobian) const {
  const Vec3d& a = axis_.direction;
  const Vec3d d = p - axis_.originMm;
  const double along = d.dot(a);
  const Growth g = growth(axis_, along);
  const Turn turn = turnBy(angle_ * g.t);
  const Vec3d across = d - along * a, side = a.cross(across);
  jacobian = turn.cosine * Eigen::Matrix3d::Identity() + (1 - turn.cosine) * (a * a.transpose());
  jacobian(0, 1) -= turn.sine * a.z();
  jacobian(0, 2) += turn.sine * a.y();
  jacobian(1, 0) += turn.sine * a.z();
  jacobian(1, 2) -= turn.sine * a.x();
  jacobian(2, 0) -= turn.sine * a.y();
  jacobian(2, 1) += turn.sine * a.x();
  if (g.slope > 0) jacobian += (angle_ * g.slope) * (turn.cosine * side - turn.sine * across) * a.transpose();
  return axis_.originMm + along * a + turn.cosine * across + turn.sine * side;
}

bool Twist::fixes(const BoxMm& box) const {
  return before(axis_, box);
}

Taper::Taper(const WarpAxis& axis, double factor) : axis_(checked("taper", axis, factor)), factor_(factor) {
  if (!(factor >= 0.05 && factor <= 20))
    throw Error(fmt::format("taper to {} times the width: give a factor from 0.05 to 20", factor));
}

Vec3d Taper::map(const Vec3d& p, Eigen::Matrix3d& jacobian) const {
  const Vec3d& a = axis_.direction;
  const Vec3d d = p - axis_.originMm;
  const double along = d.dot(a);
  const Growth g = growth(axis_, along);
  const double scale = 1 + (factor_ - 1) * g.t;
  const Vec3d across = d - along * a;
  jacobian = scale * Eigen::Matrix3d::Identity() + (1 - scale) * (a * a.transpose());
  if (g.slope > 0) jacobian += ((factor_ - 1) * g.slope) * across * a.transpose();
  return axis_.originMm + along * a + scale * across;
}

bool Taper::fixes(const BoxMm& box) const {
  return before(axis_, box);
}

Bend::Bend(const WarpAxis& axis, const Vec3d& towards, double angle)
    : axis_(checked("bend", axis, angle)), angle_(angle) {
  const Vec3d across = towards - towards.dot(axis_.direction) * axis_.direction;
  const double length = std::sqrt(across.squaredNorm());
  if (!across.allFinite() || !(length > 1e-9 * (1 + std::sqrt(towards.squaredNorm()))))
    throw Error("bend towards its own axis: give a direction across it");
  towards_ = across / length;
  if (std::abs(angle) >= kTau)
    throw Error(fmt::format("bend by {} degrees: give less than a full turn", angle / kTau * 360));
}

Vec3d Bend::map(const Vec3d& p, Eigen::Matrix3d& jacobian) const {
  const Vec3d &a = axis_.direction, &b = towards_;
  const Vec3d c = a.cross(b), d = p - axis_.originMm;
  const double along = d.dot(a), y = d.dot(b), x = d.dot(c);
  const Growth g = growth(axis_, along);
  const double phi = angle_ * g.t;
  const Turn turn = turnBy(phi);
  // Of the axis' own point: sin(phi) / phi and (1 − cos(phi)) / phi, without a division by nearly zero.
  const double run = std::min(std::max(along, axis_.fromMm), axis_.toMm) - axis_.fromMm;
  const Turn halfTurn = turnBy(phi / 2);
  const double halfSinc = std::abs(phi) > 1e-6 ? halfTurn.sine / (phi / 2) : 1.0;
  const double sinc = halfSinc * halfTurn.cosine, versinc = halfSinc * halfTurn.sine;
  const double rest = along - axis_.fromMm - run;  // Before or behind the arc: straight on.
  const double newAlong = axis_.fromMm + run * sinc - y * turn.sine + (rest > 0 ? rest * turn.cosine : rest);
  const double newY = run * versinc + y * turn.cosine + (rest > 0 ? rest * turn.sine : 0);
  const double stretch = 1 - y * angle_ * g.slope;  // Of lines along the axis; 1 outside of the range.
  const Vec3d alongTurned = turn.cosine * a + turn.sine * b, towardsTurned = turn.cosine * b - turn.sine * a;
  jacobian = stretch * alongTurned * a.transpose() + towardsTurned * b.transpose() + c * c.transpose();
  return axis_.originMm + newAlong * a + newY * b + x * c;
}

bool Bend::fixes(const BoxMm& box) const {
  return before(axis_, box);
}

Vec3d WarpChain::map(const Vec3d& p, Eigen::Matrix3d& jacobian) const {
  Vec3d at = warps_.front()->map(p, jacobian);
  for (size_t i = 1; i < warps_.size(); ++i) {
    Eigen::Matrix3d own;
    at = warps_[i]->map(at, own);
    const Eigen::Matrix3d before = jacobian;
    jacobian.noalias() = own * before;
  }
  return at;
}

bool WarpChain::fixes(const BoxMm& box) const {
  return std::all_of(warps_.begin(), warps_.end(), [&](const auto& each) { return each->fixes(box); });
}

}  // namespace argil::clay
