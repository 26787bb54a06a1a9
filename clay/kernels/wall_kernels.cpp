#include "clay/kernels/wall_kernels.h"

#include "clay/kernels/brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/wall_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kBrickEdge>;
using NumberTag = hn::Rebind<uint32_t, RowTag>;
using Row = hn::Vec<RowTag>;

HWY_INLINE Row dot(Row ax, Row ay, Row az, Row bx, Row by, Row bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

// The least of each lane so far, and where it was.
struct Least {
  Row size;
  hn::Vec<NumberTag> at;
};

template <class Mask>
HWY_INLINE void take(Least& least, Mask mask, Row size, uint32_t first) {
  const NumberTag n;
  const auto smaller = hn::And(mask, hn::Lt(size, least.size));
  least.size = hn::IfThenElse(smaller, size, least.size);
  least.at = hn::IfThenElse(hn::RebindMask(n, smaller), hn::Iota(n, first), least.at);
}

HWY_INLINE bool reduce(const Least& least, float& best, uint32_t& at) {
  const RowTag d;
  HWY_ALIGN float sizes[kBrickEdge];
  HWY_ALIGN uint32_t places[kBrickEdge];
  hn::Store(least.size, d, sizes);
  hn::Store(least.at, NumberTag(), places);
  bool found = false;
  for (size_t i = 0; i < hn::Lanes(d); ++i)
    if (sizes[i] < best || (found && sizes[i] == best && places[i] < at)) best = sizes[i], at = places[i], found = true;
  return found;
}

int Find(const SurfacePoints& points, const float* p, const float* n, Opposite& found) {
  const RowTag d;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(d));
  const float* rows[6];
  for (size_t k = 0; k < 6; ++k) rows[k] = points.rows + k * points.stride;
  const Row px = hn::Set(d, p[0]), py = hn::Set(d, p[1]), pz = hn::Set(d, p[2]);
  const Row nx = hn::Set(d, n[0]), ny = hn::Set(d, n[1]), nz = hn::Set(d, n[2]);
  const Row zero = hn::Zero(d), limit = hn::Set(d, kOppositeCosine);
  const NumberTag numbers;
  Least wall{hn::Set(d, found.wall), hn::Zero(numbers)}, gap{hn::Set(d, found.gap), hn::Zero(numbers)};
  for (uint32_t i = 0; i < points.count; i += lanes) {
    const Row mx = hn::LoadU(d, rows[3] + i), my = hn::LoadU(d, rows[4] + i), mz = hn::LoadU(d, rows[5] + i);
    const auto opposite = hn::And(hn::Lt(dot(mx, my, mz, nx, ny, nz), limit), hn::FirstN(d, points.count - i));
    if (hn::AllFalse(d, opposite)) continue;
    const Row dx = hn::Sub(px, hn::LoadU(d, rows[0] + i)), dy = hn::Sub(py, hn::LoadU(d, rows[1] + i)),
              dz = hn::Sub(pz, hn::LoadU(d, rows[2] + i));
    const Row square = dot(dx, dy, dz, dx, dy, dz), deep = dot(dx, dy, dz, nx, ny, nz),
              away = dot(dx, dy, dz, mx, my, mz);
    const Row size = hn::Div(square, hn::Abs(deep));
    take(wall, hn::And(opposite, hn::And(hn::Gt(deep, zero), hn::Lt(away, zero))), size, i);
    take(gap, hn::And(opposite, hn::And(hn::Lt(deep, zero), hn::Gt(away, zero))), size, i);
  }
  return int{reduce(wall, found.wall, found.wallAt)} | int{reduce(gap, found.gap, found.gapAt)} << 1;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Find);

int findOpposite(const SurfacePoints& points, const float* p, const float* n, Opposite& found) noexcept {
  return HWY_DYNAMIC_DISPATCH(Find)(points, p, n, found);
}

}  // namespace argil::clay
#endif
