// The plane through the eight corners of cells. For files that are compiled once per SIMD target.

// (A guard for each target in place of `#pragma once`.)
#if defined(ARGIL_CLAY_KERNELS_CORNER_PLANES) == defined(HWY_TARGET_TOGGLE)
#ifdef ARGIL_CLAY_KERNELS_CORNER_PLANES
#undef ARGIL_CLAY_KERNELS_CORNER_PLANES
#else
#define ARGIL_CLAY_KERNELS_CORNER_PLANES
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

/// By least squares, from the Walsh coefficients of the corners' values.
template <class V>
struct CornerPlane {
  V bend;                    ///< Mean square of what it leaves of the corners: of the four that no plane has.
  V sum;                     ///< Of the corners: eight times the value in the middle.
  V slopeX, slopeY, slopeZ;  ///< Four times those of the plane.
};
/// `v`: corner c lies at (c >> 2, (c >> 1) & 1, c & 1).
template <class V>
HWY_INLINE CornerPlane<V> cornerPlane(const V (&v)[8]) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::DFromV<V> d;
  const V a = hn::Add(v[0], v[1]), b = hn::Add(v[2], v[3]), c = hn::Add(v[4], v[5]), e = hn::Add(v[6], v[7]);
  const V f = hn::Sub(v[1], v[0]), g = hn::Sub(v[3], v[2]), h = hn::Sub(v[5], v[4]), k = hn::Sub(v[7], v[6]);
  const V xy = hn::Sub(hn::Sub(a, b), hn::Sub(c, e)), yz = hn::Add(hn::Sub(g, f), hn::Sub(k, h)),
          zx = hn::Sub(hn::Add(h, k), hn::Add(f, g)), xyz = hn::Sub(hn::Sub(f, g), hn::Sub(h, k));
  const V squares = hn::Add(hn::Add(hn::Mul(xy, xy), hn::Mul(yz, yz)), hn::Add(hn::Mul(zx, zx), hn::Mul(xyz, xyz)));
  const V lower = hn::Add(a, b), upper = hn::Add(c, e);
  return {hn::Mul(squares, hn::Set(d, 1.0f / 64)), hn::Add(lower, upper), hn::Sub(upper, lower),
          hn::Sub(hn::Add(b, e), hn::Add(a, c)), hn::Add(hn::Add(f, g), hn::Add(h, k))};
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
