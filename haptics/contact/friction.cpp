#include "haptics/contact/friction.h"

#include <algorithm>

namespace argil::haptics {
namespace {

// Without sliding before the ball counts as at rest: a hand that slides slowly jitters.
constexpr int kRestTicks = 3;

}  // namespace

Vec3d Friction::goal(const Vec3d& proxy, const Vec3d& hand, const Touch& touch) ARGIL_REALTIME {
  const double push = touch.push.norm();
  if (!(push > 0) || !(touch.staticMm > 0 || touch.viscousNsmm > 0)) {
    sliding_ = false;
    return hand;
  }
  const Vec3d normal = touch.push / push;
  const Vec3d stretch = hand - proxy;
  const Vec3d along = stretch - normal * normal.dot(stretch);
  const double pull = along.norm();
  const double bound = sliding_ ? touch.dynamicMm : touch.staticMm;
  if (pull <= bound) {
    if (++restTicks_ >= kRestTicks) sliding_ = false;
    return hand - along;
  }
  restTicks_ = 0;
  sliding_ = true;
  double slide = pull - touch.dynamicMm;
  // The viscous bound on speed, implicit: the proxy's own motion relaxes the spring within the tick.
  if (touch.viscousNsmm > 0) {
    const double pace = touch.periodS * touch.stiffnessNmm;
    slide *= pace / (touch.viscousNsmm + pace);
  }
  return hand - along * (1 - std::max(0.0, slide) / pull);
}

}  // namespace argil::haptics
