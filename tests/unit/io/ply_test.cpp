#include <gtest/gtest.h>

#include <limits>

#include "io/models/mesh_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::append;
using Triangle = std::array<uint32_t, 3>;

MeshFile parse(std::string_view text, const std::string& name = "part.ply") {
  return parseMesh(samples::bytesOf(text), name);
}

constexpr const char* kTextHeader =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
constexpr const char* kTextBody = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3\n";

/// Colours between the coordinates, an element in front and one behind, lists where nobody expects them.
std::string binary(bool big, std::string_view lineEnd = "\n") {
  const std::string header =
      std::string("ply|format binary_") + (big ? "big" : "little") +
      "_endian 1.0|obj_info odd|element camera 1|property double f|property list ushort short k|"
      "element vertex 3|property uchar red|property double x|property float y|property list uchar float w|"
      "property int16 z|element face 1|property float quality|property list uint8 uint32 vertex_index|"
      "property uchar flags|element edge 2|property int a|property int b|end_header|";
  std::string bytes;
  for (const char c : header) c == '|' ? bytes += lineEnd : bytes += c;
  append(bytes, 35.0, big);
  append(bytes, uint16_t(2), big);
  append(bytes, int16_t(-1), big);
  append(bytes, int16_t(-2), big);
  for (int v = 0; v < 3; ++v) {
    append(bytes, uint8_t(10), big);
    append(bytes, v + 0.1, big);
    append(bytes, -0.5f, big);
    append(bytes, uint8_t(v), big);
    for (int i = 0; i < v; ++i) append(bytes, 1.0f, big);
    append(bytes, int16_t(-300), big);
  }
  append(bytes, 0.25f, big);
  append(bytes, uint8_t(3), big);
  for (const uint32_t i : {2u, 1u, 0u}) append(bytes, i, big);
  append(bytes, uint8_t(1), big);
  for (const int32_t i : {0, 1, 1, 2}) append(bytes, i, big);
  return bytes;
}

TEST(Ply, Text) {
  const MeshFile file = parse(std::string(kTextHeader) + kTextBody, "no-ending");
  EXPECT_EQ(file.format, "PLY (text)");
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.polygons, 1u);
}

TEST(Ply, TextWithoutALastLineEnd) {
  std::string text = std::string(kTextHeader) + kTextBody;
  text.pop_back();
  EXPECT_EQ(parse(text).mesh.triangles.size(), 3u);
}

TEST(Ply, BinaryOfEitherByteOrderWithEveryExtra) {
  for (const bool big : {false, true}) {
    for (const std::string_view lineEnd : {"\n", "\r\n", "\r"}) {
      const MeshFile file = parse(binary(big, lineEnd));
      EXPECT_EQ(file.format, "PLY (binary)");
      ASSERT_EQ(file.mesh.positions.size(), 3u);
      EXPECT_EQ(file.mesh.positions[1], Vec3d(1.1, -0.5, -300));
      EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{2, 1, 0}}));
      EXPECT_EQ(file.notes.size(), 2u);
    }
  }
}

TEST(Ply, FirstDataByteThatLooksLikeALineEndIsData) {
  // The body begins with 0x0a, the low byte of a float: after "end_header\r\n" and "end_header\n" alike.
  for (const std::string_view lineEnd : {"\n", "\r\n", "\r"}) {
    std::string bytes;
    for (const char c : std::string(
             "ply|format binary_little_endian 1.0|element vertex 3|property int x|property int y|property int z|"
             "element face 1|property list uchar uchar vertex_indices|end_header|")) {
      c == '|' ? bytes += lineEnd : bytes += c;
    }
    for (int i = 0; i < 9; ++i) append(bytes, int32_t(0x0a + i));
    for (const uint8_t i : {3, 0, 1, 2}) append(bytes, i);
    EXPECT_EQ(parse(bytes).mesh.positions[0], Vec3d(10, 11, 12));
  }
}

TEST(Ply, FacesMayComeBeforeVertices) {
  const MeshFile file = parse(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\nproperty double "
      "x\n"
      "property double y\nproperty double z\nend_header\n3 0 1 2 0 0 0 1 0 0 0 1 0");
  EXPECT_EQ(file.mesh.triangles.size(), 1u);
}

