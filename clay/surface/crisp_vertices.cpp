#include "clay/surface/crisp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "clay/kernels/cell_cases.h"
#include "clay/surface/crisp_vertex.h"

namespace argil::clay {

namespace {

// Planes are taken from cells up to two away along each axis, so voxels from −2 to 10 are looked at.
constexpr int kAround = 2;
constexpr int kVoxels = kBrickEdge + 1 + 2 * kAround, kCells = kVoxels - 1;
constexpr int kStepX = kVoxels * kVoxels, kStepY = kVoxels;

// Bits of a row's cells from −2 to 2 whose steps along the three axes are LIMIT at most, by the steps to the row.
constexpr std::array<unsigned, 5> kReachOfRow{0b11111, 0b11111, 0b01110, 0b00100, 0};

// Voxels from −2 to 10 along each axis in whose part `low` to `high` kinked cells look around.
struct Surroundings {
  std::array<int, 3> low, high;  // voxels, counted from −2; `high` is the last
  std::array<float, kVoxels * kVoxels * kVoxels> phi;
  std::array<uint16_t, kCells * kCells> active;  // bit z: the cell has both signs among its corners

  [[nodiscard]] static int at(int x, int y, int z) { return x * kStepX + y * kStepY + z; }

  void read(Sampler& field, Coord brick) {
    const float band = field.band(), step = field.step();
    Slot slots[3][3][3];
    for (int x = low[0] < kAround ? 0 : 1; x <= (high[0] >= kAround + kBrickEdge ? 2 : 1); ++x)
      for (int y = low[1] < kAround ? 0 : 1; y <= (high[1] >= kAround + kBrickEdge ? 2 : 1); ++y)
        for (int z = low[2] < kAround ? 0 : 1; z <= (high[2] >= kAround + kBrickEdge ? 2 : 1); ++z)
          slots[x][y][z] = field.slot(brick + Coord{x - 1, y - 1, z - 1});
    uint16_t inside[kVoxels][kVoxels];
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const int vx = x - kAround + kBrickEdge, vy = y - kAround + kBrickEdge;
        const Slot(&row)[3] = slots[vx >> 3][vy >> 3];
        for (int z = low[2]; z <= high[2];) {
          const int vz = z - kAround + kBrickEdge, in = vz & 7, n = std::min(kBrickEdge - in, high[2] + 1 - z);
          const Slot slot = row[vz >> 3];
          float* out = &phi[static_cast<size_t>(at(x, y, z))];
          if (const Brick* b = slot.brick())
            b->read(Brick::offset(vx & 7, vy & 7, in), n, out, step);
          else
            std::fill_n(out, n, slot.phi(0, band));
          z += n;
        }
        unsigned bits = 0;
        const float* values = &phi[static_cast<size_t>(at(x, y, 0))];
        for (int z = low[2]; z <= high[2]; ++z) bits |= static_cast<unsigned>(values[z] < 0) << z;
        inside[x][y] = static_cast<uint16_t>(bits);
      }
    const unsigned some = ((1u << (high[2] - low[2])) - 1) << low[2];
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y) {
        const unsigned a = inside[x][y], b = inside[x][y + 1], c = inside[x + 1][y], d = inside[x + 1][y + 1];
        const unsigned any = a | b | c | d, all = a & b & c & d;
        active[static_cast<size_t>(x * kCells + y)] =
            static_cast<uint16_t>((any | any >> 1) & ~(all & all >> 1) & some);
      }
  }
};

// Tangent planes of cells, made when first asked for.
class Planes {
 public:
  explicit Planes(const Surroundings& around) : around_(around) {}

  // Null where the cell is bent.
  const TangentPlane* at(int x, int y, int z) {
    const auto cell = static_cast<size_t>((x * kCells + y) * kCells + z);
    if (state_[cell] == 0) state_[cell] = fit(x, y, z, planes_[cell]) ? 2 : 1;
    return state_[cell] == 2 ? &planes_[cell] : nullptr;
  }

 private:
  // A cell that bends by less than this (RMS, voxels) lies on one face; its plane is off by about as much.
  static constexpr float kFlat = 0.02f;
  // A field much flatter than a distance says little of where the surface is.
  static constexpr float kSteep = 0.5f;

