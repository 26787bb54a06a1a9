#include "io/records/clay_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "clay/base/error.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"
#include "clay/store/tree_view.h"

namespace argil::io {

namespace {

using clay::Tile;
using clay::TreePlace;
using clay::Version;

#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION  // a fuzzer has no time for smooth clay
constexpr size_t kMostWallBricks = size_t{1} << 11;
constexpr int kRounds = 1, kSweeps = 1;
constexpr size_t kManyLost = 600;
#else
constexpr size_t kMostWallBricks = size_t{1} << 16;  // 140 MB
// Relaxation of lost bricks: eight sweeps carry a value through a brick, eight rounds through a few bricks side by
// side.
constexpr int kRounds = 8, kSweeps = 8;
constexpr size_t kManyLost = 20000;  // then two rounds must do
#endif
constexpr int kLargeLevel = 2;     // blocks of 512 voxels
constexpr float kSettled = 1e-3f;  // voxels a sweep: far below what such a guess is off

int edgeOf(int level) {
  return 1 << (3 * level);
}

int& axisOf(Coord& c, int axis) {
  return axis == 0 ? c.x : axis == 1 ? c.y : c.z;
}

// Faces 0 to 5: lower and upper along x, y, z.
Coord across(Coord first, int level, int face) {
  axisOf(first, face / 2) += face % 2 == 0 ? -edgeOf(level) : edgeOf(level);
  return first;
}

bool inTree(Coord c) {
  const Coord low = clay::treeFirst();
  const auto in = [](int32_t at, int32_t from) {
    return at >= from && int64_t{at} < int64_t{from} + edgeOf(clay::kTreeLevels);
  };
  return in(c.x, low.x) && in(c.y, low.y) && in(c.z, low.z);
}

bool inReach(Coord first, int level) {
  const auto in = [level](int32_t c) {
    return c >= -clay::kBrickReach && int64_t{c} + edgeOf(level) <= clay::kBrickReach;
  };
  return in(first.x) && in(first.y) && in(first.z);
}

// What stands at a block: its place, or the tile of a larger one.
TreePlace placeAt(const Version& version, Coord first, int level) {
  TreePlace at = TreePlace::root(version);
  while (at.level() > level && at.isNode()) {
    const Coord d = (first - at.first()) >> (3 * (at.level() - 1));
    at = at.child((d.x & 7) << 6 | (d.y & 7) << 3 | (d.z & 7));
  }
  return at;
}

// The 64 of 8×8×8 that lie at a face: voxels of a brick, children of a node.
template <class Visit>
void forFaceVoxels(int face, const Visit& visit) {
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 8; ++k) {
      Coord c;
      axisOf(c, face / 2) = face % 2 == 0 ? 0 : 7;
      axisOf(c, (face / 2 + 1) % 3) = i;
      axisOf(c, (face / 2 + 2) % 3) = k;
      visit(c);
    }
}
template <class Visit>
void forFaceChildren(Coord first, int level, int face, const Visit& visit) {
  forFaceVoxels(face, [&](Coord c) { visit(first + c * edgeOf(level - 1)); });
}

// Voxels of a brick's face that are inside, less those outside.
int signOfFace(const clay::Brick& brick, int face) {
  int inside = 0;
  forFaceVoxels(face, [&](Coord c) { inside += brick.phi(clay::Brick::offset(c.x, c.y, c.z)) < 0 ? 1 : -1; });
  return inside;
}

using Halo = float[10][10][10];  // a brick's voxels from (1, 1, 1) on, and those beside its faces

// Sweeps towards the harmonic function between what stands at the faces. The largest change of the last sweep.
float relax(Halo& at, std::array<float, clay::kBrickVoxels>& values) {
  const auto index = [](int x, int y, int z) { return static_cast<size_t>(clay::Brick::offset(x - 1, y - 1, z - 1)); };
  for (int x = 1; x < 9; ++x)
    for (int y = 1; y < 9; ++y)
      for (int z = 1; z < 9; ++z) at[x][y][z] = values[index(x, y, z)];
  float change = 0;
  for (int sweep = 0; sweep < kSweeps && (sweep == 0 || change > 0); ++sweep) {
    change = 0;
    for (int x = 1; x < 9; ++x)
      for (int y = 1; y < 9; ++y)
        for (int z = 1; z < 9; ++z) {
          const float sum = ((at[x - 1][y][z] + at[x + 1][y][z]) + (at[x][y - 1][z] + at[x][y + 1][z])) +
                            (at[x][y][z + 1] + at[x][y][z - 1]);
          const float next = sum / 6;
          change = std::max(change, std::abs(next - at[x][y][z]));
          at[x][y][z] = next;
        }
  }
  for (int x = 1; x < 9; ++x)
    for (int y = 1; y < 9; ++y)
      for (int z = 1; z < 9; ++z) values[index(x, y, z)] = at[x][y][z];
  return change;
}

class Repairing {
 public:
  explicit Repairing(const Version& damaged) : version_(damaged) {}

