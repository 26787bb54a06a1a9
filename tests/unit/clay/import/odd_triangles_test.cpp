// Meshes whose triangles cross or are slivers.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "clay/import/mesh_to_clay.h"
#include "clay/store/store.h"
#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

using testing::append;
using testing::box;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// With unit voxels and the origin at zero where none is given.
Imported import(const TriangleMesh& mesh, double voxelMm = 1) {
  ImportOptions options;
  options.grid.voxelMm = voxelMm;
  options.placeOrigin = false;
  return meshToClay(Store::make(), mesh, options);
}

// An upright prism on the star polygon {n/k} of radius 10, which crosses itself: closed, one body, wound around up to k
// times.
TriangleMesh starPrism(int n, int k, double height) {
  TriangleMesh mesh;
  const auto count = uint32_t(n);
  for (const double z : {0.0, height})
    for (int i = 0; i < n; ++i) {
      const double turn = 2 * M_PI * k * i / n;
      mesh.positions.emplace_back(10 * std::cos(turn), 10 * std::sin(turn), z);
    }
  mesh.positions.emplace_back(0, 0, 0);
  mesh.positions.emplace_back(0, 0, height);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, next, count + next});
    mesh.triangles.push_back({i, count + next, count + i});
    mesh.triangles.push_back({2 * count, next, i});
    mesh.triangles.push_back({2 * count + 1, count + i, count + next});
  }
  return mesh;
}

// The same box, its sides divided into slivers: the same distances, whichever way they are found.
TEST(OddTriangles, SliversGiveTheDistancesOfWhatTheyCover) {
  for (const double size : {30.0, 300.0}) {
    SCOPED_TRACE(size);
    constexpr uint32_t kSide = 700, kRound = 4 * kSide;
    TriangleMesh slivers;
    for (const double z : {0.0, size})
      for (uint32_t i = 0; i < kRound; ++i) {
        const double along = 12.0 * (i % kSide) / kSide;
        const Vec3d corners[4] = {{along, 0, z}, {12, along, z}, {12 - along, 12, z}, {0, 12 - along, z}};
        slivers.positions.push_back(corners[i / kSide] + Vec3d(0.3, 0.2, 0.4));
      }
    slivers.positions.emplace_back(6.3, 6.2, 0.4);
    slivers.positions.emplace_back(6.3, 6.2, size + 0.4);
    for (uint32_t i = 0; i < kRound; ++i) {
      const uint32_t next = (i + 1) % kRound;
      slivers.triangles.push_back({i, next, kRound + next});
      slivers.triangles.push_back({i, kRound + next, kRound + i});
      slivers.triangles.push_back({2 * kRound, next, i});
      slivers.triangles.push_back({2 * kRound + 1, kRound + i, kRound + next});
    }
    const Version fine = import(slivers).version,
                  plain = import(box({0.3, 0.2, 0.4}, {12.3, 12.2, size + 0.4})).version;
    size_t voxels = 0;
    plain.forEachBrick([&](const Brick& brick) {
      const Slot other = fine.find(brick.coord);
      for (int v = 0; v < kBrickVoxels; ++v, ++voxels) ASSERT_NEAR(brick.phi(v), other.phi(v, 3), 1e-4) << v;
    });
    EXPECT_GT(voxels, 10000u);
    EXPECT_EQ(plain.stats().bricks, fine.stats().bricks);
  }
}

// What is wound around more than once is clay once: the difference to the sum over the triangles is not the voxel's.
TEST(OddTriangles, TellsOfTrianglesThatCross) {
  struct Star {
    int n, k;
    double voxel;
  };
  for (const auto& [n, k, voxel] :
       {Star{5, 2, 0.25}, Star{5, 2, 0.1}, Star{7, 2, 0.25}, Star{7, 3, 0.25}, Star{9, 4, 0.2}}) {
    SCOPED_TRACE(fmt::format("{{{}/{}}} at {}", n, k, voxel));
    const Imported made = import(starPrism(n, k, 6), voxel);
    const double inner = 10 * std::cos(M_PI * k / n) / std::cos(M_PI * (k - 1) / n);
    const double outline = n * 10 * inner * std::sin(M_PI / n), sum = n / 2.0 * 100 * std::sin(2 * M_PI * k / n);
    // Each side crosses 2 (k - 1) others, in three pairs of triangles where their diagonals meet the line apart.
    EXPECT_GE(made.report.crossings, uint64_t(2 * n * (k - 1)));
    EXPECT_LE(made.report.crossings, uint64_t(3 * n * (k - 1)));
    if (n == 5) {
      EXPECT_EQ(made.report.crossings, 15u);
    }
    const std::vector<std::string> told = made.report.sentences();
    EXPECT_THAT(told, Not(Contains(HasSubstr("nothing to repair"))));
    EXPECT_THAT(told, Not(Contains(HasSubstr("at this voxel size"))));
    EXPECT_THAT(told, Not(Contains(HasSubstr("% of the volume, "))));
    EXPECT_THAT(told, Contains(HasSubstr(fmt::format("{} pairs of triangles cross", made.report.crossings))));
    double less = 0;
    for (const std::string& sentence : told)
      if (std::smatch found; std::regex_search(sentence, found, std::regex("has ([0-9.]+) % less volume than the tri")))
        less = std::stod(found[1]);
    EXPECT_NEAR(less, 100 * (1 - outline / sum), 0.8);
  }
  // The same prisms without crossings, and two boxes beside each other.
  EXPECT_THAT(import(starPrism(7, 1, 6), 0.25).report.sentences(), Contains(HasSubstr("nothing to repair")));
  TriangleMesh two = box({0, 0, 0}, {10, 10, 10});
  append(two, box({5, 4, 3}, {15, 14, 13}));
  EXPECT_GT(import(two).report.crossings, 5u);
  EXPECT_THAT(import(two).report.sentences(), Contains(HasSubstr("pairs of triangles cross")));
}

}  // namespace
}  // namespace argil::clay
