#include "clay/surface/sharp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <bitset>
#include <cmath>
#include <optional>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/bent_vertex.h"
#include "clay/surface/crease_vertex.h"

namespace argil::clay {

namespace {

// RMS misfit of a linear field to the eight corners, voxels. Above it a cell may hold a crease: one that cuts off 0.03
// of a cell bends it that much, and so does a sphere of 30 voxels.
constexpr float kBent = 0.006f;

constexpr int kVoxels = kBrickEdge + 1 + 2 * kSharpMargin;  // the block of voxels that is read: from −2 to 10
constexpr int kCells = kVoxels - 1;
constexpr int kStepX = kVoxels * kVoxels, kStepY = kVoxels;

// Bent parts of a cell's field: the four of its eight Walsh coefficients that a linear field does not have.
float bend2(float v0, float v1, float v2, float v3, float v4, float v5, float v6, float v7) {
  const float a = v0 + v1, b = v2 + v3, c = v4 + v5, d = v6 + v7;  // sums and differences along z, for each (x, y)
  const float e = v1 - v0, f = v3 - v2, g = v5 - v4, h = v7 - v6;
  const float xy = (a - b) - (c - d), yz = (f - e) + (h - g), zx = (g + h) - (e + f), xyz = (e - f) - (g - h);
  return (xy * xy + yz * yz) + (zx * zx + xyz * xyz);  // 64 times the mean square
}

struct Block {
  float phi[kVoxels * kVoxels * kVoxels];

  [[nodiscard]] static int at(int x, int y, int z) { return (x * kVoxels + y) * kVoxels + z; }
  [[nodiscard]] static std::array<int, 8> corners(int base) {
    return {base,          base + 1,          base + kStepY,          base + kStepY + 1,
            base + kStepX, base + kStepX + 1, base + kStepX + kStepY, base + kStepX + kStepY + 1};
  }
  [[nodiscard]] float bent(int base) const {
    const float* v = phi + base;
    return bend2(v[0], v[1], v[kStepY], v[kStepY + 1], v[kStepX], v[kStepX + 1], v[kStepX + kStepY],
                 v[kStepX + kStepY + 1]);
  }
};

// Which cells of a block are bent, and those beside them: there the draft may be off.
struct Suspects {
  uint8_t flag[kCells * kCells * kCells];

  explicit Suspects(const Block& block) {
    uint8_t bent[kCells * kCells * kCells], z[kCells * kCells * kCells], yz[kCells * kCells * kCells];
    for (int x = 0; x < kCells; ++x)
      for (int y = 0; y < kCells; ++y)
        for (int i = 0; i < kCells; ++i)
          bent[(x * kCells + y) * kCells + i] = block.bent(Block::at(x, y, i)) > 64 * kBent * kBent;
    // Spread by a cell along z, y, x; the outermost cells are not asked for.
    constexpr int n = kCells * kCells * kCells;
    const auto spread = [](const uint8_t* from, uint8_t* to, int step) {
      for (int i = step; i < n - step; ++i) to[i] = from[i - step] | from[i] | from[i + step];
    };
    std::fill_n(z, n, uint8_t{0});
    std::fill_n(yz, n, uint8_t{0});
    std::fill_n(flag, n, uint8_t{0});
    spread(bent, z, 1);
    spread(z, yz, kCells);
    spread(yz, flag, kCells * kCells);
  }
  [[nodiscard]] bool at(int x, int y, int z) const { return flag[(x * kCells + y) * kCells + z] != 0; }
};

void readBlock(Sampler& field, Coord brick, Block& block) {
  const float band = field.band(), step = field.step();
  Slot slots[3][3][3];
  for (int i = 0; i < 27; ++i)
    slots[i / 9][i / 3 % 3][i % 3] = field.slot(brick + Coord{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1});
  float* out = block.phi;
  for (int x = 0; x < kVoxels; ++x)
    for (int y = 0; y < kVoxels; ++y) {
      const int vx = x - kSharpMargin + kBrickEdge, vy = y - kSharpMargin + kBrickEdge;
      const Slot* row = slots[vx >> 3][vy >> 3];
      for (int z = 0; z < kVoxels; ++z) {
        const int vz = z - kSharpMargin + kBrickEdge;
        *out++ = row[vz >> 3].phi(Brick::offset(vx & 7, vy & 7, vz & 7), band, step);
      }
    }
}

// Linear fits of the cells around a brick, made when first asked for.
class Fits {
 public:
  explicit Fits(const Block& block) : block_(block) {}

