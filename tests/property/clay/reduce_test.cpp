// Sculpted clay, thin walls, bodies that nearly touch: whatever is asked for, the reduced surface is closed and the
// same bodies.

#include "clay/mesh/reduce.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/edge_collapse.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/tier.h"
#include "tests/unit/clay/brute_distance.h"

namespace argil::clay {
namespace {

/// A ball after random strokes; `noisy`: every voxel near the surface moved at random, which makes crumbs, pinholes and
/// threads.
TriangleMesh sculpted(uint64_t seed, bool noisy) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Version version = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 11);
  for (int i = 0; i < 30; ++i) {
    const Vec3d a = Vec3d(u(random), u(random), u(random)).normalized() * (7 + 5 * u(random));
    // Cuts through the whole leave walls and bodies.
    BrushStroke stroke(version, Brush::of(i % 5 ? Method::carve : Method::add));
    stroke.apply({a, i % 3 ? a : Vec3d(-a), 1 + 1.2 * (u(random) + 1)});
    version = stroke.finish();
  }
  if (noisy) {
    Editor editor(version);
    version.forEachBrick([&](const Brick& brick) {
      std::array<float, kBrickVoxels> phi;
      for (int i = 0; i < kBrickVoxels; ++i)
        phi[static_cast<size_t>(i)] = brick.phi(static_cast<size_t>(i)) + static_cast<float>(0.8 * u(random));
      editor.setVoxels(brick.coord, phi);
    });
    version = editor.commit();
  }
  Surface surface(false);
  surface.update(version);
  return surface.toMesh();
}

/// Euler numbers of the bodies, sorted.
std::vector<long> eulers(const TriangleMesh& mesh) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b, c] : mesh.triangles) parent[root(a)] = root(b), parent[root(b)] = root(c);
  std::map<uint32_t, long> twice;
  for (uint32_t v = 0; v < parent.size(); ++v) twice[root(v)] += 2;
  for (const auto& t : mesh.triangles) twice[root(t[0])] -= 1;
  std::vector<long> result;
  for (const auto& [body, number] : twice) result.push_back(number / 2);
  std::sort(result.begin(), result.end());
  return result;
}

void expectSame(const TriangleMesh& original, const TriangleMesh& reduced, const std::string& what) {
  const TopologyReport report = checkTopology(reduced);
  EXPECT_TRUE(report.closed()) << what << ": non-manifold edges " << report.nonManifoldEdges << " vertices "
                               << report.nonManifoldVertices << " boundary " << report.boundaryEdges << " degenerate "
                               << report.degenerateTriangles;
  EXPECT_EQ(eulers(reduced), eulers(original)) << what;
}

TEST(Reduce, SculptedClayStaysClosedWithItsBodiesAndHoles) {
  uint64_t bodies = 0;
  long holes = 0;
  for (const bool noisy : {false, true})
    for (uint64_t seed = 1; seed <= tests::byTier<uint64_t>(2, 3); ++seed) {
      const TriangleMesh mesh = sculpted(seed, noisy);
      const TopologyReport before = checkTopology(mesh);
      ASSERT_TRUE(before.closed());
      bodies += before.bodies;
      holes += static_cast<long>(before.bodies) -
               (static_cast<long>(before.vertices) - static_cast<long>(before.triangles / 2)) / 2;
      const auto watch = [](uint64_t) {};
      EdgeCollapse farthest(mesh, {}, watch);
      farthest.run(0, watch);
      for (const uint64_t target : {mesh.triangles.size() / 10, mesh.triangles.size() / 100, size_t{0}}) {
        const std::string what =
            "seed " + std::to_string(seed) + (noisy ? " noisy" : "") + " to " + std::to_string(target);
        if (target < farthest.triangles()) {
          // As far as it goes.
          expectSame(mesh, farthest.result(), what);
          EXPECT_LT(farthest.triangles(), mesh.triangles.size() / 10) << what;
          break;
        }
        const Reduced reduced = reduce(mesh, {target, {}});
        EXPECT_LE(reduced.mesh.triangles.size(), target) << what;
        expectSame(mesh, reduced.mesh, what);
        const double volume = checkTopology(reduced.mesh).volume;
        EXPECT_NEAR(volume, before.volume,
                    (0.002 + reduced.deviation.rmsMm * before.area / before.volume) * before.volume)
            << what;
      }
    }
  std::printf("seeds 1 to 3, smooth and noisy: %llu bodies with %ld holes\n", static_cast<unsigned long long>(bodies),
              holes);
  EXPECT_GT(bodies, 50u);
  EXPECT_GT(holes, 10);
}

TEST(Reduce, AnErrorAskedForIsKept) {
  for (const bool noisy : {false, true})
    for (uint64_t seed = 11; seed <= 11; ++seed) {
      const TriangleMesh mesh = sculpted(seed, noisy);
      const double mm = noisy ? 0.4 : 0.1;
      const Reduced reduced = reduce(mesh, {{}, mm});
      const std::string what = "seed " + std::to_string(seed) + (noisy ? " noisy" : "");
      expectSame(mesh, reduced.mesh, what);
      EXPECT_LE(reduced.deviation.most(), mm) << what;
      // The promise is about the places that are measured; random ones may lie a little farther.
      std::mt19937_64 random(seed);
      for (const auto& [from, to] : {std::pair(&mesh, &reduced.mesh), std::pair(&reduced.mesh, &mesh)})
        for (int i = 0; i < 150; ++i) {
          const auto& [a, b, c] = from->triangles[random() % from->triangles.size()];
          std::uniform_real_distribution<double> u(0, 1);
          const double s = std::sqrt(u(random)), t = u(random);
          const Vec3d p = from->positions[a] * (1 - s) + s * (from->positions[b] * (1 - t) + from->positions[c] * t);
          EXPECT_LE(std::sqrt(testing::bruteSquared(p, *to)), 1.05 * mm) << what;
        }
      EXPECT_LT(reduced.mesh.triangles.size(), mesh.triangles.size() / 2) << what;
      std::printf("%s: %zu to %zu triangles within %.3f of %.3f mm\n", what.c_str(), mesh.triangles.size(),
                  reduced.mesh.triangles.size(), reduced.deviation.most(), mm);
    }
}

}  // namespace
}  // namespace argil::clay
