#include "clay/kernels/foot_kernels.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/foot_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RowTag = hn::CappedTag<float, kBrickEdge>;
using NumberTag = hn::Rebind<uint32_t, RowTag>;
using Row = hn::Vec<RowTag>;

HWY_INLINE Row squareOf(Row dx, Row dy, Row dz) {
  return hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
}

void Nearest(const float* x, const float* y, const float* z, uint32_t begin, uint32_t end, const float* p, float& best,
             uint32_t& nearest) {
  const RowTag d;
  const NumberTag n;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(d));
  const Row px = hn::Set(d, p[0]), py = hn::Set(d, p[1]), pz = hn::Set(d, p[2]);
  Row least = hn::Set(d, best);
  auto numbers = hn::Set(n, kNoPoint);
  for (uint32_t i = begin; i < end; i += lanes) {
    const Row square =
        squareOf(hn::Sub(hn::LoadU(d, x + i), px), hn::Sub(hn::LoadU(d, y + i), py), hn::Sub(hn::LoadU(d, z + i), pz));
    const auto nearer = hn::And(hn::Lt(square, least), hn::FirstN(d, end - i));
    least = hn::IfThenElse(nearer, square, least);
    numbers = hn::IfThenElse(hn::RebindMask(n, nearer), hn::Iota(n, i), numbers);
  }
  HWY_ALIGN float squares[kBrickEdge];
  HWY_ALIGN uint32_t ids[kBrickEdge];
  hn::Store(least, d, squares);
  hn::Store(numbers, n, ids);
  uint32_t found = kNoPoint;
  for (uint32_t i = 0; i < lanes; ++i)
    if (ids[i] != kNoPoint && (squares[i] < best || (squares[i] == best && ids[i] < found)))
      best = squares[i], found = ids[i];
  if (found != kNoPoint) nearest = found;
}

// Those of the points that are nearer than `first` to some place within `half` of `middle`: the plane between both cuts
// the box. `numbers` null: a point's number is its place.
size_t Filter(const float* x, const float* y, const float* z, const uint32_t* numbers, uint32_t begin, uint32_t end,
              const float* first, const float* middle, const float* half, float* outX, float* outY, float* outZ,
              uint32_t* outNumber) {
  const RowTag d;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(d));
  const Row fx = hn::Set(d, first[0]), fy = hn::Set(d, first[1]), fz = hn::Set(d, first[2]);
  const Row mx = hn::Set(d, middle[0]), my = hn::Set(d, middle[1]), mz = hn::Set(d, middle[2]);
  const Row own = squareOf(hn::Sub(fx, mx), hn::Sub(fy, my), hn::Sub(fz, mz));
  const Row hx = hn::Set(d, 2 * half[0]), hy = hn::Set(d, 2 * half[1]), hz = hn::Set(d, 2 * half[2]);
  size_t count = 0;
  for (uint32_t i = begin; i < end; i += lanes) {
    const Row sx = hn::LoadU(d, x + i), sy = hn::LoadU(d, y + i), sz = hn::LoadU(d, z + i);
    const Row farther = hn::Sub(squareOf(hn::Sub(sx, mx), hn::Sub(sy, my), hn::Sub(sz, mz)), own);
    const Row most = hn::Add(hn::Add(hn::Mul(hx, hn::Abs(hn::Sub(sx, fx))), hn::Mul(hy, hn::Abs(hn::Sub(sy, fy)))),
                             hn::Mul(hz, hn::Abs(hn::Sub(sz, fz))));
    const auto keep = hn::And(hn::Le(farther, most), hn::FirstN(d, end - i));
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, keep, bits);
    for (uint32_t left = bits[0]; left; left &= left - 1) {
      const uint32_t at = i + static_cast<uint32_t>(__builtin_ctz(left));
      outX[count] = x[at], outY[count] = y[at], outZ[count] = z[at];
      outNumber[count] = numbers ? numbers[at] : at;
      ++count;
    }
  }
  return count;
}

