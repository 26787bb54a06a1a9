// The surface is a closed 2-manifold whatever the signs, and following edits gives what extracting anew gives.

#include "clay/surface/surface.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <random>

#include "clay/field/primitives.h"
#include "clay/kernels/cell_cases.h"
#include "clay/kernels/surface_kernels.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "tests/support/simd_targets.h"
#include "tests/support/tier.h"

namespace argil::clay {
namespace {

// Voxels of a small box around a corner where eight bricks meet, so that every crossing of brick borders happens; all
// else is a tile.
struct Box {
  Coord first, size;
  std::vector<float> phi;  // x, y, z order
  float surround;          // ±3

  [[nodiscard]] float at(Coord v) const {
    const Coord l = v - first;
    if (l.x < 0 || l.y < 0 || l.z < 0 || l.x >= size.x || l.y >= size.y || l.z >= size.z) return surround;
    return phi[static_cast<size_t>((l.x * size.y + l.y) * size.z + l.z)];
  }
};

Version versionOf(const std::shared_ptr<Store>& store, const Box& box) {
  Editor editor(Version::empty(store, Grid{}));
  if (box.surround < 0) editor.setBlock({0, 0, 0}, kTreeLevels, Tile::inside);
  const Coord last = box.first + box.size - Coord{1, 1, 1};
  for (int x = box.first.x >> 3; x <= last.x >> 3; ++x)
    for (int y = box.first.y >> 3; y <= last.y >> 3; ++y)
      for (int z = box.first.z >> 3; z <= last.z >> 3; ++z) {
        std::array<float, kBrickVoxels> phi;
        for (int i = 0; i < kBrickVoxels; ++i)
          phi[static_cast<size_t>(i)] = box.at(Coord{8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7)});
        editor.setVoxels({x, y, z}, phi);
      }
  return editor.commit();
}

TopologyReport topologyOf(const Version& version) {
  Surface surface;
  surface.update(version);
  const TriangleMesh mesh = surface.toMesh();
  if (mesh.triangles.empty()) return {};
  return checkTopology(mesh);
}

TEST(CellCases, LoopsCoverTheCrossedEdgesAndFoldedFacesUnfold) {
  int folded = 0;
  for (unsigned p = 0; p < 256; ++p) {
    const CellCase& c = cellCases().separated[p];
    uint16_t crossed = 0;
    for (size_t e = 0; e < 12; ++e)
      if (((p >> kCellEdges[e].from) & 1) != ((p >> kCellEdges[e].to) & 1))
        crossed = static_cast<uint16_t>(crossed | 1 << e);
    EXPECT_EQ(c.edges, crossed);
    EXPECT_EQ(c.loops == 0, p == 0 || p == 255);
    int perLoop[4] = {};
    for (int e = 0; e < 12; ++e)
      if (crossed >> e & 1) ++perLoop[c.loopOfEdge[e]];
    for (int i = 0; i < c.loops; ++i) EXPECT_GE(perLoop[i], 3);
    if (c.foldedFace >= 0) {
      ++folded;
      EXPECT_EQ(cellCases().joined[p].foldedFace, -1) << p;
      EXPECT_EQ(cellCases().joined[p].loops, 2) << p;
    }
  }
  EXPECT_EQ(folded, 36);
}

// Every pattern beside every pattern that can share a face with it, along each axis, both surrounds, and at every place
// of a brick border: 4 096 × 3 × 2 fields.
TEST(Surface, ClosedForEveryPatternWithEveryNeighbour) {
  const auto store = Store::make();
  for (int axis = 0; axis < 3; ++axis)
    for (const float surround : {3.0f, -3.0f})
      for (unsigned signs = 0; signs < 4096; ++signs) {
        Box box;
        box.size = {2, 2, 2};
        (axis == 0 ? box.size.x : axis == 1 ? box.size.y : box.size.z) = 3;
        // Wanders over the border so that the shared face lies before, on and behind it.
        const int shift = static_cast<int>(signs % 4);
        box.first = {7 - (shift & 1), 7 - (shift >> 1), 7 - ((shift ^ axis) & 1)};
        box.surround = surround;
        for (int i = 0; i < 12; ++i) box.phi.push_back((signs >> i) & 1 ? -1.0f : 1.0f);
        const Version version = versionOf(store, box);
        const TopologyReport report = topologyOf(version);
        if (report.triangles == 0) {
          ASSERT_TRUE((surround > 0 && signs == 0) || (surround < 0 && signs == 4095)) << axis << ' ' << signs;
          continue;
        }
        ASSERT_TRUE(report.closed()) << "axis " << axis << " signs " << signs << " surround " << surround
                                     << " non-manifold edges " << report.nonManifoldEdges << " vertices "
                                     << report.nonManifoldVertices << " boundary " << report.boundaryEdges;
        ASSERT_EQ(report.volume > 0, surround > 0);
        store->collect();
      }
}

TEST(Surface, ClosedForRandomSignFields) {
  const uint64_t seed = 4711;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  std::uniform_real_distribution<float> value(0.01f, 2.9f);
  for (int field = 0; field < tests::byTier(5000, 10000); ++field) {
    Box box;
    box.first = {static_cast<int>(random() % 6) + 2, static_cast<int>(random() % 6) + 2,
                 static_cast<int>(random() % 6) + 2};
    box.size = {6, 6, 6};
    box.surround = random() % 2 ? 3.0f : -3.0f;
    const uint64_t density = 1 + random() % 7;  // of eight
    for (int i = 0; i < 6 * 6 * 6; ++i) {
      const float v = random() % 16 == 0 ? 0.0f : value(random);
      box.phi.push_back(random() % 8 < density ? -v : v);
    }
    const TopologyReport report = topologyOf(versionOf(store, box));
    ASSERT_TRUE(report.closed()) << "seed " << seed << " field " << field << ": non-manifold edges "
                                 << report.nonManifoldEdges << " vertices " << report.nonManifoldVertices
                                 << " boundary " << report.boundaryEdges << " flipped " << report.flippedEdges;
    store->collect();
  }
}

// Noise that changes from one version to the next in random bricks: the folded faces and several loops of the hard
// cases appear and vanish beside borders. (One kind of tile alone: an inside tile beside an outside one is no field of
// distances.)
TEST(Surface, FollowingRandomFieldsEqualsExtractingAnew) {
  const uint64_t seed = 99;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  Version version = Version::empty(store, Grid{});
  Surface following;
  following.update(version);
  std::map<Coord, BrickMeshPtr> known;
  int quadsAlone = 0;
  for (int step = 0; step < 300; ++step) {
    Editor editor(version);
    const int edits = 1 + static_cast<int>(random() % 4);
    for (int e = 0; e < edits; ++e) {
      const Coord c{static_cast<int>(random() % 4) - 2, static_cast<int>(random() % 4) - 2,
                    static_cast<int>(random() % 4) - 2};
      if (random() % 5 == 0) {
        editor.setTile(c, Tile::outside);
        continue;
      }
      std::array<float, kBrickVoxels> phi;
      const Slot old = editor.find(c);
      for (int i = 0; i < kBrickVoxels; ++i) phi[static_cast<size_t>(i)] = old.phi(i, 3);
      // A few voxels, so that most of a brick's neighbours keep their numbering.
      for (int k = 0; k < 20; ++k) phi[random() % kBrickVoxels] = static_cast<float>(random() % 200) / 100.0f - 1.0f;
      editor.setVoxels(c, phi);
    }
    version = editor.commit();
    const SurfaceDelta delta = following.update(version);
    for (size_t i = 1; i < delta.changed.size(); ++i) ASSERT_NE(delta.changed[i - 1]->brick, delta.changed[i]->brick);
    for (const BrickMeshPtr& mesh : delta.changed) {
      BrickMeshPtr& before = known[mesh->brick];
      if (before) {
        ASSERT_NE(before->serial, mesh->serial);
      }
      if (before && before->vertexSerial == mesh->vertexSerial) {
        ++quadsAlone;
        ASSERT_TRUE(std::equal(before->positions.begin(), before->positions.end(), mesh->positions.begin(),
                               mesh->positions.end()));
        ASSERT_TRUE(
            std::equal(before->normals.begin(), before->normals.end(), mesh->normals.begin(), mesh->normals.end()));
      }
      before = mesh;
    }
    Surface anew;
    anew.update(version, 1 + step % 2);
    ASSERT_EQ(following.hash(), anew.hash()) << "seed " << seed << " step " << step;
    ASSERT_EQ(following.vertexCount(), anew.vertexCount());
    ASSERT_EQ(following.quadCount(), anew.quadCount());
    store->collect();
  }
  EXPECT_GT(quadsAlone, 100);
}

// A second model in the same surface: what stood where nothing stands now is reported as gone.
TEST(Surface, AnotherModelReplacesTheFirst) {
  std::map<Coord, BrickMeshPtr> listener;
  Surface surface;
  for (const double radius : {30.0, 12.0, 40.0}) {
    const Version version = makeSphere(Store::make(), Grid{}, Vec3d(radius, 0, 0), radius);
    for (const BrickMeshPtr& mesh : surface.update(version, 2).changed) {
      if (mesh->positions.empty())
        listener.erase(mesh->brick);
      else
        listener[mesh->brick] = mesh;
    }
    Surface anew;
    anew.update(version);
    EXPECT_EQ(surface.hash(), anew.hash());
    EXPECT_EQ(surface.vertexCount(), anew.vertexCount());
    size_t count = 0;
    anew.forEach([&](const BrickMesh& mesh) { count += listener.contains(mesh.brick); });
    EXPECT_EQ(count, listener.size());
  }
}

TEST(SurfaceKernels, DifferingVoxelsOnEverySimdTarget) {
  std::mt19937_64 random(17);
  std::array<float, kBrickVoxels> a, b;
  for (float& v : a) v = static_cast<float>(random() % 600) / 100 - 3;
  b = a;
  for (int i = 0; i < 100; ++i) b[random() % kBrickVoxels] += 0.01f;
  tests::forEachSimdTarget([&](const std::string& name) {
    uint64_t found[8];
    differingVoxels(a.data(), b.data(), found);
    for (size_t i = 0; i < kBrickVoxels; ++i)
      ASSERT_EQ(found[i >> 6] >> (i & 63) & 1, a[i] != b[i]) << name << ' ' << i;
  });
}

// What a listener builds from the deltas alone is the surface.
TEST(Surface, DeltasAddUpToTheSurface) {
  const auto store = Store::make();
  std::mt19937_64 random(5);
  std::map<Coord, BrickMeshPtr> listener;
  Version version = makeSphere(store, Grid{}, Vec3d::Zero(), 12);
  Surface surface;
  for (int step = 0; step < 30; ++step) {
    for (const BrickMeshPtr& mesh : surface.update(version).changed) {
      if (mesh->positions.empty())
        listener.erase(mesh->brick);
      else
        listener[mesh->brick] = mesh;
    }
    size_t count = 0;
    surface.forEach([&](const BrickMesh& mesh) {
      ++count;
      ASSERT_TRUE(listener.contains(mesh.brick));
      ASSERT_EQ(listener[mesh.brick]->serial, mesh.serial);
    });
    ASSERT_EQ(count, listener.size());
    Editor editor(version);
    editor.setTile(
        {static_cast<int>(random() % 8) - 4, static_cast<int>(random() % 8) - 4, static_cast<int>(random() % 8) - 4},
        random() % 2 ? Tile::inside : Tile::outside);
    version = editor.commit();
  }
}

TEST(Surface, EqualBitsOnEverySimdTargetAndThreadCount) {
  const Version version = makeSphere(Store::make(), Grid{}, Vec3d(0.1, 0.2, 0.3), 30);
  Surface reference;
  reference.update(version);
  int targets = 0;
  tests::forEachSimdTarget([&](const std::string& name) {
    ++targets;
    for (const int threads : {1, 2, 4}) {
      Surface surface;
      surface.update(version, threads);
      EXPECT_EQ(surface.hash(), reference.hash()) << name << ' ' << threads;
    }
  });
  EXPECT_GE(targets, 1);
  RecordProperty("simd_targets", targets);
}

struct Placement {
  double voxelMm;
  Vec3d originMm;
};

// Root mean square distance from the sphere, in voxels, over vertices and over points spread on the faces.
double sphereError(const Placement& p, double radiusVoxels, const Vec3d& centreVoxels) {
  Grid grid;
  grid.voxelMm = p.voxelMm;
  grid.originMm = p.originMm;
  const Vec3d centre = grid.toWorld(centreVoxels);
  Surface surface;
  surface.update(makeSphere(Store::make(), grid, centre, radiusVoxels * p.voxelMm));
  const TriangleMesh mesh = surface.toMesh();
  EXPECT_TRUE(checkTopology(mesh).closed());
  double sum = 0;
  size_t n = 0;
  const auto add = [&](const Vec3d& at) {
    const double error = (at - centre).norm() / p.voxelMm - radiusVoxels;
    sum += error * error;
    ++n;
  };
  for (const Vec3d& v : mesh.positions) add(v);
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    add((a + b + c) / 3);
    add((a + b) / 2);
    add(0.6 * a + 0.2 * b + 0.2 * c);
  }
  return std::sqrt(sum / static_cast<double>(n));
}