  void addLost(const LostBlock& block) {
    for (int level = clay::kTreeLevels; level > block.level; --level) {
      const auto known = index_[static_cast<size_t>(level)].find(clay::Editor::blockFirst(block.first, level));
      // all of it is lost already
      if (known != index_[static_cast<size_t>(level)].end() && known->second != kAbove) return;
    }
    if (index_[static_cast<size_t>(block.level)].contains(block.first)) return;
    const TreePlace at = placeAt(version_, block.first, block.level);
    if (block.level == 1 && at.isTile() && leaves_.size() < kManyLost) {  // few enough to be filled smoothly
      for (int i = 0; i < 512; ++i) addLeaves(clay::childFirst(block.first, 1, i), 0, at);
      return;
    }
    addLeaves(block.first, block.level, at);
  }

  Version run() {
    const Version damaged = version_;
    for (const bool cautious : {false, true}) {
      decideTiles(cautious);
      fill();
      if (const auto closed = closeWalls()) return *closed;
      // A large block was taken for inside by little evidence: without large ones, walls follow the small blocks.
      version_ = damaged;
    }
    throw Error("damaged: too much of the clay is lost", Error::Kind::work);
  }

 private:
  // A part of the lost blocks that is one tile.
  struct Leaf {
    Coord first;
    int level;
    int64_t votes = 0;  // for inside
    Tile tile = Tile::outside;
    bool decided = false;
  };
  static constexpr size_t kAbove = SIZE_MAX;  // in index_: leaves lie below

  void addLeaves(Coord first, int level, const TreePlace& at) {
    if (at.brick()) return;
    if (at.isNode()) {
      for (int i = 0; i < 512; ++i) addLeaves(clay::childFirst(first, level, i), level - 1, at.child(i));
      return;
    }
    for (int above = level + 1; above <= clay::kTreeLevels; ++above)
      index_[static_cast<size_t>(above)].emplace(clay::Editor::blockFirst(first, above), kAbove);
    index_[static_cast<size_t>(level)][first] = leaves_.size();
    leaves_.push_back({first, level});
  }

  // Calls back with what touches a block (one step away across `face` of a leaf) on its side towards that leaf: a leaf,
  // or a known tile or brick.
  void visitTouching(Coord first, int level, int face, const std::function<void(Leaf*, const TreePlace&, int)>& visit) {
    if (!inTree(first)) return visit(nullptr, TreePlace(), level);
    for (int above = level + 1; above <= clay::kTreeLevels; ++above) {
      const auto known = index_[static_cast<size_t>(above)].find(clay::Editor::blockFirst(first, above));
      if (known != index_[static_cast<size_t>(above)].end() && known->second != kAbove)
        return visit(&leaves_[known->second], TreePlace(), level);
    }
    visitWithin(first, level, face, visit);
  }
  void visitWithin(Coord first, int level, int face, const std::function<void(Leaf*, const TreePlace&, int)>& visit) {
    const auto known = index_[static_cast<size_t>(level)].find(first);
    const bool below = known != index_[static_cast<size_t>(level)].end();
    if (below && known->second != kAbove) return visit(&leaves_[known->second], TreePlace(), level);
    const TreePlace at = placeAt(version_, first, level);
    if (!below && !at.isNode()) return visit(nullptr, at, level);
    forFaceChildren(first, level, face ^ 1, [&](Coord child) { visitWithin(child, level - 1, face, visit); });
  }

