// Clay of a mesh has the bodies of the mesh: none is added by sampling, and what is lost is told. Random unions of
// primitives, and real files at three voxel sizes.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/tier.h"

namespace argil::clay {
namespace {

constexpr unsigned kSeed = 17;

void add(TriangleMesh& mesh, const std::vector<Vec3d>& corners, const std::vector<std::array<uint32_t, 3>>& triangles) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), corners.begin(), corners.end());
  for (const auto& [a, b, c] : triangles) mesh.triangles.push_back({a + first, b + first, c + first});
}

// Boxes, tetrahedra and double cones of many sides, turned anyhow, some with corners and faces exactly on the voxels.
TriangleMesh randomUnion(std::mt19937& random) {
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() % 100001) / 100000; };
  TriangleMesh mesh;
  const int count = 1 + int(random() % 6);
  for (int i = 0; i < count; ++i) {
    const bool aligned = random() % 3 == 0;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (!aligned)
      turn = Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1) + 1.5)
                 .normalized()
                 .toRotationMatrix();
    Vec3d middle(between(-20, 20), between(-20, 20), between(-20, 20)),
        size(between(4, 16), between(4, 16), between(4, 16));
    if (aligned) middle = middle.array().round(), size = size.array().round();
    std::vector<Vec3d> corners;
    std::vector<std::array<uint32_t, 3>> triangles;
    const unsigned kind = random() % 3;
    if (kind == 0) {
      for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    } else if (kind == 1) {
      corners = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
      triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    } else {
      const uint32_t sides = 3 + random() % 12;
      for (uint32_t k = 0; k < sides; ++k)
        corners.emplace_back(std::cos(2 * M_PI * k / sides), std::sin(2 * M_PI * k / sides), 0);
      corners.emplace_back(0, 0, 1);
      corners.emplace_back(0, 0, -1);
      for (uint32_t k = 0; k < sides; ++k)
        triangles.push_back({k, (k + 1) % sides, sides}), triangles.push_back({(k + 1) % sides, k, sides + 1});
    }
    for (Vec3d& p : corners) p = middle + turn * p.cwiseProduct(size);
    add(mesh, corners, triangles);
  }
  return mesh;
}

struct Bodies {
  uint64_t surfaces = 0;
  double smallest = INFINITY;  // voxels³ of the least of them
};

// Of the surface that a user sees and exports.
Bodies bodiesOf(const Version& version, Grade grade) {
  Surface surface(false, grade);
  surface.update(version, 1);
  const TriangleMesh mesh = surface.toMesh();
  std::vector<uint32_t> parent(mesh.positions.size());
  for (uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) parent[find(a)] = find(b), parent[find(c)] = find(b);
  std::vector<double> volume(parent.size());
  std::vector<bool> used(parent.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const uint32_t root = find(a);
    used[root] = true;
    volume[root] += mesh.positions[a].dot(mesh.positions[b].cross(mesh.positions[c])) / 6;
  }
  Bodies bodies;
  for (size_t i = 0; i < parent.size(); ++i) {
    if (!used[i]) continue;
    ++bodies.surfaces;
    bodies.smallest = std::min(bodies.smallest, std::abs(volume[i]) / std::pow(version.grid().voxelMm, 3));
  }
  return bodies;
}

TEST(MeshBodies, NoneIsAddedToRandomUnions) {
  const int rounds = tests::byTier(30, 1000);
  std::mt19937 random(kSeed);
  uint64_t specks = 0;
  for (int round = 0; round < rounds; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    const TriangleMesh mesh = randomUnion(random);
    ImportOptions options;
    options.grid.voxelMm = 1;
    options.threads = 1;
    const Imported made = meshToClay(Store::make(), mesh, options);
    const MeshLosses& losses = made.report.losses;
    specks += losses.specks;
    for (const Grade grade : {Grade::draft, Grade::fine}) {
      const Bodies bodies = bodiesOf(made.version, grade);
      EXPECT_EQ(bodies.surfaces, losses.bodies + losses.cavities);
      // All primitives have 20 voxels and more: what is much less was added.
      EXPECT_GT(bodies.smallest, 10);
    }
    EXPECT_LE(losses.bodies, made.report.bodies);
  }
  std::printf("%d unions, %lu specks taken out\n", rounds, static_cast<unsigned long>(specks));
}

}  // namespace
}  // namespace argil::clay
