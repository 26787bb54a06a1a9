// Every closed mesh of the test data as clay at three voxel sizes: as many bodies as the clay says, none smaller than
// what is taken out as a speck, and the volume of the mesh or a sentence about what is lost.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "clay/error.h"
#include "clay/mesh_to_clay.h"
#include "clay/mesh_topology.h"
#include "clay/store.h"
#include "clay/surface.h"
#include "io/mesh_file.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

TEST(ImportBodies, ofClosedFilesAreThoseOfTheMesh) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const bool all = std::getenv("ARGIL_LONG") != nullptr;
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
      if (!repaired.openEdges.empty() || read.mesh.triangles.size() > 200000) continue;
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

}  // namespace
}  // namespace argil::engine
