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

}  // namespace
}  // namespace argil::clay
