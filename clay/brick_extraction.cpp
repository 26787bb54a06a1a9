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

void readSlots(Sampler& field, Coord brick, Slot (&slots)[2][2][2]) {
  for (int i = 0; i < 8; ++i) slots[i >> 2][(i >> 1) & 1][i & 1] = field.slot(brick + Coord{i >> 2, (i >> 1) & 1, i & 1});
}

int patternAt(const SignWords& signs, int x, int bit) {
  int pattern = 0;
  for (int c = 0; c < 8; ++c) pattern |= static_cast<int>((signs.word[x + (c >> 2)][(c >> 1) & 1][c & 1] >> bit) & 1) << c;
  return pattern;
}

// Pattern of any cell, by way of the field: for the rare folded faces.
int patternOf(Sampler& field, Coord cell) {
  int pattern = 0;
  for (int c = 0; c < 8; ++c) pattern |= static_cast<int>(field.voxel(cell + Coord{c >> 2, (c >> 1) & 1, c & 1}) < 0) << c;
  return pattern;
}

// The brick's values and those one step higher, rows of nine along z.
constexpr int kRow = 9;
struct Corners {
  float phi[9 * 9 * kRow];
};
constexpr int cornerOffset(int x, int y, int z) { return (x * 9 + y) * kRow + z; }

void readCorners(const Slot (&slots)[2][2][2], float band, Corners& corners) {
  for (int i = 0; i < 8; ++i) {
    const int dx = i >> 2, dy = (i >> 1) & 1, dz = i & 1;
    const Slot slot = slots[dx][dy][dz];
    const int nx = dx ? 1 : 8, ny = dy ? 1 : 8, nz = dz ? 1 : 8;
    const Brick* brick = slot.brick();
    const float constant = brick ? 0 : slot.phi(0, band);
    for (int x = 0; x < nx; ++x)
      for (int y = 0; y < ny; ++y) {
        float* row = corners.phi + cornerOffset(dx * 8 + x, dy * 8 + y, dz * 8);
        if (!brick)
          std::fill(row, row + nz, constant);
        else if (nz == 1)
          *row = brick->phi[Brick::offset(x, y, 0)];
        else
          std::copy_n(brick->phi + Brick::offset(x, y, 0), 8, row);
      }
  }
}

