// glTF in both directions: files of others, files written by hand, and what was written read back by tinygltf with
// Draco.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"
#include "tests/unit/io/gltf_peer.h"

namespace argil::io {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

std::filesystem::path dataFile(const char* name) {
  const char* root = std::getenv("ARGIL_DATA");
  return root == nullptr ? std::filesystem::path() : std::filesystem::path(root) / "gltf" / name;
}

uint64_t trianglesOf(const ModelFile& model) {
  uint64_t count = 0;
  for (const ModelObject& object : model.objects) count += object.mesh.triangles.size();
  return count;
}

/// A .gltf whose one buffer holds these bytes.
std::string gltf(json document, const std::string& bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kLetters[word >> (18 - 6 * k) & 63] : '=';
  }
  document["asset"] = {{"version", "2.0"}};
  document["buffers"] = {{{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + text}}};
  return document.dump();
}

/// Two triangles, a unit square in the plane z = 0 of glTF: 4 positions (48 bytes), 6 short indices (12 bytes).
std::string squareBytes() {
  std::string bytes;
  for (const float v : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) samples::append(bytes, v);
  for (const uint16_t i : {0, 1, 2, 0, 2, 3}) samples::append(bytes, i);
  return bytes;
}

json square() {
  return json::parse(R"({"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"sheet"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}]})");
}

class Gltf : public testing::Test {
 protected:
  ModelFile read(const json& document, const std::string& bytes = squareBytes()) {
    samples::spill(folder_ / "a.gltf", gltf(document, bytes));
    return readModel(folder_ / "a.gltf");
  }
  std::string refusal(const json& document, const std::string& bytes = squareBytes()) {
    return samples::errorOf([&] { static_cast<void>(read(document, bytes)); });
  }
  samples::Folder folder_;
};

TEST_F(Gltf, SquareStandsUpright) {
  const ModelFile model = read(square());
  ASSERT_EQ(model.objects.size(), 1u);
  EXPECT_EQ(model.format, "glTF (text)");
  EXPECT_EQ(model.unitMm, 1000);
  const ModelObject& object = model.objects[0];
  EXPECT_EQ(object.name, "sheet");
  EXPECT_THAT(object.mesh.positions,
              testing::ElementsAre(Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(1, 0, 1), Vec3d(0, 0, 1)));
  EXPECT_FALSE(object.colour);
}

TEST_F(Gltf, NodesPlaceAndMirrorsTurnTriangles) {
  json document = square();
  document["scenes"][0]["nodes"] = {1};
  document["nodes"][0] = {{"mesh", 0}, {"scale", {-2, 1, 1}}};
  document["nodes"].push_back(
      {{"children", {0}}, {"translation", {10, 0, 0}}, {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
  const ModelFile model = read(document);
  const clay::TriangleMesh& mesh = model.objects[0].mesh;
  // (1, 0, 0) scaled to (-2, 0, 0), turned by 90° about z to (0, -2, 0), moved to (10, -2, 0): ours is (10, 0, -2).
  EXPECT_LT((mesh.positions[1] - Vec3d(10, 0, -2)).norm(), 1e-12);
  EXPECT_EQ(mesh.triangles[0], (std::array<uint32_t, 3>{0, 2, 1}));

  document["nodes"][0] = {{"mesh", 0}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}};
  document["scenes"][0]["nodes"] = {0};
  const ModelFile byMatrix = read(document);
  EXPECT_LT((byMatrix.objects[0].mesh.positions[1] - Vec3d(4, -7, 6)).norm(), 1e-12);
  EXPECT_EQ(byMatrix.objects[0].mesh.triangles[0], (std::array<uint32_t, 3>{0, 2, 1}));
  // Programs multiply matrices in 32 bits.
  document["nodes"][0]["matrix"][15] = 0.99999994;
  EXPECT_LT((read(document).objects[0].mesh.positions[1] - Vec3d(4, -7, 6)).norm(), 1e-12);
  document["nodes"][0]["matrix"][15] = 0.5;
  EXPECT_THAT(refusal(document), HasSubstr("perspective"));
}

TEST_F(Gltf, StripsFansAndUnindexed) {
  json document = square();
  document["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 0}}}, {"mode", 5}};
  EXPECT_EQ(read(document).objects[0].mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {1, 3, 2}}));
  document["meshes"][0]["primitives"][0]["mode"] = 6;
  EXPECT_EQ(read(document).objects[0].mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{1, 2, 0}, {2, 3, 0}}));
  document["meshes"][0]["primitives"][0]["mode"] = 1;
  EXPECT_THAT(refusal(document), HasSubstr("holds no triangles (read as glTF; points and lines are not kept)"));
}

