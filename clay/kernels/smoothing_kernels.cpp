#include "clay/kernels/smoothing_kernels.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/smoothing_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kBrickEdge>;
using Row = hn::Vec<RowTag>;

// Along z, y and x: `sum(at, step)` of a row and those `reach` steps around it.
template <class Sum>
void AlongAxes(const float* broad, int reach, float share, const Sum& sum, float* out) {
  const RowTag d;
  alignas(64) float alongZ[16 * 16 * 8], alongY[16 * 8 * 8];
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 4 - reach; x < 12 + reach; ++x)
    for (int y = 4 - reach; y < 12 + reach; ++y)
      for (int z = 0; z < 8; z += lanes)
        hn::StoreU(sum(broad + broadOffset(x, y, 4 + z), 1), d, alongZ + (x * 16 + y) * 8 + z);
  for (int x = 4 - reach; x < 12 + reach; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; z += lanes)
        hn::StoreU(sum(alongZ + (x * 16 + y + 4) * 8 + z, 8), d, alongY + (x * 8 + y) * 8 + z);
  for (int x = 0; x < 8; ++x)
    for (int i = 0; i < 64; i += lanes)
      hn::StoreU(hn::Mul(sum(alongY + (x + 4) * 64 + i, 64), hn::Set(d, share)), d, out + x * 64 + i);
}
void Broad(const float* broad, int spacing, float* mean) {
  AlongAxes(
      broad, spacing, 1.0f / 64,
      [spacing](const float* at, int step) HWY_ATTR {
        const RowTag d;
        const Row centre = hn::LoadU(d, at);
        return hn::Add(hn::Add(hn::LoadU(d, at - spacing * step), hn::LoadU(d, at + spacing * step)),
                       hn::Add(centre, centre));
      },
      mean);
}
void BroadOfBroad(const float* broad, float* mean) {
  AlongAxes(
      broad, 3, 1.0f / 4096,
      [](const float* at, int step) HWY_ATTR {
        const RowTag d;
        const auto both = [&](int k)
                              HWY_ATTR { return hn::Add(hn::LoadU(d, at - k * step), hn::LoadU(d, at + k * step)); };
        const Row centre = hn::LoadU(d, at), one = both(1), two = both(2);
        return hn::Add(hn::Add(both(3), hn::Add(two, two)),
                       hn::Add(hn::Mul(one, hn::Set(d, 3.0f)), hn::Mul(centre, hn::Set(d, 4.0f))));
      },
      mean);
}

