#include "clay/mesh/weld.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "clay/mesh/mesh_topology.h"
#include "tests/support/mesh_samples.h"

namespace argil::clay {
namespace {

TriangleMesh soupOf(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    const auto base = uint32_t(soup.positions.size());
    for (const uint32_t v : t) soup.positions.push_back(mesh.positions[v]);
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  return soup;
}

TEST(Weld, SoupOfACubeIsClosedAgain) {
  const TriangleMesh soup = soupOf(samples::cube());
  EXPECT_EQ(checkTopology(soup).boundaryEdges, 36u);
  const TriangleMesh welded = weldExact(soup);
  EXPECT_EQ(welded.positions.size(), 8u);
  EXPECT_TRUE(checkTopology(welded).closed());
  for (size_t t = 0; t < soup.triangles.size(); ++t) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(welded.positions[welded.triangles[t][c]], soup.positions[soup.triangles[t][c]]);
    }
  }
}

TEST(Weld, ZeroEqualsMinusZeroAndNothingElse) {
  VertexWelder welder;
  EXPECT_EQ(welder.add({0.0, 1, 2}), 0u);
  EXPECT_EQ(welder.add({-0.0, 1, 2}), 0u);
  EXPECT_EQ(welder.add({5e-324, 1, 2}), 1u);
  EXPECT_EQ(welder.add({1, 0.0, 2}), 2u);
  EXPECT_EQ(welder.add({0.0, 2, 1}), 3u);
}

TEST(Weld, NumbersInOrderOfFirstAppearanceThroughEveryGrowth) {
  VertexWelder welder;
  std::map<std::tuple<double, double, double>, uint32_t> expected;
  uint64_t state = 12345;
  for (int i = 0; i < 60000; ++i) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    const Vec3d p(double(state >> 61), double((state >> 40) & 63), double((state >> 50) & 63));
    const auto next = uint32_t(expected.size());
    const auto [at, isNew] = expected.try_emplace({p.x(), p.y(), p.z()}, next);
    ASSERT_EQ(welder.add(p), at->second) << i;
  }
  EXPECT_GT(expected.size(), 10000u);
  EXPECT_EQ(welder.positions().size(), expected.size());
  EXPECT_EQ(welder.take().size(), expected.size());
  EXPECT_EQ(welder.add({1, 2, 3}), 0u);
}

TEST(Weld, KeepsTrianglesThatCollapseAndDropsUnusedVertices) {
  TriangleMesh mesh;
  mesh.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  mesh.triangles = {{1, 2, 3}};
  const TriangleMesh welded = weldExact(mesh);
  EXPECT_EQ(welded.positions.size(), 2u);
  ASSERT_EQ(welded.triangles.size(), 1u);
  EXPECT_EQ(checkTopology(welded).degenerateTriangles, 1u);
}

// Two cubes that touch in a face, by the same eight corners twice: closed as they are given, and as a soup.
TEST(Weld, WhatIsClosedByItsIndicesIsNotPinched) {
  const TriangleMesh cube = samples::cube();
  TriangleMesh two = cube;
  const double width = std::abs(cube.positions[0].x() - cube.positions.back().x());
  ASSERT_GT(width, 0);
  for (const Vec3d& p : cube.positions) two.positions.push_back(p + Vec3d(width, 0, 0));
  for (auto t : cube.triangles) {
    for (uint32_t& v : t) v += 8;
    two.triangles.push_back(t);
  }
  const TriangleMesh kept = weldOpenEdges(two);
  EXPECT_EQ(kept.positions.size(), 16u);
  EXPECT_TRUE(checkTopology(kept).closed());
  EXPECT_EQ(checkTopology(kept).bodies, 2u);
  EXPECT_FALSE(checkTopology(weldExact(two)).closed());

  // One of them is a soup: its corners find each other, and not those of the other.
  TriangleMesh mixed = soupOf(cube);
  const auto before = uint32_t(mixed.positions.size());
  mixed.positions.insert(mixed.positions.end(), two.positions.begin() + 8, two.positions.end());
  for (size_t t = cube.triangles.size(); t < two.triangles.size(); ++t)
    mixed.triangles.push_back(
        {two.triangles[t][0] - 8 + before, two.triangles[t][1] - 8 + before, two.triangles[t][2] - 8 + before});
  const TriangleMesh joined = weldOpenEdges(mixed);
  EXPECT_EQ(joined.positions.size(), 16u);
  EXPECT_TRUE(checkTopology(joined).closed());
  for (size_t t = 0; t < mixed.triangles.size(); ++t)
    for (size_t c = 0; c < 3; ++c)
      EXPECT_EQ(joined.positions[joined.triangles[t][c]], mixed.positions[mixed.triangles[t][c]]);
}

TEST(Weld, OpenEdgesAreWeldedAsAllAreAndInTheSameOrder) {
  for (const TriangleMesh& mesh : {soupOf(samples::cube()), soupOf(samples::cube(3, {1, 2, 3})), samples::cube()}) {
    const TriangleMesh open = weldOpenEdges(mesh), all = weldExact(mesh);
    EXPECT_EQ(open.positions, all.positions);
    EXPECT_EQ(open.triangles, all.triangles);
  }
}

// A vertex that only a triangle without area names, unused ones, and a triangle whose edges nothing else has.
TEST(Weld, TrianglesWithARepeatedCornerCloseNothing) {
  TriangleMesh mesh = samples::cube();
  const auto [a, b, c] = mesh.triangles[0];
  mesh.positions.push_back({9, 9, 9});
  mesh.triangles.erase(mesh.triangles.begin());
  mesh.triangles.push_back({a, a, b});
  mesh.triangles.push_back({c, c, c});
  // What closes it lies on its own corners.
  for (const uint32_t v : {a, b, c}) mesh.positions.push_back(Vec3d(mesh.positions[v]));
  mesh.triangles.push_back({9, 10, 11});
  const TriangleMesh welded = weldOpenEdges(mesh);
  EXPECT_EQ(welded.positions.size(), 8u);
  EXPECT_TRUE(checkTopology(welded).solid());
}

}  // namespace
}  // namespace argil::clay
