#include "ui3d/studio/widgets/placing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

using engine::Guide;

constexpr double kSameUnits = 7;       // Two clicks at one place.
constexpr double kDragUnits = 12;      // A press and a release so far apart are two clicks.
constexpr double kSizePart = 0.6;      // Of the model's extent: a new plane.
constexpr double kBoxPart = 0.2;       // A box that was clicked, not dragged.
constexpr double kGroundSlope = 0.15;  // Sine, between the view and the ground: below, points lie before the eye.
constexpr double kThinnest = 1e-3;     // Of the model's extent: where a ray for the thickness begins under the surface.

constexpr std::array<const char*, 8> kKinds{"plane", "line", "point", "curve", "box", "ruler", "angle", "thickness"};

double apart(const ScreenMap& screen, const Vec3d& a, const Vec3d& b) {
  const Vec3d p = screen.project(a), q = screen.project(b);
  return std::hypot(p.x() - q.x(), p.y() - q.y());
}

Vec3d nearestAxis(const Vec3d& v) {
  int best = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(v[i]) > std::abs(v[best])) best = i;
  return std::copysign(1.0, v[best]) * Vec3d::Unit(best);
}

/// z along the direction, x as level as it can be.
Eigen::Quaterniond frameAlong(const Vec3d& direction) {
  const Vec3d z = direction.normalized();
  const Vec3d x = (std::abs(z.z()) < 0.9 ? Vec3d::UnitZ().cross(z) : Vec3d(Vec3d::UnitX() - z.x() * z)).normalized();
  Eigen::Matrix3d m;
  m << x, z.cross(x), z;
  return Eigen::Quaterniond(m).normalized();
}

double extentOf(const World& world) {
  return world.bounds.empty() ? 0.5 * world.screen.view().heightAtTarget() : std::max(1e-3, world.bounds.size().norm());
}

}  // namespace

bool Placing::knows(const std::string& kind) {
  return std::find(kKinds.begin(), kKinds.end(), kind) != kKinds.end();
}

size_t Placing::needed() const {
  if (kind_ == "line" || kind_ == "ruler" || kind_ == "box") return 2;
  if (kind_ == "angle") return 3;
  if (kind_ == "curve") return size_t(-1);
  return 1;
}

std::string Placing::hint() const {
  if (kind_ == "curve")
    return points_.empty() ? "Click on the clay where the curve begins" : "Click for each point; Enter ends the curve";
  if (kind_ == "box") return "Press where the box begins, drag, release";
  if (kind_ == "plane") return "Click on the clay: the plane touches it there";
  if (kind_ == "thickness") return "Click on the clay: the ruler goes through it";
  if (kind_ == "point") return "Click where the point is to be";
  if (kind_ == "angle") {
    static constexpr std::array<const char*, 3> steps{"Click at the end of one arm", "Click at the corner",
                                                      "Click at the end of the other arm"};
    return steps[std::min<size_t>(points_.size(), 2)];
  }
  if (kind_ == "ruler") return points_.empty() ? "Click where the ruler begins" : "Click where the ruler ends";
  return points_.empty() ? "Click where the line begins" : "Click where the line ends";
}