float BroadPasses(const float* broad, int passes, float shift, float band, float* mean) {
  const RowTag d;
  // Rows of Pascal's triangle from the middle outwards: their sums are powers of 4, so that products are exact.
  constexpr float kWeights[5][5] = {{1}, {2, 1}, {6, 4, 1}, {20, 15, 6, 1}, {70, 56, 28, 8, 1}};
  const Row share = hn::Set(d, 1.0f / static_cast<float>(1 << (6 * passes)));
  alignas(64) float alongZ[16 * 16 * 8], alongY[16 * 8 * 8];
  const Row off = hn::Set(d, shift), most = hn::Set(d, band);
  Row least = most;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto sum = [&](const float* at, int step) {
    const float* weights = kWeights[passes];
    Row all = hn::Mul(hn::LoadU(d, at), hn::Set(d, weights[0]));
    for (int k = 1; k <= passes; ++k) {
      const Row both = hn::Add(hn::LoadU(d, at - k * step), hn::LoadU(d, at + k * step));
      all = hn::Add(all, hn::Mul(both, hn::Set(d, weights[k])));
    }
    return all;
  };
  for (int x = 4 - passes; x < 12 + passes; ++x)
    for (int y = 4 - passes; y < 12 + passes; ++y)
      for (int z = 0; z < 8; z += lanes)
        hn::StoreU(sum(broad + broadOffset(x, y, 4 + z), 1), d, alongZ + (x * 16 + y) * 8 + z);
  for (int x = 4 - passes; x < 12 + passes; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; z += lanes)
        hn::StoreU(sum(alongZ + (x * 16 + y + 4) * 8 + z, 8), d, alongY + (x * 8 + y) * 8 + z);
  for (int x = 0; x < 8; ++x)
    for (int i = 0; i < 64; i += lanes) {
      const Row value = hn::Sub(hn::Mul(sum(alongY + (x + 4) * 64 + i, 64), share), off);
      const Row phi = hn::Min(hn::Max(value, hn::Neg(most)), most);
      least = hn::Min(least, hn::Abs(phi));
      hn::StoreU(phi, d, mean + x * 64 + i);
    }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

void Bend(const float (&table)[kBendSteps + 2], float scale, float* values) {
  const RowTag d;
  const hn::RebindToSigned<RowTag> whole;
  const Row by = hn::Set(d, scale), most = hn::Set(d, kBendSteps);
  for (int voxel = 0; voxel < kBrickVoxels; voxel += static_cast<int>(hn::Lanes(d))) {
    const Row value = hn::LoadU(d, values + voxel), size = hn::Min(hn::Mul(hn::Abs(value), by), most);
    const auto at = hn::ConvertTo(whole, size);
    HWY_ALIGN int32_t places[kBrickEdge];
    hn::Store(at, whole, places);
    Row low, high;
    loadPairs(
        d, [&](int lane) { return table + places[lane]; }, low, high);
    const Row part = hn::Sub(size, hn::ConvertTo(d, at));
    hn::StoreU(hn::CopySign(hn::Add(low, hn::Mul(hn::Sub(high, low), part)), value), d, values + voxel);
  }
}

// What of three lines of three stands in the middle, ends first: mirror images have mirrored bits.
void Far(const float* const* around, float* mean) {
  const RowTag d;
  const Row half = hn::Set(d, 0.5f), quarter = hn::Set(d, 0.25f);
  for (int voxel = 0; voxel < kBrickVoxels; voxel += static_cast<int>(hn::Lanes(d))) {
    const auto middle = [&](const Row& below, const Row& at, const Row& above)
                            HWY_ATTR { return hn::Add(hn::Mul(quarter, hn::Add(below, above)), hn::Mul(half, at)); };
    const auto line = [&](int k) HWY_ATTR {
      return middle(hn::LoadU(d, around[k] + voxel), hn::LoadU(d, around[k + 1] + voxel),
                    hn::LoadU(d, around[k + 2] + voxel));
    };
    const auto plane = [&](int k) HWY_ATTR { return middle(line(k), line(k + 3), line(k + 6)); };
    hn::StoreU(middle(plane(0), plane(9), plane(18)), d, mean + voxel);
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Broad);
HWY_EXPORT(BroadOfBroad);
HWY_EXPORT(Far);
HWY_EXPORT(BroadPasses);
HWY_EXPORT(Bend);

void broadMean(const float* broad, int spacing, float* mean) noexcept {
  HWY_DYNAMIC_DISPATCH(Broad)(broad, spacing, mean);
}
void broadMeanOfMeans(const float* broad, float* mean) noexcept {
  HWY_DYNAMIC_DISPATCH(BroadOfBroad)(broad, mean);
}
float broadMeans(const float* broad, int passes, float shift, float band, float* mean) noexcept {
  return HWY_DYNAMIC_DISPATCH(BroadPasses)(broad, passes, shift, band, mean);
}
void bendValues(const float (&table)[kBendSteps + 2], float scale, float* values) noexcept {
  HWY_DYNAMIC_DISPATCH(Bend)(table, scale, values);
}
void farMean(const float* const (&around)[27], float* mean) noexcept {
  HWY_DYNAMIC_DISPATCH(Far)(around, mean);
}

}  // namespace argil::clay
#endif
