#include "clay/kernels/box_kernels.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/box_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

uint32_t Bounds(const BoxNode& node, const float* p, float slack, float best, float* squared) {
  const hn::CappedTag<float, kBoxes> d;
  // What rounding in the sums below may add to a bound; and no bound is infinite, but for lanes that are not used.
  const auto less = hn::Set(d, 1 - 1e-6f), most = hn::Set(d, std::numeric_limits<float>::max());
  const auto room = hn::Set(d, slack), none = hn::Zero(d);
  uint32_t lanes = 0;
  for (size_t i = 0; i < kBoxes; i += hn::Lanes(d)) {
    auto box = none, along = none;
    auto used = hn::Le(hn::Load(d, node.low[0] + i), hn::Load(d, node.high[0] + i));
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = hn::Set(d, p[axis]);
      const auto below = hn::Sub(hn::Load(d, node.low[axis] + i), at);
      const auto above = hn::Sub(at, hn::Load(d, node.high[axis] + i));
      const auto gap = hn::Max(hn::Sub(hn::Max(below, above), room), none);
      box = hn::Add(box, hn::Mul(gap, gap));
      along = hn::Add(along, hn::Mul(hn::Load(d, node.normal[axis] + i), at));
    }
    const auto beside = hn::Max(hn::Sub(hn::Load(d, node.from + i), along), hn::Sub(along, hn::Load(d, node.to + i)));
    const auto gap = hn::Max(hn::Sub(beside, room), none);
    const auto bound = hn::Min(hn::Mul(hn::Max(box, hn::Mul(gap, gap)), less), most);
    hn::StoreU(bound, d, squared + i);
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::And(used, hn::Le(bound, hn::Set(d, best))), bits);
    lanes |= uint32_t(bits[0]) << i;
  }
  return lanes;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Bounds);

uint32_t boundsOf(const BoxNode& node, const float (&p)[3], float slack, float best,
                  float (&squared)[kBoxes]) noexcept {
  return HWY_DYNAMIC_DISPATCH(Bounds)(node, p, slack, best, squared);
}

}  // namespace argil::clay
#endif
