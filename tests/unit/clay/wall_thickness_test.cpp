// Walls of shapes that are known, and what import then really loses.
#include "clay/mesh/wall_thickness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <time.h>

#include "clay/import/mesh_to_clay.h"
#include "clay/store/store.h"
#include "test_meshes.h"

namespace argil::clay {
namespace {

using testing::append;
using testing::box;
using testing::icosphere;

const WorkPart kQuiet(nullptr);

TriangleMesh flipped(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) testing::flip(triangle);
  return mesh;
}

WallThickness of(const TriangleMesh& mesh) {
  return wallThickness(mesh, kQuiet);
}

TEST(WallThickness, OfAPlateIsThatOfItsFaces) {
  const WallThickness walls = of(box({0, 0, 0}, {40, 30, 1.5}));
  // Faces of 2400 and rims of 210 mm²; beside the rims the ball that fits is smaller than the plate.
  EXPECT_EQ(walls.shareThinner(1.4), 0);
  EXPECT_GT(walls.shareThinner(1.501), 0.88);
  EXPECT_LT(walls.shareThinner(29), 0.97);
  EXPECT_LE(walls.keepingVoxelMm(), 0.76);
}

TEST(WallThickness, OfABallIsItsDiameter) {
  const WallThickness walls = of(icosphere({5, -6, 7}, 10, 4));
  ASSERT_EQ(walls.wallsMm.size(), walls.points);
  EXPECT_NEAR(walls.wallsMm.front(), 20, 0.3);
  EXPECT_NEAR(walls.wallsMm.back(), 20, 0.3);
}

// The shell's two sides are two pieces of surface; turned inside out as a whole it is the same shell.
TEST(WallThickness, OfAShellIsItsWall) {
  TriangleMesh shell = icosphere({0, 0, 0}, 10, 4);
  append(shell, flipped(icosphere({0, 0, 0}, 9.2, 4)));
  for (const TriangleMesh& each : {shell, flipped(shell)}) {
    const WallThickness walls = of(each);
    EXPECT_GT(walls.shareThinner(0.85), 0.99);
    EXPECT_LT(walls.shareThinner(0.7), 0.01);
  }
}

// What overlaps has faces within it, near each other, and no thin wall.
TEST(WallThickness, FacesWithinAreNone) {
  TriangleMesh two = box({0, 0, 0}, {20, 20, 20});
  append(two, box({19.9, 0.01, 0.01}, {40, 19.99, 19.99}));
  EXPECT_LT(of(two).shareThinner(2), 0.02);
  TriangleMesh apart = box({0, 0, 0}, {20, 20, 20});
  append(apart, box({20.1, 0, 0}, {20.3, 20, 20}));
  EXPECT_NEAR(of(apart).shareThinner(0.25), 2 * 400 / (6 * 400 + 2 * 400 + 16.0), 0.02) << "the plate beside it";
}

TEST(WallThickness, AWedgeIsThinAtItsEdge) {
  // 20 long, 4 high at its back, 10 wide: 11.4° at the edge.
  TriangleMesh wedge;
  wedge.positions = {{0, 0, 0}, {20, 0, 0}, {20, 0, 4}, {0, 10, 0}, {20, 10, 0}, {20, 10, 4}};
  wedge.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {0, 2, 5}, {0, 5, 3}, {1, 4, 5}, {1, 5, 2}};
  const WallThickness walls = of(wedge);
  const double faces = 20 * 10 + std::hypot(20, 4) * 10, all = faces + 40 + 80;
  for (const double thick : {0.5, 1.0, 2.0})
    EXPECT_NEAR(walls.shareThinner(thick), faces / all * thick / 4, 0.03) << thick;
}

// From its middle everything of a ball is about equally far: its cost is of the order of any other body's all the same.
TEST(WallThickness, OfABallCostsNoMoreThanOfOthers) {
  const auto cost = [](const Vec3d& stretch) {
    TriangleMesh mesh = icosphere({0, 0, 0}, 10, 6);
    for (Vec3d& p : mesh.positions) p = p.cwiseProduct(stretch).eval();
    const auto thread = [] {
      timespec t{};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
      return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double begin = thread();
    (void)wallThickness(mesh, kQuiet, 2000, 1);
    return thread() - begin;
  };
  const double egg = cost({1, 0.6, 0.3});
  EXPECT_LT(cost({1, 1, 1}), 10 * egg + 0.5);
  EXPECT_LT(cost({1, 0.97, 1.02}), 10 * egg + 0.5) << "a potato";
}

TEST(WallThickness, NothingToLookAt) {
  EXPECT_EQ(of({}).keepingVoxelMm(), 0);
  TriangleMesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_EQ(of(flat).points, 0u);
  flat.positions[2] = {0, 1, 0};
  EXPECT_EQ(of(flat).keepingVoxelMm(), 0) << "a sheet has no wall";
  EXPECT_EQ(of(flat).shareThinner(1), 0);
}

TEST(WallThickness, DoesNotDependOnThreads) {
  const TriangleMesh mesh = icosphere({0, 0, 0}, 10, 3);
  EXPECT_EQ(wallThickness(mesh, kQuiet, 3000, 1).wallsMm, wallThickness(mesh, kQuiet, 3000, 5).wallsMm);
}

TEST(WallThickness, IsCancelled) {
  Job job;
  job.cancel();
  EXPECT_THROW(static_cast<void>(wallThickness(icosphere({0, 0, 0}, 10, 3), WorkPart(&job))), Cancelled);
}

// The promise: with the voxel that it names, import loses next to nothing; with four of them, what was told.
TEST(WallThickness, TheVoxelThatItNamesKeepsTheWalls) {
  TriangleMesh shape = box({0, 0, 0}, {30, 20, 6});
  append(shape, box({29, 5, 2}, {45, 15, 2.7}));  // a fin
  const double voxel = of(shape).keepingVoxelMm();
  EXPECT_DOUBLE_EQ(voxel, 0.35);
  ImportOptions options;
  options.grid.voxelMm = voxel;
  EXPECT_EQ(meshToClay(Store::make(), shape, options).report.losses.lostMm2, 0);
  options.grid.voxelMm = 3;
  EXPECT_GT(meshToClay(Store::make(), shape, options).report.losses.lostMm2, 200);
}

}  // namespace
}  // namespace argil::clay
