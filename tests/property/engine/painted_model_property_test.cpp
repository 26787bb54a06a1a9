// A painted scan out to every format that has colours, and back into clay.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "clay/import/mesh_colours.h"
#include "engine/document/document.h"
#include "engine/models/model_files.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

constexpr double kSizeMm = 75;
constexpr double kVoxelMm = 0.8;
constexpr double kStripesMm = 23;

// Bytes of sRGB: smooth within stripes, with a jump from one to the next.
Eigen::Vector3d paintAt(const Vec3d& p, int stripe) {
  const double other = stripe % 2 == 0 ? 40 : 210;
  return {128 + 90 * std::sin(p.x() / 15), other, 128 + 90 * std::cos(p.y() / 18)};
}
int stripeOf(const Vec3d& p) {
  return int(std::floor(p.z() / kStripesMm));
}
double fromBorder(const Vec3d& p) {
  const double t = p.z() / kStripesMm;
  return std::abs(t - std::round(t)) * kStripesMm;
}

TEST(PaintedModel, KeepsItsColoursInEveryFormat) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const fs::path folder = fs::temp_directory_path() / ("argil-painted-" + std::to_string(getpid()));
  fs::create_directories(folder);
  Piece bunny =
      importModel(fs::path(data) / "mesh" / "stanford-bunny.obj", {.voxelMm = kVoxelMm, .fitMm = kSizeMm}).pieces.at(0);
  Document document;
  document.add(bunny);
  // Painted through its own surface: the nearest vertex of a fine mesh of it, a stripe's border within a hundredth of
  // mm.
  io::ModelObject skin = modelOf(document, {}).at(0);
  std::vector<clay::MeshColour> colours;
  for (const auto& [a, b, c] : skin.mesh.triangles) {
    const Vec3d middle = (skin.mesh.positions[a] + skin.mesh.positions[b] + skin.mesh.positions[c]) / 3;
    const Eigen::Vector3d paint = paintAt(middle, stripeOf(middle));
    colours.push_back(
        {uint8_t(std::lround(paint.x())), uint8_t(std::lround(paint.y())), uint8_t(std::lround(paint.z()))});
  }
  document.pieces[0].version =
      clay::withMeshColours(document.pieces[0].version, skin.mesh, {{}, colours}, clay::WorkPart(nullptr));

  for (const char* name : {"b.ply", "b.obj", "b.3mf", "b.glb", "b.gltf", "b.vdb"}) {
    SCOPED_TRACE(name);
    writeModelFiles({folder / name}, document, {});
    Document again;
    for (const Piece& piece : importModel(folder / name, {.voxelMm = kVoxelMm}).pieces) again.add(piece);
    ASSERT_EQ(again.pieces.size(), 1u);
    const io::ModelObject back = modelOf(again, {}).at(0);
    ASSERT_EQ(back.vertexColours.size(), back.mesh.positions.size());
    double sum = 0;
    size_t judged = 0, strayed = 0;
    for (size_t i = 0; i < back.vertexColours.size(); ++i) {
      const Vec3d& p = back.mesh.positions[i];
      const Eigen::Vector3d paint = paintAt(p, stripeOf(p));
      const io::Colour& c = back.vertexColours[i];
      const double border = fromBorder(p);
      // The jump itself is drawn over a voxel on either side, by clay and by interpolated colours of vertices.
      if (border > 2 * kVoxelMm) {
        sum += (Eigen::Vector3d(c.red, c.green, c.blue) - paint).squaredNorm() / 3;
        ++judged;
      }
      strayed += border > kVoxelMm && std::abs(double(c.green) - paint.y()) > 85;
    }
    EXPECT_GT(judged, 10000u);
    EXPECT_LE(std::sqrt(sum / double(judged)), 2);
    EXPECT_EQ(strayed, 0u) << "a border moved by more than a voxel";
    std::printf("%-7s %zu vertices, RMS %.2f of 255\n", name, judged, std::sqrt(sum / double(judged)));
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace argil::engine
