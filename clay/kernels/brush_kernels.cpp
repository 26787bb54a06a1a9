#include "clay/kernels/brush_kernels.h"

#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/brush_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A row of eight voxels along z: whole in one vector where the target has it, else in parts.
using RowTag = hn::CappedTag<float, kBrickEdge>;
using Row = hn::Vec<RowTag>;

HWY_INLINE void storeBits(hn::Mask<RowTag> mask, int lane, uint8_t* row) {
  const RowTag d;
  uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  *row = static_cast<uint8_t>(*row | (bits[0] << lane));
}

HWY_INLINE hn::Mask<RowTag> loadBits(int lane, uint8_t row) {
  const RowTag d;
  const uint8_t bits[8] = {static_cast<uint8_t>(row >> lane)};
  return hn::LoadMaskBits(d, bits);
}

// Squared distance from voxels (x, y, z + lane), from the brick's middle, to the segment.
struct FromSegment {
  Row squared, radius;  // of the distance; the ball's where it is nearest
};

HWY_INLINE FromSegment fromSegment(const SweptBall& b, float x, float y, Row z) {
  const RowTag d;
  const float vx = x - b.ax, vy = y - b.ay;
  const Row vz = hn::Sub(z, hn::Set(d, b.az));
  const Row along = hn::Add(hn::Set(d, vx * b.dx + vy * b.dy), hn::Mul(vz, hn::Set(d, b.dz)));
  const Row t = hn::Min(hn::Max(hn::Mul(along, hn::Set(d, b.inverseLength2)), hn::Zero(d)), hn::Set(d, 1.0f));
  const Row ex = hn::Sub(hn::Set(d, vx), hn::Mul(t, hn::Set(d, b.dx)));
  const Row ey = hn::Sub(hn::Set(d, vy), hn::Mul(t, hn::Set(d, b.dy)));
  const Row ez = hn::Sub(vz, hn::Mul(t, hn::Set(d, b.dz)));
  return {hn::Add(hn::Add(hn::Mul(ex, ex), hn::Mul(ey, ey)), hn::Mul(ez, ez)),
          hn::Add(hn::Set(d, b.radius), hn::Mul(t, hn::Set(d, b.growth)))};
}

// Less than zero inside of the swept ball.
HWY_INLINE Row outsideOf(const SweptBall& b, float x, float y, Row z) {
  const FromSegment from = fromSegment(b, x, y, z);
  return hn::Sub(hn::Sqrt(from.squared), from.radius);
}

template <class Value>
HWY_INLINE BrickChange forRows(float band, const float* phi, FloatBrick& out, const Value& value) {
  const RowTag d;
  const Row bound = hn::Set(d, band), zero = hn::Zero(d);
  auto* bits = reinterpret_cast<uint8_t*>(out.inside);
  auto changed = hn::Lt(zero, zero), inBand = changed;  // no lane yet
  for (int row = 0; row < kBrickVoxels / 8; ++row) {
    bits[row] = 0;
    for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
      const auto at = static_cast<ptrdiff_t>(row) * 8 + static_cast<ptrdiff_t>(lane);
      const Row old = hn::LoadU(d, phi + at);
      // + 0 turns −0 into 0.
      const Row next = hn::Add(value(old, at), zero);
      changed = hn::Or(changed, hn::Ne(next, old));
      inBand = hn::Or(inBand, hn::Lt(hn::Abs(next), bound));
      storeBits(hn::Lt(next, zero), static_cast<int>(lane), bits + row);
      hn::StoreU(next, d, out.value + at);
    }
  }
  return {!hn::AllFalse(d, changed), !hn::AllFalse(d, inBand)};
}

BrickChange TakeAway(const float* solid, float band, const float* phi, FloatBrick& out) {
  const RowTag d;
  const Row bound = hn::Set(d, band);
  return forRows(band, phi, out, [&](Row old, ptrdiff_t at) {
    return hn::Min(hn::Max(old, hn::Neg(hn::LoadU(d, solid + at))), bound);
  });
}

BrickChange LayOn(const float* solid, float band, const float* phi, FloatBrick& out) {
  const RowTag d;
  const Row bound = hn::Set(d, -band);
  return forRows(band, phi, out,
                 [&](Row old, ptrdiff_t at) { return hn::Max(hn::Min(old, hn::LoadU(d, solid + at)), bound); });
}

