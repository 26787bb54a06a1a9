// A reader that a file has taken over: what it says of a model or of clay is left out, said twice, cut short or
// changed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "io/models/model_writer.h"
#include "io/models/reader_process.h"
#include "io/models/vdb_file.h"
#include "io/reader/wire.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using testing::HasSubstr;
using wire::Kind;

struct Message {
  Kind kind;
  std::string payload;
};
using Speech = std::vector<Message>;

Speech heard(const std::string& what, const std::filesystem::path& file) {
  Speech speech;
  runReader(what, file, [&](Kind kind, std::span<const std::byte> payload) {
    speech.push_back({kind, std::string(reinterpret_cast<const char*>(payload.data()), payload.size())});
  });
  return speech;
}

std::string bytesOfSpeech(const Speech& speech) {
  std::string bytes;
  for (const Message& message : speech) {
    samples::append(bytes, wire::Head{message.kind, static_cast<uint32_t>(message.payload.size())});
    bytes += message.payload;
  }
  return bytes;
}

// What may be missing or come again without anything being wrong.
bool isText(Kind kind) {
  return kind == Kind::note || kind == Kind::format || kind == Kind::metadata;
}

class SpokenReaderTest : public testing::Test {
 protected:
  template <class Read>
  std::string outcome(const Speech& speech, const Read& read) {
    const std::string bytes = bytesOfSpeech(speech);
    const SpokenReader reader(samples::bytesOf(bytes));
    try {
      read();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  // Every message left out, said twice or one byte short.
  template <class Read>
  void expectNothingPasses(const Speech& speech, const Read& read) {
    EXPECT_EQ(outcome(speech, read), "") << "as it was said";
    for (size_t i = 0; i < speech.size(); ++i) {
      const Kind kind = speech[i].kind;
      Speech without = speech, twice = speech, shorter = speech;
      without.erase(without.begin() + std::ptrdiff_t(i));
      twice.insert(twice.begin() + std::ptrdiff_t(i), speech[i]);
      if (!isText(kind) && kind != Kind::colourBricks) {
        EXPECT_THAT(outcome(without, read), HasSubstr("sent what it should not")) << "without " << i;
      }
      if (!isText(kind) && kind != Kind::end) {
        EXPECT_THAT(outcome(twice, read), HasSubstr("sent what it should not")) << "twice " << i;
      }
      if (isText(kind) || kind == Kind::object || kind == Kind::grid || kind == Kind::end) continue;
      shorter[i].payload.pop_back();
      EXPECT_THAT(outcome(shorter, read), HasSubstr("sent what it should not")) << "one byte short " << i;
    }
  }
  // One number of the first message of a kind becomes another.
  template <class Number>
  static Speech changed(Speech speech, Kind kind, size_t offset, Number number) {
    for (Message& message : speech) {
      if (message.kind != kind) continue;
      EXPECT_LE(offset + sizeof number, message.payload.size());
      std::memcpy(message.payload.data() + offset, &number, sizeof number);
      break;
    }
    return speech;
  }

  samples::Folder folder_;
};

TEST_F(SpokenReaderTest, OfAModelIsBelievedInNothing) {
  std::vector<ModelObject> objects(2);
  objects[0].mesh = samples::cube(10);
  objects[1].mesh = samples::cube(5, {40, 0, 0});
  for (int i = 0; i < 8; ++i) objects[1].vertexColours.push_back({uint8_t(30 * i), 20, 30, 255});
  const auto file = folder_ / "a.glb";
  writeModel(file, {objects, {}});
  const Speech speech = heard("gltf", file);
  const auto read = [&] {
    const ModelFile model = readModel(file);
    ASSERT_EQ(model.objects.size(), 2u);
    for (const ModelObject& object : model.objects) ASSERT_EQ(object.mesh.triangles.size(), 12u);
  };
  ASSERT_NO_FATAL_FAILURE(expectNothingPasses(speech, read));
  for (const Speech& lie :
       {changed(speech, Kind::positions, 8, std::numeric_limits<double>::quiet_NaN()),
        changed(speech, Kind::positions, 16, std::numeric_limits<double>::infinity()),
        changed(speech, Kind::triangles, 4, uint32_t{1} << 20), changed(speech, Kind::object, 0, uint64_t{0}),
        changed(speech, Kind::object, 8, uint64_t{0}), changed(speech, Kind::object, 0, uint64_t{1} << 40)})
    EXPECT_THAT(outcome(lie, read), HasSubstr("sent what it should not"));
}

TEST_F(SpokenReaderTest, OfColoursOfTrianglesIsBelievedInNothing) {
  std::vector<ModelObject> objects(1);
  objects[0].mesh = samples::cube(10);
  const auto file = folder_ / "a.glb";
  writeModel(file, {objects, {}});
  Speech speech = heard("gltf", file);
  const auto head = std::ranges::find(speech, Kind::object, &Message::kind);
  ASSERT_NE(head, speech.end());
  head->payload.at(offsetof(wire::Object, hasTriangleColours)) = 1;
  std::string colours;
  for (int i = 0; i < 12; ++i) samples::append(colours, std::array<uint8_t, 4>{uint8_t(20 * i), 40, 60, 255});
  const auto last = std::ranges::find(speech, Kind::triangles, &Message::kind);
  ASSERT_NE(last, speech.end());
  speech.insert(last + 1, {Kind::triangleColours, colours});
  const auto read = [&] {
    const ModelFile model = readModel(file);
    ASSERT_EQ(model.objects.size(), 1u);
    ASSERT_EQ(model.objects[0].triangleColours.size(), 12u);
    EXPECT_EQ(model.objects[0].triangleColours[3], (Colour{60, 40, 60, 255}));
  };
  ASSERT_NO_FATAL_FAILURE(expectNothingPasses(speech, read));
}

TEST_F(SpokenReaderTest, OfFacesIsBelievedInNothing) {
  std::vector<ModelObject> objects(1);
  objects[0].mesh = samples::cube(10);
  const auto file = folder_ / "a.glb";
  writeModel(file, {objects, {}});
  const Speech plain = heard("gltf", file);
  const auto end = std::find_if(plain.begin(), plain.end(), [](const Message& m) { return m.kind == Kind::end; });
  const wire::Face face{.at = {1, 2, 3}, .along = {0, 0, 1}, .across = {1, 0, 0}, .width = 4, .depth = 5, .kind = 1};
  const auto with = [&](const wire::Face& one, size_t count = 1) {
    Speech speech(plain.begin(), end);
    std::string payload;
    for (size_t i = 0; i < count; ++i) samples::append(payload, one);
    speech.push_back({Kind::faces, payload});
    speech.insert(speech.end(), end, plain.end());
    return speech;
  };
  size_t found = 0;
  const auto read = [&] {
    const ModelFile model = readModel(file);
    found = model.objects.at(0).faces.size();
    if (found > 0) {
      EXPECT_EQ(model.objects[0].faces[0].kind, ModelFace::Kind::axis);
      EXPECT_EQ(model.objects[0].faces[0].at, Vec3d(1, 2, 3));
    }
  };
  EXPECT_EQ(outcome(plain, read), "");
  EXPECT_EQ(found, 0u);
  EXPECT_EQ(outcome(with(face, 3), read), "");
  EXPECT_EQ(found, 3u);
  const auto changedFace = [&](const auto& change) {
    wire::Face lie = face;
    change(lie);
    return with(lie);
  };
  Speech shorter = with(face), early = with(face);
  shorter[shorter.size() - 2].payload.pop_back();
  // Before the object's own arrays.
  const auto object = std::find_if(early.begin(), early.end(), [](const Message& m) { return m.kind == Kind::object; });
  std::rotate(object + 1, early.end() - 2, early.end() - 1);
  for (const Speech& lie :
       {changedFace([](wire::Face& f) { f.kind = 3; }),
        changedFace([](wire::Face& f) { f.at[1] = std::numeric_limits<double>::quiet_NaN(); }),
        changedFace([](wire::Face& f) { f.along[2] = 0; }), changedFace([](wire::Face& f) { f.along[2] = 2; }),
        changedFace([](wire::Face& f) { f.across[0] = 0, f.across[2] = 1; }),
        changedFace([](wire::Face& f) { f.width = -1; }),
        changedFace([](wire::Face& f) { f.depth = std::numeric_limits<double>::infinity(); }), shorter, early,
        with(face, wire::kMostFaces + 1)})
    EXPECT_THAT(outcome(lie, read), HasSubstr("sent what it should not"));
}

TEST_F(SpokenReaderTest, OfClayIsBelievedInNothing) {
  clay::Grid grid;
  grid.voxelMm = 1;
  const auto ball = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 40);
  clay::Editor editor(ball);
  ball.forEachBrick([&](const clay::Brick& brick) {
    const std::vector<uint8_t> red(clay::kBrickVoxels, 200);
    editor.setChannel(clay::Channel::red, brick.coord, std::span<const uint8_t, clay::kBrickVoxels>(red));
    editor.setChannel(clay::Channel::cover, brick.coord, std::span<const uint8_t, clay::kBrickVoxels>(red));
  });
  const auto painted = editor.commit();
  const auto file = folder_ / "a.vdb";
  writeVdb(file, {{"first", painted}, {"second", ball}});
  const Speech speech = heard("vdb", file);
  const auto read = [&] {
    const auto objects = readVdb(file);
    ASSERT_EQ(objects.size(), 2u);
    for (const VdbObject& object : objects) ASSERT_EQ(object.version.stats().bricks, ball.stats().bricks);
  };
  ASSERT_NO_FATAL_FAILURE(expectNothingPasses(speech, read));
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const Speech& lie : {changed(speech, Kind::grid, offsetof(wire::Grid, rotation), 0.5),
                            changed(speech, Kind::grid, offsetof(wire::Grid, bricks), uint64_t{0}),
                            changed(speech, Kind::grid, offsetof(wire::Grid, bricks), uint64_t{1} << 40),
                            changed(speech, Kind::grid, offsetof(wire::Grid, tiles), uint64_t{1} << 40),
                            changed(speech, Kind::tiles, offsetof(wire::Tile, edge), int32_t{7}),
                            changed(speech, Kind::tiles, offsetof(wire::Tile, x), int32_t{1} << 30),
                            changed(speech, Kind::bricks, 0, int32_t{1} << 30)})
    EXPECT_THAT(outcome(lie, read), HasSubstr("sent what it should not"));
  for (const double voxel : {0.0, -1.0, kNone, 1e300})
    EXPECT_NE(outcome(changed(speech, Kind::grid, 0, voxel), read), "") << voxel;
}

}  // namespace
}  // namespace argil::io
