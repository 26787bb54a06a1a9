#include "clay/kernels/warp_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/warp_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Eight nodes along z, in parts where the target's vectors are shorter.
using RowTag = hn::CappedTag<float, 8>;
using Row = hn::Vec<RowTag>;
using QuadTag = hn::FixedTag<float, 4>;
using Quad = hn::Vec<QuadTag>;

struct Rows {
  Row x, y, z;
};

// More than what rounding takes from a distance.
constexpr float kReached = 1 + 1e-4f;

HWY_INLINE Row dot(const Rows& a, Row x, Row y, Row z) {
  return hn::Add(hn::Add(hn::Mul(a.x, x), hn::Mul(a.y, y)), hn::Mul(a.z, z));
}

HWY_INLINE Row weightOf(int shape, Row t2) {
  const RowTag d;
  const Row one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const auto square = [](Row v) HWY_ATTR { return hn::Mul(v, v); };
  switch (shape) {
    case 0:
      return square(hn::Max(hn::Sub(one, square(square(t2))), zero));
    case 1:
      return square(hn::Max(hn::Sub(one, t2), zero));
    case 2:
      return hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero);
    case 3:
      return square(hn::Max(hn::Sub(one, hn::Sqrt(t2)), zero));
    default:
      return square(hn::Max(hn::Sub(one, square(t2)), zero));
  }
}

// Weight, 1 − weight and weighted flow of one or more images.
struct Flow {
  Row weight, left;
  Rows v;
};

// Where between its ends the nearest place of the tip's way lies.
HWY_INLINE Row nearestTime(const WarpImage& image, const Rows& from) {
  const RowTag d;
  const Row along = dot(from, hn::Set(d, image.dx), hn::Set(d, image.dy), hn::Set(d, image.dz));
  return hn::Min(hn::Max(hn::Mul(along, hn::Set(d, image.inverseLength2)), hn::Zero(d)), hn::Set(d, 1.0f));
}

HWY_INLINE Flow flowOfOne(const WarpImage& image, int shape, const Rows& at, float time) {
  const RowTag d;
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  if (!image.active) return {zero, one, {zero, zero, zero}};
  const Row dx = hn::Set(d, image.dx), dy = hn::Set(d, image.dy), dz = hn::Set(d, image.dz);
  Rows e{hn::Sub(at.x, hn::Set(d, image.ax)), hn::Sub(at.y, hn::Set(d, image.ay)), hn::Sub(at.z, hn::Set(d, image.az))};
  const Row t = image.fromSegment ? nearestTime(image, e) : hn::Set(d, time);
  e = {hn::Sub(e.x, hn::Mul(t, dx)), hn::Sub(e.y, hn::Mul(t, dy)), hn::Sub(e.z, hn::Mul(t, dz))};
  const Row radius = hn::Add(hn::Set(d, image.radius), hn::Mul(t, hn::Set(d, image.growth)));
  const Row w = weightOf(shape, hn::Div(dot(e, e.x, e.y, e.z), hn::Mul(radius, radius)));
  const Row nx = hn::Set(d, image.nx), ny = hn::Set(d, image.ny), nz = hn::Set(d, image.nz);
  const Row move = hn::Set(d, image.move), pull = hn::Set(d, image.pull), lift = hn::Set(d, image.lift),
            along = dot(e, nx, ny, nz);
  const auto axis = [&](Row way, Row out, Row normal, float spinA, Row b, float spinB, Row a) HWY_ATTR {
    const Row drawn = hn::Mul(pull, hn::Sub(out, hn::Mul(along, normal)));
    const Row turned = hn::Sub(hn::Mul(hn::Set(d, spinA), b), hn::Mul(hn::Set(d, spinB), a));
    return hn::Mul(w, hn::Add(hn::Add(hn::Sub(hn::Mul(move, way), drawn), hn::Mul(lift, normal)), turned));
  };
  return {w,
          hn::Sub(one, w),
          {axis(dx, e.x, nx, image.spinY, e.z, image.spinZ, e.y), axis(dy, e.y, ny, image.spinZ, e.x, image.spinX, e.z),
           axis(dz, e.z, nz, image.spinX, e.y, image.spinY, e.x)}};
}