TEST(Surface, SphereErrorAndItsOrder) {
  const Vec3d centre(0.31, -0.17, 0.43);
  const double coarse = sphereError({0.5, Vec3d::Zero()}, 80, centre),
               fine = sphereError({0.25, Vec3d::Zero()}, 160, centre);
  std::printf("sphere r = 40 mm: %.5f voxel RMS at 0.5 mm, %.5f at 0.25 mm: %.5f and %.5f mm, order %.2f\n", coarse,
              fine, coarse * 0.5, fine * 0.25, std::log2(coarse * 0.5 / (fine * 0.25)));
  EXPECT_LE(coarse, 0.01);
  // Second order in mm: a quarter of the error at half the voxel.
  EXPECT_NEAR(std::log2(coarse * 0.5 / (fine * 0.25)), 2.0, 0.1);
}

TEST(Surface, ErrorInVoxelsDoesNotDependOnPlaceOrSize) {
  const Vec3d centre(0.31, -0.17, 0.43);
  const double here = sphereError({0.5, Vec3d::Zero()}, 80, centre);
  const Placement places[] = {{0.5, Vec3d(1e6, -1e6, 1e6)},
                              {1e-3, Vec3d::Zero()},
                              {1e3, Vec3d::Zero()},
                              {1e-3, Vec3d(1e6, 1e6, -1e6)},
                              {1e3, Vec3d(-1e6, 1e6, 1e6)}};
  for (const Placement& p : places) {
    const double there = sphereError(p, 80, centre);
    std::printf("voxel %g mm, origin %g mm: %.6f voxel RMS (%.6f at zero)\n", p.voxelMm, p.originMm.x(), there, here);
    // At 1 µm voxels and 10⁶ mm a double resolves 1.2e-7 voxel.
    EXPECT_NEAR(there, here, 1e-5);
  }
}

TEST(PackedNormal, IsWithinSixThousandthsOfADegreeAndOnNoCrease) {
  std::mt19937_64 random(8);
  std::normal_distribution<float> normal;
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    Vec3f n(normal(random), normal(random), normal(random));
    // Along the axes as well: there the numbers are at their ends.
    if (i < 27)
      n = Vec3f(static_cast<float>(i / 9 - 1), static_cast<float>(i / 3 % 3 - 1), static_cast<float>(i % 3 - 1));
    if (i == 13) continue;
    n.normalize();
    const PackedNormal packed = PackedNormal::pack(n);
    ASSERT_EQ(packed.v % 2, 0) << n.transpose();
    ASSERT_GT(packed.u, -32768) << n.transpose();
    ASSERT_GT(packed.v, -32768) << n.transpose();
    worst = std::max(worst, static_cast<double>((n - packed.unpack()).norm()));
  }
  EXPECT_LT(worst * 180 / M_PI, 0.006);
}

}  // namespace
}  // namespace argil::clay
