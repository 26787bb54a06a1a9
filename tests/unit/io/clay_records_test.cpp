// Clay as records: it comes back to the bit, shares what versions share, and is refused when a record lies.

#include "io/records/clay_records.h"

#include <gtest/gtest.h>

#include <set>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "io/records/node_body.h"
#include "tests/support/record_memory.h"

namespace argil::io {
namespace {

using clay::Version;
using testing::RecordMemory;

clay::Grid unitGrid() {
  clay::Grid grid;
  grid.voxelMm = 1;
  return grid;
}

Version ball(double radius = 25) {
  return clay::makeSphere(clay::Store::make(), unitGrid(), Vec3d::Zero(), radius);
}

Version dab(const Version& version, const Vec3d& at, double radius = 5, clay::Method method = clay::Method::carve) {
  clay::BrushStroke stroke(version, clay::Brush::of(method));
  stroke.apply({at, at, radius});
  return stroke.finish();
}

uint64_t distinctBricks(const Version& a, const Version& b) {
  uint64_t count = 0;
  Version::forEachDifference(a, b, [&](Coord, clay::Slot, clay::Slot now) { count += now.brick() != nullptr; });
  return count;
}

struct File {
  RecordIds ids;
  ClayRecords clay{ids};
  RecordMemory memory;
  RecordSet held;
  RecordId write(const Version& version, RecordCodec codec = RecordCodec::raw, uint32_t owner = 1) {
    return clay.write(version, owner, held, memory, codec);
  }
};

ReadClay readFresh(RecordMemory& memory, RecordId root, int threads = 2) {
  RecordIds ids;
  ClayRecords clay(ids);
  return clay.read(memory, root, unitGrid(), clay::Store::make(), nullptr, threads);
}

TEST(ClayRecords, ComesBackToTheBitInBothCodecs) {
  for (const RecordCodec codec : {RecordCodec::raw, RecordCodec::predicted}) {
    const Version version = dab(ball(), {20, 3, 1});
    File file;
    const RecordId root = file.write(version, codec);
    EXPECT_EQ(file.memory.puts[RecordKind::brick], version.stats().bricks);
    EXPECT_EQ(file.memory.puts[RecordKind::node], version.stats().nodes);
    EXPECT_EQ(file.memory.order.back(), root);
    for (const int threads : {1, 2, 5}) {
      const ReadClay read = readFresh(file.memory, root, threads);
      EXPECT_EQ(read.version.hash(), version.hash());
      EXPECT_EQ(read.version.stats().bricks, version.stats().bricks);
      EXPECT_EQ(read.version.stats().nodes, version.stats().nodes);
      EXPECT_EQ(read.bricksLost, 0u);
    }
    // The derived members of a brick too: the surface reads them.
    const ReadClay read = readFresh(file.memory, root);
    version.forEachBrick([&](const clay::Brick& brick) {
      const clay::Brick* back = read.version.find(brick.coord).brick();
      ASSERT_TRUE(back);
      ASSERT_TRUE(std::equal(std::begin(brick.inside), std::end(brick.inside), std::begin(back->inside)));
      ASSERT_EQ(brick.anyInside, back->anyInside);
      ASSERT_EQ(brick.anyOutside, back->anyOutside);
    });
  }
}

TEST(ClayRecords, EmptyAndSolidVersionsComeBack) {
  const Version empty = Version::empty(clay::Store::make(), unitGrid());
  clay::Editor editor(empty);
  editor.setBlock({0, 0, 0}, clay::kTreeLevels, clay::Tile::inside);
  const Version solid = editor.commit();
  File file;
  const RecordId none = file.write(empty), all = file.write(solid), other = file.write(empty, RecordCodec::raw, 2);
  EXPECT_EQ(std::set({none, all, other}).size(), 3u);
  EXPECT_EQ(file.write(empty), none);
  EXPECT_EQ(readFresh(file.memory, none).version.hash(), empty.hash());
  EXPECT_EQ(readFresh(file.memory, all).version.hash(), solid.hash());
}

TEST(ClayRecords, MostlySolidVersionsComeBack) {
  clay::Editor editor(Version::empty(clay::Store::make(), unitGrid()));
  editor.setBlock({0, 0, 0}, clay::kTreeLevels, clay::Tile::inside);
  editor.setBlock({0, 0, 0}, 2, clay::Tile::outside);
  editor.setBlock({20, 20, 20}, 1, clay::Tile::inside);
  editor.setTile({100, 20, 20}, clay::Tile::outside);
  const Version holed = editor.commit();
  File file;
  EXPECT_EQ(readFresh(file.memory, file.write(holed)).version.hash(), holed.hash());
}

TEST(ClayRecords, AStrokeWritesWhatItChanged) {
  Version version = ball();
  File file;
  file.write(version);
  for (int i = 0; i < 10; ++i) {
    const Version next = dab(version, {25 * std::cos(i * 0.6), 25 * std::sin(i * 0.6), 1});
    const uint64_t changed = distinctBricks(version, next);
    file.memory.puts.clear();
    const RecordId root = file.write(next);
    EXPECT_EQ(file.memory.puts[RecordKind::brick], changed);
    EXPECT_GT(changed, 0u);
    EXPECT_LE(file.memory.puts[RecordKind::node], 12u);
    file.memory.puts.clear();
    EXPECT_EQ(file.write(next), root);
    EXPECT_EQ(file.write(version), file.write(version));
    EXPECT_TRUE(file.memory.puts.empty());
    EXPECT_EQ(readFresh(file.memory, root).version.hash(), next.hash());
    version = next;
  }
}

TEST(ClayRecords, ChildrenStandBeforeTheirParents) {
  File file;
  file.write(dab(ball(), {20, 3, 1}));
  std::set<RecordId> seen;
  for (const RecordId id : file.memory.order) {
    if (file.memory.at(id).header.kind == RecordKind::node) {
      const auto node = parseNode(file.memory.at(id));
      ASSERT_TRUE(node);
      for (const RecordId child : node->ids) EXPECT_TRUE(seen.contains(child));
    }
    seen.insert(id);
  }
}

TEST(ClayRecords, TwoFilesShareIds) {
  const Version first = ball(), second = dab(first, {20, 3, 1});
  File file;
  file.write(first);
  RecordMemory journal;
  RecordSet held;
  const RecordId root = file.clay.write(second, 1, held, journal, RecordCodec::raw);
  EXPECT_EQ(file.write(second), root);
  for (const auto& [id, bytes] : file.memory.records)
    if (journal.records.contains(id)) {
      EXPECT_EQ(journal.records[id], bytes);
    }
  EXPECT_EQ(readFresh(journal, root).version.hash(), second.hash());
  EXPECT_EQ(readFresh(file.memory, root).version.hash(), second.hash());
}

TEST(ClayRecords, AFailedWriteIsDoneAgainUnderTheSameIds) {
  const Version version = ball();
  File whole;
  const RecordId expected = whole.write(version);
  File file;
  const RecordSet before = file.held;
  file.memory.failAfter = 20;
  EXPECT_THROW(file.write(version), Error);
  file.memory = {};
  file.held = before;
  EXPECT_EQ(file.write(version), expected);
  EXPECT_EQ(readFresh(file.memory, expected).version.hash(), version.hash());
}

TEST(ClayRecords, WhatWasReadIsNotWrittenAgain) {
  const Version version = dab(ball(), {20, 3, 1});
  File file;
  const RecordId root = file.write(version);
  RecordIds ids(file.ids.next());
  ClayRecords clay(ids);
  const Version back = clay.read(file.memory, root, unitGrid(), clay::Store::make()).version;
  EXPECT_EQ(clay.entries(), version.stats().bricks + version.stats().nodes);
  file.memory.puts.clear();
  EXPECT_EQ(clay.write(back, 1, file.held, file.memory, RecordCodec::raw), root);
  EXPECT_TRUE(file.memory.puts.empty());
  // And a stroke on it costs the stroke.
  const Version next = dab(back, {-20, 0, 0});
  const RecordId nextRoot = clay.write(next, 1, file.held, file.memory, RecordCodec::raw);
  EXPECT_EQ(file.memory.puts[RecordKind::brick], distinctBricks(back, next));
  EXPECT_EQ(readFresh(file.memory, nextRoot).version.hash(), next.hash());
}

TEST(ClayRecords, ReadingNearSharesWhatBothHave) {
  const Version first = dab(ball(), {20, 3, 1}),
                second = dab(dab(first, {-20, 3, 1}), {0, 25, 0}, 6, clay::Method::add);
  File file;
  const RecordId a = file.write(first), b = file.write(second);
  RecordIds ids(file.ids.next());
  ClayRecords clay(ids);
  const Version near = clay.read(file.memory, a, unitGrid(), clay::Store::make()).version;
  ClayRecords other(ids);  // knows nothing of `near`
  for (ClayRecords* reader : {&clay, &other}) {
    const Version back = reader->readNear(file.memory, b, near, a).version;
    EXPECT_EQ(back.hash(), second.hash());
    EXPECT_EQ(back.stats().bricks, second.stats().bricks);
    EXPECT_EQ(back.stats().nodes, second.stats().nodes);
    EXPECT_EQ(back.store(), near.store());
    EXPECT_EQ(distinctBricks(near, back), distinctBricks(first, second));
    const Version backAgain = reader->readNear(file.memory, a, back, b).version;
    EXPECT_EQ(backAgain.hash(), first.hash());
    if (reader == &other) clay.learn(other);
    file.memory.puts.clear();
    EXPECT_EQ(clay.write(back, 1, file.held, file.memory, RecordCodec::raw), b);
    EXPECT_EQ(clay.write(backAgain, 1, file.held, file.memory, RecordCodec::raw), a);
    EXPECT_TRUE(file.memory.puts.empty());
  }
  EXPECT_EQ(clay.readNear(file.memory, a, near, a).version, near);
}

TEST(ClayRecords, ForgetsWhatNobodyUses) {
  const Version first = ball();
  const Version second = dab(first, {20, 3, 1});
  File file;
  file.write(first);
  const size_t ofFirst = file.clay.entries();
  file.write(second);
  const size_t ofBoth = file.clay.entries();
  EXPECT_GT(ofBoth, ofFirst);
  const std::vector<Version> both{first, second};
  file.clay.forgetUnused(both);
  EXPECT_EQ(file.clay.entries(), ofBoth);
  file.clay.forgetUnused(std::span(both).last(1));
  EXPECT_EQ(file.clay.entries(), second.stats().bricks + second.stats().nodes);
  file.memory.puts.clear();
  file.write(second);
  EXPECT_TRUE(file.memory.puts.empty());
}

TEST(ClayRecords, MarksWhatATreeConsistsOf) {
  const Version first = ball(), second = dab(first, {20, 3, 1});
  File file;
  const RecordId a = file.write(first);
  const RecordId b = file.write(second);
  RecordSet live;
  markLive(file.memory, b, live);
  uint64_t count = 0;
  for (auto at = file.memory.records.begin(); at != file.memory.records.end();) {
    const bool is = live.contains(at->first);
    count += is;
    at = is ? std::next(at) : file.memory.records.erase(at);
  }
  EXPECT_EQ(count, second.stats().bricks + second.stats().nodes);
  EXPECT_EQ(readFresh(file.memory, b).version.hash(), second.hash());
  EXPECT_THROW(markLive(file.memory, a, live), Error);
}

TEST(ClayRecords, AStoreMayTakeOverTheAddressesOfAnother) {
  File file;
  RecordId before = 0;
  for (int i = 0; i < 5; ++i) {
    const Version version = ball(20 + i);  // its store goes with it
    const RecordId root = file.write(version);
    EXPECT_NE(root, before);
    EXPECT_EQ(readFresh(file.memory, root).version.hash(), version.hash());
    before = root;
  }
}

class LyingRecords : public ::testing::Test {
 protected:
  void SetUp() override {
    version_ = dab(ball(), {20, 3, 1});
    root_ = file_.write(version_);
    for (const auto& [id, bytes] : file_.memory.records) {
      const RecordView record = file_.memory.at(id);
      if (record.header.kind == RecordKind::brick) brick_ = id;
      if (record.header.kind == RecordKind::node) levels_[parseNode(record)->level] = id;
    }
  }
  template <class Change>
  void lieAboutNode(int level, const Change& change) {
    const RecordId id = levels_[level];
    RecordHeader header = file_.memory.at(id).header;
    NodeBody node = *parseNode(file_.memory.at(id));
    change(node, header);
    std::vector<std::byte> body;
    packNode(node, body);
    file_.memory.replace(header, body);
  }
  void expectRefused(const char* what) {
    try {
      (void)readFresh(file_.memory, root_);
      ADD_FAILURE() << "read although " << what;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind("damaged: ", 0), 0u) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_EQ(error.kind(), Error::Kind::work);
    }
  }

