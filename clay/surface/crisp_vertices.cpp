#include "clay/surface/crisp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "clay/kernels/cell_cases.h"
#include "clay/kernels/crease_kernels.h"
#include "clay/kernels/surface_kernels.h"
#include "clay/surface/crisp_vertex.h"
#include "clay/surface/tangent_plane.h"

namespace argil::clay {

namespace {

// Cells that bend by less than the first (RMS, voxels) say best where their face is; on a ball of five voxels cells
// bend by 0.025, so where few of them are flat, those that bend by less than the second count too.
constexpr float kFlat = 0.02f, kCurved = 0.04f;
// Of all planes: with more of them flat the others lie across the crease, with fewer on a curved face.
constexpr float kFlatShare = 0.7f;
// A cell in a rounding of two voxels bends by less than the first, and the plane through its corners has a slope above
// the second.
constexpr float kCreaseBend = 0.09f, kCreaseSlope = 0.93f;
// Cells of faces that turn less than a ball of 120 voxels bend by less, and around a corner of such faces there
// are so many of them: cells beside it that two faces do not explain are looked at again.
constexpr float kFlatFaces = 0.001f;
constexpr int kLeastFlat = 3;
// How much deeper than the cell's values two faces may be on the side where they are exact, in the mean (voxels): where
// a rounding of two voxels may be and where none is.
constexpr float kDeeper = 0.03f, kDeeperAtCrease = 0.08f;

constexpr int kAround = BrickSurroundings::kMargin, kCells = BrickSurroundings::kCells;

// The rows around a cell's from two lower along x and y, and the bits of their cells from −2 to 2 along z whose steps
// along the three axes are three at most.
struct RowReach {
  int offset;
  unsigned cells;
};
constexpr std::array<RowReach, 21> kReach = [] {
  constexpr unsigned kBits[]{0b11111, 0b11111, 0b01110, 0b00100, 0};
  std::array<RowReach, 21> reach{};
  size_t count = 0;
  for (int x = -kAround; x <= kAround; ++x)
    for (int y = -kAround; y <= kAround; ++y)
      if (const unsigned bits = kBits[(x < 0 ? -x : x) + (y < 0 ? -y : y)])
        reach[count++] = {(x + kAround) * kCells + y + kAround, bits};
  return reach;
}();

// Whether a cell bends by more than `bend` (RMS, voxels), or the plane through its corners has less than this slope.
bool bends(const CellView& cell, float bend, float slope) {
  if (bendOf(cell.phi, cell.stepX, cell.stepY) > bend * bend) return true;
  const float *p = cell.phi, *q = p + cell.stepX;
  const int y = cell.stepY;
  const float a = p[0] + p[1], b = p[y] + p[y + 1], c = q[0] + q[1], d = q[y] + q[y + 1];
  const Vec3f sum((c + d) - (a + b), (b + d) - (a + c),
                  ((p[1] + p[y + 1]) + (q[1] + q[y + 1])) - ((p[0] + p[y]) + (q[0] + q[y])));
  return sum.squaredNorm() < 16 * slope * slope;
}

// Whether a crease goes through a cell, not a rounding of two voxels or more.
bool creased(const CellView& cell) {
  return bends(cell, kCreaseBend, kCreaseSlope);
}

// The cell or a crossed one that shares a face with it. (Deeper in the clay even the field of a rounding has kinks.)
bool creasedAround(const CellView& cell) {
  if (creased(cell)) return true;
  for (int face = 0; face < 6; ++face) {
    const CellView next = cell.beyond(face);
    if (next.pattern() % 255 != 0 && creased(next)) return true;
  }
  return false;
}

// Whether some of the planes are of flat faces, two of them turned from each other. Changes what the planes are rated.
bool betweenFlatFaces(NearPlanes& planes) {
  if (ratePlanes(planes, kFlatFaces, PlaneTrust::any) < kLeastFlat) return false;
  int first = -1;
  for (int i = 0; i < planes.count; ++i) {
    if (planes.quality[i] <= 0) continue;
    if (first < 0) first = i;
    float cosine = 0;
    for (const auto& row : planes.normal) cosine += row[i] * row[first];
    if (1 - cosine > kLeastTurn) return true;
  }
  return false;
}

// Whether the cell with these corners is crossed and kinked.
bool isKinked(const float (&corners)[8]) {
  int inside = 0;
  for (const float value : corners) inside += value < 0;
  if (inside % 8 == 0) return false;
  const CellView cell{corners, 4, 2};
  return bends(cell, kKinkedBend, kKinkedSlope) || (bends(cell, kBentBend, 0) && bends(cell, INFINITY, kBentSlope));
}

// Of the cells at one side of a brick along an axis that are set in words, those beside a kinked cell of the next
// brick.
template <int axis, int side>
void addBesideNext(Sampler& field, Coord brick, const CreaseCells& cells, const uint64_t (&known)[8],
                   uint64_t (&words)[8], bool& readsBeyond) {
  constexpr uint64_t kSide = axis == 0 ? ~uint64_t{0}
                                       : (axis == 1 ? uint64_t{0xff} : uint64_t{0x0101010101010101})
                                             << (side * (axis == 1 ? 56 : 7));
  constexpr int kFirst = axis == 0 ? 7 * side : 0, kLast = axis == 0 ? kFirst : 7;
  constexpr Coord kStep{axis == 0 ? 2 * side - 1 : 0, axis == 1 ? 2 * side - 1 : 0, axis == 2 ? 2 * side - 1 : 0};
  // Of the two layers of corners that the cell beyond has, one is that of the cell here.
  constexpr int kOwn = side == 0 ? 0 : 8, kOuter = side == 0 ? 7 : 1;
  constexpr int kBit[3]{4, 2, 1};
  Slot next;
  bool asked = false;
  for (int x = kFirst; x <= kLast; ++x)
    for (uint64_t left = cells.bent[x] & kSide & ~known[x]; left != 0; left &= left - 1) {
      if (!asked) next = field.slot(brick + kStep);
      asked = true;
      const int bit = std::countr_zero(left);
      std::array<int, 3> at{x, bit >> 3, bit & 7};
      float values[8];
      for (int c = 0; c < 8; ++c) {
        std::array<int, 3> corner{at[0] + (c >> 2), at[1] + (c >> 1 & 1), at[2] + (c & 1)};
        const bool own = ((c & kBit[axis]) != 0) == (side == 0);
        corner[axis] = own ? kOwn : kOuter;
        float& value = values[c];
        if (own) {
          value = cells.corners[cornerOffset(corner[0], corner[1], corner[2])];
        } else if (std::max(corner[(axis + 1) % 3], corner[(axis + 2) % 3]) < kBrickEdge) {
          value = next.phi(Brick::offset(corner[0], corner[1], corner[2]), field.band(), field.step());
        } else {
          value = field.voxel((brick + kStep) * kBrickEdge + Coord{corner[0], corner[1], corner[2]});
        }
      }
      if (isKinked(values)) words[x] |= left & (0 - left);
    }
  readsBeyond |= asked;
}

// Cells that may have a vertex on a crease: kinked ones, and bent ones beside one of them.
class Suspects {
 public:
  Suspects(Sampler& field, Coord brick, const CreaseCells& cells, bool& readsBeyond) {
    constexpr uint64_t kLowZ = 0x0101010101010101ull, kHighZ = kLowZ << 7;
    const uint64_t(&k)[8] = cells.kinked;
    for (int x = 0; x < 8; ++x) {
      uint64_t beside = (k[x] & ~kHighZ) << 1 | (k[x] & ~kLowZ) >> 1 | k[x] << 8 | k[x] >> 8;
      if (x > 0) beside |= k[x - 1];
      if (x < 7) beside |= k[x + 1];
      words_[x] = k[x] | (cells.bent[x] & beside);
    }
    // Those beside a cell of another brick.
    uint64_t inside[8];
    std::copy_n(words_, 8, inside);
    addBesideNext<0, 0>(field, brick, cells, inside, words_, readsBeyond);
    addBesideNext<0, 1>(field, brick, cells, inside, words_, readsBeyond);
    addBesideNext<1, 0>(field, brick, cells, inside, words_, readsBeyond);
    addBesideNext<1, 1>(field, brick, cells, inside, words_, readsBeyond);
    addBesideNext<2, 0>(field, brick, cells, inside, words_, readsBeyond);
    addBesideNext<2, 1>(field, brick, cells, inside, words_, readsBeyond);
    for (const uint64_t word : words_) any_ |= word != 0;
    readsBeyond |= any_;
  }

  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] bool has(int cell) const { return (words_[cell >> 6] >> (cell & 63) & 1) != 0; }

