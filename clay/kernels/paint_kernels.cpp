#include "clay/kernels/paint_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/paint_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kBrickEdge>;
using Row = hn::Vec<RowTag>;

template <class Value>
HWY_INLINE void forRows(const Value& value) {
  const RowTag d;
  for (int voxel = 0; voxel < kBrickVoxels; voxel += static_cast<int>(hn::Lanes(d))) value(voxel);
}

void Feet(const float* padded, float band, float* foot) {
  const RowTag d;
  const Row zero = hn::Zero(d), edge = hn::Set(d, band), least = hn::Set(d, 1e-4f);
  const auto isKnown = [&](Row value) { return hn::Lt(hn::Abs(value), edge); };
  forRows([&](int voxel) {
    const float* at = padded + paddedOffset((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, (voxel & 7) + 1);
    const Row u = hn::LoadU(d, at), twice = hn::Add(u, u);
    // Continues the difference of the other side where one side is not known.
    const auto slope = [&](int step) {
      const Row before = hn::LoadU(d, at - step), after = hn::LoadU(d, at + step);
      const Row low = hn::IfThenElse(isKnown(before), before, hn::Sub(twice, after));
      const Row high = hn::IfThenElse(isKnown(after), after, hn::Sub(twice, before));
      return hn::Sub(high, low);
    };
    const Row gx = slope(10 * kPaddedRow), gy = slope(kPaddedRow), gz = slope(1);
    const Row length2 = hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz));
    const auto known = hn::And(isKnown(u), hn::Gt(length2, least));
    const Row scale = hn::IfThenElse(known, hn::Neg(hn::Div(u, hn::Sqrt(hn::Max(length2, least)))), zero);
    hn::StoreU(hn::Mul(gx, scale), d, foot + voxel);
    hn::StoreU(hn::Mul(gy, scale), d, foot + kBrickVoxels + voxel);
    hn::StoreU(hn::Mul(gz, scale), d, foot + 2 * kBrickVoxels + voxel);
  });
}

void Paint(const SweptBall& b, int shape, float strength, const float* foot, float* weight, float* cover) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d), half = hn::Set(d, 0.5f), all = hn::Set(d, strength);
  const Row dx = hn::Set(d, b.dx), dy = hn::Set(d, b.dy), dz = hn::Set(d, b.dz);
  const Row perVoxel = hn::Set(d, 1 / kPaintRim), middle = shape == 0 ? half : zero;
  forRows([&](int voxel) {
    const Row vx = hn::Add(hn::Set(d, static_cast<float>(voxel >> 6) - 3.5f - b.ax), hn::LoadU(d, foot + voxel));
    const Row vy = hn::Add(hn::Set(d, static_cast<float>((voxel >> 3) & 7) - 3.5f - b.ay),
                           hn::LoadU(d, foot + kBrickVoxels + voxel));
    const Row vz = hn::Add(hn::Sub(hn::Iota(d, static_cast<float>(voxel & 7) - 3.5f), hn::Set(d, b.az)),
                           hn::LoadU(d, foot + 2 * kBrickVoxels + voxel));
    const Row along = hn::Add(hn::Add(hn::Mul(vx, dx), hn::Mul(vy, dy)), hn::Mul(vz, dz));
    const Row t = hn::Min(hn::Max(hn::Mul(along, hn::Set(d, b.inverseLength2)), zero), one);
    const Row ex = hn::Sub(vx, hn::Mul(t, dx)), ey = hn::Sub(vy, hn::Mul(t, dy)), ez = hn::Sub(vz, hn::Mul(t, dz));
    const Row squared = hn::Add(hn::Add(hn::Mul(ex, ex), hn::Mul(ey, ey)), hn::Mul(ez, ez));
    const Row radius = hn::Add(hn::Set(d, b.radius), hn::Mul(t, hn::Set(d, b.growth)));
    const Row within = hn::Add(hn::Mul(hn::Sub(radius, hn::Sqrt(squared)), perVoxel), middle);
    const Row step = hn::Min(hn::Max(within, zero), one);
    const Row covered = hn::Mul(hn::Mul(step, step), hn::Sub(hn::Set(d, 3.0f), hn::Add(step, step)));
    if (hn::AllFalse(d, hn::Gt(covered, zero))) return;
    const Row t2 = hn::Div(squared, hn::Mul(radius, radius)), rest2 = hn::Max(hn::Sub(one, t2), zero);
    const Row rest = hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
    Row w = one;
    switch (shape) {
      case 0:
        break;
      case 1:
        w = hn::Mul(rest2, rest2);
        break;
      case 2:
        w = rest;
        break;
      case 3:
        w = hn::Mul(rest, rest);
        break;
      default:
        w = hn::Sqrt(rest2);
    }
    w = hn::IfThenElseZero(hn::Gt(covered, zero), hn::Mul(w, all));
    hn::StoreU(hn::Max(w, hn::LoadU(d, weight + voxel)), d, weight + voxel);
    hn::StoreU(hn::Max(covered, hn::LoadU(d, cover + voxel)), d, cover + voxel);
  });
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Feet);
HWY_EXPORT(Paint);

void surfaceFeet(const float* padded, float band, float* foot) noexcept {
  HWY_DYNAMIC_DISPATCH(Feet)(padded, band, foot);
}
void paintWeights(const SweptBall& ball, int shape, float strength, const float* foot, float* weight,
                  float* cover) noexcept {
  HWY_DYNAMIC_DISPATCH(Paint)(ball, shape, strength, foot, weight, cover);
}

}  // namespace argil::clay
#endif
