// Models that lie far away, hold several objects, or come in other units become pieces where clay can be.

#include "engine/models/model_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/field/region_work.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "engine/models/model_colours.h"
#include "engine/models/prepare_clay.h"
#include "engine/text/document_text.h"
#include "io/models/model_writer.h"
#include "tests/support/package_samples.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

io::ModelObject cube(const std::string& name, const Vec3d& at, double edge, io::Colour colour) {
  io::ModelObject object;
  object.name = name;
  object.colour = colour;
  for (int i = 0; i < 8; ++i) object.mesh.positions.push_back(at + edge * Vec3d(i & 1, (i >> 1) & 1, i >> 2));
  object.mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return object;
}

class ModelFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-model-files-" + std::to_string(getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
};

TEST_F(ModelFiles, SeveralObjectsBecomePiecesWithNamesAndColours) {
  const std::vector<io::ModelObject> objects{cube("left", {0, 0, 0}, 10, {255, 0, 0, 255}),
                                             cube("right", {20, 0, 0}, 10, {0, 0, 255, 255})};
  io::writeModel(folder / "two.3mf", {objects, {}});
  const ImportedModel clay = importModel(folder / "two.3mf", {.voxelMm = 0.5});
  ASSERT_EQ(clay.pieces.size(), 2u);
  EXPECT_EQ(clay.pieces[1].name, "right");
  EXPECT_EQ(clay.pieces[1].colour, (std::array<float, 3>{0, 0, 1}));
  const ImportedModel parts = importModel(folder / "two.3mf", {.asPart = true});
  ASSERT_EQ(parts.parts.size(), 2u);
  EXPECT_EQ(parts.parts[0].name, "left");
  EXPECT_NE(parts.parts[0].felt, nullptr);
  // And out again: what was two objects is two objects.
  Document document;
  for (const Piece& piece : clay.pieces) document.add(piece);
  const auto sentences = writeModelFiles({folder / "again.3mf", folder / "again.vdb"}, document, {});
  EXPECT_EQ(sentences.size(), 2u);
  const io::ModelFile back = io::readModel(folder / "again.3mf");
  ASSERT_EQ(back.objects.size(), 2u);
  EXPECT_EQ(back.objects[0].name, "left");
  EXPECT_EQ(io::meanColour(back.objects[1]), (io::Colour{0, 0, 255, 255}));
  const ImportedModel levelSets = importModel(folder / "again.vdb", {});
  ASSERT_EQ(levelSets.pieces.size(), 2u);
  EXPECT_EQ(levelSets.pieces[0].name, "left");
  EXPECT_EQ(levelSets.pieces[1].name, "right");
}

TEST_F(ModelFiles, APiecesOwnVoxelsComeBackFrom3mf) {
  for (const std::vector<double>& voxels : {std::vector{0.5}, {0.75, 0.3}, {0.2}}) {
    Document document;
    for (size_t i = 0; i < voxels.size(); ++i) {
      Piece piece;
      piece.name = "piece " + std::to_string(i);
      piece.version =
          clay::makeBlock(clay::Store::make(), {.voxelMm = voxels[i]}, Vec3d(40.0 * double(i), 0, 0), {20, 16, 12}, 1);
      document.add(piece);
    }
    (void)writeModelFiles({folder / "own.3mf"}, document, {});
    const ImportedModel back = importModel(folder / "own.3mf", {});
    ASSERT_EQ(back.pieces.size(), voxels.size());
    for (size_t i = 0; i < voxels.size(); ++i)
      EXPECT_DOUBLE_EQ(back.pieces[i].version.grid().voxelMm, voxels[i]) << back.pieces[i].name;
    // Who asks for other voxels, or another size, gets that.
    EXPECT_DOUBLE_EQ(importModel(folder / "own.3mf", {.voxelMm = 1}).pieces[0].version.grid().voxelMm, 1);
    EXPECT_NEAR(importModel(folder / "own.3mf", {.fitMm = 256}).pieces[0].version.grid().voxelMm, 1, 0.02);
  }
  // A file that asks for more than any clay of its size had is not believed.
  const std::vector<io::ModelObject> objects{cube("left", {0, 0, 0}, 10, {255, 0, 0, 255})};
  for (const char* wrong : {"0.0001", "0", "-1", "nan", "0.5 0.5 x", ""}) {
    io::writeModel(folder / "wrong.3mf", {objects, {{"VoxelSizeMm", wrong}}});
    EXPECT_NEAR(importModel(folder / "wrong.3mf", {}).pieces[0].version.grid().voxelMm, 10.0 / 256, 0.002) << wrong;
  }
}

