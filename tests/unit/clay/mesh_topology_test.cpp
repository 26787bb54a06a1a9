#include "clay/mesh/mesh_topology.h"

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface_topology.h"
#include "clay/whole/boolean.h"
#include "tests/support/mesh_samples.h"

namespace argil::clay {
namespace {

void add(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto base = uint32_t(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + base, b + base, c + base});
}

/// Names vertex `from` instead of `to` everywhere.
void merge(TriangleMesh& mesh, uint32_t to, uint32_t from) {
  for (auto& triangle : mesh.triangles) {
    for (auto& v : triangle) v = v == to ? from : v;
  }
}

TEST(MeshTopology, CubeIsClosed) {
  const TopologyReport report = checkTopology(samples::cube(1.5, {10, 20, 30}));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.triangles, 12u);
  EXPECT_EQ(report.vertices, 8u);
  EXPECT_EQ(report.bodies, 1u);
  EXPECT_DOUBLE_EQ(report.volume, 27);
  EXPECT_DOUBLE_EQ(report.area, 54);
  EXPECT_EQ(report.low, Vec3d(8.5, 18.5, 28.5));
  EXPECT_EQ(report.high, Vec3d(11.5, 21.5, 31.5));
}

TEST(MeshTopology, VolumeKeepsItsDigitsFarFromTheOrigin) {
  const TopologyReport report = checkTopology(samples::cube(0.5, {1e6, -1e6, 1e6}));
  EXPECT_NEAR(report.volume, 1, 1e-9);
}

TEST(MeshTopology, InsideOutIsClosedWithNegativeVolume) {
  TriangleMesh mesh = samples::cube();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  const TopologyReport report = checkTopology(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_DOUBLE_EQ(report.volume, -8);
}

TEST(MeshTopology, MissingTriangleLeavesABoundary) {
  TriangleMesh mesh = samples::cube();
  mesh.triangles.pop_back();
  const TopologyReport report = checkTopology(mesh);
  EXPECT_FALSE(report.closed());
  EXPECT_EQ(report.boundaryEdges, 3u);
  EXPECT_EQ(report.boundaryVertices, 3u);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.nonManifoldVertices, 0u);
  EXPECT_EQ(report.flippedEdges, 0u);
}

TEST(MeshTopology, FlippedTriangleDisagreesAlongItsEdges) {
  TriangleMesh mesh = samples::cube();
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  const TopologyReport report = checkTopology(mesh);
  EXPECT_FALSE(report.closed());
  EXPECT_EQ(report.flippedEdges, 3u);
  EXPECT_EQ(report.boundaryEdges, 0u);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.nonManifoldVertices, 0u);
}

TEST(MeshTopology, FinOnAnEdgeIsNonManifold) {
  TriangleMesh mesh = samples::cube();
  mesh.positions.push_back({3, 3, 3});
  mesh.triangles.push_back({0, 1, 8});
  const TopologyReport report = checkTopology(mesh);
  EXPECT_FALSE(report.closed());
  EXPECT_EQ(report.nonManifoldEdges, 1u);
  EXPECT_EQ(report.boundaryEdges, 2u);
  EXPECT_EQ(report.nonManifoldVertices, 2u);
  EXPECT_EQ(report.boundaryVertices, 1u);
}

TEST(MeshTopology, DuplicateTriangleIsNonManifold) {
  TriangleMesh mesh = samples::cube();
  mesh.triangles.push_back(mesh.triangles[0]);
  const TopologyReport report = checkTopology(mesh);
  EXPECT_EQ(report.nonManifoldEdges, 3u);
  EXPECT_EQ(report.nonManifoldVertices, 3u);
}

