// Every closed mesh of the test data as clay at three voxel sizes: as many bodies as the clay says, none smaller than
// what is taken out as a speck, and the volume of the mesh or a sentence about what is lost.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "clay/base/error.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/wall_thickness.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "io/models/mesh_file.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

TEST(ImportBodies, OfClosedFilesAreThoseOfTheMesh) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const bool all = tests::longTier();
  const auto most = tests::byTier<size_t>(40'000, 200'000);  // triangles
  int files = 0;
  for (const char* folder : {"mesh", "3mf"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(data) / folder)) {
      io::MeshFile read;
      try {
        read = io::readMesh(entry.path());
      } catch (const Error&) {
        continue;
      }
      const clay::RepairedMesh repaired = clay::repairMesh(read.mesh);
      if (!repaired.openEdges.empty() || read.mesh.triangles.size() > most) continue;
      ++files;
      for (const int along : all ? std::vector<int>{48, 128, 300} : std::vector<int>{48}) {
        SCOPED_TRACE(entry.path().filename().string() + " at " + std::to_string(along) + " voxels");
        clay::ImportOptions options;
        options.grid.voxelMm = clay::suggestVoxelMm(read.mesh, along);
        clay::Imported made;
        try {
          made = clay::meshToClay(clay::Store::make(), read.mesh, options);
        } catch (const Error&) {
          continue;  // Thinner than a voxel everywhere: it says so.
        }
        const clay::MeshLosses& losses = made.report.losses;
        clay::Surface surface(false, clay::Grade::fine);
        surface.update(made.version, 2);
        const clay::TopologyReport found = clay::checkTopology(surface.toMesh());
        EXPECT_TRUE(found.closed());
        EXPECT_EQ(found.bodies, losses.bodies + losses.cavities);
        std::string said;
        for (const std::string& sentence : made.report.sentences()) said += sentence + " ";
        if (losses.bodies + losses.cavities != made.report.bodies) {
          EXPECT_NE(said.find("The clay has"), std::string::npos) << said;
        }
        if (losses.meshMm3 > 0 && std::abs(losses.clayMm3 / losses.meshMm3 - 1) > 0.005) {
          EXPECT_NE(said.find("volume"), std::string::npos) << said;
        }
        std::printf("%-40s %4d: mesh %lu bodies, clay %lu and %lu cavities, %lu specks, volume %+.2f %%\n",
                    entry.path().filename().c_str(), along, (unsigned long)(made.report.bodies),
                    (unsigned long)(losses.bodies), (unsigned long)(losses.cavities), (unsigned long)(losses.specks),
                    losses.meshMm3 > 0 ? 100 * (losses.clayMm3 / losses.meshMm3 - 1) : 0.0);
      }
    }
  }
  EXPECT_GT(files, 10);
}

// Voxels that are said to keep every wall do, for the closed files of one body.
TEST(ImportBodies, KeepTheirWallsAtTheVoxelThatIsNamed) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const bool all = tests::longTier();
  const double most = all ? 400 : 60;  // voxels along the longest side
  int files = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(data) / "mesh")) {
    io::MeshFile read;
    try {
      read = io::readMesh(entry.path());
    } catch (const Error&) {
      continue;
    }
    const clay::TopologyReport mesh = clay::checkTopology(read.mesh);
    if (!mesh.solid() || mesh.bodies != 1 || read.mesh.triangles.size() > 200000) continue;
    const double voxel = clay::wallThickness(read.mesh, clay::WorkPart(nullptr)).keepingVoxelMm();
    const double longest = (mesh.high - mesh.low).maxCoeff();
    if (!(voxel > longest / most)) continue;
    ++files;
    // As large as clay may be; what matters is voxels.
    const double scale = 100 / longest;
    for (Vec3d& p : read.mesh.positions) p *= scale;
    clay::ImportOptions options;
    options.grid.voxelMm = voxel * scale;
    const clay::MeshLosses losses = clay::meshToClay(clay::Store::make(), read.mesh, options).report.losses;
    EXPECT_LE(losses.lostMm2, 1e-3 * mesh.area * scale * scale) << entry.path().filename();
    std::printf("%-40s %3.0f voxels along: %.3g mm2 lost\n", entry.path().filename().c_str(), longest / voxel,
                losses.lostMm2);
  }
  EXPECT_GE(files, 5);
}

}  // namespace
}  // namespace argil::engine