  // Each leaf as most voxels around it are; what touches no known clay, as the leaves beside it.
  void decideTiles(bool cautious) {
    std::vector<size_t> queue;
    for (size_t i = 0; i < leaves_.size(); ++i) {
      Leaf& leaf = leaves_[i];
      leaf.votes = 0;
      leaf.tile = Tile::outside;
      leaf.decided = cautious && leaf.level >= kLargeLevel;
      if (leaf.decided) continue;
      for (int face = 0; face < 6; ++face) {
        visitTouching(
            across(leaf.first, leaf.level, face), leaf.level, face, [&](Leaf* other, const TreePlace& at, int level) {
              if (other) return;
              const int64_t area = int64_t{64} << (6 * level);
              leaf.votes += at.brick() ? signOfFace(*at.brick(), face ^ 1) : at.tile() == Tile::inside ? area : -area;
            });
      }
      if (leaf.votes == 0) continue;
      leaf.tile = leaf.votes > 0 ? Tile::inside : Tile::outside;
      leaf.decided = true;
      queue.push_back(i);
    }
    for (size_t next = 0; next < queue.size(); ++next) {
      const Leaf leaf = leaves_[queue[next]];
      for (int face = 0; face < 6; ++face) {
        visitTouching(across(leaf.first, leaf.level, face), leaf.level, face, [&](Leaf* other, const TreePlace&, int) {
          if (!other || other->decided) return;
          other->tile = leaf.tile;
          other->decided = true;
          queue.push_back(static_cast<size_t>(other - leaves_.data()));
        });
      }
    }
  }

  void fill() {
    clay::Editor editor(version_);
    std::vector<Coord> bricks;
    for (const Leaf& leaf : leaves_) {
      if (!inReach(leaf.first, leaf.level)) continue;
      editor.setBlock(leaf.first, leaf.level, leaf.tile);
      if (leaf.level == 0) bricks.push_back(leaf.first);
    }
    // Harmonic between what stands around.
    const float band = editor.grid().band;
    std::vector<std::array<float, clay::kBrickVoxels>> values(bricks.size());
    std::unordered_map<Coord, size_t, clay::CoordHash> indexOf;
    for (size_t i = 0; i < bricks.size(); ++i) {
      indexOf[bricks[i]] = i;
      values[i].fill(editor.find(bricks[i]).phi(0, band));
    }
    const int rounds = bricks.size() > kManyLost ? 2 : kRounds;
    std::vector<char> settled(bricks.size());
    for (int round = 0; round < rounds; ++round) {
      for (size_t i = 0; i < bricks.size(); ++i) {
        if (settled[i]) continue;
        Halo halo = {};
        for (int face = 0; face < 6; ++face) {
          const Coord beside = across(bricks[i], 0, face);
          const auto other = indexOf.find(beside);
          const clay::Slot slot = editor.find(beside);
          forFaceVoxels(face ^ 1, [&](Coord from) {
            Coord to = from + Coord{1, 1, 1};
            axisOf(to, face / 2) = face % 2 == 0 ? 0 : 9;
            const int offset = clay::Brick::offset(from.x, from.y, from.z);
            halo[to.x][to.y][to.z] =
                other == indexOf.end() ? slot.phi(offset, band) : values[other->second][static_cast<size_t>(offset)];
          });
        }
        settled[i] = relax(halo, values[i]) < kSettled;
        if (settled[i]) continue;
        for (int face = 0; face < 6; ++face)
          if (const auto other = indexOf.find(across(bricks[i], 0, face)); other != indexOf.end())
            settled[other->second] = 0;
      }
    }
    for (size_t i = 0; i < bricks.size(); ++i) editor.setVoxels(bricks[i], values[i]);
    version_ = editor.commit();
  }

