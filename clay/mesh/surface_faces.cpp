#include "clay/mesh/surface_faces.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"

namespace argil::clay {

namespace {

constexpr uint32_t kNone = UINT32_MAX;
constexpr int kAwayRings = 2;                       // edges from a crease: faces begin beyond them
constexpr int kTeeth = 3;                           // rounds that take teeth from borders
constexpr float kSliver = 0.02f, kLongSide = 0.5f;  // area by the longest side squared; sides by the longest

// All of `front` outwards by one cell at a time, over sides that `may` be crossed.
template <class May>
void grow(const SurfaceCells& cells, std::vector<uint32_t> front, const May& may, std::vector<uint32_t>& face) {
  std::vector<uint32_t> next;
  for (; !front.empty(); front.swap(next), next.clear())
    for (const uint32_t cell : front)
      for (size_t side = cell * cells.sides; side < (cell + 1) * cells.sides; ++side) {
        const uint32_t other = cells.across[side];
        if (!may(side) || face[other] != kNone) continue;
        face[other] = face[cell];
        next.push_back(other);
      }
}

// Where a face lies exactly on a plane of the grid two rows of vertices may stand on one crease, slivers between them:
// these go on as the cell beyond one of their long sides does.
void straightenSlivers(SurfaceCells& cells) {
  std::vector<float> longest(cells.count(), 0);
  std::vector<uint32_t> slivers, left;
  std::vector<bool> unknown(cells.count());
  for (uint32_t cell = 0; cell < cells.count(); ++cell) {
    const auto first = cells.lengths.begin() + ptrdiff_t(cell * cells.sides);
    longest[cell] = *std::max_element(first, first + ptrdiff_t(cells.sides));
    if (cells.areas[cell] > kSliver * longest[cell] * longest[cell]) continue;
    slivers.push_back(cell);
    unknown[cell] = true;
  }
  for (size_t before = SIZE_MAX; slivers.size() < before; slivers.swap(left)) {
    before = slivers.size();
    left.clear();
    for (const uint32_t cell : slivers) {
      for (size_t s = 0; s < cells.sides && unknown[cell]; ++s) {
        const size_t side = cell * cells.sides + s;
        if (cells.lengths[side] < kLongSide * longest[cell] || unknown[cells.across[side]]) continue;
        cells.normals[cell] = cells.normals[cells.across[side]];
        unknown[cell] = false;
      }
      if (unknown[cell]) left.push_back(cell);
    }
  }
}

// What two faces share, and a face by itself.
struct Border {
  double length = 0, bent = 0;
};
struct Extent {
  double area = 0, border = 0;
  uint32_t cells = 0;
  std::pair<double, uint32_t> most{};  // the longest border, and with which face
};

// Joins whatever `one` says of a border of two faces and, of the others, each that is `small` with what it shares the
// longest border with; again until nothing is left to join.
template <class One, class Small>
void joinFaces(const SurfaceCells& cells, const std::vector<bool>& bent, const One& one, const Small& small,
               std::vector<uint32_t>& face) {
  for (bool again = true; again;) {
    again = false;
    std::map<std::pair<uint32_t, uint32_t>, Border> borders;
    std::map<uint32_t, Extent> extents;
    for (uint32_t cell = 0; cell < cells.count(); ++cell) {
      Extent& own = extents[face[cell]];
      own.area += double(cells.areas[cell]);
      ++own.cells;
      for (size_t side = cell * cells.sides; side < (cell + 1) * cells.sides; ++side) {
        const uint32_t a = face[cell], b = face[cells.across[side]];
        if (a == b) continue;
        own.border += double(cells.lengths[side]);
        if (a > b) continue;
        Border& border = borders[{a, b}];
        border.length += double(cells.lengths[side]);
        border.bent += !bent.empty() && bent[side] ? double(cells.lengths[side]) : 0;
      }
    }
    JoinedSets joined(cells.count());
    for (const auto& [faces, border] : borders) {
      if (one(border)) again = joined.join(faces.first, faces.second) || again;
      for (const auto& [own, other] : {faces, std::pair{faces.second, faces.first}})
        if (Extent& extent = extents[own]; border.length > extent.most.first) extent.most = {border.length, other};
    }
    // The others first: what was joined above may not be small any more.
    if (!again)
      for (const auto& [own, extent] : extents)
        if (extent.most.first > 0 && small(extent)) again = joined.join(own, extent.most.second) || again;
    for (uint32_t& each : face) each = joined.find(each);
  }
}

}  // namespace

template <size_t Sides>
SurfaceCells::SurfaceCells(const std::vector<Vec3d>& positions, const std::vector<std::array<uint32_t, Sides>>& cells)
    : sides(Sides) {
  corners.reserve(Sides * cells.size());
  for (const auto& cell : cells) corners.insert(corners.end(), cell.begin(), cell.end());
  struct Side {
    uint64_t ends;
    uint32_t index;
  };
  std::vector<Side> all(corners.size());
  lengths.resize(corners.size());
  across.resize(corners.size());
  const auto to = [&](size_t side) { return corners[side - side % Sides + (side + 1) % Sides]; };
  for (uint32_t side = 0; side < all.size(); ++side) {
    const uint32_t a = corners[side], b = to(side);
    all[side] = {uint64_t{std::min(a, b)} << 32 | std::max(a, b), side};
    lengths[side] = static_cast<float>((positions[b] - positions[a]).norm());
  }
  std::sort(all.begin(), all.end(),
            [](const Side& a, const Side& b) { return a.ends != b.ends ? a.ends < b.ends : a.index < b.index; });
  for (size_t i = 0; i < all.size(); i += 2) {
    const bool pair = i + 1 < all.size() && all[i].ends == all[i + 1].ends &&
                      (i + 2 == all.size() || all[i + 2].ends != all[i].ends) &&
                      corners[all[i].index] == to(all[i + 1].index);
    if (!pair) throw Error("a surface that is not closed", Error::Kind::work);
    across[all[i].index] = all[i + 1].index / Sides;
    across[all[i + 1].index] = all[i].index / Sides;
  }
  areas.reserve(cells.size());
  normals.reserve(cells.size());
  for (const auto& cell : cells) {
    // Half the cross product of the diagonals; a triangle's second one is its side.
    const Vec3d &a = positions[cell[0]], &b = positions[cell[1]], &c = positions[cell[2]],
                &d = positions[cell[Sides - 1]];
    const Vec3d area = 0.5 * (Sides == 3 ? (b - a).cross(c - a) : (c - a).cross(d - b));
    areas.push_back(static_cast<float>(area.norm()));
    normals.push_back(area.squaredNorm() > 0 ? Eigen::Vector3f(area.normalized().cast<float>())
                                             : Eigen::Vector3f::Zero());
  }
  straightenSlivers(*this);
}
template SurfaceCells::SurfaceCells(const std::vector<Vec3d>&, const std::vector<std::array<uint32_t, 3>>&);
template SurfaceCells::SurfaceCells(const std::vector<Vec3d>&, const std::vector<std::array<uint32_t, 4>>&);

std::vector<uint32_t> facesOf(const SurfaceCells& cells, const std::vector<bool>& bent, double leastWidth) {
  const size_t vertices = cells.corners.empty() ? 0 : *std::max_element(cells.corners.begin(), cells.corners.end()) + 1;
  std::vector<bool> near(vertices), nearer;
  const auto to = [&](size_t side) { return cells.corners[side - side % cells.sides + (side + 1) % cells.sides]; };
  for (size_t side = 0; side < bent.size(); ++side)
    if (bent[side]) near[cells.corners[side]] = near[to(side)] = true;
  for (int ring = 1; ring < kAwayRings; ++ring) {
    nearer = near;
    for (size_t side = 0; side < bent.size(); ++side)
      if (nearer[cells.corners[side]]) near[to(side)] = true;
  }
  const auto isAway = [&](uint32_t cell) {
    const auto* first = &cells.corners[cell * cells.sides];
    return std::none_of(first, first + cells.sides, [&](uint32_t v) { return near[v]; });
  };
  std::vector<uint32_t> face(cells.count(), kNone), begun, todo;
  const auto flood = [&](uint32_t first, const auto& may) {
    face[first] = first;
    for (todo = {first}; !todo.empty();) {
      const uint32_t cell = todo.back();
      todo.pop_back();
      begun.push_back(cell);
      for (size_t side = cell * cells.sides; side < (cell + 1) * cells.sides; ++side) {
        const uint32_t next = cells.across[side];
        if (bent[side] || face[next] != kNone || !may(next)) continue;
        face[next] = first;
        todo.push_back(next);
      }
    }
  };
  for (uint32_t cell = 0; cell < cells.count(); ++cell)
    if (face[cell] == kNone && isAway(cell)) flood(cell, isAway);
  grow(
      cells, std::move(begun), [&](size_t side) { return !bent[side]; }, face);
  for (uint32_t cell = 0; cell < cells.count(); ++cell)
    if (face[cell] == kNone) flood(cell, [](uint32_t) { return true; });
  // Borders that are mostly no creases part nothing. The width of a long strip is its area by half its border.
  joinFaces(
      cells, bent, [](const Border& border) { return border.bent < kMostlyBent * border.length; },
      [&](const Extent& extent) { return extent.area < leastWidth * extent.border / 2; }, face);
  return face;
}

void tidyFaces(const SurfaceCells& cells, std::vector<uint32_t>& face) {
  const auto any = [](size_t) { return true; };
  std::vector<uint32_t> known;
  for (uint32_t cell = 0; cell < cells.count(); ++cell)
    if (face[cell] != kNone) known.push_back(cell);
  grow(cells, std::move(known), any, face);
  std::replace(face.begin(), face.end(), kNone, 0u);  // a body of which nothing is known
  const auto connect = [&] {
    JoinedSets joined(cells.count());
    for (size_t side = 0; side < cells.across.size(); ++side)
      if (const auto cell = uint32_t(side / cells.sides); face[cell] == face[cells.across[side]])
        joined.join(cell, cells.across[side]);
    for (uint32_t cell = 0; cell < cells.count(); ++cell) face[cell] = joined.find(cell);
  };
  for (int round = 0; round < kTeeth; ++round) {
    connect();
    joinFaces(
        cells, {}, [](const Border&) { return false; }, [](const Extent& extent) { return extent.cells < kFewCells; },
        face);
    // A cell with all sides but one in another face.
    for (uint32_t cell = 0; cell < cells.count(); ++cell)
      for (size_t s = 0; s < cells.sides; ++s) {
        const uint32_t other = face[cells.across[cell * cells.sides + s]];
        size_t shared = 0;
        for (size_t k = 0; k < cells.sides; ++k) shared += face[cells.across[cell * cells.sides + k]] == other;
        if (other == face[cell] || shared + 1 < cells.sides) continue;
        face[cell] = other;
        break;
      }
  }
  connect();
}

}  // namespace argil::clay