  // The cell's tangent plane; null where the cell is bent or far from the surface.
  const TangentPlane* at(int x, int y, int z) {
    const int cell = (x * kCells + y) * kCells + z;
    if (state_[static_cast<size_t>(cell)] == 0) {
      const Vec3f centre(static_cast<float>(x - kSharpMargin) + 0.5f, static_cast<float>(y - kSharpMargin) + 0.5f,
                         static_cast<float>(z - kSharpMargin) + 0.5f);
      std::array<float, 8> v;
      const std::array<int, 8> corners = Block::corners(Block::at(x, y, z));
      for (size_t c = 0; c < 8; ++c) v[c] = block_.phi[corners[c]];
      state_[static_cast<size_t>(cell)] = fit(v, centre, planes_[static_cast<size_t>(cell)]) ? 2 : 1;
    }
    return state_[static_cast<size_t>(cell)] == 2 ? &planes_[static_cast<size_t>(cell)] : nullptr;
  }

 private:
  static bool fit(const std::array<float, 8>& v, const Vec3f& centre, TangentPlane& out) {
    const float bent = bend2(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]) * (1.0f / 64);
    if (bent > kFlat * kFlat) return false;
    const float low = (v[0] + v[1]) + (v[2] + v[3]), high = (v[4] + v[5]) + (v[6] + v[7]);
    const float mean = (low + high) * 0.125f;
    const Vec3f g = 0.25f * Vec3f(high - low, ((v[2] + v[3]) + (v[6] + v[7])) - ((v[0] + v[1]) + (v[4] + v[5])),
                                  ((v[1] + v[3]) + (v[5] + v[7])) - ((v[0] + v[2]) + (v[4] + v[6])));
    const float length = std::sqrt(g.x() * g.x() + g.y() * g.y() + g.z() * g.z());
    if (length < kSteep) return false;
    const float scale = 1.0f / length;
    out = {centre, g * scale, mean * scale, 1 - bent / (kFlat * kFlat)};
    return std::abs(out.distance) < kNear;
  }

  // A cell that bends by less than this (RMS, voxels) lies on one face; its plane is off by about as much.
  static constexpr float kFlat = 0.02f;
  // A field much flatter than a distance says little of where the surface is.
  static constexpr float kSteep = 0.5f;
  // Cells farther from the surface than this see other faces too.
  static constexpr float kNear = 1.5f;

  const Block& block_;
  std::array<uint8_t, kCells * kCells * kCells> state_{};
  std::array<TangentPlane, kCells * kCells * kCells> planes_;
};

}  // namespace

bool mayHoldCrease(const float* corners, const uint16_t* cells, int count) noexcept {
  constexpr int X = cornerOffset(1, 0, 0), Y = cornerOffset(0, 1, 0);
  for (int i = 0; i < count; ++i) {
    const float* v = corners + cornerOffset(cells[i] >> 6, (cells[i] >> 3) & 7, cells[i] & 7);
    if (bend2(v[0], v[1], v[Y], v[Y + 1], v[X], v[X + 1], v[X + Y], v[X + Y + 1]) > 64 * kBent * kBent) return true;
  }
  return false;
}