TEST(MeshTopology, BodiesThatShareAVertexHaveTwoFansThere) {
  TriangleMesh mesh = samples::cube();
  add(mesh, samples::cube(1, {2, 2, 2}));
  EXPECT_TRUE(checkTopology(mesh).closed());
  EXPECT_EQ(checkTopology(mesh).bodies, 2u);
  merge(mesh, 8, 7);  // The corner (1, 1, 1) of both.
  const TopologyReport report = checkTopology(mesh);
  EXPECT_FALSE(report.closed());
  EXPECT_EQ(report.nonManifoldVertices, 1u);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.boundaryVertices, 0u);
  EXPECT_EQ(report.vertices, 15u);
  EXPECT_EQ(report.bodies, 1u);
}

TEST(MeshTopology, BodiesThatShareAnEdgeAreNonManifoldThere) {
  TriangleMesh mesh = samples::cube();
  add(mesh, samples::cube(1, {2, 2, 0}));
  merge(mesh, 8, 3);   // (1, 1, -1)
  merge(mesh, 12, 7);  // (1, 1, 1)
  const TopologyReport report = checkTopology(mesh);
  EXPECT_EQ(report.nonManifoldEdges, 1u);
  EXPECT_EQ(report.nonManifoldVertices, 2u);
  EXPECT_FALSE(report.closed());
}

TEST(MeshTopology, TwoOpenFansAtAVertexAreNonManifold) {
  TriangleMesh mesh;
  mesh.positions.assign(5, Vec3d::Zero());
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const TopologyReport report = checkTopology(mesh);
  EXPECT_EQ(report.boundaryEdges, 6u);
  EXPECT_EQ(report.nonManifoldVertices, 1u);
  EXPECT_EQ(report.boundaryVertices, 4u);
}

TEST(MeshTopology, DegenerateTrianglesAreCountedAndLeftOut) {
  TriangleMesh mesh = samples::cube();
  mesh.triangles.push_back({1, 1, 2});
  mesh.triangles.push_back({4, 4, 4});
  const TopologyReport report = checkTopology(mesh);
  EXPECT_EQ(report.triangles, 14u);
  EXPECT_EQ(report.degenerateTriangles, 2u);
  EXPECT_EQ(report.boundaryEdges, 0u);
  EXPECT_EQ(report.nonManifoldEdges, 0u);
  EXPECT_EQ(report.nonManifoldVertices, 0u);
  EXPECT_FALSE(report.closed());
}

TEST(MeshTopology, UnusedVerticesDoNotCount) {
  TriangleMesh mesh = samples::cube();
  mesh.positions.push_back({100, 100, 100});
  const TopologyReport report = checkTopology(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.vertices, 8u);
  EXPECT_EQ(report.bodies, 1u);
  EXPECT_EQ(report.high, Vec3d(1, 1, 1));
}

TEST(MeshTopology, EmptyMeshIsNotClosed) {
  const TopologyReport report = checkTopology({});
  EXPECT_FALSE(report.closed());
  EXPECT_EQ(report.bodies, 0u);
  EXPECT_EQ(report.low, Vec3d::Zero());
}

TEST(MeshTopology, IndexOutOfRangeIsAnError) {
  TriangleMesh mesh = samples::cube();
  mesh.triangles[3][1] = 8;
  EXPECT_NE(samples::errorOf([&] { (void)checkTopology(mesh); }).find("vertex 8"), std::string::npos);
}

