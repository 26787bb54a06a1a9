#include "io/models/mesh_writer.h"

#include <gmock/gmock.h>

#include <gtest/gtest.h>

#include <limits>

#include "io/models/mesh_file.h"
#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::errorOf;
using samples::slurp;

TEST(MeshWriter, TheEndingChoosesTheFormat) {
  const samples::Folder folder;
  EXPECT_EQ(writeMesh(folder / "a.stl", samples::cube()).format, "STL (binary)");
  EXPECT_EQ(writeMesh(folder / "b.STL", samples::cube(), {.text = true}).format, "STL (text)");
  EXPECT_EQ(writeMesh(folder / "c.obj", samples::cube()).format, "OBJ");
  EXPECT_EQ(writeMesh(folder / "d.Ply", samples::cube()).format, "PLY");
  EXPECT_EQ(writeMesh(folder / "e", samples::cube(), {.extension = ".obj"}).format, "OBJ");
  EXPECT_EQ(readMesh(folder / "a.stl").format, "STL (binary)");
  EXPECT_EQ(readMesh(folder / "b.STL").format, "STL (text)");
  EXPECT_EQ(readMesh(folder / "c.obj").format, "OBJ");
  EXPECT_EQ(readMesh(folder / "d.Ply").format, "PLY (binary)");
  EXPECT_EQ(folder.entries(), 5u);
}

TEST(MeshWriter, UnknownEndingsNameTheKnownOnes) {
  const samples::Folder folder;
  const std::string error = errorOf([&] { writeMesh(folder / "a.step", samples::cube()); });
  EXPECT_EQ(error.find((folder / "a.step").string() +
                       ": cannot write \".step\"; name a file that ends in one of .stl, .obj, .ply"),
            0u)
      << error;
  EXPECT_NE(errorOf([&] { writeMesh(folder / "a.off", samples::cube()); }).find(".stl, .obj, .ply"), std::string::npos);
  EXPECT_NE(errorOf([&] { writeMesh(folder / "a", samples::cube()); }).find("has no ending"), std::string::npos);
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(MeshWriter, BinaryStlIsLaidOutAsReadersExpect) {
  const samples::Folder folder;
  clay::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 1}};
  const WriteReport report = writeMesh(folder / "a.stl", mesh);
  const std::string bytes = slurp(folder / "a.stl");
  ASSERT_EQ(bytes.size(), 184u);
  EXPECT_EQ(report.bytes, 184u);
  EXPECT_EQ(report.triangles, 2u);
  EXPECT_NE(bytes.substr(0, 5), "solid");
  std::array<float, 12> numbers;
  std::memcpy(numbers.data(), bytes.data() + 84, 48);
  EXPECT_EQ(numbers, (std::array<float, 12>{0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0}));
  std::memcpy(numbers.data(), bytes.data() + 134, 48);
  EXPECT_EQ(numbers[0], 0) << "a triangle without direction has a zero normal, never NaN";
  EXPECT_EQ(numbers[2], 0);
}

TEST(MeshWriter, NormalsOfTinyAndHugeTrianglesAreUnit) {
  const samples::Folder folder;
  for (const double size : {1e-30, 1e30}) {
    clay::TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, size, 0}, {0, 0, size}};
    mesh.triangles = {{0, 1, 2}};
    writeMesh(folder / "a.stl", mesh);
    float x = 0;
    std::memcpy(&x, slurp(folder / "a.stl").data() + 84, 4);
    EXPECT_EQ(x, 1) << size;
  }
}

TEST(MeshWriter, SaysWhatRoundingLost) {
  const samples::Folder folder;
  const clay::TriangleMesh far = samples::cube(30.3, {1e6, 0, 0});
  for (const char* name : {"a.stl", "a.ply"}) {
    const WriteReport report = writeMesh(folder / name, far, {.tolerance = 0.01});
    EXPECT_NEAR(report.rounding, 0.0125, 1e-3);
    EXPECT_NE(report.warning.find("32-bit numbers"), std::string::npos) << report.warning;
    EXPECT_EQ(writeMesh(folder / name, far, {.tolerance = 0.1}).warning, "");
  }
  EXPECT_EQ(writeMesh(folder / "a.obj", far, {.tolerance = 0.0}).rounding, 0);
  EXPECT_EQ(writeMesh(folder / "b.ply", far, {.doubles = true, .tolerance = 0.0}).warning, "");
  EXPECT_EQ(readMesh(folder / "b.ply").mesh.positions, far.positions);
}

