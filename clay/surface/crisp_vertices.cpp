#include "clay/surface/crisp_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "clay/kernels/cell_cases.h"
#include "clay/kernels/crisp_kernels.h"
#include "clay/kernels/surface_kernels.h"
#include "clay/surface/crease_vertex.h"
#include "clay/surface/tangent_plane.h"

namespace argil::clay {

namespace {

// Cells that bend by less than this (RMS, voxels) say best where their face is; on a ball of five voxels cells bend by
// 0.025, so where few of them are flat, those that bend by less than kCurvedPlane count too.
constexpr float kFlat = 0.02f;
// Of all planes: with more of them flat the others lie across the crease, with fewer on a curved face.
constexpr float kFlatShare = 0.7f;
// Cells of faces that turn less than a ball of 120 voxels bend by less, and around a corner of such faces there
// are so many of them: cells beside it that two faces do not explain are looked at again.
constexpr float kFlatFaces = 0.001f;
constexpr int kLeastFlat = 3;
// How far beside a cell a crease is in it, voxels: one that lies on a plane of the grid is in either cell.
constexpr float kBeside = 0.07f;
// A slope that is not 1 counts as a bend by this factor (voxels²).
constexpr float kBlurred = 0.05f;

// How a vertex is sought: first by flat planes; in a cell with a crease, or beside one, by those of curved faces, then
// by all.
constexpr CrispRule kByFlat{.most = kFlat, .blurred = kBlurred, .share = kFlatShare, .least = 2},
    kByCurved{.most = kCurvedPlane, .blurred = kBlurred, .share = 0, .least = 3},
    kByAll{.most = kCurvedPlane, .blurred = 0, .share = 0, .least = 1};

// CrispVertices::rounding of a crease, and of a rounding that has none.
constexpr float kSharp = 0.08f, kRounded = 0.13f;
// Voxels along a crease to those that tell the same, and the cosine of its turn between them.
constexpr float kAlong = 2.5f, kSameWay = 0.8f;

// The squared sum of the unit normals of faces that meet at 80°.
constexpr float kAcute = 1.65f;

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

  // Gives the cells that they, and the cells beside them, look at.
  [[nodiscard]] BrickSurroundings::Range range() const {
    BrickSurroundings::Range range;
    std::swap(range.low, range.high);
    for (int x = 0; x < 8; ++x)
      for (uint64_t left = words_[x]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left), at[3] = {x, bit >> 3, bit & 7};
        for (size_t axis = 0; axis < 3; ++axis) {
          range.low[axis] = std::min(range.low[axis], std::max(at[axis] - 1, 0));
          range.high[axis] = std::max(range.high[axis], std::min(at[axis] + 1, kBrickEdge - 1) + 2 * kAround + 1);
        }
      }
    return range;
  }

 private:
  uint64_t words_[8];
  bool any_ = false;
};

