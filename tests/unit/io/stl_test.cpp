#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "io/models/mesh_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::errorOf;

constexpr const char* kFacet =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n";

MeshFile parse(std::string_view text, const std::string& name = "part.stl") {
  return parseMesh(samples::bytesOf(text), name);
}

std::string binary(uint32_t claimed, const std::vector<std::array<float, 9>>& triangles,
                   std::string_view header = "made by a test") {
  std::string bytes(header);
  bytes.resize(80, ' ');
  samples::append(bytes, claimed);
  for (const auto& triangle : triangles) {
    for (int i = 0; i < 3; ++i) samples::append(bytes, 0.0f);
    for (const float x : triangle) samples::append(bytes, x);
    samples::append(bytes, uint16_t(0));
  }
  return bytes;
}

constexpr std::array<float, 9> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
constexpr std::array<float, 9> kOther = {0, 1, 0, 1, 0, 0, 1, 1, 0};

TEST(Stl, TextWithSeveralSolidsIsWelded) {
  const std::string text =
      std::string("solid one two three\n") + kFacet + "endsolid one two three\nsolid\n" + kFacet + "endsolid\n";
  const MeshFile file = parse(text);
  EXPECT_EQ(file.format, "STL (text)");
  EXPECT_EQ(file.mesh.triangles.size(), 2u);
  EXPECT_EQ(file.mesh.positions.size(), 3u);
  EXPECT_TRUE(file.welded);
  EXPECT_EQ(file.faces, 2u);
}

// Solids that touch are patches of one surface; the others are objects.
TEST(Stl, TextHasAnObjectForEachSolid) {
  std::string away = kFacet;
  for (size_t at = 0; (at = away.find("vertex ", at)) != std::string::npos; at += 8) away.insert(at + 7, "1");
  const std::string text = "solid left arm\n" + std::string(kFacet) +
                           "endsolid\nsolid none\nendsolid\nsolid right\x1b arm\n" + away + "endsolid\n";
  const ModelFile apart = parseModel(samples::bytesOf(text), "a.stl");
  ASSERT_EQ(apart.objects.size(), 2u);
  EXPECT_EQ(apart.objects[0].name, "left arm");
  EXPECT_EQ(apart.objects[1].name, "right? arm");
  EXPECT_EQ(apart.objects[1].mesh.positions.size(), 3u);
  EXPECT_EQ(apart.notes, (std::vector<std::string>{"the object none has no triangles and was left out"}));
  const std::string patches = "solid a\n" + std::string(kFacet) + "endsolid\nsolid b\n" + kFacet + "endsolid\n";
  const ModelFile together = parseModel(samples::bytesOf(patches), "a.stl");
  ASSERT_EQ(together.objects.size(), 1u);
  EXPECT_EQ(together.objects[0].mesh.positions.size(), 3u);
  EXPECT_EQ(together.notes, std::vector<std::string>{"the 2 solids share vertices and were put together"});
  // One has the name of its file: programs write their own behind "solid".
  EXPECT_EQ(parseModel(samples::bytesOf("solid by some CAD\n" + std::string(kFacet) + "endsolid\n"), "a.stl")
                .objects.at(0)
                .name,
            "");
}

TEST(Stl, TextMayBeUpperCaseWithCarriageReturnsAndNanNormals) {
  const MeshFile file = parse(
      "  SOLID X\r\n FACET NORMAL nan -nan(ind) inf\r\n OUTER LOOP\r\n VERTEX 0 0 0\r\n VERTEX +1.5E+000 0 0\r\n "
      "VERTEX 0 1e-400 2\r\n"
      " ENDLOOP\r\n ENDFACET\r\nENDSOLID X",
      "no-ending");
  EXPECT_EQ(file.format, "STL (text)");
  EXPECT_EQ(file.mesh.positions[1], Vec3d(1.5, 0, 0));
  EXPECT_EQ(file.mesh.positions[2], Vec3d(0, 0, 2));
}