Flow flowOf(const WarpImage* images, size_t count, int shape, const Rows& at, float time) {
  if (count == 1) return flowOfOne(*images, shape, at, time);
  // Halves first: mirroring does not change the sum.
  const size_t half = count / 2;
  const Flow a = flowOf(images, half, shape, at, time), b = flowOf(images + half, count - half, shape, at, time);
  return {hn::Add(a.weight, b.weight),
          hn::Mul(a.left, b.left),
          {hn::Add(a.v.x, b.v.x), hn::Add(a.v.y, b.v.y), hn::Add(a.v.z, b.v.z)}};
}

// Whether some of the places come into a tip on its way. Elsewhere nothing flows, and what does not move stays there.
HWY_INLINE bool anyReached(const WarpImage* images, size_t count, const Rows& at) {
  const RowTag d;
  for (size_t i = 0; i < count; ++i) {
    const WarpImage& image = images[i];
    if (!image.active) continue;
    Rows e{hn::Sub(at.x, hn::Set(d, image.ax)), hn::Sub(at.y, hn::Set(d, image.ay)),
           hn::Sub(at.z, hn::Set(d, image.az))};
    const Row t = nearestTime(image, e);
    e = {hn::Sub(e.x, hn::Mul(t, hn::Set(d, image.dx))), hn::Sub(e.y, hn::Mul(t, hn::Set(d, image.dy))),
         hn::Sub(e.z, hn::Mul(t, hn::Set(d, image.dz)))};
    const float radius = kReached * (image.radius + (image.growth > 0 ? image.growth : 0));
    if (!hn::AllFalse(d, hn::Lt(dot(e, e.x, e.y, e.z), hn::Set(d, radius * radius)))) return true;
  }
  return false;
}

// Where images overlap: the mean of what they do by weight, as strongly as they weigh together, at most 1. One alone:
// its own.
HWY_INLINE Rows velocity(const WarpImage* images, size_t count, int shape, const Rows& at, float time) {
  const RowTag d;
  if (count == 1) return flowOfOne(*images, shape, at, time).v;
  const Flow flow = flowOf(images, count, shape, at, time);
  const Row share = hn::Div(hn::Sub(hn::Set(d, 1.0f), flow.left), hn::Max(flow.weight, hn::Set(d, 1e-12f)));
  return {hn::Mul(flow.v.x, share), hn::Mul(flow.v.y, share), hn::Mul(flow.v.z, share)};
}

void Trace(const WarpImage* images, size_t count, int shape, int steps, float spacing, NodePlaces& places) {
  const RowTag d;
  const float step = 1.0f / static_cast<float>(steps);
  // Adding it leaves multiples of 2⁻¹⁶.
  const Row coarse = hn::Set(d, 192.0f * spacing);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
        Rows at{hn::Set(d, (static_cast<float>(x) - 3.5f) * spacing),
                hn::Set(d, (static_cast<float>(y) - 3.5f) * spacing),
                hn::Mul(hn::Iota(d, static_cast<float>(lane) - 3.5f), hn::Set(d, spacing))};
        const auto moved = [&](const Rows& v, float by) HWY_ATTR {
          const Row s = hn::Set(d, by);
          return Rows{hn::Sub(at.x, hn::Mul(s, v.x)), hn::Sub(at.y, hn::Mul(s, v.y)), hn::Sub(at.z, hn::Mul(s, v.z))};
        };
        for (int i = anyReached(images, count, at) ? steps : 0; i > 0; --i) {
          const float late = static_cast<float>(i) * step, middle = (static_cast<float>(i) - 0.5f) * step,
                      early = static_cast<float>(i - 1) * step;
          const Rows k1 = velocity(images, count, shape, at, late);
          const Rows k2 = velocity(images, count, shape, moved(k1, 0.5f * step), middle);
          const Rows k3 = velocity(images, count, shape, moved(k2, 0.5f * step), middle);
          const Rows k4 = velocity(images, count, shape, moved(k3, step), early);
          const auto mean = [&](Row a, Row b, Row c, Row e) HWY_ATTR {
            const Row inner = hn::Add(b, c);
            return hn::Add(hn::Add(a, e), hn::Add(inner, inner));
          };
          at = moved({mean(k1.x, k2.x, k3.x, k4.x), mean(k1.y, k2.y, k3.y, k4.y), mean(k1.z, k2.z, k3.z, k4.z)},
                     step / 6);
        }
        const int first = x * 64 + y * 8 + static_cast<int>(lane);
        hn::StoreU(hn::Sub(hn::Add(at.x, coarse), coarse), d, places.x + first);
        hn::StoreU(hn::Sub(hn::Add(at.y, coarse), coarse), d, places.y + first);
        hn::StoreU(hn::Sub(hn::Add(at.z, coarse), coarse), d, places.z + first);
      }
}