TEST_F(Gltf, SparseAndQuantizedPositions) {
  json document = square();
  std::string bytes = squareBytes();  // 60 bytes
  for (const int index : {1, 2}) samples::append(bytes, uint8_t(index));
  bytes.append(2, '\0');
  for (const float v : {4.f, 5.f, 6.f, 7.f, 8.f, 9.f}) samples::append(bytes, v);
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 60}, {"byteLength", 2}});
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 64}, {"byteLength", 24}});
  document["accessors"][0]["sparse"] = {
      {"count", 2}, {"indices", {{"bufferView", 2}, {"componentType", 5121}}}, {"values", {{"bufferView", 3}}}};
  EXPECT_EQ(read(document, bytes).objects[0].mesh.positions[1], Vec3d(4, -6, 5));
  EXPECT_EQ(read(document, bytes).objects[0].mesh.positions[2], Vec3d(7, -9, 8));
  for (const int wrong : {5120, 5122, 5126}) {
    document["accessors"][0]["sparse"]["indices"]["componentType"] = wrong;
    EXPECT_THAT(refusal(document, bytes), HasSubstr("sparse indices of a wrong type")) << wrong;
  }
  document["accessors"][0]["sparse"]["indices"]["componentType"] = 5121;
  bytes[61] = 4;
  EXPECT_THAT(refusal(document, bytes), HasSubstr("changes an element that is not there"));
  bytes[61] = 2;
  // Of two changes of one vertex the last one counts.
  bytes[61] = bytes[60];
  EXPECT_EQ(read(document, bytes).objects[0].mesh.positions[1], Vec3d(7, -9, 8));
  bytes[61] = 2;
  // Without bytes of its own it is zero where nothing changes it. A few bytes do not ask for gigabytes.
  document["accessors"][0].erase("bufferView");
  EXPECT_THAT(read(document, bytes).objects[0].mesh.positions,
              testing::ElementsAre(Vec3d(0, 0, 0), Vec3d(4, -6, 5), Vec3d(7, -9, 8)));
  document["accessors"][0]["count"] = 200'000'000;
  EXPECT_THAT(refusal(document, bytes), HasSubstr("announces 200000000 elements"));
  document["accessors"][0].erase("sparse");
  EXPECT_THAT(refusal(document, bytes), HasSubstr("accessor 0 has no data"));

  document = square();
  bytes.clear();
  for (const int v : {0, 0, 0, 0, 127, 0, 0, 0, 127, 127, 0, 0, 0, -127, 0, 0}) samples::append(bytes, int8_t(v));
  bytes += squareBytes().substr(48);
  document["accessors"][0] = {
      {"bufferView", 0}, {"componentType", 5120}, {"normalized", true}, {"count", 4}, {"type", "VEC3"}};
  document["bufferViews"] = {{{"buffer", 0}, {"byteLength", 16}, {"byteStride", 4}},
                             {{"buffer", 0}, {"byteOffset", 16}, {"byteLength", 12}}};
  document["extensionsRequired"] = {"KHR_mesh_quantization"};
  EXPECT_EQ(read(document, bytes).objects[0].mesh.positions[3], Vec3d(0, 0, -1));
}

TEST_F(Gltf, SparseIndicesOfEveryWidth) {
  for (const int width : {1, 2, 4}) {
    json document = square();
    std::string bytes = squareBytes();
    for (const uint32_t index : {1u, 3u})
      for (int i = 0; i < width; ++i) bytes += char(index >> (8 * i));
    bytes.resize(68, '\0');
    for (const float v : {4.f, 5.f, 6.f, 7.f, 8.f, 9.f}) samples::append(bytes, v);
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 60}, {"byteLength", 2 * width}});
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 68}, {"byteLength", 24}});
    document["accessors"][0]["sparse"] = {{"count", 2},
                                          {"indices",
                                           {{"bufferView", 2},
                                            {"componentType", width == 1   ? 5121
                                                              : width == 2 ? 5123
                                                                           : 5125}}},
                                          {"values", {{"bufferView", 3}}}};
    EXPECT_EQ(read(document, bytes).objects[0].mesh.positions[3], Vec3d(7, -9, 8)) << width;
  }
}

