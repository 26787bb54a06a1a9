#include "clay/surface/sharp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <bitset>
#include <optional>

#include "clay/kernels/cell_cases.h"
#include "clay/kernels/crease_kernels.h"
#include "clay/surface/bent_vertex.h"
#include "clay/surface/crease_vertex.h"
#include "clay/surface/tangent_plane.h"

namespace argil::clay {

namespace {

// A cell that bends by less than this (RMS, voxels) lies on one face; its plane is off by about as much.
constexpr float kFlat = 0.02f;

// RMS misfit of a linear field to the eight corners, voxels. Above the first the draft may be off by 0.03 voxel (a
// sphere of 30 voxels bends cells as much); above the second a cell may hold a crease (one of 18 does).
constexpr float kBent = 0.006f, kCreased = 0.010f;

// What flat faces may differ from the values of a cell beside a face that turns, voxels.
constexpr float kExplained = 0.02f;

constexpr int kCells = kBlockCells;
constexpr int kStepX = BrickSurroundings::kStepX, kStepY = BrickSurroundings::kStepY;

// Cells and those beside them. The outermost ones cannot be asked for.
class WithNeighbours {
 public:
  explicit WithNeighbours(const BlockCells& cells) {
    BlockCells spread;
    for (int x = 0; x < kCells; ++x)
      for (int y = 1; y < kCells - 1; ++y) {
        const unsigned near = cells[x][y - 1] | cells[x][y] | cells[x][y + 1];
        spread[x][y] = static_cast<uint16_t>(near | near << 1 | near >> 1);
      }
    for (int x = 1; x < kCells - 1; ++x)
      for (int y = 1; y < kCells - 1; ++y)
        rows_[x][y] = static_cast<uint16_t>(spread[x - 1][y] | spread[x][y] | spread[x + 1][y]);
  }
  [[nodiscard]] bool at(int x, int y, int z) const { return (rows_[x][y] >> z & 1) != 0; }

