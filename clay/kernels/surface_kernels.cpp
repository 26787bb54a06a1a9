#include "clay/kernels/surface_kernels.h"

#include <array>
#include <bit>
#include <cstring>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/surface_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "clay/kernels/corner_planes.h"
#include "clay/kernels/lane_loads.h"

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kCellPadding>;
using IntTag = hn::RebindToSigned<Tag>;
using Floats = hn::Vec<Tag>;
using Ints = hn::Vec<IntTag>;

// Where the lowest corner of a cell (x·64 + y·8 + z) lies.
constexpr std::array<uint16_t, 512> kCornerOf = [] {
  std::array<uint16_t, 512> places{};
  for (int cell = 0; cell < 512; ++cell)
    places[static_cast<size_t>(cell)] = static_cast<uint16_t>(cornerOffset(cell >> 6, cell >> 3 & 7, cell & 7));
  return places;
}();

HWY_INLINE Floats mix(Floats a, Floats b, Floats t) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), t));
}

// Octahedral, as PackedNormal::pack of a vertex that is on no crease; a vector without length gives z.
HWY_INLINE Ints packNormal(Floats x, Floats y, Floats gz) {
  const Tag d;
  const IntTag di;
  const Floats one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const Floats sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(gz));
  // A field without slope at the vertex (a saddle's very centre) has no normal: any will do, but always the same.
  const auto flat = hn::Not(hn::Gt(sum, hn::Set(d, 1e-12f)));
  const Floats scale = hn::IfThenElse(flat, zero, hn::Div(one, sum)), z = hn::IfThenElse(flat, one, gz);
  const Floats u = hn::Mul(x, scale), v = hn::Mul(y, scale);
  const auto sign = [&](Floats a) { return hn::IfThenElse(hn::Lt(a, zero), hn::Set(d, -1.0f), one); };
  const auto below = hn::Lt(z, zero);
  const Floats fu = hn::IfThenElse(below, hn::Mul(hn::Sub(one, hn::Abs(v)), sign(u)), u);
  const Floats fv = hn::IfThenElse(below, hn::Mul(hn::Sub(one, hn::Abs(u)), sign(v)), v);
  const auto fixed = [&](Floats a, float most) {
    const Floats half = hn::IfThenElse(hn::Lt(a, zero), hn::Set(d, -0.5f), hn::Set(d, 0.5f));
    return hn::ConvertTo(di, hn::Add(hn::Mul(a, hn::Set(d, most)), half));
  };
  const Ints most = hn::Set(di, 16383), half = hn::Min(hn::Max(fixed(fv, 16383.5f), hn::Neg(most)), most);
  return hn::Or(hn::And(fixed(fu, 32767), hn::Set(di, 0xffff)), hn::ShiftLeft<17>(half));
}

// (Loops over corners and edges are written out by templates: g++ keeps them as loops otherwise, with vectors in
// memory.)
template <int... c>
HWY_INLINE Ints patternOf(const Floats (&v)[8], std::integer_sequence<int, c...>) {
  const Tag d;
  const IntTag di;
  Ints pattern = hn::Zero(di);
  ((pattern = hn::Or(pattern, hn::IfThenElseZero(hn::RebindMask(di, hn::Lt(v[c], hn::Zero(d))), hn::Set(di, 1 << c)))),
   ...);
  return pattern;
}

// Edge axis·4 + e, as kCellEdges: its crossing's coordinates on top of `sum` where it is crossed, and one on top of
// `n`.
template <int axis, int e>
HWY_INLINE void addEdge(const Floats (&v)[8], Floats (&sum)[3], Floats& n) {
  const Tag d;
  constexpr int u = (axis + 1) % 3, w = (axis + 2) % 3;
  constexpr int from = (e >> 1) * (4 >> u) + (e & 1) * (4 >> w), to = from + (4 >> axis);
  const auto crossed = hn::Xor(hn::Lt(v[from], hn::Zero(d)), hn::Lt(v[to], hn::Zero(d)));
  sum[axis] = hn::Add(sum[axis], hn::IfThenElseZero(crossed, hn::Div(v[from], hn::Sub(v[from], v[to]))));
  const Floats step = hn::IfThenElseZero(crossed, hn::Set(d, 1.0f));
  if constexpr ((e >> 1) != 0) sum[u] = hn::Add(sum[u], step);
  if constexpr ((e & 1) != 0) sum[w] = hn::Add(sum[w], step);
  n = hn::Add(n, step);
}
template <int... i>
HWY_INLINE void addEdges(const Floats (&v)[8], Floats (&sum)[3], Floats& n, std::integer_sequence<int, i...>) {
  (addEdge<i / 4, i % 4>(v, sum, n), ...);
}

