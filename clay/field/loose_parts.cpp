// Connected components by union-find over the voxels of each brick that hang together and the tiles of the tree.

#include "clay/field/loose_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "clay/field/brick_parts.h"
#include "clay/field/settle.h"
#include "clay/kernels/cell_cases.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"
#include "clay/store/tree_view.h"

namespace argil::clay {

namespace {

constexpr size_t kStepEvery = 2048;  // bricks between two looks at the job
constexpr Coord kUnit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// What stands one step higher in z (in y) at each voxel of a plane, which ends in `next`.
uint64_t higherZ(uint64_t plane, uint64_t next) {
  return ((plane >> 1) & ~(kLowestZ << 7)) | ((next & kLowestZ) << 7);
}
uint64_t higherY(uint64_t plane, uint64_t next) {
  return (plane >> 8) | (next << 56);
}

class Components {
 public:
  struct Piece {  // what hangs together in one brick, or a tile
    Coord first;  // brick coordinate
    int level;    // of a tile; 0 for one brick
    bool isTile;
    BrickMask mask;
  };

  /// Of the voxels inside (or outside) of a version.
  Components(const Version& version, Tile side, const WorkPart& part) : version_(version), side_(side) {
    collect(TreePlace::root(version));
    parent_.resize(pieces_.size());
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (size_t i = 0; i < pieces_.size(); ++i) {
      if (i % kStepEvery == 0) part.step(double(i) / double(pieces_.size()));
      join(static_cast<uint32_t>(i));
    }
    for (const Coord brick : brickCoords_) joinAcrossFaces(brick);
    for (uint32_t i = 0; i < pieces_.size(); ++i) {
      const uint32_t root = find(i);
      const auto [at, added] = bodyOf_.try_emplace(root, static_cast<uint32_t>(voxels_.size()));
      if (added) voxels_.push_back(0);
      voxels_[at->second] += count(pieces_[i]);
    }
  }

  /// One of its voxels.
  [[nodiscard]] static Coord voxelOf(const Piece& piece) {
    const Coord first = piece.first * kBrickEdge;
    if (piece.isTile) return first;
    for (int x = 0; x < 8; ++x) {
      const uint64_t plane = piece.mask[static_cast<size_t>(x)];
      if (plane != 0) return first + Coord{x, std::countr_zero(plane) >> 3, std::countr_zero(plane) & 7};
    }
    return first;
  }