// Cubic through the four nodes: of fourth order where Catmull-Rom's is of third; its kinks at nodes are of third.
HWY_INLINE void lagrangeOf(float t, float* w) {
  const float s = 1 - t, third = 1.0f / 3, inner = (1 + t) * (1 + s) * 0.5f, outer = (t * s) * (-0.5f * third);
  w[0] = outer * (1 + s);
  w[1] = inner * s;
  w[2] = inner * t;
  w[3] = outer * (1 + t);
}

HWY_INLINE void weightsOf(float t, float* w) {
  const float s = 1 - t;
  w[0] = -0.5f * (t * s) * s;
  w[1] = s * ((1 + t) - 1.5f * (t * t));
  w[2] = t * ((1 + s) - 1.5f * (s * s));
  w[3] = -0.5f * (s * t) * t;
}

// Of its derivative: those of 1 − t are the same ones turned round, with the other sign.
HWY_INLINE void slopesOf(float t, float* w) {
  const float s = 1 - t;
  w[0] = -0.5f * (s * (s - 2 * t));
  w[1] = t * (4.5f * t - 5);
  w[2] = -(s * (4.5f * s - 5));
  w[3] = 0.5f * (t * (t - 2 * s));
}

// Outer pair, then inner pair: the same turned round.
template <class V>
HWY_INLINE V four(V a, V b, V c, V e, const float* w) {
  const hn::DFromV<V> d;
  return hn::Add(hn::Add(hn::Mul(a, hn::Set(d, w[0])), hn::Mul(e, hn::Set(d, w[3]))),
                 hn::Add(hn::Mul(b, hn::Set(d, w[1])), hn::Mul(c, hn::Set(d, w[2]))));
}

HWY_INLINE Quad along(const float* at, ptrdiff_t stride, const float* w) {
  const QuadTag d;
  return four(hn::LoadU(d, at), hn::LoadU(d, at + stride), hn::LoadU(d, at + 2 * stride), hn::LoadU(d, at + 3 * stride),
              w);
}