// kKinkedCell where the field in a cell is no plane of slope 1, kBentCell where it is no plane.
HWY_INLINE Ints kinkOf(const Floats (&v)[8]) {
  const Tag d;
  const CornerPlane<Floats> plane = cornerPlane(v);
  const Floats slope = hn::Add(hn::Add(hn::Mul(plane.slopeX, plane.slopeX), hn::Mul(plane.slopeY, plane.slopeY)),
                               hn::Mul(plane.slopeZ, plane.slopeZ));
  const auto bent = hn::Gt(plane.bend, hn::Set(d, kBentBend * kBentBend));
  const auto kinked = hn::Or(hn::Gt(plane.bend, hn::Set(d, kKinkedBend * kKinkedBend)),
                             hn::Or(hn::Lt(slope, hn::Set(d, 16 * kKinkedSlope * kKinkedSlope)),
                                    hn::And(bent, hn::Lt(slope, hn::Set(d, 16 * kBentSlope * kBentSlope)))));
  const IntTag di;
  return hn::Or(hn::IfThenElseZero(hn::RebindMask(di, kinked), hn::Set(di, static_cast<int32_t>(kKinkedCell))),
                hn::IfThenElseZero(hn::RebindMask(di, bent), hn::Set(di, static_cast<int32_t>(kBentCell))));
}

bool CellVertices(const float* corners, const uint16_t* cells, int count, bool kinks, const uint32_t* unusual,
                  uint32_t* patterns, float* positions, uint32_t* normals) {
  const Tag d;
  const IntTag di;
  const hn::Rebind<uint16_t, Tag> d16;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  // The word of a pattern, from a vector of all eight; narrower ones leave the question to the caller.
  constexpr bool kAsks = hn::MaxLanes(Tag()) >= 8;
  constexpr size_t kWords = kAsks ? hn::MaxLanes(Tag()) : 8;
  alignas(64) int32_t all[kWords] = {};
  std::memcpy(all, unusual, 8 * sizeof(uint32_t));
  const Ints words = hn::Load(di, all);
  Ints found = hn::Zero(di);
  for (int first = 0; first < count; first += lanes) {
    const Ints cell = hn::PromoteTo(di, hn::LoadU(d16, cells + first));
    const Ints x = hn::ShiftRight<6>(cell), y = hn::And(hn::ShiftRight<3>(cell), hn::Set(di, 7)),
               z = hn::And(cell, hn::Set(di, 7));
    const float* at[kCellPadding];
    for (int i = 0; i < lanes; ++i) at[i] = corners + kCornerOf[cells[first + i]];
    const auto pair = [&](int offset, Floats& lower, Floats& upper) {
      loadPairs(
          d, [&](int lane) { return at[lane] + offset; }, lower, upper);
    };
    Floats v[8];
    pair(cornerOffset(0, 0, 0), v[0], v[1]);
    pair(cornerOffset(0, 1, 0), v[2], v[3]);
    pair(cornerOffset(1, 0, 0), v[4], v[5]);
    pair(cornerOffset(1, 1, 0), v[6], v[7]);
    Ints pattern = patternOf(v, std::make_integer_sequence<int, 8>());
    if (kinks) pattern = hn::Or(pattern, kinkOf(v));
    hn::StoreU(pattern, di, reinterpret_cast<int32_t*>(patterns + first));
    if constexpr (kAsks) {
      const hn::RebindToUnsigned<IntTag> du;
      const auto low = hn::And(pattern, hn::Set(di, 0xff));
      const Ints word = hn::TableLookupLanes(words, hn::IndicesFromVec(di, hn::ShiftRight<5>(low)));
      const auto bit = hn::Shr(hn::BitCast(du, word), hn::BitCast(du, hn::And(low, hn::Set(di, 31))));
      found =
          hn::Or(found, hn::Or(hn::And(hn::BitCast(di, bit), hn::Set(di, 1)), hn::AndNot(hn::Set(di, 0xff), pattern)));
    }

    Floats sum[3] = {zero, zero, zero}, n = zero;
    addEdges(v, sum, n, std::make_integer_sequence<int, 12>());
    const Floats inverse = hn::Div(one, n);
    const Floats fx = hn::Mul(sum[0], inverse), fy = hn::Mul(sum[1], inverse), fz = hn::Mul(sum[2], inverse);
    hn::StoreInterleaved3(hn::Add(hn::ConvertTo(d, x), fx), hn::Add(hn::ConvertTo(d, y), fy),
                          hn::Add(hn::ConvertTo(d, z), fz), d, positions + 3 * first);
    if (!normals) continue;

    // Gradient of the trilinear field at the vertex.
    const Floats v00 = mix(v[0], v[1], fz), v01 = mix(v[2], v[3], fz), v10 = mix(v[4], v[5], fz),
                 v11 = mix(v[6], v[7], fz);
    const Floats z0 = mix(hn::Sub(v[1], v[0]), hn::Sub(v[3], v[2]), fy),
                 z1 = mix(hn::Sub(v[5], v[4]), hn::Sub(v[7], v[6]), fy);
    const Floats gx = mix(hn::Sub(v10, v00), hn::Sub(v11, v01), fy), gy = mix(hn::Sub(v01, v00), hn::Sub(v11, v10), fx),
                 gz = mix(z0, z1, fx);
    hn::StoreU(packNormal(gx, gy, gz), di, reinterpret_cast<int32_t*>(normals + first));
  }
  return !kAsks || !hn::AllTrue(di, hn::Eq(found, hn::Zero(di)));
}

