// Colour, material and mask as records: they come back to the bit, share what versions share, and what is lost of them
// is unset.

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cmath>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "io/records/channel_codec.h"
#include "io/records/clay_records.h"
#include "io/records/document_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_memory.h"

namespace argil::io {
namespace {

using clay::Channel;
using clay::Version;
using testing::RecordMemory;

clay::Grid unitGrid() {
  clay::Grid grid;
  grid.voxelMm = 1;
  return grid;
}

Version ball() {
  return clay::makeSphere(clay::Store::make(), unitGrid(), Vec3d::Zero(), 25);
}

Version painted(const Version& version, const Vec3d& at, clay::Property property, double radius = 8) {
  auto brush = std::make_shared<clay::Brush>();
  brush->operations.push_back({property, clay::Method::set, clay::Falloff::smooth, 1});
  brush->colour = {200, 90, 10};
  brush->material = 3;
  clay::BrushStroke stroke(version, brush);
  stroke.apply(clay::Stamp{at, at, radius});
  return stroke.finish();
}

Version colourful() {
  return painted(painted(painted(ball(), {25, 0, 0}, clay::Property::colour), {0, 25, 0}, clay::Property::material),
                 {0, 18, 18}, clay::Property::mask);
}

struct File {
  RecordIds ids;
  ClayRecords clay{ids};
  RecordMemory memory;
  RecordSet held;
  RecordId write(const Version& version, RecordCodec codec = RecordCodec::raw) {
    return clay.write(version, 1, held, memory, codec);
  }
};

ReadClay readFresh(RecordMemory& memory, RecordId root, const OlderBricks* repair = nullptr) {
  RecordIds ids;
  ClayRecords clay(ids);
  return clay.read(memory, root, unitGrid(), clay::Store::make(), nullptr, 2, repair, 1);
}

TEST(ChannelRecords, ComeBackToTheBitAndClayWithoutAnyIsWrittenAsBefore) {
  const Version version = colourful();
  for (const RecordCodec codec : {RecordCodec::raw, RecordCodec::predicted}) {
    File file;
    const RecordId root = file.write(version, codec);
    EXPECT_EQ(file.memory.puts[RecordKind::channelBrick], version.stats().channelBricks);
    EXPECT_EQ(file.memory.puts[RecordKind::node], version.stats().nodes);
    EXPECT_EQ(file.memory.puts[RecordKind::clay], 1u);
    const ReadClay back = readFresh(file.memory, root);
    EXPECT_EQ(back.version.hash(), version.hash());
    EXPECT_TRUE(back.notes.empty());
  }
  File bare;
  (void)bare.write(ball());
  EXPECT_EQ(bare.memory.puts[RecordKind::channelBrick] + bare.memory.puts[RecordKind::clay], 0u);
}

TEST(ChannelRecords, AStrokeOfPaintWritesItsBytesAlone) {
  File file;
  const Version first = colourful();
  const RecordId firstRoot = file.write(first);
  EXPECT_EQ(file.write(first), firstRoot);
  file.memory.puts.clear();
  const Version second = painted(first, {0, 0, -25}, clay::Property::mask, 5);
  const RecordId root = file.write(second);
  EXPECT_EQ(file.memory.puts[RecordKind::brick], 0u);
  EXPECT_GT(file.memory.puts[RecordKind::channelBrick], 0u);
  EXPECT_LT(file.memory.puts[RecordKind::channelBrick], 30u);
  EXPECT_LE(file.memory.puts[RecordKind::node], 12u);
  EXPECT_EQ(file.clay.rootOf(second, 1), root);
  EXPECT_EQ(file.clay.rootOf(first, 1), firstRoot);
  EXPECT_NE(root, firstRoot);
  const std::array inUse{second};
  file.clay.forgetUnused(inUse);
  EXPECT_EQ(file.clay.rootOf(second, 1), root);
  EXPECT_EQ(file.clay.rootOf(first, 1), 0u);
}

TEST(ChannelRecords, WhatWasReadIsNotWrittenAgain) {
  File file;
  const RecordId root = file.write(colourful(), RecordCodec::predicted);
  RecordIds ids(file.ids.next());
  ClayRecords clay(ids);
  const Version back = clay.read(file.memory, root, unitGrid(), clay::Store::make()).version;
  EXPECT_EQ(clay.write(back, 1, file.held, file.memory, RecordCodec::raw), root);
  file.memory.puts.clear();
  (void)clay.write(painted(back, {0, 0, -25}, clay::Property::colour, 5), 1, file.held, file.memory, RecordCodec::raw);
  EXPECT_EQ(file.memory.puts[RecordKind::brick], 0u);
  EXPECT_LT(file.memory.puts[RecordKind::channelBrick], 60u);
}

TEST(ChannelRecords, NearVersionsShareAndEveryWayLeadsBack) {
  File file;
  const Version bare = ball(), first = painted(bare, {25, 0, 0}, clay::Property::colour),
                second = painted(first, {0, 25, 0}, clay::Property::mask);
  clay::BrushStroke cut(second, clay::Brush::of(clay::Method::carve));
  cut.apply(clay::Stamp{{22, 0, 0}, {22, 8, 0}, 6});
  const std::vector<Version> versions{bare, first, second, cut.finish()};
  std::vector<RecordId> roots;
  for (const Version& each : versions) roots.push_back(file.write(each));
  for (size_t a = 0; a < versions.size(); ++a)
    for (size_t b = 0; b < versions.size(); ++b) {
      RecordIds ids(file.ids.next());
      ClayRecords clay(ids);
      const Version near = clay.read(file.memory, roots[a], unitGrid(), clay::Store::make()).version;
      const Version back = clay.readNear(file.memory, roots[b], near, roots[a]).version;
      ASSERT_EQ(back.hash(), versions[b].hash()) << a << ' ' << b;
      ASSERT_EQ(clay.write(back, 1, file.held, file.memory, RecordCodec::raw), roots[b]) << a << ' ' << b;
      // What did not change is the same brick.
      size_t other = 0, changed = 0;
      for (const Channel channel : clay::kAllChannels) {
        Version::forEachDifference(channel, near, back, [&](Coord, clay::ChannelSlot, clay::ChannelSlot) { ++other; });
        Version::forEachDifference(channel, versions[a], versions[b],
                                   [&](Coord, clay::ChannelSlot, clay::ChannelSlot) { ++changed; });
      }
      EXPECT_EQ(other, changed);
    }
}

TEST(ChannelRecords, WhatIsLostIsUnsetAndTold) {
  const Version version = colourful();
  File file;
  const RecordId root = file.write(version);
  std::vector<RecordId> bricks;
  for (const auto& [id, bytes] : file.memory.records)
    if (parseRecord(bytes)->header.kind == RecordKind::channelBrick) bricks.push_back(id);
  for (size_t i = 0; i < bricks.size(); i += 7) {
    const std::vector<std::byte> kept = file.memory.records.at(bricks[i]);
    file.memory.records.erase(bricks[i]);
    EXPECT_THROW((void)readFresh(file.memory, root), Error);
    const ReadClay back = readFresh(file.memory, root, &file.memory);
    ASSERT_EQ(back.notes.size(), 1u);
    EXPECT_NE(back.notes[0].find("1 places of colour"), std::string::npos);
    size_t different = 0;
    for (const Channel channel : clay::kAllChannels) {
      version.forEachBrick(channel, [&](const clay::ChannelBrick& brick) {
        different += back.version.find(channel, brick.coord) == clay::ChannelSlot();
      });
    }
    EXPECT_EQ(different, 1u);
    file.memory.records[bricks[i]] = kept;
  }
}

TEST(ChannelRecords, EveryLostRecordIsRefusedOrMended) {
  File file;
  const RecordId root = file.write(painted(ball(), {25, 0, 0}, clay::Property::colour));
  const auto records = file.memory.records;
  size_t tried = 0;
  for (const auto& [id, bytes] : records) {
    if (parseRecord(bytes)->header.kind == RecordKind::brick) continue;
    file.memory.records.erase(id);
    EXPECT_THROW((void)readFresh(file.memory, root), Error);
    const ReadClay back = readFresh(file.memory, root, &file.memory);
    EXPECT_FALSE(back.notes.empty());
    file.memory.records.emplace(id, bytes);
    ++tried;
  }
  EXPECT_GT(tried, 30u);
}

TEST(ChannelRecords, BytesBesideTheClayAreLeftOut) {
  // A record whose every byte is set, in the place of one of a painted spot.
  File file;
  const Version version = painted(ball(), {25, 0, 0}, clay::Property::mask);
  const RecordId root = file.write(version);
  for (auto& [id, bytes] : file.memory.records) {
    const RecordView record = *parseRecord(bytes);
    if (record.header.kind != RecordKind::channelBrick) continue;
    std::vector<std::byte> body(record.body.begin(), record.body.end());
    std::fill(body.begin() + 12, body.end(), std::byte{77});
    RecordHeader header = record.header;
    bytes.clear();
    appendRecord(bytes, header, body);
  }
  const Version back = readFresh(file.memory, root).version;
  size_t set = 0;
  back.forEachBrick(Channel::mask, [&](const clay::ChannelBrick& brick) {
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      const float phi = back.find(brick.coord).phi(i, 3);
      ASSERT_EQ(brick.value[i], std::abs(phi) < 3 ? 77 : 0);
      set += brick.value[i] != 0;
    }
  });
  EXPECT_GT(set, 100u);
}

TEST(ChannelRecords, BricksAndHeadsOfAnyBytesAreToldApart) {
  std::vector<std::byte> body;
  packClayHead({5, {0, 0, 7, 8, 0, 9}}, body);
  const auto parse = [&](RecordId id) {
    return parseClayHead({{RecordKind::clay, RecordCodec::raw, static_cast<uint16_t>(body.size()), 1, id}, body, {}});
  };
  ASSERT_TRUE(parse(10));
  EXPECT_EQ(parse(10)->channels[5], 9u);
  EXPECT_FALSE(parse(9));  // what it refers to is older than it
  for (size_t length = 0; length < body.size(); ++length) {
    const RecordView cut{
        {RecordKind::clay, RecordCodec::raw, static_cast<uint16_t>(length), 1, 10}, std::span(body).first(length), {}};
    EXPECT_TRUE(length % 9 == 8 || !parseClayHead(cut)) << length;
  }
  clay::ChannelBrick brick{};
  for (int i = 0; i < clay::kBrickVoxels; ++i) brick.value[i] = static_cast<uint8_t>(i / 100);
  brick.coord = {-3, 4, 5};
  for (RecordCodec codec : {RecordCodec::raw, RecordCodec::predicted}) {
    packChannelBrick(brick, codec, body);
    uint8_t values[clay::kBrickVoxels];
    EXPECT_EQ(unpackChannelBrick({{RecordKind::channelBrick, codec, 0, 1, 2}, body, {}}, values), brick.coord);
    EXPECT_TRUE(std::equal(std::begin(values), std::end(values), brick.value));
    for (size_t length = 0; length < body.size(); ++length)
      EXPECT_FALSE(
          unpackChannelBrick({{RecordKind::channelBrick, codec, 0, 1, 2}, std::span(body).first(length), {}}, values))
          << length;
  }
}

int schemaNeeded(const std::filesystem::path& path) {
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  sqlite3_stmt* query = nullptr;
  EXPECT_EQ(sqlite3_prepare_v2(database, "SELECT value FROM meta WHERE key = 'needs'", -1, &query, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_step(query), SQLITE_ROW);
  const int needs = sqlite3_column_int(query, 0);
  sqlite3_finalize(query);
  sqlite3_close(database);
  return needs;
}

TEST(ChannelRecords, AFileNeedsALaterArgilOnlyWhereItHasChannels) {
  const samples::Folder folder;
  for (const Version& version : {ball(), colourful()}) {
    const bool channels = version.has(Channel::cover);
    const auto path = folder / (channels ? "painted.argil" : "bare.argil");
    auto file = DocumentFile::create(path);
    RecordIds ids;
    ClayRecords clay(ids);
    RecordSet held;
    auto transaction = file->begin();
    const RecordId root = clay.write(version, 1, held, *transaction, RecordCodec::predicted);
    transaction->commit(root, ids.next());
    EXPECT_EQ(schemaNeeded(path), channels ? 2 : 1);
    // Nothing dead, so nothing goes: a later save keeps what it needs.
    RecordSet live;
    markLive(*file, root, live);
    transaction = file->begin();
    transaction->removeAllBut(live);
    transaction->commit(root, ids.next());
    EXPECT_EQ(schemaNeeded(path), channels ? 2 : 1);
    RecordIds freshIds;
    ClayRecords fresh(freshIds);
    EXPECT_EQ(fresh.read(*file, root, unitGrid(), clay::Store::make()).version.hash(), version.hash());
  }
}

}  // namespace
}  // namespace argil::io
