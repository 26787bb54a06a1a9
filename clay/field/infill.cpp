#include "clay/field/infill.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::clay {

namespace {

constexpr double kSteepest = 1.7320508075688772;  // of the gyroid's function, where its period is 2π
constexpr int kSteps = 4;                         // towards the gyroid: each squares what is left
constexpr double kFlat = 0.3;                     // of a gradient that leads nowhere
constexpr double kMost = 1.5;                     // times the bound: what a way to the nearest place can be

// Axes of a cube that stands on a corner, as rows.
Eigen::Matrix3d onCorner() {
  const double across = std::sqrt(2.0 / 3), half = 1 / std::sqrt(6.0), side = std::sqrt(0.5), up = 1 / std::sqrt(3.0);
  Eigen::Matrix3d rows;
  rows << across, 0, up, -half, side, up, -half, -side, up;
  return rows;
}

struct Gyroid {
  double value;
  Vec3d gradient;
};
Gyroid gyroid(const Vec3d& p) {
  const double sx = std::sin(p.x()), sy = std::sin(p.y()), sz = std::sin(p.z());
  const double cx = std::cos(p.x()), cy = std::cos(p.y()), cz = std::cos(p.z());
  return {sx * cy + sy * cz + sz * cx, {cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz}};
}

// From `p` to the gyroid of period 2π: all of it but a few thousandths where it is nearer than `near`, else less.
double toGyroid(const Vec3d& p, double near) {
  Gyroid at = gyroid(p);
  const double least = std::abs(at.value) / kSteepest;
  if (least > near) return least;
  Vec3d q = p;
  for (int i = 0; i < kSteps; ++i) {
    const double steep2 = at.gradient.squaredNorm();
    if (steep2 < kFlat * kFlat) return least;
    q -= at.gradient * (at.value / steep2);
    at = gyroid(q);
  }
  return std::clamp((q - p).norm(), least, kMost * least);
}

}  // namespace

InfillField::InfillField(Infill kind, double cell, double wall, const Eigen::Matrix3d& turn, double near)
    : kind_(kind),
      cell_(cell),
      wall_(wall),
      near_(near),
      axes_(kind == Infill::gyroid ? turn : Eigen::Matrix3d(onCorner() * turn)) {}

double InfillField::distance(const Vec3d& p) const {
  const Vec3d at = axes_ * p;
  if (kind_ == Infill::gyroid) {
    const double scale = 2 * std::numbers::pi / cell_;
    return toGyroid(at * scale, (wall_ / 2 + near_) * scale) / scale - wall_ / 2;
  }
  Vec3d to;
  for (int i = 0; i < 3; ++i) to[i] = cell_ / 2 - std::abs(at[i] - cell_ * std::round(at[i] / cell_));
  if (kind_ == Infill::cubic) return to.minCoeff() - wall_ / 2;
  const Vec3d squared = to.cwiseProduct(to);
  return std::sqrt(squared.sum() - squared.maxCoeff()) - wall_ / 2;
}

double infillDensity(Infill kind, double wallPerCell) {
  const double t = wallPerCell;
  switch (kind) {
    case Infill::gyroid:
      return std::min(1.0, 3.0915 * t);  // the area of a cell of edge 1
    case Infill::cubic:
      return t < 1 ? 1 - std::pow(1 - t, 3) : 1;
    case Infill::struts: {
      // Three round bars, less what two and three of them have in common.
      const double r = t / 2;
      return std::min(1.0, 3 * std::numbers::pi * r * r - 8 * std::numbers::sqrt2 * r * r * r);
    }
  }
  return 0;
}

}  // namespace argil::clay
