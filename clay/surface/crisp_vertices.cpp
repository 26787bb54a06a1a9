#include "clay/surface/crisp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <utility>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/crisp_vertex.h"
#include "clay/surface/tangent_plane.h"

namespace argil::clay {

namespace {

// Cells that bend by less than the first (RMS, voxels) say best where their face is; on a ball of five voxels cells
// bend by 0.025, so where few of them are flat, those that bend by less than the second count too.
constexpr float kFlat = 0.02f, kCurved = 0.04f;
// Of all planes: with more of them flat the others lie across the crease, with fewer on a curved face.
constexpr float kFlatShare = 0.7f;
// Planes of curved cells find two faces on a rounding too. A cell in one of two voxels bends by less than the first,
// and the plane through its corners has a slope above the second.
constexpr float kCreaseBend = 0.09f, kCreaseSlope = 0.93f;

constexpr int kAround = BrickSurroundings::kMargin, kCells = BrickSurroundings::kCells;

// Bits of a row's cells from −2 to 2 whose steps along the three axes are three at most, by the steps to the row.
constexpr std::array<unsigned, 5> kReachOfRow{0b11111, 0b11111, 0b01110, 0b00100, 0};

// Whether a crease goes through a cell, not a rounding of two voxels or more.
bool creased(const CellView& cell) {
  if (bendOf(cell.phi, cell.stepX, cell.stepY) > kCreaseBend * kCreaseBend) return true;
  Vec3f slope = Vec3f::Zero();
  for (int c = 0; c < 8; ++c)
    slope += 0.25f * cell.corner(c) * Vec3f(c & 4 ? 1.0f : -1.0f, c & 2 ? 1.0f : -1.0f, c & 1 ? 1.0f : -1.0f);
  return slope.squaredNorm() < kCreaseSlope * kCreaseSlope;
}

// The cells that have both signs among their corners.
class CrossedCells {
 public:
  CrossedCells(const BrickSurroundings& around, const BrickSurroundings::Range& range) {
    const auto& [low, high] = range;
    uint16_t inside[BrickSurroundings::kVoxels][BrickSurroundings::kVoxels];
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        unsigned bits = 0;
        const float* values = around.at(x, y, 0);
        for (int z = low[2]; z <= high[2]; ++z) bits |= static_cast<unsigned>(values[z] < 0) << z;
        inside[x][y] = static_cast<uint16_t>(bits);
      }
    const unsigned some = ((1u << (high[2] - low[2])) - 1) << low[2];
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y) {
        const unsigned a = inside[x][y], b = inside[x][y + 1], c = inside[x + 1][y], d = inside[x + 1][y + 1];
        const unsigned any = a | b | c | d, all = a & b & c & d;
        rows_[static_cast<size_t>(x * kCells + y)] = static_cast<uint16_t>((any | any >> 1) & ~(all & all >> 1) & some);
      }
  }

  // Bit i: cell z + i of the row.
  [[nodiscard]] unsigned from(int x, int y, int z) const { return rows_[static_cast<size_t>(x * kCells + y)] >> z; }

 private:
  std::array<uint16_t, kCells * kCells> rows_;
};

// What cells that are `kinked` look at.
BrickSurroundings::Range rangeAround(const KinkedCells& cells) {
  BrickSurroundings::Range range;
  std::swap(range.low, range.high);
  for (const uint16_t i : cells.kinked) {
    const int cell = cells.cells[i], at[3] = {cell >> 6, (cell >> 3) & 7, cell & 7};
    for (size_t axis = 0; axis < 3; ++axis) {
      range.low[axis] = std::min(range.low[axis], at[axis]);
      range.high[axis] = std::max(range.high[axis], at[axis] + 2 * kAround + 1);
    }
  }
  return range;
}

}  // namespace

void crispVertices(Sampler& field, Coord brick, const KinkedCells& cells, bool wantNormals, ExtractionBuffer& out) {
  const BrickSurroundings::Range range = rangeAround(cells);
  BrickSurroundings around;
  around.read(field, brick, range);
  const CrossedCells crossed(around, range);
  TangentPlanes planes(around, kCurved);
  std::array<TangentPlane, kMostCrispPlanes> near, flat;
  size_t sharp = 0;
  auto special = out.table.specials.begin();
  for (const uint16_t i : cells.kinked) {
    while (special != out.table.specials.end() && special->cell < cells.cells[i]) ++special;
    if (special != out.table.specials.end() && special->cell == cells.cells[i]) continue;
    const int x = cells.cells[i] >> 6, y = (cells.cells[i] >> 3) & 7, z = cells.cells[i] & 7;
    size_t count = 0;
    for (int px = x; px <= x + 2 * kAround; ++px)
      for (int py = y; py <= y + 2 * kAround; ++py)
        for (unsigned left = crossed.from(px, py, z) &
                             kReachOfRow[static_cast<size_t>(std::abs(px - x - kAround) + std::abs(py - y - kAround))];
             left != 0; left &= left - 1)
          if (const TangentPlane* plane = planes.at(px, py, z + std::countr_zero(left))) near[count++] = *plane;
    CreaseCell cell;
    cell.low = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    cell.draft = out.positions[i];
    cell.view = {around.at(x + kAround, y + kAround, z + kAround), BrickSurroundings::kStepX,
                 BrickSurroundings::kStepY};
    cell.edges = cellCases().separated[cells.patterns[i]].edges;
    size_t flats = 0;
    for (size_t k = 0; k < count; ++k) {
      const float bend = (1 - near[k].quality) * kCurved * kCurved;
      if (bend < kFlat * kFlat) (flat[flats++] = near[k]).quality = 1 - bend / (kFlat * kFlat);
    }
    cell.planes = {flat.data(), flats};
    CreaseVertex found;
    if (static_cast<float>(flats) >= kFlatShare * static_cast<float>(count)) found = placeCrisply(cell);
    if (found.kind == CreaseVertex::Kind::none && creased(cell.view)) {
      cell.planes = {near.data(), count};
      found = placeCrisply(cell);
    }
    if (found.kind == CreaseVertex::Kind::none) continue;
    out.positions[i] = found.position;
    if (found.kind != CreaseVertex::Kind::face) out.sharp[sharp++] = i;
    if (wantNormals) out.normals[i] = found.packedNormal();
  }
  out.table.sharp = {out.sharp.data(), sharp};
}

}  // namespace argil::clay