// The cells around a brick that have both signs among their corners, and the planes of those that do not bend too much
// for any rule.
class CrossedCells {
 public:
  CrossedCells(const BrickSurroundings& around, const BrickSurroundings::Range& range) {
    const auto& [low, high] = range;
    const unsigned some = ((1u << (high[2] - low[2])) - 1) << low[2];
    std::array<BlockCell, BlockPlanes::kMost + BlockPlanes::kPadding> cells;
    size_t count = 0;
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y) {
        const unsigned a = around.inside(x, y), b = around.inside(x, y + 1), c = around.inside(x + 1, y),
                       d = around.inside(x + 1, y + 1);
        const unsigned any = a | b | c | d, all = a & b & c & d;
        const unsigned crossed = (any | any >> 1) & ~(all & all >> 1) & some;
        rows_[static_cast<size_t>(x * kCells + y)].cells = static_cast<uint16_t>(crossed);
        for (unsigned left = crossed; left != 0; left &= left - 1)
          cells[count++] = static_cast<BlockCell>(x << 8 | y << 4 | std::countr_zero(left));
      }
    std::fill_n(cells.data() + count, BlockPlanes::kPadding, cells[0]);
    cellPlanes(around.at(0, 0, 0), BrickSurroundings::kStepX, BrickSurroundings::kStepY, kAround, cells.data(),
               static_cast<int>(count), planes_);
    size_t plane = 0, kept = 0;
    for (int x = low[0]; x < high[0]; ++x)
      for (int y = low[1]; y < high[1]; ++y) {
        Row& row = rows_[static_cast<size_t>(x * kCells + y)];
        row.first = static_cast<uint16_t>(kept);
        unsigned counts = 0;
        for (unsigned left = row.cells; left != 0; left &= left - 1, ++plane) {
          const bool keep = planes_.foot[plane][BlockPlanes::bend] < kCurvedPlane * kCurvedPlane;
          numbers_[kept] = static_cast<uint16_t>(plane);
          kept += keep;
          counts |= keep ? left & (0 - left) : 0;
        }
        row.cells = static_cast<uint16_t>(counts);
      }
  }

  [[nodiscard]] const BlockPlanes& planes() const { return planes_; }

  // The planes up to three steps away from a cell of the brick; how many.
  int near(int x, int y, int z, uint16_t (&out)[kMostNearPlanes]) const {
    size_t count = 0;
    const Row* rows = &rows_[static_cast<size_t>(x * kCells + y)];
    for (const RowReach& reach : kReach) {
      const Row& row = rows[reach.offset];
      // Those of a row follow each other. Five are written, needed or not: how many there are is hard to foresee.
      const unsigned reached = row.cells & reach.cells << z;
      const auto at = static_cast<size_t>(row.first + std::popcount(row.cells & ((reached & (0 - reached)) - 1)));
      std::copy_n(&numbers_[at], kMostInRow, out + count);
      count += static_cast<size_t>(std::popcount(reached));
    }
    return static_cast<int>(count);
  }

 private:
  static constexpr size_t kMostInRow = 5;
  struct Row {
    uint16_t cells;  // Bit z: there is a plane.
    uint16_t first;  // Index of its first one in numbers_.
  };
  std::array<Row, kCells * kCells> rows_;
  std::array<uint16_t, BlockPlanes::kMost + kMostInRow> numbers_;
  BlockPlanes planes_;
};

// The vertices of a brick that may be moved, some at a time.
class Placement {
 public:
  Placement(const BrickSurroundings& around, const CrossedCells& crossed, bool wantNormals, Grade grade,
            ExtractionBuffer& brick)
      : around_(around),
        crossed_(crossed),
        wantNormals_(wantNormals),
        curvedAlone_(grade == Grade::fine),
        brick_(brick) {
    cells_.stepX = BrickSurroundings::kStepX, cells_.stepY = BrickSurroundings::kStepY;
  }

  void add(uint16_t vertex, uint16_t cell, uint16_t edges) {
    Suspect& s = suspects_[count_++];
    s.vertex = vertex, s.cell = cell, s.edges = edges;
    s.kinked = s.curved = false, s.explained = true;
    s.share = 1;
    s.told = false;
    s.found.kind = CreaseVertex::Kind::none;
    if (count_ == suspects_.size()) place();
  }

  // After the last.
  void finish() { place(); }

  // Cells that creases of others go through: eight values across a crease may lie in a plane, and then it is not known
  // for one.
  [[nodiscard]] const RimCells& passed() const { return passed_; }
  // Vertices on creases; cells whose crease is too sharp or too tangled for planes.
  [[nodiscard]] const PlacedVertices& sharp() const { return onCrease_; }
  [[nodiscard]] const RimCells& hard() const { return hard_; }

 private:
  static constexpr size_t kAtOnce = 256;
  // A vertex, and what became of it.
  struct Suspect {
    uint16_t vertex;
    uint16_t cell;  // x·64 + y·8 + z
    uint16_t edges;
    bool kinked, curved, explained;
    bool told;              // the rounding is known
    float rounding, share;  // CrispVertices::rounding; of the crease
    Vec3f crease, along;    // a point and the direction of it
    CreaseVertex found;
  };

