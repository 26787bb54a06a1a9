#include "clay/kernels/shaping_kernels.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/shaping_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kBrickEdge>;
using Row = hn::Vec<RowTag>;

HWY_INLINE hn::Mask<RowTag> rowMask(const uint64_t* words, int voxel) {
  const RowTag d;
  const uint8_t bits[8] = {static_cast<uint8_t>(words[voxel >> 6] >> (voxel & 63))};
  return hn::LoadMaskBits(d, bits);
}

template <class Value>
HWY_INLINE void forRows(const Value& value) {
  const RowTag d;
  for (int voxel = 0; voxel < kBrickVoxels; voxel += static_cast<int>(hn::Lanes(d))) value(voxel);
}

// The same for rows of z whose bits are set.
template <class Value>
HWY_INLINE void forRowsOf(uint64_t rows, const Value& value) {
  const RowTag d;
  for (; rows != 0; rows &= rows - 1)
    for (int lane = 0; lane < kBrickEdge; lane += static_cast<int>(hn::Lanes(d)))
      value(std::countr_zero(rows) * kBrickEdge + lane);
}

HWY_INLINE int wideAt(int voxel) {
  return wideOffset((voxel >> 6) + 2, ((voxel >> 3) & 7) + 2, (voxel & 7) + 2);
}

// An axis as the upwind scheme sees it: α(u − β) with the nearer neighbour's value, relative to a base.
struct Axis {
  Row near, alpha2, beta;
};

HWY_INLINE void order(Axis& a, Axis& b) {
  const auto swap = hn::Lt(b.near, a.near);
  const Axis low{hn::IfThenElse(swap, b.near, a.near), hn::IfThenElse(swap, b.alpha2, a.alpha2),
                 hn::IfThenElse(swap, b.beta, a.beta)};
  const Axis high{hn::IfThenElse(swap, a.near, b.near), hn::IfThenElse(swap, a.alpha2, b.alpha2),
                  hn::IfThenElse(swap, a.beta, b.beta)};
  a = low;
  b = high;
}

