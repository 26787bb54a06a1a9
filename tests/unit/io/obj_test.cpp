#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/models/mesh_file.h"
#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using Triangle = std::array<uint32_t, 3>;

MeshFile parse(std::string_view text, const std::string& name = "part.obj") {
  return parseMesh(samples::bytesOf(text), name);
}

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, EveryFormOfACornerIsRead) {
  const MeshFile file =
      parse(std::string(kSquare) +
            "vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf 1// 2/ 3\n");
  EXPECT_EQ(file.format, "OBJ");
  ASSERT_EQ(file.mesh.triangles.size(), 5u);
  for (const Triangle& t : file.mesh.triangles) EXPECT_EQ(t, (Triangle{0, 1, 2}));
  EXPECT_TRUE(file.notes.empty());
}

TEST(Obj, PolygonsBecomeFans) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 3 4\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.faces, 1u);
  EXPECT_EQ(file.polygons, 1u);
}

TEST(Obj, NegativeIndicesCountBackFromTheirPlace) {
  const MeshFile file = parse("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Obj, VerticesMayComeAfterTheirFaces) {
  EXPECT_EQ(parse(std::string("f 1 2 3\n") + kSquare).mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Obj, LinesMayBeContinued) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 \\\n 3 \\\r\n4\nf 1 2\\\n 3\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
}

TEST(Obj, GroupsMaterialsCommentsAndExtraNumbersArePassedOver) {
  const MeshFile file = parse(
      "# a comment\r\n\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 0.5 0.5 0.5\r\nv 1 0 0 1.0 # red\r\nv 1 1 0\r\n"
      "g a b\r\ns off\r\nusemtl\r\nf 1 2 3 # last",
      "no-ending");
  EXPECT_EQ(file.mesh.triangles.size(), 1u);
  EXPECT_EQ(file.notes, (std::vector<std::string>{"materials and their colours were left out"}));
  EXPECT_EQ(parse(std::string(kSquare) + "g a\nf 1 2 3\ng b c\ng a\nf 1 2 3\ng d\nf 1 3 4\n").notes,
            (std::vector<std::string>{"2 groups were put together"}));
}

TEST(Obj, WhatIsLeftOutIsNoted) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 3\nl 1 2\np 3\ncstype bezier\ncurv 0 1 1 2\nwobble 3\n");
  ASSERT_EQ(file.notes.size(), 3u);
  EXPECT_EQ(file.notes[0], "2 line and point elements were left out");
  EXPECT_EQ(file.notes[1], "2 statements of free-form curves and surfaces were left out");
  EXPECT_EQ(file.notes[2], "1 lines of an unknown kind were left out");
}

// Two cubes would do; two squares say it: three materials, one without a colour, one of another object.
TEST(Obj, ColoursOfMaterialsAreRead) {
  const samples::Folder folder;
  samples::spill(folder / "of all.mtl",
                 "# a comment\nKd 0 0 0\nnewmtl red one\nKa 1 1 1\nKd 1 0 0.5\nmap_Kd wood.png\n"
                 "newmtl grey\nKd 0.5\nnewmtl odd\nKd spectral file.rfl\nKd nan 0 0\n");
  samples::spill(folder / "a.obj", std::string("mtllib of all.mtl\n") + kSquare +
                                       "v 5 0 0\nv 6 0 0\nv 6 1 0\no first\nf 1 2 3\nusemtl red one\nf 1 3 4\n"
                                       "mtllib of all.mtl\no second\nusemtl odd\nusemtl grey\nf 5 6 7\n");
  const ModelFile file = readModel(folder / "a.obj");
  ASSERT_EQ(file.objects.size(), 2u);
  EXPECT_EQ(file.objects[0].triangleColours, (std::vector<Colour>{{}, {255, 0, 128, 255}}));
  EXPECT_FALSE(file.objects[0].colour);
  EXPECT_TRUE(file.objects[1].triangleColours.empty());
  EXPECT_EQ(file.objects[1].colour, (Colour{128, 128, 128, 255}));
  EXPECT_EQ(file.notes, (std::vector<std::string>{"1 pictures of materials were left out"}));

  // Colours of vertices go before.
  samples::spill(folder / "b.obj",
                 "mtllib of all.mtl\nv 0 0 0 0 1 0\nv 1 0 0 0 1 0\nv 0 1 0 0 1 0\nusemtl grey\nf 1 2 3\n");
  const ModelFile painted = readModel(folder / "b.obj");
  EXPECT_EQ(painted.objects.at(0).vertexColours.size(), 3u);
  EXPECT_TRUE(painted.objects.at(0).triangleColours.empty());
}

// What is not below the folder is not looked for, and nothing of it is worse than a note.
TEST(Obj, MaterialLibrariesThatCannotBeReadAreNoted) {
  const samples::Folder folder;
  std::filesystem::create_directories(folder / "in");
  samples::spill(folder / "up.mtl", "newmtl red\nKd 1 0 0\n");
  samples::spill(folder / "in" / "zero.mtl", "");
  samples::spill(folder / "in" / "more.mtl", "newmtl red\nKd 0 1 0\n");
  const auto notesOf = [&](const std::string& name) {
    samples::spill(folder / "in" / "a.obj", "mtllib " + name + "\n" + kSquare + "usemtl red\nf 1 2 3\n");
    const ModelFile file = readModel(folder / "in" / "a.obj");
    EXPECT_TRUE(file.objects.at(0).colour.has_value() || !file.notes.empty());
    return file.notes;
  };
  for (const std::string& name : {std::string("../up.mtl"), (folder / "up.mtl").string(), std::string("none.mtl"),
                                  std::string("zero.mtl"), std::string("."), std::string("/dev/zero")})
    EXPECT_THAT(notesOf(name), testing::ElementsAre(testing::HasSubstr("is not beside the file"))) << name;
  EXPECT_THAT(notesOf("more.mtl"), testing::IsEmpty());
  EXPECT_THAT(notesOf("more.mtl none.mtl"), testing::SizeIs(1)) << "the first of two is read all the same";
}

