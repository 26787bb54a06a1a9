// Pictures on models: where their pixels lie, what is multiplied, what lies beyond their edges, and what is wrong with
// them. Right colours are computed from the picture and the places alone.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "clay/mesh/nearest_triangle.h"
#include "io/models/colour_list.h"
#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/package_samples.h"
#include "tests/support/textured_samples.h"

namespace argil::io {
namespace {

using nlohmann::json;
using samples::checkColour;
using samples::Rgba;
using samples::TexturedCube;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kEpsilon = 1e-9;  // mm, off a plane

// Finds the triangle that a point lies in and its shares of the corners.
std::pair<size_t, Vec3d> placeIn(const clay::TriangleMesh& mesh, const Vec3d& point) {
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    const Vec3d normal = (b - a).cross(c - a);
    if (std::abs((point - a).dot(normal.normalized())) > 1e-4) continue;
    Vec3d shares((b - point).cross(c - point).dot(normal), (c - point).cross(a - point).dot(normal),
                 (a - point).cross(b - point).dot(normal));
    shares /= normal.squaredNorm();
    if (shares.minCoeff() > -1e-6) return {t, shares};
  }
  ADD_FAILURE() << "no triangle has the point " << point.transpose();
  return {0, Vec3d::Constant(1.0 / 3)};
}

void expectNear(const Colour& is, const Rgba& right, int within, const std::string& where) {
  const std::array<uint8_t, 4> has{is.red, is.green, is.blue, is.alpha};
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(has[k], right[k], within) << where << " channel " << k;
}

// Looks at the middle of each of `squares`² parts of each side and compares with the right colour of its place.
void expectColours(const ModelObject& object, const TexturedCube& cube, int squares,
                   const std::function<Rgba(double u, double v)>& right) {
  ASSERT_EQ(object.places.size(), object.mesh.triangles.size());
  const PictureColours colours(object, object.mesh);
  for (const TexturedCube::Side& side : cube.sides()) {
    for (int i = 0; i < squares * squares; ++i) {
      const double across = (i % squares + 0.5) / squares, up = (i / squares + 0.5) / squares;
      const Vec3d point = side.low + across * side.across + up * side.upwards;
      const auto [triangle, shares] = placeIn(object.mesh, point);
      const auto [u, v] = cube.placeAt(side, point);
      expectNear(colours.at(triangle, shares, kEpsilon), right(u, v), 2,
                 "at " + std::to_string(u) + ", " + std::to_string(v));
    }
  }
}

// The square of the board at a place whose picture is repeated.
Rgba repeated(double u, double v) {
  const auto square = [](double part) { return int(std::floor((part - std::floor(part)) * samples::kChecks)); };
  return checkColour(square(u), samples::kChecks - 1 - square(v));
}
Rgba mirrored(double u, double v) {
  const auto within = [](double part) {
    const double turn = part - 2 * std::floor(part / 2);
    return turn < 1 ? turn : 2 - turn;
  };
  return repeated(within(u), within(v));
}
Rgba clamped(double u, double v) {
  const auto within = [](double part) { return std::min(std::max(part, 0.0), 1 - 1e-9); };
  return repeated(within(u), within(v));
}

Rgba times(const Rgba& colour, const std::array<double, 4>& factor) {
  Rgba product{};
  for (size_t k = 0; k < 3; ++k)
    product[k] = uint8_t(std::lround(255 * samples::srgbOf(factor[k] * samples::linearLight(colour[k] / 255.0))));
  product[3] = uint8_t(std::lround(factor[3] * colour[3]));
  return product;
}

ModelFile inMm(ModelFile file) {
  for (ModelObject& object : file.objects)
    for (Vec3d& p : object.mesh.positions) p *= file.unitMm.value_or(1);
  return file;
}

class Textures : public testing::Test {
 protected:
  void SetUp() override { samples::spill(folder_ / "board.png", samples::checkerPng()); }
  ModelFile readObj(const TexturedCube& cube, const std::string& material) {
    samples::spill(folder_ / "cube.mtl", "newmtl board\n" + material);
    samples::spill(folder_ / "cube.obj", cube.obj());
    return readModel(folder_ / "cube.obj");
  }
  ModelFile readGltf(const TexturedCube& cube, const json& document) {
    samples::spill(folder_ / "cube.bin", cube.bytes());
    samples::spill(folder_ / "cube.gltf", document.dump());
    return inMm(readModel(folder_ / "cube.gltf"));
  }
  // A 3MF of the cube whose texture has these attributes; `transform` places it.
  ModelFile readThreeMf(const TexturedCube& cube, const std::string& attributes, const std::string& picture,
                        const std::string& transform = "1 0 0 0 1 0 0 0 1 0 0 0") {
    std::string vertices, triangles, places;
    int first = 0;
    for (const TexturedCube::Side& side : cube.sides()) {
      for (int corner = 0; corner < 4; ++corner) {
        const Vec3d p = TexturedCube::cornerOf(side, corner);
        const auto [u, v] = cube.placeOf(corner);
        vertices += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x(), p.y(), p.z());
        places += fmt::format("<m:tex2coord u=\"{}\" v=\"{}\"/>", u, v);
      }
      for (const auto& [b, c] : {std::pair(1, 2), std::pair(2, 3)})
        triangles +=
            fmt::format("<triangle v1=\"{0}\" v2=\"{1}\" v3=\"{2}\" pid=\"2\" p1=\"{0}\" p2=\"{1}\" p3=\"{2}\"/>",
                        first, first + b, first + c);
      first += 4;
    }
    const std::string inside =
        "<resources><m:texture2d id=\"1\" path=\"/3D/Textures/board.png\" contenttype=\"image/png\" " + attributes +
        "/><m:texture2dgroup id=\"2\" texid=\"1\">" + places +
        "</m:texture2dgroup><basematerials id=\"5\"><base name=\"grey\" displaycolor=\"#808080\"/></basematerials>"
        "<object id=\"3\" pid=\"5\" pindex=\"0\"><mesh><vertices>" +
        vertices + "</vertices><triangles>" + triangles +
        "</triangles></mesh></object></resources><build><item objectid=\"3\" transform=\"" + transform + "\"/></build>";
    samples::spill(folder_ / "cube.3mf",
                   samples::threeMf(inside, "unit=\"millimeter\"", {{"3D/Textures/board.png", picture}}));
    return readModel(folder_ / "cube.3mf");
  }
  // The same in one file, with the picture inside.
  ModelFile readGlb(const TexturedCube& cube, json document, const std::string& picture) {
    std::string bytes = cube.bytes();
    document["images"] = {{{"bufferView", document["bufferViews"].size()}, {"mimeType", "image/png"}}};
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", picture.size()}});
    bytes += picture;
    bytes.resize((bytes.size() + 3) / 4 * 4);
    document["buffers"] = {{{"byteLength", bytes.size()}}};
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    for (const size_t number : {size_t{2}, 28 + text.size() + bytes.size(), text.size()})
      samples::append(glb, uint32_t(number));
    glb += "JSON" + text;
    samples::append(glb, uint32_t(bytes.size()));
    glb += std::string("BIN\0", 4) + bytes;
    samples::spill(folder_ / "cube.glb", glb);
    return inMm(readModel(folder_ / "cube.glb"));
  }
  const samples::Folder folder_;
};