void Signs(const SignWords& words, BrickSigns& out) {
  const hn::CappedTag<uint64_t, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto lowZ = hn::Set(d, 0x0101010101010101ull), rest = hn::Set(d, ~0x8080808080808080ull);
  uint64_t own[9], any[9], all[9];  // by x; over the four voxels of a plane of cells' corners
  for (int x = 0; x <= 8; x += x < 8 ? lanes : 1) {
    // The plane of the next brick comes last, in every lane the same.
    const auto load = [&](int k) { return x < 8 ? hn::LoadU(d, words.own[k] + x) : hn::Set(d, words.next[k]); };
    const auto w = load(0), z = load(1), y = load(2), yz = load(3);
    const auto toZ = [&](decltype(w) here, decltype(w) after) {
      return hn::Or(hn::And(hn::ShiftRight<1>(here), rest), hn::ShiftLeft<7>(hn::And(after, lowZ)));
    };
    const auto toY = [](decltype(w) here, decltype(w) after) {
      return hn::Or(hn::ShiftRight<8>(here), hn::ShiftLeft<56>(after));
    };
    const auto atZ = toZ(w, z), atY = toY(w, y), atYZ = toZ(atY, toY(z, yz));
    const auto someIn = hn::Or(hn::Or(w, atZ), hn::Or(atY, atYZ)), allIn = hn::And(hn::And(w, atZ), hn::And(atY, atYZ));
    if (x == 8) {
      own[8] = hn::GetLane(w);
      any[8] = hn::GetLane(someIn);
      all[8] = hn::GetLane(allIn);
      break;
    }
    hn::StoreU(w, d, own + x);
    hn::StoreU(someIn, d, any + x);
    hn::StoreU(allIn, d, all + x);
    hn::StoreU(w, d, out.inside + x);
    hn::StoreU(hn::Xor(w, atY), d, out.crossed[1] + x);
    hn::StoreU(hn::Xor(w, atZ), d, out.crossed[2] + x);
  }
  for (int x = 0; x < 8; x += lanes) {
    hn::StoreU(hn::Xor(hn::LoadU(d, own + x), hn::LoadU(d, own + x + 1)), d, out.crossed[0] + x);
    const auto someIn = hn::Or(hn::LoadU(d, any + x), hn::LoadU(d, any + x + 1));
    const auto allIn = hn::And(hn::LoadU(d, all + x), hn::LoadU(d, all + x + 1));
    hn::StoreU(hn::AndNot(allIn, someIn), d, out.active + x);
  }
}

// What stands for the bits of the first word; the next one's are more by a step.
struct BitValues {
  alignas(64) std::array<uint32_t, 64> first;
  uint32_t step;
};
constexpr BitValues kPositions = [] {
  BitValues values{{}, 64};
  for (uint32_t bit = 0; bit < 64; ++bit) values.first[bit] = bit;
  return values;
}();
constexpr BitValues kMapPlaces = [] {
  BitValues values{{}, static_cast<uint32_t>(kMapStep[0])};
  for (int bit = 0; bit < 64; ++bit)
    values.first[static_cast<size_t>(bit)] = static_cast<uint32_t>(mapPlace(0, bit >> 3, bit & 7));
  return values;
}();