  std::span<Suspect> suspects() { return {suspects_.data(), count_}; }

  void place() {
    byTwoFaces();
    if (!curvedAlone_) {
      findShares();
      atCorners();
    }
    for (const Suspect& s : suspects()) {
      const CreaseVertex& found = s.found;
      if (isHard(s)) hard_.set(s.cell);
      if (found.kind == CreaseVertex::Kind::none) continue;
      if (curvedAlone_ && (!s.curved || found.kind != CreaseVertex::Kind::edge)) continue;
      if (s.share <= 0) continue;
      brick_.positions[s.vertex] += s.share * (found.position - brick_.positions[s.vertex]);
      // A vertex that goes part of the way stands on no crease: it keeps the field's normal.
      if (s.share < 1) continue;
      if (found.kind != CreaseVertex::Kind::face) onCrease_.set(s.vertex);
      if (wantNormals_) brick_.normals[s.vertex] = found.packedNormal();
    }
    count_ = 0;
  }

  // In an acute wedge, at a corner, or where two faces are there and do not explain the cell.
  [[nodiscard]] bool isHard(const Suspect& s) const {
    switch (s.found.kind) {
      case CreaseVertex::Kind::none:
        return s.kinked;
      case CreaseVertex::Kind::corner:
        return true;
      case CreaseVertex::Kind::edge:
        if (s.found.normal.squaredNorm() < kAcute) return true;
        [[fallthrough]];
      case CreaseVertex::Kind::face:
        return s.kinked && !s.explained;
    }
    return false;
  }

  void byTwoFaces() {
    for (Suspect& s : suspects()) seek(s, kByFlat);
    flush();
    for (Suspect& s : suspects())
      if (s.found.kind == CreaseVertex::Kind::none && (s.kinked || creasedAround(viewOf(s)))) {
        // Where both find something, the first counts.
        seek(s, kByCurved);
        seek(s, kByAll);
      }
    flush();
  }

  // Finds shares by the median of the roundings along a crease: one that a cell takes for rounded, and the next one
  // does not, would be a row of teeth.
  void findShares() {
    std::array<float, kAtOnce> roundings;
    for (Suspect& s : suspects()) {
      if (!s.told) continue;
      size_t count = 0;
      for (const Suspect& other : suspects())
        if (other.told && (&other == &s || other.found.kind == CreaseVertex::Kind::edge) &&
            (other.crease - s.crease).squaredNorm() < kAlong * kAlong && std::abs(other.along.dot(s.along)) > kSameWay)
          roundings[count++] = other.rounding;
      std::sort(roundings.begin(), roundings.begin() + static_cast<std::ptrdiff_t>(count));
      const float median = 0.5f * (roundings[(count - 1) / 2] + roundings[count / 2]);
      s.share = std::clamp((kRounded - median) / (kRounded - kSharp), 0.0f, 1.0f);
    }
  }

  // Around a corner of three faces every crossed cell bends, and of a face there may be no plane that counts: there the
  // fine grade's step looks at all cells two steps away. That costs many times what a cell does, so only flat faces get
  // it.
  void atCorners() {
    std::array<Suspect*, kAtOnce> open;
    size_t count = 0;
    for (Suspect& s : suspects())
      if ((s.found.kind == CreaseVertex::Kind::none ? s.kinked : !s.explained || s.share < 1) && isBetweenFlatFaces(s))
        open[count++] = &s;
    if (count > 0) placeAtCorners({open.data(), count});
  }

  void placeAtCorners(std::span<Suspect* const> open) {
    TangentPlanes fits(around_, kFlat);
    std::array<TangentPlane, 125> planes;
    for (Suspect* s : open) {
      const auto [x, y, z] = placeOf(*s);
      const CreaseVertex corner =
          placeAtCrease(cellOf(*s, {planes.data(), fits.around(x + kAround, y + kAround, z + kAround, planes.data())}));
      // Takes it for a rounding as well: it finds where the vertex should stand.
      const bool counts = corner.kind == CreaseVertex::Kind::corner || s->found.kind == CreaseVertex::Kind::none ||
                          (corner.kind == CreaseVertex::Kind::edge && s->share < 1);
      if (!counts) continue;
      s->found = corner;
      s->share = 1;
    }
  }

