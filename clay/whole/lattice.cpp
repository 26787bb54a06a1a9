#include "clay/whole/lattice.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

constexpr int kMost = 8;

// Bernstein polynomials of degree count − 1 at t, and their derivatives.
struct Basis {
  double value[kMost], slope[kMost];
  Basis(int count, double t) {
    const int degree = count - 1;
    value[0] = 1;
    for (int d = 1; d <= degree; ++d) {
      if (d == degree) {  // From those of one degree less come the derivatives.
        slope[0] = -degree * value[0];
        for (int i = 1; i < degree; ++i) slope[i] = degree * (value[i - 1] - value[i]);
        slope[degree] = degree * value[degree - 1];
      }
      value[d] = t * value[d - 1];
      for (int i = d - 1; i > 0; --i) value[i] = (1 - t) * value[i] + t * value[i - 1];
      value[0] = (1 - t) * value[0];
    }
  }
};

bool within(const BoxMm& box, const Vec3d& p) {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

}  // namespace

Lattice::Lattice(const BoxMm& box, std::array<int, 3> counts) : box_(box), counts_(counts) {
  if (!box.low.allFinite() || !box.high.allFinite() || !((box.high - box.low).minCoeff() > 1e-6))
    throw Error("lattice over a box without extent: each side needs more than 1e-6 mm");
  for (const int n : counts)
    if (n < 2 || n > kMost)
      throw Error(
          fmt::format("lattice of {} × {} × {} points: give 2 to {} an axis", counts[0], counts[1], counts[2], kMost));
  points_.resize(static_cast<size_t>(counts[0] * counts[1] * counts[2]));
  for (size_t i = 0; i < points_.size(); ++i) points_[i] = restPoint(i);
  place();
}

Lattice Lattice::around(const BoxMm& piece, std::array<int, 3> counts) {
  const Vec3d margin = Vec3d::Constant((piece.high - piece.low).maxCoeff() / 20);
  return Lattice({piece.low - margin, piece.high + margin}, counts);
}

size_t Lattice::index(int x, int y, int z) const {
  return static_cast<size_t>((x * counts_[1] + y) * counts_[2] + z);
}

Vec3d Lattice::restPoint(size_t index) const {
  const int i = static_cast<int>(index), z = i % counts_[2], y = i / counts_[2] % counts_[1],
            x = i / (counts_[2] * counts_[1]);
  const Vec3d t(double(x) / (counts_[0] - 1), double(y) / (counts_[1] - 1), double(z) / (counts_[2] - 1));
  return box_.low + t.cwiseProduct(box_.high - box_.low);
}

void Lattice::setPoint(size_t index, const Vec3d& mm) {
  if (index >= points_.size()) throw Error(fmt::format("lattice point {}: it has {}", index, points_.size()));
  if (!mm.allFinite()) throw Error("lattice point at a place that is not finite: give finite numbers");
  points_[index] = mm;
  place();
}

void Lattice::place() {
  packed_.resize(points_.size());
  moved_ = sidesMoved_ = false;
  for (size_t n = 0; n < points_.size(); ++n) {
    packed_[n] << points_[n], 0;
    if (points_[n] == restPoint(n)) continue;
    moved_ = true;
    const int i = static_cast<int>(n), z = i % counts_[2], y = i / counts_[2] % counts_[1],
              x = i / (counts_[2] * counts_[1]);
    sidesMoved_ |= x == 0 || y == 0 || z == 0 || x == counts_[0] - 1 || y == counts_[1] - 1 || z == counts_[2] - 1;
  }
}

void Lattice::drag(const Vec3d& p, const Vec3d& by) {
  if (!p.allFinite() || !by.allFinite())
    throw Error("lattice dragged by numbers that are not finite: give finite ones");
  const Vec3d t = (p - box_.low).cwiseQuotient(box_.high - box_.low).cwiseMax(0.0).cwiseMin(1.0);
  const Basis u(counts_[0], t.x()), v(counts_[1], t.y()), w(counts_[2], t.z());
  double squares = 0;
  std::vector<double> weight(points_.size());
  size_t n = 0;
  for (int x = 0; x < counts_[0]; ++x)
    for (int y = 0; y < counts_[1]; ++y)
      for (int z = 0; z < counts_[2]; ++z, ++n) {
        weight[n] = u.value[x] * v.value[y] * w.value[z];
        squares += weight[n] * weight[n];
      }
  for (n = 0; n < points_.size(); ++n) points_[n] += weight[n] / squares * by;
  place();
}

bool Lattice::moved() const {
  return moved_;
}

Vec3d Lattice::map(const Vec3d& p, Eigen::Matrix3d& jacobian) const {
  if (!sidesMoved_ && !within(box_, p)) {
    jacobian.setIdentity();
    return p;
  }
  using Eigen::Vector4d;
  const Vec3d size = box_.high - box_.low, t = (p - box_.low).cwiseQuotient(size);
  const Basis u(counts_[0], t.x()), v(counts_[1], t.y()), w(counts_[2], t.z());
  Vector4d value = Vector4d::Zero(), alongU = value, alongV = value, alongW = value;
  const Vector4d* at = packed_.data();
  for (int x = 0; x < counts_[0]; ++x) {
    Vector4d plane = Vector4d::Zero(), planeV = plane, planeW = plane;
    for (int y = 0; y < counts_[1]; ++y) {
      Vector4d row = Vector4d::Zero(), rowW = row;
      for (int z = 0; z < counts_[2]; ++z, ++at) {
        row += w.value[z] * *at;
        rowW += w.slope[z] * *at;
      }
      plane += v.value[y] * row;
      planeV += v.slope[y] * row;
      planeW += v.value[y] * rowW;
    }
    value += u.value[x] * plane;
    alongU += u.slope[x] * plane;
    alongV += u.value[x] * planeV;
    alongW += u.value[x] * planeW;
  }
  jacobian.col(0) = alongU.head<3>() / size.x();
  jacobian.col(1) = alongV.head<3>() / size.y();
  jacobian.col(2) = alongW.head<3>() / size.z();
  return value.head<3>();
}

BoxMm Lattice::domain(const BoxMm& piece) const {
  if (sidesMoved_ && !(within(box_, piece.low) && within(box_, piece.high)))
    throw Error(
        "the lattice's box does not hold the whole piece, and points on its sides were moved: enlarge the box, or move "
        "inner points alone");
  return box_;
}

bool Lattice::fixes(const BoxMm& box) const {
  if (!moved_) return true;
  if (sidesMoved_) return false;
  return (box.high.array() < box_.low.array()).any() || (box.low.array() > box_.high.array()).any();
}

}  // namespace argil::clay