  bool fit(int x, int y, int z, TangentPlane& out) const {
    const float* v = &around_.phi[static_cast<size_t>(Surroundings::at(x, y, z))];
    const float v0 = v[0], v1 = v[1], v2 = v[kStepY], v3 = v[kStepY + 1], v4 = v[kStepX], v5 = v[kStepX + 1],
                v6 = v[kStepX + kStepY], v7 = v[kStepX + kStepY + 1];
    const float a = v0 + v1, b = v2 + v3, c = v4 + v5, d = v6 + v7, e = v1 - v0, f = v3 - v2, g = v5 - v4, h = v7 - v6;
    const float xy = (a - b) - (c - d), yz = (f - e) + (h - g), zx = (g + h) - (e + f), xyz = (e - f) - (g - h);
    const float bend = ((xy * xy + yz * yz) + (zx * zx + xyz * xyz)) * (1.0f / 64);
    if (bend > kFlat * kFlat) return false;
    const Vec3f slope = 0.25f * Vec3f((c + d) - (a + b), (b + d) - (a + c), (e + f) + (g + h));
    const float length = std::sqrt(slope.squaredNorm());
    if (length < kSteep) return false;
    const float scale = 1 / length;
    const Vec3f centre(static_cast<float>(x - kAround) + 0.5f, static_cast<float>(y - kAround) + 0.5f,
                       static_cast<float>(z - kAround) + 0.5f);
    out = {centre, slope * scale, ((a + b) + (c + d)) * (0.125f * scale), 1 - bend / (kFlat * kFlat)};
    return true;
  }

  const Surroundings& around_;
  std::array<uint8_t, kCells * kCells * kCells> state_{};
  std::array<TangentPlane, kCells * kCells * kCells> planes_;
};

}  // namespace

void crispVertices(Sampler& field, Coord brick, const KinkedCells& cells, bool wantNormals, ExtractionBuffer& out) {
  Surroundings around;
  around.low.fill(kVoxels);
  around.high.fill(0);
  for (const uint16_t i : cells.kinked) {
    const int cell = cells.cells[i], at[3] = {cell >> 6, (cell >> 3) & 7, cell & 7};
    for (size_t axis = 0; axis < 3; ++axis) {
      around.low[axis] = std::min(around.low[axis], at[axis]);
      around.high[axis] = std::max(around.high[axis], at[axis] + 2 * kAround + 1);
    }
  }
  around.read(field, brick);
  Planes planes(around);
  std::array<TangentPlane, kMostCrispPlanes> near;
  size_t sharp = 0;
  auto special = out.table.specials.begin();
  for (const uint16_t i : cells.kinked) {
    while (special != out.table.specials.end() && special->cell < cells.cells[i]) ++special;
    if (special != out.table.specials.end() && special->cell == cells.cells[i]) continue;
    const int x = cells.cells[i] >> 6, y = (cells.cells[i] >> 3) & 7, z = cells.cells[i] & 7;
    size_t count = 0;
    for (int px = x; px <= x + 2 * kAround; ++px)
      for (int py = y; py <= y + 2 * kAround; ++py)
        for (unsigned left = (around.active[static_cast<size_t>(px * kCells + py)] >> z) &
                             kReachOfRow[static_cast<size_t>(std::abs(px - x - kAround) + std::abs(py - y - kAround))];
             left != 0; left &= left - 1)
          if (const TangentPlane* plane = planes.at(px, py, z + std::countr_zero(left))) near[count++] = *plane;
    CreaseCell cell;
    cell.low = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    cell.draft = out.positions[i];
    cell.view = {&around.phi[static_cast<size_t>(Surroundings::at(x + kAround, y + kAround, z + kAround))], kStepX,
                 kStepY};
    cell.edges = cellCases().separated[cells.patterns[i]].edges;
    cell.planes = {near.data(), count};
    const CreaseVertex found = placeCrisply(cell);
    if (found.kind == CreaseVertex::Kind::none) continue;
    out.positions[i] = found.position;
    if (found.kind != CreaseVertex::Kind::face) out.sharp[sharp++] = i;
    if (wantNormals) out.normals[i] = found.packedNormal();
  }
  out.table.sharp = {out.sharp.data(), sharp};
}

}  // namespace argil::clay
