// RecoveredRecords: what is sound in a file is found, whatever became of the rest.

#include "io/records/recovered_records.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/records/blob.h"
#include "io/records/document_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

using samples::bodyOf;
using samples::errorOf;
using samples::idsFromTo;
using samples::putSample;
using samples::slurp;
using samples::soundSamples;
using samples::spill;

template <class Number>
void little(std::vector<std::byte>& bytes, Number value) {
  const auto* raw = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}

void putBrick(RecordSink& sink, RecordId id, uint32_t owner, int32_t x, int32_t y, int32_t z) {
  std::vector<std::byte> body;
  little(body, x);
  little(body, y);
  little(body, z);
  body.resize(60);
  sink.put({RecordKind::brick, RecordCodec::raw, 0, owner, id}, body);
}

// As putBlob() lays them out; takesWholeBlobsAsTheyAreWritten holds the two together.
void putChunk(RecordSink& sink, RecordId id, BlobKind kind, uint32_t index, uint32_t count, uint64_t checksum,
              uint64_t bytes = 100) {
  std::vector<std::byte> body;
  little(body, uint32_t(kind));
  little(body, index);
  little(body, count);
  little(body, uint32_t{0});
  little(body, bytes);
  little(body, checksum);
  body.resize(200);
  sink.put({RecordKind::chunk, RecordCodec::zstd, 0, 0, id}, body);
}

std::vector<RecordId> bricksAt(const RecoveredRecords& found, uint32_t owner, Coord place) {
  std::vector<RecordId> ids;
  found.bricksIn(owner, place, 1, [&](Coord, RecordId id) { ids.push_back(id); });
  return ids;
}

TEST(RecoveredRecords, FindsEveryRecordOfADocument) {
  const samples::Folder folder;
  const auto file = DocumentFile::create(folder / "a.argil");
  for (RecordId first = 1; first < 400; first += 100) {
    const auto transaction = file->begin();
    for (RecordId id = first; id < first + 100; ++id) putSample(*transaction, id);
    transaction->commit(first, first + 100);
  }
  RecoveredRecords found(folder / "a.argil");
  EXPECT_EQ(soundSamples(found, idsFromTo(1, 500)), idsFromTo(1, 400));
  EXPECT_EQ(found.highestId(), 400u);
  EXPECT_GE(found.records(), 400u);
  std::vector<std::byte> record;
  EXPECT_TRUE(found.get(7, record));
  EXPECT_TRUE(samples::isSample(record, 7));
  EXPECT_FALSE(found.get(401, record));
}

TEST(RecoveredRecords, FindsRecordsAcrossBlocksOfTheScan) {
  // Longer than several blocks, with other bytes between some.
  const samples::Folder folder;
  std::vector<std::byte> bytes;
  const RecordId count = 3500;
  for (RecordId id = 1; id <= count; ++id) {
    if (id % 3 == 0) bytes.insert(bytes.end(), id % 11, std::byte{0x8a});
    appendRecord(bytes, {RecordKind::node, RecordCodec::raw, 0, 1, id}, bodyOf(id));
  }
  ASSERT_GT(bytes.size(), size_t{3} * (size_t{4} << 20));
  spill(folder / "a", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  RecoveredRecords found(folder / "a");
  EXPECT_EQ(found.records(), count);
  EXPECT_EQ(soundSamples(found, idsFromTo(1, count)), idsFromTo(1, count));
}

TEST(RecoveredRecords, FindsARecordWhereverABlockOfTheScanEnds) {
  const samples::Folder folder;
  const size_t block = (size_t{4} << 20) + kMostRecordBytes - 1;
  for (const size_t before : {0, 1, 7, 8, 39, 40, 41, 3000, 5000, 7998, 7999, 8000}) {
    std::vector<std::byte> bytes(block - before);
    appendRecord(bytes, {RecordKind::node, RecordCodec::raw, 0, 1, 5}, samples::someBytes(kMostRecordBody, 1));
    appendRecord(bytes, {RecordKind::node, RecordCodec::raw, 0, 1, 6}, samples::someBytes(100, 1));
    spill(folder / "a", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    RecoveredRecords found(folder / "a");
    EXPECT_EQ(found.records(), 2u) << before;
    std::vector<std::byte> record;
    ASSERT_TRUE(found.get(5, record));
    EXPECT_EQ(parseRecord(record)->body.size(), kMostRecordBody);
  }
}

TEST(RecoveredRecords, KnowsWholeHeadsAndBricksByPlaceNewestFirst) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  {
    const auto transaction = file->begin();
    putBrick(*transaction, 1, 5, -1, 2, 3);
    putBrick(*transaction, 2, 5, -1, 2, 4);
    putBrick(*transaction, 3, 6, -1, 2, 3);
    putChunk(*transaction, 10, BlobKind::head, 0, 1, 77);
    putBrick(*transaction, 4, 5, -1, 2, 3);
    for (uint32_t i = 0; i < 3; ++i) putChunk(*transaction, 20 + i, BlobKind::head, i, 3, 78);
    for (uint32_t i = 0; i < 3; ++i) putChunk(*transaction, 30 + i, BlobKind::mesh, i, 3, 79);
    for (uint32_t i = 0; i < 2; ++i) putChunk(*transaction, 40 + i, BlobKind::head, i, 3, 80);  // A piece is missing.
    for (uint32_t i = 0; i < 2; ++i) putChunk(*transaction, 50 + i, BlobKind::head, i, 2, 81 + i);  // Of two blobs.
    putChunk(*transaction, 60, BlobKind::head, 0, 0xffffffff, 90);
    transaction->commit(20, 100);
  }
  const RecoveredRecords found(path);
  EXPECT_EQ(found.heads(), (std::vector<RecordId>{20, 10}));
  EXPECT_EQ(bricksAt(found, 5, {-1, 2, 3}), (std::vector<RecordId>{4, 1}));
  EXPECT_EQ(bricksAt(found, 6, {-1, 2, 3}), (std::vector<RecordId>{3}));
  EXPECT_TRUE(bricksAt(found, 5, {1, 2, 3}).empty());
}

TEST(RecoveredRecords, TakesWholeBlobsAsTheyAreWritten) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  RecordIds ids(1);
  RecordSet held;
  std::vector<RecordId> heads, states;
  {
    const auto transaction = file->begin();
    for (uint64_t i = 1; i <= 4; ++i) {
      const size_t size = i % 2 == 0 ? 30000 : 100;
      heads.push_back(putBlob(BlobKind::head, samples::someBytes(size, i), ids, held, *transaction));
      states.push_back(putBlob(BlobKind::state, samples::someBytes(size, 50 + i), ids, held, *transaction));
      (void)putBlob(BlobKind::mesh, samples::someBytes(size, 90 + i), ids, held, *transaction);
    }
    transaction->commit(heads.back(), ids.next());
  }
  RecoveredRecords found(path);
  EXPECT_EQ(found.heads(), std::vector<RecordId>(heads.rbegin(), heads.rend()));
  EXPECT_EQ(found.states(), std::vector<RecordId>(states.rbegin(), states.rend()));
  EXPECT_EQ(getBlob(BlobKind::state, states[1], found, 1 << 20), samples::someBytes(30000, 52));
}

