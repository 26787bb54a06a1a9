#include <gtest/gtest.h>

#include "io/mesh_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using Triangle = std::array<uint32_t, 3>;

MeshFile parse(std::string_view text, const std::string& name = "part.obj") {
  return parseMesh(samples::bytesOf(text), name);
}

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, everyFormOfACornerIsRead) {
  const MeshFile file =
      parse(std::string(kSquare) +
            "vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf 1// 2/ 3\n");
  EXPECT_EQ(file.format, "OBJ");
  ASSERT_EQ(file.mesh.triangles.size(), 5u);
  for (const Triangle& t : file.mesh.triangles) EXPECT_EQ(t, (Triangle{0, 1, 2}));
  EXPECT_TRUE(file.notes.empty());
}

TEST(Obj, polygonsBecomeFans) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 3 4\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.faces, 1u);
  EXPECT_EQ(file.polygons, 1u);
}

TEST(Obj, negativeIndicesCountBackFromTheirPlace) {
  const MeshFile file = parse("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Obj, verticesMayComeAfterTheirFaces) {
  EXPECT_EQ(parse(std::string("f 1 2 3\n") + kSquare).mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Obj, linesMayBeContinued) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 \\\n 3 \\\r\n4\nf 1 2\\\n 3\n");
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
}

TEST(Obj, groupsMaterialsCommentsAndExtraNumbersArePassedOver) {
  const MeshFile file = parse(
      "# a comment\r\n\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 0.5 0.5 0.5\r\nv 1 0 0 1.0 # red\r\nv 1 1 0\r\n"
      "g a b\r\ns off\r\nusemtl\r\nf 1 2 3 # last",
      "no-ending");
  EXPECT_EQ(file.mesh.triangles.size(), 1u);
  EXPECT_TRUE(file.notes.empty());
}

TEST(Obj, whatIsLeftOutIsNoted) {
  const MeshFile file = parse(std::string(kSquare) + "f 1 2 3\nl 1 2\np 3\ncstype bezier\ncurv 0 1 1 2\nwobble 3\n");
  ASSERT_EQ(file.notes.size(), 3u);
  EXPECT_EQ(file.notes[0], "2 line and point elements were left out");
  EXPECT_EQ(file.notes[1], "2 statements of free-form curves and surfaces were left out");
  EXPECT_EQ(file.notes[2], "1 lines of an unknown kind were left out");
}

TEST(Obj, errorsNameTheLine) {
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

}  // namespace
}  // namespace argil::io