TEST(MeshTopology, FanOfManyTrianglesIsFast) {
  // A vertex with 300 000 neighbours: anything quadratic in the fan would not end.
  constexpr uint32_t kRim = 300000;
  TriangleMesh mesh;
  mesh.positions.push_back({0, 0, 1});
  mesh.positions.push_back({0, 0, -1});
  for (uint32_t i = 0; i < kRim; ++i) {
    const double angle = 2 * M_PI * i / kRim;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
  }
  for (uint32_t i = 0; i < kRim; ++i) {
    const uint32_t a = 2 + i, b = 2 + (i + 1) % kRim;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  const TopologyReport report = checkTopology(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, 2 * M_PI / 3, 1e-9);
}

bool same(const TopologyReport& a, const TopologyReport& b) {
  return a.triangles == b.triangles && a.vertices == b.vertices && a.degenerateTriangles == b.degenerateTriangles &&
         a.boundaryEdges == b.boundaryEdges && a.nonManifoldEdges == b.nonManifoldEdges &&
         a.flippedEdges == b.flippedEdges && a.boundaryVertices == b.boundaryVertices &&
         a.nonManifoldVertices == b.nonManifoldVertices && a.bodies == b.bodies && a.volume == b.volume &&
         a.area == b.area && a.low == b.low && a.high == b.high;
}

// Two balls over many slabs, whole and damaged in every way: piece by piece the report is that of the whole.
TEST(MeshTopology, PieceByPieceIsAsTheWhole) {
  Grid grid;
  grid.voxelMm = 0.5;
  const Version two = combine(makeSphere(Store::make(), grid, {0, 0, 0}, 60),
                              makeSphere(Store::make(), grid, {130, 20, 0}, 50), Combination::join);
  Surface surface;
  surface.update(two);
  EXPECT_TRUE(same(surfaceTopology(surface), checkTopology(surface.toMesh())));
  const Eigen::AngleAxisd turn(0.7, Vec3d(1, 2, 3).normalized());
  TriangleMesh turned = surface.toMesh();
  for (Vec3d& p : turned.positions) p = turn * p;
  EXPECT_TRUE(same(surfaceTopology(surface, [&](const Vec3d& p) { return turn * p; }), checkTopology(turned)));

  enum class Damage { missing, flipped, doubled, degenerate, pinched };
  for (const Damage damage : {Damage::missing, Damage::flipped, Damage::doubled, Damage::degenerate, Damage::pinched}) {
    std::vector<SurfaceSlab> slabs;
    surface.forEachSlab(SlabOf::both, [&](const SurfaceSlab& slab) { slabs.push_back(slab); });
    ASSERT_GT(slabs.size(), 5u);
    for (size_t k = 1; k < slabs.size(); k += 2) {
      auto& triangles = slabs[k].triangles;
      const size_t at = triangles.size() / 3;
      if (damage == Damage::missing) triangles.erase(triangles.begin() + std::ptrdiff_t(at));
      if (damage == Damage::flipped) std::swap(triangles[at][0], triangles[at][1]);
      if (damage == Damage::doubled) triangles.push_back(triangles[at]);
      if (damage == Damage::degenerate) triangles[at][0] = triangles[at][1];
      if (damage == Damage::pinched)
        for (auto& triangle : triangles)
          for (uint32_t& v : triangle) v = v == slabs[k].firstVertex + 7 ? slabs[k - 1].firstVertex + 9 : v;
    }
    TriangleMesh mesh;
    for (const SurfaceSlab& slab : slabs) {
      mesh.positions.insert(mesh.positions.end(), slab.positions.begin(), slab.positions.end());
      mesh.triangles.insert(mesh.triangles.end(), slab.triangles.begin(), slab.triangles.end());
    }
    const TopologyReport whole = checkTopology(mesh);
    EXPECT_FALSE(whole.closed());
    TopologyCheck check(whole.low + (whole.high - whole.low) / 2);
    for (const SurfaceSlab& slab : slabs) {
      check.add(slab.positions, slab.triangles);
      check.settle(slab.firstVertex);
    }
    EXPECT_TRUE(same(check.finish(), whole)) << int(damage);
  }
}

TEST(MeshTopology, WhatIsSettledGetsNoMoreTriangles) {
  const TriangleMesh cube = samples::cube();
  TopologyCheck check(Vec3d::Zero());
  check.add(cube.positions, cube.triangles);
  check.settle(8);
  check.add(cube.positions, {});
  const std::array<uint32_t, 3> late[] = {{7, 8, 9}};
  EXPECT_NE(samples::errorOf([&] { check.add({}, late); }).find("vertex 7"), std::string::npos);
}

}  // namespace
}  // namespace argil::clay