  static std::array<int, 3> placeOf(const Suspect& s) { return {s.cell >> 6, s.cell >> 3 & 7, s.cell & 7}; }
  static Vec3f lowOf(const Suspect& s) {
    const auto [x, y, z] = placeOf(s);
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  }
  CellView viewOf(const Suspect& s) const {
    const auto [x, y, z] = placeOf(s);
    return {around_.at(x + kAround, y + kAround, z + kAround), BrickSurroundings::kStepX, BrickSurroundings::kStepY};
  }
  CreaseCell cellOf(const Suspect& s, std::span<const TangentPlane> planes) const {
    return {lowOf(s), brick_.positions[s.vertex], viewOf(s), s.edges, planes};
  }

  void seek(Suspect& s, const CrispRule& rule) {
    const auto k = static_cast<size_t>(cells_.count++);
    const auto [x, y, z] = placeOf(s);
    const Vec3f low = lowOf(s), draft = brick_.positions[s.vertex] - low;
    asked_[k] = &s;
    cells_.phi[k] = viewOf(s).phi;
    for (int axis = 0; axis < 3; ++axis) cells_.low[axis][k] = low[axis], cells_.draft[axis][k] = draft[axis];
    cells_.edges[k] = s.edges;
    cells_.rule[k] = &rule;
    cells_.planes[k] = crossed_.near(x, y, z, cells_.plane[k]);
    if (cells_.count == kCrispCells) flush();
  }

  void flush() {
    if (cells_.count == 0) return;
    CrispVertices found;
    placeCrisply(cells_, crossed_.planes(), found);
    for (size_t k = 0; k < static_cast<size_t>(cells_.count); ++k) {
      Suspect& s = *asked_[k];
      const auto has = [k](unsigned bits) { return (bits >> k & 1) != 0; };
      s.kinked = has(found.kinked);
      if (s.found.kind != CreaseVertex::Kind::none) continue;
      if (has(found.edge | found.face)) {
        const auto at = [k](const float(&rows)[3][kCrispCells]) { return Vec3f(rows[0][k], rows[1][k], rows[2][k]); };
        s.found.kind = has(found.edge) ? CreaseVertex::Kind::edge : CreaseVertex::Kind::face;
        s.found.position = at(found.position) + lowOf(s);
        s.found.normal = at(found.normal);
        s.curved = has(found.curved);
        s.explained = has(found.explained);
        s.told = !(isHard(s) && has(found.third));
        s.rounding = found.rounding[k];
        s.along = at(found.along);
        s.crease = at(found.crease) + lowOf(s);
        if (s.kinked && s.found.kind == CreaseVertex::Kind::face) markPassed(s, at(found.crease));
      } else if (has(found.third)) {
        s.found = byThreeFaces(s, *cells_.rule[k], {cells_.plane[k], static_cast<size_t>(cells_.planes[k])});
      }
    }
    cells_.count = 0;
  }

  // The cell beside s that the point, from its lowest corner, lies in, if it is one of the brick's.
  void markPassed(const Suspect& s, const Vec3f& crease) {
    std::array<int, 3> cell = placeOf(s);
    for (size_t axis = 0; axis < 3; ++axis) {
      const float along = crease[static_cast<Eigen::Index>(axis)];
      cell[axis] += (along > 1 + kBeside) - (along < -kBeside);
      if (cell[axis] < 0 || cell[axis] >= kBrickEdge) return;
    }
    passed_.set(static_cast<size_t>(Brick::offset(cell[0], cell[1], cell[2])));
  }