uint64_t Pass(const float* wide, const uint64_t* frozen, uint64_t rows, float cap, float* out) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d), third = hn::Set(d, 1.0f / 3), second = hn::Set(d, 2.25f);
  const Row unknown = hn::Set(d, kUnknownDistance), bound = hn::Set(d, cap);
  uint64_t changed = 0;
  forRowsOf(rows, [&](int voxel) {
    const int at = wideAt(voxel);
    const Row old = hn::LoadU(d, wide + at);
    const auto kept = rowMask(frozen, voxel);
    // As seen from the voxel's own side of the surface.
    const Row side = hn::And(old, hn::Set(d, -0.0f));
    const auto load = [&](int step) { return hn::Xor(hn::LoadU(d, wide + at + step), side); };
    constexpr int kX = 12 * kWideRow, kY = kWideRow, kZ = 1;
    const Row before[3] = {load(-kX), load(-kY), load(-kZ)}, after[3] = {load(kX), load(kY), load(kZ)};
    const Row nearest[3] = {hn::Min(before[0], after[0]), hn::Min(before[1], after[1]), hn::Min(before[2], after[2])};
    const Row base = hn::Min(hn::Min(nearest[0], nearest[1]), nearest[2]);
    if (hn::AllTrue(d, hn::Or(kept, hn::Ge(base, bound)))) {
      hn::StoreU(old, d, out + voxel);
      return;
    }
    const auto axis = [&](int i, int step) {
      const Row down = load(-2 * step), up = load(2 * step);
      // Of two equal sides the lower next one counts, so that mirroring changes nothing.
      const Row next = hn::IfThenElse(hn::Lt(before[i], after[i]), down,
                                      hn::IfThenElse(hn::Lt(after[i], before[i]), up, hn::Min(down, up)));
      const auto two = hn::Le(next, nearest[i]);
      const Row near = hn::Sub(nearest[i], base), rise = hn::Min(hn::Sub(nearest[i], next), one);
      return Axis{near, hn::IfThenElse(two, second, one),
                  hn::IfThenElse(two, hn::Add(near, hn::Mul(rise, third)), near)};
    };
    Axis a = axis(0, kX), b = axis(1, kY), c = axis(2, kZ);
    order(a, b);
    order(b, c);
    order(a, b);
    // α²(u − β)² summed over the axes that lie upwind is 1.
    Row u = hn::Add(a.beta, hn::Div(one, hn::Sqrt(a.alpha2)));
    Row sumA = a.alpha2, sumB = hn::Mul(a.alpha2, a.beta), sumC = hn::Sub(hn::Mul(sumB, a.beta), one);
    const auto with = [&](const Axis& next) {
      const Row weighted = hn::Mul(next.alpha2, next.beta);
      const auto joins = hn::Gt(u, next.near);
      sumA = hn::Add(sumA, next.alpha2);
      sumB = hn::Add(sumB, weighted);
      sumC = hn::Add(sumC, hn::Mul(weighted, next.beta));
      const Row root = hn::Sub(hn::Mul(sumB, sumB), hn::Mul(sumA, sumC));
      const Row solved = hn::Div(hn::Add(sumB, hn::Sqrt(hn::Max(root, zero))), sumA);
      u = hn::IfThenElse(hn::And(joins, hn::Ge(root, zero)), solved, u);
    };
    with(b);
    with(c);
    u = hn::Add(u, base);
    u = hn::Xor(hn::IfThenElse(hn::Lt(u, bound), u, unknown), side);
    u = hn::IfThenElse(kept, old, u);
    changed |= uint64_t{!hn::AllTrue(d, hn::Eq(u, old))} << (voxel >> 3);
    hn::StoreU(u, d, out + voxel);
  });
  return changed;
}

void Feet(const float* wide, uint64_t rows, float* foot, float (&box)[2][3]) {
  const RowTag d;
  const Row zero = hn::Zero(d), far = hn::Set(d, kUnknownDistance), least = hn::Set(d, 1e-4f);
  Row lowest[3] = {far, far, far}, highest[3] = {hn::Neg(far), hn::Neg(far), hn::Neg(far)};
  forRowsOf(rows, [&](int voxel) {
    const int at = wideAt(voxel);
    const Row u = hn::LoadU(d, wide + at), twice = hn::Add(u, u);
    const auto slope = [&](int step) {
      const Row before = hn::LoadU(d, wide + at - step), after = hn::LoadU(d, wide + at + step);
      const Row low = hn::IfThenElse(hn::Ge(before, far), hn::Sub(twice, after), before);
      const Row high = hn::IfThenElse(hn::Ge(after, far), hn::Sub(twice, before), after);
      return hn::Sub(high, low);
    };
    const Row gx = slope(12 * kWideRow), gy = slope(kWideRow), gz = slope(1);
    const Row length2 = hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz));
    const auto known = hn::And(hn::Lt(u, far), hn::Gt(length2, least));
    const Row scale = hn::IfThenElse(known, hn::Neg(hn::Div(u, hn::Sqrt(hn::Max(length2, least)))), zero);
    const auto one = [&](int axis, Row value, Row place) {
      hn::StoreU(value, d, foot + axis * kBrickVoxels + voxel);
      const Row end = hn::Add(place, value);
      lowest[axis] = hn::Min(lowest[axis], hn::IfThenElse(hn::Lt(u, far), end, far));
      highest[axis] = hn::Max(highest[axis], hn::IfThenElse(hn::Lt(u, far), end, hn::Neg(far)));
    };
    one(0, hn::Mul(gx, scale), hn::Set(d, static_cast<float>(voxel >> 6) - 3.5f));
    one(1, hn::Mul(gy, scale), hn::Set(d, static_cast<float>((voxel >> 3) & 7) - 3.5f));
    one(2, hn::Mul(gz, scale), hn::Iota(d, static_cast<float>(voxel & 7) - 3.5f));
  });
  for (int axis = 0; axis < 3; ++axis) {
    box[0][axis] = hn::GetLane(hn::MinOfLanes(d, lowest[axis]));
    box[1][axis] = hn::GetLane(hn::MaxOfLanes(d, highest[axis]));
  }
}

