#include "ui3d/studio/widgets/snap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/view/scale.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Document;
using engine::Guide;

constexpr double kParallel = 1e-6;
constexpr double kGridPart = 0.25;  // Of a grid's cell: between its lines there is room for what is not on them.
constexpr double kAligned = 1 - 1e-9;

struct Feature {
  enum class Kind : uint8_t { point, line, path, plane } kind;
  std::string name;
  std::vector<Vec3d> points;  // Of a point, of a path; a line's and a plane's place first.
  Vec3d axis = Vec3d::UnitZ();
  std::vector<Vec3d> highlight;
};

std::vector<Feature> featuresOf(const Document& document, const Target& self) {
  std::vector<Feature> features;
  const auto point = [&](const std::string& name, const Vec3d& p) {
    features.push_back({Feature::Kind::point, name, {p}, Vec3d::UnitZ(), {}});
  };
  for (const Guide& guide : document.guides) {
    if (!guide.visible || (self.kind == Target::Kind::thing && self.id == guide.id)) continue;
    const Vec3d place = guide.pose.translation;
    switch (guide.kind) {
      case Guide::Kind::plane: {
        const Eigen::Matrix3d axes = guide.pose.rotation.toRotationMatrix();
        const Sheet sheet{place, axes.col(0), axes.col(1), 0.5 * guide.sizeMm.x(), 0.5 * guide.sizeMm.y()};
        auto rim = sheet.corners();
        rim.push_back(Vec3d(rim.front()));
        features.push_back({Feature::Kind::plane, guide.name, {place}, sheet.normal(), rim});
        break;
      }
      case Guide::Kind::line: {
        const Vec3d half = 0.5 * guide.sizeMm.z() * guide.axis();
        features.push_back({Feature::Kind::line, guide.name, {place}, guide.axis(), {place - half, place + half}});
        break;
      }
      case Guide::Kind::point:
        point(guide.name, place);
        break;
      case Guide::Kind::curve: {
        const auto samples = sampleCurve(guide.pointsMm, guide.closed);
        features.push_back({Feature::Kind::path, guide.name, samples, Vec3d::UnitZ(), samples});
        for (const Vec3d& p : guide.pointsMm) point(guide.name, p);
        break;
      }
      case Guide::Kind::keepOutBox:
        break;
      case Guide::Kind::ruler:
      case Guide::Kind::angle:
        for (const Vec3d& p : guide.pointsMm) point(guide.name, p);
        break;
    }
  }
  if (self.kind != Target::Kind::symmetry) {
    for (const engine::MirrorPlane& plane : document.images().mirrors)
      features.push_back({Feature::Kind::plane, "symmetry", {plane.pointMm}, plane.normal.normalized(), {}});
  }
  return features;
}

/// Of the line p + s·u the parameter that is nearest to the line q + t·v.
std::optional<double> nearestOnLine(const Vec3d& p, const Vec3d& u, const Vec3d& q, const Vec3d& v) {
  const double b = u.dot(v), square = 1 - b * b;
  if (square < kParallel) return {};
  const Vec3d w = p - q;
  return (b * v.dot(w) - u.dot(w)) / square;
}