TEST_F(Gltf, Refusals) {
  json document = square();
  document["extensionsRequired"] = {"EXT_meshopt_compression"};
  EXPECT_THAT(refusal(document), HasSubstr("needs the extension EXT_meshopt_compression"));
  document = square();
  document["nodes"][0]["children"] = {0};
  EXPECT_THAT(refusal(document), HasSubstr("node 0 lies below itself"));
  document = square();
  document["accessors"][0]["count"] = 5;
  EXPECT_THAT(refusal(document), HasSubstr("reaches beyond buffer view 0"));
  document["accessors"][0]["count"] = 3;
  EXPECT_THAT(refusal(document), HasSubstr("names vertex 3 of 3"));
  document["accessors"][0]["count"] = uint64_t{1} << 62;
  EXPECT_THAT(refusal(document), HasSubstr("damaged"));
  document = square();
  document["bufferViews"][0]["byteLength"] = 61;
  EXPECT_THAT(refusal(document), HasSubstr("reaches beyond its buffer"));
  document["bufferViews"][0] = {{"buffer", 0}, {"byteOffset", uint64_t(-1)}, {"byteLength", 48}};
  EXPECT_THAT(refusal(document), HasSubstr("reaches beyond its buffer"));
  document = square();
  document["nodes"][0]["mesh"] = 3;
  EXPECT_THAT(refusal(document), HasSubstr("number 3 of its meshes"));
  document = square();
  document["nodes"][0]["matrix"] = {1, 2};
  EXPECT_THAT(refusal(document), HasSubstr("matrix is no list of 16 numbers"));
  std::string bytes = squareBytes();
  const float infinite = INFINITY;
  std::memcpy(bytes.data() + 12, &infinite, 4);
  EXPECT_THAT(refusal(square(), bytes), HasSubstr("not finite"));
  samples::spill(folder_ / "a.gltf", "{\"asset\":{\"version\":\"1.0\"}}");
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readModel(folder_ / "a.gltf")); }), HasSubstr("version 1.0"));
  samples::spill(folder_ / "a.gltf", std::string(1000000, '['));
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readModel(folder_ / "a.gltf")); }), HasSubstr("a.gltf"));
}

TEST_F(Gltf, BuffersComeFromItsFolderOnly) {
  json document = square();
  document["asset"] = {{"version", "2.0"}};
  const auto with = [&](const std::string& uri) {
    document["buffers"] = {{{"byteLength", 60}, {"uri", uri}}};
    samples::spill(folder_ / "a.gltf", document.dump());
    return folder_ / "a.gltf";
  };
  std::filesystem::create_directory(folder_ / "sub");
  samples::spill(folder_ / "sub/my data.bin", squareBytes());
  EXPECT_EQ(trianglesOf(readModel(with("sub/my%20data.bin"))), 2u);
  const auto refused = [&](const std::string& uri) {
    return samples::errorOf([&] { static_cast<void>(readModel(with(uri))); });
  };
  EXPECT_THAT(refused("other.bin"), HasSubstr("other.bin is missing"));
  EXPECT_THAT(refused("sub/../sub/my%20data.bin"), HasSubstr("outside of the file's folder"));
  EXPECT_THAT(refused("%2e%2e/x"), HasSubstr("outside of the file's folder"));
  EXPECT_THAT(refused("/etc/passwd"), HasSubstr("outside of the file's folder"));
  EXPECT_THAT(refused("https://example.com/x.bin"), HasSubstr("lies elsewhere"));
}

TEST_F(Gltf, FilesOfOthers) {
  if (dataFile("").empty()) GTEST_SKIP() << "ARGIL_DATA is not set";
  const ModelFile engine = readModel(dataFile("2CylinderEngine_draco/2CylinderEngine.gltf"));
  EXPECT_EQ(trianglesOf(engine), 110336u);  // 65 311 in its meshes, some of which stand in several places
  EXPECT_EQ(engine.format, "glTF (text, Draco)");
  const ModelFile box = readModel(dataFile("Box_Draco.glb"));
  EXPECT_EQ(trianglesOf(box), 12u);
  EXPECT_EQ(box.format, "glTF (binary, Draco)");
  EXPECT_TRUE(clay::checkTopology(box.objects[0].mesh).closed());
  const ModelFile duck = readModel(dataFile("Duck.glb"));
  EXPECT_EQ(trianglesOf(duck), 4212u);
  EXPECT_THAT(duck.notes, testing::IsEmpty());
  EXPECT_EQ(duck.objects[0].places.size(), 4212u);
  const auto report = clay::checkTopology(duck.objects[0].mesh);
  EXPECT_EQ(report.boundaryEdges, 0u);
  EXPECT_GT(report.volume, 0);
  EXPECT_GT((report.high - report.low).z(), (report.high - report.low).y() * 0.5);
  EXPECT_THAT(samples::errorOf([&] { static_cast<void>(readModel(dataFile("IndexOutOfRange/IndexOutOfRange.gltf"))); }),
              HasSubstr("names vertex 255 of 24"));
}