TEST(MeshWriter, WhatCannotBeWrittenLeavesTheOldFile) {
  const samples::Folder folder;
  samples::spill(folder / "a.stl", "old");
  const auto contains = [&](const clay::TriangleMesh& mesh, const char* part) {
    try {
      writeMesh(folder / "a.stl", mesh);
      ADD_FAILURE() << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::work);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
    EXPECT_EQ(slurp(folder / "a.stl"), "old");
    EXPECT_EQ(folder.entries(), 1u);
  };
  contains({}, "there is no surface to write");
  clay::TriangleMesh mesh = samples::cube();
  mesh.positions[3].y() = std::numeric_limits<double>::quiet_NaN();
  contains(mesh, "vertex 3 is not finite");
  mesh.positions[3].y() = 1e39;
  contains(mesh, "does not fit the format");
  mesh = samples::cube();
  mesh.triangles[11][2] = 8;
  contains(mesh, "names a vertex that is not there");
}

TEST(MeshWriter, CancelLeavesTheOldFile) {
  const samples::Folder folder;
  samples::spill(folder / "a.obj", "old");
  clay::TriangleMesh mesh = samples::cube();
  Job job;
  MeshWriter writer(folder / "a.obj", {8, 12}, {}, &job);
  writer.vertices(mesh.positions);
  EXPECT_NEAR(job.fraction(), 0.4, 1e-12);
  job.cancel();
  EXPECT_THROW(writer.triangles(mesh.triangles), Cancelled);
  EXPECT_THROW(writeMesh(folder / "a.obj", mesh, {}, &job), Cancelled);
  EXPECT_EQ(slurp(folder / "a.obj"), "old");
}

TEST(MeshWriter, PiecesGiveTheSameFileAsTheWhole) {
  const samples::Folder folder;
  const clay::TriangleMesh mesh = samples::cube(0.7);
  for (const std::string ending : {".stl", ".obj", ".ply"}) {
    writeMesh(folder / ("whole" + ending), mesh);
    MeshWriter writer(folder / ("pieces" + ending), {8, 12});
    for (const Vec3d& p : mesh.positions) writer.vertices({&p, 1});
    writer.triangles({});
    for (const auto& t : mesh.triangles) writer.triangles({&t, 1});
    EXPECT_FALSE(std::filesystem::exists(folder / ("pieces" + ending)));
    const WriteReport report = writer.finish();
    EXPECT_EQ(report.vertices, 8u);
    EXPECT_EQ(report.bytes, std::filesystem::file_size(folder / ("whole" + ending)));
    EXPECT_EQ(slurp(folder / ("pieces" + ending)), slurp(folder / ("whole" + ending)));
  }
}