void Compose(const NodePlaces& places, float spacing, const Displacement* window, int margin, Displacement* out) {
  using FourTag = hn::CappedTag<float, 16>;
  using Four = hn::Vec<FourTag>;
  const FourTag f;
  const QuadTag d;
  const int n = 8 + 2 * margin;
  const float inverse = 1 / spacing;
  const auto rowsApart = static_cast<ptrdiff_t>(n) * 4, slicesApart = rowsApart * n;
  for (int i = 0; i < kBlockNodes; ++i) {
    const int node[3] = {i >> 6, (i >> 3) & 7, i & 7};
    const float place[3] = {places.x[i], places.y[i], places.z[i]};
    const Displacement& here = window[((node[0] + margin) * n + node[1] + margin) * n + node[2] + margin];
    float own[3], w[3][4];
    ptrdiff_t first[3];
    bool same = true;
    for (int k = 0; k < 3; ++k) {
      own[k] = (static_cast<float>(node[k]) - 3.5f) * spacing;
      same = same && place[k] == own[k];
      const float s = place[k] * inverse + 3.5f;
      const auto base = static_cast<int>(s + 64) - 64;
      lagrangeOf(s - static_cast<float>(base), w[k]);
      first[k] = base - 1 + margin;
    }
    if (same) {
      out[i] = here;
      continue;
    }
    // Across x and y for the four nodes along z at once, then along z.
    const float* corner = &window[(first[0] * n + first[1]) * n + first[2]].x;
    alignas(64) float nodes[16];
    for (size_t part = 0; part < 16; part += hn::Lanes(f)) {
      Four slice[4];
      for (int x = 0; x < 4; ++x) {
        const float* at = corner + x * slicesApart + part;
        slice[x] = four(hn::LoadU(f, at), hn::LoadU(f, at + rowsApart), hn::LoadU(f, at + 2 * rowsApart),
                        hn::LoadU(f, at + 3 * rowsApart), w[1]);
      }
      hn::Store(four(slice[0], slice[1], slice[2], slice[3], w[0]), f, nodes + part);
    }
    alignas(16) float sum[4];
    hn::Store(along(nodes, 4, w[2]), d, sum);
    out[i] = {sum[0] + (place[0] - own[0]), sum[1] + (place[1] - own[1]), sum[2] + (place[2] - own[2]), 0};
  }
}

void Refine(const Displacement* window, int n, const int (&first)[3][10], const float (&weights)[3][10][4],
            Displacement* scratch, Displacement* out) {
  const QuadTag d;
  Displacement* alongZ = scratch;               // n·n·10
  Displacement* alongY = scratch + n * n * 10;  // n·10·10
  for (int row = 0; row < n * n; ++row)
    for (int z = 0; z < 10; ++z)
      hn::StoreU(along(&window[row * n + first[2][z]].x, 4, weights[2][z]), d, &alongZ[row * 10 + z].x);
  // Of these, nodes that follow each other have the same weights.
  const RowTag wide;
  const auto blend = [&](const Displacement* from, int apart, const float* w, int nodes, Displacement* to) HWY_ATTR {
    const float* at = &from->x;
    for (ptrdiff_t i = 0; i < 4 * nodes; i += static_cast<ptrdiff_t>(hn::Lanes(wide))) {
      const auto node = [&](int k) HWY_ATTR { return hn::LoadU(wide, at + 4 * k * apart + i); };
      hn::StoreU(four(node(0), node(1), node(2), node(3), w), wide, &to->x + i);
    }
  };
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < 10; ++y)
      blend(&alongZ[(x * n + first[1][y]) * 10], 10, weights[1][y], 10, &alongY[(x * 10 + y) * 10]);
  for (int x = 0; x < 10; ++x) blend(&alongY[first[0][x] * 100], 100, weights[0][x], 100, &out[x * 100]);
}

void Sample(const FieldSample* samples, size_t count, ptrdiff_t strideX, ptrdiff_t strideY, FieldValue* out) {
  const QuadTag d;
  for (size_t i = 0; i < count; ++i) {
    const FieldSample& s = samples[i];
    float wx[4], wy[4], wz[4], dx[4], dy[4], dz[4];
    weightsOf(s.tx, wx);
    weightsOf(s.ty, wy);
    weightsOf(s.tz, wz);
    slopesOf(s.tx, dx);
    slopesOf(s.ty, dy);
    slopesOf(s.tz, dz);
    Quad value[4], slopeY[4];
    for (int x = 0; x < 4; ++x) {
      const float* at = s.corner + x * strideX;
      const Quad a = hn::LoadU(d, at), b = hn::LoadU(d, at + strideY), c = hn::LoadU(d, at + 2 * strideY),
                 e = hn::LoadU(d, at + 3 * strideY);
      value[x] = four(a, b, c, e, wy);
      slopeY[x] = four(a, b, c, e, dy);
    }
    alignas(16) float v[4], gx[4], gy[4];
    hn::Store(four(value[0], value[1], value[2], value[3], wx), d, v);
    hn::Store(four(value[0], value[1], value[2], value[3], dx), d, gx);
    hn::Store(four(slopeY[0], slopeY[1], slopeY[2], slopeY[3], wx), d, gy);
    const auto sum = [](const float* row, const float* w) {
      return (row[0] * w[0] + row[3] * w[3]) + (row[1] * w[1] + row[2] * w[2]);
    };
    out[i] = {sum(v, wz), sum(gx, wz), sum(gy, wz), sum(v, dz)};
  }
}

