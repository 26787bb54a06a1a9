#include "io/models/three_mf_write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "clay/mesh/mesh_topology.h"
#include "io/bytes/zip_reader.h"
#include "io/models/model_writer.h"
#include "tests/support/lib3mf_model.h"
#include "tests/support/package_samples.h"

/// lib3mf leaves some of libzip's memory behind, even when all of its objects are released.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libzip\nleak:lib3MF\n";
}

namespace argil::io {
namespace {

using samples::errorOf;
using samples::Folder;
using samples::PeerModel;
using samples::readByLib3mf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Colour kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 128}, kGrey{10, 20, 30, 255};

/// Closed, with numbers of all lengths: n × n vertices about a torus.
clay::TriangleMesh torus(uint32_t n, double size = 40) {
  clay::TriangleMesh mesh;
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < n; ++j) {
      const double a = 2 * M_PI * i / n, b = 2 * M_PI * j / n, r = size + size / 3 * std::cos(b);
      mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), size / 3 * std::sin(b));
      const uint32_t right = i * n + (j + 1) % n, up = (i + 1) % n * n + j, both = (i + 1) % n * n + (j + 1) % n;
      mesh.triangles.push_back({i * n + j, up, both});
      mesh.triangles.push_back({i * n + j, both, right});
    }
  }
  return mesh;
}

ModelObject object(clay::TriangleMesh mesh, std::string name = {}) {
  ModelObject result;
  result.mesh = std::move(mesh);
  result.name = std::move(name);
  return result;
}

std::string modelXml(const std::filesystem::path& path) {
  const FileBytes file = readFile(path);
  const Input input{file.bytes(), "a.3mf"};
  ZipReader zip(input);
  const FileBytes part = zip.read(*zip.find("3D/3dmodel.model"));
  return {reinterpret_cast<const char*>(part.data.get()), part.size};
}

void expectSame(const PeerModel& found, std::span<const ModelObject> objects) {
  EXPECT_EQ(found.unit, NMR::MODELUNIT_MILLIMETER);
  EXPECT_THAT(found.warnings, IsEmpty());
  ASSERT_EQ(found.objects.size(), objects.size());
  for (size_t i = 0; i < objects.size(); ++i) {
    EXPECT_EQ(found.objects[i].name, objects[i].name);
    EXPECT_EQ(found.objects[i].triangles, objects[i].mesh.triangles);
    ASSERT_EQ(found.objects[i].positions.size(), objects[i].mesh.positions.size());
    for (size_t v = 0; v < objects[i].mesh.positions.size(); ++v) {
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(found.objects[i].positions[v][static_cast<size_t>(axis)],
                  static_cast<float>(objects[i].mesh.positions[v][axis]))
            << v;
      }
    }
  }
}

TEST(ThreeMfWrite, AnotherReaderFindsTheSameObjects) {
  const Folder folder;
  // More than one block of vertices and of triangles.
  const ModelObject objects[] = {object(torus(180), "a < b & \"c\" \xc3\xa4"), object(samples::cube(0.001), ""),
                                 object(samples::cube(123456.789, {1e-7, -1e5, 3}), "big")};
  const WriteReport report =
      writeModel(folder / "a.3mf", {objects, {{"Title", "T & U"}, {"Custom name", "1"}, {"Title", "second"}}});
  EXPECT_EQ(report.format, "3MF");
  EXPECT_EQ(report.triangles, 64800u + 24);
  EXPECT_GT(report.rounding, 0);
  const PeerModel found = readByLib3mf(folder / "a.3mf");
  expectSame(found, objects);
  // lib3mf leaves the entities in texts and puts namespaces in place of prefixes.
  EXPECT_THAT(found.metadata, ElementsAre(std::pair<std::string, std::string>("Application", "Argil"),
                                          std::pair<std::string, std::string>("Title", "T &amp; U; second"),
                                          std::pair<std::string, std::string>("urn:argil:Custom_name", "1")));
  EXPECT_THAT(readModel(folder / "a.3mf").metadata,
              Contains(std::pair<std::string, std::string>("Title", "T & U; second")));
}

TEST(ThreeMfWrite, NumbersOfAllSizesArriveAsTheSameFloats) {
  const Folder folder;
  std::mt19937 random(20268);
  std::uniform_real_distribution<double> exponent(-38, 8), sign(-1, 1);
  clay::TriangleMesh mesh = torus(60);
  for (Vec3d& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::copysign(std::pow(10, exponent(random)), sign(random));
  }
  mesh.positions[0] = {0, -0.0, 1e8};
  const ModelObject one[] = {object(mesh, "numbers")};
  writeModel(folder / "a.3mf", {one, {}});
  const ModelFile file = readModel(folder / "a.3mf");
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_EQ(static_cast<float>(file.objects[0].mesh.positions[v][axis]),
                static_cast<float>(mesh.positions[v][axis]));
  }
  // lib3mf keeps what is within 1e9; it reads through strtod, which rounds twice.
  const PeerModel found = readByLib3mf(folder / "a.3mf");
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto expected = static_cast<float>(mesh.positions[v][static_cast<int>(axis)]);
      ASSERT_FLOAT_EQ(found.objects[0].positions[v][axis], expected);
    }
  }
}