// The values of the bits that are set in eight words, in order, with `flag` where the same bit of `without` is not.
template <uint32_t flag>
HWY_INLINE int List(const BitValues& values, const uint64_t* words, const uint64_t* without, uint16_t* out) {
  uint16_t* at = out;
#if HWY_TARGET <= HWY_AVX3
  const hn::FixedTag<uint32_t, 16> d;
  const hn::Rebind<uint16_t, decltype(d)> d16;
  // (Written out: g++ keeps loops, with vectors in memory.)
  const auto load = [&](int i) { return hn::Load(d, values.first.data() + 16 * i); };
  const auto first = load(0), second = load(1), third = load(2), fourth = load(3);
  for (int x = 0; x < 8; ++x) {
    if (words[x] == 0) continue;
    const auto more = hn::Set(d, values.step * static_cast<uint32_t>(x));
    const auto quarter = [&](auto here, int i) {
      const auto bitsOf = [&](const uint64_t* of) {
        return hn::LoadMaskBits(d, reinterpret_cast<const uint8_t*>(of + x) + 2 * i);
      };
      auto value = hn::Add(here, more);
      if constexpr (flag != 0) value = hn::Or(value, hn::IfThenZeroElse(bitsOf(without), hn::Set(d, flag)));
      hn::StoreU(hn::TruncateTo(d16, hn::Compress(value, bitsOf(words))), d16, at);
      at += std::popcount(static_cast<uint16_t>(words[x] >> (16 * i)));
    };
    quarter(first, 0), quarter(second, 1), quarter(third, 2), quarter(fourth, 3);
  }
#else
  uint32_t more = 0;
  for (int x = 0; x < 8; ++x, more += values.step) {
    uint64_t left = words[x];
    const int count = std::popcount(left);
    // Four at a time, needed or not: how many there are is hard to foresee, and a wrong guess costs more than they do.
    uint16_t* next = at;
    do {
      // (Written out: g++ keeps a loop.)
      const uint64_t second = left & (left - 1), third = second & (second - 1), fourth = third & (third - 1);
      const auto place = [&](uint64_t word) {
        const auto bit = static_cast<unsigned>(std::countr_zero(word)) & 63;
        uint32_t value = values.first[bit] + more;
        if constexpr (flag != 0) value |= flag * static_cast<uint32_t>(~(without[x] >> bit) & 1);
        return static_cast<uint16_t>(value);
      };
      next[0] = place(left), next[1] = place(second), next[2] = place(third), next[3] = place(fourth);
      left = fourth & (fourth - 1);
      next += 4;
    } while (left != 0);
    at += count;
  }
#endif
  return static_cast<int>(at - out);
}

// Here since the instructions for it came with AVX2 and AVX-512.
int ListBits(const uint64_t* words, uint16_t* out) {
  return List<0>(kPositions, words, nullptr, out);
}
int ListEdges(const uint64_t* crossed, const uint64_t* inside, uint16_t* out) {
  return List<kEdgeDown>(kMapPlaces, crossed, inside, out);
}

void PlaceCells(const float* positions, const uint64_t* active, uint32_t refs, CellVertex* map) {
  uint16_t places[512 + kListPadding];
  const int count = List<0>(kMapPlaces, active, nullptr, places);
  const hn::Full128<float> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto three = hn::FirstN(d, 3);
  const auto place = [&](int i, const float* from) {
    const auto ref = hn::BitCast(d, hn::Set(du, refs | static_cast<uint32_t>(i)));
    hn::Store(hn::IfThenElse(three, hn::LoadU(d, from), ref), d, &map[places[i]].x);
  };
  if (count == 0) return;
  for (int i = 0; i < count - 1; ++i) place(i, positions + 3 * i);
  float last[4] = {};  // nothing need lie behind it
  std::memcpy(last, positions + 3 * (count - 1), 3 * sizeof(float));
  place(count - 1, last);
}

static_assert(std::endian::native == std::endian::little, "a quad is written as one word");

