#include "clay/kernels/formula_kernels.h"

#include "clay/kernels/brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/formula_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kBrickEdge>;
using IntTag = hn::RebindToSigned<Tag>;
using UintTag = hn::RebindToUnsigned<Tag>;
using Vec = hn::Vec<Tag>;
using UintVec = hn::Vec<UintTag>;

// Whole turns are taken off in two parts, the first of so few bits that its products are exact up to 8192 turns; what
// is left is folded into a quarter turn, where the odd polynomial of least error serves (1.6e-7).
HWY_INLINE Vec sineOf(Vec radians) {
  const Tag d;
  const Vec perRadian = hn::Set(d, 0.15915494309f);
  const Vec turns = hn::Floor(hn::Add(hn::Mul(radians, perRadian), hn::Set(d, 0.5f)));
  const Vec left = hn::Sub(hn::Sub(radians, hn::Mul(turns, hn::Set(d, 6.28125f))),
                           hn::Mul(turns, hn::Set(d, 0.0019353071795864769f)));
  Vec t = hn::Mul(left, perRadian);  // −1/2 to 1/2
  const Vec half = hn::CopySign(hn::Set(d, 0.5f), t);
  t = hn::IfThenElse(hn::Gt(hn::Abs(t), hn::Set(d, 0.25f)), hn::Sub(half, t), t);
  const Vec s = hn::Mul(t, t);
  Vec sum = hn::Set(d, 39.536706065730f);
  sum = hn::Add(hn::Mul(sum, s), hn::Set(d, -76.54978250f));
  sum = hn::Add(hn::Mul(sum, s), hn::Set(d, 81.60100407f));
  sum = hn::Add(hn::Mul(sum, s), hn::Set(d, -41.34165550f));
  sum = hn::Add(hn::Mul(sum, s), hn::Set(d, 6.28318508f));
  return hn::Mul(sum, t);
}

HWY_INLINE UintVec mixed(UintVec h) {
  const UintTag d;
  h = hn::Xor(h, hn::ShiftRight<16>(h));
  h = hn::Mul(h, hn::Set(d, 0x7feb352du));
  h = hn::Xor(h, hn::ShiftRight<15>(h));
  h = hn::Mul(h, hn::Set(d, 0x846ca68bu));
  return hn::Xor(h, hn::ShiftRight<16>(h));
}

// −1 to 1 at a corner of the lattice.
HWY_INLINE Vec cornerOf(UintVec x, UintVec y, UintVec z) {
  const Tag d;
  const UintTag u;
  const UintVec h = mixed(hn::Add(x, mixed(hn::Add(y, mixed(z)))));
  // 24 bits, exactly a float.
  const auto whole = hn::BitCast(IntTag(), hn::ShiftRight<8>(h));
  (void)u;
  return hn::Sub(hn::Mul(hn::ConvertTo(d, whole), hn::Set(d, 2.0f / 16777215)), hn::Set(d, 1.0f));
}

struct Lattice {
  UintVec low, high;
  Vec share;
};
HWY_INLINE Lattice latticeOf(Vec v) {
  const Tag d;
  const UintTag u;
  // Farther out every voxel is a corner of the lattice anyway; what is no number counts as the border.
  const Vec bound = hn::Set(d, 1e9f);
  const Vec within = hn::Max(hn::Min(v, bound), hn::Neg(bound));
  const Vec floor = hn::Floor(within), t = hn::Sub(within, floor);
  const UintVec low = hn::BitCast(u, hn::ConvertTo(IntTag(), floor));
  // Perlin's fade: t³ (6 t² − 15 t + 10).
  const Vec fade =
      hn::Mul(hn::Mul(hn::Mul(t, t), t),
              hn::Add(hn::Mul(t, hn::Sub(hn::Mul(t, hn::Set(d, 6.0f)), hn::Set(d, 15.0f))), hn::Set(d, 10.0f)));
  return {low, hn::Add(low, hn::Set(u, 1u)), fade};
}
HWY_INLINE Vec between(Vec a, Vec b, Vec share) {
  return hn::Add(a, hn::Mul(share, hn::Sub(b, a)));
}