TEST_F(Textures, EachPointOfAnObjHasTheColourOfItsPicture) {
  const TexturedCube cube;
  const ModelFile file = readObj(cube, "Kd 1 1 1\nmap_Kd board.png\n");
  EXPECT_THAT(file.notes, IsEmpty());
  ASSERT_EQ(file.objects.size(), 1u);
  expectColours(file.objects[0], cube, 12, repeated);
}

TEST_F(Textures, EachPointOfAGltfHasTheColourOfItsPicture) {
  const TexturedCube cube;
  const ModelFile file = readGltf(cube, TexturedCube::gltf());
  EXPECT_THAT(file.notes, IsEmpty());
  expectColours(file.objects.at(0), cube, 12, repeated);
  const ModelFile glb = readGlb(cube, TexturedCube::gltf(), samples::checkerPng());
  EXPECT_THAT(glb.notes, IsEmpty());
  expectColours(glb.objects.at(0), cube, 12, repeated);
}

TEST_F(Textures, EachPointOfA3mfHasTheColourOfItsPicture) {
  const TexturedCube cube;
  const ModelFile file = readThreeMf(cube, "", samples::checkerPng());
  EXPECT_THAT(file.notes, IsEmpty());
  expectColours(file.objects.at(0), cube, 12, repeated);
  // Mirrored in x: what was at x is at -x.
  const ModelFile mirror = readThreeMf(cube, "", samples::checkerPng(), "-1 0 0 0 1 0 0 0 1 0 0 0");
  ModelObject back = mirror.objects.at(0);
  for (Vec3d& p : back.mesh.positions) p.x() = -p.x();
  for (size_t t = 0; t < back.mesh.triangles.size(); ++t) {
    std::swap(back.mesh.triangles[t][0], back.mesh.triangles[t][2]);
    std::swap(back.places[t].corners[0], back.places[t].corners[2]);
  }
  expectColours(back, cube, 12, repeated);
  const TexturedCube moved{.times = {3, 3}, .from = {-1.25, -0.75}};
  expectColours(readThreeMf(moved, "", samples::checkerPng()).objects.at(0), moved, 24, repeated);
  const auto styled = [&](const std::string& u, const std::string& v) {
    return readThreeMf(moved, "tilestyleu=\"" + u + "\" tilestylev=\"" + v + "\"", samples::checkerPng()).objects.at(0);
  };
  expectColours(styled("wrap", "wrap"), moved, 24, repeated);
  expectColours(styled("mirror", "mirror"), moved, 24, mirrored);
  expectColours(styled("clamp", "clamp"), moved, 24, clamped);
  expectColours(styled("none", "none"), moved, 24, clamped);
}