TEST(Ply, HeaderErrors) {
  const auto contains = [](const std::string& text, const char* part) {
    const std::string error = samples::errorOf([&] { parse(text); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains("pl", "begins with \"ply\"");
  contains("ply\nformat ascii 1.0\nelement vertex 3\n", "the file ends inside its header");
  contains("ply\nformat ascii 2.0\n", "PLY of version \"2.0\" is unknown");
  contains("ply\nformat utf8 1.0\n", "\"utf8\" is no format of PLY");
  contains("ply\nproperty float x\n", "line 2: a property comes before any element");
  contains("ply\nelement vertex 3\nproperty half x\n", "line 3: \"half\" is no type");
  contains("ply\nelement vertex 3\nproperty list float int x\n", "counted in fractions");
  contains("ply\nelement vertex 3\nproperty float\n", "has no name");
  contains("ply\nelement vertex -3\n", "is negative");
  contains("ply\nelement vertex lots\n", "\"lots\" stands where");
  contains("ply\nelement vertex 3\nend_header\n", "the header has no \"format\"");
  contains("ply\nformat ascii 1.0\nelement vertex 3\nend_header\n1 2 3", "has no properties");
  contains("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2 3",
           "do not have x, y and z");
  contains("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar float vertex_indices\nend_header\n3 0 1 2",
           "no list \"vertex_indices\"");
  contains("ply\nformat ascii 1.0\nsurprise\n", "\"surprise\" is no word of a PLY header");
}

TEST(Ply, CountsThatLieAreRefusedBeforeMemoryIsTaken) {
  const auto contains = [](std::string text, const char* from, const char* to, const char* part) {
    text.replace(text.find(from), std::string_view(from).size(), to);
    const std::string error = samples::errorOf([&] { parse(text); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  const std::string text = std::string(kTextHeader) + kTextBody;
  contains(text, "vertex 4", "vertex 4000000000", "announces 4000000000 of \"vertex\"");
  contains(text, "face 2", "face 9000000000000000000", "announces 9000000000000000000 of \"face\"");
  contains(binary(false), "vertex 3", "vertex 4000000000",
           "announces 4000000000 of \"vertex\", at least 16 bytes each");
  contains(binary(true), "edge 2", "edge 1000", "announces 1000 of \"edge\"");
}

TEST(Ply, BodyErrors) {
  const auto contains = [](const std::string& body, const char* part) {
    const std::string error = samples::errorOf([&] { parse(kTextHeader + body); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains("0 0 0 1 0 0 1 1 0 0 1 0\n3 0 1 4\n3 0 1 2\n", "line 12: face 0 names vertex 4 and there are 4");
  contains("0 0 0 1 0 0 1 1 0 0 1 0\n3 0 1 -1\n3 0 1 2\n", "names vertex -1");
  contains("0 0 0 1 0 0 1 1 0 0 1 0\n3 0 1 1.5\n3 0 1 2\n", "\"1.5\" stands where a whole number should");
  contains("0 0 0 1 0 0 1 1 0 0 1 0\n2 0 1\n3 0 1 2\n", "face 0 has 2 corners");
  contains("0 0 0 1 0 0 1 1 0 0 1 0\n300 0 1 2\n3 0 1 2\n", "the file ends");
  contains("0 0 0 1 0 0 1 1 nan 0 1 0\n3 0 1 2\n3 0 1 2\n", "line 11: a number is \"nan\"");
  std::string bytes = binary(false);
  bytes.resize(bytes.size() - 1);
  EXPECT_NE(samples::errorOf([&] { parse(bytes); }).find("bytes are left"), std::string::npos);
}

TEST(Ply, BinaryCoordinatesMustBeFinite) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
  for (int i = 0; i < 9; ++i) append(bytes, i == 4 ? std::numeric_limits<float>::infinity() : float(i), true);
  for (const uint8_t i : {3, 0, 1, 2}) append(bytes, i);
  const std::string error = samples::errorOf([&] { parse(bytes); });
  EXPECT_NE(error.find("vertex 1 has a coordinate that is not finite"), std::string::npos) << error;
}

TEST(Ply, StripsOfTriangles) {
  const auto strips = [](const std::string& numbers, int count) {
    return parse(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement "
        "tristrips 1\n"
        "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n" +
        std::to_string(count) + " " + numbers + "\n");
  };
  const MeshFile file = strips("0 1 2 3 4 -1 4 3 2 -1 -1 0 1", 13);
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 2}}));
  EXPECT_EQ(file.faces, 4u);
  EXPECT_TRUE(file.notes.empty());
  // A vertex that stands twice leads on, and still turns the order.
  EXPECT_EQ(strips("0 1 2 2 3 4", 6).mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 2, 4}}));
  EXPECT_NE(samples::errorOf([&] { strips("0 1 5", 3); }).find("strip 0 names vertex 5 and there are 5"),
            std::string::npos);
  EXPECT_NE(samples::errorOf([&] { strips("0 1 -2", 3); }).find("names vertex -2"), std::string::npos);
  EXPECT_NE(samples::errorOf([&] { strips("0 1 2", 4); }).find("cut off"), std::string::npos);
  EXPECT_NE(samples::errorOf([&] { strips("0 1 2", -1); }).find("negative count"), std::string::npos);
  EXPECT_NE(samples::errorOf([&] { strips("0 1", 2); }).find("holds no triangles"), std::string::npos);
  for (const bool big : {false, true}) {
    std::string bytes =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n";
    for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0}) append(bytes, x, big);
    for (const int32_t i : {4, -1, 2, 0, 1}) append(bytes, i, big);
    EXPECT_EQ(parse(bytes).mesh.triangles, (std::vector<Triangle>{{2, 0, 1}}));
  }
}

