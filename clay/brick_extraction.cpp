#include "clay/brick_extraction.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clay/cell_cases.h"

namespace argil::clay {

namespace {

constexpr uint64_t kAll = ~uint64_t{0};
constexpr uint64_t kLowZ = 0x0101010101010101ull;  // z = 0 of each row

uint64_t insideWord(Slot slot, int x) { return slot.isTile() ? (slot.tile() == Tile::inside ? kAll : 0) : slot.brick()->inside[x]; }

// Sign bits of the voxels of a brick and of those one step higher, as words in the layout of Brick::inside:
// word[x][dy][dz] has at bit y·8 + z the voxel (x, y + dy, z + dz), x from 0 to 8.
struct SignWords {
  uint64_t word[9][2][2];
  bool uniform;  // one sign everywhere: no cell of the brick is crossed
};

void readSigns(const Slot (&slots)[2][2][2], SignWords& signs) {
  uint64_t any = 0, all = kAll;
  for (int x = 0; x <= 8; ++x) {
    const int bx = x >> 3, lx = x & 7;
    const uint64_t w = insideWord(slots[bx][0][0], lx), z = insideWord(slots[bx][0][1], lx);
    const uint64_t y = insideWord(slots[bx][1][0], lx), yz = insideWord(slots[bx][1][1], lx);
    const auto up = [](uint64_t here, uint64_t next) { return (here >> 8) | (next << 56); };  // y + 1
    const auto right = [](uint64_t here, uint64_t next) {                                      // z + 1
      return ((here >> 1) & ~(kLowZ << 7)) | ((next & kLowZ) << 7);
    };
    auto& out = signs.word[x];
    out[0][0] = w;
    out[0][1] = right(w, z);
    out[1][0] = up(w, y);
    out[1][1] = right(out[1][0], up(z, yz));
    any |= w | out[0][1] | out[1][0] | out[1][1];
    all &= w & out[0][1] & out[1][0] & out[1][1];
  }
  signs.uniform = any == 0 || all == kAll;
}

// Pattern of any cell, by way of the field: for the rare folded faces.
int patternOf(Sampler& field, Coord cell) {
  int pattern = 0;
  for (int c = 0; c < 8; ++c) pattern |= static_cast<int>(field.voxel(cell + Coord{c >> 2, (c >> 1) & 1, c & 1}) < 0) << c;
  return pattern;
}

// Bit y: byte y of the word is not zero.
unsigned rowsOf(uint64_t word) {
  word |= word >> 4;
  word |= word >> 2;
  word |= word >> 1;
  return static_cast<unsigned>(((word & kLowZ) * 0x0102040810204080ull) >> 56);
}

// The values at the corners of the active cells, from the brick and those one step higher; the rest stays unset. Rows that no
// active cell touches are left in memory: a surface passes most bricks in few of them.
void readCorners(const Slot (&slots)[2][2][2], const uint64_t (&active)[8], float band, float* corners) {
  unsigned rows[9] = {}, ends[9] = {};  // bit y: the row, and its ninth value, is needed
  for (int x = 0; x < 8; ++x) {
    const unsigned any = rowsOf(active[x]), last = rowsOf(active[x] & (kLowZ << 7));
    rows[x] |= any | any << 1;
    rows[x + 1] |= any | any << 1;
    ends[x] |= last | last << 1;
    ends[x + 1] |= last | last << 1;
  }
  for (int x = 0; x <= 8; ++x)
    for (unsigned left = rows[x]; left != 0; left &= left - 1) {
      const int y = std::countr_zero(left);
      float* row = corners + cornerOffset(x, y, 0);
      const Slot(&pair)[2] = slots[x >> 3][y >> 3];
      const int offset = Brick::offset(x & 7, y & 7, 0);
      if (const Brick* brick = pair[0].brick())
        std::copy_n(brick->phi + offset, 8, row);
      else
        std::fill_n(row, 8, pair[0].phi(0, band));
      if ((ends[x] >> y) & 1) row[8] = pair[1].phi(offset, band);
    }
}

// The mean of a loop's edge crossings in cell coordinates, edges in their fixed order.
Vec3f loopCentre(const float* v, const CellCase& c, int loop) {
  float sum[3] = {};
  int n = 0;
  for (unsigned edges = c.edges; edges != 0; edges &= edges - 1) {
    const int e = std::countr_zero(edges);
    if (c.loopOfEdge[e] != loop) continue;
    const CellEdge edge = kCellEdges[static_cast<size_t>(e)];
    const auto corner = [](int k) { return cornerOffset(k >> 2, (k >> 1) & 1, k & 1); };
    const float from = v[corner(edge.from)], to = v[corner(edge.to)];
    sum[0] += static_cast<float>(edge.from >> 2);
    sum[1] += static_cast<float>((edge.from >> 1) & 1);
    sum[2] += static_cast<float>(edge.from & 1);
    sum[edge.axis] += from / (from - to);
    ++n;
  }
  const float inverse = 1.0f / static_cast<float>(n);
  return {sum[0] * inverse, sum[1] * inverse, sum[2] * inverse};
}

// Gradient of the trilinear field in a cell, normalised; `at` in cell coordinates.
Vec3f cellNormal(const float* v, const Vec3f& at) {
  constexpr int X = cornerOffset(1, 0, 0), Y = cornerOffset(0, 1, 0);
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  const float fx = at.x(), fy = at.y(), fz = at.z();
  const float v00 = mix(v[0], v[1], fz), v01 = mix(v[Y], v[Y + 1], fz), v10 = mix(v[X], v[X + 1], fz), v11 = mix(v[X + Y], v[X + Y + 1], fz);
  const float z0 = mix(v[1] - v[0], v[Y + 1] - v[Y], fy), z1 = mix(v[X + 1] - v[X], v[X + Y + 1] - v[X + Y], fy);
  const float gx = mix(v10 - v00, v11 - v01, fy), gy = mix(v01 - v00, v11 - v10, fx), gz = mix(z0, z1, fx);
  const float length = std::sqrt(gx * gx + gy * gy + gz * gz);
  // A field without slope at the vertex (a saddle's very centre) has no normal: any will do, but always the same.
  if (!(length > 1e-12f)) return {0, 0, 1};
  const float inverse = 1.0f / length;
  return {gx * inverse, gy * inverse, gz * inverse};
}

// A cell's only vertex, relative to the brick whose quads use it; `ref` is kSeveral where the edge must decide.
struct CellVertex {
  float x, y, z;
  uint32_t ref;
};
constexpr uint32_t kSeveral = ~uint32_t{0}, kOneRef = 0xffff;

float length2(const CellVertex& a, const CellVertex& b) {
  const float dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
  return (dx * dx + dy * dy) + dz * dz;
}

// VertexRef's bits 13 to 15 are x, y, z.
uint32_t refBits(int lower) { return static_cast<uint32_t>((lower >> 2 & 1) | (lower & 2) | (lower & 1) << 2) << kVertexRefBits; }

CellVertex vertexAt(const VertexSource& source, int lower, uint32_t index) {
  const Vec3f& p = source.positions[index];
  const auto shift = [lower](int bit) { return (lower >> bit) & 1 ? 8.0f : 0.0f; };
  return {p.x() - shift(2), p.y() - shift(1), p.z() - shift(0), index | refBits(lower)};
}

// Vertices of the cells that the quads of a brick share with the brick that is `lower` (dx·4 + dy·2 + dz) of it: all of its own,
// the last layer of a lower one.
void readVertices(const VertexSource& source, int lower, CellVertex* vertices) {
  if (!source.table) return;
  const CellTable& table = *source.table;
  uint64_t mask = kAll;
  if (lower & 2) mask &= uint64_t{0xff} << 56;
  if (lower & 1) mask &= kLowZ << 7;
  const int shift = (lower & 4 ? -8 * 81 : 0) + (lower & 2 ? -8 * 9 : 0) + (lower & 1 ? -8 : 0) + 81 + 9 + 1;
  const float sx = lower & 4 ? 8.0f : 0.0f, sy = lower & 2 ? 8.0f : 0.0f, sz = lower & 1 ? 8.0f : 0.0f;
  const uint32_t bits = refBits(lower);
  for (int x = lower & 4 ? 7 : 0; x < 8; ++x) {
    const uint64_t active = table.active[x];
    CellVertex* row = vertices + x * 81 + shift;
    uint32_t rank = table.before[x];
    for (uint64_t left = active & mask; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      if (lower & 3) rank = table.before[x] + static_cast<uint32_t>(std::popcount(active & ((uint64_t{1} << bit) - 1)));
      const Vec3f& p = source.positions[rank];
      row[(bit >> 3) * 9 + (bit & 7)] = {p.x() - sx, p.y() - sy, p.z() - sz, rank | bits};
      ++rank;
    }
    for (uint64_t left = table.special[x] & mask; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      row[(bit >> 3) * 9 + (bit & 7)].ref = kSeveral;
    }
  }
}

CellVertex vertexOfEdge(const std::array<VertexSource, 8>& sources, int at, int edge) {
  const int x = at / 81 - 1, y = at / 9 % 9 - 1, z = at % 9 - 1;
  const int lower = (x < 0) * 4 + (y < 0) * 2 + (z < 0);
  const VertexSource& source = sources[static_cast<size_t>(lower)];
  return vertexAt(source, lower, source.table->vertexOf(Brick::offset(x & 7, y & 7, z & 7), edge));
}

}  // namespace

bool operator==(const CellTable& a, const CellTable& b) {
  return std::equal(std::begin(a.active), std::end(a.active), std::begin(b.active)) && a.specials == b.specials && a.vertices == b.vertices;
}

uint32_t CellTable::vertexOf(int cell, int edge) const {
  const int x = cell >> 6, bit = cell & 63;
  const uint64_t mask = uint64_t{1} << bit;
  const auto rank = static_cast<uint32_t>(before[x] + std::popcount(active[x] & (mask - 1)));
  if (!(special[x] & mask)) return rank;
  const auto it = std::lower_bound(specials.begin(), specials.end(), cell, [](const Special& s, int c) { return s.cell < c; });
  const CellCase& c = it->joined ? cellCases().joined[it->pattern] : cellCases().separated[it->pattern];
  const uint32_t loop = c.loopOfEdge[edge];
  return loop == 0 ? rank : it->extraFirst + loop - 1;
}

void extractVertices(Sampler& field, Coord brick, bool wantNormals, CellTable& table, VertexBuffer& out) {
  table = CellTable{};
  out.count = 0;
  Slot slots[2][2][2];
  field.corner(brick, slots);
  SignWords signs;
  readSigns(slots, signs);
  if (signs.uniform) return;

  int count = 0;
  for (int x = 0; x < 8; ++x) {
    const auto& a = signs.word[x];
    const auto& b = signs.word[x + 1];
    const uint64_t any = a[0][0] | a[0][1] | a[1][0] | a[1][1] | b[0][0] | b[0][1] | b[1][0] | b[1][1];
    const uint64_t all = a[0][0] & a[0][1] & a[1][0] & a[1][1] & b[0][0] & b[0][1] & b[1][0] & b[1][1];
    table.active[x] = any & ~all;
    table.before[x] = static_cast<uint16_t>(count);
    count += std::popcount(table.active[x]);
  }
  if (count == 0) return;

  float corners[kCornerCount];
  readCorners(slots, table.active, field.band(), corners);
  // Active cells in order, then any valid cell up to a whole number of vectors.
  uint16_t cells[kBrickVoxels + kCellPadding];
  int listed = 0;
  for (int x = 0; x < 8; ++x)
    for (uint64_t left = table.active[x]; left != 0; left &= left - 1) cells[listed++] = static_cast<uint16_t>(x * 64 + std::countr_zero(left));
  std::fill_n(cells + listed, kCellPadding, cells[0]);
  uint32_t patterns[kBrickVoxels + kCellPadding];
  static_assert(sizeof(Vec3f) == 3 * sizeof(float) && sizeof(PackedNormal) == sizeof(uint32_t));
  cellVertices(corners, cells, count, patterns, out.positions.data()->data(), wantNormals ? reinterpret_cast<uint32_t*>(out.normals.data()) : nullptr);
  out.count = static_cast<size_t>(count);

  // Cells with several loops are rare; they are mended one by one.
  const CellCases& cases = cellCases();
  for (int i = 0; i < count; ++i) {
    const CellCase* c = &cases.separated[patterns[i]];
    if (c->loops == 1 && c->foldedFace < 0) continue;
    const int cell = cells[i], x = cell >> 6, y = (cell >> 3) & 7, z = cell & 7;
    bool joined = false;
    if (c->foldedFace >= 0) {
      table.folded = true;
      const int axis = c->foldedFace / 2, side = c->foldedFace & 1;
      Coord beyond = brick * kBrickEdge + Coord{x, y, z};
      (axis == 0 ? beyond.x : axis == 1 ? beyond.y : beyond.z) += side ? 1 : -1;
      joined = cases.separated[static_cast<size_t>(patternOf(field, beyond))].foldedFace == (c->foldedFace ^ 1);
      if (!joined) continue;
      c = &cases.joined[patterns[i]];
    }
    table.special[x] |= uint64_t{1} << (cell & 63);
    table.specials.push_back({static_cast<uint16_t>(cell), static_cast<uint8_t>(patterns[i]), joined, static_cast<uint16_t>(out.count)});
    const float* v = corners + cornerOffset(x, y, z);
    for (int loop = 0; loop < c->loops; ++loop) {
      const Vec3f within = loopCentre(v, *c, loop);
      const Vec3f position = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) + within;
      const PackedNormal normal = wantNormals ? PackedNormal::pack(cellNormal(v, within)) : PackedNormal{};
      const size_t at = loop == 0 ? static_cast<size_t>(i) : out.count++;
      out.positions[at] = position;
      if (wantNormals) out.normals[at] = normal;
    }
  }
  table.vertices = static_cast<uint16_t>(out.count);
}

