// The fine surface after edits and on fields that are no solid's: closed, bounded, and the same however it came about.

#include <gtest/gtest.h>

#include "clay/brush/brush.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/surface/rim_vertices.h"
#include "tests/support/simd_targets.h"
#include "tests/unit/clay/sharp_shapes.h"

namespace argil::clay {
namespace {

using namespace testing;

// The box of which a corner moves: every brick around changes in turn.
Version cutBy(const Version& base, const TurnedBox& box, Coord first, Coord last) {
  Editor editor(base);
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y)
      for (int z = first.z; z <= last.z; ++z) {
        const Slot old = editor.find({x, y, z});
        std::array<float, kBrickVoxels> phi;
        for (int i = 0; i < kBrickVoxels; ++i) {
          const Vec3d p(8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7));
          phi[static_cast<size_t>(i)] = std::max(old.phi(i, base.grid().band), static_cast<float>(-box.cut(p)));
        }
        editor.setVoxels({x, y, z}, phi);
      }
  return editor.commit();
}

class CreaseGrades : public ::testing::TestWithParam<Grade> {};
INSTANTIATE_TEST_SUITE_P(SharpFeatures, CreaseGrades, ::testing::Values(Grade::crisp, Grade::fine),
                         [](const auto& grade) { return grade.param == Grade::crisp ? "crisp" : "fine"; });

TEST_P(CreaseGrades, FollowingEqualsExtractingAnewOnAnyNumberOfThreads) {
  const uint64_t seed = 31;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-14, 14);
  const auto store = Store::make();
  TurnedBox box;
  box.axes = randomTurn(random);
  box.half = Vec3d(14, 13, 12);
  Version version = clayOf(store, 26, [&](const Vec3d& p) { return box.distance(p); });
  Surface following(true, GetParam());
  following.update(version);
  for (int step = 0; step < 10; ++step) {
    TurnedBox tool;
    tool.axes = randomTurn(random);
    tool.half = Vec3d(3, 4, 5);
    tool.centre = Vec3d(place(random), place(random), place(random));
    const auto low = [](double v) { return static_cast<int>(std::floor((v - 11) / 8)); };
    const auto high = [](double v) { return static_cast<int>(std::floor((v + 11) / 8)); };
    version = cutBy(version, tool, {low(tool.centre.x()), low(tool.centre.y()), low(tool.centre.z())},
                    {high(tool.centre.x()), high(tool.centre.y()), high(tool.centre.z())});
    following.update(version, 1 + step % 3);
    Surface fresh(true, GetParam());
    fresh.update(version);
    ASSERT_EQ(following.hash(), fresh.hash()) << "seed " << seed << " step " << step;
  }
  ASSERT_TRUE(checkTopology(following.toMesh()).closed());
}

// Clay that bends everywhere, and stamps so small that most of them end within a few voxels of a brick's border: what a
// brick takes from those around it has to be looked at again, and no more.
TEST_P(CreaseGrades, SmallChangesBesideAnyBrickAreFollowed) {
  const uint64_t seed = 33;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-13, 13), size(1, 2.5);
  std::vector<Vec3d> balls;
  for (int i = 0; i < 12; ++i) balls.emplace_back(place(random), place(random), place(random));
  Version version = clayOf(Store::make(), 26, [&](const Vec3d& p) {
    double least = 1e9;
    for (const Vec3d& ball : balls) least = std::min(least, (p - ball).norm() - 7);
    return least;
  });
  Surface following(true, GetParam());
  following.update(version);
  const int steps = GetParam() == Grade::crisp ? 600 : 50;
  for (int step = 0; step < steps; ++step) {
    const Vec3d towards = Vec3d(place(random), place(random), place(random)).normalized();
    const Vec3d at = balls[random() % balls.size()] + 7 * towards;
    BrushStroke stroke(version, Brush::of(step % 2 == 0 ? Method::carve : Method::add));
    stroke.apply({at, at, size(random)});
    version = stroke.finish();
    following.update(version);
    Surface fresh(true, GetParam());
    fresh.update(version);
    ASSERT_EQ(following.hash(), fresh.hash()) << "seed " << seed << " step " << step;
  }
}

