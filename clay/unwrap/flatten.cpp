#include "clay/unwrap/flatten.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::clay {

namespace {

using Mat2d = Eigen::Matrix2d;
using Sparse = Eigen::SparseMatrix<double>;
using Solver = Eigen::SimplicialLDLT<Sparse>;

constexpr double kStay = 1e-4;       // of the stiffness: how much a vertex is held where it is
constexpr double kEnough = 1e-5;     // of the energy: less gain in a round ends the work
constexpr double kBeforeFold = 0.8;  // of the way to the first fold
constexpr int kHalvings = 12;
constexpr double kLeastHeight = 1e-5;  // of a triangle's side: what has less is given that

// A triangle in its own plane: gradients of its corners' hat functions, and its area.
struct Flat {
  std::array<Vec2d, 3> gradient;
  double area = 0;
};

std::optional<Flat> flatOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d side = b - a, other = c - a;
  const double length = side.norm();
  if (!(length > 0)) return std::nullopt;
  const double x = other.dot(side) / length, y = std::max(side.cross(other).norm() / length, kLeastHeight * length),
               twice = length * y;
  Flat flat;
  flat.area = 0.5 * twice;
  flat.gradient[1] = Vec2d(y, -x) / twice;
  flat.gradient[2] = Vec2d(0, length) / twice;
  flat.gradient[0] = -flat.gradient[1] - flat.gradient[2];
  return flat;
}

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

class Flattening {
 public:
  Flattening(const SurfaceDisk& disk, std::vector<Flat> flats) : disk_(disk), flats_(std::move(flats)) {}

  // Inside a circle of the surface's area, each vertex in the middle of its neighbours.
  bool inCircle() {
    const size_t count = disk_.positions.size(), rim = disk_.boundary.size();
    double area = 0, length = 0;
    for (const Flat& each : flats_) area += each.area;
    const auto side = [&](size_t i) {
      return (disk_.positions[disk_.boundary[(i + 1) % rim]] - disk_.positions[disk_.boundary[i]]).norm();
    };
    for (size_t i = 0; i < rim; ++i) length += side(i);
    const double radius = std::sqrt(area / std::numbers::pi);
    places_.assign(count, Vec2d::Zero());
    std::vector<uint32_t> unknown(count, 0);
    double along = 0;
    for (size_t i = 0; i < rim; ++i) {
      const double angle = 2 * std::numbers::pi * along / length;
      places_[disk_.boundary[i]] = radius * Vec2d(std::cos(angle), std::sin(angle));
      unknown[disk_.boundary[i]] = UINT32_MAX;
      along += side(i);
    }
    uint32_t inner = 0;
    for (uint32_t& each : unknown)
      if (each != UINT32_MAX) each = inner++;
    if (inner > 0) {
      std::vector<Eigen::Triplet<double>> entries;
      Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(inner, 2);
      // Each side inside is seen from both its triangles, once a way: every neighbour once.
      for (const auto& t : disk_.triangles)
        for (size_t s = 0; s < 3; ++s) {
          const uint32_t from = t[s], to = t[(s + 1) % 3];
          if (unknown[from] == UINT32_MAX) continue;
          entries.emplace_back(unknown[from], unknown[from], 1);
          if (unknown[to] == UINT32_MAX)
            right.row(unknown[from]) += places_[to].transpose();
          else
            entries.emplace_back(unknown[from], unknown[to], -1);
        }
      Sparse matrix(inner, inner);
      matrix.setFromTriplets(entries.begin(), entries.end());
      Solver solver(matrix);
      if (solver.info() != Eigen::Success) return false;
      const Eigen::MatrixX2d solved = solver.solve(right);
      for (size_t v = 0; v < count; ++v)
        if (unknown[v] != UINT32_MAX) places_[v] = solved.row(unknown[v]).transpose();
    }
    return std::isfinite(energy(places_));
  }

  void relax(int rounds) {
    double before = energy(places_);
    for (int round = 0; round < rounds; ++round) {
      const std::vector<Vec2d> aim = solved();
      std::vector<Vec2d> way(aim.size()), next(aim.size());
      for (size_t v = 0; v < aim.size(); ++v) way[v] = aim[v] - places_[v];
      double step = std::min(1.0, kBeforeFold * toFold(way)), now = before;
      for (int halving = 0; halving < kHalvings; ++halving, step /= 2) {
        for (size_t v = 0; v < aim.size(); ++v) next[v] = places_[v] + step * way[v];
        now = energy(next);
        if (now < before) break;
      }
      if (!(now < before)) break;
      places_ = next;
      const bool last = before - now < kEnough * before;
      before = now;
      if (last) break;
    }
  }