// Each would be a row of the list: beyond 32 they come as one.
TEST_F(ModelFiles, NotesOfSeveralObjectsNameThem) {
  std::vector<io::ModelObject> objects{cube("left", {0, 0, 0}, 10, {}), cube("", {20, 0, 0}, 10, {}),
                                       cube("lidless", {40, 0, 0}, 10, {})};
  objects[2].mesh.triangles.erase(objects[2].mesh.triangles.begin() + 2, objects[2].mesh.triangles.begin() + 4);
  io::writeModel(folder / "three.3mf", {objects, {}});
  const ImportedModel clay = importModel(folder / "three.3mf", {.voxelMm = 0.5});
  ASSERT_EQ(clay.pieces.size(), 3u);
  for (const char* begin : {"left: The mesh has 12 triangles in 1 body: one closed body", "Object 2: The mesh has 12",
                            "lidless: The mesh has 10 triangles in 1 body.", "lidless: The mesh is open along 4 edges"})
    EXPECT_THAT(clay.notes, testing::Contains(testing::StartsWith(begin)));
  // Of one object alone the name says nothing that the file does not.
  io::writeModel(folder / "one.3mf", {{&objects[0], 1}, {}});
  EXPECT_THAT(importModel(folder / "one.3mf", {.voxelMm = 0.5}).notes,
              testing::Contains(testing::StartsWith("The mesh has 12")));
}

TEST_F(ModelFiles, AsManyObjectsAsAListHoldsStayApart) {
  for (const int count : {32, 33}) {
    std::vector<io::ModelObject> objects;
    for (int i = 0; i < count; ++i)
      objects.push_back(cube("cube " + std::to_string(i), {12.0 * i, 0, 0}, 10, {255, 0, 0, 255}));
    io::writeModel(folder / "many.3mf", {objects, {}});
    EXPECT_EQ(importModel(folder / "many.3mf", {.voxelMm = 2}).pieces.size(), count == 32 ? 32u : 1u);
  }
}

TEST_F(ModelFiles, MoreObjectsThanAListHoldsAreOnePart) {
  std::vector<io::ModelObject> objects;
  for (int i = 0; i < 40; ++i)
    objects.push_back(cube("cube " + std::to_string(i), {12.0 * i, 0, 0}, 10, {255, 0, 0, 255}));
  io::writeModel(folder / "many.3mf", {objects, {}});
  const ImportedModel parts = importModel(folder / "many.3mf", {.asPart = true});
  ASSERT_EQ(parts.parts.size(), 1u);
  EXPECT_EQ(parts.parts[0].mesh->triangles.size(), 40u * 12);
}

// A pocket of 20 × 20 × 10 in a block of 40 × 40 × 20, as PrusaSlicer keeps it: 28 000 mm³ are left of 32 000.
TEST_F(ModelFiles, WhatASlicerCutsAwayIsCutFromTheClay) {
  const io::ModelObject block = cube("block", {0, 0, 0}, 40, {}), pocket = cube("pocket", {10, 10, 10}, 20, {}),
                        apart = cube("apart", {100, 0, 0}, 10, {});
  auto read = std::make_shared<io::ModelFile>();
  read->objects = {block, apart};
  for (Vec3d& p : read->objects[0].mesh.positions) p.z() *= 0.5;
  read->objects[1].assembly = 1;
  read->negatives = {pocket};
  read->notes = {"What the reader noticed."};
  const auto look = std::make_shared<const ModelLook>(lookAtModel(read, "a.3mf"));
  const ImportedModel clay = importModel("a.3mf", {.voxelMm = 0.5, .look = look});
  ASSERT_EQ(clay.pieces.size(), 2u);
  EXPECT_NEAR(clay::volumeOf(clay.pieces[0].version) * 0.125, 28000, 28);
  EXPECT_NEAR(clay::volumeOf(clay.pieces[1].version) * 0.125, 1000, 10) << "of another assembly";
  EXPECT_THAT(clay.notes, testing::Contains(HasSubstr("pocket was cut away")));
  EXPECT_THAT(clay.notes, testing::Contains("What the reader noticed."));
  // It goes where the model goes.
  ModelImport standing;
  standing.look = look;
  standing.units = "cm";
  standing.voxelMm = 5;
  standing.stands = true;
  const ImportedModel stood = importModel("a.3mf", standing);
  ASSERT_EQ(stood.pieces.size(), 2u);
  EXPECT_NEAR(clay::volumeOf(stood.pieces[0].version) * 0.125, 28000, 28);
  // All as one, and as a part that cannot be cut.
  const ImportedModel fitted = importModel("a.3mf", {.voxelMm = 0.25, .fitMm = 55, .look = look});
  ASSERT_EQ(fitted.pieces.size(), 1u);
  EXPECT_NEAR(clay::volumeOf(fitted.pieces[0].version) / 64, 29000 / 8.0, 29);
  EXPECT_THAT(importModel("a.3mf", {.look = look, .asPart = true}).notes, testing::Contains(HasSubstr("not cut away")));
  // More is cut away than there is.
  read->negatives[0] = cube("all", {-10, -10, -10}, 60, {});
  const ImportedModel rest = importModel("a.3mf", {.voxelMm = 1, .look = look});
  ASSERT_EQ(rest.pieces.size(), 1u);
  EXPECT_EQ(rest.pieces[0].name, "apart");
  EXPECT_THAT(rest.notes, testing::Contains(HasSubstr("Nothing is left of block")));
  read->objects.pop_back();
  EXPECT_THROW((void)importModel("a.3mf", {.voxelMm = 1, .look = look}), Error);
}