TEST(MeshWriter, AnnouncedCountsMustBeKept) {
  const samples::Folder folder;
  const clay::TriangleMesh mesh = samples::cube();
  {
    MeshWriter writer(folder / "a.ply", {7, 12});
    EXPECT_THROW(writer.vertices(mesh.positions), Error);
  }
  {
    MeshWriter writer(folder / "a.ply", {8, 13});
    EXPECT_THROW(writer.triangles(mesh.triangles), Error);
    writer.vertices(mesh.positions);
    writer.triangles(mesh.triangles);
    EXPECT_THROW(writer.finish(), Error);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

// A grain a million millimetres from zero: 32-bit numbers stand 0.06 mm apart there.
TEST(ModelWriting, WhatTheNumbersCannotHoldIsRefusedAndTheOldFileStays) {
  const samples::Folder folder;
  ModelObject grain;
  grain.mesh = samples::cube(0.01, Vec3d(1e6, 0, 0));
  for (const char* name : {"a.stl", "a.ply", "a.3mf"}) {
    samples::spill(folder / name, "old");
    const std::string error = samples::errorOf([&] {
      static_cast<void>(writeModel(folder / name, {{&grain, 1}, {}}));
    });
    EXPECT_THAT(error, testing::HasSubstr("--recentre")) << name;
    EXPECT_EQ(samples::slurp(folder / name), "old");
  }
  for (const char* name : {"a.obj", "a.glb"}) {
    static_cast<void>(writeModel(folder / name, {{&grain, 1}, {}}));
    EXPECT_EQ(readModel(folder / name).objects.at(0).mesh.positions.size(), 8u) << name;
  }
  // A large model at the same place loses as much, and next to nothing of itself.
  grain.mesh = samples::cube(1000, Vec3d(1e6, 0, 0));
  EXPECT_EQ(writeModel(folder / "a.stl", {{&grain, 1}, {}}).triangles, 12u);
}

// Red and blue triangles side by side: PLY keeps each, OBJ the mean where they meet and says so beforehand, STL none.
TEST(ModelWriting, ColoursOfTrianglesAreKeptOrTold) {
  const samples::Folder folder;
  ModelObject cube;
  cube.mesh = samples::cube(10);
  for (size_t i = 0; i < 12; ++i)
    cube.triangleColours.push_back(i % 2 ? Colour{255, 0, 0, 255} : Colour{0, 0, 200, 255});
  const auto written = [&](const char* name) {
    static_cast<void>(writeModel(folder / name, {{&cube, 1}, {}}));
    return readModel(folder / name).objects.at(0);
  };
  EXPECT_EQ(written("a.ply").triangleColours, cube.triangleColours);
  EXPECT_TRUE(lossesOf("a.ply", {{&cube, 1}, {}}).empty());
  const ModelObject obj = written("a.obj");
  ASSERT_EQ(obj.vertexColours.size(), 8u);
  for (size_t v = 0; v < 8; ++v) {
    double red = 0, blue = 0, count = 0;
    for (size_t t = 0; t < 12; ++t)
      if (std::count(cube.mesh.triangles[t].begin(), cube.mesh.triangles[t].end(), v) > 0)
        red += cube.triangleColours[t].red, blue += cube.triangleColours[t].blue, ++count;
    EXPECT_NEAR(obj.vertexColours[v].red, red / count, 0.51);
    EXPECT_NEAR(obj.vertexColours[v].blue, blue / count, 0.51);
  }
  EXPECT_THAT(lossesOf("a.obj", {{&cube, 1}, {}}),
              testing::ElementsAre(testing::HasSubstr("the mean around each vertex")));
  EXPECT_THAT(lossesOf("a.stl", {{&cube, 1}, {}}), testing::ElementsAre(testing::HasSubstr("STL has no colours")));
}

// Names may repeat, be missing or hold what would end the line.
TEST(ModelWriting, ObjKeepsObjectsWithTheirNames) {
  const samples::Folder folder;
  std::vector<ModelObject> objects(4);
  for (size_t i = 0; i < 4; ++i) objects[i].mesh = samples::cube(1, Vec3d(10.0 * double(i), 0, 0));
  objects[0].name = "left hand";
  objects[1].name = "left hand";
  objects[3].name = "two\nlines";
  static_cast<void>(writeModel(folder / "a.obj", {objects, {}}));
  const ModelFile again = readModel(folder / "a.obj");
  ASSERT_EQ(again.objects.size(), 4u);
  const char* const names[] = {"left hand", "left hand 2", "Object", "two lines"};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(again.objects[i].name, names[i]);
    EXPECT_EQ(again.objects[i].mesh.triangles.size(), 12u);
    EXPECT_NEAR(again.objects[i].mesh.positions[0].x(), 10.0 * double(i), 1.001);
  }
  EXPECT_TRUE(lossesOf("a.obj", {objects, {}}).empty());
  EXPECT_THAT(lossesOf("a.ply", {objects, {}}), testing::ElementsAre(testing::HasSubstr("4 objects become one")));
}

}  // namespace
}  // namespace argil::io