TEST(Obj, ErrorsNameTheLine) {
  const auto contains = [](const std::string& tail, const char* part) {
    const std::string error = samples::errorOf([&] { parse(kSquare + tail); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains("", "part.obj: holds no triangles");
  contains("f 1 2\n", "line 5: a face has 2 corners");
  contains("f\n", "line 5: a face has 0 corners");
  contains("\nf 1 2 5\n", "line 6: a face names vertex 5 and the file has 4");
  contains("f 0 1 2\n", "line 5: a face names vertex 0");
  contains("f 1 2 -5\n", "line 5: a face names vertex -5 and 4 came before");
  contains("f 1 2 99999999999999999999\n", "is no corner of a face");
  contains("f 1 2 4294967296\n", "more than a mesh may have");
  contains("f 1 2 3/x\n", "line 5: \"3/x\" is no corner of a face");
  contains("f 1 2 3/1/1/1\n", "\"3/1/1/1\" is no corner");
  contains("f 1 2 /3\n", "\"/3\" is no corner");
  contains("f 1 2 3.0\n", "\"3.0\" is no corner");
  contains("f 1 2 \\\n x\n", "line 6: \"x\" is no corner");
  contains("v 1 2\n", "line 5: the line ends where a z coordinate should stand");
  contains("v 1 2 inf\n", "line 5: a z coordinate is \"inf\"");
  contains("v 1 2 1e999\n", "only finite numbers");
  contains("v 1 2 3,5\n", "\"3,5\" stands where a z coordinate should");
}

TEST(Obj, NamedObjectsBecomeObjects) {
  const auto model = [](const std::string& text) { return parseModel(samples::bytesOf(text), "part.obj"); };
  // Two objects, the first in two places, one without faces and faces before any object.
  const ModelFile file = model(std::string(kSquare) + "f 1 2 3\n" + "o  left hand \n" + kSquare +
                               "f 5 6 7\no empty\no right\n" + kSquare + "f -4 -3 -2\no left hand\nf -6 -5 -8\n");
  ASSERT_EQ(file.objects.size(), 3u);
  EXPECT_EQ(file.objects[0].name, "");
  EXPECT_EQ(file.objects[1].name, "left hand");
  EXPECT_EQ(file.objects[2].name, "right");
  EXPECT_EQ(file.objects[1].mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 3, 0}}));
  EXPECT_EQ(file.objects[1].mesh.positions.size(), 4u);
  EXPECT_EQ(file.objects[1].mesh.positions[3], Vec3d(0, 1, 0));
  EXPECT_EQ(file.faces, 4u);
  EXPECT_EQ(file.notes, (std::vector<std::string>{"the object empty has no triangles and was left out"}));

  const ModelFile one = model(std::string("o \xff\x01 part\n") + kSquare + "f 1 2 3\n");
  ASSERT_EQ(one.objects.size(), 1u);
  EXPECT_EQ(one.objects[0].name, "?? part");
  EXPECT_EQ(one.objects[0].mesh.positions.size(), 4u) << "vertices without faces stay";
}

TEST(Obj, ObjectsThatShareVerticesStayOneSurface) {
  const ModelFile file =
      parseModel(samples::bytesOf(std::string(kSquare) + "o a\nf 1 2 3\no b\nf 1 3 4\n"), "part.obj");
  ASSERT_EQ(file.objects.size(), 1u);
  EXPECT_EQ(file.objects[0].mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.notes, (std::vector<std::string>{"the objects share vertices and were put together"}));
}

TEST(Obj, ColoursBehindPositionsAreRead) {
  const MeshFile file = parse("v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1 0.2\nv 1 1 0\nv 0 1 0 1\nf 1 2 3\n");
  EXPECT_EQ(file.vertexColours, (std::vector<Colour>{{255, 128, 0}, {0, 0, 255, 51}, {}, {}}));
  EXPECT_EQ(parse("v 0 0 0 255 128 1\nv 1 0 0 0 0 300\nv 0 1 0 nan -1 1\nf 1 2 3\n").vertexColours,
            (std::vector<Colour>{{255, 128, 1}, {0, 0, 255}, {0, 0, 1}}))
      << "one above 1 says that 255 is full";
  EXPECT_TRUE(parse("v 0 0 0 1\nv 1 0 0 1 1\nv 0 1 0 a b c\nf 1 2 3\n").vertexColours.empty());
  const ModelFile split = parseModel(
      samples::bytesOf(
          "o a\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0\nf 1 2 3\no b\nv 0 0 1\nv 1 0 1\nv 0 1 1 0 0 1\nf 6 5 4\n"),
      "x.obj");
  ASSERT_EQ(split.objects.size(), 2u);
  EXPECT_EQ(split.objects[1].vertexColours, (std::vector<Colour>{{0, 0, 255}, {}, {}}));
}

}  // namespace
}  // namespace argil::io
