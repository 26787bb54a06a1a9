// Pairs of triangles that cross, counted against the definition and against shapes whose count is known.

#include "clay/mesh/crossing_triangles.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/base/error.h"
#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

using testing::append;
using testing::box;
using testing::icosphere;

void addTriangle(TriangleMesh& mesh, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto first = uint32_t(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

double sixVolumes(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

// In general position two triangles cross exactly where an edge of one runs through the other.
bool pierces(const Vec3d& p, const Vec3d& q, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  if (sixVolumes(a, b, c, p) * sixVolumes(a, b, c, q) >= 0) return false;
  const double one = sixVolumes(p, q, a, b), two = sixVolumes(p, q, b, c), three = sixVolumes(p, q, c, a);
  return (one > 0) == (two > 0) && (two > 0) == (three > 0);
}
uint64_t byDefinition(const TriangleMesh& mesh) {
  uint64_t pairs = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (size_t k = i + 1; k < mesh.triangles.size(); ++k) {
      bool cross = false;
      for (const auto& [own, other] : {std::pair(i, k), std::pair(k, i)}) {
        const auto& s = mesh.triangles[own];
        const auto& t = mesh.triangles[other];
        for (size_t e = 0; e < 3; ++e)
          cross |= pierces(mesh.positions[s[e]], mesh.positions[s[(e + 1) % 3]], mesh.positions[t[0]],
                           mesh.positions[t[1]], mesh.positions[t[2]]);
      }
      pairs += cross;
    }
  }
  return pairs;
}

TEST(CrossingTriangles, RandomTrianglesAgreeWithTheDefinition) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-10, 10), edge(-4, 4);
    TriangleMesh mesh;
    for (int i = 0; i < 400; ++i) {
      const Vec3d middle(place(random), place(random), place(random));
      const auto corner = [&] { return Vec3d(middle + Vec3d(edge(random), edge(random), edge(random))); };
      const Vec3d a = corner(), b = corner(), c = corner();
      addTriangle(mesh, a, b, c);
    }
    const uint64_t right = byDefinition(mesh);
    EXPECT_GT(right, 100u);
    EXPECT_EQ(countCrossings(mesh), right) << "seed " << seed;
  }
}

TEST(CrossingTriangles, ClosedSurfacesDoNotCrossThemselves) {
  EXPECT_EQ(countCrossings({}), 0u);
  EXPECT_EQ(countCrossings(icosphere({1, 2, 3}, 5, 4)), 0u);
  EXPECT_EQ(countCrossings(box({0, 0, 0}, {1, 2, 3})), 0u);
  // Boxes side by side, with a common face, edge or corner.
  for (const Vec3d& at : {Vec3d(1, 0, 0), Vec3d(1, 1, 0), Vec3d(1, 1, 1), Vec3d(1, 0.3, 0.2), Vec3d(5, 0, 0)}) {
    TriangleMesh two = box({0, 0, 0}, {1, 1, 1});
    append(two, box(at, at + Vec3d(1, 1, 1)));
    EXPECT_EQ(countCrossings(two), 0u) << at.transpose();
  }
  // Far away and rounded to 32 bits, as files have it.
  for (const double away : {1e3, 1e5, 1e7}) {
    TriangleMesh far = icosphere({away, -away, away / 3}, 20, 4);
    for (Vec3d& p : far.positions) p = p.cast<float>().cast<double>();
    EXPECT_EQ(countCrossings(far), 0u) << away;
  }
}

TEST(CrossingTriangles, KnownNumbers) {
  // One long triangle through a pile of n.
  for (const int n : {1, 2, 7, 100}) {
    TriangleMesh mesh;
    for (int i = 0; i < n; ++i) addTriangle(mesh, {-5, -5, double(i)}, {5, -5, double(i)}, {0, 5, double(i)});
    addTriangle(mesh, {0.1, 0.2, -1}, {0.3, 0.1, -1}, {0.2, 0.3, n + 1.0});
    EXPECT_EQ(countCrossings(mesh), uint64_t(n));
  }
  // Two with one corner in common, of which one passes through the other, and one that only leaves from there.
  TriangleMesh mesh{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {3, 1, 2}, {1, 3, -2}, {-3, -1, 2}, {-1, -3, -2}}, {}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(countCrossings(mesh), 1u);
  mesh.triangles = {{0, 1, 2}, {0, 5, 6}};
  EXPECT_EQ(countCrossings(mesh), 0u);
  // Three side by side in one plane, and one that stands on an edge.
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 2, 4}, {0, 1, 2}};
  EXPECT_EQ(countCrossings(mesh), 0u);
}

TEST(CrossingTriangles, CountingEndsAndCanBeCancelled) {
  TriangleMesh mesh;
  constexpr int kEach = 1100;
  for (int i = 0; i < kEach; ++i) {
    const double at = 1e-3 * i;
    addTriangle(mesh, {-5, -5, at}, {5, -5, at}, {0, 5, at});
    addTriangle(mesh, {at, 0, -5}, {at, 0.5, -5}, {at, 0.2, 10});
  }
  EXPECT_EQ(countCrossings(mesh), kMostCrossings) << kEach * kEach;
  Job job;
  job.cancel();
  EXPECT_THROW((void)countCrossings(mesh, &job), Cancelled);
}

}  // namespace
}  // namespace argil::clay