  FlatDisk result() && {
    double surface = 0, flat = 0, sum = 0;
    for (size_t t = 0; t < flats_.size(); ++t) {
      const Mat2d j = jacobian(t, places_);
      const double determinant = j.determinant();
      surface += flats_[t].area;
      flat += flats_[t].area * determinant;
      // The squares of the inverse's singular values.
      sum += flats_[t].area * j.squaredNorm() / (2 * determinant * determinant);
    }
    FlatDisk out;
    out.stretch = std::sqrt(sum / surface * flat / surface);
    const double scale = std::sqrt(surface / flat);
    for (Vec2d& each : places_) each *= scale;
    out.places = std::move(places_);
    return out;
  }

 private:
  [[nodiscard]] Mat2d jacobian(size_t t, const std::vector<Vec2d>& places) const {
    Mat2d j = Mat2d::Zero();
    for (size_t i = 0; i < 3; ++i) j += places[disk_.triangles[t][i]] * flats_[t].gradient[i].transpose();
    return j;
  }

  // |J|² + |1/J|² over the surface; infinite with a fold.
  [[nodiscard]] double energy(const std::vector<Vec2d>& places) const {
    double sum = 0;
    for (size_t t = 0; t < flats_.size(); ++t) {
      const Mat2d j = jacobian(t, places);
      const double determinant = j.determinant();
      if (!(determinant > 0)) return INFINITY;
      sum += flats_[t].area * j.squaredNorm() * (1 + 1 / (determinant * determinant));
    }
    return sum;
  }

  // Visits the entries below the diagonal, and on it, of each triangle's six rows and columns, always in one order:
  // visit(corner of the row, of the column, axis of the row, of the column, row, column).
  template <class Visit>
  static void forLower(const std::array<uint32_t, 3>& corners, const Visit& visit) {
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k) {
        if (corners[i] < corners[k]) continue;
        for (int a = 0; a < 2; ++a)
          for (int b = 0; b < (i == k ? a + 1 : 2); ++b)
            visit(i, k, a, b, 2 * static_cast<int>(corners[i]) + a, 2 * static_cast<int>(corners[k]) + b);
      }
  }

  // Where the entries of the triangles are added up: the same from round to round.
  void prepare() {
    const auto count = static_cast<int>(2 * places_.size());
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(disk_.triangles.size() * kLowerEntries + static_cast<size_t>(count));
    for (const auto& corners : disk_.triangles)
      forLower(corners, [&](size_t, size_t, int, int, int row, int column) { entries.emplace_back(row, column, 0.0); });
    for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 0.0);
    matrix_.resize(count, count);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    const int *outer = matrix_.outerIndexPtr(), *inner = matrix_.innerIndexPtr();
    const auto slotOf = [&](int row, int column) {
      return static_cast<int>(std::lower_bound(inner + outer[column], inner + outer[column + 1], row) - inner);
    };
    slots_.reserve(disk_.triangles.size() * kLowerEntries);
    for (const auto& corners : disk_.triangles)
      forLower(corners, [&](size_t, size_t, int, int, int row, int column) { slots_.push_back(slotOf(row, column)); });
    for (int i = 0; i < count; ++i) diagonal_.push_back(slotOf(i, i));
    solver_.analyzePattern(matrix_);
  }

  // Where a quadratic energy has its least that agrees with the true one here in value and slope.
  std::vector<Vec2d> solved() {
    if (slots_.empty()) prepare();
    const auto count = static_cast<Eigen::Index>(places_.size());
    double* values = matrix_.valuePtr();
    std::fill_n(values, matrix_.nonZeros(), 0.0);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * count);
    double stiffness = 0;
    const int* slot = slots_.data();
    for (size_t t = 0; t < flats_.size(); ++t) {
      // A turn, then a stretch along two directions, each with a weight (squared) of its own: a function of a symmetric
      // matrix of two rows, which needs no decomposition.
      const Mat2d j = jacobian(t, places_);
      Mat2d rotation;
      rotation << j(0, 0) + j(1, 1), j(0, 1) - j(1, 0), j(1, 0) - j(0, 1), j(0, 0) + j(1, 1);
      rotation /= std::hypot(rotation(0, 0), rotation(1, 0));
      const Mat2d stretch = j * rotation.transpose();
      const auto weight = [](double s) { return std::abs(s - 1) < 1e-6 ? 4.0 : (s - 1 / (s * s * s)) / (s - 1); };
      const double middle = (stretch(0, 0) + stretch(1, 1)) / 2, half = (stretch(0, 0) - stretch(1, 1)) / 2,
                   apart = std::hypot(half, (stretch(0, 1) + stretch(1, 0)) / 2);
      const double most = weight(middle + apart), least = weight(middle - apart);
      Mat2d metric = (most + least) / 2 * Mat2d::Identity();
      if (apart > 1e-12 * middle) metric += (most - least) / 2 / apart * (stretch - middle * Mat2d::Identity());
      const Mat2d turned = metric * rotation;
      const auto& corners = disk_.triangles[t];
      for (size_t i = 0; i < 3; ++i)
        right.segment<2>(2 * static_cast<Eigen::Index>(corners[i])) += flats_[t].area * turned * flats_[t].gradient[i];
      double blocks[3][3];
      for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k) blocks[i][k] = flats_[t].area * flats_[t].gradient[i].dot(flats_[t].gradient[k]);
      for (size_t i = 0; i < 3; ++i) stiffness += blocks[i][i] * metric.trace();
      forLower(corners,
               [&](size_t i, size_t k, int a, int b, int, int) { values[*slot++] += blocks[i][k] * metric(a, b); });
    }
    const double stay = kStay * stiffness / double(2 * count);
    for (const int each : diagonal_) values[each] += stay;
    for (Eigen::Index v = 0; v < count; ++v) right.segment<2>(2 * v) += stay * places_[size_t(v)];
    solver_.factorize(matrix_);
    std::vector<Vec2d> out(places_.size(), Vec2d::Zero());
    if (solver_.info() != Eigen::Success) return places_;
    const Eigen::VectorXd x = solver_.solve(right);
    for (Eigen::Index v = 0; v < count; ++v) out[size_t(v)] = x.segment<2>(2 * v);
    return out;
  }

  // How far along `way` the first triangle has no area left.
  [[nodiscard]] double toFold(const std::vector<Vec2d>& way) const {
    double first = INFINITY;
    for (const auto& t : disk_.triangles) {
      const Vec2d b = places_[t[1]] - places_[t[0]], c = places_[t[2]] - places_[t[0]], vb = way[t[1]] - way[t[0]],
                  vc = way[t[2]] - way[t[0]];
      // Twice the area: constant + linear s + square s².
      const double constant = cross(b, c), linear = cross(b, vc) + cross(vb, c), square = cross(vb, vc);
      const double under = linear * linear - 4 * square * constant;
      if (under < 0) continue;
      const double q = -0.5 * (linear + std::copysign(std::sqrt(under), linear));
      for (const double root : {square != 0 ? q / square : -1, q != 0 ? constant / q : -1})
        if (root > 0) first = std::min(first, root);
    }
    return first;
  }

  const SurfaceDisk& disk_;
  std::vector<Flat> flats_;
  std::vector<Vec2d> places_;
  static constexpr size_t kLowerEntries = 21;  // of six rows and columns
  Sparse matrix_;
  std::vector<int> slots_, diagonal_;  // places of entries in its values
  Solver solver_;
};