TEST_F(Textures, PicturesOfA3mfThatCannotBeReadAreNoted) {
  const TexturedCube cube;
  const std::string whole = samples::checkerPng();
  for (const std::string& picture : {std::string("text"), whole.substr(0, whole.size() / 2), std::string()}) {
    const ModelFile file = readThreeMf(cube, "", picture);
    EXPECT_THAT(file.notes, testing::ElementsAre(HasSubstr("the picture \"/3D/Textures/board.png\" was left out")));
    EXPECT_TRUE(file.objects.at(0).places.empty() && file.objects[0].pictures.empty());
    EXPECT_EQ(file.objects[0].colour, (Colour{128, 128, 128, 255}));
    EXPECT_EQ(file.objects[0].mesh.triangles.size(), 12u);
  }
}

// Beyond the edges a picture is repeated, mirrored or goes on as it ends, along each edge by itself.
TEST_F(Textures, PicturesAreRepeatedMirroredOrClamped) {
  const TexturedCube cube{.times = {3, 3}, .from = {-1.25, -0.75}};
  expectColours(readObj(cube, "map_Kd board.png\n").objects.at(0), cube, 24, repeated);
  expectColours(readObj(cube, "map_Kd -clamp on board.png\n").objects.at(0), cube, 24, clamped);
  expectColours(readObj(cube, "map_Kd -clamp off board.png\n").objects.at(0), cube, 24, repeated);
  const auto wrapped = [&](int u, int v) {
    json document = TexturedCube::gltf();
    document["samplers"] = {{{"wrapS", u}, {"wrapT", v}}};
    return readGltf(cube, document);
  };
  constexpr int kRepeat = 10497, kMirror = 33648, kClamp = 33071;
  expectColours(wrapped(kRepeat, kRepeat).objects.at(0), cube, 24, repeated);
  expectColours(wrapped(kMirror, kMirror).objects.at(0), cube, 24, mirrored);
  expectColours(wrapped(kClamp, kClamp).objects.at(0), cube, 24, clamped);
  // glTF's v runs the other way, which changes where mirrors lie: at whole numbers all the same.
  expectColours(wrapped(kMirror, kClamp).objects.at(0), cube, 24, [](double u, double v) {
    return mirrored(u, clamped(0, v) == clamped(0, 0.1) ? 0.1 : v < 0 ? 0.1 : std::min(v, 0.9));
  });
}