TEST(RecoveredRecords, TakesNoTwoBlobsForOne) {
  // Chunks that fit but for the upper half of the checksum, or of the length.
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  constexpr uint64_t kUpper = uint64_t{1} << 40;
  {
    const auto transaction = file->begin();
    putChunk(*transaction, 10, BlobKind::state, 0, 2, 77);
    putChunk(*transaction, 11, BlobKind::state, 1, 2, 77 + kUpper);
    putChunk(*transaction, 20, BlobKind::state, 0, 2, 78, 100);
    putChunk(*transaction, 21, BlobKind::state, 1, 2, 78, 100 + kUpper);
    putChunk(*transaction, 30, BlobKind::state, 0, 2, 79 + kUpper, 100 + kUpper);
    putChunk(*transaction, 31, BlobKind::state, 1, 2, 79 + kUpper, 100 + kUpper);
    transaction->commit(1, 100);
  }
  EXPECT_EQ(RecoveredRecords(path).states(), std::vector<RecordId>{30});
}

TEST(RecoveredRecords, RefusesOnlyWhatCannotBeRead) {
  const samples::Folder folder;
  spill(folder / "empty", "");
  spill(folder / "text", "not a record");
  EXPECT_EQ(RecoveredRecords(folder / "empty").records(), 0u);
  EXPECT_EQ(RecoveredRecords(folder / "text").records(), 0u);
  EXPECT_NE(errorOf([&] { RecoveredRecords missing(folder / "missing"); }).find("missing: there is no such file"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { RecoveredRecords itself(folder.path()); }).find("is not a regular file"), std::string::npos);
  Job job;
  job.cancel();
  EXPECT_THROW(RecoveredRecords(folder / "text", &job), Cancelled);
}

TEST(RecoveredRecords, AFileThatBecomesShorterLosesOnlyWhatWasThere) {
  const samples::Folder folder;
  std::vector<std::byte> bytes;
  for (RecordId id = 1; id <= 20; ++id) appendRecord(bytes, {RecordKind::node, RecordCodec::raw, 0, 1, id}, bodyOf(id));
  spill(folder / "a", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  RecoveredRecords found(folder / "a");
  std::filesystem::resize_file(folder / "a", bytes.size() / 2);
  const auto sound = soundSamples(found, idsFromTo(1, 20));
  EXPECT_EQ(sound, idsFromTo(1, sound.size()));
  EXPECT_LT(sound.size(), 20u);
  EXPECT_GT(sound.size(), 2u);
}

}  // namespace
}  // namespace argil::io