TEST(Ply, ColoursOfVerticesAndFaces) {
  const auto coloured = [](const std::string& type, const std::string& prefix, const std::string& first,
                           const std::string& second) {
    std::string header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n";
    for (const char* part : {"red", "green", "blue", "alpha"})
      header += "property " + type + " " + prefix + part + "\n";
    return parse(header +
                 "property float y\nproperty float z\nelement face 2\nproperty uchar red\nproperty list uchar int "
                 "vertex_indices\n"
                 "property uchar green\nproperty uchar blue\nend_header\n0 " +
                 first + " 0 0\n1 " + second + " 0 0\n1 " + first + " 1 0\n9 3 0 1 2 8 7\n6 4 0 1 2 1 5 4\n");
  };
  const MeshFile bytes = coloured("uchar", "", "255 0 1 128", "0 1 0 255");
  EXPECT_EQ(bytes.vertexColours, (std::vector<Colour>{{255, 0, 1, 128}, {0, 1, 0, 255}, {255, 0, 1, 128}}));
  EXPECT_EQ(bytes.triangleColours, (std::vector<Colour>{{9, 8, 7}, {6, 5, 4}, {6, 5, 4}}));
  EXPECT_EQ(coloured("float", "diffuse_", "1 0.5 0 1", "0 0 0 0").vertexColours,
            (std::vector<Colour>{{255, 128, 0, 255}, {0, 0, 0, 0}, {255, 128, 0, 255}}));
  EXPECT_EQ(coloured("ushort", "", "65535 257 0 65535", "0 128 129 65535").vertexColours[1], (Colour{0, 0, 1, 255}));
  EXPECT_TRUE(coloured("uchar", "their_", "1 1 1 1", "1 1 1 1").vertexColours.empty());

  std::string nan =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property float red\nproperty float green\nproperty float blue\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  for (int v = 0; v < 3; ++v) {
    for (const float number : {float(v), 0.0f, 0.0f, std::numeric_limits<float>::quiet_NaN(), -1.0f, 1.0f})
      append(nan, number);
  }
  append(nan, uint8_t(3));
  for (const int32_t i : {0, 1, 2}) append(nan, i);
  EXPECT_EQ(parse(nan).vertexColours[0], (Colour{0, 0, 255}));
}

TEST(Ply, FacesWithoutColoursBesideThoseWithThemAreWhite) {
  const MeshFile file = parse(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips 1\n"
      "property list int int vertex_indices\nelement face 1\nproperty list uchar int vertex_indices\nproperty uchar "
      "red\nproperty uchar green\n"
      "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2 1 2 3\n3 0 1 2\n");
  EXPECT_EQ(file.mesh.triangles.size(), 3u);
  EXPECT_EQ(file.triangleColours, (std::vector<Colour>{{}, {1, 2, 3}, {}}));
}

}  // namespace
}  // namespace argil::io