  CreaseVertex byThreeFaces(const Suspect& s, const CrispRule& rule, std::span<const uint16_t> near) const {
    std::array<TangentPlane, kMostNearPlanes> planes;
    size_t count = 0;
    for (const uint16_t i : near) {
      const float(&foot)[4] = crossed_.planes().foot[i], (&normal)[4] = crossed_.planes().normal[i];
      const float quality = planeQuality(foot[BlockPlanes::bend], normal[BlockPlanes::blur], rule);
      if (quality > 0) planes[count++] = {{foot[0], foot[1], foot[2]}, {normal[0], normal[1], normal[2]}, 0, quality};
    }
    return placeAtCrease(cellOf(s, {planes.data(), count}));
  }

  // Whether some of the planes are of flat faces, two of them turned from each other.
  bool isBetweenFlatFaces(const Suspect& s) const {
    uint16_t near[kMostNearPlanes];
    const auto [x, y, z] = placeOf(s);
    const int count = crossed_.near(x, y, z, near);
    const float* first = nullptr;
    int flat = 0;
    bool turned = false;
    for (int i = 0; i < count; ++i) {
      const float* normal = crossed_.planes().normal[near[i]];
      if (crossed_.planes().foot[near[i]][BlockPlanes::bend] >= kFlatFaces * kFlatFaces) continue;
      if (!first) first = normal;
      ++flat;
      turned |= 1 - (normal[0] * first[0] + normal[1] * first[1] + normal[2] * first[2]) > kLeastTurn;
    }
    return turned && flat >= kLeastFlat;
  }

  const BrickSurroundings& around_;
  const CrossedCells& crossed_;
  const bool wantNormals_, curvedAlone_;
  ExtractionBuffer& brick_;
  size_t count_ = 0;
  PlacedVertices onCrease_;
  RimCells hard_, passed_;
  std::array<Suspect, kAtOnce> suspects_;
  CrispCells cells_;
  std::array<Suspect*, kCrispCells> asked_;
};

}  // namespace

void crispVertices(Sampler& field, Coord brick, const CreaseCells& cells, bool wantNormals, Grade grade,
                   ExtractionBuffer& out, PlacedVertices& placed) {
  const Suspects suspects(field, brick, cells, out.table.readsBeyond);
  if (!suspects.any()) return;
  std::array<RimSuspect, ExtractionBuffer::kMostVertices> list;
  size_t count = 0;
  auto special = out.table.specials.begin();
  for (int k = 0; k < cells.count; ++k) {
    const uint16_t cell = cells.cells[k];
    while (special != out.table.specials.end() && special->cell < cell) ++special;
    const bool several = special != out.table.specials.end() && special->cell == cell;
    const CellCases& cases = cellCases();
    const CellCase& c = (several && special->joined ? cases.joined : cases.separated)[cells.patterns[k]];
    for (int loop = 0; loop < (several ? c.loops : 1); ++loop) {
      const int vertex = loop == 0 ? k : special->extraFirst + loop - 1;
      list[count++] = {static_cast<uint16_t>(vertex), cell, several ? c.edgesOf(loop) : c.edges, suspects.has(cell)};
    }
  }
  const BrickSurroundings::Range range = suspects.range();
  BrickSurroundings around;
  around.read(field, brick, range);
  const CrossedCells crossed(around, range);
  Placement placement(around, crossed, wantNormals, grade, out);
  for (size_t i = 0; i < count; ++i)
    if (list[i].kinked) placement.add(list[i].vertex, list[i].cell, list[i].edges);
  placement.finish();
  if (const RimCells passed = placement.passed(); passed.any()) {
    for (size_t i = 0; i < count; ++i)
      if (!list[i].kinked && passed[list[i].cell]) {
        list[i].kinked = true;
        placement.add(list[i].vertex, list[i].cell, list[i].edges);
      }
    placement.finish();
  }
  PlacedVertices sharp = placement.sharp();
  const bool all = grade == Grade::fine;
  if (all || placement.hard().any())
    placeOnRims(field, brick, {list.data(), count}, placement.hard(), all, wantNormals, out, placed, sharp);
  size_t onCrease = 0;
  for (size_t i = 0; i < out.table.vertices; ++i)
    if (sharp[i]) out.sharp[onCrease++] = static_cast<uint16_t>(i);
  out.table.sharp = {out.sharp.data(), onCrease};
}

}  // namespace argil::clay
