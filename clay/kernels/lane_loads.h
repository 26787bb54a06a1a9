// Vectors from many places, by one load a lane. The gather instruction may be several times slower: on a Xeon of
// 2.5 GHz one of eight floats took 10.7 ns, and eight loads 3.3. For files that are compiled once per SIMD target.

// (A guard for each target in place of `#pragma once`.)
#if defined(ARGIL_CLAY_KERNELS_LANE_LOADS) == defined(HWY_TARGET_TOGGLE)
#ifdef ARGIL_CLAY_KERNELS_LANE_LOADS
#undef ARGIL_CLAY_KERNELS_LANE_LOADS
#else
#define ARGIL_CLAY_KERNELS_LANE_LOADS
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

/// A vector of kLanes floats from parts of kUnit floats: load(i) is part number i.
template <int kLanes, int kUnit, class Load>
HWY_INLINE auto joinedLoads(const Load& load, int first = 0) {
  namespace hn = hwy::HWY_NAMESPACE;
  if constexpr (kLanes == kUnit) {
    return load(first);
  } else {
    const auto lower = joinedLoads<kLanes / 2, kUnit>(load, first);
    const auto upper = joinedLoads<kLanes / 2, kUnit>(load, first + kLanes / 2 / kUnit);
    return hn::Combine(hn::FixedTag<float, kLanes>(), upper, lower);
  }
}

/// load(lane) in each lane, an address of a float.
template <class D, class Address>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<D> loadEach(D, const Address& address) {
  namespace hn = hwy::HWY_NAMESPACE;
  return joinedLoads<static_cast<int>(hn::MaxLanes(D())), 1>(
      [&](int lane) { return hn::LoadU(hn::FixedTag<float, 1>(), address(lane)); });
}

/// The two floats at address(lane) and behind it, the firsts and the seconds.
template <class D, class Address>
HWY_INLINE void loadPairs(D d, const Address& address, hwy::HWY_NAMESPACE::Vec<D>& first,
                          hwy::HWY_NAMESPACE::Vec<D>& second) {
  namespace hn = hwy::HWY_NAMESPACE;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  const auto load = [&](int lane) { return hn::LoadU(hn::FixedTag<float, 2>(), address(lane)); };
  const auto lower = joinedLoads<kLanes, 2>(load), upper = joinedLoads<kLanes, 2>(load, kLanes / 2);
  first = hn::ConcatEven(d, upper, lower);
  second = hn::ConcatOdd(d, upper, lower);
}

/// The four floats at address(lane) and behind it: out[k] has number k of each.
template <class D, class Address>
HWY_INLINE void loadFours(D d, const Address& address, hwy::HWY_NAMESPACE::Vec<D> (&out)[4]) {
  namespace hn = hwy::HWY_NAMESPACE;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  // Four lanes in each block of 128 bits: those of number `row` of all blocks.
  const auto row = [&](int number) {
    return joinedLoads<kLanes, 4>(
        [&](int part) { return hn::LoadU(hn::FixedTag<float, 4>(), address(part * 4 + number)); });
  };
  const auto a = row(0), b = row(1), c = row(2), e = row(3);
  const auto ac = hn::InterleaveLower(d, a, c), be = hn::InterleaveLower(d, b, e);
  const auto acUp = hn::InterleaveUpper(d, a, c), beUp = hn::InterleaveUpper(d, b, e);
  out[0] = hn::InterleaveLower(d, ac, be);
  out[1] = hn::InterleaveUpper(d, ac, be);
  out[2] = hn::InterleaveLower(d, acUp, beUp);
  out[3] = hn::InterleaveUpper(d, acUp, beUp);
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
