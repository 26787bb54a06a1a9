#include <gtest/gtest.h>

#include "io/models/mesh_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using Triangle = std::array<uint32_t, 3>;

MeshFile parse(std::string_view text, const std::string& name = "part.off") {
  return parseMesh(samples::bytesOf(text), name);
}

constexpr const char* kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

TEST(Off, PlainWithCommentsAndPolygons) {
  const MeshFile file = parse(std::string("# made by hand\nOFF # keyword\n\n4 2 0 # counts\n# vertices\n") + kSquare +
                              "\n3 0 1 2\n4 0 1 2 3 # quad");
  EXPECT_EQ(file.format, "OFF");
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.faces, 2u);
  EXPECT_EQ(file.polygons, 1u);
  EXPECT_TRUE(file.notes.empty());
}

TEST(Off, VariantsOfTheHeader) {
  const std::string body =
      "4 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n1 1 0 1 1 1 1\n0 1 0 0 0 0 1\n3 0 1 2 0.5 0.5 0.5\n";
  for (const std::string header : {"OFF\n", "COFF\n", "NOFF\r\n", "STCNOFF ", "CNOFF\r", "OFF "}) {
    const MeshFile file = parse(header + body, "no-ending");
    EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}})) << header;
    EXPECT_EQ(file.mesh.positions[2], Vec3d(1, 1, 0)) << header;
  }
  EXPECT_EQ(parse(body).mesh.triangles.size(), 1u) << "keyword left out";
  EXPECT_EQ(parse(std::string("OFF\n4 1\n") + kSquare + "3 0 1 2\n").mesh.triangles.size(), 1u)
      << "count of edges left out";
}

TEST(Off, WhatFollowsIsNoted) {
  const MeshFile file = parse(std::string("OFF\n4 1 0\n") + kSquare + "3 0 1 2\n3 0 2 3\n");
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_EQ(file.notes[0], "what follows the last face, from line 8 on, was ignored");
}

TEST(Off, ErrorsNameTheLine) {
  const auto contains = [](const std::string& text, const char* part) {
    const std::string error = samples::errorOf([&] { parse(text); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  const std::string square = kSquare;
  contains("OFF\n", "the file ends where the count of vertices should stand");
  contains("OFF\n-4 1 0\n", "line 2: the count of vertices is negative");
  contains("OFF\n4000000000 1 0\n" + square, "announces 4000000000 vertices and has only 24 bytes left");
  contains("OFF\n4 4000000000 0\n" + square + "3 0 1 2\n", "announces 4000000000 faces and has only 8 bytes left");
  contains("OFF\n4 0 0\n" + square, "holds no triangles");
  contains("OFF\n4 1 0\n0 0 0\n1 0\n1 1 0\n0 1 0\n3 0 1 2\n",
           "line 4: the line ends where a z coordinate should stand");
  contains("OFF\n4 1 0\n" + square + "3 0 1 4\n", "line 7: a face names vertex 4");
  contains("OFF\n4 1 0\n" + square + "3 0 1 -1\n", "line 7: a face names vertex -1");
  contains("OFF\n4 1 0\n" + square + "2 0 1      \n", "line 7: a face has 2 corners");
  contains("OFF\n4 1 0\n" + square + "9 0 1 2 3 0", "the file ends where a vertex of a face should stand");
  contains("OFF\n4 1 0\n0 0 nan\n" + square + "3 0 1 2\n", "line 3: a z coordinate is \"nan\"");
  contains("4OFF\n4 1 0\n" + square + "3 0 1 2\n", "only OFF in three dimensions");
  contains("OFF BINARY\n" + square, "binary OFF cannot be read");
}

TEST(Off, ColoursOfVerticesAndFaces) {
  const auto vertices = [](const std::string& header, const std::string& a, const std::string& b) {
    return parse(header + "\n3 1 0\n0 0 0 " + a + "\n1 0 0 " + b + "\n0 1 0\n3 0 1 2\n").vertexColours;
  };
  EXPECT_EQ(vertices("COFF", "255 0 1 128", "1 2 3"), (std::vector<Colour>{{255, 0, 1, 128}, {1, 2, 3}, {}}));
  EXPECT_EQ(vertices("COFF", "1 0 0.5 1", "0 1 0"), (std::vector<Colour>{{255, 0, 128, 255}, {0, 255, 0}, {}}));
  EXPECT_EQ(vertices("CNOFF", "0 0 1 1 0 0", "0 0 1 0 1 0 0.2"),
            (std::vector<Colour>{{255, 0, 0}, {0, 255, 0, 51}, {}}));
  EXPECT_TRUE(vertices("NOFF", "0 0 1 1 0 0", "0 0 1 0 1 0").empty());
  EXPECT_TRUE(vertices("COFF", "1 2", "red").empty());
  const MeshFile faces =
      parse(std::string("OFF\n4 3 0\n") + kSquare + "3 0 1 2 17\n4 0 1 2 3 10 20 30\n3 0 1 2 1 2 3 4 5\n");
  EXPECT_EQ(faces.triangleColours, (std::vector<Colour>{{}, {10, 20, 30}, {10, 20, 30}, {1, 2, 3, 4}}));
}

}  // namespace
}  // namespace argil::io