void Parts(const float* padded, const float* weight, const float (&origin)[3], SurfaceParts& parts) {
  const RowTag d;
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f);
  forRows([&](int voxel) {
    const int x = voxel >> 6, y = (voxel >> 3) & 7, z = voxel & 7, at = paddedOffset(x + 1, y + 1, z + 1);
    const Row phi = hn::LoadU(d, padded + at), t = hn::Abs(phi), out = hn::Sub(two, t);
    const Row near = hn::Sub(hn::Set(d, 2.0f / 3), hn::Mul(hn::Mul(t, t), hn::Sub(one, hn::Mul(hn::Set(d, 0.5f), t))));
    const Row far = hn::Mul(hn::Mul(hn::Mul(out, out), out), hn::Set(d, 1.0f / 6));
    const Row spline = hn::IfThenElse(hn::Lt(t, one), near, hn::IfThenElse(hn::Lt(t, two), far, zero));
    const Row w = hn::Mul(hn::LoadU(d, weight + voxel), spline);
    if (hn::AllFalse(d, hn::Gt(w, zero))) {
      hn::StoreU(zero, d, parts.weight + voxel);
      return;
    }
    const auto slope = [&](int step) {
      return hn::Sub(hn::LoadU(d, padded + at + step), hn::LoadU(d, padded + at - step));
    };
    const Row g[3] = {slope(10 * kPaddedRow), slope(kPaddedRow), slope(1)};
    const Row length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(g[0], g[0]), hn::Mul(g[1], g[1])), hn::Mul(g[2], g[2])));
    hn::StoreU(hn::IfThenElseZero(hn::Gt(length, hn::Set(d, 0.2f)), w), d, parts.weight + voxel);
    const Row middle[3] = {hn::Set(d, static_cast<float>(x) - 3.5f), hn::Set(d, static_cast<float>(y) - 3.5f),
                           hn::Iota(d, static_cast<float>(z) - 3.5f)};
    for (int axis = 0; axis < 3; ++axis) {
      const Row normal = hn::Div(g[axis], length);
      hn::StoreU(normal, d, parts.normal[axis] + voxel);
      hn::StoreU(hn::Sub(hn::Sub(middle[axis], hn::Set(d, origin[axis])), hn::Mul(normal, phi)), d,
                 parts.place[axis] + voxel);
    }
  });
}

void SumParts(const SurfacePart* parts, size_t count, const float* facing, double* sums) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  constexpr size_t kLanes = hn::MaxLanes(d), kVectors = 8 / kLanes;
  // What is added to this number is rounded to a multiple of 2⁻¹⁸.
  const auto rounds = hn::Set(d, 1.5 * static_cast<double>(uint64_t{1} << (52 - 18)));
  hn::Vec<decltype(d)> sum[kVectors];
  for (size_t k = 0; k < kVectors; ++k) sum[k] = hn::LoadU(d, sums + k * kLanes);
  for (size_t i = 0; i < count; ++i) {
    const SurfacePart& part = parts[i];
    float w = part.weight;
    if (facing) {
      const float* n = part.normal;
      const float cosine = std::max((n[0] * facing[0] + n[1] * facing[1]) + n[2] * facing[2], 0.0f),
                  square = cosine * cosine;
      w *= square * square;
    }
    const auto weight = hn::Set(df, w);
    for (size_t k = 0; k < kVectors; ++k) {
      const auto term = hn::PromoteTo(d, hn::Mul(hn::LoadU(df, &part.one + k * kLanes), weight));
      sum[k] = hn::Add(sum[k], hn::Sub(hn::Add(term, rounds), rounds));
    }
  }
  for (size_t k = 0; k < kVectors; ++k) hn::StoreU(sum[k], d, sums + k * kLanes);
}

