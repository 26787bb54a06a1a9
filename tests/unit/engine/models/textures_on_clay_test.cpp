// Pictures of models on the clay and the parts that are made of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/models/model_colours.h"
#include "engine/models/model_files.h"
#include "engine/models/prepare_clay.h"
#include "engine/models/script_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/textured_samples.h"

namespace argil::engine {
namespace {

using samples::checkColour;
using samples::Rgba;
using samples::TexturedCube;
using testing::IsEmpty;

constexpr double kVoxel = 0.5;  // mm; a square of the board has 8 along an edge

class TexturesOnClay : public testing::Test {
 protected:
  void SetUp() override {
    samples::spill(folder_ / "board.png", samples::checkerPng());
    samples::spill(folder_ / "cube.mtl", "newmtl board\nmap_Kd board.png\n");
    samples::spill(folder_ / "cube.obj", cube_.obj());
    samples::spill(folder_ / "cube.bin", cube_.bytes());
    samples::spill(folder_ / "cube.gltf", TexturedCube::gltf().dump());
  }
  // Compares each vertex that is clear of edges of the cube and of the board with the board; returns how many.
  size_t compare(const Piece& piece, const Vec3d& moved = Vec3d::Zero()) const {
    clay::Surface surface(false, clay::Grade::fine);
    surface.update(piece.version, 2);
    const clay::TriangleMesh mesh = surface.toMesh();
    const std::vector<io::Colour> colours = vertexColoursOf(surface, piece);
    EXPECT_EQ(colours.size(), mesh.positions.size());
    size_t count = 0;
    for (size_t i = 0; i < colours.size(); ++i) {
      const Vec3d p = piece.pose.apply(mesh.positions[i]) - moved;
      const auto side = cube_.sideAt(p);
      const auto [u, v] = cube_.placeAt(side, p);
      const auto clear = [](double part) {
        const double in = part * samples::kChecks;
        return std::abs(in - std::round(in)) > 2 * kVoxel / 4;  // two voxels of a square of 4 mm
      };
      if (!clear(u) || !clear(v)) continue;
      const Rgba right = checkColour(int(u * samples::kChecks), samples::kChecks - 1 - int(v * samples::kChecks));
      EXPECT_NEAR(colours[i].red, right[0], 2) << p.transpose();
      EXPECT_NEAR(colours[i].green, right[1], 2) << p.transpose();
      EXPECT_NEAR(colours[i].blue, right[2], 2) << p.transpose();
      ++count;
    }
    return count;
  }
  const TexturedCube cube_;
  const samples::Folder folder_;
};

TEST_F(TexturesOnClay, ClayHasTheColoursOfThePicture) {
  for (const char* name : {"cube.obj", "cube.gltf"}) {
    const ImportedModel model = importModel(folder_ / name, {.voxelMm = kVoxel});
    ASSERT_EQ(model.pieces.size(), 1u) << name;
    EXPECT_GT(compare(model.pieces[0]), 1000u) << name;
  }
}

TEST_F(TexturesOnClay, AScriptsImportHasThem) {
  samples::spill(folder_ / "script.json",
                 R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.5}, {"import": "cube.obj"}], "strokes": []})");
  const PreparedClay made = prepareClay(clay::Store::make(), readScript(folder_ / "script.json"));
  ASSERT_EQ(made.document.pieces.size(), 1u);
  EXPECT_GT(compare(made.document.pieces[0]), 1000u);
}

// A part has one colour: the mean of the light of all squares.
TEST_F(TexturesOnClay, APartHasTheMeanOfThePicture) {
  std::array<double, 3> light{};
  for (int x = 0; x < samples::kChecks; ++x)
    for (int y = 0; y < samples::kChecks; ++y)
      for (size_t k = 0; k < 3; ++k) light[k] += samples::linearLight(checkColour(x, y)[k] / 255.0) / 16;
  const ImportedModel model = importModel(folder_ / "cube.obj", {.asPart = true});
  ASSERT_EQ(model.parts.size(), 1u);
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(model.parts[0].colour[k], samples::srgbOf(light[k]), 0.03) << k;
}

// Where a picture lets all light through the clay has no colour of its own, as nobody chose one.
TEST_F(TexturesOnClay, NothingIsInventedWhereAPictureIsClear) {
  samples::spill(folder_ / "board.png", samples::pngOf(64, 64, [](int x, int) {
                   return Rgba{200, 40, 40, uint8_t(x < 32 ? 255 : 0)};
                 }));
  const ImportedModel model = importModel(folder_ / "cube.obj", {.voxelMm = kVoxel});
  ASSERT_EQ(model.pieces.size(), 1u);
  EXPECT_EQ(chosenColour(model.pieces[0]), std::nullopt);
  clay::Surface surface(false, clay::Grade::fine);
  surface.update(model.pieces[0].version, 2);
  const clay::TriangleMesh mesh = surface.toMesh();
  const std::vector<io::Colour> colours = vertexColoursOf(surface, model.pieces[0]);
  ASSERT_EQ(colours.size(), mesh.positions.size());
  for (size_t i = 0; i < colours.size(); ++i) {
    const auto [u, v] = cube_.placeAt(cube_.sideAt(mesh.positions[i]), mesh.positions[i]);
    if (std::min({std::abs(u - 0.5), u, 1 - u}) < 0.1 || v < 0.1 || v > 0.9) continue;
    EXPECT_EQ(colours[i], u < 0.5 ? (io::Colour{200, 40, 40, 255}) : (io::Colour{255, 255, 255, 255}));
  }
}

}  // namespace
}  // namespace argil::engine
