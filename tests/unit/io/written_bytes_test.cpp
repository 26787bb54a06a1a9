// What files hold, byte by byte, beside what a plain program would write.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "io/models/mesh_writer.h"
#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::append;
using samples::errorOf;
using samples::slurp;

clay::TriangleMesh randomMesh(uint32_t vertices, uint32_t triangles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-50, 50);
  clay::TriangleMesh mesh;
  for (uint32_t i = 0; i < vertices; ++i) mesh.positions.emplace_back(u(random), u(random), u(random));
  for (uint32_t i = 0; i < triangles; ++i) {
    const uint32_t a = random() % vertices, b = (a + 1) % vertices, c = (a + 2) % vertices;
    mesh.triangles.push_back({a, b, c});
  }
  return mesh;
}

TEST(WrittenBytes, BinaryStlOfManyTriangles) {
  const samples::Folder folder;
  // Neither a multiple of the triangles that are packed together nor less than a piece of the sink.
  const clay::TriangleMesh mesh = randomMesh(1000, 33333);
  writeMesh(folder / "a.stl", mesh);
  const std::string bytes = slurp(folder / "a.stl");
  ASSERT_EQ(bytes.size(), 84 + 50 * mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<float, 12> numbers;
    std::memcpy(numbers.data(), bytes.data() + 84 + 50 * t, 48);
    std::array<Vec3d, 3> corners;
    for (size_t k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) {
        const auto expected = float(mesh.positions[mesh.triangles[t][k]][i]);
        ASSERT_EQ(numbers[3 * (k + 1) + size_t(i)], expected);
        corners[k][i] = expected;
      }
    const Vec3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(numbers[size_t(i)], normal[i], 1e-6);
    ASSERT_EQ(bytes[84 + 50 * t + 48], 0);
    ASSERT_EQ(bytes[84 + 50 * t + 49], 0);
  }
}

ModelObject coloured() {
  ModelObject object;
  object.mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}};
  object.mesh.triangles = {{0, 1, 2}};
  object.vertexColours = {{255, 0, 0, 255}, {0, 128, 0, 7}, {1, 2, 51, 255}};
  return object;
}

TEST(WrittenBytes, PlyKeepsColours) {
  const samples::Folder folder;
  const ModelObject object = coloured();
  std::string expected =
      "ply\nformat binary_little_endian 1.0\ncomment Written by Argil, units: mm\nelement vertex 3\nproperty float "
      "x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  for (size_t v = 0; v < 3; ++v) {
    for (int i = 0; i < 3; ++i) append(expected, float(object.mesh.positions[v][i]));
    for (const uint8_t level :
         {object.vertexColours[v].red, object.vertexColours[v].green, object.vertexColours[v].blue})
      append(expected, level);
  }
  append(expected, uint8_t(3));
  for (const uint32_t v : {0u, 1u, 2u}) append(expected, v);
  EXPECT_EQ(writeModel(folder / "a.ply", {{&object, 1}, {}}).bytes, expected.size());
  EXPECT_EQ(slurp(folder / "a.ply"), expected);
}

TEST(WrittenBytes, ObjKeepsColours) {
  const samples::Folder folder;
  const ModelObject object = coloured();
  writeModel(folder / "a.obj", {{&object, 1}, {}});
  EXPECT_EQ(slurp(folder / "a.obj"),
            "# Written by Argil, units: mm\nv 0 0 0 1 0 0\nv 2 0 0 0 0.5019608 0\nv 0 3 0 0.003921569 0.007843138 "
            "0.2\nf 1 2 3\n");
}

TEST(WrittenBytes, StlDropsColours) {
  const samples::Folder folder;
  const ModelObject object = coloured();
  writeModel(folder / "a.stl", {{&object, 1}, {}});
  writeMesh(folder / "b.stl", object.mesh);
  EXPECT_EQ(slurp(folder / "a.stl"), slurp(folder / "b.stl"));
}

TEST(WrittenBytes, ObjectsWithoutColoursAreWhiteBesideOthers) {
  const samples::Folder folder;
  std::vector<ModelObject> objects(3, coloured());
  objects[0].vertexColours.clear();
  objects[1].vertexColours.clear();
  objects[1].colour = Colour{10, 20, 30, 255};
  objects[2].triangleColours = {Colour{0, 0, 255, 255}};
  writeModel(folder / "a.obj", {objects, {}});
  const std::string text = slurp(folder / "a.obj");
  EXPECT_NE(text.find("\nv 0 0 0 1 1 1\nv 2 0 0 1 1 1\nv 0 3 0 1 1 1\nv 0 0 0 0.039215688 "), std::string::npos)
      << text;
  EXPECT_NE(text.find("\nv 2 0 0 0 0 1\nv 0 3 0 0 0 1\no Object\nf 1 2 3\no Object 2\nf 4 5 6\no Object 3\nf 7 8 9\n"),
            std::string::npos)
      << text;
}

TEST(WrittenBytes, ColoursMustComeAsAnnounced) {
  const samples::Folder folder;
  const ModelObject object = coloured();
  for (const bool announced : {false, true}) {
    MeshWriter writer(folder / "a.ply", {3, 1, announced});
    const std::span<const Colour> colours(object.vertexColours);
    EXPECT_NE(
        errorOf([&] { writer.vertices(object.mesh.positions, colours.first(announced ? 0 : 3)); }).find("announced"),
        std::string::npos);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

}  // namespace
}  // namespace argil::io