void LevelRises(const float* broad, float band, const float* weight, const LevelPlane& p, float* height, float* rise,
                uint64_t* moves) {
  const RowTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f), most = hn::Set(d, p.most), nx = hn::Set(d, p.nx),
            ny = hn::Set(d, p.ny), nz = hn::Set(d, p.nz);
  // What may not happen would have to be more than everything.
  const Row least = hn::Set(d, p.up ? 0.0f : p.most * 2), lowest = hn::Set(d, p.down ? 0.0f : p.most * 2);
  std::fill(moves, moves + kBrickEdge, uint64_t{0});
  for (int voxel = 0; voxel < kBrickVoxels; voxel += lanes) {
    const Row w = hn::LoadU(d, weight + voxel);
    const int x = voxel >> 6, y = (voxel >> 3) & 7, z = voxel & 7;
    const float* at = broad + broadOffset(x + 4, y + 4, z + 4);
    const Row phi = hn::LoadU(d, at);
    auto may = hn::And(hn::Gt(w, zero), hn::Lt(hn::Abs(phi), hn::Set(d, band)));
    if (hn::AllFalse(d, may)) continue;
    const float across = p.nx * (static_cast<float>(x) - 3.5f) + p.ny * (static_cast<float>(y) - 3.5f);
    const Row goal = hn::Sub(hn::Add(hn::Set(d, across), hn::Mul(nz, hn::Iota(d, static_cast<float>(z) - 3.5f))),
                             hn::Set(d, p.offset));
    const auto slope = [&](int step) HWY_ATTR { return hn::Sub(hn::LoadU(d, at + step), hn::LoadU(d, at - step)); };
    const Row gx = slope(16 * kBroadRow), gy = slope(kBroadRow), gz = slope(1);
    const Row length2 = hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz)),
              along = hn::Add(hn::Add(hn::Mul(gx, nx), hn::Mul(gy, ny)), hn::Mul(gz, nz));
    // From the plane to the surface along its normal: of what faces away there is nothing to move.
    const Row facing = hn::Min(hn::Max(hn::Div(along, hn::Sqrt(hn::Max(length2, hn::Set(d, 0.04f)))), zero), one);
    const Row share = hn::Mul(w, hn::Set(d, p.share));
    Row way = hn::Sub(hn::Mul(phi, facing), goal);
    if (p.done > 0) {
      // Earlier parts went their share of that; only what lay farther off has a way left.
      const Row left = hn::Sub(hn::Abs(way), hn::Mul(hn::Set(d, p.done), hn::Sub(one, share)));
      way = hn::CopySign(hn::Max(left, zero), way);
    }
    way = hn::Min(hn::Max(way, hn::Neg(most)), most);
    const Row moved = hn::Mul(way, share);
    may = hn::And(may, hn::Or(hn::Gt(moved, least), hn::Lt(moved, hn::Neg(lowest))));
    hn::StoreU(goal, d, height + voxel);
    hn::StoreU(moved, d, rise + voxel);
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, may, bits);
    moves[x] |= uint64_t{bits[0]} << (y * 8 + z);
  }
}

