#include "clay/kernels/bend_kernels.h"

#include <bit>

#include "clay/kernels/cell_cases.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/bend_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A lane is an edge; most cells have four that are crossed, few have more than eight.
using Tag = hn::CappedTag<float, EdgeCrossings::kPadding>;
using Floats = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));

constexpr float kKink = 0.05f, kKinkRatio = 8;
// Of Newton's method: a start that is 0.05 voxel off leaves 0.0001 after the first where a field bends by that, and
// its square after the second.
constexpr int kSteps = 2;
constexpr float kLeastSlope = 0.05f;
// A field that is flatter is no distance.
constexpr float kFlat = 0.1f;

HWY_INLINE Floats all(float value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE Floats times(float factor, Floats v) {
  return hn::Mul(all(factor), v);
}

// Is a kink in this second difference, and none in the one beside it?
HWY_INLINE Mask kinked(Floats difference, Floats other) {
  return hn::Gt(hn::Abs(difference), hn::Add(times(kKinkRatio, hn::Abs(other)), all(kKink)));
}

HWY_INLINE Floats secondDifference(Floats a, Floats b, Floats c) {
  return hn::Add(hn::Sub(a, times(2, b)), c);
}

// Slope at the third of five voxels in a line; beside a kink from the smooth side alone.
HWY_INLINE Floats slopeAt(const Floats (&f)[5]) {
  const Floats low = secondDifference(f[0], f[1], f[2]), middle = secondDifference(f[1], f[2], f[3]),
               high = secondDifference(f[2], f[3], f[4]);
  const Mask lower = hn::Lt(hn::Abs(low), hn::Abs(high));
  const Floats below = hn::Add(hn::Sub(times(3, f[2]), times(4, f[1])), f[0]),
               above = hn::Sub(hn::Sub(times(4, f[3]), times(3, f[2])), f[4]);
  const Floats oneSided = hn::IfThenElse(lower, below, above);
  const Mask kink = kinked(middle, hn::IfThenElse(lower, low, high));
  return times(0.5f, hn::IfThenElse(kink, oneSided, hn::Sub(f[3], f[1])));
}

bool CrossEdges(const float* phi, int stepX, int stepY, unsigned edges, EdgeCrossings& out) {
  const Tag d;
  const int steps[3] = {stepX, stepY, 1};
  out.count = std::popcount(edges);
  bool steep = true;
  unsigned left = edges;
  for (int first = 0; first < out.count; first += kLanes) {
    // Of each edge the first corner, and the steps along it and across. A lane without an edge has the last one again.
    const float* from[kLanes];
    int along[kLanes], across[2][kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      const CellEdge edge = kCellEdges[static_cast<size_t>(std::countr_zero(left))];
      from[lane] = phi + (edge.from >> 2) * stepX + ((edge.from >> 1) & 1) * stepY + (edge.from & 1);
      along[lane] = steps[edge.axis];
      across[0][lane] = steps[(edge.axis + 1) % 3];
      across[1][lane] = steps[(edge.axis + 2) % 3];
      if ((left & (left - 1)) != 0) left &= left - 1;
    }
    const auto at = [&](int alongEdge, int other, int voxels) {
      return loadEach(d, [&](int lane) { return from[lane] + alongEdge * along[lane] + voxels * across[other][lane]; });
    };
    // Where the cubic through four voxels is zero, and its slope there.
    const Floats b = at(0, 0, 0), c = at(1, 0, 0);
    Floats low = secondDifference(at(-1, 0, 0), b, c), high = secondDifference(b, c, at(2, 0, 0));
    const Mask lowKink = kinked(low, high), highKink = kinked(high, low);
    const Floats smooth = high;  // never both are kinked
    high = hn::IfThenElse(highKink, low, high);
    low = hn::IfThenElse(lowKink, smooth, low);
    const Floats rise = hn::Sub(c, b), one = all(1);
    Floats t = hn::Div(b, hn::Sub(b, c)), slope = rise;
    for (int i = 0; i < kSteps; ++i) {
      const Floats inner = hn::Mul(t, hn::Sub(t, one));
      const Floats bend = times(1.0f / 6, hn::Add(hn::Mul(low, hn::Sub(all(2), t)), hn::Mul(high, hn::Add(one, t))));
      slope = hn::Add(hn::Add(rise, hn::Mul(hn::Sub(times(2, t), one), bend)),
                      times(1.0f / 6, hn::Mul(inner, hn::Sub(high, low))));
      const Floats value = hn::Add(hn::Add(b, hn::Mul(t, rise)), hn::Mul(inner, bend));
      const Floats next = hn::Min(hn::Max(hn::Sub(t, hn::Div(value, slope)), all(0)), one);
      t = hn::IfThenElse(hn::Lt(hn::Abs(slope), all(kLeastSlope)), t, next);
    }
    Floats sides[2];
    for (int other = 0; other < 2; ++other) {
      const auto slopeBeside = [&](int corner, Floats middle) {
        const Floats line[5] = {at(corner, other, -2), at(corner, other, -1), middle, at(corner, other, 1),
                                at(corner, other, 2)};
        return slopeAt(line);
      };
      sides[other] = hn::Add(hn::Mul(hn::Sub(one, t), slopeBeside(0, b)), hn::Mul(t, slopeBeside(1, c)));
    }
    const Floats length =
        hn::Sqrt(hn::Add(hn::Add(hn::Mul(slope, slope), hn::Mul(sides[0], sides[0])), hn::Mul(sides[1], sides[1])));
    const Floats scale = hn::Div(one, length);
    steep = steep && hn::AllTrue(d, hn::Gt(length, all(kFlat)));
    hn::StoreU(t, d, out.along + first);
    hn::StoreU(hn::Mul(slope, scale), d, out.normal[0] + first);
    hn::StoreU(hn::Mul(sides[0], scale), d, out.normal[1] + first);
    hn::StoreU(hn::Mul(sides[1], scale), d, out.normal[2] + first);
  }
  return steep;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(CrossEdges);

bool crossEdges(const float* phi, int stepX, int stepY, unsigned edges, EdgeCrossings& out) noexcept {
  return HWY_DYNAMIC_DISPATCH(CrossEdges)(phi, stepX, stepY, edges, out);
}

}  // namespace argil::clay
#endif