TEST(Stl, TextErrorsNameTheLine) {
  EXPECT_EQ(errorOf([] { parse("solid a\nendsolid a\n"); }),
            "part.stl: holds no triangles (read as STL); check what was exported");
  const auto contains = [](const std::string& text, const char* part) {
    const std::string error = errorOf([&] { parse(text); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  const std::string facet = kFacet;
  contains("solid a\n" + facet, "line 9: the file ends without \"endsolid\"");
  contains("solid a\n" + facet.substr(0, 60), "the file ends");
  contains("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n",
           "line 4: \"x\" stands where a z coordinate should");
  contains("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", "line 4: a y coordinate is \"nan\"");
  contains("solid a\nfacet normal 0 0 1\nouter loop\nvertex 1e999 0 0\n", "only finite numbers");
  contains("solid a\nfacet normal 0 0 up\n", "line 2: \"up\" stands in a normal");
  contains("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\n",
           "line 7: \"vertex\" stands where \"endloop\" should");
  contains("solid a\n" + facet + "banana\x1b[31m\n", "line 9: \"banana?[31m\" is no word of a text STL");
}

TEST(Stl, BinaryIsWeldedAndLosesNothing) {
  const MeshFile file = parse(binary(2, {kTriangle, kOther}));
  EXPECT_EQ(file.format, "STL (binary)");
  EXPECT_EQ(file.mesh.triangles.size(), 2u);
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_TRUE(file.notes.empty());
}

TEST(Stl, BinaryThatBeginsWithSolidIsBinary) {
  EXPECT_EQ(parse(binary(2, {kTriangle, kOther}, "solid featuretype")).mesh.triangles.size(), 2u);
  EXPECT_EQ(parse(binary(1, {kTriangle}, "solid a\nfacet"), "whatever.bin").format, "STL (binary)");
  // Also when its length betrays that it is damaged.
  const std::string cut = binary(2, {kTriangle, kOther}, "solid featuretype").substr(0, 150);
  EXPECT_NE(errorOf([&] { parse(cut); }).find("announces 2 triangles (184 bytes) and has 150 bytes"),
            std::string::npos);
}

TEST(Stl, BytesBehindTheLastTriangleAreNoted) {
  const MeshFile file = parse(binary(1, {kTriangle, kOther}));
  EXPECT_EQ(file.mesh.triangles.size(), 1u);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_EQ(file.notes[0], "50 bytes after the last triangle were ignored");
}

TEST(Stl, BinaryErrors) {
  const auto contains = [](const std::string& bytes, const char* part) {
    const std::string error = errorOf([&] { parse(bytes); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains(binary(0, {}), "holds no triangles");
  contains(binary(0xffffffff, {kTriangle}), "announces 4294967295 triangles (214748364834 bytes) and has 134 bytes");
  contains(binary(1, {kTriangle}).substr(0, 50), "at least 84 bytes and this has 50");
  for (const float bad : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    auto triangle = kTriangle;
    triangle[4] = bad;
    contains(binary(2, {kOther, triangle}), "byte 134: triangle 2 has a coordinate that is not finite");
  }
}

TEST(Stl, ColoursAreKeptWhereTheHeaderSaysSo) {
  const auto withAttributes = [](std::string_view header, uint16_t first, uint16_t second) {
    std::string bytes = binary(2, {kTriangle, kOther}, header);
    std::memcpy(bytes.data() + 84 + 48, &first, 2);
    std::memcpy(bytes.data() + 84 + 98, &second, 2);
    return parse(bytes);
  };
  const MeshFile coloured = withAttributes("by Magics COLOR=\x01\x02\x03\x04 more", 31 | (1 << 5), 0x8000);
  EXPECT_EQ(coloured.triangleColours, (std::vector<Colour>{{255, 8, 0}, {1, 2, 3, 4}}));
  EXPECT_TRUE(coloured.notes.empty());
  const MeshFile unsaid = withAttributes("by somebody", 0x8000 | 31, 0);
  EXPECT_TRUE(unsaid.triangleColours.empty());
  ASSERT_EQ(unsaid.notes.size(), 1u);
  EXPECT_NE(unsaid.notes[0].find("attribute bytes of 1 triangles"), std::string::npos);
  EXPECT_TRUE(withAttributes(std::string(72, '.') + "COLOR=xx", 1, 1).triangleColours.empty())
      << "the colour is cut off";
}

}  // namespace
}  // namespace argil::io