// Written files, read by tinygltf and Draco themselves.

/// A closed bumpy ball of n² · 2 triangles or so, in mm, away from the origin.
ModelObject ball(int n, const Vec3d& middle) {
  ModelObject object;
  clay::TriangleMesh soup;
  const auto at = [&](int i, int j) -> Vec3d {
    if (i == 0) return middle + Vec3d(0, 0, 20);
    if (i == n) return middle - Vec3d(0, 0, 20);
    const double polar = M_PI * i / n, turn = M_PI * (j % (2 * n)) / n, r = 20 + std::sin(5 * turn) * std::sin(polar);
    return middle + r * Vec3d(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < 2 * n; ++j) {
      for (const auto& corners : {std::array<std::pair<int, int>, 3>{{{i, j}, {i + 1, j}, {i + 1, j + 1}}},
                                  {{{i, j}, {i + 1, j + 1}, {i, j + 1}}}}) {
        if ((i == 0 && corners[2].first == 0) || (i == n - 1 && corners[2].first == n)) {
          if (corners[1].first == corners[2].first ? i == n - 1 : i == 0) continue;
        }
        const auto first = uint32_t(soup.positions.size());
        for (const auto& [p, q] : corners) soup.positions.push_back(at(p, q));
        soup.triangles.push_back({first, first + 1, first + 2});
      }
    }
  }
  object.mesh = clay::weldExact(soup);
  return object;
}

std::vector<ModelObject> twoBalls() {
  std::vector<ModelObject> objects = {ball(24, {100, -50, 30}), ball(12, {0, 0, 5000})};
  objects[0].name = "first \xc3\xb6";
  objects[0].colour = Colour{200, 100, 3, 128};
  objects[1].name = "second";
  for (size_t i = 0; i < objects[1].mesh.positions.size(); ++i)
    objects[1].vertexColours.push_back({uint8_t(i), uint8_t(i / 3), uint8_t(255 - i % 256), 255});
  return objects;
}

/// Each vertex of the peer's is near one of ours, with its colour, and triangles join the same places.
void expectSame(const ModelObject& ours, const PeerObject& peer, double within) {
  EXPECT_EQ(ours.name, peer.name);
  ASSERT_EQ(ours.mesh.triangles.size(), peer.triangles.size());
  std::map<std::array<long, 3>, std::vector<uint32_t>> cells;
  const double edge = std::max(4 * within, 1e-6);
  const auto cellOf = [&](const Vec3d& p) {
    return std::array<long, 3>{std::lround(p.x() / edge), std::lround(p.y() / edge), std::lround(p.z() / edge)};
  };
  for (uint32_t i = 0; i < ours.mesh.positions.size(); ++i) cells[cellOf(ours.mesh.positions[i])].push_back(i);
  std::vector<uint32_t> match(peer.positionsMm.size(), UINT32_MAX);
  for (size_t i = 0; i < peer.positionsMm.size(); ++i) {
    const auto cell = cellOf(peer.positionsMm[i]);
    for (long d = 0; d < 27; ++d) {
      const auto near = cells.find({cell[0] + d % 3 - 1, cell[1] + d / 3 % 3 - 1, cell[2] + d / 9 - 1});
      if (near == cells.end()) continue;
      for (const uint32_t j : near->second) {
        if ((ours.mesh.positions[j] - peer.positionsMm[i]).norm() <= within * (1 + 1e-9) + 1e-12) match[i] = j;
      }
    }
    ASSERT_NE(match[i], UINT32_MAX) << "vertex " << i << " is not near one of ours";
    if (!ours.vertexColours.empty()) {
      const Colour& c = ours.vertexColours[match[i]];
      EXPECT_EQ(peer.colours.at(i), (std::array<uint8_t, 4>{c.red, c.green, c.blue, c.alpha}));
    }
  }
  const auto turned = [](std::array<uint32_t, 3> t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
  };
  std::vector<std::array<uint32_t, 3>> a, b;
  for (const auto& t : ours.mesh.triangles) a.push_back(turned(t));
  for (const auto& t : peer.triangles) b.push_back(turned({match[t[0]], match[t[1]], match[t[2]]}));
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  EXPECT_TRUE(a == b);
  if (ours.colour) {
    EXPECT_EQ(peer.baseColour,
              (std::array<uint8_t, 4>{ours.colour->red, ours.colour->green, ours.colour->blue, ours.colour->alpha}));
  }
}

