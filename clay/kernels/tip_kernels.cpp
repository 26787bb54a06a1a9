#include "clay/kernels/tip_kernels.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/tip_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using RowTag = hn::CappedTag<float, 8>;
using Row = hn::Vec<RowTag>;

struct Rows {
  Row x, y, z;
};

HWY_INLINE Row sum3(Row x, Row y, Row z) {
  return hn::Add(hn::Add(x, y), z);
}
HWY_INLINE Row square(Row v) {
  return hn::Mul(v, v);
}

template <class Value>
HWY_INLINE void forPlaces(const SweptAxes& tip, float* distance, const Value& value) {
  const RowTag d;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
        const Row vx = hn::Set(d, (static_cast<float>(x) - 3.5f) - tip.a[0]),
                  vy = hn::Set(d, (static_cast<float>(y) - 3.5f) - tip.a[1]);
        const Row vz = hn::Sub(hn::Iota(d, static_cast<float>(lane) - 3.5f), hn::Set(d, tip.a[2]));
        const auto along = [&](const float* axis) HWY_ATTR {
          return sum3(hn::Mul(vx, hn::Set(d, axis[0])), hn::Mul(vy, hn::Set(d, axis[1])),
                      hn::Mul(vz, hn::Set(d, axis[2])));
        };
        hn::StoreU(value(Rows{along(tip.axes), along(tip.axes + 3), along(tip.axes + 6)}), d,
                   distance + x * 64 + y * 8 + lane);
      }
}

// The place of the way whose ellipsoid reaches the farthest is where the scaled place, a sphere's, is nearest. From
// there the distance follows from the foot e² y / (λ + e²), by steps that solve |foot / e| = 1 as for a sphere (Moré
// and Sorensen 1983).
void Ellipsoid(const SweptAxes& tip, float* distance) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  float inverse[3], way2 = 0;
  for (int i = 0; i < 3; ++i) inverse[i] = 1 / tip.half[i];
  const float s[3] = {tip.d[0] * inverse[0], tip.d[1] * inverse[1], tip.d[2] * inverse[2]};
  way2 = (s[0] * s[0] + s[1] * s[1]) + s[2] * s[2];
  const float inverseWay2 = way2 > 1e-12f ? 1 / way2 : 0;
  forPlaces(tip, distance, [&](const Rows& q) HWY_ATTR {
    const auto by = [&](Row v, float w) HWY_ATTR { return hn::Mul(v, hn::Set(d, w)); };
    const Row dot = sum3(by(q.x, inverse[0] * s[0]), by(q.y, inverse[1] * s[1]), by(q.z, inverse[2] * s[2]));
    const Row t = hn::Min(hn::Max(by(dot, inverseWay2), zero), one), size = hn::Add(one, by(t, tip.growth));
    const Rows y{hn::Sub(q.x, by(t, tip.d[0])), hn::Sub(q.y, by(t, tip.d[1])), hn::Sub(q.z, by(t, tip.d[2]))};
    const Row ex = by(size, tip.half[0]), ey = by(size, tip.half[1]), ez = by(size, tip.half[2]);
    const Row ex2 = square(ex), ey2 = square(ey), ez2 = square(ez), least = hn::Min(hn::Min(ex2, ey2), ez2);
    const Row cx = hn::Mul(ex, y.x), cy = hn::Mul(ey, y.y), cz = hn::Mul(ez, y.z);
    const Row k0 = hn::Sqrt(sum3(square(hn::Div(cx, ex2)), square(hn::Div(cy, ey2)), square(hn::Div(cz, ez2))));
    const Row k1 = hn::Sqrt(sum3(square(hn::Div(y.x, ex2)), square(hn::Div(y.y, ey2)), square(hn::Div(y.z, ez2))));
    const Row floor = by(least, -0.9999f);
    Row lambda = hn::Max(hn::Div(hn::Mul(k0, hn::Sub(k0, one)), hn::Max(square(k1), hn::Set(d, 1e-12f))), floor);
    for (int i = 0; i < 5; ++i) {
      const Row ux = hn::Div(one, hn::Add(lambda, ex2)), uy = hn::Div(one, hn::Add(lambda, ey2)),
                uz = hn::Div(one, hn::Add(lambda, ez2));
      const Row gx = square(hn::Mul(cx, ux)), gy = square(hn::Mul(cy, uy)), gz = square(hn::Mul(cz, uz));
      const Row g = sum3(gx, gy, gz), slope = sum3(hn::Mul(gx, ux), hn::Mul(gy, uy), hn::Mul(gz, uz));
      const Row step = hn::Div(hn::Mul(hn::Sub(hn::Sqrt(g), one), g), hn::Max(slope, hn::Set(d, 1e-20f)));
      lambda = hn::Max(hn::Add(lambda, step), floor);
    }
    const Row way =
        hn::Sqrt(sum3(square(hn::Div(y.x, hn::Add(lambda, ex2))), square(hn::Div(y.y, hn::Add(lambda, ey2))),
                      square(hn::Div(y.z, hn::Add(lambda, ez2)))));
    // In the very middle there is no foot to be found.
    return hn::IfThenElse(hn::Lt(k1, hn::Set(d, 1e-6f)), hn::Neg(hn::Sqrt(least)), hn::Mul(lambda, way));
  });
}