TEST_F(Textures, FactorsOfMaterialsMultiplyAsLight) {
  const TexturedCube cube;
  const std::array<double, 4> half{0.5, 0.25, 1, 1};
  json document = TexturedCube::gltf();
  document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = half;
  expectColours(readGltf(cube, document).objects.at(0), cube, 8,
                [&](double u, double v) { return times(repeated(u, v), half); });
  // Kd is sRGB, and black means the picture alone.
  expectColours(readObj(cube, "Kd 0.6 1 0.2\nmap_Kd board.png\n").objects.at(0), cube, 8, [](double u, double v) {
    return times(repeated(u, v), {samples::linearLight(153 / 255.0), 1, samples::linearLight(51 / 255.0), 1});
  });
  expectColours(readObj(cube, "Kd 0 0 0\nmap_Kd board.png\n").objects.at(0), cube, 8, repeated);
  // Colours of vertices multiply too: here one for all of them.
  document = TexturedCube::gltf();
  document["accessors"].push_back({{"bufferView", 3}, {"componentType", 5126}, {"count", 24}, {"type", "VEC3"}});
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 552}, {"byteLength", 288}});
  document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 3;
  document["buffers"][0]["byteLength"] = 552 + 288;
  std::string bytes = cube.bytes();
  for (int i = 0; i < 24; ++i)
    for (const float part : {1.0f, 0.25f, 0.5f}) samples::append(bytes, part);
  samples::spill(folder_ / "cube.bin", bytes);
  samples::spill(folder_ / "cube.gltf", document.dump());
  // Colours of vertices are kept as sRGB of 8 bits.
  expectColours(inMm(readModel(folder_ / "cube.gltf")).objects.at(0), cube, 8, [](double u, double v) {
    return times(repeated(u, v), {1, 0.25, 0.5, 1});
  });
}

TEST_F(Textures, AlphaCountsAsTheMaterialSays) {
  const TexturedCube cube;
  const auto alphaOf = [](int x) { return uint8_t(x < 32 ? 60 : 200); };
  samples::spill(folder_ / "board.png", samples::pngOf(64, 64, [&](int x, int) {
                   return Rgba{250, 100, 50, alphaOf(x)};
                 }));
  const auto at = [&](uint8_t left, uint8_t right) {
    return [=](double u, double) { return Rgba{250, 100, 50, u < 0.5 ? left : right}; };
  };
  const auto alphaMode = [&](const json& material) {
    json document = TexturedCube::gltf();
    document["materials"][0].update(material);
    return readGltf(cube, document).objects.at(0);
  };
  const auto alphas = [&](const ModelObject& object, uint8_t left, uint8_t right) {
    const PictureColours colours(object, object.mesh);
    for (const TexturedCube::Side& side : cube.sides())
      for (const double across : {0.25, 0.75}) {
        const Vec3d point = side.low + across * side.across + 0.4 * side.upwards;
        const auto [triangle, shares] = placeIn(object.mesh, point);
        EXPECT_NEAR(colours.at(triangle, shares, kEpsilon).alpha, across < 0.5 ? left : right, 2);
      }
  };
  expectColours(alphaMode({{"alphaMode", "OPAQUE"}}), cube, 8, at(255, 255));
  expectColours(alphaMode(json::object()), cube, 8, at(255, 255));
  expectColours(alphaMode({{"alphaMode", "BLEND"}}), cube, 8, at(60, 200));
  alphas(alphaMode({{"alphaMode", "MASK"}}), 0, 255);
  alphas(alphaMode({{"alphaMode", "MASK"}, {"alphaCutoff", 0.1}}), 255, 255);
  alphas(alphaMode({{"alphaMode", "MASK"}, {"alphaCutoff", 0.9}}), 0, 0);
  expectColours(readObj(cube, "map_Kd board.png\n").objects.at(0), cube, 8, at(60, 200));
  expectColours(readObj(cube, "d 0.5\nmap_Kd board.png\n").objects.at(0), cube, 8, at(30, 100));
}

// Scaled and moved: by options of the material in OBJ, by KHR_texture_transform in glTF.
TEST_F(Textures, PicturesAreMovedAsTheMaterialSays) {
  const TexturedCube cube;
  expectColours(readObj(cube, "map_Kd -s 2 3 1 -o 0.25 0.5 0 board.png\n").objects.at(0), cube, 24,
                [](double u, double v) { return repeated(2 * u + 0.25, 3 * v + 0.5); });
  json document = TexturedCube::gltf();
  document["extensionsUsed"] = {"KHR_texture_transform"};
  auto& picture = document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  picture["extensions"]["KHR_texture_transform"] = {{"scale", {2, 3}}, {"offset", {0.25, 0.5}}};
  expectColours(readGltf(cube, document).objects.at(0), cube, 24,
                [](double u, double v) { return repeated(2 * u + 0.25, 1 - (3 * (1 - v) + 0.5)); });
  // The extension's own matrix: u' = cos u + sin v, v' = -sin u + cos v, in glTF's own v.
  picture["extensions"]["KHR_texture_transform"] = {{"rotation", M_PI / 2}};
  expectColours(readGltf(cube, document).objects.at(0), cube, 24,
                [](double u, double v) { return repeated(1 - v, 1 - -u); });
}

