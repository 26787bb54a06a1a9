#include "clay/import/mesh_repair.h"

#include <gtest/gtest.h>

#include "clay/base/error.h"

#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

using testing::append;
using testing::box;
using testing::flip;
using testing::icosphere;
using testing::meshVolume;

constexpr uint64_t kSeed = 7;

TEST(MeshRepair, LeavesASoundMeshAlone) {
  const TriangleMesh sphere = icosphere({1, 2, 3}, 5, 3);
  const RepairedMesh repaired = repairMesh(sphere);
  EXPECT_TRUE(repaired.findings.sound());
  EXPECT_EQ(repaired.findings.bodies, 1u);
  EXPECT_EQ(repaired.mesh.triangles.size(), sphere.triangles.size());
  EXPECT_TRUE(repaired.openEdges.empty());
  EXPECT_EQ(repaired.findings.backedShare, 1);
}

TEST(MeshRepair, TurnsFlippedFacesAndDropsRepeatedOnes) {
  TriangleMesh mesh = icosphere({0, 0, 0}, 5, 3);
  const double volume = meshVolume(mesh);
  std::mt19937 random(kSeed);
  for (auto& t : mesh.triangles) {
    if (random() % 5 == 0) flip(t);
  }
  const size_t count = mesh.triangles.size();
  for (size_t i = 0; i < count; i += 10) mesh.triangles.push_back(mesh.triangles[i]);
  for (size_t i = 0; i < count; i += 15) {  // some of them a third time, facing the other way
    mesh.triangles.push_back(mesh.triangles[i]);
    flip(mesh.triangles.back());
  }
  const RepairedMesh repaired = repairMesh(mesh);
  EXPECT_NEAR(meshVolume(repaired.mesh), volume, 1e-9) << "seed " << kSeed;
  EXPECT_EQ(repaired.mesh.triangles.size(), count);
  EXPECT_EQ(repaired.findings.duplicateFaces, mesh.triangles.size() - count);
  EXPECT_GT(repaired.findings.flippedFaces, 0u);
  EXPECT_TRUE(repaired.openEdges.empty());
}

// Of many boxes beside each other every third is inside out, and every fifth has a cavity, which is meant to be.
TEST(MeshRepair, TurnsEachOfManyBodiesAndLeavesTheirCavities) {
  TriangleMesh mesh;
  double volume = 0;
  uint64_t turned = 0;
  for (int i = 0; i < 600; ++i) {
    const Vec3d at(3.0 * (i % 30), 3.0 * (i / 30), 0);
    TriangleMesh outer = box(at, at + Vec3d(2, 2, 2)),
                 inner = box(at + Vec3d(0.5, 0.5, 0.5), at + Vec3d(1.5, 1.5, 1.5));
    if (i % 3 == 1) {
      for (auto& t : outer.triangles) flip(t);
      ++turned;
    }
    append(mesh, outer);
    volume += 8;
    if (i % 5 != 0) continue;
    for (auto& t : inner.triangles) flip(t);
    append(mesh, inner);
    volume -= 1;
  }
  const RepairedMesh repaired = repairMesh(mesh);
  EXPECT_EQ(repaired.findings.bodies, 720u);
  EXPECT_EQ(repaired.findings.flippedBodies, turned);
  EXPECT_NEAR(meshVolume(repaired.mesh), volume, 1e-9);
  EXPECT_EQ(repaired.findings.crossings, 0u);
  Job job;
  job.cancel();
  EXPECT_THROW((void)repairMesh(mesh, &job), Cancelled);
}

TEST(MeshRepair, DropsAFlapOfNoThickness) {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh.positions.emplace_back(2, 2, 2);
  mesh.triangles.push_back({6, 7, 8});
  mesh.triangles.push_back({7, 6, 8});
  const RepairedMesh repaired = repairMesh(mesh);
  EXPECT_EQ(repaired.mesh.triangles.size(), 12u);
  EXPECT_TRUE(repaired.findings.sound());
}

TEST(MeshRepair, WeldsSoupsAndDropsWhatHasNoArea) {
  const TriangleMesh welded = box({0, 0, 0}, {1, 1, 1});
  TriangleMesh soup;
  for (const auto& t : welded.triangles) {
    for (const uint32_t v : t) soup.positions.push_back(welded.positions[v]);
    const auto n = uint32_t(soup.positions.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
  }
  soup.triangles.push_back({0, 0, 1});
  const RepairedMesh repaired = repairMesh(soup);
  EXPECT_EQ(repaired.mesh.positions.size(), 8u);
  EXPECT_EQ(repaired.mesh.triangles.size(), 12u);
  EXPECT_EQ(repaired.findings.degenerate, 1u);
  EXPECT_TRUE(repaired.findings.sound());
}

TEST(MeshRepair, TurnsBodiesButKeepsCavities) {
  const auto inverted = [](TriangleMesh mesh) {
    for (auto& t : mesh.triangles) flip(t);
    return mesh;
  };
  TriangleMesh hollow = icosphere({0, 0, 0}, 10, 2);
  append(hollow, inverted(icosphere({0, 0, 0}, 5, 2)));
  const double volume = meshVolume(hollow);
  EXPECT_NEAR(meshVolume(repairMesh(hollow).mesh), volume, 1e-9);
  EXPECT_EQ(repairMesh(hollow).findings.bodies, 2u);

  const RepairedMesh whole = repairMesh(inverted(hollow));
  EXPECT_TRUE(whole.findings.flippedWhole);
  EXPECT_NEAR(meshVolume(whole.mesh), volume, 1e-9);

  TriangleMesh beside = icosphere({0, 0, 0}, 10, 2);
  append(beside, inverted(icosphere({30, 0, 0}, 5, 2)));
  const RepairedMesh one = repairMesh(beside);
  EXPECT_EQ(one.findings.flippedBodies, 1u);
  EXPECT_FALSE(one.findings.flippedWhole);
  EXPECT_GT(meshVolume(one.mesh), volume);
}

TEST(MeshRepair, TellsAnOpenBodyFromASheet) {
  TriangleMesh open = box({0, 0, 0}, {4, 4, 4});
  open.triangles.resize(10);
  for (auto& t : open.triangles) flip(t);
  const RepairedMesh repaired = repairMesh(open);
  EXPECT_EQ(repaired.findings.boundaryEdges, 4u);
  EXPECT_EQ(repaired.openEdges.size(), 4u);
  EXPECT_TRUE(repaired.findings.flippedWhole);
  EXPECT_GT(repaired.findings.backedShare, 0.9);

  TriangleMesh sheet;
  constexpr uint32_t kN = 20;
  for (uint32_t x = 0; x < kN; ++x) {
    for (uint32_t y = 0; y < kN; ++y) sheet.positions.emplace_back(x, y, std::sin(x * 0.7) * std::cos(y * 0.9));
  }
  for (uint32_t x = 0; x + 1 < kN; ++x) {
    for (uint32_t y = 0; y + 1 < kN; ++y) {
      const uint32_t v = x * kN + y;
      sheet.triangles.push_back({v, v + kN, v + 1});
      sheet.triangles.push_back({v + 1, v + kN, v + kN + 1});
    }
  }
  EXPECT_LT(repairMesh(sheet).findings.backedShare, 0.3);
}

TEST(MeshRepair, HoldsNothingOfNothing) {
  EXPECT_TRUE(repairMesh({}).mesh.triangles.empty());
  EXPECT_TRUE(repairMesh({{{0, 0, 0}}, {{0, 0, 0}}}).mesh.triangles.empty());
}

}  // namespace
}  // namespace argil::clay