void extractQuads(Sampler& field, Coord brick, const std::array<VertexSource, 8>& sources, QuadBuffer& out) {
  out.count = 0;
  Slot slots[2][2][2];
  field.corner(brick, slots);
  SignWords signs;
  readSigns(slots, signs);
  if (signs.uniform) return;
  // Every vertex that a quad here may use, by its cell (from −1 to 7 along each axis). Only crossed cells are written, and
  // only crossed cells are read.
  CellVertex vertices[9 * 9 * 9];
  for (int k = 0; k < 8; ++k) readVertices(sources[static_cast<size_t>(k)], k, vertices);

  const auto ends = [&](int x, int axis) {
    return axis == 0 ? signs.word[x + 1][0][0] : axis == 1 ? signs.word[x][1][0] : signs.word[x][0][1];
  };
  constexpr int kStep[3] = {81, 9, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const int stepU = kStep[(axis + 1) % 3], stepV = kStep[(axis + 2) % 3];
    // Around an edge, counter-clockwise seen from its upper end: the cells one lower along the two axes after its own.
    const int around[4] = {-stepU - stepV, -stepV, 0, -stepU};
    for (int x = 0; x < 8; ++x) {
      const uint64_t low = signs.word[x][0][0];
      for (uint64_t left = low ^ ends(x, axis); left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const CellVertex* cell = vertices + (x + 1) * 81 + ((bit >> 3) + 1) * 9 + (bit & 7) + 1;
        CellVertex a = cell[around[0]], b = cell[around[1]], c = cell[around[2]], d = cell[around[3]];
        if ((a.ref | b.ref | c.ref | d.ref) > kOneRef) {
          const int at = static_cast<int>(cell - vertices);
          if (a.ref == kSeveral) a = vertexOfEdge(sources, at + around[0], axis * 4 + 3);
          if (b.ref == kSeveral) b = vertexOfEdge(sources, at + around[1], axis * 4 + 1);
          if (c.ref == kSeveral) c = vertexOfEdge(sources, at + around[2], axis * 4);
          if (d.ref == kSeveral) d = vertexOfEdge(sources, at + around[3], axis * 4 + 2);
        }
        // Outwards is up the edge when its lower voxel is inside; else the other way round.
        const bool up = (low >> bit) & 1;
        const uint32_t second = up ? b.ref : d.ref, fourth = up ? d.ref : b.ref;
        // The first corner is one of the shorter diagonal.
        const bool turned = length2(b, d) < length2(a, c);
        const auto ref = [](uint32_t r) { return static_cast<VertexRef>(r); };
        out.quads[out.count++] = turned ? std::array<VertexRef, 4>{ref(second), ref(c.ref), ref(fourth), ref(a.ref)}
                                        : std::array<VertexRef, 4>{ref(a.ref), ref(second), ref(c.ref), ref(fourth)};
      }
    }
  }
}

}  // namespace argil::clay
