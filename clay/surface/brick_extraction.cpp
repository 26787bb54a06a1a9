#include "clay/surface/brick_extraction.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/crisp_vertices.h"
#include "clay/surface/sharp_vertices.h"

namespace argil::clay {

namespace {

constexpr uint64_t kAll = ~uint64_t{0};
constexpr uint64_t kLowZ = 0x0101010101010101ull;  // z = 0 of each row

// Pattern of any cell, by way of the field: for the rare folded faces.
int patternOf(Sampler& field, Coord cell) {
  int pattern = 0;
  for (int c = 0; c < 8; ++c)
    pattern |= static_cast<int>(field.voxel(cell + Coord{c >> 2, (c >> 1) & 1, c & 1}) < 0) << c;
  return pattern;
}

// Bit y: byte y of the word is not zero.
unsigned rowsOf(uint64_t word) {
  word |= word >> 4;
  word |= word >> 2;
  word |= word >> 1;
  return static_cast<unsigned>(((word & kLowZ) * 0x0102040810204080ull) >> 56);
}

// Calls work(x, y, what stands there and one step higher in z, offset of the row in it) for each row that active cells
// touch. The others are left in memory: a surface passes most bricks in few of them.
template <class Work>
void forEachRow(const BrickInput& input, const Work& work) {
  for (int x = 0; x <= 8; ++x)
    for (unsigned left = input.rows[x]; left != 0; left &= left - 1) {
      const int y = std::countr_zero(left);
      work(x, y, input.slots[x >> 3][y >> 3], Brick::offset(x & 7, y & 7, 0));
    }
}

// The values at the corners of the active cells, from the brick and those one step higher; the rest stays unset.
void readCorners(const BrickInput& input, float band, float* corners) {
  forEachRow(input, [&](int x, int y, const Slot(&pair)[2], int offset) {
    float* row = corners + cornerOffset(x, y, 0);
    if (const Brick* brick = pair[0].brick())
      brick->read(offset, kBrickEdge, row, input.step);
    else
      std::fill_n(row, 8, pair[0].phi(0, band));
    if ((input.ends[x] >> y) & 1) row[8] = pair[1].phi(offset, band, input.step);
  });
}

// Patterns whose cells need more than their one mean: several loops, or a face that may be folded. A bit each.
const std::array<uint32_t, 8> kUnusual = [] {
  std::array<uint32_t, 8> words{};
  for (size_t i = 0; i < 256; ++i)
    if (cellCases().separated[i].loops > 1 || cellCases().separated[i].foldedFace >= 0) words[i >> 5] |= 1u << (i & 31);
  return words;
}();

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

// Gradient of the trilinear field in a cell; `at` in cell coordinates.
Vec3f cellNormal(const float* v, const Vec3f& at) {
  constexpr int X = cornerOffset(1, 0, 0), Y = cornerOffset(0, 1, 0);
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  const float fx = at.x(), fy = at.y(), fz = at.z();
  const float v00 = mix(v[0], v[1], fz), v01 = mix(v[Y], v[Y + 1], fz), v10 = mix(v[X], v[X + 1], fz),
              v11 = mix(v[X + Y], v[X + Y + 1], fz);
  const float z0 = mix(v[1] - v[0], v[Y + 1] - v[Y], fy), z1 = mix(v[X + 1] - v[X], v[X + Y + 1] - v[X + Y], fy);
  const float gx = mix(v10 - v00, v11 - v01, fy), gy = mix(v01 - v00, v11 - v10, fx), gz = mix(z0, z1, fx);
  // A field without slope at the vertex (a saddle's very centre) has no normal: any will do, but always the same.
  if (!(std::abs(gx) + std::abs(gy) + std::abs(gz) > 1e-12f)) return {0, 0, 1};
  return {gx, gy, gz};
}

// Where a cell of a brick, x·64 + y·8 + z, is in the map of vertices that its quads may use.
constexpr std::array<uint16_t, kBrickVoxels> kMapPlace = [] {
  std::array<uint16_t, kBrickVoxels> places{};
  for (int cell = 0; cell < kBrickVoxels; ++cell)
    places[static_cast<size_t>(cell)] = static_cast<uint16_t>(mapPlace(cell >> 6, cell >> 3 & 7, cell & 7));
  return places;
}();

// In place of a vertex, where the edge must decide which of a cell's.
constexpr uint32_t kSeveral = kRefTag | 0x3fffff;

// VertexRef's bits 13 to 15 are x, y, z.
uint32_t refBits(int lower) {
  return static_cast<uint32_t>((lower >> 2 & 1) | (lower & 2) | (lower & 1) << 2) << kVertexRefBits;
}

// Vertices of the cells that the quads of a brick share with the brick that is `lower` (dx·4 + dy·2 + dz) of it: all of
// its own, the last layer of a lower one. True when some of them are several.
bool placeVertices(const VertexSource& source, int lower, CellVertex* vertices) {
  if (!source.table) return false;
  const CellTable& table = *source.table;
  const int shift = (lower & 4 ? -8 * 81 : 0) + (lower & 2 ? -8 * 9 : 0) + (lower & 1 ? -8 : 0);
  const auto placeOf = [&](int cell) { return vertices + shift + kMapPlace[static_cast<size_t>(cell)]; };
  const float sx = lower & 4 ? 8.0f : 0.0f, sy = lower & 2 ? 8.0f : 0.0f, sz = lower & 1 ? 8.0f : 0.0f;
  const uint32_t bits = kRefTag | refBits(lower);
  const auto place = [&](int cell, uint32_t rank) {
    const Vec3f& p = source.positions[rank];
    *placeOf(cell) = {p.x() - sx, p.y() - sy, p.z() - sz, rank | bits};
  };
  uint64_t mask = kAll;
  if (lower & 2) mask &= uint64_t{0xff} << 56;
  if (lower & 1) mask &= kLowZ << 7;
  if (lower == 0) {
    placeCells(source.positions->data(), table.active, bits, vertices);
  } else {
    for (int x = lower & 4 ? 7 : 0; x < 8; ++x)
      for (uint64_t left = table.active[x] & mask; left != 0; left &= left - 1) {
        const uint64_t below = (left & (0 - left)) - 1;
        place(x * 64 + std::popcount(below),
              table.before[x] + static_cast<uint32_t>(std::popcount(table.active[x] & below)));
      }
  }
  bool several = false;
  for (const CellTable::Special& special : table.specials) {
    if (!(mask >> (special.cell & 63) & 1) || ((lower & 4) && special.cell < 7 * 64)) continue;
    placeOf(special.cell)->ref = kSeveral;
    several = true;
  }
  return several;
}

// The vertex that stands for the cell at `at` around one of its edges.
CellVertex vertexOfEdge(const std::array<VertexSource, 8>& sources, const CellVertex* vertices, int at, int edge) {
  if (vertices[at].ref != kSeveral) return vertices[at];
  const int x = at / 81 - 1, y = at / 9 % 9 - 1, z = at % 9 - 1;
  const int lower = (x < 0) * 4 + (y < 0) * 2 + (z < 0);
  const VertexSource& source = sources[static_cast<size_t>(lower)];
  const uint32_t index = source.table->vertexOf(Brick::offset(x & 7, y & 7, z & 7), edge);
  const Vec3f& p = source.positions[index];
  return {p.x() - (x < 0 ? 8.0f : 0.0f), p.y() - (y < 0 ? 8.0f : 0.0f), p.z() - (z < 0 ? 8.0f : 0.0f),
          kRefTag | refBits(lower) | index};
}

}  // namespace

bool operator==(const CellTable& a, const CellTable& b) {
  return a.vertices == b.vertices && a.readsBeyond == b.readsBeyond &&
         std::equal(std::begin(a.active), std::end(a.active), std::begin(b.active)) &&
         std::equal(a.specials.begin(), a.specials.end(), b.specials.begin(), b.specials.end()) &&
         std::equal(a.sharp.begin(), a.sharp.end(), b.sharp.begin(), b.sharp.end());
}

uint32_t CellTable::vertexOf(int cell, int edge) const {
  const int x = cell >> 6, bit = cell & 63;
  const auto rank = static_cast<uint32_t>(before[x] + std::popcount(active[x] & ((uint64_t{1} << bit) - 1)));
  const auto it =
      std::lower_bound(specials.begin(), specials.end(), cell, [](const Special& s, int c) { return s.cell < c; });
  if (it == specials.end() || it->cell != cell) return rank;
  const CellCase& c = it->joined ? cellCases().joined[it->pattern] : cellCases().separated[it->pattern];
  const uint32_t loop = c.loopOfEdge[edge];
  return loop == 0 ? rank : it->extraFirst + loop - 1;
}

void readSigns(BrickInput& input) {
  static constexpr uint64_t kUniform[2][8] = {{}, {kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll}};
  const auto wordsOf = [](Slot slot) {
    return slot.isTile() ? kUniform[slot.tile() == Tile::inside] : slot.brick()->inside;
  };
  SignWords words;
  for (int k = 0; k < 4; ++k) {
    words.own[k] = wordsOf(input.slots[0][k >> 1][k & 1]);
    words.next[k] = wordsOf(input.slots[1][k >> 1][k & 1])[0];
  }
  brickSigns(words, input.signs);
}

void readRows(BrickInput& input) {
  const auto& active = input.signs.active;
  input.crossed = (active[0] | active[1] | active[2] | active[3] | active[4] | active[5] | active[6] | active[7]) != 0;
  if (!input.crossed) return;
  unsigned rowsBefore = 0, endsBefore = 0;
  for (int x = 0; x <= 8; ++x) {
    const uint64_t word = x < 8 ? active[x] : 0;
    const unsigned rows = rowsOf(word), ends = rowsOf(word & (kLowZ << 7));
    input.rows[x] = static_cast<uint16_t>((rows | rowsBefore) | (rows | rowsBefore) << 1);
    input.ends[x] = static_cast<uint16_t>((ends | endsBefore) | (ends | endsBefore) << 1);
    rowsBefore = rows;
    endsBefore = ends;
  }
  // By cache lines, of two rows each. (Written out: g++ 12 takes a function that does nothing but prefetch for one
  // without effect, and drops it.)
  for (int x = 0; x <= 8; ++x) {
    const auto lines = [](unsigned rows) { return (rows | rows >> 1) & 0x155; };
    const unsigned ends = lines(input.ends[x]);
    for (unsigned left = lines(input.rows[x]); left != 0; left &= left - 1) {
      const int y = std::countr_zero(left), offset = Brick::offset(x & 7, y & 7, 0);
      const Slot(&pair)[2] = input.slots[x >> 3][y >> 3];
      if (const Brick* brick = pair[0].brick()) __builtin_prefetch(brick->address(offset, input.step));
      if ((ends >> y) & 1)
        if (const Brick* brick = pair[1].brick()) __builtin_prefetch(brick->address(offset, input.step));
    }
  }
}

void extractVertices(Sampler& field, const Coord& brick, const BrickInput& input, bool wantNormals, Grade grade,
                     ExtractionBuffer& out) {
  CellTable& table = out.table;
  table = CellTable{};
  if (!input.crossed) return;
  // Active cells in order, then any valid cell up to a whole number of vectors.
  uint16_t cells[kBrickVoxels + std::max(kCellPadding, kListPadding)];
  const int count = listBits(input.signs.active, cells);
  std::fill_n(cells + count, kCellPadding, cells[0]);
  int before = 0, quads = 0;
  for (int x = 0; x < 8; ++x) {
    table.active[x] = input.signs.active[x];
    table.before[x] = static_cast<uint16_t>(before);
    before += std::popcount(table.active[x]);
    for (const auto& crossed : input.signs.crossed) quads += std::popcount(crossed[x]);
  }
  table.quads = static_cast<uint16_t>(quads);

  float corners[kCornerCount];
  readCorners(input, field.band(), corners);
  uint32_t patterns[kBrickVoxels + kCellPadding];
  static_assert(sizeof(Vec3f) == 3 * sizeof(float) && sizeof(PackedNormal) == sizeof(uint32_t));
  const bool some = cellVertices(corners, cells, count, grade != Grade::draft, kUnusual.data(), patterns,
                                 out.positions.data()->data(),
                                 wantNormals ? reinterpret_cast<uint32_t*>(out.normals.data()) : nullptr);

  // Cells with several loops are rare; they are repaired one by one.
  const CellCases& cases = cellCases();
  size_t vertices = static_cast<size_t>(count), specials = 0;
  CreaseCells creases{cells, patterns, count, corners, {}, {}};
  uint32_t flags = 0;
  for (int i = 0; some && i < count; ++i) {
    if (patterns[i] > 0xff) {
      flags |= patterns[i];
      const uint64_t bit = uint64_t{1} << (cells[i] & 63);
      if ((patterns[i] & kKinkedCell) != 0) creases.kinked[cells[i] >> 6] |= bit;
      if ((patterns[i] & kBentCell) != 0) creases.bent[cells[i] >> 6] |= bit;
      patterns[i] &= 0xff;
    }
    if (!(kUnusual[patterns[i] >> 5] >> (patterns[i] & 31) & 1)) continue;
    const CellCase* c = &cases.separated[patterns[i]];
    const int cell = cells[i], x = cell >> 6, y = (cell >> 3) & 7, z = cell & 7;
    bool joined = false;
    if (c->foldedFace >= 0) {
      table.readsBeyond = true;
      const int axis = c->foldedFace / 2, side = c->foldedFace & 1;
      Coord beyond = brick * kBrickEdge + Coord{x, y, z};
      (axis == 0 ? beyond.x : axis == 1 ? beyond.y : beyond.z) += side ? 1 : -1;
      joined = cases.separated[static_cast<size_t>(patternOf(field, beyond))].foldedFace == (c->foldedFace ^ 1);
      if (!joined) continue;
      c = &cases.joined[patterns[i]];
    }
    out.specials[specials++] = {static_cast<uint16_t>(cell), static_cast<uint8_t>(patterns[i]), joined,
                                static_cast<uint16_t>(vertices)};
    const float* v = corners + cornerOffset(x, y, z);
    for (int loop = 0; loop < c->loops; ++loop) {
      const Vec3f within = loopCentre(v, *c, loop);
      const size_t at = loop == 0 ? static_cast<size_t>(i) : vertices++;
      out.positions[at] = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) + within;
      if (wantNormals) out.normals[at] = PackedNormal::pack(cellNormal(v, within));
    }
  }
  table.vertices = static_cast<uint16_t>(vertices);
  table.specials = {out.specials.data(), specials};
  PlacedVertices placed;
  if (flags != 0) crispVertices(field, brick, creases, wantNormals, grade, out, placed);
  if (grade == Grade::fine && mayHoldCrease(corners, cells, count))
    sharpenVertices(field, brick, wantNormals, placed, out);
}