// Weight of a ball swept over a row of places, from its beginning.
HWY_INLINE Row weightAt(const SweptBall& b, int shape, Row vx, Row vy, Row vz) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const Row dx = hn::Set(d, b.dx), dy = hn::Set(d, b.dy), dz = hn::Set(d, b.dz);
  const Row along = hn::Add(hn::Add(hn::Mul(vx, dx), hn::Mul(vy, dy)), hn::Mul(vz, dz));
  const Row t = hn::Min(hn::Max(hn::Mul(along, hn::Set(d, b.inverseLength2)), zero), one);
  const Row ex = hn::Sub(vx, hn::Mul(t, dx)), ey = hn::Sub(vy, hn::Mul(t, dy)), ez = hn::Sub(vz, hn::Mul(t, dz));
  const Row squared = hn::Add(hn::Add(hn::Mul(ex, ex), hn::Mul(ey, ey)), hn::Mul(ez, ez));
  const Row radius = hn::Add(hn::Set(d, b.radius), hn::Mul(t, hn::Set(d, b.growth)));
  const Row t2 = hn::Div(squared, hn::Mul(radius, radius)), rest2 = hn::Max(hn::Sub(one, t2), zero);
  switch (shape) {
    case 0:
      return hn::Min(hn::Max(hn::Mul(hn::Sub(radius, hn::Sqrt(squared)), hn::Set(d, 0.5f)), zero), one);
    case 1:
      return hn::Mul(rest2, rest2);
    case 2:
      return hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
    case 3: {
      const Row rest = hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
      return hn::Mul(rest, rest);
    }
    default:
      return hn::Sqrt(rest2);
  }
}

void Weights(const SweptBall& b, int shape, float strength, const float* foot, float* weight) {
  const RowTag d;
  forRows([&](int voxel) {
    const Row vx = hn::Add(hn::Set(d, static_cast<float>(voxel >> 6) - 3.5f - b.ax), hn::LoadU(d, foot + voxel));
    const Row vy = hn::Add(hn::Set(d, static_cast<float>((voxel >> 3) & 7) - 3.5f - b.ay),
                           hn::LoadU(d, foot + kBrickVoxels + voxel));
    const Row z = hn::Iota(d, static_cast<float>(voxel & 7) - 3.5f);
    const Row vz = hn::Add(hn::Sub(z, hn::Set(d, b.az)), hn::LoadU(d, foot + 2 * kBrickVoxels + voxel));
    const Row w = weightAt(b, shape, vx, vy, vz);
    hn::StoreU(hn::Max(hn::Mul(w, hn::Set(d, strength)), hn::LoadU(d, weight + voxel)), d, weight + voxel);
  });
}

