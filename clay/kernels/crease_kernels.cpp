#include "clay/kernels/crease_kernels.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/crease_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/corner_planes.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Sums are kept in eight parts whatever the target, so that all of them add in one order.
constexpr int kParts = 8;
using Tag = hn::CappedTag<float, kParts>;
using IntTag = hn::RebindToSigned<Tag>;
using Floats = hn::Vec<Tag>;
using Ints = hn::Vec<IntTag>;
constexpr int kVectors = kParts / static_cast<int>(hn::MaxLanes(Tag()));

HWY_INLINE Floats dot(Floats ax, Floats ay, Floats az, Floats bx, Floats by, Floats bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

// A field much flatter than a distance says little of where the surface is.
constexpr float kSteep = 0.5f;
// Cells farther from the surface than this, in voxels, see other faces too.
constexpr float kNear = 1.5f;

// The greatest of all, and where it was.
struct Greatest {
  Floats size[kVectors];
  Ints at[kVectors];
  HWY_INLINE Greatest() {
    for (int k = 0; k < kVectors; ++k) size[k] = hn::Zero(Tag()), at[k] = hn::Set(IntTag(), -1);
  }
  HWY_INLINE void take(int k, int i, Floats v) {
    const auto larger = hn::Gt(v, size[k]);
    size[k] = hn::IfThenElse(larger, v, size[k]);
    at[k] = hn::IfThenElse(hn::RebindMask(IntTag(), larger), hn::Iota(IntTag(), i), at[k]);
  }
  HWY_INLINE int place() const {
    HWY_ALIGN float sizes[kParts];
    HWY_ALIGN int32_t places[kParts];
    for (int k = 0; k < kVectors; ++k) {
      const int first = k * static_cast<int>(hn::Lanes(Tag()));
      hn::Store(size[k], Tag(), sizes + first);
      hn::Store(at[k], IntTag(), places + first);
    }
    int best = 0;
    for (int i = 1; i < kParts; ++i)
      if (sizes[i] > sizes[best]) best = i;
    return sizes[best] > 0 ? places[best] : -1;
  }
};

void FitCells(const float* phi, int stepX, int stepY, const CellBends& bends, CellFits& out) {
  const Tag d;
  constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
  const auto square = [&](float most) { return hn::Set(d, most * most); };
  const Floats slight = square(bends.slight), strong = square(bends.strong), flat = square(bends.flat),
               one = hn::Set(d, 1.0f), quarter = hn::Set(d, 0.25f);
  for (int x = 0; x < kBlockCells; ++x)
    for (int y = 0; y < kBlockCells; ++y) {
      unsigned over = 0, far = 0, plain = 0;
      // Eight lanes overlap in the middle of a row, so that none reads beyond its end.
      for (int z = 0; z + lanes <= kBlockCells; z += 4) {
        const float* at = phi + x * stepX + y * stepY + z;
        const auto value = [&](int step) { return hn::LoadU(d, at + step); };
        const Floats corners[8] = {value(0),     value(1),         value(stepY),         value(stepY + 1),
                                   value(stepX), value(stepX + 1), value(stepX + stepY), value(stepX + stepY + 1)};
        const CornerPlane<Floats> plane = cornerPlane(corners);
        const Floats bend = plane.bend, sx = hn::Mul(quarter, plane.slopeX), sy = hn::Mul(quarter, plane.slopeY),
                     sz = hn::Mul(quarter, plane.slopeZ);
        const Floats length = hn::Sqrt(dot(sx, sy, sz, sx, sy, sz));
        const Floats scale = hn::Div(one, hn::Max(length, hn::Set(d, kSteep)));
        const Floats distance = hn::Mul(plane.sum, hn::Mul(hn::Set(d, 0.125f), scale));
        const auto known = hn::And(hn::And(hn::Lt(bend, flat), hn::Ge(length, hn::Set(d, kSteep))),
                                   hn::Lt(hn::Abs(distance), hn::Set(d, kNear)));
        const auto bits = [&](auto mask) {
          uint8_t some[8] = {};
          hn::StoreMaskBits(d, mask, some);
          return unsigned{some[0]} << z;
        };
        over |= bits(hn::Gt(bend, slight));
        far |= bits(hn::Gt(bend, strong));
        plain |= bits(known);
        hn::StoreU(hn::IfThenElseZero(known, hn::Sub(one, hn::Div(bend, flat))), d, out.quality[x][y] + z);
        hn::StoreU(hn::Mul(sx, scale), d, out.x[x][y] + z);
        hn::StoreU(hn::Mul(sy, scale), d, out.y[x][y] + z);
        hn::StoreU(hn::Mul(sz, scale), d, out.z[x][y] + z);
        hn::StoreU(distance, d, out.distance[x][y] + z);
      }
      out.slight[x][y] = static_cast<uint16_t>(over);
      out.strong[x][y] = static_cast<uint16_t>(far);
      out.flat[x][y] = static_cast<uint16_t>(plain);
    }
}

bool NormalsAgree(const CellFits& n, int x, int y, int z, const float* p, float most) {
  constexpr int kAcross = 5, lanes = static_cast<int>(hn::MaxLanes(Tag()));
  const Tag d;
  // work(part, number of its first cell, row along x, y, cells along z); eight parts, as in all sums here.
  const auto forWindow = [&](const auto& work) {
    for (int i = 0; i < kAcross * kAcross; ++i)
      for (int k = 0; k < kVectors; ++k)
        work(k, i * kParts + k * lanes, x - 2 + i / kAcross, y - 2 + i % kAcross, z - 2 + k * lanes);
  };
  const auto some = [&](int k) { return hn::FirstN(d, static_cast<size_t>(std::max(kAcross - k * lanes, 0))); };
  Greatest heaviest;
  forWindow([&](int k, int first, int i, int j, int from) {
    const Floats quality = hn::IfThenElseZero(some(k), hn::LoadU(d, n.quality[i][j] + from));
    const float ax = static_cast<float>(i) - p[0], ay = static_cast<float>(j) - p[1];
    const Floats az = hn::Sub(hn::Iota(d, static_cast<float>(from)), hn::Set(d, p[2]));
    const Floats squared = hn::Add(hn::Set(d, 0.25f + (ax * ax + ay * ay)), hn::Mul(az, az));
    heaviest.take(k, first, hn::Div(quality, hn::Mul(squared, squared)));
  });
  const int place = heaviest.place();
  if (place < 0) return true;
  const int i0 = x - 2 + place / kParts / kAcross, j0 = y - 2 + place / kParts % kAcross, k0 = z - 2 + place % kParts;
  const Floats nx = hn::Set(d, n.x[i0][j0][k0]), ny = hn::Set(d, n.y[i0][j0][k0]), nz = hn::Set(d, n.z[i0][j0][k0]);
  const Floats least = hn::Set(d, 1 - most);
  Floats off = hn::Zero(d);
  forWindow([&](int k, int, int i, int j, int from) {
    const Floats cosine =
        dot(hn::LoadU(d, n.x[i][j] + from), hn::LoadU(d, n.y[i][j] + from), hn::LoadU(d, n.z[i][j] + from), nx, ny, nz);
    const auto there = hn::And(some(k), hn::Gt(hn::LoadU(d, n.quality[i][j] + from), hn::Zero(d)));
    off = hn::Or(off, hn::IfThenElseZero(hn::And(there, hn::Le(cosine, least)), hn::Set(d, 1.0f)));
  });
  return hn::AllTrue(d, hn::Eq(off, hn::Zero(d)));
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(FitCells);
HWY_EXPORT(NormalsAgree);

void fitCells(const float* phi, int stepX, int stepY, const CellBends& bends, CellFits& out) noexcept {
  HWY_DYNAMIC_DISPATCH(FitCells)(phi, stepX, stepY, bends, out);
}

bool normalsAgree(const CellFits& fits, int x, int y, int z, const float* p, float most) noexcept {
  return HWY_DYNAMIC_DISPATCH(NormalsAgree)(fits, x, y, z, p, most);
}

}  // namespace argil::clay
#endif