HWY_INLINE Vec noiseOf(Vec vx, Vec vy, Vec vz) {
  const Lattice x = latticeOf(vx), y = latticeOf(vy), z = latticeOf(vz);
  const auto along = [&](UintVec atX, UintVec atY) {
    return between(cornerOf(atX, atY, z.low), cornerOf(atX, atY, z.high), z.share);
  };
  return between(between(along(x.low, y.low), along(x.low, y.high), y.share),
                 between(along(x.high, y.low), along(x.high, y.high), y.share), x.share);
}

template <class Value>
HWY_INLINE void forVoxels(const FormulaOperand (&operands)[3], float* out, const Value& value) {
  const Tag d;
  const auto first = [&](const FormulaOperand& o) { return o.values && o.one ? hn::Set(d, *o.values) : hn::Zero(d); };
  const Vec a1 = first(operands[0]), b1 = first(operands[1]), c1 = first(operands[2]);
  const auto at = [&](const FormulaOperand& o, Vec one, size_t i) {
    return o.values && !o.one ? hn::LoadU(d, o.values + i) : one;
  };
  const bool all = (operands[0].one || !operands[0].values) && (operands[1].one || !operands[1].values) &&
                   (operands[2].one || !operands[2].values);
  if (all) {
    *out = hn::GetLane(value(a1, b1, c1));
    return;
  }
  for (size_t i = 0; i < kBrickVoxels; i += hn::Lanes(d))
    hn::StoreU(value(at(operands[0], a1, i), at(operands[1], b1, i), at(operands[2], c1, i)), d, out + i);
}

void Run(FormulaStep step, const FormulaOperand (&o)[3], float* out) {
  const Tag d;
  const Vec zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  switch (step) {
    case FormulaStep::add:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::Add(a, b); });
    case FormulaStep::subtract:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::Sub(a, b); });
    case FormulaStep::multiply:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::Mul(a, b); });
    case FormulaStep::divide:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::Div(a, b); });
    case FormulaStep::least:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::IfThenElse(hn::Lt(b, a), b, a); });
    case FormulaStep::most:
      return forVoxels(o, out, [](Vec a, Vec b, Vec) { return hn::IfThenElse(hn::Lt(a, b), b, a); });
    case FormulaStep::less:
      return forVoxels(o, out, [=](Vec a, Vec b, Vec) { return hn::IfThenElse(hn::Lt(a, b), one, zero); });
    case FormulaStep::lessEqual:
      return forVoxels(o, out, [=](Vec a, Vec b, Vec) { return hn::IfThenElse(hn::Le(a, b), one, zero); });
    case FormulaStep::choose:
      return forVoxels(o, out, [=](Vec a, Vec b, Vec c) { return hn::IfThenElse(hn::Ne(a, zero), b, c); });
    case FormulaStep::absolute:
      return forVoxels(o, out, [](Vec a, Vec, Vec) { return hn::Abs(a); });
    case FormulaStep::root:
      return forVoxels(o, out, [=](Vec a, Vec, Vec) { return hn::Sqrt(hn::IfThenElse(hn::Lt(a, zero), zero, a)); });
    case FormulaStep::floor:
      return forVoxels(o, out, [](Vec a, Vec, Vec) { return hn::Floor(a); });
    case FormulaStep::sine:
      return forVoxels(o, out, [](Vec a, Vec, Vec) { return sineOf(a); });
    case FormulaStep::noise:
      return forVoxels(o, out, [](Vec a, Vec b, Vec c) { return noiseOf(a, b, c); });
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Run);

void runFormulaStep(FormulaStep step, const FormulaOperand (&operands)[3], float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(Run)(step, operands, out);
}

}  // namespace argil::clay
#endif
