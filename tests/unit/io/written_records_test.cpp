// What a journal's writer has written is read back while it goes on, and when its file has gone.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "clay/base/error.h"
#include "io/records/journal_file.h"

namespace argil::io {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> body(RecordId id, size_t bytes) {
  return std::vector<std::byte>(bytes, static_cast<std::byte>(id * 37));
}

void put(JournalWriter& writer, RecordId id, size_t bytes) {
  writer.put({RecordKind::chunk, RecordCodec::raw, 0, 0, id}, body(id, bytes));
}

bool has(RecordSource& source, RecordId id, size_t bytes) {
  std::vector<std::byte> found;
  if (!source.get(id, found)) return false;
  const auto record = parseRecord(found);
  const auto wanted = body(id, bytes);
  return record && record->header.id == id &&
         std::equal(record->body.begin(), record->body.end(), wanted.begin(), wanted.end());
}

TEST(WrittenRecords, AreReadBackInAnyOrderAndByManyAtOnce) {
  for (const bool unnamed : {false, true}) {
    const fs::path file = fs::temp_directory_path() / ("argil-written-" + std::to_string(getpid())) / "1.journal";
    auto writer = std::make_unique<JournalWriter>(file, unnamed);
    EXPECT_EQ(fs::exists(file), !unnamed);
    const auto records = writer->records();
    const auto sizeOf = [](RecordId id) { return size_t(10 + 71 * id % 5000); };
    // Not in the order of their ids, with events and far gaps between.
    for (RecordId id = 1; id <= 900; ++id) {
      const RecordId shuffled = id * 677 % 1009;
      put(*writer, shuffled, sizeOf(shuffled));
      if (id % 50 == 0) writer->put({RecordKind::went, RecordCodec::raw, 0, 0, 0}, body(1, 7000));
    }
    EXPECT_FALSE(has(*records, 900 * 677 % 1009, sizeOf(900 * 677 % 1009))) << "still with the writer";
    writer->write();
    EXPECT_TRUE(has(*records, 900 * 677 % 1009, sizeOf(900 * 677 % 1009)));
    put(*writer, 5000, 100);
    put(*writer, 4000, 100);
    writer->sync();
    EXPECT_EQ(writer->synced(), writer->bytes());
    put(*writer, 677, 3000);  // again: the last one counts
    writer->write();
    const auto expectAll = [&] {
      std::vector<RecordId> ids;
      for (RecordId id = 1; id <= 1009; ++id) ids.push_back(id);
      ids.push_back(4000);
      ids.push_back(4500);
      size_t count = 0, before = 0;
      records->getMany(ids, [&](size_t index, std::span<const std::byte> bytes) {
        EXPECT_TRUE(count == 0 || index > before);
        before = index;
        ++count;
        const auto record = parseRecord(bytes);
        ASSERT_TRUE(record.has_value()) << ids[index];
        EXPECT_EQ(record->header.id, ids[index]);
        EXPECT_EQ(record->body.size(), ids[index] == 677 ? 3000 : ids[index] == 4000 ? 100 : sizeOf(ids[index]));
      });
      EXPECT_EQ(count, 901u);
      EXPECT_FALSE(has(*records, 4500, 1));
    };
    expectAll();
    writer->remove();
    writer.reset();
    expectAll();
    fs::remove_all(file.parent_path());
  }
}

}  // namespace
}  // namespace argil::io