// The same in a package of PrusaSlicer, by way of a script: a block of 40 × 40 × 20 with a pocket of 20 mm.
TEST_F(ModelFiles, WhatASlicerCutsAwayIsCutInScriptsToo) {
  std::string vertices, triangles;
  uint32_t first = 0;
  for (const io::ModelObject& each : {cube("", {0, 0, 0}, 40, {}), cube("", {10, 10, 30}, 20, {})}) {
    for (const Vec3d& p : each.mesh.positions)
      vertices += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : each.mesh.triangles)
      triangles += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", first + a, first + b, first + c);
    first += uint32_t(each.mesh.positions.size());
  }
  const auto volume = [](int from, int to, const char* kind) {
    return fmt::format(
        "<volume firstid=\"{}\" lastid=\"{}\"><metadata type=\"volume\" key=\"volume_type\" value=\"{}\"/></volume>",
        from, to, kind);
  };
  const std::string model = "<resources><object id=\"1\"><mesh><vertices>" + vertices + "</vertices><triangles>" +
                            triangles + "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build>";
  samples::spill(folder / "a.3mf",
                 samples::threeMf(model, "unit=\"millimeter\"",
                                  {{"Metadata/Slic3r_PE_model.config",
                                    "<?xml version=\"1.0\"?><config><object id=\"1\">" + volume(0, 11, "ModelPart") +
                                        volume(12, 23, "NegativeVolume") + "</object></config>"}}));
  Script script;
  script.voxelMm = 0.5;
  const PreparedClay clay = prepareClay(clay::Store::make(), script, {.input = folder / "a.3mf"});
  EXPECT_NEAR(clay::volumeOf(clay.version) * 0.125, 64000 - 4000, 60);
  EXPECT_EQ(clay.document.pieces.at(0).version, clay.version);
  EXPECT_THAT(clay.notes, testing::Contains(HasSubstr("was cut away")));
  script.fitMm = 20;
  script.voxelMm = 0.25;
  EXPECT_NEAR(clay::volumeOf(prepareClay(clay::Store::make(), script, {.input = folder / "a.3mf"}).version) / 64, 7500,
              15);
}

// What the import page lists: each object's kind, and walls over all of them.
TEST_F(ModelFiles, WhatIsWorthKnowingBeforeImport) {
  auto read = std::make_shared<io::ModelFile>();
  read->objects = {cube("solid", {0, 0, 0}, 40, {}), cube("open", {100, 0, 0}, 40, {})};
  read->objects[1].mesh.triangles.pop_back();
  const ModelDetails details = detailsOf(lookAtModel(read, "a.obj"));
  EXPECT_EQ(details.solid, (std::vector<bool>{true, false}));
  EXPECT_DOUBLE_EQ(details.walls.keepingVoxelMm(), 6.2);
  EXPECT_EQ(read->objects.size(), 2u) << "what was read stays";
  EXPECT_FALSE(read->objects[0].mesh.triangles.empty());
}

