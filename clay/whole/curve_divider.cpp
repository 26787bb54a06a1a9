// Sides and distances of a drawn curve, in the plane across its direction.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/whole/cut.h"

namespace argil::clay {

namespace {

using Vec2d = Eigen::Vector2d;

constexpr size_t kMostPoints = 4096;
constexpr double kFar = 1e4;           // The way around, in sizes of the curve: clay lies within.
constexpr double kCornerCosine = 0.5;  // Turns of more than 60° are meant.

double length(const Vec2d& v) {
  return std::sqrt(v.squaredNorm());
}

// Points nearer to the last one than `spacing` go, but for the end of an open curve.
std::vector<Vec2d> thinned(const std::vector<Vec2d>& points, double spacing, bool closed) {
  std::vector<Vec2d> kept{points.front()};
  for (const Vec2d& p : points)
    if (length(p - kept.back()) > spacing) kept.push_back(p);
  if (closed) {
    while (kept.size() > 1 && length(kept.back() - kept.front()) <= spacing) kept.pop_back();
  } else if (kept.back() != points.back()) {
    if (kept.size() > 1)
      kept.back() = points.back();
    else
      kept.push_back(points.back());
  }
  return kept;
}

// Hermite spans through all points; tangents look at both neighbours, weighted by nearness, and at one alone beside
// corners and ends.
std::vector<Vec2d> smoothed(const std::vector<Vec2d>& points, double chord, bool closed) {
  const size_t n = points.size();
  if (n < 3) return points;
  const auto side = [&](size_t i, int by) {
    return points[(i + n + static_cast<size_t>(by + static_cast<int>(n))) % n];
  };
  std::vector<Vec2d> result;
  const size_t spans = closed ? n : n - 1;
  // Unit direction of the curve at point i; `ahead` says which of a corner's two.
  const auto tangent = [&](size_t i, bool ahead) -> Vec2d {
    const bool first = !closed && i == 0, last = !closed && i == n - 1;
    const Vec2d in = first ? Vec2d::Zero() : Vec2d(points[i] - side(i, -1)),
                out = last ? Vec2d::Zero() : Vec2d(side(i, 1) - points[i]);
    if (first) return out / length(out);
    if (last) return in / length(in);
    const double a = length(in), b = length(out);
    if (in.dot(out) < kCornerCosine * a * b) return ahead ? Vec2d(out / b) : Vec2d(in / a);
    const Vec2d t = in / a * b + out / b * a;
    return t / length(t);
  };
  for (size_t i = 0; i < spans; ++i) {
    const Vec2d a = points[i], b = points[(i + 1) % n];
    const double size = length(b - a);
    const Vec2d ta = tangent(i, true) * size, tb = tangent((i + 1) % n, false) * size;
    const int steps = std::clamp(static_cast<int>(std::ceil(size / chord)), 1, 32);
    for (int s = 0; s < steps; ++s) {
      const double t = double(s) / steps, t2 = t * t, t3 = t2 * t;
      result.push_back((2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * ta + (3 * t2 - 2 * t3) * b + (t3 - t2) * tb);
    }
  }
  if (!closed) result.push_back(points.back());
  return result;
}

}  // namespace

CurveDivider::CurveDivider(const Curve& curve) {
  const double size = std::sqrt(curve.direction.squaredNorm());
  if (!curve.direction.allFinite() || !(size > 1e-12))
    throw Error("cut by a curve along a direction that is zero or not finite: give a direction");
  if (curve.pointsMm.size() > kMostPoints)
    throw Error(fmt::format("cut by a curve of {} points: give at most {}", curve.pointsMm.size(), kMostPoints));
  const Vec3d ahead = curve.direction / size;
  // Whatever makes a right-handed view: its own roll does not matter.
  Vec3d across = Vec3d::Zero();
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(ahead[i]) < std::abs(ahead[least])) least = i;
  across[least] = 1;
  up_ = across - across.dot(ahead) * ahead;
  up_ /= std::sqrt(up_.squaredNorm());
  right_ = ahead.cross(up_);

  std::vector<Vec2d> points;
  Vec2d low = Vec2d::Constant(INFINITY), high = -low;
  for (const Vec3d& p : curve.pointsMm) {
    if (!p.allFinite()) throw Error("cut by a curve with a point that is not finite: give finite numbers");
    points.push_back(flat(p));
    low = low.cwiseMin(points.back());
    high = high.cwiseMax(points.back());
  }
  const double extent = points.empty() ? 0 : length(high - low);
  if (points.size() >= 2 && extent > 0) points = thinned(points, std::max(curve.smoothMm, 1e-9 * extent), curve.closed);
  if (points.size() < (curve.closed ? 3u : 2u) || !(extent > 1e-9))
    throw Error(fmt::format("cut by a curve of {} different points: {} needs {} at least", points.size(),
                            curve.closed ? "a closed one" : "an open one", curve.closed ? 3 : 2));
  if (curve.smoothMm > 0) points = smoothed(points, curve.smoothMm, curve.closed);