void RaiseAtFeet(const float* broad, float band, std::span<const WeighedBall> balls, int shape, float gain,
                 float* phi) {
  constexpr int kAxes[3] = {16 * kBroadRow, kBroadRow, 1};
  const RowTag d;
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f), edge = hn::Set(d, band), least = hn::Set(d, 1e-4f);
  const Row side = hn::Set(d, gain < 0 ? -1.0f : 1.0f);
  const auto isKnown = [&](Row value) { return hn::Lt(hn::Abs(value), edge); };
  forRows([&](int voxel) {
    const int at = broadOffset((voxel >> 6) + 4, ((voxel >> 3) & 7) + 4, (voxel & 7) + 4);
    const Row own = hn::LoadU(d, broad + at);
    const auto unknown = hn::Ge(hn::Mul(side, own), edge);
    auto known = isKnown(own);
    Row u = own;
    if (!hn::AllFalse(d, unknown)) {
      // Next to what is known: on as the two voxels along an axis go, the mean of all that say something.
      Row sum = zero, count = zero;
      for (const int axis : kAxes) {
        const auto along = [&](int step, Row& there) {
          const Row near = hn::LoadU(d, broad + at + step), far = hn::LoadU(d, broad + at + 2 * step);
          const auto both = hn::And(isKnown(near), isKnown(far));
          there = hn::IfThenElseZero(both, one);
          return hn::IfThenElseZero(both, hn::Sub(hn::Add(near, near), far));
        };
        Row below, above;
        const Row fromBelow = along(-axis, below), fromAbove = along(axis, above);
        sum = hn::Add(sum, hn::Add(fromBelow, fromAbove));
        count = hn::Add(count, hn::Add(below, above));
      }
      const auto told = hn::And(unknown, hn::Gt(count, zero));
      const Row mean = hn::Mul(side, hn::Max(hn::Mul(side, hn::Div(sum, hn::Max(count, one))), edge));
      u = hn::IfThenElse(told, mean, own);
      known = hn::Or(known, told);
    }
    if (hn::AllFalse(d, known)) return hn::StoreU(own, d, phi + voxel);
    // Continues the difference of the other side where one side is not known.
    const Row twice = hn::Add(u, u);
    Row way[3], length2 = zero;
    for (int k = 0; k < 3; ++k) {
      const Row before = hn::LoadU(d, broad + at - kAxes[k]), after = hn::LoadU(d, broad + at + kAxes[k]);
      const Row low = hn::IfThenElse(isKnown(before), before, hn::Sub(twice, after));
      const Row high = hn::IfThenElse(isKnown(after), after, hn::Sub(twice, before));
      way[k] = hn::Sub(high, low);
      length2 = hn::Add(length2, hn::Mul(way[k], way[k]));
    }
    const Row scale =
        hn::IfThenElse(hn::Gt(length2, least), hn::Neg(hn::Div(u, hn::Sqrt(hn::Max(length2, least)))), zero);
    for (Row& each : way) each = hn::Mul(each, scale);
    Row weight = zero;
    for (const WeighedBall& each : balls) {
      const SweptBall& b = each.ball;
      const Row x = hn::Add(hn::Set(d, static_cast<float>(voxel >> 6) - 3.5f - b.ax), way[0]);
      const Row y = hn::Add(hn::Set(d, static_cast<float>((voxel >> 3) & 7) - 3.5f - b.ay), way[1]);
      const Row z = hn::Add(hn::Sub(hn::Iota(d, static_cast<float>(voxel & 7) - 3.5f), hn::Set(d, b.az)), way[2]);
      weight = hn::Max(weight, hn::Mul(weightAt(b, shape, x, y, z), hn::Set(d, each.strength)));
    }
    const Row raised = hn::Sub(u, hn::Mul(weight, hn::Set(d, gain)));
    hn::StoreU(hn::IfThenElse(known, raised, own), d, phi + voxel);
  });
}

bool Heights(const float* weight, float gain, float limit, const uint64_t* mask, float* height) {
  const RowTag d;
  const Row zero = hn::Zero(d), most = hn::Set(d, limit), times = hn::Set(d, gain);
  auto any = hn::Lt(zero, zero);
  forRows([&](int voxel) {
    const Row w = hn::LoadU(d, weight + voxel), old = hn::LoadU(d, height + voxel);
    const auto mine = hn::And(rowMask(mask, voxel), hn::Gt(w, zero));
    const Row next = hn::Min(hn::Add(old, hn::Mul(w, times)), most);
    any = hn::Or(any, hn::And(mine, hn::Gt(next, old)));
    hn::StoreU(hn::IfThenElse(mine, next, old), d, height + voxel);
  });
  return !hn::AllFalse(d, any);
}

void Raised(const float* u, const float* padded, float side, float* phi) {
  const RowTag d;
  // Beyond this slope the height jumps from voxel to voxel and says nothing about a distance.
  const Row one = hn::Set(d, 1.0f), quarter = hn::Set(d, 0.25f), steepest = hn::Set(d, 25.0f), sign = hn::Set(d, side);
  forRows([&](int voxel) {
    const int at = paddedOffset((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, (voxel & 7) + 1);
    const Row h = hn::LoadU(d, padded + at);
    const auto slope = [&](int step) {
      return hn::Sub(hn::LoadU(d, padded + at + step), hn::LoadU(d, padded + at - step));
    };
    const Row gx = slope(10 * kPaddedRow), gy = slope(kPaddedRow), gz = slope(1);
    const Row squared = hn::Mul(hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz)), quarter);
    const Row value = hn::Div(hn::Sub(hn::LoadU(d, u + voxel), h), hn::Sqrt(hn::Add(one, hn::Min(squared, steepest))));
    const auto raised = hn::And(hn::Gt(h, hn::Zero(d)), hn::Lt(hn::LoadU(d, u + voxel), hn::Set(d, kUnknownDistance)));
    hn::StoreU(hn::IfThenElse(raised, hn::Mul(value, sign), hn::LoadU(d, phi + voxel)), d, phi + voxel);
  });
}

