#include "haptics/contact/texture_path.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

constexpr double kOfRate = 0.4;           // Highest frequency rendered, of the servo's rate: half of it would alias.
constexpr double kTravelSmoothing = 0.1;  // Encoder steps must not let the fading flicker.
// Of what a texture may owe, a tick: a hand that shook is not left without texture.
constexpr double kForgiven = 0.002;
constexpr double kRounding = 1e-12;  // mm²

// One plane, the common case, at a tenth of the cost.
ActiveSet nearest(const Vec3d& hand, const HalfSpace* planes, int count) ARGIL_REALTIME {
  if (count != 1) return nearestAllowed(hand, planes, count);
  ActiveSet one;
  one.x = hand;
  const double push = planes[0].offset - planes[0].normal.dot(hand);
  if (!(push > 0)) return one;
  one.x += push * planes[0].normal;
  one.multiplier[0] = push;
  one.count = 1;
  return one;
}

}  // namespace

// Each textured plane with the place where its texture was touched last: the nearest one of the same texture. What is
// touched is the place below the ball along the smooth normal: the nearest point itself jumps from facet to facet.
int TexturePath::match(const Vec3d& proxy, const TexturedPlane* planes, int count, Walk* walks) const ARGIL_REALTIME {
  bool taken[kMaxHalfSpaces] = {};
  int walking = 0;
  for (int i = 0; i < count; ++i) {
    if (!planes[i].texture) continue;
    Walk& walk = walks[walking++];
    walk.plane = i;
    walk.to = walk.from = planes[i].pose->applyInverse(proxy - (proxy - planes[i].at).norm() * planes[i].plane.normal);
    walk.normal = planes[i].pose->rotation.conjugate() * planes[i].plane.normal;
    int nearest = -1;
    for (int s = 0; s < slotCount_; ++s) {
      if (taken[s] || slots_[size_t(s)].texture != planes[i].texture) continue;
      if (nearest < 0 ||
          (slots_[size_t(s)].at - walk.to).squaredNorm() < (slots_[size_t(nearest)].at - walk.to).squaredNorm())
        nearest = s;
    }
    if (nearest < 0) continue;
    taken[nearest] = true;
    walk.from = slots_[size_t(nearest)].at;
  }
  return walking;
}

TexturePath::Place TexturePath::advance(const Vec3d& proxy, const Vec3d& hand, const TexturedPlane* planes,
                                        int count) ARGIL_REALTIME {
  Place place;
  place.proxy = proxy;
  place.stretch = proxy - hand;
  place.planes = count;
  count = std::min(count, kMaxHalfSpaces);
  if (!begun_) {
    slotCount_ = 0;
    travel_ = energy_ = stored_ = 0;
    smooth_.setZero();
    stretch_.setZero();
    hand_ = hand;
  }
  Walk walks[kMaxHalfSpaces];
  const int walking = match(proxy, planes, count, walks);
  begun_ = walking > 0;
  if (!begun_) return place;

  // Every wave that is left is met in two ticks or more and what is shorter as its mean: nothing on the path is
  // skipped.
  double travel = 0;
  for (int i = 0; i < walking; ++i) travel = std::max(travel, (walks[i].to - walks[i].from).norm());
  travel_ += kTravelSmoothing * (travel - travel_);
  const double finest = std::max(travel, travel_) / kOfRate;

  // What the hand paid since the last tick, and what the smooth contact gives away by itself because forces are held
  // between ticks.
  const Vec3d moved = hand - hand_, smooth = proxy - hand;
  const double paid = -stretch_.dot(moved);
  const double given = 0.5 * (smooth.squaredNorm() - smooth_.squaredNorm()) + smooth_.dot(moved);
  const double budget = energy_ + paid + given + stored_;
  // What a texture may owe or keep: as much as it takes to climb it once. With nothing lent a first bump could not be
  // climbed in time.
  double range = 0;
  for (int i = 0; i < walking; ++i) range = std::max(range, planes[walks[i].plane].texture->rangeMm());
  const double credit = range * smooth.norm();

  // The nearest place to the hand under the displaced planes.
  HalfSpace work[kMaxHalfSpaces];
  Vec3d slopes[kMaxHalfSpaces];
  for (int i = 0; i < count; ++i) {
    work[i] = planes[i].plane;
    slopes[i].setZero();
  }
  const ActiveSet below = nearest(hand, work, count);
  for (int i = 0; i < walking; ++i) {
    const Walk& w = walks[i];
    const TexturedPlane& plane = planes[w.plane];
    Vec3d slope;
    work[w.plane].offset += plane.texture->height(w.to, w.normal, finest, &slope);
    slopes[w.plane] = plane.pose->rotation * slope;
    slots_[size_t(i)] = {plane.texture, w.to};
  }
  slotCount_ = walking;
  const ActiveSet above = nearest(hand, work, count);
  Vec3d spring = smooth, tilt = Vec3d::Zero();
  if (below.feasible && above.feasible) {
    spring += above.x - below.x;
    place.planes = above.count;
    for (int i = 0; i < above.count; ++i) tilt -= above.multiplier[size_t(i)] * slopes[above.active[size_t(i)]];
  }

  // No higher than was paid for, and never below the bottom: that is a smooth contact again, which gives by itself what
  // is given.
  double energy = 0.5 * spring.squaredNorm();
  if (energy > budget + credit + kRounding) {
    for (int i = 0; i < count; ++i)
      work[i].offset = planes[i].plane.offset - (planes[i].texture ? planes[i].texture->rangeMm() : 0.0);
    const Vec3d least = smooth + (nearest(hand, work, count).x - below.x), rise = spring - least;
    const double a = 0.5 * rise.squaredNorm(), b = least.dot(rise), c = 0.5 * least.squaredNorm() - budget - credit;
    const double share =
        c < 0 && a > 0 ? std::clamp((std::sqrt(std::max(0.0, b * b - 4 * a * c)) - b) / (2 * a), 0.0, 1.0) : 0.0;
    spring = least + share * rise;
    energy = 0.5 * spring.squaredNorm();
  }
  stored_ = std::min(budget - energy, credit);
  if (stored_ < 0) stored_ = std::min(0.0, stored_ + kForgiven * credit);
  if (stored_ < 0) tilt *= std::clamp(2 * (1 + stored_ / credit), 0.0, 1.0);
  place.proxy = hand + spring;
  place.stretch = spring + tilt;
  energy_ = energy;
  hand_ = hand;
  smooth_ = smooth;
  stretch_ = place.stretch;
  return place;
}

}  // namespace argil::haptics