// Outside: the distance to a convex solid is convex along the way, so halving finds its least. Inside: the nearest of
// the planes that bound the swept box, its own and those that the way makes with its edges.
void Box(const SweptAxes& tip, float* distance) {
  const RowTag d;
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const float core[3] = {tip.half[0] - tip.round, tip.half[1] - tip.round, tip.half[2] - tip.round};
  const float middle = 1 + 0.5f * tip.growth;
  float planes[3][3], support[3], scale[3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    planes[i][i] = 0, planes[i][j] = tip.d[k], planes[i][k] = -tip.d[j];
    const float length2 = tip.d[j] * tip.d[j] + tip.d[k] * tip.d[k];
    scale[i] = length2 > 1e-8f ? 1 / std::sqrt(length2) : 0;
    support[i] = (core[j] * std::abs(tip.d[k]) + core[k] * std::abs(tip.d[j])) * middle * scale[i];
  }
  const bool moves = tip.d[0] != 0 || tip.d[1] != 0 || tip.d[2] != 0;
  forPlaces(tip, distance, [&](const Rows& q) HWY_ATTR {
    const auto by = [&](Row v, float w) HWY_ATTR { return hn::Mul(v, hn::Set(d, w)); };
    const auto beyond = [&](Row v, Row half) HWY_ATTR { return hn::Sub(v, hn::Min(hn::Max(v, hn::Neg(half)), half)); };
    const auto outside = [&](Row t) HWY_ATTR {
      const Row size = hn::Add(one, by(t, tip.growth));
      return Rows{beyond(hn::Sub(q.x, by(t, tip.d[0])), by(size, core[0])),
                  beyond(hn::Sub(q.y, by(t, tip.d[1])), by(size, core[1])),
                  beyond(hn::Sub(q.z, by(t, tip.d[2])), by(size, core[2]))};
    };
    Row t = zero;
    if (moves) {
      Row low = zero, high = one;
      for (int i = 0; i < 14; ++i) {
        t = by(hn::Add(low, high), 0.5f);
        const Rows o = outside(t);
        const auto farther = hn::Gt(sum3(by(o.x, tip.d[0]), by(o.y, tip.d[1]), by(o.z, tip.d[2])), zero);
        low = hn::IfThenElse(farther, t, low);
        high = hn::IfThenElse(farther, high, t);
      }
      // The ends of the way are places too.
      t = hn::IfThenElse(hn::Lt(high, hn::Set(d, 1.0f / 8192)), zero,
                         hn::IfThenElse(hn::Gt(low, hn::Set(d, 1 - 1.0f / 8192)), one, t));
    }
    const Rows o = outside(t);
    const Row away = hn::Sqrt(sum3(square(o.x), square(o.y), square(o.z)));
    const Rows m{hn::Abs(hn::Sub(q.x, hn::Set(d, 0.5f * tip.d[0]))), hn::Abs(hn::Sub(q.y, hn::Set(d, 0.5f * tip.d[1]))),
                 hn::Abs(hn::Sub(q.z, hn::Set(d, 0.5f * tip.d[2])))};
    const auto face = [&](Row v, int i)
                          HWY_ATTR { return hn::Sub(v, hn::Set(d, core[i] * middle + 0.5f * std::abs(tip.d[i]))); };
    Row depth = hn::Max(hn::Max(face(m.x, 0), face(m.y, 1)), face(m.z, 2));
    for (int i = 0; i < 3; ++i) {
      if (scale[i] == 0) continue;
      const Row n = hn::Abs(
          sum3(by(q.x, planes[i][0] * scale[i]), by(q.y, planes[i][1] * scale[i]), by(q.z, planes[i][2] * scale[i])));
      depth = hn::Max(depth, hn::Sub(n, hn::Set(d, support[i])));
    }
    const Row round = by(hn::Add(one, by(t, tip.growth)), tip.round);
    return hn::Sub(hn::IfThenElse(hn::Gt(away, zero), away, hn::Min(depth, zero)), round);
  });
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {
HWY_EXPORT(Ellipsoid);
HWY_EXPORT(Box);
void ellipsoidDistances(const SweptAxes& tip, float* distance) noexcept {
  HWY_DYNAMIC_DISPATCH(Ellipsoid)(tip, distance);
}
void boxDistances(const SweptAxes& tip, float* distance) noexcept {
  HWY_DYNAMIC_DISPATCH(Box)(tip, distance);
}
}  // namespace argil::clay
#endif