void Placing::look(const World& world, const Grip& grip) {
  const ScreenMap& screen = world.screen;
  snap_.reset();
  spotNormal_ = Vec3d::Zero();
  constrain_ = grip.constrain;
  SnapQuery query;
  if (!points_.empty()) query.beside = {points_.back()};
  Vec3d at = grip.origin;
  if (!grip.stylus) {
    const Ray sight{grip.origin, grip.direction};
    if (kind_ == "box" && points_.size() == 1) {
      // In the level of its first corner, or before the eye.
      const Vec3d n = std::abs(screen.axes().forward.z()) > kGroundSlope ? Vec3d(Vec3d::UnitZ())
                                                                         : nearestAxis(screen.axes().forward);
      const double fall = sight.direction.dot(n);
      const double t = std::abs(fall) > 1e-3 ? (points_[0] - sight.origin).dot(n) / fall : -1;
      if (t > 0) spot_ = sight.origin + t * sight.direction;
      return;
    }
    const auto hit = world.pick ? world.pick(sight.origin, sight.direction) : std::nullopt;
    if (hit) {
      at = hit->pointMm;
      spotNormal_ = hit->normal.normalized();
    } else {
      Vec3d n = screen.axes().forward, through = points_.empty() ? screen.view().target : points_.back();
      if (points_.empty() && std::abs(n.z()) > kGroundSlope) {
        n = Vec3d::UnitZ();
        through = Vec3d(0, 0, world.bounds.empty() ? 0 : world.bounds.min.z());
      }
      const double fall = sight.direction.dot(n);
      const double t = std::abs(fall) > 1e-3 ? (through - sight.origin).dot(n) / fall : -1;
      if (!(t > 0)) return;
      at = sight.origin + t * sight.direction;
    }
    query.sight = sight;
  } else {
    query.tipReachMm = 1.5 * world.toolRadiusMm;
    const Vec3d away = screen.axes().forward;
    if (const auto hit = world.pick ? world.pick(at - query.tipReachMm * away, away) : std::nullopt;
        hit && (hit->pointMm - at).norm() <= query.tipReachMm) {
      at = hit->pointMm;
      spotNormal_ = hit->normal.normalized();
    }
  }
  // Clay under the hand is the surface already: only other guides go before it.
  query.at = at;
  if (spotNormal_.norm() > 0) query.beside.clear();
  if (world.state.snapWidgets && !grip.snapOff && kind_ != "thickness") {
    snap_ = snapPlace(world, world.document, query);
    if (snap_) at = snap_->at;
  }
  spot_ = at;
}

bool Placing::addPoint(const World& world) {
  if (!spot_) return false;
  if (kind_ == "curve" && !points_.empty()) {
    if (apart(world.screen, *spot_, points_.back()) < kSameUnits) return points_.size() >= 2;
    if (points_.size() >= 3 && apart(world.screen, *spot_, points_.front()) < kPickUnits) {
      closed_ = true;
      return true;
    }
  }
  const bool again = !points_.empty() && apart(world.screen, *spot_, points_.back()) < kSameUnits;
  if (again && kind_ != "line") return false;  // A ruler of no length measures nothing.
  if (points_.empty()) normal_ = spotNormal_;
  points_.push_back(*spot_);
  return points_.size() >= needed();
}

bool Placing::follow(const World& world, const Grip& grip) {
  look(world, grip);
  const bool pressed = grip.down && !wasDown_, released = !grip.down && wasDown_;
  wasDown_ = grip.down;
  if (pressed) {
    pressedAt_ = spot_;
    return addPoint(world);
  }
  if (!released) return false;
  const bool dragged = pressedAt_ && spot_ && apart(world.screen, *pressedAt_, *spot_) > kDragUnits;
  if (kind_ == "box") {
    if (points_.empty()) return false;
    if (!dragged) {
      const Vec3d half = 0.5 * kBoxPart * extentOf(world) * Vec3d::Ones();
      points_ = {Vec3d(points_[0] - half), Vec3d(points_[0] + half)};
      return true;
    }
    points_.push_back(*spot_);
    return true;
  }
  return dragged && (kind_ == "line" || kind_ == "ruler") && points_.size() == 1 && addPoint(world);
}

bool Placing::click(const World& world, const Grip& grip) {
  look(world, grip);
  if (kind_ != "box") return addPoint(world);
  if (!spot_) return false;
  const Vec3d half = 0.5 * kBoxPart * extentOf(world) * Vec3d::Ones();
  points_ = {Vec3d(*spot_ - half), Vec3d(*spot_ + half)};
  return true;
}

bool Placing::finish(const World& world) {
  spot_.reset();
  return kind_ == "curve" && points_.size() >= 2 && make(world, points_).has_value();
}