  // What they look at.
  [[nodiscard]] BrickSurroundings::Range range() const {
    BrickSurroundings::Range range;
    std::swap(range.low, range.high);
    for (int x = 0; x < 8; ++x)
      for (uint64_t left = words_[x]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left), at[3] = {x, bit >> 3, bit & 7};
        for (size_t axis = 0; axis < 3; ++axis) {
          range.low[axis] = std::min(range.low[axis], at[axis]);
          range.high[axis] = std::max(range.high[axis], at[axis] + 2 * kAround + 1);
        }
      }
    return range;
  }

 private:
  uint64_t words_[8];
  bool any_ = false;
};

// The cells around a brick that have both signs among their corners, and their planes.
class CrossedCells {
 public:
  CrossedCells(const BrickSurroundings& around, const BrickSurroundings::Range& range) {
    const auto& [low, high] = range;
    const unsigned some = ((1u << (high[2] - low[2])) - 1) << low[2];
    std::array<BlockCell, kMostBrickPlanes + kPlanePadding> cells;
    size_t count = 0;
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y) {
        const unsigned a = around.inside(x, y), b = around.inside(x, y + 1), c = around.inside(x + 1, y),
                       d = around.inside(x + 1, y + 1);
        const unsigned any = a | b | c | d, all = a & b & c & d;
        const unsigned crossed = (any | any >> 1) & ~(all & all >> 1) & some;
        rows_[static_cast<size_t>(x * kCells + y)] = {static_cast<uint16_t>(crossed), static_cast<uint16_t>(count)};
        for (unsigned left = crossed; left != 0; left &= left - 1)
          cells[count++] = static_cast<BlockCell>(x << 8 | y << 4 | std::countr_zero(left));
      }
    std::fill_n(cells.data() + count, kPlanePadding, cells[0]);
    cellPlanes(around.at(0, 0, 0), BrickSurroundings::kStepX, BrickSurroundings::kStepY, kAround, cells.data(),
               static_cast<int>(count), planes_);
  }

  // The planes up to three steps away from a cell of the brick, as numbers relative to it.
  void near(int x, int y, int z, const Vec3f& low, NearPlanes& out) const {
    std::array<uint16_t, kMostNearPlanes + kPlanePadding> indices;
    size_t count = 0;
    const Row* rows = &rows_[static_cast<size_t>(x * kCells + y)];
    for (const RowReach& reach : kReach) {
      const Row& row = rows[reach.offset];
      // Those of a row follow each other. Five are written, needed or not: how many there are is hard to foresee.
      const unsigned reached = row.crossed & reach.cells << z;
      const auto at = static_cast<unsigned>(row.first + std::popcount(row.crossed & ((reached & (0 - reached)) - 1)));
      for (unsigned i = 0; i < 5; ++i) indices[count + i] = static_cast<uint16_t>(at + i);
      count += static_cast<size_t>(std::popcount(reached));
    }
    std::fill_n(indices.data() + count, kPlanePadding, uint16_t{0});
    pickPlanes(planes_, indices.data(), static_cast<int>(count), low.data(), out);
  }

 private:
  struct Row {
    uint16_t crossed;  // Bit z: the cell is crossed.
    uint16_t first;    // Index of its first plane.
  };
  std::array<Row, kCells * kCells> rows_;
  BrickPlanes planes_;
};