// The nearest to each voxel of a row of eight along z, whose first lies at `low`. `across`: room.
void Along(const float* x, const float* y, const float* z, const uint32_t* numbers, size_t count, const float* low,
           float* across, uint32_t* nearest) {
  const RowTag d;
  const NumberTag n;
  const size_t lanes = hn::Lanes(d);
  const Row px = hn::Set(d, low[0]), py = hn::Set(d, low[1]);
  for (size_t i = 0; i < count; i += lanes) {
    const Row dx = hn::Sub(hn::LoadU(d, x + i), px), dy = hn::Sub(hn::LoadU(d, y + i), py);
    hn::StoreU(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), d, across + i);
  }
  for (size_t voxel = 0; voxel < kBrickEdge; voxel += lanes) {
    const Row pz = hn::Add(hn::Set(d, low[2]), hn::Iota(d, float(voxel)));
    Row least = hn::Set(d, 1e30f);
    auto found = hn::Set(n, kNoPoint);
    for (size_t i = 0; i < count; ++i) {
      const Row dz = hn::Sub(pz, hn::Set(d, z[i]));
      const Row square = hn::Add(hn::Mul(dz, dz), hn::Set(d, across[i]));
      found = hn::IfThenElse(hn::RebindMask(n, hn::Lt(square, least)), hn::Set(n, numbers[i]), found);
      least = hn::Min(least, square);
    }
    hn::StoreU(found, n, nearest + voxel);
  }
}

void BitsBeyond(const float* phi, ptrdiff_t strideX, ptrdiff_t strideY, const int* counts, float side, float level,
                uint32_t* bits) {
  const RowTag d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const Row sides = hn::Set(d, side), levels = hn::Set(d, level);
  const uint32_t all = (1u << counts[2]) - 1;
  for (int x = 0; x < counts[0]; ++x)
    for (int y = 0; y < counts[1]; ++y) {
      const float* row = phi + x * strideX + y * strideY;
      uint32_t found = 0;
      for (int z = 0; z < kBrickEdge; z += lanes) {
        uint8_t some[8] = {};
        hn::StoreMaskBits(d, hn::Gt(hn::Mul(sides, hn::LoadU(d, row + z)), levels), some);
        found |= uint32_t{some[0]} << z;
      }
      if (counts[2] > kBrickEdge) found |= uint32_t(side * row[kBrickEdge] > level) << kBrickEdge;
      bits[x * kBitRows + y] = found & all;
    }
}

void BoxSquares(const PointArrays& low, const PointArrays& high, size_t count, const float* p, float* squares) {
  const RowTag d;
  const Row px = hn::Set(d, p[0]), py = hn::Set(d, p[1]), pz = hn::Set(d, p[2]);
  const auto gap = [&](const float* from, const float* to, Row at) HWY_ATTR {
    return hn::Max(hn::Max(hn::Sub(hn::LoadU(d, from), at), hn::Sub(at, hn::LoadU(d, to))), hn::Zero(d));
  };
  for (size_t i = 0; i < count; i += hn::Lanes(d))
    hn::StoreU(squareOf(gap(low.x + i, high.x + i, px), gap(low.y + i, high.y + i, py), gap(low.z + i, high.z + i, pz)),
               d, squares + i);
}

// One after the other, so that lanes and a loop over one voxel after the other sum in the same order.
HWY_INLINE Row dotOf(Row ax, Row ay, Row az, Row bx, Row by, Row bz) {
  return hn::Add(hn::Mul(ax, bx), hn::Add(hn::Mul(ay, by), hn::Mul(az, bz)));
}