TEST_F(Textures, NamesOfPicturesAreFoundAsTheyAreMeant) {
  const TexturedCube cube;
  std::filesystem::create_directory(folder_ / "maps of it");
  std::filesystem::rename(folder_ / "board.png", folder_ / "maps of it" / "the board.png");
  for (const char* name : {"maps of it/the board.png", "maps of it\\the board.png", "./maps of it/the board.png  "}) {
    const ModelFile file = readObj(cube, std::string("map_Kd ") + name + "\n");
    EXPECT_THAT(file.notes, IsEmpty()) << name;
    expectColours(file.objects.at(0), cube, 4, repeated);
  }
  json document = TexturedCube::gltf();
  document["images"] = {{{"uri", "maps%20of%20it/the%20board.png"}}};
  expectColours(readGltf(cube, document).objects.at(0), cube, 4, repeated);
  std::filesystem::rename(folder_ / "maps of it" / "the board.png", folder_ / "board.png");
  for (const char* name : {"C:\\work\\maps\\board.png", "/home/other/maps/board.png"}) {
    const ModelFile file = readObj(cube, std::string("map_Kd ") + name + "\n");
    EXPECT_THAT(file.notes, IsEmpty()) << name;
    expectColours(file.objects.at(0), cube, 4, repeated);
  }
}

// Nothing of a picture is worse than a note; the surface has the material's colour then.
TEST_F(Textures, PicturesThatCannotBeReadAreNoted) {
  const TexturedCube cube;
  const std::string whole = samples::checkerPng();
  std::string huge = whole;
  huge.replace(16, 8, std::string("\x00\x01\x86\xa0\x00\x01\x86\xa0", 8));  // 100 000 pixels along each edge
  std::filesystem::create_directory(folder_ / "folder.png");
  ASSERT_EQ(::mkfifo((folder_ / "pipe.png").c_str(), 0600), 0);
  samples::spill(folder_ / "empty.png", "");
  samples::spill(folder_ / "text.png", "no picture at all");
  samples::spill(folder_ / "half.png", whole.substr(0, whole.size() / 2));
  samples::spill(folder_ / "huge.png", huge);
  std::filesystem::create_directory(folder_ / "in");
  const Colour grey{128, 128, 128, 255};
  for (const char* name : {"missing.png", "folder.png", "pipe.png", "empty.png", "text.png", "half.png", "huge.png",
                           "../board.png", "/dev/zero"}) {
    samples::spill(folder_ / "in" / "board.png", "");
    const ModelFile file = readObj(cube, std::string("Kd 0.5 0.5 0.5\nmap_Kd ") + name + "\n");
    if (std::string(name) == "../board.png") {
      EXPECT_THAT(file.notes, IsEmpty()) << "its last name lies in the folder";
      continue;
    }
    EXPECT_THAT(file.notes, testing::ElementsAre(HasSubstr("picture"))) << name;
    ASSERT_EQ(file.objects.size(), 1u);
    EXPECT_EQ(file.objects[0].mesh.triangles.size(), 12u);
    EXPECT_TRUE(file.objects[0].places.empty());
    EXPECT_EQ(file.objects[0].colour, grey) << name;
  }
  for (const std::string& picture : {std::string("text"), whole.substr(0, whole.size() / 2), huge, std::string()}) {
    json document = TexturedCube::gltf();
    document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.2158605, 0.2158605, 0.2158605, 1};
    const ModelFile file = readGlb(cube, document, picture);
    EXPECT_THAT(file.notes, testing::ElementsAre(HasSubstr("picture"))) << picture.size();
    EXPECT_EQ(file.objects.at(0).mesh.triangles.size(), 12u);
    EXPECT_TRUE(file.objects[0].places.empty());
    EXPECT_EQ(file.objects[0].colour, grey);
  }
  for (const char* wrong :
       {R"({"images":[{"uri":"missing.png"}]})", R"({"images":[{"uri":"../board.png"}]})", R"({"images":[{}]})",
        R"({"images":[{"uri":"https://example.com/a.png"}]})", R"({"images":[{"uri":"data:image/png;base64,!!"}]})",
        R"({"images":[{"bufferView":9}]})", R"({"images":[]})", R"({"textures":[{"source":7}]})", R"({"textures":[]})",
        R"({"textures":[{"sampler":0}]})", R"({"textures":[{"source":0,"sampler":5}]})"}) {
    json document = TexturedCube::gltf();
    document.update(json::parse(wrong));
    const ModelFile file = readGltf(cube, document);
    EXPECT_THAT(file.notes, testing::ElementsAre(HasSubstr("picture"))) << wrong;
    EXPECT_EQ(file.objects.at(0).mesh.triangles.size(), 12u) << wrong;
    EXPECT_TRUE(file.objects[0].places.empty()) << wrong;
  }
  json document = TexturedCube::gltf();
  document["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  EXPECT_THAT(readGltf(cube, document).notes, testing::ElementsAre(HasSubstr("no places on it")));
}

