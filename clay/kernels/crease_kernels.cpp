#include "clay/kernels/crease_kernels.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/crease_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

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
static_assert(kPlanePadding % kParts == 0);

// A field much flatter than a distance says little of where the surface is.
constexpr float kSteep = 0.5f;
// Cells farther from the surface than this, in voxels, see other faces too.
constexpr float kNear = 1.5f;
// A slope that is not 1 counts as a bend by this factor (voxels²).
constexpr float kBlurred = 0.05f;
// Keeps the slope of normals along a face from being read out of planes that stand side by side.
constexpr float kHeld = 0.05f;
// A plane through the corners of a cell on a ball is off by this part of the curvature, at first order: an eighth of
// the sum of both. On balls of four voxels and less, of which the first order knows little, it is taken to be less.
constexpr float kCutOff = 0.25f, kBall = 4;

HWY_INLINE Floats dot(Floats ax, Floats ay, Floats az, Floats bx, Floats by, Floats bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

struct Sum {
  Floats part[kVectors];
  HWY_INLINE Sum() {
    for (int k = 0; k < kVectors; ++k) part[k] = hn::Zero(Tag());
  }
  HWY_INLINE void add(int k, Floats v) { part[k] = hn::Add(part[k], v); }
  HWY_INLINE float total() const {
    HWY_ALIGN float v[kParts];
    for (int k = 0; k < kVectors; ++k) hn::Store(part[k], Tag(), v + k * static_cast<int>(hn::Lanes(Tag())));
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
  }
};

// Calls work(k, i): part k of the sums, elements from i on.
template <class Work>
HWY_INLINE void forAll(int padded, const Work& work) {
  constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
  for (int i = 0; i < padded; i += kParts)
    for (int k = 0; k < kVectors; ++k) work(k, i + k * lanes);
}

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

void SortCells(const float* phi, int stepX, int stepY, const CellBends& bends, SortedCells& out) {
  const Tag d;
  constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
  const auto square = [&](float most) { return hn::Set(d, 64 * most * most); };
  const Floats slight = square(bends.slight), strong = square(bends.strong), flat = square(bends.flat),
               near = hn::Set(d, 8 * bends.near);
  for (int x = 0; x < kBlockCells; ++x)
    for (int y = 0; y < kBlockCells; ++y) {
      unsigned over = 0, far = 0, plain = 0;
      // Eight lanes overlap in the middle of a row, so that none reads beyond its end.
      for (int z = 0; z + lanes <= kBlockCells; z += 4) {
        const float* at = phi + x * stepX + y * stepY + z;
        const auto value = [&](int step) { return hn::LoadU(d, at + step); };
        const Floats v0 = value(0), v1 = value(1), v2 = value(stepY), v3 = value(stepY + 1), v4 = value(stepX),
                     v5 = value(stepX + 1), v6 = value(stepX + stepY), v7 = value(stepX + stepY + 1);
        const Floats a = hn::Add(v0, v1), b = hn::Add(v2, v3), c = hn::Add(v4, v5), e = hn::Add(v6, v7);
        const Floats f = hn::Sub(v1, v0), g = hn::Sub(v3, v2), h = hn::Sub(v5, v4), k = hn::Sub(v7, v6);
        const Floats xy = hn::Sub(hn::Sub(a, b), hn::Sub(c, e)), yz = hn::Add(hn::Sub(g, f), hn::Sub(k, h)),
                     zx = hn::Sub(hn::Add(h, k), hn::Add(f, g)), xyz = hn::Sub(hn::Sub(f, g), hn::Sub(h, k));
        const Floats bend =
            hn::Add(hn::Add(hn::Mul(xy, xy), hn::Mul(yz, yz)), hn::Add(hn::Mul(zx, zx), hn::Mul(xyz, xyz)));
        const auto bits = [&](auto mask) {
          uint8_t some[8] = {};
          hn::StoreMaskBits(d, mask, some);
          return unsigned{some[0]} << z;
        };
        const Floats sum = hn::Abs(hn::Add(hn::Add(a, b), hn::Add(c, e)));
        over |= bits(hn::Gt(bend, slight));
        far |= bits(hn::Gt(bend, strong));
        plain |= bits(hn::And(hn::Le(bend, flat), hn::Lt(sum, near)));
      }
      out.slight[x][y] = static_cast<uint16_t>(over);
      out.strong[x][y] = static_cast<uint16_t>(far);
      out.flatNear[x][y] = static_cast<uint16_t>(plain);
    }
}

bool NormalsAgree(const BlockNormals& n, int x, int y, int z, const float* p, float most) {
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

void CellPlanes(const float* phi, int stepX, int stepY, int margin, const uint16_t* cells, int count,
                BrickPlanes& out) {
  const Tag d;
  const IntTag di;
  const hn::Rebind<uint16_t, Tag> d16;
  const Ints low4 = hn::Set(di, 15);
  const Floats shift = hn::Set(d, 0.5f - static_cast<float>(margin));
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const Ints cell = hn::PromoteTo(di, hn::LoadU(d16, cells + i));
    const Ints x = hn::ShiftRight<8>(cell), y = hn::And(hn::ShiftRight<4>(cell), low4), z = hn::And(cell, low4);
    const auto pair = [&](int offset, Floats& lower, Floats& upper) {
      loadPairs(
          d,
          [&](int lane) {
            const int one = cells[i + lane];
            return phi + (one >> 8) * stepX + (one >> 4 & 15) * stepY + (one & 15) + offset;
          },
          lower, upper);
    };
    Floats v0, v1, v2, v3, v4, v5, v6, v7;
    pair(0, v0, v1), pair(stepY, v2, v3), pair(stepX, v4, v5), pair(stepX + stepY, v6, v7);
    const Floats a = hn::Add(v0, v1), b = hn::Add(v2, v3), c = hn::Add(v4, v5), e = hn::Add(v6, v7);
    const Floats f = hn::Sub(v1, v0), g = hn::Sub(v3, v2), h = hn::Sub(v5, v4), k = hn::Sub(v7, v6);
    const Floats lower = hn::Add(a, b), upper = hn::Add(c, e), quarter = hn::Set(d, 0.25f);
    const Floats sx = hn::Mul(quarter, hn::Sub(upper, lower)),
                 sy = hn::Mul(quarter, hn::Sub(hn::Add(b, e), hn::Add(a, c))),
                 sz = hn::Mul(quarter, hn::Add(hn::Add(f, g), hn::Add(h, k)));
    const Floats xy = hn::Sub(hn::Sub(a, b), hn::Sub(c, e)), yz = hn::Add(hn::Sub(g, f), hn::Sub(k, h)),
                 zx = hn::Sub(hn::Add(h, k), hn::Add(f, g)), xyz = hn::Sub(hn::Sub(f, g), hn::Sub(h, k));
    const Floats bend =
        hn::Mul(hn::Add(hn::Add(hn::Mul(xy, xy), hn::Mul(yz, yz)), hn::Add(hn::Mul(zx, zx), hn::Mul(xyz, xyz))),
                hn::Set(d, 1.0f / 64));
    const Floats length = hn::Sqrt(dot(sx, sy, sz, sx, sy, sz));
    const Floats scale = hn::Div(hn::Set(d, 1.0f), hn::Max(length, hn::Set(d, kSteep)));
    const Floats nx = hn::Mul(sx, scale), ny = hn::Mul(sy, scale), nz = hn::Mul(sz, scale);
    const Floats distance = hn::Mul(hn::Add(lower, upper), hn::Mul(hn::Set(d, 0.125f), scale));
    const auto known = hn::And(hn::Ge(length, hn::Set(d, kSteep)), hn::Lt(hn::Abs(distance), hn::Set(d, kNear)));
    const auto foot = [&](Ints place, Floats normal) {
      return hn::Sub(hn::Add(hn::ConvertTo(d, place), shift), hn::Mul(distance, normal));
    };
    hn::StoreU(foot(x, nx), d, out.foot[0] + i);
    hn::StoreU(foot(y, ny), d, out.foot[1] + i);
    hn::StoreU(foot(z, nz), d, out.foot[2] + i);
    hn::StoreU(nx, d, out.normal[0] + i);
    hn::StoreU(ny, d, out.normal[1] + i);
    hn::StoreU(nz, d, out.normal[2] + i);
    const Floats blur = hn::Abs(hn::Sub(length, hn::Set(d, 1.0f)));
    hn::StoreU(hn::IfThenElse(known, bend, hn::Set(d, kNoPlane)), d, out.bend + i);
    hn::StoreU(blur, d, out.blur + i);
  }
}

void Pick(const BrickPlanes& all, const uint16_t* indices, int count, const float* low, NearPlanes& out) {
  const Tag d;
  out.count = count;
  out.padded = (count + kParts - 1) / kParts * kParts;
  forAll(out.padded, [&](int, int i) {
    const auto from = [&](const float* values) {
      return loadEach(d, [&](int lane) { return values + indices[i + lane]; });
    };
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(hn::Sub(from(all.foot[axis]), hn::Set(d, low[axis])), d, out.foot[axis] + i);
      hn::Store(from(all.normal[axis]), d, out.normal[axis] + i);
    }
    hn::Store(from(all.bend), d, out.bend + i);
    hn::Store(from(all.blur), d, out.blur + i);
  });
  for (int i = count; i < out.padded; ++i) out.bend[i] = kNoPlane;
}