void SampleValues(const FieldSample* samples, size_t count, ptrdiff_t strideX, ptrdiff_t strideY, float* out) {
  const QuadTag d;
  for (size_t i = 0; i < count; ++i) {
    const FieldSample& s = samples[i];
    float wx[4], wy[4], wz[4];
    weightsOf(s.tx, wx);
    weightsOf(s.ty, wy);
    weightsOf(s.tz, wz);
    Quad value[4];
    for (int x = 0; x < 4; ++x) {
      const float* at = s.corner + x * strideX;
      value[x] = four(hn::LoadU(d, at), hn::LoadU(d, at + strideY), hn::LoadU(d, at + 2 * strideY),
                      hn::LoadU(d, at + 3 * strideY), wy);
    }
    alignas(16) float v[4];
    hn::Store(four(value[0], value[1], value[2], value[3], wx), d, v);
    out[i] = (v[0] * wz[0] + v[3] * wz[3]) + (v[1] * wz[1] + v[2] * wz[2]);
  }
}

void MovedBox(const MovedVoxels& moved, float (&low)[3], float (&high)[3]) {
  const RowTag d;
  const float* const along[3] = {moved.x, moved.y, moved.z};
  for (int axis = 0; axis < 3; ++axis) {
    Row least = hn::LoadU(d, along[axis] + 111), most = least;
    for (int x = 1; x <= 8; ++x)
      for (int y = 1; y <= 8; ++y)
        for (int z = 1; z <= 8; z += static_cast<int>(hn::Lanes(d))) {
          const Row v = hn::LoadU(d, along[axis] + (x * 10 + y) * 10 + z);
          least = hn::Min(least, v);
          most = hn::Max(most, v);
        }
    low[axis] = hn::GetLane(hn::MinOfLanes(d, least));
    high[axis] = hn::GetLane(hn::MaxOfLanes(d, most));
  }
}

void Split(const Displacement* from, MovedVoxels& out) {
  const hn::CappedTag<float, 4> d;
  static_assert(sizeof(Displacement) == 4 * sizeof(float));
  for (int i = 0; i < 1000; i += static_cast<int>(hn::Lanes(d))) {
    auto x = hn::Zero(d), y = x, z = x, unused = x;
    hn::LoadInterleaved4(d, &from[i].x, x, y, z, unused);
    hn::StoreU(x, d, out.x + i);
    hn::StoreU(y, d, out.y + i);
    hn::StoreU(z, d, out.z + i);
  }
}