bool Meet(const float* phi, const float* solid, float sign, float band, float most) {
  const RowTag d;
  const Row bound = hn::Set(d, band), limit = hn::Set(d, most), unknown = hn::Set(d, HUGE_VALF),
            side = hn::Set(d, sign), last = hn::Set(d, 7.0f);
  // Where one of them is not known the difference is infinite, and that of two such is no number: neither counts.
  float apart[kBrickVoxels + 8];
  auto any = hn::Lt(bound, bound);
  for (int at = 0; at < kBrickVoxels; at += static_cast<int>(hn::Lanes(d))) {
    const Row a = hn::LoadU(d, phi + at), b = hn::LoadU(d, solid + at);
    const auto both = hn::And(hn::Lt(hn::Abs(a), bound), hn::Lt(hn::Abs(b), bound));
    any = hn::Or(any, both);
    hn::StoreU(hn::IfThenElse(both, hn::Sub(a, hn::Mul(side, b)), unknown), d, apart + at);
  }
  if (hn::AllFalse(d, any)) return false;
  for (int i = 0; i < 8; ++i) apart[kBrickVoxels + i] = HUGE_VALF;
  auto meet = hn::Lt(bound, bound);
  for (int at = 0; at < kBrickVoxels; at += static_cast<int>(hn::Lanes(d))) {
    const Row here = hn::LoadU(d, apart + at);
    const auto differs = [&](int step) {
      const Row by = hn::Abs(hn::Sub(hn::LoadU(d, apart + at + step), here));
      return hn::And(hn::Gt(by, limit), hn::Lt(by, hn::Set(d, HUGE_VALF)));
    };
    if (at < 448) meet = hn::Or(meet, differs(64));
    if ((at & 56) < 56) meet = hn::Or(meet, differs(8));
    meet = hn::Or(meet, hn::And(differs(1), hn::Lt(hn::Iota(d, static_cast<float>(at & 7)), last)));
  }
  return !hn::AllFalse(d, meet);
}

BrickChange Seal(const float* source, float band, FloatBrick& out, float& most) {
  const RowTag d;
  const Row bound = hn::Set(d, band);
  Row largest = hn::Zero(d);
  const float* mine = out.value;
  const BrickChange change = forRows(band, source, out, [&](Row old, ptrdiff_t at) {
    const Row next = hn::Min(hn::Max(hn::LoadU(d, mine + at), hn::Neg(bound)), bound);
    largest = hn::Max(largest, hn::Abs(hn::Sub(next, old)));
    return next;
  });
  most = hn::GetLane(hn::MaxOfLanes(d, largest));
  return change;
}

template <class Value>
HWY_INLINE void forVoxels(const Value& value) {
  const RowTag d;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (size_t lane = 0; lane < 8; lane += hn::Lanes(d))
        value(static_cast<float>(x) - 3.5f, static_cast<float>(y) - 3.5f, hn::Iota(d, static_cast<float>(lane) - 3.5f),
              x * 64 + y * 8 + static_cast<int>(lane));
}

void Weights(const SweptBall& ball, int shape, float strength, float* weight, uint64_t rows) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  forVoxels([&](float x, float y, Row z, int at) {
    if ((rows >> (at / kBrickEdge) & 1) == 0) return;
    const FromSegment from = fromSegment(ball, x, y, z);
    const Row t2 = hn::Div(from.squared, hn::Mul(from.radius, from.radius));
    Row w = one;
    switch (shape) {
      case 0:
        break;
      case 1: {
        const Row rest = hn::Max(hn::Sub(one, t2), zero);
        w = hn::Mul(rest, rest);
        break;
      }
      case 2:
        w = hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
        break;
      case 3: {
        const Row rest = hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
        w = hn::Mul(rest, rest);
        break;
      }
      default:
        w = hn::Sqrt(hn::Max(hn::Sub(one, t2), zero));
    }
    w = hn::IfThenElse(hn::Lt(t2, one), hn::Mul(w, hn::Set(d, strength)), zero);
    hn::StoreU(hn::Max(w, hn::LoadU(d, weight + at)), d, weight + at);
  });
}

uint64_t RowsWithin(const float* phi, float within) {
  const RowTag d;
  uint64_t rows = 0;
  for (int at = 0; at < kBrickVoxels; at += static_cast<int>(hn::Lanes(d))) {
    const bool any = !hn::AllFalse(d, hn::Lt(hn::Abs(hn::LoadU(d, phi + at)), hn::Set(d, within)));
    rows |= uint64_t{any} << (at / kBrickEdge);
  }
  return rows;
}

void Distances(const SweptBall& ball, float* distance) {
  const RowTag d;
  forVoxels([&](float x, float y, Row z, int at) { hn::StoreU(outsideOf(ball, x, y, z), d, distance + at); });
}