void DistancesToShapes(const FootShape* shapes, const uint32_t* nearest, const float* low, uint64_t rows,
                       float* distance) {
  const RowTag d;
  const Row zero = hn::Zero(d), one = hn::Set(d, 1.0f), least = hn::Set(d, kLeastSpread);
  for (; rows != 0; rows &= rows - 1) {
    const int row = __builtin_ctzll(rows);
    const Row px = hn::Set(d, low[0] + float(row >> 3)), py = hn::Set(d, low[1] + float(row & 7));
    for (size_t z = 0; z < kBrickEdge; z += hn::Lanes(d)) {
      const size_t voxel = static_cast<size_t>(row) * kBrickEdge + z;
      Row field[12];
      const auto quarter = [&](int k) {
        Row(&four)[4] = *reinterpret_cast<Row(*)[4]>(field + 4 * k);
        loadFours(
            d, [&](int lane) { return shapes[nearest[voxel + size_t(lane)]].point + 4 * k; }, four);
      };
      quarter(0), quarter(1), quarter(2);
      const Row pz = hn::Add(hn::Set(d, low[2]), hn::Iota(d, float(z)));
      const Row wx = hn::Sub(px, field[0]), wy = hn::Sub(py, field[1]), wz = hn::Sub(pz, field[2]);
      const Row square = dotOf(wx, wy, wz, wx, wy, wz);
      const Row h = dotOf(wx, wy, wz, field[3], field[4], field[5]);
      const Row u = dotOf(wx, wy, wz, field[6], field[7], field[8]);
      const Row rest = hn::Max(hn::Sub(hn::Sub(square, hn::Mul(h, h)), hn::Mul(u, u)), zero);
      // Nothing is nearest beyond the middle of its own hollow: curvatures that say so come from a crease.
      const Row hollow = hn::Div(hn::Set(d, -kDeepestHollow), hn::Max(h, one));
      const Row first = hn::Max(field[9], hollow), second = hn::Max(field[10], hollow);
      // A parallel surface at h has curvatures κ/(1 + hκ).
      const Row along = hn::Max(hn::Add(one, hn::Mul(h, first)), least);
      const Row across = hn::Max(hn::Add(one, hn::Mul(h, second)), least);
      const Row bend = hn::Add(hn::Div(hn::Mul(hn::Mul(first, u), u), along), hn::Div(hn::Mul(second, rest), across));
      const Row bent = hn::Add(h, hn::Mul(bend, hn::Set(d, 0.5f)));
      // Points lie so close together that one is beside the nearest place, as it looks from afar.
      const Row near = hn::Sqrt(hn::Max(hn::Sub(square, hn::Mul(field[11], hn::Max(one, along))), zero));
      hn::StoreU(hn::Min(hn::Max(bent, near), hn::Sqrt(square)), d, distance + voxel);
    }
  }
}

uint64_t RowsBeyond(const float* phi, const FarField& field) {
  const RowTag d;
  const Row side = hn::Set(d, field.side), level = hn::Set(d, field.level);
  uint64_t rows = 0;
  for (int row = 0; row < 64; ++row) {
    bool any = false;
    for (size_t z = 0; z < kBrickEdge; z += hn::Lanes(d))
      any |=
          !hn::AllFalse(d, hn::Gt(hn::Mul(side, hn::LoadU(d, phi + static_cast<size_t>(row) * kBrickEdge + z)), level));
    rows |= uint64_t{any} << row;
  }
  return rows;
}