int Rate(NearPlanes& planes, float most, PlaneTrust trust) {
  const Tag d;
  const Floats zero = hn::Zero(d), one = hn::Set(d, 1.0f), inverse = hn::Set(d, 1 / (most * most)),
               blurred = hn::Set(d, trust == PlaneTrust::steep ? kBlurred : 0);
  int count = 0;
  forAll(planes.padded, [&](int, int i) {
    const Floats quality = hn::Max(
        zero,
        hn::Sub(one, hn::Mul(hn::Add(hn::Load(d, planes.bend + i), hn::Mul(hn::Load(d, planes.blur + i), blurred)),
                             inverse)));
    hn::Store(quality, d, planes.quality + i);
    count += static_cast<int>(hn::CountTrue(d, hn::Gt(quality, zero)));
  });
  return count;
}

struct Vector {
  Floats x, y, z;
};
HWY_INLINE Vector load(const float (&rows)[3][kMostNearPlanes], int i) {
  const Tag d;
  return {hn::Load(d, rows[0] + i), hn::Load(d, rows[1] + i), hn::Load(d, rows[2] + i)};
}
HWY_INLINE Vector set(const float* v) {
  const Tag d;
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}
HWY_INLINE Floats dot(const Vector& a, const Vector& b) {
  return dot(a.x, a.y, a.z, b.x, b.y, b.z);
}
HWY_INLINE Vector minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