// A scan in the coordinates of a map comes in, is saved, and goes out where the map has it.
TEST_F(ModelFiles, WhatImportMovedCanBePutBack) {
  auto read = std::make_shared<io::ModelFile>();
  read->objects = {cube("here", {3.5e8, -7.25e6, 40}, 40, {}), cube("there", {3.5e8 + 100, -7.25e6, 40}, 40, {})};
  const auto look = std::make_shared<const ModelLook>(lookAtModel(read, "a.obj"));
  Eigen::AlignedBox3d file;
  for (const io::ModelObject& object : read->objects)
    for (const Vec3d& p : object.mesh.positions) file.extend(p);
  EXPECT_EQ(look->low, file.min());
  EXPECT_EQ(look->high, file.max());
  const auto boxOut = [&](const Document& document, bool putBack) {
    ModelExport what;
    what.putBack = putBack;
    Eigen::AlignedBox3d box;
    for (const io::ModelObject& object : modelOf(document, what))
      for (const Vec3d& p : object.mesh.positions) box.extend(p);
    return box;
  };
  const Vec3d low(3.5e8, -7.25e6, 40), high = low + Vec3d(140, 40, 40);
  for (const bool stands : {false, true}) {
    Document document;
    const ImportedModel in = importModel("a.obj", {.voxelMm = 1, .stands = stands, .look = look});
    for (const Piece& piece : in.pieces) document.add(piece);
    ASSERT_EQ(document.pieces.size(), 2u);
    EXPECT_LT(boxOut(document, false).center().norm(), 30);
    EXPECT_LT((boxOut(document, true).min() - low).norm(), 0.2);
    EXPECT_LT((boxOut(document, true).max() - high).norm(), 0.2);
    // As it is saved.
    const Document again = readDocumentText(documentText(document, {{1, 1}, {2, 1}}, {}), "it").document;
    EXPECT_EQ(again.pieces.at(1).fileOffsetMm, document.pieces[1].fileOffsetMm);
    // A level set too.
    ModelExport what;
    what.putBack = true;
    writeModelFiles({folder / "a.vdb"}, document, what);
    Document set;
    for (const Piece& piece : importModel(folder / "a.vdb", {.units = "um"}).pieces) set.add(piece);
    EXPECT_LT((1000 * boxOut(set, false).min() - low).norm(), 2) << "as it reaches farther than clay in mm";
  }
  EXPECT_TRUE(importModel("a.obj", {.voxelMm = 1, .fitMm = 30, .look = look}).pieces.at(0).fileOffsetMm.isZero(0));
  EXPECT_TRUE(fileOffset({1e13, 0, 0}).isZero(0)) << "no digit of the shape would be left";
}

TEST_F(ModelFiles, WhatIsInsideOutIsTurnedAround) {
  clay::TriangleMesh mesh = cube("", {0, 0, 0}, 10, {}).mesh;
  const auto right = mesh.triangles;
  EXPECT_FALSE(turnOutwards(mesh));
  EXPECT_EQ(mesh.triangles, right);
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(turnOutwards(mesh));
  EXPECT_GT(clay::checkTopology(mesh).volume, 999);
  // The same as loose triangles, one of them without area, as some programs write them.
  clay::TriangleMesh loose;
  for (const auto& triangle : mesh.triangles) {
    const auto first = static_cast<uint32_t>(loose.positions.size());
    for (const uint32_t v : triangle) loose.positions.push_back(mesh.positions[v]);
    loose.triangles.push_back({first + 1, first, first + 2});
  }
  loose.triangles.push_back({0, 0, 1});
  EXPECT_TRUE(turnOutwards(loose));
  EXPECT_FALSE(turnOutwards(loose));
  // What is open has no inside.
  mesh.triangles.pop_back();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(turnOutwards(mesh));
}

TEST_F(ModelFiles, SmallModelsFarAwayGoOutWhenTheyAreMovedToZero) {
  Document document = Document::of(
      clay::makeSphere(clay::Store::make(), {.voxelMm = 0.001, .originMm = {9e5, 0, 0}}, {9e5, 0, 0}, 0.02));
  EXPECT_THROW((void)writeModelFiles({folder / "grain.stl"}, document, {}), Error);
  EXPECT_FALSE(fs::exists(folder / "grain.stl"));
  ModelExport how;
  how.recentre = true;
  const auto sentences = writeModelFiles({folder / "grain.stl"}, document, how);
  EXPECT_THAT(sentences, testing::Contains(HasSubstr("Moved by")));
  Eigen::AlignedBox3d box;
  const io::ModelFile written = io::readModel(folder / "grain.stl");
  for (const Vec3d& p : written.objects.at(0).mesh.positions) box.extend(p);
  EXPECT_NEAR(box.sizes().x(), 0.04, 0.002);
}

