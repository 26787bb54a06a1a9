#include "clay/surface_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/surface_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kCellPadding>;
using IntTag = hn::RebindToSigned<Tag>;
using Floats = hn::Vec<Tag>;
using Ints = hn::Vec<IntTag>;

HWY_INLINE Floats mix(Floats a, Floats b, Floats t) { return hn::Add(a, hn::Mul(hn::Sub(b, a), t)); }

// Octahedral, as PackedNormal::pack.
HWY_INLINE Ints packNormal(Floats x, Floats y, Floats z) {
  const Tag d;
  const IntTag di;
  const Floats one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const Floats scale = hn::Div(one, hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z)));
  const Floats u = hn::Mul(x, scale), v = hn::Mul(y, scale);
  const auto sign = [&](Floats a) { return hn::IfThenElse(hn::Lt(a, zero), hn::Set(d, -1.0f), one); };
  const auto below = hn::Lt(z, zero);
  const Floats fu = hn::IfThenElse(below, hn::Mul(hn::Sub(one, hn::Abs(v)), sign(u)), u);
  const Floats fv = hn::IfThenElse(below, hn::Mul(hn::Sub(one, hn::Abs(u)), sign(v)), v);
  const auto fixed = [&](Floats a) {
    const Floats half = hn::IfThenElse(hn::Lt(a, zero), hn::Set(d, -0.5f), hn::Set(d, 0.5f));
    return hn::ConvertTo(di, hn::Add(hn::Mul(a, hn::Set(d, 32767.0f)), half));
  };
  return hn::Or(hn::And(fixed(fu), hn::Set(di, 0xffff)), hn::ShiftLeft<16>(fixed(fv)));
}

void CellVertices(const float* corners, const uint16_t* cells, int count, uint32_t* patterns, float* positions, uint32_t* normals) {
  const Tag d;
  const IntTag di;
  const hn::Rebind<uint16_t, Tag> d16;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  for (int first = 0; first < count; first += lanes) {
    const Ints cell = hn::PromoteTo(di, hn::LoadU(d16, cells + first));
    const Ints x = hn::ShiftRight<6>(cell), y = hn::And(hn::ShiftRight<3>(cell), hn::Set(di, 7)), z = hn::And(cell, hn::Set(di, 7));
    // (x·9 + y)·9 + z, by shifts: integer products are slow on some targets.
    const Ints xy = hn::Add(hn::Add(hn::ShiftLeft<3>(x), x), y);
    const Ints base = hn::Add(hn::Add(hn::ShiftLeft<3>(xy), xy), z);
    Floats v[8];
    Ints pattern = hn::Zero(di);
    for (int c = 0; c < 8; ++c) {
      v[c] = hn::GatherIndex(d, corners + cornerOffset(c >> 2, (c >> 1) & 1, c & 1), base);
      pattern = hn::Or(pattern, hn::IfThenElseZero(hn::RebindMask(di, hn::Lt(v[c], zero)), hn::Set(di, 1 << c)));
    }
    hn::StoreU(pattern, di, reinterpret_cast<int32_t*>(patterns + first));

    Floats sum[3] = {zero, zero, zero}, n = zero;
    // The twelve edges in the order of kCellEdges: axis, then the two axes after it.
    for (int axis = 0; axis < 3; ++axis)
      for (int e = 0; e < 4; ++e) {
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        int at[3] = {};
        at[u] = e >> 1;
        at[w] = e & 1;
        const int from = at[0] * 4 + at[1] * 2 + at[2], to = from + (4 >> axis);
        const auto crossed = hn::Xor(hn::Lt(v[from], zero), hn::Lt(v[to], zero));
        const Floats t = hn::Div(v[from], hn::Sub(v[from], v[to]));
        sum[axis] = hn::Add(sum[axis], hn::IfThenElseZero(crossed, t));
        const Floats step = hn::IfThenElseZero(crossed, one);
        if (at[u]) sum[u] = hn::Add(sum[u], step);
        if (at[w]) sum[w] = hn::Add(sum[w], step);
        n = hn::Add(n, step);
      }
    const Floats inverse = hn::Div(one, n);
    const Floats fx = hn::Mul(sum[0], inverse), fy = hn::Mul(sum[1], inverse), fz = hn::Mul(sum[2], inverse);
    hn::StoreInterleaved3(hn::Add(hn::ConvertTo(d, x), fx), hn::Add(hn::ConvertTo(d, y), fy), hn::Add(hn::ConvertTo(d, z), fz), d,
                          positions + 3 * first);
    if (!normals) continue;

    // Gradient of the trilinear field at the vertex.
    const Floats v00 = mix(v[0], v[1], fz), v01 = mix(v[2], v[3], fz), v10 = mix(v[4], v[5], fz), v11 = mix(v[6], v[7], fz);
    const Floats z0 = mix(hn::Sub(v[1], v[0]), hn::Sub(v[3], v[2]), fy), z1 = mix(hn::Sub(v[5], v[4]), hn::Sub(v[7], v[6]), fy);
    const Floats gx = mix(hn::Sub(v10, v00), hn::Sub(v11, v01), fy), gy = mix(hn::Sub(v01, v00), hn::Sub(v11, v10), fx), gz = mix(z0, z1, fx);
    const Floats length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy)), hn::Mul(gz, gz)));
    // A field without slope at the vertex (a saddle's very centre) has no normal: any will do, but always the same.
    const auto flat = hn::Not(hn::Gt(length, hn::Set(d, 1e-12f)));
    const Floats scale = hn::Div(one, length);
    const Ints packed = packNormal(hn::IfThenElse(flat, zero, hn::Mul(gx, scale)), hn::IfThenElse(flat, zero, hn::Mul(gy, scale)),
                                   hn::IfThenElse(flat, one, hn::Mul(gz, scale)));
    hn::StoreU(packed, di, reinterpret_cast<int32_t*>(normals + first));
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(CellVertices);

void cellVertices(const float* corners, const uint16_t* cells, int count, uint32_t* patterns, float* positions, uint32_t* normals) noexcept {
  HWY_DYNAMIC_DISPATCH(CellVertices)(corners, cells, count, patterns, positions, normals);
}

}  // namespace argil::clay
#endif