 private:
  BlockCells rows_;
};

// The squared sine of 30°: the middle one of three vertices on creases that stands out of the others' plane by more is
// on another face than the fourth vertex of the quad.
constexpr float kOnFace = 0.25f;
// The square of half a voxel: what stands out by less is on the others' face as well.
constexpr float kOffFace = 0.25f;

}  // namespace

bool mayHoldCrease(const float* corners, const uint16_t* cells, int count) noexcept {
  constexpr int X = cornerOffset(1, 0, 0), Y = cornerOffset(0, 1, 0);
  for (int i = 0; i < count; ++i) {
    const float* v = corners + cornerOffset(cells[i] >> 6, (cells[i] >> 3) & 7, cells[i] & 7);
    if (bendOf(v, X, Y) > kBent * kBent) return true;
  }
  return false;
}

void sharpenVertices(Sampler& field, Coord brick, bool wantNormals, const PlacedVertices& placed,
                     ExtractionBuffer& out) {
  CellTable& table = out.table;
  std::bitset<ExtractionBuffer::kMostVertices> curved;
  for (const uint16_t index : table.sharp) curved.set(index);
  BrickSurroundings around;
  around.read(field, brick, {});
  TangentPlanes fits(around, kFlat, kBent, kCreased);
  const WithNeighbours bendy(fits.slightlyBent()), suspects(fits.bent());
  std::array<TangentPlane, 125> planes;
  size_t rank = 0, sharp = 0;
  auto special = table.specials.begin();
  for (int x = 0; x < kBrickEdge; ++x) {
    for (uint64_t left = table.active[x]; left != 0; left &= left - 1, ++rank) {
      const int bit = std::countr_zero(left), y = bit >> 3, z = bit & 7;
      const CellTable::Special* several =
          special != table.specials.end() && special->cell == x * 64 + bit ? &*special++ : nullptr;
      const int cx = x + BrickSurroundings::kMargin, cy = y + BrickSurroundings::kMargin,
                cz = z + BrickSurroundings::kMargin;
      const bool bent = bendy.at(cx, cy, cz);
      if (!bent && !several) {
        if (curved[rank]) out.sharp[sharp++] = static_cast<uint16_t>(rank);
        continue;
      }

      CreaseCell cell;
      cell.low = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
      cell.view = {around.at(cx, cy, cz), kStepX, kStepY};
      const unsigned pattern = cell.view.pattern();
      const CellCase& c = several && several->joined ? cellCases().joined[pattern] : cellCases().separated[pattern];
      const int loops = several ? c.loops : 1;
      bool gathered = false;
      for (int loop = 0; loop < loops; ++loop) {
        const size_t index = loop == 0 ? rank : several->extraFirst + static_cast<size_t>(loop) - 1;
        if (!bent || placed[index]) {
          if (curved[index]) out.sharp[sharp++] = static_cast<uint16_t>(index);
          continue;
        }
        cell.draft = out.positions[index];
        cell.edges = loops > 1 ? c.edgesOf(loop) : c.edges;
        // Where all face one way there are no two faces, and grouping would find none.
        if (!gathered && suspects.at(cx, cy, cz) && !fits.agreeAround(cx, cy, cz, cell.draft, kLeastTurn)) {
          cell.planes = {planes.data(), fits.around(cx, cy, cz, planes.data())};
          gathered = true;
        }
        const CreaseVertex found = placeAtCrease(cell);
        if (curved[index] && (found.kind == CreaseVertex::Kind::none || found.misfit > kExplained)) {
          out.sharp[sharp++] = static_cast<uint16_t>(index);
          continue;
        }
        if (found.kind == CreaseVertex::Kind::none) {
          const std::optional<SurfacePoint> on = placeOnBend(cell.view, cell.edges);
          if (!on) continue;
          out.positions[index] = on->at + cell.low;
          if (wantNormals) out.normals[index] = PackedNormal::pack(on->normal);
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
  // Bit by reference to a vertex: a look at a list for every corner would cost more than the quads.
  uint64_t marks[(kVertexRefIndex + 1) / 8];
  for (unsigned k = 0; k < 8; ++k) {
    if (!sources[k].table) continue;
    // Of sources dx is the highest bit, of references z.
    uint64_t* of = marks + size_t{(k & 1) << 2 | (k & 2) | k >> 2} * ((kVertexRefIndex + 1) / 64);
    std::fill_n(of, sources[k].table->vertices / 64 + 1, uint64_t{0});
    for (const uint16_t index : sources[k].table->sharp) of[index >> 6] |= uint64_t{1} << (index & 63);
  }
  const auto on = [&marks](unsigned ref) { return static_cast<unsigned>(marks[ref >> 6] >> (ref & 63) & 1); };
  const auto at = [&sources](unsigned ref) -> Vec3f {
    const unsigned n = ref >> kVertexRefBits, lower = (n & 1) << 2 | (n & 2) | n >> 2;
    const Vec3f& p = sources[lower].positions[ref & kVertexRefIndex];
    return p - Vec3f(static_cast<float>(n & 1), static_cast<float>(n >> 1 & 1), static_cast<float>(n >> 2)) * 8;
  };
  // Bit i: corner i is sharp. Set where the diagonal 1–3 must be taken in place of 0–2.
  constexpr unsigned kOneThree = 1u << 0b1010;
  // Three are.
  constexpr unsigned kThree = 1u << 0b0111 | 1u << 0b1011 | 1u << 0b1101 | 1u << 0b1110;
  for (std::array<VertexRef, 4>& quad : quads) {
    const unsigned sharp = on(quad[0]) | on(quad[1]) << 1 | on(quad[2]) << 2 | on(quad[3]) << 3;
    bool turned = (kOneThree >> sharp & 1) != 0;
    if (kThree >> sharp & 1) {
      // The middle one is opposite to the one that is not sharp.
      const auto other = static_cast<unsigned>(std::countr_one(sharp)), middle = other ^ 2u;
      const Vec3f o = at(quad[other]), m = at(quad[middle]) - o, before = at(quad[middle ^ 1u]) - o,
                  after = at(quad[middle ^ 3u]) - o, normal = before.cross(after);
      const float height = m.dot(normal), length2 = std::min((m - before).squaredNorm(), (m - after).squaredNorm());
      const bool through = height * height <= std::max(kOnFace * length2, kOffFace) * normal.squaredNorm();
      turned = through == ((middle & 1) != 0);
    }
    if (turned) quad = {quad[1], quad[2], quad[3], quad[0]};
  }
}

}  // namespace argil::clay