void EdgeQuads(const CellVertex* vertices, const uint16_t* edges, int count, int stepU, int stepV, uint16_t* quads) {
  const hn::Full128<float> d;
  using Four = hn::Vec<decltype(d)>;
  const auto load = [&](const CellVertex* v) { return hn::Load(d, &v->x); };
  // (x² + y²) + z² of four vectors whose squares these are.
  const auto sums = [&](const Four(&q)[4]) {
    const Four xy0 = hn::InterleaveLower(d, q[0], q[1]), xy1 = hn::InterleaveLower(d, q[2], q[3]);
    const Four z = hn::ConcatLowerLower(d, hn::InterleaveUpper(d, q[2], q[3]), hn::InterleaveUpper(d, q[0], q[1]));
    return hn::Add(hn::Add(hn::ConcatLowerLower(d, xy1, xy0), hn::ConcatUpperUpper(d, xy1, xy0)), z);
  };
  for (int first = 0; first < count; first += 4) {
    const auto squares = [&](int i, Four& diagonal, Four& other) {
      const CellVertex* c = vertices + (edges[first + i] & ~kEdgeDown);
      const Four a = hn::Sub(load(c - stepU - stepV), load(c)), b = hn::Sub(load(c - stepV), load(c - stepU));
      diagonal = hn::Mul(a, a);
      other = hn::Mul(b, b);
    };
    Four ac[4], bd[4];
    squares(0, ac[0], bd[0]);
    squares(1, ac[1], bd[1]);
    squares(2, ac[2], bd[2]);
    squares(3, ac[3], bd[3]);
    uint8_t turned[8];
    hn::StoreMaskBits(d, hn::Lt(sums(bd), sums(ac)), turned);
    for (int i = 0; i < 4; ++i) {
      const uint16_t edge = edges[first + i];
      const CellVertex* c = vertices + (edge & ~kEdgeDown);
      const auto ref = [](const CellVertex* v) { return static_cast<uint64_t>(v->ref & 0xffff); };
      // Around an edge, counter-clockwise seen from its upper end; the other way round where that is the inside.
      uint64_t second = ref(c - stepV), fourth = ref(c - stepU);
      const uint64_t swap = (second ^ fourth) & (uint64_t{0} - (edge >> 15));
      second ^= swap;
      fourth ^= swap;
      const uint64_t quad = ref(c - stepU - stepV) | second << 16 | ref(c) << 32 | fourth << 48;
      const uint64_t word = std::rotr(quad, ((turned[0] >> i) & 1) * 16);
      std::memcpy(quads + 4 * (first + i), &word, sizeof word);
    }
  }
}

void Differing(const float* a, const float* b, uint64_t* out) {
  const hn::CappedTag<uint32_t, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < 8; ++x) {
    uint64_t word = 0;
    for (int i = 0; i < 64; i += lanes) {
      const auto load = [&](const float* v) { return hn::LoadU(d, reinterpret_cast<const uint32_t*>(v) + x * 64 + i); };
      uint8_t bits[8] = {};
      hn::StoreMaskBits(d, hn::Ne(load(a), load(b)), bits);
      word |= (bits[0] | uint64_t{bits[1]} << 8) << i;
    }
    out[x] = word;
  }
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(Signs);
HWY_EXPORT(CellVertices);
HWY_EXPORT(ListBits);
HWY_EXPORT(ListEdges);
HWY_EXPORT(PlaceCells);
HWY_EXPORT(EdgeQuads);
HWY_EXPORT(Differing);

void brickSigns(const SignWords& words, BrickSigns& out) noexcept {
  HWY_DYNAMIC_DISPATCH(Signs)(words, out);
}

bool cellVertices(const float* corners, const uint16_t* cells, int count, bool kinks, const uint32_t* unusual,
                  uint32_t* patterns, float* positions, uint32_t* normals) noexcept {
  return HWY_DYNAMIC_DISPATCH(CellVertices)(corners, cells, count, kinks, unusual, patterns, positions, normals);
}

int listBits(const uint64_t* words, uint16_t* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(ListBits)(words, out);
}

int listEdges(const uint64_t* crossed, const uint64_t* inside, uint16_t* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(ListEdges)(crossed, inside, out);
}

void placeCells(const float* positions, const uint64_t* active, uint32_t refs, CellVertex* map) noexcept {
  HWY_DYNAMIC_DISPATCH(PlaceCells)(positions, active, refs, map);
}

void edgeQuads(const CellVertex* vertices, const uint16_t* edges, int count, int stepU, int stepV,
               uint16_t* quads) noexcept {
  HWY_DYNAMIC_DISPATCH(EdgeQuads)(vertices, edges, count, stepU, stepV, quads);
}

void differingVoxels(const float* a, const float* b, uint64_t (&out)[8]) noexcept {
  HWY_DYNAMIC_DISPATCH(Differing)(a, b, out);
}

}  // namespace argil::clay
#endif