void Nearest(const MovedVoxels& moved, const VoxelWindow& window, const float* now, float band, float* phi,
             uint64_t* doubtful) {
  const RowTag d;
  const hn::RebindToSigned<RowTag> di;
  constexpr float kHalf = 0.4999f;  // what is halfway is so however it was rounded
  const Row zero = hn::Zero(d), sizeY = hn::Set(d, static_cast<float>(window.sizeY)),
            sizeZ = hn::Set(d, static_cast<float>(window.sizeZ));
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < 8; ++x) {
    doubtful[x] = 0;
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; z += lanes) {
        const int at = ((x + 1) * 10 + y + 1) * 10 + z + 1, voxel = (x * 8 + y) * 8 + z;
        const Row dx = hn::LoadU(d, moved.x + at), dy = hn::LoadU(d, moved.y + at), dz = hn::LoadU(d, moved.z + at);
        const Row wx = hn::Round(dx), wy = hn::Round(dy), wz = hn::Round(dz);
        const Row off = hn::Max(hn::Max(hn::Abs(hn::Sub(dx, wx)), hn::Abs(hn::Sub(dy, wy))), hn::Abs(hn::Sub(dz, wz)));
        const auto stays = hn::And(hn::And(hn::Eq(dx, zero), hn::Eq(dy, zero)), hn::Eq(dz, zero));
        const int first = ((x - window.x) * window.sizeY + y - window.y) * window.sizeZ + z - window.z;
        // Whole numbers below 2²³: floats hold them. What stays reads its own place, which the window may not hold.
        const Row way = hn::Add(hn::Mul(hn::Add(hn::Mul(wx, sizeY), wy), sizeZ), wz);
        const Row place = hn::Add(hn::Iota(d, static_cast<float>(first)), way);
        HWY_ALIGN int32_t places[8];
        hn::Store(hn::ConvertTo(di, hn::IfThenZeroElse(stays, place)), di, places);
        const Row value = loadEach(d, [&](int lane) { return window.values + places[lane]; });
        hn::StoreU(hn::IfThenElse(stays, hn::LoadU(d, now + voxel), value), d, phi + voxel);
        const auto open = hn::Or(hn::Gt(off, hn::Set(d, kHalf)), hn::Lt(hn::Abs(value), hn::Set(d, band)));
        uint8_t bits[8] = {};
        hn::StoreMaskBits(d, hn::AndNot(stays, open), bits);
        doubtful[x] |= uint64_t{bits[0]} << (y * 8 + z);
      }
  }
}

