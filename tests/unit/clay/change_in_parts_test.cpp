// A change that is looked at while it is half done.

#include "clay/store/change_in_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <span>
#include <tuple>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"

namespace argil::clay {
namespace {

// Voxels of 0.25 mm; balls that overlap in part, so that tiles become clay and clay becomes tiles, of both kinds.
Version ball(const std::shared_ptr<Store>& store, const Vec3d& middleMm, double radiusMm) {
  return makeSphere(store, Grid{.voxelMm = 0.25}, middleMm, radiusMm);
}

// A brick of `to`, or of the distances of its tile.
FloatBrick* copyOf(Editor& editor, Coord coord, Slot to) {
  FloatBrick* brick = editor.newBrick(coord);
  BrickValues room;
  std::copy_n(to.values(room, editor.grid().band), kBrickVoxels, brick->value);
  for (int x = 0; x < kBrickEdge; ++x) {
    brick->inside[x] = 0;
    for (int i = 0; i < 64; ++i) brick->inside[x] |= uint64_t{brick->value[x * 64 + i] < 0} << i;
  }
  return brick;
}

// Places where tiles of both kinds meet with no brick beside them, which no surface can show.
int holes(const Editor& editor, std::span<const Coord> bricks) {
  int holes = 0;
  for (const Coord coord : bricks)
    for (int lower = 0; lower < 8; ++lower) {
      const Coord first = coord - Coord{lower >> 2, (lower >> 1) & 1, lower & 1};
      int inside = 0, tiles = 0;
      for (int i = 0; i < 8; ++i) {
        const Slot slot = editor.find(first + Coord{i >> 2, (i >> 1) & 1, i & 1});
        tiles += slot.isTile();
        inside += slot == Slot(Tile::inside);
      }
      holes += tiles == 8 && inside > 0 && inside < 8;
    }
  return holes;
}

// All that differ within 80 voxels, sorted.
std::vector<Coord> differences(const Version& a, const Version& b) {
  std::vector<Coord> bricks;
  for (int x = -10; x < 10; ++x)
    for (int y = -10; y < 10; ++y)
      for (int z = -10; z < 10; ++z)
        if (const Coord coord{x, y, z}; a.find(coord) != b.find(coord)) bricks.push_back(coord);
  return bricks;
}

struct Changed {
  std::vector<Coord> bricks;
  int looks = 0, holes = 0, open = 0;
  uint64_t hash = 0;
};

// Makes `to` of `from` brick by brick and looks at it every `every` of them.
Changed change(const Version& from, const Version& to, size_t every) {
  Changed result;
  result.bricks = differences(from, to);
  std::optional<Editor> editor(from);
  ChangeInParts parts(*editor, result.bricks);
  Surface surface;
  for (size_t i = 0; i < result.bricks.size(); ++i) {
    const Coord coord = result.bricks[i];
    const Slot slot = to.find(coord);
    parts.link(i, copyOf(*editor, coord, slot), !slot.isTile());
    parts.done(i + 1);
    const size_t looked = std::min<size_t>(i, 400);  // about a layer
    if (i % 4 == 0) result.holes += holes(*editor, std::span(result.bricks).subspan(i - looked, looked));
    if ((i + 1) % every != 0 && i + 1 < result.bricks.size()) continue;
    const Version now = editor->commit();
    editor.emplace(now);
    surface.update(now);
    ++result.looks;
    result.open += !checkTopology(surface.toMesh()).closed();
    result.hash = now.hash();
  }
  return result;
}

// The same at once.
uint64_t hashAtOnce(const Version& from, const Version& to, const std::vector<Coord>& bricks) {
  Editor editor(from);
  for (const Coord coord : bricks) editor.link(copyOf(editor, coord, to.find(coord)), !to.find(coord).isTile());
  return editor.commit().hash();
}

class ChangesInParts : public testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Precisions, ChangesInParts, testing::Values(Precision::float32, Precision::fixed16));

TEST_P(ChangesInParts, AreClosedWhereverTheyStandAndEndAsTheWhole) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 6; ++i) {
    const auto store = Store::make(GetParam());
    // From 20 voxels to 48 and back, and aside: outside tiles become inside ones and the other way round.
    const Version small = ball(store, Vec3d(u(random), u(random), u(random)), 5),
                  large = ball(store, 2 * Vec3d(u(random), u(random), u(random)), 12);
    const auto& [from, to] = i % 2 ? std::tie(small, large) : std::tie(large, small);
    const Changed changed = change(from, to, 40);
    ASSERT_GT(changed.looks, 20);
    EXPECT_EQ(changed.holes, 0) << i;
    EXPECT_EQ(changed.open, 0) << i;
    EXPECT_EQ(changed.hash, hashAtOnce(from, to, changed.bricks)) << i;
  }
}

// What becomes a tile waits as a brick for what is beside it, not for the end.
TEST(ChangeInParts, LetsGoOfWhatIsDone) {
  const auto store = Store::make();
  const Version from = ball(store, Vec3d::Zero(), 6), to = ball(store, Vec3d(6, 0, 0), 9);
  const std::vector<Coord> bricks = differences(from, to);
  Editor editor(from);
  ChangeInParts parts(editor, bricks);
  size_t most = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    const Slot slot = to.find(bricks[i]);
    parts.link(i, copyOf(editor, bricks[i], slot), !slot.isTile());
    parts.done(i + 1);
    size_t waiting = 0;
    for (size_t k = 0; k <= i; ++k) {
      if (editor.find(bricks[k]).isTile() || !to.find(bricks[k]).isTile()) continue;
      ++waiting;
      ASSERT_LT(i + 1, bricks.size());
      EXPECT_GE(bricks[k].x + 1, bricks[i + 1].x);
    }
    most = std::max(most, waiting);
  }
  EXPECT_GT(most, 0u);
}

}  // namespace
}  // namespace argil::clay
