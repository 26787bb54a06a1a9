#include "ui3d/studio/widgets/handle.h"

#include <algorithm>
#include <cmath>

namespace argil::studio {
namespace {

// A thin line is met less easily than a dot on it, a face more easily than the line that crosses it.
constexpr double kPathBehindDot = 1.5, kAreaBehindPath = 6, kBodyBehindAll = 1000;
constexpr double kNearerWins = 1e-6;  // Units for each mm of depth: decides between equals alone.

double behind(const Handle& handle) {
  const double form = handle.form == Form::area                                   ? kAreaBehindPath
                      : (handle.form == Form::dot || handle.form == Form::square) ? 0
                                                                                  : kPathBehindDot;
  return form + (handle.body ? kBodyBehindAll : 0);
}

struct Distance {
  double value = 0;  // Units or mm.
  double depthMm = 0;
  Vec3d point = Vec3d::Zero();
};

Vec3d nearestOn(const Vec3d& a, const Vec3d& b, const Vec3d& p) {
  const Vec3d ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? Vec3d(a + std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) * ab) : a;
}

Vec3d nearestOn(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
  const Vec3d n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0) {
    const Vec3d foot = p - (p - a).dot(n) / n.squaredNorm() * n;
    const auto inside = [&](const Vec3d& u, const Vec3d& v) { return (v - u).cross(foot - u).dot(n) >= 0; };
    if (inside(a, b) && inside(b, c) && inside(c, a)) return foot;
  }
  Vec3d best = nearestOn(a, b, p);
  for (const Vec3d& other : {nearestOn(b, c, p), nearestOn(c, a, p)})
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  return best;
}

std::optional<Distance> fromTip(const Handle& handle, const Vec3d& tip) {
  std::optional<Distance> best;
  const auto consider = [&](const Vec3d& p) {
    const double d = (p - tip).norm();
    if (!best || d < best->value) best = Distance{d, 0, p};
  };
  const auto& p = handle.points;
  if (handle.form == Form::area) {
    for (size_t i = 0; i + 2 < p.size(); i += 3) consider(nearestOn(p[i], p[i + 1], p[i + 2], tip));
  } else if (p.size() == 1) {
    consider(p[0]);
  } else {
    for (size_t i = 1; i < p.size(); ++i) consider(nearestOn(p[i - 1], p[i], tip));
  }
  return best;
}

}  // namespace

void applyRigid(Subject& subject, const Handle& handle, const Change& change) {
  if (change.angle != 0) turn(subject, handle.anchor, handle.axis, change.angle);
  if (!change.move.isZero(0)) move(subject, change.move);
}

std::optional<Picked> pickHandle(const std::vector<Handle>& handles, const Grip& grip, const ScreenMap& screen,
                                 double tipReachMm, const std::function<bool()>& clayThere) {
  struct Candidate {
    double rank;
    Picked picked;
  };
  std::vector<Candidate> found;
  const Vec3d at = grip.stylus ? screen.project(grip.origin) : screen.place({grip.origin, grip.direction});
  for (size_t i = 0; i < handles.size(); ++i) {
    const Handle& handle = handles[i];
    std::optional<Distance> distance;
    if (grip.stylus) {
      distance = fromTip(handle, grip.origin);
      // Handles keep their size in the picture: in a wide view their reach is that of a mouse.
      if (distance && distance->value > std::max(tipReachMm, kPickUnits * screen.unitMm(distance->point)))
        distance.reset();
      if (distance) distance->value /= screen.unitMm(distance->point);
    } else {
      const auto near = handle.form == Form::area ? screen.inside(handle.points, at.x(), at.y())
                                                  : screen.nearest(handle.points, at.x(), at.y());
      if (near && near->units <= kPickUnits) distance = Distance{near->units, near->depthMm, near->point};
    }
    if (distance)
      found.push_back({distance->value + behind(handle) + kNearerWins * distance->depthMm, {i, distance->point}});
  }
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.rank < b.rank; });
  std::optional<bool> clay;
  for (const Candidate& candidate : found) {
    if (handles[candidate.picked.index].besideClay) {
      if (!clay) clay = clayThere && clayThere();
      if (*clay) continue;
    }
    return candidate.picked;
  }
  return {};
}

}  // namespace argil::studio
