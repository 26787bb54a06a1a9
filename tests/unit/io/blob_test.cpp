// Blobs: any length comes back, and nothing else than what was stored.

#include "io/records/blob.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/base/error.h"
#include "tests/support/record_memory.h"

namespace argil::io {
namespace {

using testing::RecordMemory;

std::vector<std::byte> someBytes(size_t count, bool packable) {
  std::mt19937 random(11);
  std::vector<std::byte> bytes(count);
  for (std::byte& each : bytes) each = static_cast<std::byte>(packable ? random() % 3 : random());
  return bytes;
}

TEST(Blob, ComesBackWhateverItsLength) {
  for (const bool packable : {false, true}) {
    for (const size_t size :
         {size_t{0}, size_t{1}, size_t{5000}, kMostRecordBody - 32, kMostRecordBody - 31, size_t{300000}}) {
      RecordMemory memory;
      RecordIds ids(17);
      RecordSet held;
      const auto bytes = someBytes(size, packable);
      const RecordId id = putBlob(BlobKind::mesh, bytes, ids, held, memory);
      EXPECT_EQ(id, 17u);
      EXPECT_EQ(ids.next(), 17 + memory.records.size());
      EXPECT_EQ(getBlob(BlobKind::mesh, id, memory, size), bytes) << size;
      if (packable && size > 5000) {
        EXPECT_LT(memory.bytesPut, size / 3);
      }
      RecordSet live;
      markBlob(memory, id, live);
      for (const auto& [each, record] : memory.records) EXPECT_TRUE(live.contains(each) && held.contains(each));
      EXPECT_FALSE(live.contains(id - 1) || live.contains(ids.next()));
    }
  }
}

TEST(Blob, AnythingElseIsRefused) {
  RecordMemory memory;
  RecordIds ids;
  RecordSet held, live;
  const auto bytes = someBytes(30000, false);
  const RecordId id = putBlob(BlobKind::picture, bytes, ids, held, memory);
  ASSERT_GT(memory.records.size(), 3u);
  EXPECT_THROW((void)getBlob(BlobKind::mesh, id, memory, 1 << 20), Error);
  EXPECT_THROW((void)getBlob(BlobKind::picture, id, memory, bytes.size() - 1), Error);
  EXPECT_THROW((void)getBlob(BlobKind::picture, id + 1, memory, 1 << 20), Error);
  EXPECT_THROW((void)getBlob(BlobKind::picture, 0, memory, 1 << 20), Error);
  const auto before = memory.records;
  for (const auto& [lost, record] : before) {
    memory.records.erase(lost);
    EXPECT_THROW((void)getBlob(BlobKind::picture, id, memory, 1 << 20), Error);
    EXPECT_THROW(markBlob(memory, id, live), Error);
    memory.records = before;
  }
  // Two chunks that changed places, with sound checksums of their own.
  RecordHeader second = memory.at(id + 1).header, third = memory.at(id + 2).header;
  std::swap(second.id, third.id);
  memory.replace(second, parseRecord(before.at(id + 1))->body);
  memory.replace(third, parseRecord(before.at(id + 2))->body);
  EXPECT_THROW((void)getBlob(BlobKind::picture, id, memory, 1 << 20), Error);
}

TEST(Blob, AnyChangedByteIsRefused) {
  for (const bool packable : {false, true}) {
    RecordMemory memory;
    RecordIds ids;
    RecordSet held;
    const auto bytes = someBytes(9000, packable);
    const RecordId id = putBlob(BlobKind::state, bytes, ids, held, memory);
    const RecordHeader header = memory.at(id).header;
    const std::vector<std::byte> body(memory.at(id).body.begin(), memory.at(id).body.end());
    for (size_t at = 0; at < std::min<size_t>(body.size(), 600); ++at) {
      std::vector<std::byte> changed = body;
      changed[at] ^= std::byte{4};
      memory.replace(header, changed);
      try {
        EXPECT_EQ(getBlob(BlobKind::state, id, memory, 1 << 20), bytes) << at;  // reserved bytes mean nothing
        EXPECT_TRUE((at > 0 && at < 4) || (at >= 12 && at < 16) || packable) << at;
      } catch (const Error&) {
      }
    }
  }
}

}  // namespace
}  // namespace argil::io
