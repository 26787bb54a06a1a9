#include "clay/mesh/triangulate.h"

#include <algorithm>
#include <cmath>

namespace argil::clay {

namespace {

/// An ear is flat below this cross product, relative to its squared edges: it is taken where there is no other.
constexpr double kFlat = 1e-6;
/// What rounding may make of zero, relative likewise.
constexpr double kRounding = 1e-12;
/// Polygons larger than this, or smaller than its inverse, are scaled before they are measured.
constexpr double kFar = 1e30;
/// Corners of a polygon that are searched one by one; more are sorted into cells.
constexpr size_t kFew = 24;
/// Corners looked at, for each corner of the polygon and in all, before the rest becomes a fan.
constexpr uint64_t kWorkACorner = 10'000, kMostWork = 2'000'000'000;
/// Once this part of the corners was clipped since all of them were looked at, flat ears wait for another look.
constexpr uint32_t kLookAgain = 16;

struct Areas {
  Vec3d sum = Vec3d::Zero();  // twice the area of the polygon, along its mean normal
  double parts = 0;           // the same of the fan's triangles, each without its direction
};

/// About the first corner, so that distance from zero costs no digits.
Areas areasOf(std::span<const Vec3d> corners) {
  Areas areas;
  for (size_t i = 2; i < corners.size(); ++i) {
    const Vec3d part = (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
    areas.sum += part;
    areas.parts += part.norm();
  }
  return areas;
}

/// Whether triangles from the first corner to each edge cover the polygon once: all of them face its way, and less than
/// a half turn lies between its first edge and its last.
bool fanCovers(std::span<const Vec3d> corners, const Vec3d& normal) {
  const auto faces = [&](const Vec3d& a, const Vec3d& b) {
    return a.cross(b).dot(normal) > kFlat * (a.squaredNorm() + b.squaredNorm());
  };
  for (size_t i = 2; i < corners.size(); ++i)
    if (!faces(corners[i - 1] - corners[0], corners[i] - corners[0])) return false;
  return faces(corners[1] - corners[0], corners.back() - corners[0]);
}

}  // namespace

bool Triangulator::add(std::span<const Vec3d> corners, std::vector<std::array<uint32_t, 3>>& triangles) {
  const auto count = uint32_t(corners.size());
  double reach = 0;
  for (const Vec3d& corner : corners) reach = std::max(reach, (corner - corners[0]).cwiseAbs().maxCoeff());
  if (reach > kFar || (reach > 0 && reach < 1 / kFar)) {
    // Products of four such numbers are beyond a double.
    scaled_.clear();
    for (const Vec3d& corner : corners) scaled_.emplace_back(corner / reach - corners[0] / reach);
    corners = scaled_;
  }
  if (count == 3) {
    triangles.push_back({0, 1, 2});
    return true;
  }
  const auto [sum, parts] = areasOf(corners);
  const Vec3d normal = sum / sum.norm();
  const bool faces = sum.norm() > kRounding * parts && std::isfinite(parts);
  if (!faces || fanCovers(corners, normal)) {
    for (uint32_t i = 2; i < count; ++i) triangles.push_back({0, i - 1, i});
    return faces || parts == 0;
  }
  project(corners, normal);
  next_.resize(count), before_.resize(count);
  for (uint32_t i = 0; i < count; ++i) next_[i] = i + 1 == count ? 0 : i + 1, before_[i] = i == 0 ? count - 1 : i - 1;
  stamp_.assign(count, 0);
  gone_.assign(count, false);
  left_ = count, anyLeft_ = 0;
  work_ = 0, mostWork_ = std::min(kMostWork, kWorkACorner * count);
  sortIntoCells();
  const bool whole = clip(triangles);
  for (uint32_t i = next_[anyLeft_]; next_[i] != anyLeft_; i = next_[i]) triangles.push_back({anyLeft_, i, next_[i]});
  return whole;
}

void Triangulator::project(std::span<const Vec3d> corners, const Vec3d& normal) {
  Vec3d::Index thin = 0;
  normal.cwiseAbs().minCoeff(&thin);
  const Vec3d u = normal.cross(Vec3d(Vec3d::Unit(thin))).normalized(), v = normal.cross(u);
  points_.clear();
  for (const Vec3d& corner : corners) {
    const Vec3d p = corner - corners[0];
    points_.push_back({p.dot(u), p.dot(v)});
  }
}

void Triangulator::sortIntoCells() {
  columns_ = rows_ = 0;
  if (points_.size() <= kFew) return;
  low_ = points_[0];
  Point high = low_;
  for (const Point& p : points_) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double width = high.x - low_.x, height = high.y - low_.y, count = double(points_.size());
  const auto side = [count](double along, double across) {
    return uint32_t(std::clamp(std::sqrt(count * along / across), 1.0, count));
  };
  columns_ = side(width, height);
  rows_ = uint32_t(std::clamp(count / columns_, 1.0, count));
  cellSize_ = {width / columns_, height / rows_};
  const auto cellOf = [&](const Point& p) {
    const auto x = uint32_t(std::min<double>((p.x - low_.x) / cellSize_.x, columns_ - 1));
    const auto y = uint32_t(std::min<double>((p.y - low_.y) / cellSize_.y, rows_ - 1));
    return size_t(y) * columns_ + x;
  };
  // Counts are kept two places up, so that filling the list moves each start to its final place.
  cell_.assign(size_t(columns_) * rows_ + 2, 0);
  for (const Point& p : points_) ++cell_[cellOf(p) + 2];
  for (size_t i = 1; i < cell_.size(); ++i) cell_[i] += cell_[i - 1];
  inCell_.resize(points_.size());
  for (uint32_t i = 0; i < points_.size(); ++i) inCell_[cell_[cellOf(points_[i]) + 1]++] = i;
}

/// Visits the corners that are left in the box of three of them, and some around it, until `visit` returns false.
template <class Visit>
void Triangulator::forEachNear(uint32_t a, uint32_t b, uint32_t c, const Visit& visit) {
  if (columns_ == 0) {
    uint32_t i = a;
    do {
      ++work_;
      if (!visit(i)) return;
      i = next_[i];
    } while (i != a);
    return;
  }
  const auto place = [](double at, double low, double size, uint32_t count) {
    return size > 0 ? uint32_t(std::clamp((at - low) / size, 0.0, double(count - 1))) : 0u;
  };
  const Point &p = points_[a], &q = points_[b], &r = points_[c];
  const uint32_t left = place(std::min({p.x, q.x, r.x}), low_.x, cellSize_.x, columns_),
                 right = place(std::max({p.x, q.x, r.x}), low_.x, cellSize_.x, columns_),
                 bottom = place(std::min({p.y, q.y, r.y}), low_.y, cellSize_.y, rows_),
                 top = place(std::max({p.y, q.y, r.y}), low_.y, cellSize_.y, rows_);
  for (uint32_t y = bottom; y <= top; ++y) {
    const size_t row = size_t(y) * columns_;
    work_ += 1 + (right - left) / 8;
    for (uint32_t i = cell_[row + left]; i < cell_[row + right + 1]; ++i) {
      ++work_;
      if (!gone_[inCell_[i]] && !visit(inCell_[i])) return;
    }
  }
}

/// Positive where the way from a over b to c turns left.
double Triangulator::turn(uint32_t a, uint32_t b, uint32_t c) const {
  const Point &p = points_[a], &q = points_[b], &r = points_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

double Triangulator::squared(uint32_t a, uint32_t b) const {
  const double x = points_[a].x - points_[b].x, y = points_[a].y - points_[b].y;
  return x * x + y * y;
}

bool Triangulator::same(uint32_t a, uint32_t b) const {
  return points_[a].x == points_[b].x && points_[a].y == points_[b].y;
}

/// Whether the inside at a corner, which lies between the directions to `first` and to `last`, left of the one for a
/// sign of 1 and right of it for -1, holds the direction to `to`, which lies less than a half turn from the first.
bool Triangulator::opensTo(uint32_t at, uint32_t first, uint32_t last, uint32_t to, double sign, bool& flat) const {
  if (sign * turn(at, first, last) <= 0) return true;  // A half turn at least, or a whole one.
  const double beyond = sign * turn(at, to, last), small = kFlat * (squared(at, to) + squared(at, last));
  if (beyond < small) flat = true;
  return beyond > -small;
}

/// Whether the triangle of a corner and its neighbours lies inside and nothing of the polygon lies in it.
Triangulator::Ear Triangulator::earAt(uint32_t v) {
  const uint32_t a = before_[v], b = next_[v];
  const double area = turn(a, v, b), edges = squared(a, v) + squared(v, b);
  const double rounding = kRounding * edges;
  if (same(a, v) || same(v, b) || same(a, b) || std::abs(area) <= rounding) return Ear::flat;
  if (area < 0) return Ear::none;
  bool flat = area <= kFlat * edges;
  if (!opensTo(a, v, before_[a], b, 1, flat) || !opensTo(b, v, next_[b], a, -1, flat)) return Ear::none;
  bool empty = true;
  const double diagonal = squared(a, b);
  forEachNear(a, v, b, [&](uint32_t p) {
    if (p == v || same(p, a) || same(p, b)) return true;
    if (same(p, v)) {
      // Another corner in the same place: its edges must not lead into the triangle.
      for (const uint32_t end : {before_[p], next_[p]})
        if (turn(v, b, end) > 0 && turn(v, end, a) > 0) empty = false;
      return empty;
    }
    const double beside = turn(b, a, p);
    const bool between = turn(a, v, p) > rounding && turn(v, b, p) > rounding;
    if (between && beside > rounding) return empty = false;
    // On the diagonal, or so near that a sliver would be left.
    if (std::abs(beside) <= kFlat * diagonal && squared(a, p) < diagonal && squared(b, p) < diagonal) flat = true;
    return true;
  });
  return !empty ? Ear::none : flat ? Ear::flat : Ear::good;
}

void Triangulator::queue(uint32_t corner) {
  const Ear ear = earAt(corner);
  if (ear == Ear::none) return;
  queue_.push_back({ear, squared(before_[corner], next_[corner]), corner, stamp_[corner]});
  std::push_heap(queue_.begin(), queue_.end());
}

void Triangulator::queueAll() {
  queue_.clear();
  uint32_t i = anyLeft_;
  do {
    ++stamp_[i];
    queue(i);
    i = next_[i];
  } while (i != anyLeft_ && work_ < mostWork_);
}

/// Cuts off ears, those with the shortest diagonal first, until three corners are left; false when no ear was left
/// before. What is left is a ring from anyLeft_.
bool Triangulator::clip(std::vector<std::array<uint32_t, 3>>& triangles) {
  queueAll();
  uint32_t clipped = 0;  // since all were looked at
  while (left_ > 3) {
    if (work_ >= mostWork_) return false;
    if (queue_.empty() || (queue_.front().ear == Ear::flat && clipped > left_ / kLookAgain)) {
      if (clipped == 0) return false;
      clipped = 0;
      queueAll();
      continue;
    }
    const Candidate best = queue_.front();
    std::pop_heap(queue_.begin(), queue_.end());
    queue_.pop_back();
    const uint32_t v = best.corner;
    if (gone_[v] || best.stamp != stamp_[v]) continue;
    const uint32_t a = before_[v], b = next_[v];
    triangles.push_back({a, v, b});
    next_[a] = b, before_[b] = a;
    gone_[v] = true;
    --left_, ++clipped;
    anyLeft_ = a;
    for (const uint32_t each : {a, b}) {
      ++stamp_[each];
      queue(each);
    }
  }
  return true;
}

}  // namespace argil::clay