HWY_INLINE Row binomialZ(const float* at) {
  const RowTag d;
  const Row centre = hn::LoadU(d, at);
  return hn::Add(hn::Add(hn::LoadU(d, at - 1), hn::LoadU(d, at + 1)), hn::Add(centre, centre));
}

HWY_INLINE Row binomialYZ(const float* at) {
  const Row centre = binomialZ(at);
  return hn::Add(hn::Add(binomialZ(at - kPaddedRow), binomialZ(at + kPaddedRow)), hn::Add(centre, centre));
}

void Smooth(const float* padded, const float* weight, float amount, float band, float* out) {
  const RowTag d;
  const Row bound = hn::Set(d, band), share = hn::Set(d, 1.0f / 64);
  forVoxels([&](float, float, Row, int voxel) {
    const float* at = padded + paddedOffset((voxel >> 6) + 1, ((voxel >> 3) & 7) + 1, 1) + (voxel & 7);
    const Row old = hn::LoadU(d, at), centre = binomialYZ(at);
    const Row sum =
        hn::Add(hn::Add(binomialYZ(at - 10 * kPaddedRow), binomialYZ(at + 10 * kPaddedRow)), hn::Add(centre, centre));
    const Row mean = hn::Mul(sum, share);
    const Row w = hn::Mul(hn::LoadU(d, weight + voxel), hn::Set(d, amount));
    const Row next = hn::Add(old, hn::Mul(w, hn::Sub(mean, old)));
    hn::StoreU(hn::IfThenElse(hn::Lt(hn::Abs(old), bound), next, old), d, out + voxel);
  });
}

bool Bound(const float* phi, const float* weight, float band, float most, float* made) {
  const RowTag d;
  const Row bound = hn::Set(d, band), up = hn::Set(d, most), down = hn::Set(d, -most), zero = hn::Zero(d);
  auto good = hn::Eq(zero, zero);
  for (int i = 0; i < kBrickVoxels; i += static_cast<int>(hn::Lanes(d))) {
    const Row value = hn::LoadU(d, phi + i), change = hn::Sub(hn::LoadU(d, made + i), value);
    const auto counts = hn::And(hn::Gt(hn::LoadU(d, weight + i), zero), hn::Lt(hn::Abs(value), bound));
    good = hn::And(good, hn::Or(hn::IsFinite(change), hn::Not(counts)));
    const Row moved = hn::Add(value, hn::Min(hn::Max(change, down), up));
    hn::StoreU(hn::IfThenElse(counts, moved, value), d, made + i);
  }
  return hn::AllTrue(d, good);
}

void Bits(const float* phi, float band, uint64_t* bits) {
  const RowTag d;
  const Row most = hn::Set(d, band);
  std::fill_n(bits, kBrickEdge, 0);
  for (int voxel = 0; voxel < kBrickVoxels; voxel += static_cast<int>(hn::Lanes(d))) {
    uint8_t some[8] = {};
    hn::StoreMaskBits(d, hn::Lt(hn::Abs(hn::LoadU(d, phi + voxel)), most), some);
    bits[voxel >> 6] |= uint64_t{some[0]} << (voxel & 63);
  }
}

void Start(const float* padded, float band, uint64_t* frozen, float* u) {
  const RowTag d;
  const Row bound = hn::Set(d, band), zero = hn::Zero(d);
  for (int at = 0; at < kPaddedSize; at += static_cast<int>(hn::Lanes(d)))
    hn::StoreU(hn::Abs(hn::LoadU(d, padded + at)), d, u + at);
  auto* bits = reinterpret_cast<uint8_t*>(frozen);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) {
      uint8_t* row = bits + x * 8 + y;
      *row = 0;
      for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
        const int at = paddedOffset(x + 1, y + 1, 1) + static_cast<int>(lane);
        const auto inside = [&](int step) { return hn::Lt(hn::LoadU(d, padded + at + step), zero); };
        const auto in = inside(0);
        const auto differs = [&](int step) { return hn::Or(hn::Xor(in, inside(-step)), hn::Xor(in, inside(step))); };
        const auto beside = hn::Or(hn::Or(differs(1), differs(kPaddedRow)), differs(10 * kPaddedRow));
        storeBits(beside, static_cast<int>(lane), row);
        hn::StoreU(hn::IfThenElse(beside, hn::LoadU(d, u + at), bound), d, u + at);
      }
    }
}