void StartWide(const float* broad, const float* near, const uint64_t* frozen, float band, float* wide) {
  const RowTag d;
  const Row zero = hn::Zero(d), unknown = hn::Set(d, kUnknownDistance), known = hn::Set(d, band);
  // Sizes with the sign that says which side: zero counts as outside.
  const auto sided = [&](Row size, Row phi) { return hn::IfThenElse(hn::Lt(phi, zero), hn::Neg(size), size); };
  const int lanes = static_cast<int>(hn::Lanes(d));
  // What a row's last vector writes too much, the next row writes again.
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      for (int z = 0; z < 12; z += lanes) {
        const Row phi = hn::LoadU(d, broad + broadOffset(x + 2, y + 2, z + 2)), size = hn::Abs(phi);
        hn::StoreU(sided(hn::IfThenElse(hn::Lt(size, known), size, unknown), phi), d, wide + wideOffset(x, y, z));
      }
  forRows([&](int voxel) {
    const int x = voxel >> 6, y = (voxel >> 3) & 7, z = voxel & 7;
    const Row phi = hn::LoadU(d, broad + broadOffset(x + 4, y + 4, z + 4));
    const Row u = hn::LoadU(d, near + paddedOffset(x + 1, y + 1, z + 1));
    hn::StoreU(sided(hn::IfThenElse(rowMask(frozen, voxel), u, unknown), phi), d, wide + wideAt(voxel));
  });
}

bool Steep(const float* padded, float most) {
  const RowTag d;
  Row largest = hn::Zero(d);
  forRows([&](int voxel) {
    const float* at = padded + paddedOffset((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, (voxel & 7) + 1);
    const Row own = hn::LoadU(d, at);
    for (const int step : {10 * kPaddedRow, kPaddedRow, 1})
      for (const int to : {-step, step}) largest = hn::Max(largest, hn::Abs(hn::Sub(hn::LoadU(d, at + to), own)));
  });
  return hn::GetLane(hn::MaxOfLanes(d, largest)) > most;
}

bool SlopeOne(const float* values, float within, float tolerance) {
  constexpr uint64_t kCells = 0x007f7f7f7f7f7f7fu;  // whose eight corners lie in the brick
  constexpr uint64_t kWords[kBrickEdge] = {kCells, kCells, kCells, kCells, kCells, kCells, kCells, 0};
  const RowTag d;
  // Four times the slope, squared; eight times the middle.
  const Row near = hn::Set(d, 8 * within), least = hn::Set(d, 16 * (1 - tolerance) * (1 - tolerance)),
            most = hn::Set(d, 16 * (1 + tolerance) * (1 + tolerance));
  const int lanes = static_cast<int>(hn::Lanes(d));
  float own[kBrickVoxels + 1];  // A cell's last lane counts nothing, but is read.
  std::copy_n(values, kBrickVoxels, own);
  own[kBrickVoxels] = 0;
  Row off = hn::Zero(d);
  for (int x = 0; x < kBrickEdge - 1; ++x)
    for (int row = 64 * x; row < 64 * x + 7 * kBrickEdge; row += lanes) {
      const auto at = [&](int step) { return hn::LoadU(d, own + row + step); };
      const Row a = at(0), b = at(1), c = at(8), e = at(9), f = at(64), g = at(65), h = at(72), i = at(73);
      const Row ab = hn::Add(a, b), ce = hn::Add(c, e), fg = hn::Add(f, g), hi = hn::Add(h, i);
      const Row gx = hn::Sub(hn::Add(fg, hi), hn::Add(ab, ce)), gy = hn::Sub(hn::Add(ce, hi), hn::Add(ab, fg)),
                gz = hn::Add(hn::Add(hn::Sub(b, a), hn::Sub(e, c)), hn::Add(hn::Sub(g, f), hn::Sub(i, h)));
      const Row squared = hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz)),
                middle = hn::Add(hn::Add(ab, ce), hn::Add(fg, hi));
      const auto counts = hn::And(rowMask(kWords, row), hn::Lt(hn::Abs(middle), near));
      const auto differs = hn::And(counts, hn::Or(hn::Lt(squared, least), hn::Gt(squared, most)));
      off = hn::Or(off, hn::IfThenElseZero(differs, least));
    }
  return hn::AllTrue(d, hn::Eq(off, hn::Zero(d)));
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Pass);
HWY_EXPORT(Feet);
HWY_EXPORT(Parts);
HWY_EXPORT(LevelRises);
HWY_EXPORT(SumParts);
HWY_EXPORT(Weights);
HWY_EXPORT(RaiseAtFeet);
HWY_EXPORT(Heights);
HWY_EXPORT(Raised);
HWY_EXPORT(StartWide);
HWY_EXPORT(Steep);
HWY_EXPORT(SlopeOne);