  // No brick would own the surface between an inside tile and an outside one: both sides become bricks.
  std::optional<Version> closeWalls() {
    std::map<Coord, Tile> wall;
    const auto addPair = [&](const auto& self, Coord first, int level, int face, Tile tile) -> void {
      if (wall.size() > kMostWallBricks) return;
      if (level > 0) {
        forFaceChildren(first, level, face, [&](Coord child) { self(self, child, level - 1, face, tile); });
        return;
      }
      wall.emplace(first, tile);
      wall.emplace(across(first, 0, face), tile == Tile::inside ? Tile::outside : Tile::inside);
    };
    const auto visit = [&](const auto& self, Coord first, int level, int face, Tile tile) -> void {
      const TreePlace other = placeAt(version_, across(first, level, face), level);
      if (other.isNode())
        forFaceChildren(first, level, face, [&](Coord child) { self(self, child, level - 1, face, tile); });
      else if (!other.brick() && other.tile() != tile) {
        // Before they are counted out one by one: a face of level 8 would have 64^8.
        if (2 * (uint64_t{1} << (6 * level)) > kMostWallBricks)
          throw Error("damaged: too much of the clay is lost", Error::Kind::work);
        addPair(addPair, first, level, face, tile);
      }
    };
    for (const Leaf& leaf : leaves_) {
      const TreePlace at = placeAt(version_, leaf.first, leaf.level);
      if (!at.isTile()) continue;
      for (int face = 0; face < 6; ++face)
        if (inTree(across(leaf.first, leaf.level, face))) visit(visit, leaf.first, leaf.level, face, at.tile());
    }
    if (wall.size() > kMostWallBricks) return std::nullopt;
    clay::Editor editor(version_);
    const float band = editor.grid().band;
    for (const auto& [brick, tile] : wall) {
      if (!inReach(brick, 0)) continue;
      std::array<float, clay::kBrickVoxels> phi;
      phi.fill(band);
      for (int n = 0; n < 27; ++n) {
        const Coord d{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
        const clay::Slot beside = version_.find(brick + d);
        if (!beside.isTile() || beside.tile() == tile) continue;
        const auto gap = [](int at, int towards) {
          return towards == 0 ? 0.0f : static_cast<float>(towards < 0 ? at : 7 - at) + 0.5f;
        };
        for (int k = 0; k < clay::kBrickVoxels; ++k) {
          const float x = gap(k >> 6, d.x), y = gap(k >> 3 & 7, d.y), z = gap(k & 7, d.z);
          phi[static_cast<size_t>(k)] = std::min(phi[static_cast<size_t>(k)], std::sqrt(x * x + y * y + z * z));
        }
      }
      if (tile == Tile::inside)
        for (float& each : phi) each = -each;
      editor.setVoxels(brick, phi);
    }
    return editor.commit();
  }

  Version version_;
  std::vector<Leaf> leaves_;
  std::array<std::unordered_map<Coord, size_t, clay::CoordHash>, clay::kTreeLevels + 1> index_;
};

}  // namespace

Version repairClay(const Version& damaged, std::span<const LostBlock> lost) {
  if (lost.empty()) return damaged;
  Repairing repairing(damaged);
  std::vector<LostBlock> blocks(lost.begin(), lost.end());
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const LostBlock& a, const LostBlock& b) { return a.level > b.level; });
  for (const LostBlock& block : blocks) repairing.addLost(block);
  return repairing.run();
}

}  // namespace argil::io