// Around a corner of three faces every crossed cell bends, and of a face there may be no plane that counts: there the
// fine grade's step looks at all cells two steps away. That costs many times what a cell does, so only flat faces get
// it.
class Corners {
 public:
  explicit Corners(const BrickSurroundings& around) : around_(around) {}
  CreaseVertex place(CreaseCell cell) {
    if (!fits_) fits_.emplace(around_, kFlat);
    std::array<TangentPlane, 125> planes;
    const auto at = [&cell](int axis) { return static_cast<int>(cell.low[axis]) + kAround; };
    cell.planes = {planes.data(), fits_->around(at(0), at(1), at(2), planes.data())};
    return placeAtCrease(cell);
  }

 private:
  const BrickSurroundings& around_;
  std::optional<TangentPlanes> fits_;
};

// A vertex of a cell from the planes around it.
CreaseVertex placeVertex(const CreaseCell& cell, NearPlanes& planes, Corners* corners) {
  const bool kinked = creased(cell.view);
  const float deeper = kinked ? kDeeperAtCrease : kDeeper;
  const int all = ratePlanes(planes, kCurved, PlaneTrust::steep), flat = ratePlanes(planes, kFlat, PlaneTrust::steep);
  CreaseVertex found;
  if (static_cast<float>(flat) >= kFlatShare * static_cast<float>(all)) found = placeCrisply(cell, planes, deeper, 2);
  if (found.kind == CreaseVertex::Kind::none && (kinked || creasedAround(cell.view))) {
    ratePlanes(planes, kCurved, PlaneTrust::steep);
    found = placeCrisply(cell, planes, deeper, 3);
    if (found.kind == CreaseVertex::Kind::none) {
      ratePlanes(planes, kCurved, PlaneTrust::any);
      found = placeCrisply(cell, planes, deeper, 1);
    }
  }
  const bool open = found.kind == CreaseVertex::Kind::none ? kinked : !found.explained;
  if (!open || !corners || !betweenFlatFaces(planes)) return found;
  const CreaseVertex corner = corners->place(cell);
  return corner.kind == CreaseVertex::Kind::corner || found.kind == CreaseVertex::Kind::none ? corner : found;
}

}  // namespace