uint64_t widePass(const float* wide, const uint64_t* frozen, uint64_t rows, float cap, float* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(Pass)(wide, frozen, rows, cap, out);
}
void wideFeet(const float* wide, uint64_t rows, float* foot, float (&box)[2][3]) noexcept {
  HWY_DYNAMIC_DISPATCH(Feet)(wide, rows, foot, box);
}
void surfaceParts(const float* padded, const float* weight, const float (&origin)[3], SurfaceParts& parts) noexcept {
  HWY_DYNAMIC_DISPATCH(Parts)(padded, weight, origin, parts);
}
void sumParts(std::span<const SurfacePart> parts, const float* facing, double (&sums)[8]) noexcept {
  HWY_DYNAMIC_DISPATCH(SumParts)(parts.data(), parts.size(), facing, sums);
}
void levelRises(const float* broad, float band, const float* weight, const LevelPlane& plane, float* height,
                float* rise, uint64_t (&moves)[kBrickEdge]) noexcept {
  HWY_DYNAMIC_DISPATCH(LevelRises)(broad, band, weight, plane, height, rise, moves);
}
void footWeights(const SweptBall& ball, int shape, float strength, const float* foot, float* weight) noexcept {
  HWY_DYNAMIC_DISPATCH(Weights)(ball, shape, strength, foot, weight);
}
void raiseAtFeet(const float* broad, float band, std::span<const WeighedBall> balls, int shape, float gain,
                 float* phi) noexcept {
  HWY_DYNAMIC_DISPATCH(RaiseAtFeet)(broad, band, balls, shape, gain, phi);
}
bool raiseHeights(const float* weight, float gain, float limit, const uint64_t* mask, float* height) noexcept {
  return HWY_DYNAMIC_DISPATCH(Heights)(weight, gain, limit, mask, height);
}
void raisedDistances(const float* u, const float* padded, float side, float* phi) noexcept {
  HWY_DYNAMIC_DISPATCH(Raised)(u, padded, side, phi);
}
void startWide(const float* broad, const float* near, const uint64_t* frozen, float band, float* wide) noexcept {
  HWY_DYNAMIC_DISPATCH(StartWide)(broad, near, frozen, band, wide);
}
bool isSteep(const float* padded, float most) noexcept {
  return HWY_DYNAMIC_DISPATCH(Steep)(padded, most);
}
bool isSlopeOne(const float* values, float within, float tolerance) noexcept {
  return HWY_DYNAMIC_DISPATCH(SlopeOne)(values, within, tolerance);
}

}  // namespace argil::clay
#endif