TEST(ThreeMfWrite, ColoursOfObjectsTrianglesAndVertices) {
  const Folder folder;
  ModelObject objects[] = {object(samples::cube(1), "plain"), object(samples::cube(2), "blue"),
                           object(samples::cube(3), "triangles"), object(samples::cube(4), "vertices"),
                           object(samples::cube(5), "grey")};
  objects[1].colour = kBlue;
  objects[4].colour = kGrey;
  objects[2].triangleColours.assign(12, kRed);
  objects[2].triangleColours[5] = kGreen;
  objects[2].triangleColours[7] = kBlue;
  objects[3].vertexColours.assign(8, kGrey);
  objects[3].vertexColours[6] = kGreen;
  writeModel(folder / "a.3mf", {objects, {}});

  const PeerModel found = readByLib3mf(folder / "a.3mf");
  expectSame(found, objects);
  EXPECT_THAT(found.materials, ElementsAre(kBlue, kGrey));
  EXPECT_THAT(found.objects[0].corners, IsEmpty());
  ASSERT_EQ(found.objects[2].corners.size(), 12u);
  ASSERT_EQ(found.objects[3].corners.size(), 12u);
  for (size_t t = 0; t < 12; ++t) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(found.objects[2].corners[t][c], objects[2].triangleColours[t]);
      EXPECT_EQ(found.objects[3].corners[t][c], objects[3].vertexColours[objects[3].mesh.triangles[t][c]]);
    }
  }

  const ModelFile file = readModel(folder / "a.3mf");
  EXPECT_THAT(file.notes, IsEmpty());
  EXPECT_FALSE(file.objects[0].colour);
  EXPECT_EQ(file.objects[1].colour, kBlue);
  EXPECT_EQ(file.objects[4].colour, kGrey);
  EXPECT_EQ(file.objects[2].triangleColours, objects[2].triangleColours);
  EXPECT_EQ(file.objects[3].vertexColours, objects[3].vertexColours);

  const std::string xml = modelXml(folder / "a.3mf");
  EXPECT_THAT(xml, HasSubstr("<base name=\"#0000FF80\" displaycolor=\"#0000FF80\"/>"));
  EXPECT_THAT(xml, HasSubstr("<object id=\"3\" type=\"model\" name=\"blue\" pid=\"1\" pindex=\"0\">"));
  EXPECT_THAT(xml, HasSubstr("<m:colorgroup id=\"4\">\n<m:color color=\"#0000FF80\"/>\n<m:color "
                             "color=\"#00FF00FF\"/>\n<m:color color=\"#FF0000FF\"/>\n</m:colorgroup>"));
  EXPECT_THAT(xml, HasSubstr("<triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"4\" p1=\"2\"/>"));
}

TEST(ThreeMfWrite, ObjectsOfOneColourShareAMaterial) {
  const Folder folder;
  ModelObject objects[] = {object(samples::cube(1)), object(samples::cube(2)), object(samples::cube(3)),
                           object(samples::cube(4))};
  const Colour colours[] = {kGrey, kBlue, kGrey, kBlue};
  for (size_t i = 0; i < 4; ++i) objects[i].colour = colours[i];
  writeModel(folder / "a.3mf", {objects, {}});
  EXPECT_THAT(readByLib3mf(folder / "a.3mf").materials, ElementsAre(kBlue, kGrey));
  const ModelFile file = readModel(folder / "a.3mf");
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(file.objects.at(i).colour, colours[i]) << i;
}

TEST(ThreeMfWrite, ManyColoursKeepTheirPlaces) {
  const Folder folder;
  ModelObject one[] = {object(torus(300))};
  for (uint32_t i = 0; i < 180000; ++i)
    one[0].triangleColours.push_back({uint8_t(i * 7), uint8_t(i >> 3), uint8_t(i >> 11), uint8_t(255 - i % 3)});
  writeModel(folder / "a.3mf", {one, {}});
  EXPECT_EQ(readModel(folder / "a.3mf").objects[0].triangleColours, one[0].triangleColours);
}