// Both ends of a plane of any slope come out exact: the slopes taken are those of the edge that the surface crosses,
// else those towards the surface.
void RenewNear(const float* padded, const uint64_t* frozen, float least, float* u) {
  const RowTag d;
  const Row zero = hn::Zero(d), tiny = hn::Set(d, 1e-12f), half = hn::Set(d, 0.5f), low = hn::Set(d, 0.7f),
            high = hn::Set(d, 2.2f);
  const auto* bits = reinterpret_cast<const uint8_t*>(frozen);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) {
      if (bits[x * 8 + y] == 0) continue;
      for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
        const int at = paddedOffset(x + 1, y + 1, 1) + static_cast<int>(lane);
        const Row mine = hn::LoadU(d, padded + at), size = hn::Abs(mine);
        const auto in = hn::Lt(mine, zero);
        Row sum = zero;
        auto kink = hn::Lt(zero, zero);
        const auto axis = [&](int step) {
          const Row before = hn::LoadU(d, padded + at - step), after = hn::LoadU(d, padded + at + step);
          const Row down = hn::Abs(hn::Sub(mine, before)), up = hn::Abs(hn::Sub(after, mine));
          const auto crossesDown = hn::Xor(in, hn::Lt(before, zero)), crossesUp = hn::Xor(in, hn::Lt(after, zero));
          const Row across = hn::Max(hn::IfThenElse(crossesDown, down, zero), hn::IfThenElse(crossesUp, up, zero));
          const Row towards = hn::Max(hn::Sub(size, hn::Min(hn::Abs(before), hn::Abs(after))), zero);
          const Row slope = hn::IfThenElse(hn::Or(crossesDown, crossesUp), across, towards);
          sum = hn::Add(sum, hn::Mul(slope, slope));
          kink = hn::Or(kink, hn::Gt(hn::Abs(hn::Sub(up, down)), half));
        };
        axis(10 * kPaddedRow);
        axis(kPaddedRow);
        axis(1);
        // At a crease of true distances one side of the voxel slopes by its plane, the other by another's: what is
        // there is right.
        const auto crease = hn::And(kink, hn::And(hn::Gt(sum, low), hn::Lt(sum, high)));
        const Row renewed = hn::Div(size, hn::Sqrt(hn::Max(sum, tiny)));
        const auto mineToo = hn::And(hn::Ge(size, hn::Set(d, least)),
                                     hn::AndNot(crease, loadBits(static_cast<int>(lane), bits[x * 8 + y])));
        const Row old = hn::LoadU(d, u + at);
        hn::StoreU(hn::IfThenElse(mineToo, hn::Min(renewed, hn::Set(d, 1.5f)), old), d, u + at);
      }
    }
}

BrickChange Settle(const float* phi, const float* u, float band, float tolerance, FloatBrick& out) {
  const RowTag d;
  const Row limit = hn::Set(d, tolerance), zero = hn::Zero(d);
  return forRows(band, phi, out, [&](Row old, ptrdiff_t at) {
    const Row solved = hn::LoadU(d, u + at);
    const Row value = hn::IfThenElse(hn::Lt(old, zero), hn::Neg(solved), solved);
    return hn::IfThenElse(hn::Lt(hn::Abs(hn::Sub(value, old)), limit), old, value);
  });
}

