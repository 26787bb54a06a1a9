// Colours go out to every format that has them and come back as the clay's own; one colour alone is the piece's.

#include "engine/models/model_colours.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "clay/field/primitives.h"
#include "clay/store/channel_reader.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "engine/models/model_files.h"
#include "engine/models/prepare_clay.h"
#include "io/models/model_writer.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;

using Rgb = Eigen::Vector3d;

// sRGB, smooth over 20 mm and more.
Rgb painted(const Vec3d& p) {
  return Rgb(128 + 100 * std::sin(p.x() / 6), 128 + 100 * std::cos(p.y() / 7), 128 + 100 * std::sin(p.z() / 8 + 1));
}

io::Colour colourAt(const Vec3d& p) {
  const Rgb c = painted(p);
  const auto byte = [](double v) { return static_cast<uint8_t>(std::lround(v)); };
  return {byte(c.x()), byte(c.y()), byte(c.z()), 255};
}

// A ball of 20 mm with one colour a vertex.
io::ModelObject paintedBall() {
  clay::Grid grid;
  grid.voxelMm = 1;
  Document document = Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 20));
  io::ModelObject object = modelOf(document, {}).at(0);
  for (const Vec3d& p : object.mesh.positions) object.vertexColours.push_back(colourAt(p));
  return object;
}

class ModelColours : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-model-colours-" + std::to_string(getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
};

// Root mean square over the vertices of the surface, in bytes; all of it must be covered.
double errorOf(const Document& document) {
  const io::ModelObject object = modelOf(document, {}).at(0);
  EXPECT_EQ(object.vertexColours.size(), object.mesh.positions.size());
  if (object.vertexColours.size() != object.mesh.positions.size()) return INFINITY;
  double sum = 0;
  for (size_t i = 0; i < object.vertexColours.size(); ++i) {
    const io::Colour& c = object.vertexColours[i];
    sum += (Rgb(c.red, c.green, c.blue) - painted(object.mesh.positions[i])).squaredNorm() / 3;
  }
  return std::sqrt(sum / double(object.vertexColours.size()));
}

TEST_F(ModelColours, OfVerticesComeBackFromEveryFormat) {
  const io::ModelObject ball = paintedBall();
  for (const char* name : {"ball.ply", "ball.obj", "ball.3mf", "ball.glb", "ball.gltf"}) {
    SCOPED_TRACE(name);
    io::writeModel(folder / name, {{&ball, 1}, {}});
    const ImportedModel in = importModel(folder / name, {.voxelMm = 1});
    ASSERT_EQ(in.pieces.size(), 1u);
    EXPECT_LT(errorOf([&] {
                Document document;
                document.add(in.pieces[0]);
                return document;
              }()),
              2);
    // Those of scripts too.
    Script script;
    script.voxelMm = 1;
    script.up = Up::z;
    EXPECT_LT(errorOf(prepareClay(clay::Store::make(), script, {.input = folder / name}).document), 2);
  }
}

// Two pieces that lie turned beside each other: every byte, each own colour, every place.
TEST_F(ModelColours, ALevelSetKeepsThemAndWhereItLies) {
  const io::ModelObject ball = paintedBall();
  io::writeModel(folder / "ball.ply", {{&ball, 1}, {}});
  Piece turned = importModel(folder / "ball.ply", {.voxelMm = 1}).pieces.at(0);
  turned.name = "Ball";
  turned.pose = {Vec3d(50, -7, 3), Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()))};
  Piece plain;
  plain.name = "Ball";
  plain.colour = {10 / 255.0f, 200 / 255.0f, 1};
  plain.version = clay::makeSphere(clay::Store::make(), {}, Vec3d(-60, 0, 0), 10);
  Piece part = turned;  // of which a half is painted
  part.name = "Part";
  clay::Editor editor(part.version);
  part.version.forEachBrick(clay::Channel::cover, [&](const clay::ChannelBrick& brick) {
    if (brick.coord.x < 0) editor.setChannelTile(clay::Channel::cover, brick.coord, false);
  });
  part.version = editor.commit();
  part.colour = {1, 0, 0};
  Document document;
  for (Piece* piece : {&plain, &turned, &part}) document.add(*piece);
  EXPECT_EQ(writeModelFiles({folder / "a.vdb"}, document, {}).size(), 1u) << "nothing is lost";
  Document again;
  const ImportedModel in = importModel(folder / "a.vdb", {});
  EXPECT_TRUE(in.notes.empty());
  for (const Piece& piece : in.pieces) again.add(piece);
  const std::vector<io::ModelObject> before = modelOf(document, {}), after = modelOf(again, {});
  ASSERT_EQ(after.size(), before.size());
  for (const io::ModelObject& object : after) {
    SCOPED_TRACE(object.name);
    // Grids of a file have no order.
    const auto same = std::find_if(before.begin(), before.end(), [&](const io::ModelObject& each) {
      return each.name == object.name && each.vertexColours.empty() == object.vertexColours.empty();
    });
    ASSERT_NE(same, before.end());
    EXPECT_EQ(object.colour, same->colour);
    ASSERT_EQ(object.mesh.positions.size(), same->mesh.positions.size());
    double most = 0;
    size_t differ = 0;
    for (size_t i = 0; i < object.mesh.positions.size(); ++i) {
      most = std::max(most, (object.mesh.positions[i] - same->mesh.positions[i]).norm());
      if (!object.vertexColours.empty()) differ += object.vertexColours[i] != same->vertexColours[i];
    }
    EXPECT_LT(most, 1e-5);
    EXPECT_EQ(differ, 0u) << "of " << object.mesh.positions.size();
  }
}