// Far planes count little: the nearest ones know a curved face best.
HWY_INLINE Floats weightOf(Floats quality, Floats squared) {
  const Floats d2 = hn::Add(hn::Set(Tag(), 0.25f), squared);
  return hn::Div(quality, hn::Mul(d2, d2));
}

struct VectorSum {
  Sum x, y, z;
  HWY_INLINE VectorSum() {}
  HWY_INLINE void add(int k, Floats weight, const Vector& v) {
    x.add(k, hn::Mul(weight, v.x));
    y.add(k, hn::Mul(weight, v.y));
    z.add(k, hn::Mul(weight, v.z));
  }
  HWY_INLINE void total(float scale, float* out) const {
    out[0] = x.total() * scale;
    out[1] = y.total() * scale;
    out[2] = z.total() * scale;
  }
};

HWY_INLINE float dot3(const float* a, const float* b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
// False for one without length.
HWY_INLINE bool normalize(float* v) {
  const float length = std::sqrt(dot3(v, v));
  if (!(length > 1e-6f)) return false;
  for (int axis = 0; axis < 3; ++axis) v[axis] *= 1 / length;
  return true;
}

SplitFaces Split(NearPlanes& planes, const float* p, const FaceTurns& turns) {
  const Tag d;
  const Floats zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  SplitFaces split;
  const Vector about = set(p);
  Greatest heaviest;
  int counted = 0;
  forAll(planes.padded, [&](int k, int i) {
    const Vector to = minus(load(planes.foot, i), about);
    const Floats weight = weightOf(hn::Load(d, planes.quality + i), dot(to, to));
    hn::Store(weight, d, planes.weight + i);
    heaviest.take(k, i, weight);
    counted += static_cast<int>(hn::CountTrue(d, hn::Gt(weight, zero)));
  });
  split.planes = counted;
  const int first = heaviest.place();
  if (first < 0) return split;
  float normals[2][3];
  for (int axis = 0; axis < 3; ++axis) normals[0][axis] = planes.normal[axis][first];
  const Vector start = set(normals[0]);
  Greatest turned;
  forAll(planes.padded, [&](int k, int i) {
    const Floats turn = hn::Sub(one, dot(load(planes.normal, i), start));
    turned.take(
        k, i, hn::IfThenElseZero(hn::Gt(turn, hn::Set(d, turns.least)), hn::Mul(hn::Load(d, planes.weight + i), turn)));
  });
  const int other = turned.place();
  if (other < 0) return split;
  for (int axis = 0; axis < 3; ++axis) normals[1][axis] = planes.normal[axis][other];
  {
    const Vector n0 = set(normals[0]), n1 = set(normals[1]);
    VectorSum sums[2];
    forAll(planes.padded, [&](int k, int i) {
      const Vector n = load(planes.normal, i);
      const Floats weight = hn::Load(d, planes.weight + i);
      const auto second = hn::Gt(dot(n, n1), dot(n, n0));
      sums[0].add(k, hn::IfThenElse(second, zero, weight), n);
      sums[1].add(k, hn::IfThenElse(second, weight, zero), n);
    });
    for (int face = 0; face < 2; ++face) {
      sums[face].total(1, normals[face]);
      if (!normalize(normals[face])) return split;
    }
  }
  if (1 - dot3(normals[0], normals[1]) < turns.least) return split;
  const Vector n0 = set(normals[0]), n1 = set(normals[1]);
  Sum all, away, weights[2];
  VectorSum normal[2], foot[2];
  forAll(planes.padded, [&](int k, int i) {
    const Vector n = load(planes.normal, i), f = load(planes.foot, i);
    const Floats weight = hn::Load(d, planes.weight + i), t0 = hn::Sub(one, dot(n, n0)), t1 = hn::Sub(one, dot(n, n1));
    const auto none = hn::Gt(hn::Min(t0, t1), hn::Set(d, turns.most)), second = hn::Lt(t1, t0);
    all.add(k, weight);
    away.add(k, hn::IfThenElseZero(none, weight));
    const Floats in = hn::IfThenElse(none, zero, one);
    const Floats members[2] = {hn::IfThenElse(second, zero, in), hn::IfThenElse(second, in, zero)};
    for (int face = 0; face < 2; ++face) {
      hn::Store(members[face], d, planes.member[face] + i);
      const Floats share = hn::Mul(weight, members[face]);
      split.count[face] += static_cast<int>(hn::CountTrue(d, hn::Gt(share, zero)));
      weights[face].add(k, share);
      normal[face].add(k, share, n);
      foot[face].add(k, share, f);
    }
  });
  split.third = away.total() > turns.third * all.total();
  split.found = true;
  for (int face = 0; face < 2; ++face) {
    const float sum = weights[face].total();
    split.found = split.found && sum > 0;
    const float inverse = 1 / std::max(sum, 1e-30f);
    normal[face].total(inverse, split.face[face].normal);
    foot[face].total(inverse, split.face[face].foot);
  }
  return split;
}

FaceThere There(NearPlanes& planes, int which, const float* p) {
  const Tag d;
  const Vector place = set(p);
  FaceThere face;
  Sum sums;
  VectorSum normal, foot;
  forAll(planes.padded, [&](int k, int i) {
    const Vector f = load(planes.foot, i), to = minus(f, place);
    const Floats quality = hn::Mul(hn::Load(d, planes.quality + i), hn::Load(d, planes.member[which] + i));
    const Floats weight = weightOf(quality, dot(to, to));
    hn::Store(weight, d, planes.weight + i);
    sums.add(k, weight);
    normal.add(k, weight, load(planes.normal, i));
    foot.add(k, weight, f);
  });
  const float sum = sums.total(), inverse = 1 / std::max(sum, 1e-30f);
  float mean[3], towards[3];
  normal.total(inverse, mean);
  foot.total(inverse, face.foot);
  for (int axis = 0; axis < 3; ++axis) towards[axis] = p[axis] - face.foot[axis];
  const float length2 = dot3(towards, towards);
  const Vector middle = set(face.foot), way = set(towards), meanNormal = set(mean);
  Sum spreads, apart, turned;
  VectorSum bends;
  forAll(planes.padded, [&](int k, int i) {
    const Vector from = minus(load(planes.foot, i), middle), bend = minus(load(planes.normal, i), meanNormal);
    const Floats weight = hn::Load(d, planes.weight + i), along = dot(way, from), share = hn::Mul(weight, along);
    spreads.add(k, hn::Mul(share, along));
    bends.add(k, share, bend);
    apart.add(k, hn::Mul(weight, dot(from, from)));
    turned.add(k, hn::Mul(weight, dot(from, bend)));
  });
  const float loose = kHeld * sum, curvature = turned.total() / (apart.total() + loose + 1e-12f);
  // Planes that lie across the way say little of how the face turns along it: as a ball, then.
  const float held = loose * length2, ball = loose * curvature;
  bends.total(1, face.normal);
  const float scaled = length2 / (spreads.total() + held + 1e-12f);
  for (int axis = 0; axis < 3; ++axis)
    face.normal[axis] = mean[axis] + scaled * (face.normal[axis] + ball * towards[axis]);
  const float scale = 1 / std::sqrt(std::max(dot3(face.normal, face.normal), 1e-12f));
  for (float& n : face.normal) n *= scale;
  const Vector there = set(face.normal);
  Sum values;
  forAll(planes.padded, [&](int k, int i) {
    const Vector n = load(planes.normal, i), both{hn::Add(n.x, there.x), hn::Add(n.y, there.y), hn::Add(n.z, there.z)};
    values.add(k, hn::Mul(hn::Load(d, planes.weight + i), dot(both, minus(place, load(planes.foot, i)))));
  });
  face.offset = 0.5f * values.total() * inverse - dot3(face.normal, p) -
                kCutOff * curvature / (1 + kBall * kBall * curvature * curvature);
  return face;
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(SortCells);
HWY_EXPORT(NormalsAgree);
HWY_EXPORT(CellPlanes);
HWY_EXPORT(Pick);
HWY_EXPORT(Rate);
HWY_EXPORT(Split);
HWY_EXPORT(There);

void sortCells(const float* phi, int stepX, int stepY, const CellBends& bends, SortedCells& out) noexcept {
  HWY_DYNAMIC_DISPATCH(SortCells)(phi, stepX, stepY, bends, out);
}

bool normalsAgree(const BlockNormals& normals, int x, int y, int z, const float* p, float most) noexcept {
  return HWY_DYNAMIC_DISPATCH(NormalsAgree)(normals, x, y, z, p, most);
}

void cellPlanes(const float* phi, int stepX, int stepY, int margin, const BlockCell* cells, int count,
                BrickPlanes& out) noexcept {
  HWY_DYNAMIC_DISPATCH(CellPlanes)(phi, stepX, stepY, margin, cells, count, out);
}

void pickPlanes(const BrickPlanes& all, const uint16_t* indices, int count, const float* low,
                NearPlanes& out) noexcept {
  HWY_DYNAMIC_DISPATCH(Pick)(all, indices, count, low, out);
}

int ratePlanes(NearPlanes& planes, float most, PlaneTrust trust) noexcept {
  return HWY_DYNAMIC_DISPATCH(Rate)(planes, most, trust);
}

SplitFaces splitPlanes(NearPlanes& planes, const float* p, const FaceTurns& turns) noexcept {
  return HWY_DYNAMIC_DISPATCH(Split)(planes, p, turns);
}

FaceThere faceAt(NearPlanes& planes, int which, const float* p) noexcept {
  return HWY_DYNAMIC_DISPATCH(There)(planes, which, p);
}

}  // namespace argil::clay
#endif