void sharpenVertices(Sampler& field, Coord brick, bool wantNormals, ExtractionBuffer& out) {
  CellTable& table = out.table;
  Block block;
  readBlock(field, brick, block);
  const Suspects suspects(block);
  Fits fits(block);
  std::array<TangentPlane, 125> planes;
  size_t rank = 0, sharp = 0;
  auto special = table.specials.begin();
  for (int x = 0; x < kBrickEdge; ++x) {
    for (uint64_t left = table.active[x]; left != 0; left &= left - 1, ++rank) {
      const int bit = std::countr_zero(left), y = bit >> 3, z = bit & 7;
      const CellTable::Special* several =
          special != table.specials.end() && special->cell == x * 64 + bit ? &*special++ : nullptr;
      const int cx = x + kSharpMargin, cy = y + kSharpMargin, cz = z + kSharpMargin;
      if (!suspects.at(cx, cy, cz)) continue;

      CreaseCell cell;
      cell.low = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
      cell.view = {block.phi + Block::at(cx, cy, cz), kStepX, kStepY};
      const unsigned pattern = cell.view.pattern();
      size_t count = 0;
      for (int dx = -2; dx <= 2; ++dx)
        for (int dy = -2; dy <= 2; ++dy)
          for (int dz = -2; dz <= 2; ++dz)
            if (const TangentPlane* plane = fits.at(cx + dx, cy + dy, cz + dz)) planes[count++] = *plane;
      cell.planes = {planes.data(), count};
      const CellCase& c = several && several->joined ? cellCases().joined[pattern] : cellCases().separated[pattern];
      const int loops = several ? c.loops : 1;
      for (int loop = 0; loop < loops; ++loop) {
        const size_t index = loop == 0 ? rank : several->extraFirst + static_cast<size_t>(loop) - 1;
        cell.draft = out.positions[index];
        cell.edges = c.edges;
        for (int e = 0; loops > 1 && e < 12; ++e)
          if (c.loopOfEdge[e] != loop) cell.edges = static_cast<uint16_t>(cell.edges & ~(1 << e));
        const CreaseVertex found = placeAtCrease(cell);
        if (found.kind == CreaseVertex::Kind::none) {
          const std::optional<SurfacePoint> bent = placeOnBend(cell.view, cell.edges);
          if (!bent) continue;
          out.positions[index] = bent->at + cell.low;
          if (wantNormals) out.normals[index] = PackedNormal::pack(bent->normal);
          continue;
        }
        out.positions[index] = found.position;
        if (found.kind != CreaseVertex::Kind::face) out.sharp[sharp++] = static_cast<uint16_t>(index);
        if (wantNormals) out.normals[index] = found.packedNormal();
      }
    }
  }
  std::sort(out.sharp.begin(), out.sharp.begin() + static_cast<std::ptrdiff_t>(sharp));
  table.sharp = {out.sharp.data(), sharp};
}

void splitAlongCreases(const std::array<VertexSource, 8>& sources, std::span<std::array<VertexRef, 4>> quads) {
  if (std::none_of(sources.begin(), sources.end(),
                   [](const VertexSource& s) { return s.table && !s.table->sharp.empty(); }))
    return;
  // Bit by vertex of each source: a look at a list for every corner would cost more than the quads.
  std::array<std::bitset<kVertexRefIndex + 1>, 8> marks;
  for (size_t k = 0; k < 8; ++k)
    if (sources[k].table)
      for (const uint16_t index : sources[k].table->sharp) marks[k].set(index);
  // Bit i: corner i is sharp. Set where the diagonal 1–3 must be taken in place of 0–2.
  constexpr unsigned kTurned = 1u << 0b1010 | 1u << 0b0111 | 1u << 0b1101;
  for (std::array<VertexRef, 4>& quad : quads) {
    unsigned on = 0;
    for (size_t i = 0; i < 4; ++i) {
      // Bits 13 to 15 of a reference are x, y, z.
      const int lower = quad[i] >> kVertexRefBits;
      on |= static_cast<unsigned>(
                marks[static_cast<size_t>((lower & 1) << 2 | (lower & 2) | lower >> 2)][quad[i] & kVertexRefIndex])
            << i;
    }
    if (kTurned >> on & 1) std::rotate(quad.begin(), quad.begin() + 1, quad.end());
  }
}

}  // namespace argil::clay