TEST(ThreeMfWrite, EqualModelsGiveEqualBytesOnAnyNumberOfThreads) {
  const Folder folder;
  const ModelObject one[] = {object(torus(250))};
  writeModel(folder / "a.3mf", {one, {}});
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  writeModel(folder / "b.3mf", {one, {}});
  EXPECT_EQ(samples::slurp(folder / "a.3mf"), samples::slurp(folder / "b.3mf"));
}

TEST(ThreeMfWrite, BrokenTextInNamesBecomesReadable) {
  const Folder folder;
  const ModelObject one[] = {object(samples::cube(),
                                    "a\xff\x01"
                                    "b\n")};
  writeModel(folder / "a.3mf", {one, {{"Description", "two\nlines \xe2\x82"}}});
  const ModelFile file = readModel(folder / "a.3mf");
  EXPECT_EQ(file.objects[0].name, "a??b ");
  EXPECT_THAT(file.metadata, Contains(std::pair<std::string, std::string>("Description", "two\nlines ??")));
  (void)readByLib3mf(folder / "a.3mf");
}

TEST(ThreeMfWrite, NothingIsLeftWhenItFailsOrIsCancelled) {
  const Folder folder;
  ModelObject one[] = {object(torus(100))};
  Job job;
  job.cancel();
  EXPECT_THROW(writeModel(folder / "a.3mf", {one, {}}, {}, &job), Cancelled);
  one[0].triangleColours.resize(5);
  EXPECT_THAT(errorOf([&] { writeModel(folder / "a.3mf", {one, {}}); }), HasSubstr("do not fit its mesh"));
  one[0].triangleColours.clear();
  one[0].mesh.positions[7].x() = 1e39;
  EXPECT_THAT(errorOf([&] { writeModel(folder / "a.3mf", {one, {}}); }), HasSubstr("does not fit the format"));
  EXPECT_EQ(folder.entries(), 0u);
  one[0].mesh.positions[7].x() = 1;
  Job whole;
  writeModel(folder / "a.3mf", {one, {}}, {}, &whole);
  EXPECT_EQ(whole.fraction(), 1);
}

// Readers of 3MF take vertices as they are: a mesh whose corners only lie together would fall apart.
TEST(ThreeMfWrite, VerticesInOnePlaceBecomeOneAndCornersKeepTheirColours) {
  const Folder folder;
  ModelObject loose;
  const clay::TriangleMesh cube = samples::cube(10);
  for (size_t t = 0; t < cube.triangles.size(); ++t) {
    const auto first = uint32_t(loose.mesh.positions.size());
    for (size_t k = 0; k < 3; ++k) {
      loose.mesh.positions.push_back(cube.positions[cube.triangles[t][k]]);
      loose.vertexColours.push_back({uint8_t(10 * t), uint8_t(50 * k), 7, 255});
    }
    loose.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  // One without an area, which no triangle of the format may be.
  loose.mesh.positions.push_back(loose.mesh.positions[0]);
  loose.vertexColours.push_back(kRed);
  loose.mesh.triangles.push_back({0, 36, 1});
  const WriteReport report = writeModel(folder / "a.3mf", {{&loose, 1}, {}}, {.weld = true});
  EXPECT_EQ(report.vertices, 8u);
  EXPECT_EQ(report.triangles, 12u);
  const PeerModel peer = readByLib3mf(folder / "a.3mf");
  EXPECT_THAT(peer.warnings, IsEmpty());
  ASSERT_EQ(peer.objects.size(), 1u);
  EXPECT_EQ(peer.objects[0].positions.size(), 8u);
  ASSERT_EQ(peer.objects[0].triangles.size(), 12u);
  ASSERT_EQ(peer.objects[0].corners.size(), 12u);
  clay::TriangleMesh mesh;
  for (const auto& [x, y, z] : peer.objects[0].positions) mesh.positions.emplace_back(x, y, z);
  mesh.triangles = peer.objects[0].triangles;
  EXPECT_TRUE(clay::checkTopology(mesh).closed());
  for (size_t t = 0; t < 12; ++t)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_EQ(peer.objects[0].corners[t][k], (Colour{uint8_t(10 * t), uint8_t(50 * k), 7, 255}));
  // A closed mesh stays as it is, vertices in one place too.
  ModelObject touching = object(samples::cube(10));
  const clay::TriangleMesh other = samples::cube(10, {20, 20, 20});
  for (auto triangle : other.triangles) {
    for (uint32_t& v : triangle) v += 8;
    touching.mesh.triangles.push_back(triangle);
  }
  touching.mesh.positions.insert(touching.mesh.positions.end(), other.positions.begin(), other.positions.end());
  EXPECT_EQ(writeModel(folder / "b.3mf", {{&touching, 1}, {}}, {.weld = true}).vertices, 16u);
}

}  // namespace
}  // namespace argil::io