// Half a ball of the first material, which has a colour, a quarter of the second, which has none.
TEST_F(ModelFiles, ColoursOfMaterialsGoOut) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 10);
  clay::Editor editor(ball);
  ball.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> rows{};
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < 3) rows[size_t(i)] = brick.coord.x >= 0 ? 1 : brick.coord.y >= 0 ? 2 : 0;
    editor.setChannel(clay::Channel::material, brick.coord, rows);
  });
  Piece piece;
  piece.version = editor.commit();
  piece.colour = {1, 0, 0};
  piece.materials = {{"wax", {}, std::array{0.0f, 0.0f, 1.0f}}, {"rubber", {}, {}}};
  Document document;
  document.add(piece);
  static_cast<void>(writeModelFiles({folder / "ball.ply"}, document, {}));
  const io::ModelFile back = io::readModel(folder / "ball.ply");
  const io::ModelObject& object = back.objects.at(0);
  ASSERT_EQ(object.vertexColours.size(), object.mesh.positions.size());
  for (size_t i = 0; i < object.vertexColours.size(); ++i) {
    const double x = object.mesh.positions[i].x();
    if (std::abs(x) < 1) continue;
    EXPECT_EQ(object.vertexColours[i], x > 0 ? (io::Colour{0, 0, 255, 255}) : (io::Colour{255, 0, 0, 255})) << i;
  }
}

// Nobody chose a colour: no format invents one, and what comes back has none.
TEST_F(ModelFiles, ClayWithoutAColourIsWrittenWithoutOne) {
  Piece piece;
  piece.version = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 5);
  Document document;
  document.add(piece);
  std::vector<fs::path> files;
  for (const char* name : {"a.obj", "a.ply", "a.3mf", "a.glb", "a.gltf", "a.drc", "a.vdb", "a.step", "quads.obj"})
    files.push_back(folder / name);
  const fs::path quads = files.back();
  files.pop_back();
  static_cast<void>(writeModelFiles(files, document, {}));
  ModelExport few;
  few.quads = 200;
  static_cast<void>(writeModelFiles({quads}, document, few));
  files.push_back(quads);
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.filename());
    const ImportedModel back = importModel(file, {});
    EXPECT_EQ(chosenColour(back.pieces.at(0)), std::nullopt);
    EXPECT_FALSE(back.pieces[0].version.has(clay::Channel::cover));
    if (file.extension() == ".vdb") continue;
    const io::ModelObject object = io::readModel(file).objects.at(0);
    EXPECT_EQ(object.colour, std::nullopt);
    EXPECT_TRUE(object.vertexColours.empty());
    EXPECT_TRUE(object.triangleColours.empty());
  }
  // A colour that was chosen stays, also where another piece has none.
  document.pieces[0].colour = {1, 0, 0};
  document.pieces[0].pose.translation = {20, 0, 0};
  document.add(piece);
  for (const char* name : {"b.obj", "b.ply", "b.3mf", "b.glb", "b.vdb"}) {
    SCOPED_TRACE(name);
    static_cast<void>(writeModelFiles({folder / name}, document, {}));
    const ImportedModel back = importModel(folder / name, {});
    if (back.pieces.size() == 2) {
      EXPECT_EQ(chosenColour(back.pieces[0]), (std::array<float, 3>{1, 0, 0}));
    }
    if (fs::path(name).extension() == ".3mf" || fs::path(name).extension() == ".vdb") {
      EXPECT_EQ(chosenColour(back.pieces.at(1)), std::nullopt);
    }
  }
}

TEST_F(ModelFiles, PaintOnClayWithoutAColourLeavesTheRestWhite) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 10);
  clay::Editor editor(ball);
  ball.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> rows{};
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < 3) rows[size_t(i)] = brick.coord.x >= 0 ? 1 : 0;
    editor.setChannel(clay::Channel::material, brick.coord, rows);
  });
  Piece piece;
  piece.version = editor.commit();
  piece.materials = {{"wax", {}, std::array{0.0f, 0.0f, 1.0f}}};
  Document document;
  document.add(piece);
  static_cast<void>(writeModelFiles({folder / "ball.ply"}, document, {}));
  const io::ModelFile back = io::readModel(folder / "ball.ply");
  const io::ModelObject& object = back.objects.at(0);
  ASSERT_EQ(object.vertexColours.size(), object.mesh.positions.size());
  for (size_t i = 0; i < object.vertexColours.size(); ++i) {
    const double x = object.mesh.positions[i].x();
    if (std::abs(x) < 1) continue;
    EXPECT_EQ(object.vertexColours[i], x > 0 ? (io::Colour{0, 0, 255, 255}) : io::Colour()) << i;
  }
}