void TakeFar(const float* distance, uint64_t rows, const FarField& field, float* phi) {
  const RowTag d;
  const Row side = hn::Set(d, field.side), level = hn::Set(d, field.level), ownTo = hn::Set(d, field.ownTo);
  const Row agree = hn::Set(d, field.agree), reach = hn::Set(d, field.reach);
  for (; rows != 0; rows &= rows - 1) {
    const auto row = static_cast<size_t>(__builtin_ctzll(rows)) * kBrickEdge;
    for (size_t z = row; z < row + kBrickEdge; z += hn::Lanes(d)) {
      const Row old = hn::LoadU(d, phi + z), size = hn::Mul(side, old);
      const Row own = hn::Sub(size, level), far = hn::LoadU(d, distance + z), apart = hn::Sub(far, own);
      const auto both = hn::And(hn::Lt(own, ownTo), hn::Lt(hn::Abs(apart), agree));
      const Row from = hn::IfThenElse(both, hn::Add(own, hn::Mul(hn::Div(own, ownTo), apart)), far);
      const Row now = hn::Mul(side, hn::Min(hn::Add(level, from), reach));
      hn::StoreU(hn::IfThenElse(hn::Gt(size, level), now, old), d, phi + z);
    }
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Nearest);
HWY_EXPORT(Filter);
HWY_EXPORT(Along);
HWY_EXPORT(BitsBeyond);
HWY_EXPORT(BoxSquares);
HWY_EXPORT(DistancesToShapes);
HWY_EXPORT(RowsBeyond);
HWY_EXPORT(TakeFar);

void bitsBeyond(const float* phi, ptrdiff_t strideX, ptrdiff_t strideY, const int (&counts)[3], float side, float level,
                uint32_t (&bits)[kBitRows * kBitRows]) noexcept {
  HWY_DYNAMIC_DISPATCH(BitsBeyond)(phi, strideX, strideY, counts, side, level, bits);
}

void boxSquares(const PointArrays& low, const PointArrays& high, size_t count, const float (&p)[3],
                float* squares) noexcept {
  HWY_DYNAMIC_DISPATCH(BoxSquares)(low, high, count, p, squares);
}

void distancesToShapes(const FootShape* shapes, const uint32_t (&nearest)[kBrickVoxels], const float (&low)[3],
                       uint64_t rows, float (&distance)[kBrickVoxels]) noexcept {
  HWY_DYNAMIC_DISPATCH(DistancesToShapes)(shapes, nearest, low, rows, distance);
}

uint64_t rowsBeyond(const float (&phi)[kBrickVoxels], const FarField& field) noexcept {
  return HWY_DYNAMIC_DISPATCH(RowsBeyond)(phi, field);
}

void takeFar(const float (&distance)[kBrickVoxels], uint64_t rows, const FarField& field,
             float (&phi)[kBrickVoxels]) noexcept {
  HWY_DYNAMIC_DISPATCH(TakeFar)(distance, rows, field, phi);
}

void PointRoom::fit(size_t count) {
  if (x.size() >= count + kBrickEdge) return;
  for (std::vector<float>* each : {&x, &y, &z, &row}) each->resize(2 * count + kBrickEdge);
  number.resize(2 * count + kBrickEdge);
}

void nearestOf(const PointArrays& points, PointRange range, const float (&p)[3], float& best,
               uint32_t& nearest) noexcept {
  HWY_DYNAMIC_DISPATCH(Nearest)(points.x, points.y, points.z, range.begin, range.end, p, best, nearest);
}

void nearestPoints(const PointArrays& points, std::span<const PointRange> ranges, uint32_t first, const float (&low)[3],
                   uint64_t rows, PointRoom& wide, PointRoom& narrow, uint32_t (&nearest)[kBrickVoxels]) {
  // Blocks of 4 × 4 × 8 within the block: a vector holds a row of them.
  constexpr float kHalf = 3.5f, kQuarter = 1.5f;
  size_t most = 0;
  for (const PointRange& range : ranges) most += range.end - range.begin;
  wide.fit(most);
  const float middle[3] = {low[0] + kHalf, low[1] + kHalf, low[2] + kHalf}, half[3] = {kHalf, kHalf, kHalf};
  const float own[3] = {points.x[first], points.y[first], points.z[first]};
  size_t count = 0;
  for (const PointRange& range : ranges)
    count += HWY_DYNAMIC_DISPATCH(Filter)(points.x, points.y, points.z, nullptr, range.begin, range.end, own, middle,
                                          half, wide.x.data() + count, wide.y.data() + count, wide.z.data() + count,
                                          wide.number.data() + count);
  narrow.fit(count);
  for (int part = 0; part < 4; ++part) {
    const int x0 = 4 * (part >> 1), y0 = 4 * (part & 1);
    if ((rows >> (8 * x0 + y0) & 0x0f0f0f0f) == 0) continue;
    const float centre[3] = {low[0] + float(x0) + kQuarter, low[1] + float(y0) + kQuarter, middle[2]};
    const float reach[3] = {kQuarter, kQuarter, kHalf};
    float best = 1e30f;
    uint32_t at = 0;
    HWY_DYNAMIC_DISPATCH(Nearest)
    (wide.x.data(), wide.y.data(), wide.z.data(), 0, static_cast<uint32_t>(count), centre, best, at);
    const float near[3] = {wide.x[at], wide.y[at], wide.z[at]};
    const size_t few = HWY_DYNAMIC_DISPATCH(Filter)(wide.x.data(), wide.y.data(), wide.z.data(), wide.number.data(), 0,
                                                    static_cast<uint32_t>(count), near, centre, reach, narrow.x.data(),
                                                    narrow.y.data(), narrow.z.data(), narrow.number.data());
    for (int x = x0; x < x0 + 4; ++x)
      for (int y = y0; y < y0 + 4; ++y) {
        if (!(rows >> (8 * x + y) & 1)) continue;
        const float row[3] = {low[0] + float(x), low[1] + float(y), low[2]};
        HWY_DYNAMIC_DISPATCH(Along)
        (narrow.x.data(), narrow.y.data(), narrow.z.data(), narrow.number.data(), few, row, narrow.row.data(),
         nearest + (x * kBrickEdge + y) * kBrickEdge);
      }
  }
}

}  // namespace argil::clay
#endif