TEST_F(ModelColours, OfTrianglesHaveSharpBorders) {
  io::ModelObject ball = paintedBall();
  ball.vertexColours.clear();
  for (const auto& t : ball.mesh.triangles) {
    const bool left = ball.mesh.positions[t[0]].x() + ball.mesh.positions[t[1]].x() + ball.mesh.positions[t[2]].x() < 0;
    ball.triangleColours.push_back(left ? io::Colour{200, 10, 30, 255} : io::Colour{20, 90, 250, 255});
  }
  for (const char* name : {"ball.3mf", "ball.ply", "ball.glb"}) {
    SCOPED_TRACE(name);
    io::writeModel(folder / name, {{&ball, 1}, {}});
    Document document;
    document.add(importModel(folder / name, {.voxelMm = 1}).pieces.at(0));
    const io::ModelObject object = modelOf(document, {}).at(0);
    ASSERT_EQ(object.vertexColours.size(), object.mesh.positions.size());
    size_t judged = 0;
    for (size_t i = 0; i < object.vertexColours.size(); ++i) {
      const double x = object.mesh.positions[i].x();
      if (std::abs(x) < 2) continue;
      ++judged;
      EXPECT_EQ(object.vertexColours[i], x < 0 ? (io::Colour{200, 10, 30, 255}) : (io::Colour{20, 90, 250, 255}))
          << object.mesh.positions[i].transpose();
    }
    EXPECT_GT(judged, 1000u);
  }
}

TEST_F(ModelColours, ALoneOneIsThePiecesOwn) {
  io::ModelObject ball = paintedBall();
  for (io::Colour& each : ball.vertexColours) each = {10, 200, 30, 255};
  io::writeModel(folder / "ball.ply", {{&ball, 1}, {}});
  const Piece piece = importModel(folder / "ball.ply", {.voxelMm = 1}).pieces.at(0);
  EXPECT_EQ(bytesOf(piece.colour), (std::array<uint8_t, 3>{10, 200, 30}));
  EXPECT_FALSE(piece.version.has(clay::Channel::cover)) << "no memory for what the piece says";
}

TEST_F(ModelColours, DoNotDependOnThreads) {
  const io::ModelObject ball = paintedBall();
  const clay::Version plain = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 20);
  std::vector<clay::MeshColour> colours;
  for (const io::Colour& each : ball.vertexColours) colours.push_back({each.red, each.green, each.blue});
  const clay::Version one = clay::withMeshColours(plain, ball.mesh, {colours, {}}, clay::WorkPart(nullptr), 1);
  const clay::Version four = clay::withMeshColours(plain, ball.mesh, {colours, {}}, clay::WorkPart(nullptr), 4);
  size_t painted = 0;
  one.forEachBrick([&](const clay::Brick& brick) {
    for (const clay::Channel channel : clay::kColourChannels) {
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        const uint8_t value = one.find(channel, brick.coord).value(i);
        painted += value != 0;
        ASSERT_EQ(value, four.find(channel, brick.coord).value(i));
        if (channel == clay::Channel::cover) {
          ASSERT_EQ(value, std::abs(brick.phi(i)) < 3 ? 255 : 0) << "the band and nothing else";
        }
      }
    }
  });
  EXPECT_GT(painted, 10000u);
  EXPECT_FALSE(plain.has(clay::Channel::cover)) << "the version it came from stays";
}

TEST_F(ModelColours, AreCountedBeforeTheyAreUsed) {
  const io::ModelObject ball = paintedBall();
  const clay::Version plain = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 20);
  const std::vector<clay::MeshColour> few(3);
  EXPECT_THROW((void)clay::withMeshColours(plain, ball.mesh, {few, {}}, clay::WorkPart(nullptr)), Error);
  EXPECT_THROW((void)clay::withMeshColours(plain, ball.mesh, {{}, few}, clay::WorkPart(nullptr)), Error);
  Job job;
  job.cancel();
  const std::vector<clay::MeshColour> all(ball.mesh.positions.size());
  EXPECT_THROW((void)clay::withMeshColours(plain, ball.mesh, {all, {}}, clay::WorkPart(&job)), Cancelled);
}

// One object painted, one of a single colour, too many to be pieces of their own: all as one piece keeps both.
TEST_F(ModelColours, StayWhenObjectsBecomeOne) {
  std::vector<io::ModelObject> objects(2, paintedBall());
  objects[1].vertexColours.clear();
  objects[1].colour = io::Colour{9, 99, 199, 255};
  for (Vec3d& p : objects[1].mesh.positions) p.x() += 100;
  const io::ModelObject all = io::merged(std::move(objects));
  ASSERT_EQ(all.vertexColours.size(), all.mesh.positions.size());
  for (size_t i = 0; i < all.vertexColours.size(); ++i) {
    const Vec3d& p = all.mesh.positions[i];
    EXPECT_EQ(all.vertexColours[i], p.x() > 50 ? (io::Colour{9, 99, 199, 255}) : colourAt(p));
  }
}

}  // namespace
}  // namespace argil::engine
