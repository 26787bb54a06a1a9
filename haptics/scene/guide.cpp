#include "haptics/scene/guide.h"

#include <cmath>
#include <string>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kFarthestMm = 1e6;
constexpr double kStrongestN = 1e4;

/// Checks the shape of one guide.
struct Checker {
  std::string who;

  void require(bool good, const char* what) const {
    if (!good) throw Error(who + what);
  }
  void place(const Vec3d& p) const {
    require(p.allFinite() && p.cwiseAbs().maxCoeff() <= kFarthestMm, "a place must be finite and within 1e6 mm");
  }
  void direction(const Vec3d& d) const {
    require(d.allFinite() && d.norm() > 1e-6 && d.norm() < kFarthestMm,
            "a direction must be finite and longer than 1e-6");
  }
  void length(double mm) const { require(mm > 0 && mm <= kFarthestMm, "a length must be above 0 and at most 1e6 mm"); }
  void strength(double n) const { require(n >= 0 && n <= kStrongestN, "a force must be 0 to 10 000 N"); }
  void shape(const WellShape& well) const {
    length(well.rangeMm);
    strength(well.forceN);
  }

  void operator()(const LockToPoint& g) const { place(g.point); }
  void operator()(const LockToLine& g) const {
    place(g.point);
    direction(g.direction);
  }
  void operator()(const LockToPlane& g) const {
    place(g.point);
    direction(g.normal);
  }
  void operator()(const LockToCurve& g) const { require(g.curve != nullptr, "the curve is missing"); }
  void operator()(const LockToNormal&) const {}
  void operator()(const KeepOutBox& g) const {
    place(g.pose.translation);
    require(std::abs(g.pose.rotation.norm() - 1) < 1e-6, "the quaternion of a pose must be of unit length");
    for (int i = 0; i < 3; ++i) length(g.halfMm[i]);
  }
  void operator()(const KeepOutBall& g) const {
    place(g.centre);
    length(g.radiusMm);
  }
  void operator()(const KeepOutPlane& g) const {
    place(g.point);
    direction(g.normal);
  }
  void operator()(const KeepOutPiece&) const {}
  void operator()(const WellAtPoints& g) const {
    require(!g.points.empty() && g.points.size() <= kMaxWellPoints,
            "a well has 1 to 256 points; spread more over several guides");
    for (const Vec3d& p : g.points) place(p);
    shape(g.shape);
  }
  void operator()(const WellAtCurve& g) const {
    require(g.curve != nullptr, "the curve is missing");
    shape(g.shape);
  }
  void operator()(const WellAtPlane& g) const {
    place(g.point);
    direction(g.normal);
    shape(g.shape);
  }
  void operator()(const WellAtPiece& g) const { shape(g.shape); }
  void operator()(const Gravity& g) const {
    require(g.forceN.allFinite(), "a force must be finite");
    strength(g.forceN.norm());
  }
  void operator()(const Buoyancy& g) const {
    place(g.levelPoint);
    direction(g.up);
    strength(g.forceN);
    length(g.depthMm);
  }
  void operator()(const Viscosity& g) const {
    require(g.dragNsmm >= 0 && g.dragNsmm <= 1e3, "a drag must be 0 to 1000 N·s/mm");
  }
  void operator()(const AmbientPlane& g) const {
    place(g.point);
    direction(g.normal);
    require(g.stiffnessNmm >= 0 && g.stiffnessNmm <= 1e4, "a stiffness must be 0 to 10 000 N/mm");
    strength(g.mostN);
  }
  void operator()(const FollowModel& g) const {
    require(g.source != nullptr, "nobody says the model");
    strength(g.mostN);
  }
};

}  // namespace

void Guide::check() const {
  std::visit(Checker{"guide " + std::to_string(id) + ": "}, shape);
}

GuideRole Guide::roleOf(size_t kind) noexcept {
  using Shapes = decltype(shape);
  constexpr size_t kFirstKeepOut = 5, kFirstSoft = 9;
  static_assert(std::is_same_v<std::variant_alternative_t<kFirstKeepOut, Shapes>, KeepOutBox>);
  static_assert(std::is_same_v<std::variant_alternative_t<kFirstSoft, Shapes>, WellAtPoints>);
  if (kind < kFirstKeepOut) return GuideRole::lock;
  return kind < kFirstSoft ? GuideRole::keepOut : GuideRole::soft;
}

int64_t Guide::piece() const noexcept {
  if (const auto* keepOut = std::get_if<KeepOutPiece>(&shape)) return keepOut->piece;
  if (const auto* well = std::get_if<WellAtPiece>(&shape)) return well->piece;
  return -1;
}

}  // namespace argil::haptics