// Gradient of the trilinear field in a cell, normalised; `at` in cell coordinates.
Vec3f cellNormal(const float* v, const Vec3f& at) {
  constexpr int X = 9 * kRow, Y = kRow;
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

void extractVertices(Sampler& field, Coord brick, bool wantNormals, CellTable& table, std::vector<Vec3f>& positions,
                     std::vector<PackedNormal>& normals) {
  table = CellTable{};
  Slot slots[2][2][2];
  readSlots(field, brick, slots);
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

  Corners corners;
  readCorners(slots, field.band(), corners);
  const CellCases& cases = cellCases();
  positions.reserve(positions.size() + static_cast<size_t>(count));
  if (wantNormals) normals.reserve(normals.size() + static_cast<size_t>(count));
  std::vector<Vec3f> extraPositions;
  std::vector<PackedNormal> extraNormals;
  for (int x = 0; x < 8; ++x)
    for (uint64_t left = table.active[x]; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left), y = bit >> 3, z = bit & 7;
      const int pattern = patternAt(signs, x, bit);
      const CellCase* c = &cases.separated[static_cast<size_t>(pattern)];
      bool joined = false;
      if (c->foldedFace >= 0) {
        table.folded = true;
        const int axis = c->foldedFace / 2, side = c->foldedFace & 1;
        Coord beyond = brick * kBrickEdge + Coord{x, y, z};
        (axis == 0 ? beyond.x : axis == 1 ? beyond.y : beyond.z) += side ? 1 : -1;
        joined = cases.separated[static_cast<size_t>(patternOf(field, beyond))].foldedFace == (c->foldedFace ^ 1);
        if (joined) c = &cases.joined[static_cast<size_t>(pattern)];
      }
      if (c->loops > 1 || joined) {
        table.special[x] |= uint64_t{1} << bit;
        table.specials.push_back({static_cast<uint16_t>(x * 64 + bit), static_cast<uint8_t>(pattern), joined,
                                  static_cast<uint16_t>(static_cast<size_t>(count) + extraPositions.size())});
      }
      const float* v = corners.phi + cornerOffset(x, y, z);
      const Vec3f base(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
      for (int loop = 0; loop < c->loops; ++loop) {
        // The mean of the loop's edge crossings, edges in their fixed order.
        float sum[3] = {};
        int n = 0;
        for (unsigned edges = c->edges; edges != 0; edges &= edges - 1) {
          const int e = std::countr_zero(edges);
          if (c->loopOfEdge[e] != loop) continue;
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
        const Vec3f at(sum[0] * inverse, sum[1] * inverse, sum[2] * inverse);
        (loop == 0 ? positions : extraPositions).push_back(base + at);
        if (wantNormals) (loop == 0 ? normals : extraNormals).push_back(PackedNormal::pack(cellNormal(v, at)));
      }
    }
  table.vertices = static_cast<uint16_t>(static_cast<size_t>(count) + extraPositions.size());
  positions.insert(positions.end(), extraPositions.begin(), extraPositions.end());
  normals.insert(normals.end(), extraNormals.begin(), extraNormals.end());
}

void extractQuads(Sampler& field, Coord brick, const std::array<VertexSource, 8>& sources, std::vector<std::array<VertexRef, 4>>& quads) {
  Slot slots[2][2][2];
  readSlots(field, brick, slots);
  SignWords signs;
  readSigns(slots, signs);
  if (signs.uniform) return;
  // Around an edge, counter-clockwise seen from its upper end: steps along the two axes after its own.
  constexpr int kAround[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int x = 0; x < 8; ++x) {
      const uint64_t low = signs.word[x][0][0];
      const uint64_t high = axis == 0 ? signs.word[x + 1][0][0] : axis == 1 ? signs.word[x][1][0] : signs.word[x][0][1];
      for (uint64_t left = low ^ high; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const int voxel[3] = {x, bit >> 3, bit & 7};
        std::array<VertexRef, 4> quad;
        Vec3f at[4];
        for (int i = 0; i < 4; ++i) {
          int cell[3] = {voxel[0], voxel[1], voxel[2]};
          cell[u] += kAround[i][0];
          cell[v] += kAround[i][1];
          const int lx = cell[0] < 0, ly = cell[1] < 0, lz = cell[2] < 0;
          const VertexSource& source = sources[static_cast<size_t>(lx * 4 + ly * 2 + lz)];
          const int edge = axis * 4 + (kAround[i][0] < 0) * 2 + (kAround[i][1] < 0);
          const uint32_t index = source.table->vertexOf(((cell[0] & 7) << 6) | ((cell[1] & 7) << 3) | (cell[2] & 7), edge);
          quad[static_cast<size_t>(i)] =
              static_cast<VertexRef>(index | static_cast<uint32_t>(lx) << 13 | static_cast<uint32_t>(ly) << 14 | static_cast<uint32_t>(lz) << 15);
          at[i] = source.positions[index] - Vec3f(8.0f * static_cast<float>(lx), 8.0f * static_cast<float>(ly), 8.0f * static_cast<float>(lz));
        }
        // Outwards is up the edge when its lower voxel is inside.
        if (!((low >> bit) & 1)) {
          std::swap(quad[1], quad[3]);
          std::swap(at[1], at[3]);
        }
        if ((at[1] - at[3]).squaredNorm() < (at[0] - at[2]).squaredNorm()) quad = {quad[1], quad[2], quad[3], quad[0]};
        quads.push_back(quad);
      }
    }
  }
}

}  // namespace argil::clay