bool Placing::stepBack() {
  if (points_.empty()) return false;
  points_.pop_back();
  return true;
}

std::optional<Guide> Placing::preview(const World& world) const {
  std::vector<Vec3d> points = points_;
  if (spot_ && points.size() < needed()) points.push_back(*spot_);
  return make(world, points);
}

std::optional<Guide> Placing::result(const World& world) const {
  return make(world, points_);
}

std::optional<Guide> Placing::make(const World& world, const std::vector<Vec3d>& points) const {
  if (points.empty()) return {};
  const Vec3d clay = points_.empty() ? spotNormal_ : normal_;
  const double extent = extentOf(world);
  Guide guide;
  if (kind_ == "plane") {
    guide.kind = Guide::Kind::plane;
    guide.feel = Guide::Feel::well;
    Vec3d normal = clay.norm() > 0 ? clay : nearestAxis(world.screen.toEye(points[0]));
    if (constrain_) normal = nearestAxis(normal);
    guide.pose = {points[0], frameAlong(normal)};
    guide.sizeMm = kSizePart * extent * Vec3d::Ones();
  } else if (kind_ == "point") {
    guide.kind = Guide::Kind::point;
    guide.feel = Guide::Feel::well;
    guide.pose.translation = points[0];
  } else if (kind_ == "line") {
    if (points.size() < 2) return {};
    guide.kind = Guide::Kind::line;
    guide.feel = Guide::Feel::well;
    Vec3d a = points[0], b = points[1];
    if (apart(world.screen, a, b) < kSameUnits) {
      const Vec3d along = clay.norm() > 0 ? clay : Vec3d(Vec3d::UnitZ());
      b = a + 0.25 * extent * along;
      a -= 0.25 * extent * along;
    }
    if (constrain_) b = a + (b - a).norm() * nearestAxis(b - a);
    if (!((b - a).norm() >= kLeastSizeMm)) return {};
    guide.pose = {0.5 * (a + b), frameAlong(b - a)};
    guide.sizeMm.z() = (b - a).norm();
  } else if (kind_ == "curve") {
    if (points.size() < 2) return {};
    guide.kind = Guide::Kind::curve;
    guide.feel = Guide::Feel::well;
    guide.pointsMm = points;
    guide.closed = closed_ && points.size() >= 3;
  } else if (kind_ == "ruler") {
    if (points.size() < 2) return {};
    guide.kind = Guide::Kind::ruler;
    guide.pointsMm = points;
  } else if (kind_ == "thickness") {
    // From where it was clicked through to the other side of the clay.
    if (!(clay.norm() > 0) || !world.pick) return {};
    const auto out = world.pick(points[0] - kThinnest * extent * clay, -clay);
    if (!out) return {};
    guide.kind = Guide::Kind::ruler;
    guide.name = "Thickness";
    guide.pointsMm = {points[0], out->pointMm};
  } else if (kind_ == "angle") {
    if (points.size() < 2) return {};
    guide.kind = Guide::Kind::angle;
    guide.pointsMm = points;
    if (guide.pointsMm.size() == 2) guide.pointsMm.push_back(points[0]);
  } else if (kind_ == "box") {
    if (points.size() < 2) return {};
    guide.kind = Guide::Kind::keepOutBox;
    guide.feel = Guide::Feel::keepOut;
    Vec3d size = (points[1] - points[0]).cwiseAbs();
    // A flat one gets a height: half of its shorter edge.
    int flat = 0;
    for (int i = 1; i < 3; ++i)
      if (size[i] < size[flat]) flat = i;
    const double shorter = std::min(size[(flat + 1) % 3], size[(flat + 2) % 3]);
    if (size[flat] < 0.02 * shorter) size[flat] = 0.5 * shorter;
    guide.sizeMm = size.cwiseMax(std::max(kLeastSizeMm, 1e-3 * extent));
    guide.pose.translation = 0.5 * (points[0] + points[1]);
  }
  return guide;
}

}  // namespace argil::studio