// Pieces whose surface has vertices in one place, as a cut through voxels leaves them.
TEST_F(ModelFiles, NoTriangleHasTwoCornersInOnePlace) {
  const auto twice = [](const io::ModelObject& object, double scale) {
    size_t count = 0;
    for (const auto& t : object.mesh.triangles)
      for (size_t k = 0; k < 3; ++k)
        count += (object.mesh.positions[t[k]] * scale).cast<float>() ==
                 (object.mesh.positions[t[(k + 1) % 3]] * scale).cast<float>();
    return count;
  };
  clay::Grid grid;
  grid.voxelMm = 0.5;
  Document document;
  for (int i = 0; i < 3; ++i) {
    // Boxes on and off the voxels, far from zero, where 32-bit numbers are coarse.
    Piece piece;
    piece.version = clay::makeBlock(clay::Store::make(), grid, Vec3d::Constant(0.25 * i), Vec3d(10, 8, 6), 0);
    piece.pose.translation = Vec3d(30'000.0 * i, 0.1, 0.1);
    document.add(piece);
  }
  // Far from zero some vertices of fine clay fall together.
  Piece far;
  grid.voxelMm = 0.01;
  far.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 1);
  far.pose.translation = {40'000, 40'000, 40'000};
  document.add(far);
  clay::Surface surface(false, clay::Grade::fine);
  surface.update(far.version);
  io::ModelObject rounded;
  rounded.mesh = surface.toMesh();
  for (Vec3d& p : rounded.mesh.positions) p += far.pose.translation;
  ASSERT_GT(twice(rounded, 1), 0u) << "there is something to be moved";
  ModelExport what;
  std::vector<io::ModelObject> objects = modelOf(document, what);
  for (const io::ModelObject& object : objects) EXPECT_EQ(twice(object, 1), 0u);
  for (const char* name : {"a.glb", "a.3mf", "a.ply", "a.obj", "a.gltf"}) {
    SCOPED_TRACE(name);
    static_cast<void>(writeModelFiles({folder / name}, document, what));
    const io::ModelFile back = io::readModel(folder / name);
    for (const io::ModelObject& object : back.objects) EXPECT_EQ(twice(object, 1), 0u);
  }
  // A mesh of somebody else's: the triangles that close a body are moved, others are left out.
  objects.resize(1);
  objects[0].mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}},
                     {{0, 2, 1}, {0, 1, 3}, {1, 2, 4}, {2, 0, 4}, {0, 3, 4}, {1, 4, 3}}};
  objects[0].vertexColours.clear();
  EXPECT_EQ(partCorners(objects), "");
  EXPECT_EQ(objects[0].mesh.triangles.size(), 6u);
  EXPECT_EQ(twice(objects[0], 1), 0u);
  objects[0].mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}, {1, 1, 2}}};
  objects[0].triangleColours = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  EXPECT_EQ(partCorners(objects), "2 triangles with two corners in one place were left out.");
  EXPECT_EQ(objects[0].mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}}));
  EXPECT_EQ(objects[0].triangleColours, (std::vector<io::Colour>{{1, 1, 1}}));
  objects[0].mesh.triangles = {{1, 1, 2}};
  EXPECT_THROW(static_cast<void>(partCorners(objects)), Error);
}