  Version version_;
  File file_;
  RecordId root_ = 0, brick_ = 0;
  std::map<int, RecordId> levels_;
};

TEST_F(LyingRecords, AMissingRecordIsNamed) {
  for (const RecordId id : {brick_, levels_[1], levels_[3], root_}) {
    const auto record = file_.memory.records.extract(id);
    expectRefused("one is missing");
    file_.memory.records[id] = record.mapped();
  }
  EXPECT_EQ(readFresh(file_.memory, root_).version.hash(), version_.hash());
}

TEST_F(LyingRecords, AnotherLevelIsRefused) {
  for (int level = 1; level <= clay::kTreeLevels; ++level) {
    const auto before = file_.memory.records;
    lieAboutNode(level, [](NodeBody& node, RecordHeader&) { node.level = node.level % clay::kTreeLevels + 1; });
    expectRefused("the level is another");
    file_.memory.records = before;
  }
}

TEST_F(LyingRecords, AnotherPlaceOrOwnerIsRefused) {
  const auto before = file_.memory.records;
  lieAboutNode(1, [](NodeBody& node, RecordHeader&) { node.first.x += 8; });
  expectRefused("the place is another");
  file_.memory.records = before;
  lieAboutNode(2, [](NodeBody&, RecordHeader& header) { header.owner = 7; });
  expectRefused("the owner is another");
  file_.memory.records = before;
  RecordHeader header = file_.memory.at(brick_).header;
  header.owner = 9;
  const std::vector<std::byte> body(file_.memory.at(brick_).body.begin(), file_.memory.at(brick_).body.end());
  file_.memory.replace(header, body);
  expectRefused("the brick's owner is another");
}

TEST_F(LyingRecords, CyclesAndSharedChildrenAreRefused) {
  const auto before = file_.memory.records;
  lieAboutNode(2, [&](NodeBody& node, RecordHeader&) { node.ids[0] = root_; });
  expectRefused("a node refers to its root");
  file_.memory.records = before;
  lieAboutNode(1, [](NodeBody& node, RecordHeader&) { node.ids[1] = node.ids[0]; });
  expectRefused("two places have one brick");
  file_.memory.records = before;
  lieAboutNode(2, [&](NodeBody& node, RecordHeader&) { node.ids[0] = brick_; });
  expectRefused("a node's child is a brick");
  file_.memory.records = before;
  lieAboutNode(1, [&](NodeBody& node, RecordHeader&) { node.ids[0] = 0; });
  expectRefused("a child is no record");
}

TEST_F(LyingRecords, AnyByteOfANodeIsReadOrRefused) {
  const RecordId id = levels_[1];
  const RecordHeader header = file_.memory.at(id).header;
  const std::vector<std::byte> body(file_.memory.at(id).body.begin(), file_.memory.at(id).body.end());
  int refused = 0;
  for (size_t at = 0; at < body.size(); ++at) {
    for (const int bit : {0, 5, 7}) {
      std::vector<std::byte> changed = body;
      changed[at] ^= std::byte(1u << bit);
      file_.memory.replace(header, changed);
      try {
        (void)readFresh(file_.memory, root_, 1).version.hash();
      } catch (const Error&) {
        ++refused;
      }
    }
    file_.memory.replace(header, std::span(body).first(at));
    EXPECT_THROW((void)readFresh(file_.memory, root_, 1), Error);
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace argil::io