/// Lit as clay is: a dull material, and normals that are those of the triangles around, to the bend of the surface.
void expectMatt(const PeerObject& peer) {
  EXPECT_TRUE(peer.material);
  EXPECT_EQ(peer.metallic, 0);
  EXPECT_EQ(peer.roughness, 1);
  ASSERT_EQ(peer.normals.size(), peer.positionsMm.size());
  for (const auto& [a, b, c] : peer.triangles) {
    const Vec3d facing =
        (peer.positionsMm[b] - peer.positionsMm[a]).cross(peer.positionsMm[c] - peer.positionsMm[a]).normalized();
    for (const uint32_t corner : {a, b, c}) {
      ASSERT_NEAR(peer.normals[corner].norm(), 1, 0.005);
      ASSERT_GT(peer.normals[corner].dot(facing), 0.75);
    }
  }
}

class GltfWritten : public testing::TestWithParam<std::pair<const char*, bool>> {};

TEST_P(GltfWritten, PeerAndWeReadTheSame) {
  const auto [name, draco] = GetParam();
  const samples::Folder folder;
  const auto path = folder / name;
  const std::vector<ModelObject> objects = twoBalls();
  WriteOptions options;
  options.draco = draco;
  const WriteReport report = writeModel(path, {objects, {{"Title", "Two balls"}}}, options);
  EXPECT_EQ(report.bytes, std::filesystem::file_size(path));
  EXPECT_EQ(report.triangles, objects[0].mesh.triangles.size() + objects[1].mesh.triangles.size());
  EXPECT_EQ(folder.entries(), 1u);
  // 16 bits over 42 mm: half a step in each coordinate at most.
  const double within = draco ? report.deviation : std::sqrt(3.0) * report.rounding;
  EXPECT_LT(within, draco ? std::sqrt(3.0) * 42 / 65535 / 2 * 1.02 : 1e-5);
  EXPECT_GT(within, 0);

  const std::vector<PeerObject> peers = readByPeer(path);
  ASSERT_EQ(peers.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    expectSame(objects[i], peers[i], within);
    expectMatt(peers[i]);
  }
  // Only what was asked for shuts other programs out.
  EXPECT_EQ(requiredByPeer(path),
            draco ? std::vector<std::string>{"KHR_draco_mesh_compression"} : std::vector<std::string>{});

  const ModelFile again = readModel(path);
  ASSERT_EQ(again.objects.size(), 2u);
  EXPECT_EQ(again.unitMm, 1000);
  EXPECT_THAT(again.metadata, Contains(std::pair<std::string, std::string>("Title", "Two balls")));
  for (size_t i = 0; i < 2; ++i) {
    PeerObject peer;
    peer.name = again.objects[i].name;
    for (const Vec3d& p : again.objects[i].mesh.positions) peer.positionsMm.push_back(1000 * p);
    peer.triangles = again.objects[i].mesh.triangles;
    for (const Colour& c : again.objects[i].vertexColours) peer.colours.push_back({c.red, c.green, c.blue, c.alpha});
    if (const auto& c = again.objects[i].colour) peer.baseColour = {c->red, c->green, c->blue, c->alpha};
    expectSame(objects[i], peer, within);
    EXPECT_TRUE(clay::checkTopology(again.objects[i].mesh).closed());
  }
}

INSTANTIATE_TEST_SUITE_P(All, GltfWritten,
                         testing::Values(std::pair("a.glb", true), std::pair("b.glb", false), std::pair("c.gltf", true),
                                         std::pair("d.gltf", false)));