void extractQuads(const BrickSigns& signs, const std::array<VertexSource, 8>& sources, ExtractionBuffer& out) {
  // Every vertex that a quad here may use, by its cell (from −1 to 7 along each axis). Only crossed cells are written,
  // and only crossed cells are read.
  CellVertex vertices[9 * 9 * 9];
  bool several = false;
  for (int k = 0; k < 8; ++k) several |= placeVertices(sources[static_cast<size_t>(k)], k, vertices);

  std::array<VertexRef, 4>* quads = out.quads.data();
  for (int axis = 0; axis < 3; ++axis) {
    uint16_t edges[kBrickVoxels + std::max(kEdgePadding, kListPadding)];
    const int count = listEdges(signs.crossed[axis], signs.inside, edges);
    if (count == 0) continue;
    const int stepU = kMapStep[(axis + 1) % 3], stepV = kMapStep[(axis + 2) % 3];
    if (!several) {
      std::fill_n(edges + count, kEdgePadding, edges[0]);
      edgeQuads(vertices, edges, count, stepU, stepV, quads->data());
    } else {
      for (int i = 0; i < count; ++i) {
        // The four vertices around the edge alone, as a map of 2×2 cells.
        const int at = edges[i] & ~kEdgeDown;
        const CellVertex around[4] = {vertexOfEdge(sources, vertices, at - stepU - stepV, axis * 4 + 3),
                                      vertexOfEdge(sources, vertices, at - stepU, axis * 4 + 2),
                                      vertexOfEdge(sources, vertices, at - stepV, axis * 4 + 1),
                                      vertexOfEdge(sources, vertices, at, axis * 4)};
        uint16_t edge[1 + kEdgePadding];
        std::fill_n(edge, 1 + kEdgePadding, static_cast<uint16_t>(3 | (edges[i] & kEdgeDown)));
        edgeQuads(around, edge, 1, 2, 1, quads[i].data());
      }
    }
    quads += count;
  }
  splitAlongCreases(sources, {out.quads.data(), quads});
}

}  // namespace argil::clay