void crispVertices(Sampler& field, Coord brick, const CreaseCells& cells, bool wantNormals, Grade grade,
                   ExtractionBuffer& out) {
  const bool curvedAlone = grade == Grade::fine;
  const Suspects suspects(field, brick, cells, out.table.readsBeyond);
  if (!suspects.any()) return;
  const BrickSurroundings::Range range = suspects.range();
  BrickSurroundings around;
  around.read(field, brick, range);
  const CrossedCells crossed(around, range);
  Corners corners(around);
  NearPlanes planes;
  size_t sharp = 0;
  auto special = out.table.specials.begin();
  for (int k = 0; k < cells.count; ++k) {
    if (!suspects.has(cells.cells[k])) continue;
    while (special != out.table.specials.end() && special->cell < cells.cells[k]) ++special;
    const bool several = special != out.table.specials.end() && special->cell == cells.cells[k];
    const int x = cells.cells[k] >> 6, y = (cells.cells[k] >> 3) & 7, z = cells.cells[k] & 7;
    CreaseCell cell;
    cell.low = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    cell.view = {around.at(x + kAround, y + kAround, z + kAround), BrickSurroundings::kStepX,
                 BrickSurroundings::kStepY};
    crossed.near(x, y, z, cell.low, planes);
    const CellCases& cases = cellCases();
    const CellCase& c = (several && special->joined ? cases.joined : cases.separated)[cells.patterns[k]];
    for (int loop = 0; loop < (several ? c.loops : 1); ++loop) {
      const size_t i = loop == 0 ? static_cast<size_t>(k) : special->extraFirst + static_cast<size_t>(loop) - 1;
      cell.draft = out.positions[i];
      cell.edges = several ? c.edgesOf(loop) : c.edges;
      const CreaseVertex found = placeVertex(cell, planes, curvedAlone ? nullptr : &corners);
      if (found.kind == CreaseVertex::Kind::none) continue;
      if (curvedAlone && (!found.curved || found.kind != CreaseVertex::Kind::edge)) continue;
      out.positions[i] = found.position;
      if (found.kind != CreaseVertex::Kind::face) out.sharp[sharp++] = static_cast<uint16_t>(i);
      if (wantNormals) out.normals[i] = found.packedNormal();
    }
  }
  std::sort(out.sharp.begin(), out.sharp.begin() + static_cast<std::ptrdiff_t>(sharp));
  out.table.sharp = {out.sharp.data(), sharp};
}

}  // namespace argil::clay