Vec3d nearestOnPath(const std::vector<Vec3d>& path, const Vec3d& p) {
  Vec3d best = path.front();
  for (size_t i = 1; i < path.size(); ++i) {
    const Vec3d ab = path[i] - path[i - 1];
    const double length2 = ab.squaredNorm();
    const Vec3d q =
        length2 > 0 ? Vec3d(path[i - 1] + std::clamp((p - path[i - 1]).dot(ab) / length2, 0.0, 1.0) * ab) : path[i];
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

/// Where within the bound a feature would have the point, if it has a say there.
std::optional<Vec3d> wanted(const Feature& feature, const SnapQuery& query, const ScreenMap& screen) {
  const Bound& bound = query.bound;
  const Vec3d& place = feature.points.front();
  switch (feature.kind) {
    case Feature::Kind::point:
      return query.aligns ? bound.nearest(place) : place;
    case Feature::Kind::line:
      if (bound.kind == Bound::Kind::none) {
        if (!query.sight) return place + (query.at - place).dot(feature.axis) * feature.axis;
        const auto s = nearestOnLine(place, feature.axis, query.sight->origin, query.sight->direction);
        return s ? std::optional<Vec3d>(place + *s * feature.axis) : std::nullopt;
      }
      if (bound.kind == Bound::Kind::line) {
        const auto s = nearestOnLine(place, feature.axis, bound.origin, bound.axis);
        return s ? std::optional<Vec3d>(place + *s * feature.axis) : std::nullopt;
      }
      if (const double fall = feature.axis.dot(bound.axis); std::abs(fall) > kParallel)
        return place + (bound.origin - place).dot(bound.axis) / fall * feature.axis;
      return place + (query.at - place).dot(feature.axis) * feature.axis;
    case Feature::Kind::path:
      if (query.sight) {
        const Vec3d at = screen.place(*query.sight);
        const auto near = screen.nearest(feature.points, at.x(), at.y());
        return near ? std::optional<Vec3d>(near->point) : std::nullopt;
      }
      return nearestOnPath(feature.points, query.at);
    case Feature::Kind::plane: {
      const double off = (place - query.at).dot(feature.axis);
      if (bound.kind == Bound::Kind::none) return query.at + off * feature.axis;
      if (bound.kind == Bound::Kind::line) {
        const double rise = bound.axis.dot(feature.axis);
        return std::abs(rise) > kParallel ? std::optional<Vec3d>(query.at + off / rise * bound.axis) : std::nullopt;
      }
      Vec3d along = feature.axis - feature.axis.dot(bound.axis) * bound.axis;  // Steepest way within the bound.
      if (along.squaredNorm() < kParallel) return {};
      return query.at + off / along.squaredNorm() * along;
    }
  }
  return {};
}

std::optional<Snap> nearestFeature(const World& world, const Document& shown, const SnapQuery& query, bool planes) {
  const ScreenMap& screen = world.screen;
  std::optional<Snap> best;
  int bestRank = 3;
  double bestUnits = kSnapUnits;
  for (const Feature& feature : featuresOf(shown, query.self)) {
    if ((feature.kind == Feature::Kind::plane) != planes) continue;
    const auto target = wanted(feature, query, screen);
    if (!target) continue;
    const Vec3d foot = query.bound.nearest(*target);
    const double unit = screen.unitMm(query.at);
    // A mouse that is free in depth sees what is near in the picture; all else is near in the world.
    const bool byPicture = query.sight && feature.kind != Feature::Kind::plane;
    const Vec3d a = screen.project(query.at), b = screen.project(foot);
    double units = byPicture ? std::hypot(a.x() - b.x(), a.y() - b.y()) : (query.at - foot).norm() / unit;
    if (!query.aligns) units = std::max(units, (foot - *target).norm() / unit);
    if (!screen.seen(foot)) continue;
    const int rank = feature.kind == Feature::Kind::point ? 0 : 1;
    if (units > kSnapUnits || rank > bestRank || (rank == bestRank && units >= bestUnits)) continue;
    bestRank = rank;
    bestUnits = units;
    best = Snap{foot, feature.name, feature.highlight};
    if (query.aligns && feature.kind == Feature::Kind::point) best->highlight = {foot, *target};
  }
  return best;
}

std::optional<Snap> surface(const World& world, const SnapQuery& query) {
  if (!query.toSurface || !world.pick) return {};
  if (query.sight) {
    const auto hit = world.pick(query.sight->origin, query.sight->direction);
    return hit ? std::optional<Snap>(Snap{hit->pointMm, "surface", {}}) : std::nullopt;
  }
  const Vec3d away = world.screen.axes().forward;
  const auto hit = world.pick(query.at - query.tipReachMm * away, away);
  if (!hit || (hit->pointMm - query.at).norm() > query.tipReachMm) return {};
  return Snap{hit->pointMm, "surface", {}};
}

std::optional<Snap> rightAngle(const World& world, const SnapQuery& query) {
  std::optional<Snap> best;
  double bestUnits = kSnapUnits;
  for (const Vec3d& from : query.beside) {
    for (int i = 0; i < 3; ++i) {
      const Vec3d foot = from + (query.at - from).dot(Vec3d::Unit(i)) * Vec3d::Unit(i);
      // Everything is near the point itself.
      if ((foot - from).norm() < 2 * kSnapUnits * world.screen.unitMm(from)) continue;
      const double units = (foot - query.at).norm() / world.screen.unitMm(query.at);
      if (units >= bestUnits) continue;
      bestUnits = units;
      best = Snap{foot, "right angle", {from, foot}};
    }
  }
  return best;
}

std::optional<Snap> gridLines(const World& world, const SnapQuery& query) {
  if (!world.state.look.grid || query.bound.kind == Bound::Kind::none) return {};
  const double step = render::gridSpacing(world.screen.view(), int(world.screen.height())).minor;
  const double within = std::min(kSnapUnits * world.screen.unitMm(query.at), kGridPart * step);
  Snap snap{query.at, "grid", {}};
  bool any = false;
  for (int i = 0; i < 3; ++i) {
    const double along = query.bound.axis[i];
    const bool free =
        query.bound.kind == Bound::Kind::line ? std::abs(along) >= kAligned : std::abs(along) <= kParallel;
    if (!free) continue;
    const double line = std::round(query.at[i] / step) * step;
    if (std::abs(line - query.at[i]) > within) continue;
    snap.at[i] = line;
    any = true;
  }
  // A slanted plane holds no two of the world's axes: then nothing of the grid lies in it.
  if (!any || (query.bound.nearest(snap.at) - snap.at).norm() > 1e-9 * (1 + snap.at.norm())) return {};
  return snap;
}

}  // namespace

Vec3d Bound::nearest(const Vec3d& p) const {
  switch (kind) {
    case Kind::none:
      break;
    case Kind::line:
      return origin + (p - origin).dot(axis) * axis;
    case Kind::plane:
      return p - (p - origin).dot(axis) * axis;
  }
  return p;
}

std::optional<Snap> snapPlace(const World& world, const Document& shown, const SnapQuery& query) {
  if (auto snap = nearestFeature(world, shown, query, false)) return snap;
  if (auto snap = surface(world, query)) return snap;
  if (auto snap = rightAngle(world, query)) return snap;
  if (auto snap = nearestFeature(world, shown, query, true)) return snap;
  return gridLines(world, query);
}

std::optional<double> snapTurn(const Document& shown, const Target& self, const std::vector<Vec3d>& directions,
                               const Vec3d& axis, double angle) {
  std::vector<Vec3d> others{Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()};
  for (const Guide& guide : shown.guides) {
    if (!guide.visible || (self.kind == Target::Kind::thing && self.id == guide.id)) continue;
    if (guide.kind == Guide::Kind::plane || guide.kind == Guide::Kind::line) others.push_back(guide.axis());
  }
  const auto flat = [&](const Vec3d& v) { return Vec3d(v - v.dot(axis) * axis); };
  std::optional<double> best;
  for (const Vec3d& direction : directions) {
    const Vec3d from = flat(direction);
    if (from.norm() < 0.1) continue;
    for (const Vec3d& other : others) {
      const Vec3d to = flat(other);
      if (to.norm() < 0.1) continue;
      const double between = std::atan2(from.cross(to).dot(axis), from.dot(to)), quarter = 0.5 * std::numbers::pi;
      const double candidate = between + std::round((angle - between) / quarter) * quarter;
      if (std::abs(candidate - angle) <= kSnapAngle && (!best || std::abs(candidate - angle) < std::abs(*best - angle)))
        best = candidate;
    }
  }
  return best;
}

Vec3d toGrid(const World& world, const Bound& bound, const Vec3d& start, const Vec3d& at) {
  const double step = render::gridSpacing(world.screen.view(), int(world.screen.height())).minor;
  const auto whole = [&](double mm) { return std::round(mm / step) * step; };
  Vec3d result = at;
  switch (bound.kind) {
    case Bound::Kind::none:
      return {whole(at.x()), whole(at.y()), whole(at.z())};
    case Bound::Kind::line: {
      for (int i = 0; i < 3; ++i)
        if (std::abs(bound.axis[i]) >= kAligned) {
          result[i] = whole(at[i]);
          return result;
        }
      return start + whole((at - start).dot(bound.axis)) * bound.axis;  // Slanted: whole steps of the way.
    }
    case Bound::Kind::plane: {
      for (int i = 0; i < 3; ++i)
        if (std::abs(bound.axis[i]) >= kAligned) {
          for (const int j : {(i + 1) % 3, (i + 2) % 3}) result[j] = whole(at[j]);
          return result;
        }
      const Vec3d u = bound.axis.unitOrthogonal(), v = bound.axis.cross(u);
      return start + whole((at - start).dot(u)) * u + whole((at - start).dot(v)) * v;
    }
  }
  return result;
}

}  // namespace argil::studio
