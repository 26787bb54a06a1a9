#include "haptics/contact/keep_out.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

// A region that holds the tool in is at least so much larger than the ball, in radii: a socket of its own size leaves
// no free place.
constexpr double kPlay = 1.02;

}  // namespace

bool KeepOut::reset(const Guide& guide, const Scene& scene, TouchableClay* clay) ARGIL_REALTIME {
  radius_ = scene.tool.radiusMm;
  Region region;
  bool changed = clay != clay_;
  clay_ = clay;
  if (const auto* box = std::get_if<KeepOutBox>(&guide.shape)) {
    region = {Kind::box, box->inside, box->pose.translation, box->halfMm, box->pose.rotation};
    if (box->inside) region.size = region.size.cwiseMax(kPlay * radius_);
  } else if (const auto* ball = std::get_if<KeepOutBall>(&guide.shape)) {
    region = {Kind::ball, ball->inside, ball->centre, {ball->radiusMm, 0, 0}, Eigen::Quaterniond::Identity()};
    if (ball->inside) region.size.x() = std::max(region.size.x(), kPlay * radius_);
  } else if (const auto* plane = std::get_if<KeepOutPlane>(&guide.shape)) {
    region = {Kind::plane, false, plane->point, plane->normal.normalized(), Eigen::Quaterniond::Identity()};
  } else if (const auto* piece = std::get_if<KeepOutPiece>(&guide.shape);
             piece && clay && piece->piece < scene.pieces.size()) {
    region.kind = Kind::piece;
    changed = clay->reset(scene.pieces[piece->piece]) || changed;
  }
  changed = changed || !(region == region_);
  region_ = region;
  return changed;
}

Nearest KeepOut::toBox(const Vec3d& p) const noexcept {
  const Vec3d local = region_.rotation.conjugate() * (p - region_.place);
  Vec3d onto = local.cwiseMax(-region_.size).cwiseMin(region_.size);
  Nearest answer{true, Vec3d::Zero(), (local - onto).norm()};
  if (answer.distance == 0) {  // Within the box: the nearest wall.
    int axis = 0;
    (region_.size - local.cwiseAbs()).minCoeff(&axis);
    answer.distance = std::abs(local[axis]) - region_.size[axis];
    onto[axis] = std::copysign(region_.size[axis], local[axis]);
  }
  answer.point = region_.rotation * onto + region_.place;
  return answer;
}

Nearest KeepOut::toBall(const Vec3d& p, const Vec3d* hint) const noexcept {
  Vec3d out = p - region_.place;
  const double distance = out.norm();
  // In the middle every way is as near; the last one is taken again.
  if (!(distance > 1e-12))
    out = hint && (*hint - region_.place).norm() > 1e-12 ? Vec3d(*hint - region_.place) : Vec3d::UnitZ();
  return {true, region_.place + out.normalized() * region_.size.x(), distance - region_.size.x()};
}

Nearest KeepOut::nearest(const Vec3d& p, double reachMm, const Vec3d* hint) ARGIL_REALTIME {
  Nearest answer;
  switch (region_.kind) {
    case Kind::none:
      return {false, p, reachMm};
    case Kind::piece:
      return clay_->nearest(p, reachMm, hint);
    case Kind::box:
      answer = toBox(p);
      break;
    case Kind::ball:
      answer = toBall(p, hint);
      break;
    case Kind::plane:
      answer.found = true;
      answer.distance = region_.size.dot(p - region_.place);
      answer.point = p - answer.distance * region_.size;
      break;
  }
  if (region_.inside) answer.distance = -answer.distance;
  if (std::abs(answer.distance) <= reachMm) return answer;
  return {false, p, std::copysign(reachMm, answer.distance)};
}

Vec3d KeepOut::normal(const Vec3d& point) ARGIL_REALTIME {
  return region_.kind == Kind::piece ? clay_->normal(point) : Vec3d::Zero();
}

double KeepOut::resolutionMm() const ARGIL_REALTIME {
  return region_.kind == Kind::piece ? clay_->resolutionMm() : radius_ / 4;
}

}  // namespace argil::haptics