  [[nodiscard]] size_t bodies() const { return voxels_.size(); }
  [[nodiscard]] double voxels(size_t body) const { return voxels_[body]; }
  [[nodiscard]] size_t body(size_t piece) { return bodyOf_.at(find(static_cast<uint32_t>(piece))); }
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  /// Bodies by volume, the largest first; equal ones in the order of the tree.
  [[nodiscard]] std::vector<size_t> largestFirst() const {
    std::vector<size_t> order(bodies());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return voxels_[a] > voxels_[b]; });
    return order;
  }
  /// Makes the chosen bodies part of the other side.
  Version without(const std::vector<bool>& goes, const WorkPart& part) {
    Editor editor(version_);
    const Tile other = side_ == Tile::inside ? Tile::outside : Tile::inside;
    const float far = other == Tile::inside ? -editor.grid().band : editor.grid().band;
    std::vector<Coord> changed;
    for (size_t i = 0; i < pieces_.size(); ++i) {
      if (i % kStepEvery == 0) part.step(0.5 * double(i) / double(pieces_.size()));
      if (!goes[body(i)]) continue;
      const Piece& piece = pieces_[i];
      if (piece.isTile) {
        editor.setBlock(piece.first, piece.level, other);
        continue;
      }
      float phi[kBrickVoxels];
      const Slot slot = editor.find(piece.first);
      for (int v = 0; v < kBrickVoxels; ++v)
        phi[v] = (piece.mask[static_cast<size_t>(v >> 6)] >> (v & 63)) & 1 ? far : slot.phi(v, editor.grid().band);
      editor.setVoxels(piece.first, phi);
      changed.push_back(piece.first);
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    redistanceAll(editor, bricksAround(editor, changed), part.part(0.5, 1));
    keepChannels(editor, version_);
    return editor.commit();
  }

 private:
  static uint64_t key(Coord c, int level) {
    return ((static_cast<uint64_t>(static_cast<uint32_t>(c.x + 32768)) & 0xffff) << 40) |
           ((static_cast<uint64_t>(static_cast<uint32_t>(c.y + 32768)) & 0xffff) << 24) |
           ((static_cast<uint64_t>(static_cast<uint32_t>(c.z + 32768)) & 0xffff) << 8) | static_cast<uint64_t>(level);
  }

  void collect(const TreePlace& place) {
    if (place.isTile()) {
      if (place.tile() != side_ && place.level() < kTreeLevels) return;
      if (place.tile() != side_) return;
      tiles_.emplace(key(place.first(), place.level()), static_cast<uint32_t>(pieces_.size()));
      pieces_.push_back({place.first(), place.level(), true, kFullMask});
      return;
    }
    if (place.isNode()) {
      for (int i = 0; i < 512; ++i) collect(place.child(i));
      return;
    }
    const Brick& brick = *place.brick();
    BrickMask left;
    for (size_t x = 0; x < 8; ++x) left[x] = side_ == Tile::inside ? brick.inside[x] : ~brick.inside[x];
    bricks_.emplace(key(brick.coord, 0), static_cast<uint32_t>(pieces_.size()));
    brickCoords_.push_back(brick.coord);
    while (std::any_of(left.begin(), left.end(), [](uint64_t w) { return w != 0; }))
      pieces_.push_back({brick.coord, 0, false, takeComponent(left)});
  }

  [[nodiscard]] double count(const Piece& piece) const {
    if (piece.isTile) return double(kBrickVoxels) * std::pow(512.0, piece.level);
    double n = 0;
    for (const uint64_t w : piece.mask) n += std::popcount(w);
    return n;
  }

  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(uint32_t a, uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // The tile that holds a brick coordinate, of `level` or above; UINT32_MAX when something else stands there.
  [[nodiscard]] uint32_t tileAt(Coord brick, int level) const {
    for (int l = level; l <= kTreeLevels; ++l) {
      const auto at = tiles_.find(key(Editor::blockFirst(brick, l), l));
      if (at != tiles_.end()) return at->second;
    }
    return UINT32_MAX;
  }

  // With what lies next to it: larger or equal tiles on every side, bricks on the upper ones.
  void join(uint32_t i) {
    const Piece& piece = pieces_[i];
    const int edge = 1 << (3 * piece.level);
    for (int axis = 0; axis < 3; ++axis) {
      const Coord up = piece.first + kUnit[axis] * edge, down = piece.first - kUnit[axis];
      for (const Coord next : {up, down}) {
        const uint32_t tile = tileAt(next, piece.level);
        if (tile == UINT32_MAX) continue;
        if (piece.isTile || (next == up ? touch(piece.mask, kFullMask, axis) : touch(kFullMask, piece.mask, axis)))
          unite(i, tile);
      }
      if (piece.isTile) continue;
      const auto at = bricks_.find(key(up, 0));
      if (at == bricks_.end()) continue;
      for (uint32_t k = at->second; k < pieces_.size() && !pieces_[k].isTile && pieces_[k].first == up; ++k)
        if (touch(piece.mask, pieces_[k].mask, axis)) unite(i, k);
    }
  }

  // Where the signs alternate around a face of four voxels the surface goes between those inside, and those outside are
  // one, except for a folded face (cell_cases.h): there it is the other way.
  void joinAcrossFaces(Coord brick) {
    std::array<BrickMask, 8> at;  // of the brick and those one step higher: x·4 + y·2 + z
    for (int i = 0; i < 8; ++i) at[static_cast<size_t>(i)] = maskAt(brick + Coord{i >> 2, (i >> 1) & 1, i & 1});
    std::array<uint64_t, 9> plane, z, y, yz;
    for (size_t x = 0; x <= 8; ++x) {
      const size_t k = x < 8 ? 0 : 4, row = x & 7;
      plane[x] = at[k][row];
      z[x] = higherZ(at[k][row], at[k + 1][row]);
      y[x] = higherY(at[k][row], at[k + 2][row]);
      yz[x] = higherY(z[x], higherZ(at[k + 2][row], at[k + 3][row]));
    }
    const auto alternates = [](uint64_t a, uint64_t b, uint64_t c, uint64_t opposite) {
      return (a ^ b) & (a ^ c) & ~(a ^ opposite);
    };
    for (size_t x = 0; x < 8; ++x) {
      const uint64_t faces[3] = {alternates(plane[x], y[x], z[x], yz[x]),
                                 alternates(plane[x], z[x], plane[x + 1], z[x + 1]),
                                 alternates(plane[x], plane[x + 1], y[x], y[x + 1])};
      for (int axis = 0; axis < 3; ++axis)
        for (uint64_t left = faces[axis]; left != 0; left &= left - 1) {
          const int v = std::countr_zero(left);
          joinAcross(brick * kBrickEdge + Coord{static_cast<int>(x), v >> 3, v & 7}, axis);
        }
    }
  }

  // `low`: the lowest voxel of an alternating face across `axis`.
  void joinAcross(Coord low, int axis) {
    const Coord u = kUnit[(axis + 1) % 3], v = kUnit[(axis + 2) % 3];
    const CellCases& cases = cellCases();
    const bool folded = cases.separated[patternOf(low)].foldedFace == 2 * axis &&
                        cases.separated[patternOf(low - kUnit[axis])].foldedFace == 2 * axis + 1;
    if (folded != (side_ == Tile::inside)) return;
    if (holds(low))
      unite(pieceAt(low), pieceAt(low + u + v));
    else
      unite(pieceAt(low + u), pieceAt(low + v));
  }

  // Corners inside, as kCellEdges counts them.
  [[nodiscard]] size_t patternOf(Coord cell) const {
    size_t pattern = 0;
    for (int c = 0; c < 8; ++c)
      pattern |= size_t(holds(cell + Coord{c >> 2, (c >> 1) & 1, c & 1}) == (side_ == Tile::inside)) << c;
    return pattern;
  }

  static Coord brickOf(Coord voxel) { return {voxel.x >> 3, voxel.y >> 3, voxel.z >> 3}; }
  [[nodiscard]] bool holds(Coord voxel) const {
    return (maskAt(brickOf(voxel))[size_t(voxel.x & 7)] >> (((voxel.y & 7) << 3) | (voxel.z & 7))) & 1;
  }
  // Of this side's voxels.
  [[nodiscard]] BrickMask maskAt(Coord brick) const {
    BrickMask all{};
    const auto at = bricks_.find(key(brick, 0));
    if (at == bricks_.end()) return tileAt(brick, 0) == UINT32_MAX ? all : kFullMask;
    for (uint32_t k = at->second; k < pieces_.size() && !pieces_[k].isTile && pieces_[k].first == brick; ++k)
      for (size_t x = 0; x < 8; ++x) all[x] |= pieces_[k].mask[x];
    return all;
  }
  // Of a voxel of this side.
  [[nodiscard]] uint32_t pieceAt(Coord voxel) const {
    const auto at = bricks_.find(key(brickOf(voxel), 0));
    if (at == bricks_.end()) return tileAt(brickOf(voxel), 0);
    uint32_t k = at->second;
    while (!((pieces_[k].mask[size_t(voxel.x & 7)] >> (((voxel.y & 7) << 3) | (voxel.z & 7))) & 1)) ++k;
    return k;
  }

  Version version_;
  Tile side_;
  std::vector<Piece> pieces_;
  std::vector<Coord> brickCoords_;
  std::unordered_map<uint64_t, uint32_t> tiles_, bricks_;
  std::vector<uint32_t> parent_;
  std::unordered_map<uint32_t, uint32_t> bodyOf_;
  std::vector<double> voxels_;
};

double voxelVolume(const Version& version) {
  return std::pow(version.grid().voxelMm, 3);
}

}  // namespace

std::vector<double> bodyVolumes(const Version& version, Job* job) {
  const Components bodies(version, Tile::inside, WorkPart(job));
  std::vector<double> volumes;
  for (const size_t b : bodies.largestFirst()) volumes.push_back(bodies.voxels(b) * voxelVolume(version));
  return volumes;
}

namespace {

struct SplitPart {
  double voxels;
  Version version;
};

// Bodies that are taken out of one version: more are halved first, as each takes a look at all of them.
constexpr size_t kTakenAtOnce = 64;

// Adds a version for each body to `parts`, in the order of the tree.
void splitInto(std::vector<SplitPart>& parts, const Version& version, const WorkPart& part) {
  std::array<Version, 2> halves;
  {
    Components bodies(version, Tile::inside, part.part(0, 0.1));
    const size_t count = bodies.bodies();
    if (count > kMostParts)
      throw Error(
          fmt::format("the piece consists of {} parts, and {} is the most that are split: remove the crumbs first",
                      count, kMostParts),
          Error::Kind::work);
    if (count <= 1) {
      parts.push_back({count == 1 ? bodies.voxels(0) : 0, version});
      return;
    }
    if (count <= kTakenAtOnce) {
      for (size_t body = 0; body < count; ++body) {
        std::vector<bool> goes(count, true);
        goes[body] = false;
        const double share = 0.9 / double(count), from = 0.1 + share * double(body);
        parts.push_back({bodies.voxels(body), bodies.without(goes, part.part(from, from + share))});
      }
      return;
    }
    for (const size_t half : {0u, 1u}) {
      std::vector<bool> goes(count);
      for (size_t body = 0; body < count; ++body) goes[body] = (body < count / 2) == (half == 1);
      halves[half] = bodies.without(goes, part.part(0.1 + 0.05 * double(half), 0.15 + 0.05 * double(half)));
    }
  }
  splitInto(parts, halves[0], part.part(0.2, 0.6));
  halves[0] = {};
  splitInto(parts, halves[1], part.part(0.6, 1));
}

}  // namespace

std::vector<Version> splitParts(const Version& version, Job* job) {
  std::vector<SplitPart> parts;
  splitInto(parts, version, WorkPart(job));
  std::stable_sort(parts.begin(), parts.end(),
                   [](const SplitPart& a, const SplitPart& b) { return a.voxels > b.voxels; });
  std::vector<Version> versions;
  versions.reserve(parts.size());
  for (SplitPart& each : parts) versions.push_back(std::move(each.version));
  if (job) job->step(1);
  return versions;
}

Cleaned removeCrumbs(const Version& version, double belowMm3, Job* job) {
  if (!(belowMm3 >= 0)) throw Error("crumbs: the volume below which they go must be a number of mm³, zero or more");
  const WorkPart all(job);
  Components bodies(version, Tile::inside, all.part(0, 0.5));
  Cleaned result{version, 0, 0};
  std::vector<bool> goes(bodies.bodies(), false);
  const std::vector<size_t> order = bodies.largestFirst();
  for (size_t k = 1; k < order.size(); ++k) {
    const double volume = bodies.voxels(order[k]) * voxelVolume(version);
    if (!(volume < belowMm3)) continue;
    goes[order[k]] = true;
    ++result.count;
    result.volumeMm3 += volume;
  }
  if (result.count > 0) result.version = bodies.without(goes, all.part(0.5, 1));
  if (job) job->step(1);
  return result;
}

namespace {

// Bodies of a version's outside that no way leads to from the end of the grid.
std::vector<bool> cavitiesOf(Components& spaces) {
  std::vector<bool> cavity(spaces.bodies(), true);
  // The corner of all that there is lies outside.
  for (size_t i = 0; i < spaces.pieces().size(); ++i) {
    const Components::Piece& piece = spaces.pieces()[i];
    const Coord last = piece.first + Coord{1, 1, 1} * ((1 << (3 * piece.level)) - 1);
    if (std::min({piece.first.x, piece.first.y, piece.first.z}) <= -kBrickReach ||
        std::max({last.x, last.y, last.z}) >= kBrickReach - 1)
      cavity[spaces.body(i)] = false;
  }
  return cavity;
}

}  // namespace

Cleaned fillVoids(const Version& version, const WorkPart& part) {
  Components spaces(version, Tile::outside, part.part(0, 0.5));
  Cleaned result{version, 0, 0};
  const std::vector<bool> goes = cavitiesOf(spaces);
  for (size_t body = 0; body < goes.size(); ++body) {
    if (!goes[body]) continue;
    ++result.count;
    result.volumeMm3 += spaces.voxels(body) * voxelVolume(version);
  }
  if (result.count > 0) result.version = spaces.without(goes, part.part(0.5, 1));
  part.step(1);
  return result;
}

Specks removeSpecks(const Version& version, Tile side, double belowVoxels, const SpeckTest& goes,
                    const WorkPart& part) {
  Components parts(version, side, part.part(0, 0.5));
  std::vector<bool> may(parts.bodies(), true);
  if (side == Tile::outside)
    may = cavitiesOf(parts);
  else if (!may.empty())
    may[parts.largestFirst().front()] = false;
  Specks result;
  result.version = version;
  result.left = side == Tile::inside && !may.empty() ? 1 : 0;
  std::vector<bool> asked(parts.bodies(), false), went(parts.bodies(), false);
  for (size_t i = 0; i < parts.pieces().size(); ++i) {
    const size_t body = parts.body(i);
    if (!may[body] || asked[body]) continue;
    asked[body] = true;
    if (parts.voxels(body) < belowVoxels && goes(Components::voxelOf(parts.pieces()[i]), parts.voxels(body))) {
      went[body] = true;
      ++result.count;
      result.volumeMm3 += parts.voxels(body) * voxelVolume(version);
    } else {
      ++result.left;
    }
  }
  if (result.count > 0) result.version = parts.without(went, part.part(0.5, 1));
  part.step(1);
  return result;
}

}  // namespace argil::clay