// Of two sides that share no end.
bool meet(const Vec2d& a, const Vec2d& b, const Vec2d& c, const Vec2d& d) {
  if (a.cwiseMax(b).x() < c.cwiseMin(d).x() || c.cwiseMax(d).x() < a.cwiseMin(b).x() ||
      a.cwiseMax(b).y() < c.cwiseMin(d).y() || c.cwiseMax(d).y() < a.cwiseMin(b).y())
    return false;
  const double p = cross(b - a, c - a), q = cross(b - a, d - a), r = cross(d - c, a - c), s = cross(d - c, b - c);
  return !((p > 0 && q > 0) || (p < 0 && q < 0) || (r > 0 && s > 0) || (r < 0 && s < 0));
}

}  // namespace

std::optional<FlatDisk> laidFlat(const SurfaceDisk& disk, int rounds) {
  std::vector<Flat> flats;
  for (const auto& t : disk.triangles) {
    const std::optional<Flat> flat = flatOf(disk.positions[t[0]], disk.positions[t[1]], disk.positions[t[2]]);
    if (!flat) return std::nullopt;
    flats.push_back(*flat);
  }
  Flattening work(disk, std::move(flats));
  if (!work.inCircle()) return std::nullopt;
  work.relax(rounds);
  return std::move(work).result();
}

bool crossesItself(const std::vector<Vec2d>& places, const std::vector<uint32_t>& boundary) {
  const size_t rim = boundary.size();
  for (size_t i = 0; i < rim; ++i)
    for (size_t k = i + 2; k < rim; ++k) {
      if (i == 0 && k + 1 == rim) continue;
      if (meet(places[boundary[i]], places[boundary[i + 1]], places[boundary[k]], places[boundary[(k + 1) % rim]]))
        return true;
    }
  return false;
}

}  // namespace argil::clay