uint64_t Eikonal(const float* padded, const uint64_t* frozen, uint64_t rows, float band, float* out) {
  const RowTag d;
  const Row bound = hn::Set(d, band), one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f), half = hn::Set(d, 0.5f),
            zero = hn::Zero(d);
  const Row third = hn::Set(d, 1.0f / 3), three = hn::Set(d, 3.0f);
  const auto* bits = reinterpret_cast<const uint8_t*>(frozen);
  uint64_t changed = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int row = std::countr_zero(rows), x = row >> 3, y = row & 7;
    for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
      const int at = paddedOffset(x + 1, y + 1, 1) + static_cast<int>(lane);
      float* const to = out + Brick::offset(x, y, static_cast<int>(lane));
      const Row old = hn::LoadU(d, padded + at);
      const auto least = [&](int step) {
        return hn::Min(hn::LoadU(d, padded + at - step), hn::LoadU(d, padded + at + step));
      };
      const Row p = least(10 * kPaddedRow), q = least(kPaddedRow), r = least(1);
      // Where nothing came near yet, nothing follows: the row stays as it is.
      if (hn::AllTrue(d, hn::Ge(hn::Min(hn::Min(p, q), r), bound))) {
        hn::StoreU(old, d, to);
        continue;
      }
      // a ≤ b ≤ c
      const Row low = hn::Min(p, q), high = hn::Max(p, q);
      const Row a = hn::Min(low, r), c = hn::Max(high, r), b = hn::Max(low, hn::Min(high, r));
      const Row one1 = hn::Add(a, one);
      const Row ab = hn::Sub(a, b);
      const Row two2 = hn::Mul(half, hn::Add(hn::Add(a, b), hn::Sqrt(hn::Max(hn::Sub(two, hn::Mul(ab, ab)), zero))));
      const Row sum = hn::Add(hn::Add(a, b), c);
      const Row squares = hn::Add(hn::Add(hn::Mul(a, a), hn::Mul(b, b)), hn::Mul(c, c));
      const Row root = hn::Sqrt(hn::Max(hn::Sub(hn::Mul(sum, sum), hn::Mul(three, hn::Sub(squares, one))), zero));
      const Row three3 = hn::Mul(third, hn::Add(sum, root));
      Row u = hn::IfThenElse(hn::Gt(one1, b), two2, one1);
      u = hn::IfThenElse(hn::Gt(u, c), three3, u);
      u = hn::Min(u, bound);
      u = hn::IfThenElse(loadBits(static_cast<int>(lane), bits[x * 8 + y]), old, u);
      changed |= uint64_t{!hn::AllTrue(d, hn::Eq(u, old))} << row;
      hn::StoreU(u, d, to);
    }
  }
  return changed;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(TakeAway);
HWY_EXPORT(LayOn);
HWY_EXPORT(Smooth);
HWY_EXPORT(Meet);
HWY_EXPORT(Seal);
HWY_EXPORT(Weights);
HWY_EXPORT(RowsWithin);
HWY_EXPORT(Distances);
HWY_EXPORT(RenewNear);
HWY_EXPORT(Start);
HWY_EXPORT(Bits);
HWY_EXPORT(Bound);
HWY_EXPORT(Eikonal);
HWY_EXPORT(Settle);

BrickChange takeAwaySolid(const float* solid, float band, const float* phi, FloatBrick& out) noexcept {
  return HWY_DYNAMIC_DISPATCH(TakeAway)(solid, band, phi, out);
}
BrickChange layOnSolid(const float* solid, float band, const float* phi, FloatBrick& out) noexcept {
  return HWY_DYNAMIC_DISPATCH(LayOn)(solid, band, phi, out);
}
void smoothBrick(const float* padded, const float* weight, float amount, float band, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(Smooth)(padded, weight, amount, band, out);
}
bool meetAtAnAngle(const float* phi, const float* solid, float sign, float band, float most) noexcept {
  return HWY_DYNAMIC_DISPATCH(Meet)(phi, solid, sign, band, most);
}
BrickChange sealBrick(const float* source, float band, FloatBrick& out, float& most) noexcept {
  return HWY_DYNAMIC_DISPATCH(Seal)(source, band, out, most);
}
void ballWeights(const SweptBall& ball, int shape, float strength, float* weight, uint64_t rows) noexcept {
  HWY_DYNAMIC_DISPATCH(Weights)(ball, shape, strength, weight, rows);
}
uint64_t rowsWithin(const float* phi, float within) noexcept {
  return HWY_DYNAMIC_DISPATCH(RowsWithin)(phi, within);
}
void ballDistances(const SweptBall& ball, float* distance) noexcept {
  HWY_DYNAMIC_DISPATCH(Distances)(ball, distance);
}
void renewNearDistance(const float* padded, const uint64_t* frozen, float least, float* u) noexcept {
  HWY_DYNAMIC_DISPATCH(RenewNear)(padded, frozen, least, u);
}
bool boundChange(const float* phi, const float* weight, float band, float most, float* made) noexcept {
  return HWY_DYNAMIC_DISPATCH(Bound)(phi, weight, band, most, made);
}
void bandBits(const float* phi, float band, uint64_t* bits) noexcept {
  HWY_DYNAMIC_DISPATCH(Bits)(phi, band, bits);
}
void startDistance(const float* padded, float band, uint64_t* frozen, float* u) noexcept {
  HWY_DYNAMIC_DISPATCH(Start)(padded, band, frozen, u);
}
BrickChange settleDistance(const float* phi, const float* u, float band, float tolerance, FloatBrick& out) noexcept {
  return HWY_DYNAMIC_DISPATCH(Settle)(phi, u, band, tolerance, out);
}
uint64_t eikonalPass(const float* padded, const uint64_t* frozen, uint64_t rows, float band, float* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(Eikonal)(padded, frozen, rows, band, out);
}

}  // namespace argil::clay
#endif