// A material that names a picture and no colour has none once the picture is not there.
TEST_F(Textures, NoColourIsInventedForAPictureThatIsMissing) {
  const ModelFile file = readObj(TexturedCube(), "map_Kd missing.png\n");
  ASSERT_EQ(file.objects.size(), 1u);
  EXPECT_EQ(file.objects[0].colour, std::nullopt);
  EXPECT_TRUE(file.objects[0].triangleColours.empty() && file.objects[0].vertexColours.empty());
}

// Two objects, of which one has a picture: each keeps its own, together and apart.
TEST_F(Textures, ObjectsKeepTheirPictures) {
  const TexturedCube cube;
  samples::spill(folder_ / "cube.mtl", "newmtl board\nmap_Kd board.png\nnewmtl red\nKd 1 0 0\n");
  std::string text = "o first\n" + cube.obj() + "o second\nusemtl red\n";
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(40 + 2 * (i & 1)) + " " + std::to_string(i & 2) + " " + std::to_string((i & 4) / 2) +
            "\n";
  for (const auto& [a, b, c] : samples::cube().triangles)
    text += "f " + std::to_string(25 + a) + " " + std::to_string(25 + b) + " " + std::to_string(25 + c) + "\n";
  samples::spill(folder_ / "cube.obj", text);
  ModelFile file = readModel(folder_ / "cube.obj");
  ASSERT_EQ(file.objects.size(), 2u);
  EXPECT_TRUE(file.objects[1].places.empty());
  EXPECT_EQ(file.objects[1].colour, (Colour{255, 0, 0, 255}));
  expectColours(file.objects[0], cube, 8, repeated);
  const ModelObject all = merged(std::move(file.objects));
  expectColours(all, cube, 8, repeated);
  const PictureColours colours(all, all.mesh);
  EXPECT_EQ(colours.at(14, Vec3d::Constant(1.0 / 3), kEpsilon), (Colour{255, 0, 0, 255}));
}

// Wider than its squares, a place has the mean light of them: that of two greys that alternate pixel by pixel.
TEST_F(Textures, WidePlacesHaveTheMeanLight) {
  const TexturedCube cube;
  samples::spill(folder_ / "board.png", samples::pngOf(64, 64, [](int x, int y) {
                   const uint8_t grey = (x + y) % 2 == 0 ? 240 : 20;
                   return Rgba{grey, grey, grey, 255};
                 }));
  const ModelObject object = readObj(cube, "map_Kd board.png\n").objects.at(0);
  const double mean = (samples::linearLight(240 / 255.0) + samples::linearLight(20 / 255.0)) / 2;
  const auto right = uint8_t(std::lround(255 * samples::srgbOf(mean)));
  const PictureColours colours(object, object.mesh);
  for (size_t t = 0; t < object.mesh.triangles.size(); ++t)
    expectNear(colours.at(t, Vec3d(0.5, 0.3, 0.2), 2), {right, right, right, 255}, 2, "triangle");
  EXPECT_NEAR(meanColour(object)->red, right, 2);
}

// A picture that differs from corner to corner becomes colours of vertices, whose seams become vertices of their own.
TEST_F(Textures, PicturesBecomeColoursOfVertices) {
  const TexturedCube cube;
  ModelObject object = readObj(cube, "map_Kd board.png\n").objects.at(0);
  const double area = 6 * 16 * 16;
  picturesToVertices(object);
  EXPECT_TRUE(object.places.empty() && object.pictures.empty());
  double sum = 0;
  for (const auto& [a, b, c] : object.mesh.triangles)
    sum += (object.mesh.positions[b] - object.mesh.positions[a])
               .cross(object.mesh.positions[c] - object.mesh.positions[a])
               .norm() /
           2;
  EXPECT_NEAR(sum, area, 1e-6);
  EXPECT_TRUE(!object.vertexColours.empty() || !object.triangleColours.empty());
}

}  // namespace
}  // namespace argil::io