void Warped(const CameFrom& field, const MovedVoxels& moved, const uint64_t* mask, float stretch, float bend,
            float* phi) {
  const RowTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Row half = hn::Set(d, 0.5f), quarter = hn::Set(d, 0.25f), two = hn::Set(d, 2.0f), one = hn::Set(d, 1.0f);
  for (int voxel = 0; voxel < kBlockNodes; voxel += lanes) {
    const uint8_t bits[8] = {static_cast<uint8_t>((mask[voxel >> 6] >> (voxel & 63)) & ((1u << lanes) - 1))};
    if (bits[0] == 0) continue;
    const int at = (((voxel >> 6) + 1) * 10 + ((voxel >> 3) & 7) + 1) * 10 + (voxel & 7) + 1;
    const Rows v{hn::LoadU(d, field.x + voxel), hn::LoadU(d, field.y + voxel), hn::LoadU(d, field.z + voxel)};
    const Row value = hn::LoadU(d, field.value + voxel);
    const auto q = [&](int step) HWY_ATTR {
      return dot(v, hn::LoadU(d, moved.x + at + step), hn::LoadU(d, moved.y + at + step),
                 hn::LoadU(d, moved.z + at + step));
    };
    const Row q0 = hn::Mul(two, q(0)), xu = q(100), xd = q(-100), yu = q(10), yd = q(-10), zu = q(1), zd = q(-1);
    const Row sx = hn::Add(v.x, hn::Mul(half, hn::Sub(xu, xd))), sy = hn::Add(v.y, hn::Mul(half, hn::Sub(yu, yd))),
              sz = hn::Add(v.z, hn::Mul(half, hn::Sub(zu, zd)));
    const Row was2 = dot(v, v.x, v.y, v.z), is2 = hn::Max(dot({sx, sy, sz}, sx, sy, sz), hn::Set(d, 1e-12f));
    const auto cross = [&](int s, int t) HWY_ATTR {
      return hn::Mul(quarter, hn::Sub(hn::Add(q(s + t), q(-s - t)), hn::Add(q(s - t), q(t - s))));
    };
    const auto twice = [&](Row slope, Row up, Row down)
                           HWY_ATTR { return hn::Mul(hn::Mul(slope, slope), hn::Sub(hn::Add(up, down), q0)); };
    const Row along = hn::Add(hn::Add(twice(sx, xu, xd), twice(sy, yu, yd)), twice(sz, zu, zd));
    const Row across =
        hn::Add(hn::Add(hn::Mul(hn::Mul(sx, sy), cross(100, 10)), hn::Mul(hn::Mul(sx, sz), cross(100, 1))),
                hn::Mul(hn::Mul(sy, sz), cross(10, 1)));
    const Row curve = hn::Div(hn::Add(along, hn::Mul(two, across)), is2);
    const Row first = hn::Mul(value, hn::Min(hn::Sqrt(hn::Div(was2, is2)), hn::Set(d, stretch)));
    const Row second = hn::Mul(hn::Mul(half, curve), hn::Div(value, is2));
    const Row distance = hn::Mul(first, hn::Add(one, hn::Min(hn::Max(second, hn::Set(d, -bend)), hn::Set(d, bend))));
    // Where the field is flat its slope says nothing.
    const Row result = hn::IfThenElse(hn::Lt(was2, hn::Set(d, 0.01f)), value, distance);
    hn::StoreU(hn::IfThenElse(hn::LoadMaskBits(d, bits), result, hn::LoadU(d, phi + voxel)), d, phi + voxel);
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Trace);
HWY_EXPORT(Compose);
HWY_EXPORT(Refine);
HWY_EXPORT(Sample);
HWY_EXPORT(SampleValues);
HWY_EXPORT(MovedBox);
HWY_EXPORT(Split);
HWY_EXPORT(Nearest);
HWY_EXPORT(Warped);

void traceBack(std::span<const WarpImage> images, int shape, int steps, float spacing, NodePlaces& places) noexcept {
  HWY_DYNAMIC_DISPATCH(Trace)(images.data(), images.size(), shape, steps, spacing, places);
}
void composeDisplacements(const NodePlaces& places, float spacing, const Displacement* window, int margin,
                          Displacement* out) noexcept {
  HWY_DYNAMIC_DISPATCH(Compose)(places, spacing, window, margin, out);
}
void cubicWeights(float t, float (&weights)[4]) noexcept {
  HWY_STATIC_DISPATCH(lagrangeOf)(t, weights);
}
void refineDisplacements(const Displacement* window, int n, const int (&first)[3][10], const float (&weights)[3][10][4],
                         Displacement* scratch, Displacement* out) noexcept {
  HWY_DYNAMIC_DISPATCH(Refine)(window, n, first, weights, scratch, out);
}
void sampleField(std::span<const FieldSample> samples, ptrdiff_t strideX, ptrdiff_t strideY, FieldValue* out) noexcept {
  HWY_DYNAMIC_DISPATCH(Sample)(samples.data(), samples.size(), strideX, strideY, out);
}
void sampleValues(std::span<const FieldSample> samples, ptrdiff_t strideX, ptrdiff_t strideY, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(SampleValues)(samples.data(), samples.size(), strideX, strideY, out);
}

void splitDisplacements(const Displacement* from, MovedVoxels& out) noexcept {
  HWY_DYNAMIC_DISPATCH(Split)(from, out);
}
void nearestValues(const MovedVoxels& moved, const VoxelWindow& window, const float* now, float band, float* phi,
                   uint64_t* doubtful) noexcept {
  HWY_DYNAMIC_DISPATCH(Nearest)(moved, window, now, band, phi, doubtful);
}
void movedBounds(const MovedVoxels& moved, float (&low)[3], float (&high)[3]) noexcept {
  HWY_DYNAMIC_DISPATCH(MovedBox)(moved, low, high);
}
void warpedDistances(const CameFrom& field, const MovedVoxels& moved, const uint64_t* mask, float stretch, float bend,
                     float* phi) noexcept {
  HWY_DYNAMIC_DISPATCH(Warped)(field, moved, mask, stretch, bend, phi);
}

}  // namespace argil::clay
#endif