// Written from the surface slab by slab, without a mesh: the same bytes. Two pieces, one painted, both moved and
// turned.
TEST_F(ModelFiles, FilesOfOneMeshAreWrittenWithoutIt) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 40);
  clay::Editor editor(ball);
  ball.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> rows{};
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      if (std::abs(brick.phi(i)) < 3) rows[size_t(i)] = brick.coord.x >= 0 ? 1 : 0;
    editor.setChannel(clay::Channel::material, brick.coord, rows);
  });
  Document document;
  for (const clay::Version& version :
       {clay::makeSphere(clay::Store::make(), {}, Vec3d(3, 4, 5), 30), editor.commit()}) {
    Piece piece;
    piece.name = fmt::format("Ball {}", document.pieces.size());
    piece.version = version;
    piece.materials = {{"wax", {}, std::array{0.0f, 0.0f, 1.0f}}};
    piece.pose.translation = {100.0 * double(document.pieces.size()), 7, 0};
    piece.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3d(1, 1, 0).normalized()));
    piece.fileOffsetMm = {1, 2, 3};
    document.add(piece);
  }
  const auto bytes = [](const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  ModelExport what;
  what.putBack = true;
  const std::vector<io::ModelObject> objects = modelOf(document, what);
  std::vector<fs::path> files;
  for (const char* ending : {".stl", ".ply", ".obj"}) {
    io::WriteOptions options;
    options.distinct = true;
    (void)io::writeModel(folder / (std::string("whole") + ending), {objects, {}}, options);
    files.push_back(folder / (std::string("slabs") + ending));
  }
  // With one in between whose meshes the next can take.
  files.insert(files.begin() + 2, folder / "between.3mf");
  (void)writeModelFiles(files, document, what);
  for (const char* ending : {".stl", ".ply", ".obj"})
    EXPECT_TRUE(bytes(folder / (std::string("whole") + ending)) == bytes(folder / (std::string("slabs") + ending)))
        << ending;
}

// Bluer from left to right, by twelve levels a voxel: the nearest corner there was is half a voxel off at most, in each
// direction.
TEST_F(ModelFiles, ReducedMeshesKeepTheColoursOfTheirPlaces) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 5);
  const double voxel = ball.grid().voxelMm;
  clay::Editor editor(ball);
  ball.forEachBrick([&](const clay::Brick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> blue{}, cover{};
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      if (std::abs(brick.phi(i)) >= 3) continue;
      const double x = brick.coord.x * clay::kBrickEdge + (i >> 6);
      blue[size_t(i)] = static_cast<uint8_t>(128 + 12 * x);
      cover[size_t(i)] = 255;
    }
    editor.setChannel(clay::Channel::blue, brick.coord, blue);
    editor.setChannel(clay::Channel::cover, brick.coord, cover);
  });
  Piece piece;
  piece.version = editor.commit();
  Document document;
  document.add(piece);
  ModelExport how;
  how.triangles = 500;
  static_cast<void>(writeModelFiles({folder / "ball.ply"}, document, how));
  const io::ModelObject object = io::readModel(folder / "ball.ply").objects.at(0);
  EXPECT_LE(object.mesh.triangles.size(), 500u);
  ASSERT_EQ(object.vertexColours.size(), object.mesh.positions.size());
  double sum = 0;
  for (size_t i = 0; i < object.vertexColours.size(); ++i)
    sum += std::abs(object.vertexColours[i].blue - (128 + 12 * object.mesh.positions[i].x() / voxel));
  const double mean = sum / double(object.vertexColours.size());
  EXPECT_LT(mean, 3);
}

TEST_F(ModelFiles, FarModelsAreBroughtNearAndSaySo) {
  const io::ModelObject far = cube("far", {5e6, -3e6, 0}, 100, {});
  io::writeModel(folder / "far.obj", {{&far, 1}, {}});
  const ImportedModel near = importModel(folder / "far.obj", {.voxelMm = 2});
  ASSERT_EQ(near.pieces.size(), 1u);
  EXPECT_THAT(near.notes, testing::Contains(HasSubstr("moved by")));
  Document document;
  document.add(near.pieces[0]);
  for (const Vec3d& p : meshOf(document, 0, false).positions) EXPECT_LT(p.cwiseAbs().maxCoeff(), 60);
}

TEST_F(ModelFiles, UnitsOfTheFileGoBeforeTheOnesGiven) {
  const io::ModelObject one = cube("one", {0, 0, 0}, 10, {});
  for (const char* name : {"u.3mf", "u.glb", "u.stl"}) {
    io::writeModel(folder / name, {{&one, 1}, {}});
    const ImportedModel part = importModel(folder / name, {.units = "in", .asPart = true});
    ASSERT_EQ(part.parts.size(), 1u);
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : part.parts[0].mesh->positions) box.extend(p);
    EXPECT_NEAR(box.sizes().maxCoeff(), std::string(name) == "u.stl" ? 254 : 10, 0.01) << name;
  }
}

}  // namespace
}  // namespace argil::engine
