#include "clay/kernels/fixed_brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/fixed_brick.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using Wide = hn::RebindToSigned<Floats>;
using Codes = hn::Rebind<int16_t, Floats>;

bool Pack(const float* values, float band, int16_t* codes) {
  const Floats d;
  const Wide wide;
  const Codes narrow;
  const auto perStep = hn::Set(d, static_cast<float>(kMostCode) / band), zero = hn::Zero(d);
  const auto most = hn::Set(wide, kMostCode), belowZero = hn::Set(wide, -1);
  auto inBand = hn::Lt(most, most);  // no lane yet
  for (size_t i = 0; i < kBrickVoxels; i += hn::Lanes(d)) {
    const auto value = hn::LoadU(d, values + i);
    const auto nearest = hn::NearestInt(hn::Mul(value, perStep));
    const auto negative = hn::RebindMask(wide, hn::Lt(value, zero));
    const auto code = hn::IfThenElse(negative, hn::Min(nearest, belowZero), nearest);
    inBand = hn::Or(inBand, hn::Lt(hn::Abs(code), most));
    hn::StoreU(hn::DemoteTo(narrow, code), narrow, codes + i);
  }
  return !hn::AllFalse(wide, inBand);
}

void Unpack(const int16_t* codes, float step, float* values) {
  const Floats d;
  const Wide wide;
  const Codes narrow;
  const auto unit = hn::Set(d, step);
  for (size_t i = 0; i < kBrickVoxels; i += hn::Lanes(d))
    hn::StoreU(hn::Mul(hn::ConvertTo(d, hn::PromoteTo(wide, hn::LoadU(narrow, codes + i))), unit), d, values + i);
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Pack);
HWY_EXPORT(Unpack);

bool packDistances(const BrickValues& values, float band, int16_t (&codes)[kBrickVoxels]) noexcept {
  return HWY_DYNAMIC_DISPATCH(Pack)(values, band, codes);
}
void unpackDistances(const int16_t* codes, float step, float* values) noexcept {
  HWY_DYNAMIC_DISPATCH(Unpack)(codes, step, values);
}

}  // namespace argil::clay
#endif
