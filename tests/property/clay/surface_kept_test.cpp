// Meshes that an update replaced are kept for the way back: the same meshes, never more than a surface's memory.

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/surface/vertex_channels.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Version without(const Version& clay, const Vec3d& at, double radius) {
  return combine(clay, makeSphere(Store::make(), clay.grid(), at, radius), Combination::cut);
}

Grid millimetres() {
  Grid grid;
  grid.voxelMm = 1;
  return grid;
}

// What deltas add up to, and that of one surface anew.
class Listener {
 public:
  void take(const SurfaceDelta& delta) {
    for (const BrickMeshPtr& mesh : delta.changed) {
      ASSERT_NE(std::exchange(last_, mesh->serial), mesh->serial);
      if (mesh->positions.empty() && mesh->quads.empty())
        meshes_.erase(mesh->brick);
      else
        meshes_[mesh->brick] = mesh;
    }
  }
  [[nodiscard]] std::map<Coord, uint64_t> serials() const {
    std::map<Coord, uint64_t> all;
    for (const auto& [brick, mesh] : meshes_) all[brick] = mesh->serial;
    return all;
  }
  void expectSame(const Surface& surface, const Version& version) {
    Surface anew;
    anew.update(version);
    ASSERT_EQ(surface.hash(), anew.hash());
    ASSERT_EQ(surface.vertexCount(), anew.vertexCount());
    ASSERT_EQ(surface.quadCount(), anew.quadCount());
    size_t count = 0;
    surface.forEach([&](const BrickMesh& mesh) {
      ++count;
      ASSERT_TRUE(meshes_.contains(mesh.brick));
      ASSERT_EQ(meshes_[mesh.brick]->serial, mesh.serial);
    });
    ASSERT_EQ(count, meshes_.size());
  }

 private:
  std::map<Coord, BrickMeshPtr> meshes_;
  uint64_t last_ = 0;
};

TEST(SurfaceKept, UndoAndRedoGiveTheSameMeshesBack) {
  const Version whole = makeSphere(Store::make(), millimetres(), Vec3d::Zero(), 50);
  const Version cut = without(whole, {50, 0, 0}, 25);
  Surface surface;
  Listener listener;
  listener.take(surface.update(whole));
  const auto before = listener.serials();
  EXPECT_FALSE(surface.keeps(whole));
  listener.take(surface.update(cut, 1, true));
  const auto after = listener.serials();
  ASSERT_NE(before, after);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(surface.keeps(whole));
    EXPECT_FALSE(surface.keeps(cut)) << "it is there already";
    listener.take(surface.update(whole));
    EXPECT_EQ(listener.serials(), before);
    listener.expectSame(surface, whole);
    ASSERT_TRUE(surface.keeps(cut));
    listener.take(surface.update(cut));
    EXPECT_EQ(listener.serials(), after);
    listener.expectSame(surface, cut);
  }
}

// Steps back and forth, strokes in between, other steps after an undo: whatever is kept, the surface is the version's.
TEST(SurfaceKept, RandomHistoriesEqualExtractingAnew) {
  const uint64_t seed = 20261123;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-30, 30), size(4, 18);
  std::vector<Version> history = {makeSphere(Store::make(), millimetres(), Vec3d::Zero(), 30)};
  size_t at = 0;
  Surface surface;
  Listener listener;
  listener.take(surface.update(history[0]));
  int kept = 0;
  for (int step = 0; step < 120; ++step) {
    const auto choice = random() % 5;
    if (choice == 0 && at > 0) {
      --at;
    } else if (choice == 1 && at + 1 < history.size()) {
      ++at;
    } else if (choice == 2) {
      at = random() % history.size();
    } else {
      const Vec3d centre(place(random), place(random), place(random));
      history.resize(at + 1);
      if (choice == 3) {
        BrushStroke brush(history[at], Brush::of(Method::carve));
        brush.apply({centre, centre, size(random)});
        history.push_back(brush.finish());
      } else {
        history.push_back(without(history[at], centre, size(random)));
      }
      ++at;
    }
    kept += surface.keeps(history[at]);
    listener.take(surface.update(history[at], 1 + step % 2, random() % 4 != 0));
    listener.expectSame(surface, history[at]);
    if (testing::Test::HasFatalFailure()) FAIL() << "seed " << seed << ", step " << step;
  }
  EXPECT_GT(kept, 10);
}

// Each of these steps replaces all of the surface.
TEST(SurfaceKept, IsNeverMoreThanTheSurfaceItself) {
  std::vector<Version> history = {makeSphere(Store::make(), millimetres(), Vec3d::Zero(), 40)};
  Surface surface;
  surface.update(history[0]);
  for (int step = 0; step < 4; ++step) {
    history.push_back(without(history.back(), Vec3d(0.3 * (step + 1), 0, 0), 10 + 6 * step));
    const Version shell =
        combine(history.back(), makeSphere(Store::make(), millimetres(), {0.1 * step, 0, 0}, 39 - step),
                Combination::intersect);
    history.push_back(shell);
    surface.update(shell, 1, true);
  }
  ASSERT_TRUE(surface.keeps(history[history.size() - 3]));
  surface.update(history[history.size() - 3]);
  EXPECT_FALSE(surface.keeps(history[history.size() - 5])) << "the oldest goes first";
}

// Paint has to be found for vertices that come back: that is not for a thread that edits.
TEST(SurfaceKept, PaintedClayComesBackWithItsPaint) {
  const Version whole = makeSphere(Store::make(), millimetres(), Vec3d::Zero(), 40);
  auto paint = std::make_shared<Brush>();
  paint->operations = {{Property::colour, Method::set, Falloff::smooth, 1}};
  paint->colour = {200, 30, 60};
  BrushStroke brush(whole, paint);
  brush.apply({{40, 0, 0}, {40, 0, 0}, 12});
  const Version painted = brush.finish(), cut = without(painted, {35, 10, 0}, 14);
  ASSERT_TRUE(hasChannels(painted));
  Surface surface;
  surface.update(painted);
  const std::vector<VertexPaint> before = meshPaint(surface);
  surface.update(cut, 1, true);
  EXPECT_FALSE(surface.keeps(painted));
  const SurfaceDelta back = surface.update(painted);
  EXPECT_EQ(meshPaint(surface), before);
  EXPECT_GT(back.painted.size(), 0u);
}

}  // namespace
}  // namespace argil::clay