TEST(GltfWriting, ColoursOfTrianglesComeBack) {
  const samples::Folder folder;
  ModelObject cube;
  cube.mesh = samples::cube(10);
  for (size_t i = 0; i < cube.mesh.triangles.size(); ++i)
    cube.triangleColours.push_back(i % 4 < 2 ? Colour{255, 0, 0, 255} : Colour{0, 0, 200, 255});
  for (const bool draco : {true, false}) {
    WriteOptions options;
    options.draco = draco;
    static_cast<void>(writeModel(folder / "a.glb", {{&cube, 1}, {}}, options));
    const ModelFile model = readModel(folder / "a.glb");
    const ModelObject& object = model.objects[0];
    EXPECT_TRUE(clay::checkTopology(object.mesh).closed());
    ASSERT_EQ(object.triangleColours.size(), 12u);
    EXPECT_EQ(std::count(object.triangleColours.begin(), object.triangleColours.end(), Colour{255, 0, 0, 255}), 6);
    EXPECT_EQ(std::count(object.triangleColours.begin(), object.triangleColours.end(), Colour{0, 0, 200, 255}), 6);
  }
}

// A cube's edges stay edges in the light of any viewer, and it comes back closed.
TEST(GltfWriting, CreasesAreLitAsCreases) {
  const samples::Folder folder;
  ModelObject cube;
  cube.mesh = samples::cube(10);
  for (const bool draco : {false, true}) {
    WriteOptions options;
    options.draco = draco;
    static_cast<void>(writeModel(folder / "a.glb", {{&cube, 1}, {}}, options));
    const PeerObject peer = readByPeer(folder / "a.glb").at(0);
    EXPECT_EQ(peer.positionsMm.size(), 24u);
    for (const auto& [a, b, c] : peer.triangles) {
      const Vec3d facing =
          (peer.positionsMm[b] - peer.positionsMm[a]).cross(peer.positionsMm[c] - peer.positionsMm[a]).normalized();
      for (const uint32_t corner : {a, b, c}) EXPECT_GT(peer.normals.at(corner).dot(facing), 0.9999);
    }
    const ModelObject again = readModel(folder / "a.glb").objects.at(0);
    EXPECT_EQ(again.mesh.positions.size(), 8u);
    EXPECT_TRUE(clay::checkTopology(again.mesh).closed());
    EXPECT_FALSE(again.colour) << "white was not asked for";
  }
}

// A row of three, the second turned and the third three times as large.
TEST_F(Gltf, InstancesArePlaced) {
  json document = square();
  std::string bytes = squareBytes();
  for (const float v : {0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 5.f, 0.f, 0.f}) samples::append(bytes, v);
  for (const float v : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 1.f}) samples::append(bytes, v);
  for (const float v : {1.f, 1.f, 1.f, 1.f, 1.f, 1.f, 3.f, 3.f, 3.f}) samples::append(bytes, v);
  for (const auto& [offset, length] : {std::pair{60, 36}, {96, 48}, {144, 36}})
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
  for (const auto& [view, type] : {std::pair{2, "VEC3"}, {3, "VEC4"}, {4, "VEC3"}})
    document["accessors"].push_back({{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", type}});
  const json places = {{"TRANSLATION", 2}, {"ROTATION", 3}, {"SCALE", 4}};
  document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = places;
  document["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const ModelFile model = read(document, bytes);
  ASSERT_EQ(model.objects.size(), 3u);
  const auto boxOf = [](const ModelObject& object) {
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : object.mesh.positions) box.extend(p);
    return box;
  };
  // The square of glTF's x and y is ours of x and z.
  EXPECT_EQ(boxOf(model.objects[0]).max(), Vec3d(1, 0, 1));
  EXPECT_LT((boxOf(model.objects[1]).min() - Vec3d(1, 0, -1)).norm(), 1e-9);  // Half a turn about glTF's z.
  EXPECT_LT((boxOf(model.objects[2]).max() - Vec3d(8, 0, 3)).norm(), 1e-9);
  EXPECT_EQ(model.objects[2].name, "sheet");
  // A place that is none.
  for (const size_t offset : {60, 96, 144}) {
    std::string nowhere = bytes;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(nowhere.data() + offset + 4, &nan, sizeof nan);
    EXPECT_THAT(refusal(document, nowhere), HasSubstr("instances")) << offset;
  }
  // Lists of different lengths.
  document["accessors"][3]["count"] = 2;
  EXPECT_THAT(refusal(document, bytes), HasSubstr("instances"));
}

TEST(GltfWriting, CancelLeavesTheOldFile) {
  const samples::Folder folder;
  samples::spill(folder / "a.glb", "old");
  const std::vector<ModelObject> objects = twoBalls();
  Job job;
  job.cancel();
  EXPECT_THROW(static_cast<void>(writeModel(folder / "a.glb", {objects, {}}, {}, &job)), Cancelled);
  EXPECT_EQ(samples::slurp(folder / "a.glb"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace argil::io