  if (curve.closed) {
    for (size_t i = 0; i < points.size(); ++i) edges_.push_back({points[i], points[(i + 1) % points.size()]});
    outline_ = edges_;
  } else {
    for (size_t i = 0; i + 1 < points.size(); ++i) edges_.push_back({points[i], points[i + 1]});
    outline_ = edges_;
    const auto beyond = [&](const Vec2d& end, const Vec2d& before) {
      return Vec2d(end + (end - before) * (kFar * extent / length(end - before)));
    };
    const Vec2d last = points.back(), start = points.front();
    const Vec2d lastFar = beyond(last, points[points.size() - 2]), startFar = beyond(start, points[1]);
    edges_.push_back({last, lastFar, true});
    edges_.push_back({start, startFar, true});
    // Back from the far end to the far beginning, on the left, over the corners of a square that both lie within.
    const Vec2d middle = (low + high) / 2;
    const double around = 4 * kFar * extent;
    const auto rim = [&](const Vec2d& p) {
      return Vec2d(middle + (p - middle) * (around / (p - middle).cwiseAbs().maxCoeff()));
    };
    // How far around the square a place on it is: 0 to 8, from the middle of the right side on, counter-clockwise.
    const auto turned = [&](const Vec2d& p) {
      const Vec2d d = (p - middle) / around;
      if (d.x() >= 1 - 1e-12) return d.y() < 0 ? 8 + d.y() : d.y();
      if (d.y() >= 1 - 1e-12) return 2 - d.x();
      return d.x() <= -1 + 1e-12 ? 4 - d.y() : 6 + d.x();
    };
    std::vector<Vec2d> way{last, lastFar, rim(lastFar)};
    const double from = turned(rim(lastFar));
    double to = turned(rim(startFar));
    if (to < from) to += 8;
    for (int corner = 1; corner < 16; corner += 2) {
      if (corner <= from || corner >= to) continue;
      const int k = corner % 8;
      way.push_back(middle + around * Vec2d(k == 1 || k == 7 ? 1 : -1, k <= 3 ? 1 : -1));
    }
    way.insert(way.end(), {rim(startFar), startFar, start});
    for (size_t i = 0; i + 1 < way.size(); ++i) outline_.push_back({way[i], way[i + 1]});
  }
  for (const Edge& edge : outline_) levels_.push_back(edge.from.y());
  std::sort(levels_.begin(), levels_.end());
  levels_.erase(std::unique(levels_.begin(), levels_.end()), levels_.end());
  crossing_.resize(levels_.size());
  const auto at = [&](double y) {
    return static_cast<size_t>(std::lower_bound(levels_.begin(), levels_.end(), y) - levels_.begin());
  };
  for (size_t i = 0; i < outline_.size(); ++i) {
    const double a = outline_[i].from.y(), b = outline_[i].to.y();
    for (size_t level = at(std::min(a, b)); level < at(std::max(a, b)); ++level)
      crossing_[level].push_back(static_cast<uint32_t>(i));
  }
}

// Whether an odd number of edges lies to the right.
bool CurveDivider::first(const Vec2d& p) const {
  const auto level = std::upper_bound(levels_.begin(), levels_.end(), p.y());
  if (level == levels_.begin() || level == levels_.end()) return false;
  bool odd = false;
  for (const uint32_t i : crossing_[static_cast<size_t>(level - levels_.begin()) - 1]) {
    const Edge& e = outline_[i];
    const double t = (p.y() - e.from.y()) / (e.to.y() - e.from.y());
    odd ^= e.from.x() + t * (e.to.x() - e.from.x()) > p.x();
  }
  return odd;
}

double CurveDivider::squared(const Edge& edge, const Vec2d& p) {
  const Vec2d d = edge.to - edge.from, q = p - edge.from;
  const double t = std::max(q.dot(d) / d.squaredNorm(), 0.0);
  return (q - (edge.endless ? t : std::min(t, 1.0)) * d).squaredNorm();
}

double CurveDivider::distance(const Vec3d& mm) const {
  const Vec2d p = flat(mm);
  double least = INFINITY;
  for (const Edge& edge : edges_) least = std::min(least, squared(edge, p));
  return first(p) ? -std::sqrt(least) : std::sqrt(least);
}

void CurveDivider::distances(const Vec3d& firstMm, double step, std::span<double, kBrickVoxels> out) const {
  constexpr double kHalf = 0.5 * (kBrickEdge - 1);
  const double reach = 1.001 * std::sqrt(3.0) * kHalf * step;
  const Vec2d middle = flat(firstMm + Vec3d::Constant(kHalf * step));
  thread_local std::vector<double> away;
  thread_local std::vector<Edge> near;
  away.clear();
  near.clear();
  double least = INFINITY;
  for (const Edge& edge : edges_) {
    away.push_back(squared(edge, middle));
    least = std::min(least, away.back());
  }
  // What is nearest to some place of the brick is not farther from its middle than this.
  const double most = std::sqrt(least) + 2 * reach;
  for (size_t i = 0; i < edges_.size(); ++i)
    if (away[i] <= most * most) near.push_back(edges_[i]);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const Vec2d p = flat(firstMm + step * Coord{i >> 6, (i >> 3) & 7, i & 7}.toVec3d());
    double closest = INFINITY;
    for (const Edge& edge : near) closest = std::min(closest, squared(edge, p));
    out[static_cast<size_t>(i)] = first(p) ? -std::sqrt(closest) : std::sqrt(closest);
  }
}

}  // namespace argil::clay