// A crease that comes beside a brick, by changes that end before it.
TEST_P(CreaseGrades, ACreaseInTheNextBrickIsSeen) {
  const Vec3d centre(3.8, 3.6, 3.9);
  const auto ball = [&](const Vec3d& p) { return (p - centre).norm() - 7; };
  const Version base = clayOf(Store::make(), 16, ball);
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1})
      for (double at = 0.2; at < 3; at += 0.1) {
        // Beyond x = ±at (or y, or z) the ball is cut, in the bricks of that side alone: the others keep every value.
        const double border = side < 0 ? -at : 7 + at;
        Editor editor(base);
        for (int x = -2; x < 2; ++x)
          for (int y = -2; y < 2; ++y)
            for (int z = -2; z < 2; ++z) {
              const Coord brick{x, y, z};
              const int along = axis == 0 ? x : axis == 1 ? y : z;
              if ((side < 0 ? along >= 0 : along <= 0) || editor.find(brick).isTile()) continue;
              std::array<float, kBrickVoxels> phi;
              for (int i = 0; i < kBrickVoxels; ++i) {
                const Vec3d p(8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7));
                phi[static_cast<size_t>(i)] = static_cast<float>(std::max(ball(p), side * (p[axis] - border)));
              }
              editor.setVoxels(brick, phi);
            }
        const Version cut = editor.commit();
        Surface following(true, GetParam()), fresh(true, GetParam());
        following.update(base);
        following.update(cut);
        fresh.update(cut);
        ASSERT_EQ(following.hash(), fresh.hash()) << "axis " << axis << " side " << side << " at " << at;
      }
}

TEST_P(CreaseGrades, EqualBitsOnEverySimdTarget) {
  const auto store = Store::make();
  std::mt19937_64 random(32);
  TurnedBox box;
  box.axes = randomTurn(random);
  const Version version = clayOf(store, 24, [&](const Vec3d& p) { return box.distance(p); });
  uint64_t first = 0;
  tests::forEachSimdTarget([&](const std::string& target) {
    Surface surface(true, GetParam());
    surface.update(version);
    if (first == 0) first = surface.hash();
    EXPECT_EQ(surface.hash(), first) << target;
  });
  EXPECT_NE(first, 0u);
}

// Noise, and boxes with noise: vertices never leave the neighbourhood of their cells, are finite, and the mesh is
// closed.
TEST_P(CreaseGrades, RandomFieldsKeepTheirVerticesNearTheirCells) {
  const uint64_t seed = 33;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  for (int field = 0; field < 40; ++field) {
    TurnedBox box;
    box.axes = randomTurn(random);
    box.half = Vec3d(7, 6, 5);
    const double noise = field % 4 == 0 ? 3 : 0.02 * (field % 4);
    std::uniform_real_distribution<double> rough(-noise, noise);
    const Version version = clayOf(store, 12, [&](const Vec3d& p) {
      const double d = box.distance(p) + rough(random);
      return std::max(p.cwiseAbs().maxCoeff() - 14, d);
    });
    Surface draft(true), fine(true, GetParam());
    draft.update(version);
    fine.update(version);
    ASSERT_TRUE(checkTopology(fine.toMesh()).closed()) << "seed " << seed << " field " << field;
    draft.forEach([&](const BrickMesh& mesh) {
      const BrickMesh* other = fine.find(mesh.brick);
      ASSERT_NE(other, nullptr);
      ASSERT_EQ(other->positions.size(), mesh.positions.size());
      for (size_t i = 0; i < mesh.positions.size(); ++i) {
        ASSERT_TRUE(other->positions[i].allFinite());
        // The draft's is in the cell.
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GE(other->positions[i][axis], std::floor(mesh.positions[i][axis] - 1e-4f) - kVertexReach - 1e-3f)
              << "seed " << seed << " field " << field;
          ASSERT_LE(other->positions[i][axis], std::ceil(mesh.positions[i][axis] + 1e-4f) + kVertexReach + 1e-3f)
              << "seed " << seed << " field " << field;
        }
      }
    });
  }
}

}  // namespace
}  // namespace argil::clay
