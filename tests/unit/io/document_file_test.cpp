// Documents: what a commit wrote is there, what had none is not, and only our own tables are opened.

#include "io/records/document_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <random>
#include <set>

#include "io/records/recovered_records.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

using samples::errorOf;
using samples::idsFromTo;
using samples::isSample;
using samples::putSample;
using samples::slurp;
using samples::soundSamples;
using samples::spill;

void save(DocumentFile& file, const std::vector<RecordId>& ids, RecordId head) {
  const auto transaction = file.begin();
  for (const RecordId id : ids) putSample(*transaction, id);
  transaction->commit(head, ids.empty() ? head + 1 : ids.back() + 1);
}

/// A program that is not ours.
void sql(const std::filesystem::path& path, const std::string& statements) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  sqlite3_exec(database, statements.c_str(), nullptr, nullptr, &message);
  EXPECT_EQ(message, nullptr) << message;
  sqlite3_close(database);
}

std::vector<RecordId> heldIds(DocumentFile& file, RecordId last) {
  std::vector<RecordId> ids;
  const RecordSet held = file.held();
  for (RecordId id = 1; id <= last; ++id) {
    if (held.contains(id)) ids.push_back(id);
  }
  return ids;
}

TEST(DocumentFile, AppearsWithItsFirstCommit) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  {
    const auto file = DocumentFile::create(path);
    EXPECT_EQ(file->save(), 0u);
    std::vector<std::byte> record;
    EXPECT_FALSE(file->get(1, record));
    const auto transaction = file->begin();
    putSample(*transaction, 1);
    EXPECT_FALSE(std::filesystem::exists(path));
    transaction->commit(1, 2);
    EXPECT_TRUE(isDocument(path));
    EXPECT_EQ(folder.entries(), 1u);
    EXPECT_EQ(file->save(), 1u);
    EXPECT_TRUE(file->get(1, record));
    EXPECT_TRUE(isSample(record, 1));
  }
  EXPECT_EQ(folder.entries(), 1u) << "a document at rest is one file";
  const auto file = DocumentFile::open(path, false);
  EXPECT_EQ(file->save(), 1u);
  EXPECT_EQ(file->head(), 1u);
  EXPECT_EQ(file->nextId(), 2u);
}

// The heap's bytes; zero under sanitizers, whose heap does not count.
size_t heapBytes() {
  const struct mallinfo2 heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

// Ids are 33 bits: what is kept for each that a file could have would be a gibibyte for a file of two records.
TEST(DocumentFile, RecordsNumberedHighCostNoMoreThanOthers) {
  constexpr RecordId kHighest = (RecordId{1} << 33) - 1;
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  {
    const auto file = DocumentFile::create(path);
    const auto transaction = file->begin();
    for (const RecordId id : {RecordId{1}, RecordId{1} << 32, kHighest}) putSample(*transaction, id);
    transaction->commit(1, kHighest + 1);
  }
  const auto file = DocumentFile::open(path, true);
  const size_t before = heapBytes();
  RecordSet held = file->held();
  RecordSet live = held;
  live.remove(RecordId{1} << 32);
  live.intersect(held);
  EXPECT_TRUE(held.contains(kHighest) && held.contains(RecordId{1} << 32) && !held.contains(kHighest - 1));
  EXPECT_EQ(held.without(live), std::vector<RecordId>{RecordId{1} << 32});
  EXPECT_LT(heapBytes() - before, size_t{1} << 20);
  const auto transaction = file->begin();
  transaction->removeAllBut(live);
  transaction->commit(1, kHighest + 1);
  EXPECT_FALSE(file->held().contains(RecordId{1} << 32));
  EXPECT_TRUE(file->held().contains(kHighest));
}

TEST(DocumentFile, WithoutACommitNothingIsLeft) {
  const samples::Folder folder;
  spill(folder / "old.argil", "old");
  {
    const auto file = DocumentFile::create(folder / "old.argil");
    (void)file->begin();
    const auto again = file->begin();
    putSample(*again, 1);
  }
  EXPECT_EQ(slurp(folder / "old.argil"), "old");
  EXPECT_EQ(folder.entries(), 1u);
  const auto file = DocumentFile::create(folder / "old.argil");
  save(*file, {1, 2}, 2);
  EXPECT_TRUE(isDocument(folder / "old.argil"));
  {
    const auto transaction = file->begin();
    putSample(*transaction, 3);
    std::vector<std::byte> record;
    EXPECT_TRUE(file->get(3, record)) << "a transaction sees what it has put";
  }
  EXPECT_EQ(heldIds(*file, 9), (std::vector<RecordId>{1, 2}));
  EXPECT_EQ(file->save(), 1u);
}

TEST(DocumentFile, SavesAddUpAndSurviveReopening) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  save(*DocumentFile::create(path), idsFromTo(1, 50), 50);
  for (RecordId n = 1; n <= 5; ++n) {
    const auto file = DocumentFile::open(path, true);
    EXPECT_EQ(file->save(), n);
    save(*file, idsFromTo(50 * n + 1, 50 * n + 50), 50 * n + 50);
    EXPECT_EQ(file->save(), n + 1);
  }
  const auto file = DocumentFile::open(path, false);
  EXPECT_EQ(soundSamples(*file, idsFromTo(1, 400)), idsFromTo(1, 300));
  EXPECT_EQ(heldIds(*file, 400), idsFromTo(1, 300));
  EXPECT_EQ(file->head(), 300u);
  EXPECT_EQ(file->nextId(), 301u);
}

TEST(DocumentFile, GetManyFindsWhatIsThereInAnyPattern) {
  const samples::Folder folder;
  const auto file = DocumentFile::create(folder / "a.argil");
  std::mt19937 random(5);
  std::vector<RecordId> there;
  for (RecordId id = 1; id < 4000; id += 1 + (id < 1000 ? 0 : random() % 20)) there.push_back(id);
  save(*file, there, there.back());
  for (const uint32_t step : {1u, 2u, 7u, 30u, 500u, 5000u}) {
    std::vector<RecordId> wanted, expected;
    for (RecordId id = 1; id < 5000; id += 1 + random() % step) wanted.push_back(id);
    std::set_intersection(wanted.begin(), wanted.end(), there.begin(), there.end(), std::back_inserter(expected));
    EXPECT_EQ(soundSamples(*file, wanted), expected) << "step " << step;
  }
  EXPECT_THROW(file->getMany(there, [](size_t, auto) { throw std::runtime_error("enough"); }), std::runtime_error);
  save(*file, {5000}, 5000);  // The lock of the broken-off reading is gone.
}

TEST(DocumentFile, EveryRecordLiesInOnePage) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  {
    const auto transaction = file->begin();
    const std::vector<std::byte> largest(kMostRecordBody, std::byte{7});
    for (RecordId id = 1; id <= 40; ++id)
      transaction->put({RecordKind::brick, RecordCodec::raw, 0, 1, (RecordId{1} << 32) + id}, largest);
    for (RecordId id = 1; id <= 100; ++id) putSample(*transaction, id);
    transaction->commit(1, (RecordId{1} << 32) + 100);
  }
  const std::string bytes = slurp(path);
  const auto all = samples::bytesOf(bytes);
  std::set<RecordId> found;
  for (size_t at = 0; (at = findRecord(all, at)) < all.size();) {
    const auto record = *parseRecord(all.subspan(at));
    EXPECT_EQ(at / 8192, (at + record.whole.size() - 1) / 8192);
    found.insert(record.header.id);
    at += record.whole.size();
  }
  EXPECT_EQ(found.size(), 140u);
}

TEST(DocumentFile, RemovesWhatIsNotLiveButNotWhatALaterArgilWrote) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  save(*file, idsFromTo(1, 600), 600);
  {
    const auto transaction = file->begin();
    transaction->put({static_cast<RecordKind>(99), RecordCodec::raw, 0, 0, 601}, samples::bodyOf(601));
    transaction->commit(600, 602);
  }
  const auto before = std::filesystem::file_size(path);
  RecordSet live;
  std::vector<RecordId> kept;
  for (RecordId id = 10; id <= 600; id += 10) {
    live.add(id);
    kept.push_back(id);
  }
  {
    const auto transaction = file->begin();
    transaction->removeAllBut(live);
    putSample(*transaction, 602);
    transaction->commit(600, 603);
  }
  kept.push_back(601);
  kept.push_back(602);
  EXPECT_EQ(heldIds(*file, 700), kept);
  EXPECT_LT(std::filesystem::file_size(path), before / 5) << "empty pages went back";
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_EQ(soundSamples(*file, idsFromTo(1, 700)), kept);
  // The same object goes on with the copy.
  save(*file, {603}, 603);
  EXPECT_EQ(DocumentFile::open(path, false)->save(), 4u);
}

TEST(DocumentFile, IsNotMixedWithTheJournalOfTheFileThatItReplaces) {
  const samples::Folder folder;
  const auto path = folder / "a.argil", journal = folder / "a.argil-journal";
  save(*DocumentFile::create(path), idsFromTo(1, 200), 200);
  // As another program leaves it that is killed in the middle of a transaction too large for its memory.
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "PRAGMA cache_size = 2; BEGIN; UPDATE record SET body = zeroblob(3000)", nullptr,
                         nullptr, nullptr),
            SQLITE_OK);
  const std::string halfWritten = slurp(path), hot = slurp(journal);
  sqlite3_close(other);
  const auto leave = [&] {
    spill(path, halfWritten);
    spill(journal, hot);
  };
  leave();
  EXPECT_EQ(soundSamples(*DocumentFile::open(path, false), idsFromTo(1, 300)), idsFromTo(1, 200)) << "rolled back";
  EXPECT_FALSE(std::filesystem::exists(journal));
  leave();
  save(*DocumentFile::create(path), {7}, 7);
  EXPECT_FALSE(std::filesystem::exists(journal));
  EXPECT_EQ(soundSamples(*DocumentFile::open(path, false), idsFromTo(1, 300)), std::vector<RecordId>{7});
  // A file that is no database any more is replaced as well.
  spill(path, "gone");
  spill(journal, hot);
  save(*DocumentFile::create(path), {8}, 8);
  EXPECT_EQ(soundSamples(*DocumentFile::open(path, false), idsFromTo(1, 300)), std::vector<RecordId>{8});
}

TEST(DocumentFile, WhoComesSecondIsTold) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto first = DocumentFile::create(path);
  save(*first, {1}, 1);
  EXPECT_EQ(heldIds(*first, 9), std::vector<RecordId>{1});
  const auto second = DocumentFile::open(path, true);
  save(*second, {2}, 2);
  const std::string told = errorOf([&] { (void)first->begin(); });
  EXPECT_NE(told.find("a.argil: was changed by another program"), std::string::npos) << told;
  // A replaced file, too.
  save(*DocumentFile::create(path), {1}, 1);
  EXPECT_NE(errorOf([&] { (void)second->begin(); }).find("was changed by another program"), std::string::npos);
  std::filesystem::remove(path);
  EXPECT_NE(errorOf([&] { (void)second->begin(); }).find("was changed by another program"), std::string::npos);
}

TEST(DocumentFile, SaysWhoHoldsIt) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  save(*file, {1}, 1);
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN EXCLUSIVE", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_NE(errorOf([&] { (void)file->begin(); }).find("a.argil: is in use by another program"), std::string::npos);
  sqlite3_close(other);
  save(*file, {2}, 2);
}

TEST(DocumentFile, KeepsItsLocksWhenTheSameProgramLooksAtTheFile) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  save(*file, {1}, 1);
  // Locks are seen by other processes alone. SQLite's lie at 2^30 (sqlite.org/fileformat2.html, "The lock-byte page").
  const auto locked = [&] {
    const pid_t child = ::fork();
    if (child == 0) {
      const int fd = ::open(path.c_str(), O_RDWR);
      struct flock lock {};
      lock.l_type = F_WRLCK;
      lock.l_start = 0x40000000;
      lock.l_len = 512;
      std::_Exit(::fcntl(fd, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK ? 1 : 0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WEXITSTATUS(status) == 1;
  };
  EXPECT_FALSE(locked());
  {
    const auto transaction = file->begin();
    putSample(*transaction, 2);
    EXPECT_TRUE(locked());
    EXPECT_TRUE(isDocument(path));
    { const RecoveredRecords found(path); }
    EXPECT_TRUE(locked());
    transaction->commit(2, 3);
  }
  EXPECT_FALSE(locked());
}

TEST(DocumentFile, ReadingNeverChangesTheFile) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  save(*DocumentFile::create(path), idsFromTo(1, 20), 20);
  const std::string before = slurp(path);
  const auto file = DocumentFile::open(path, false);
  EXPECT_EQ(soundSamples(*file, idsFromTo(1, 20)).size(), 20u);
  EXPECT_NE(errorOf([&] { (void)file->begin(); }).find("reading only"), std::string::npos);
  EXPECT_EQ(slurp(path), before);
}

TEST(DocumentFile, LinksAreFollowedAndPermissionsKept) {
  const samples::Folder folder;
  save(*DocumentFile::create(folder / "a.argil"), {1}, 1);
  ::chmod((folder / "a.argil").c_str(), 0640);
  std::filesystem::create_symlink("a.argil", folder / "link.argil");
  save(*DocumentFile::create(folder / "link.argil"), {1, 2}, 2);
  save(*DocumentFile::open(folder / "link.argil", true), {3}, 3);
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.argil"));
  EXPECT_EQ(DocumentFile::open(folder / "a.argil", false)->head(), 3u);
  EXPECT_EQ(std::filesystem::status(folder / "a.argil").permissions(), std::filesystem::perms(0640));
}

TEST(DocumentFile, RefusesWhatIsNoDocumentInOneSentence) {
  const samples::Folder folder;
  spill(folder / "text.argil", "a text");
  spill(folder / "empty.argil", "");
  sql(folder / "other.argil", "CREATE TABLE record(id INTEGER PRIMARY KEY)");
  std::filesystem::create_directory(folder / "folder.argil");
  for (const char* name : {"text.argil", "empty.argil", "other.argil", "folder.argil", "missing.argil"}) {
    const std::string told = errorOf([&] { (void)DocumentFile::open(folder / name, true); });
    EXPECT_NE(told.find(name), std::string::npos) << told;
  }
  EXPECT_NE(errorOf([&] { (void)DocumentFile::create(folder / "folder.argil"); }).find("is a folder"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { (void)DocumentFile::create(folder / "no" / "a.argil"); }).find("folder does not exist"),
            std::string::npos);
  EXPECT_NE(errorOf([&] { (void)DocumentFile::create("/dev/null"); }).find("not a regular file"), std::string::npos);
}

TEST(DocumentFile, RunsNothingThatAFileBrings) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  for (const char* code : {"CREATE TRIGGER t AFTER INSERT ON record BEGIN DELETE FROM record; END",
                           "CREATE VIEW v AS SELECT 1", "CREATE INDEX i ON record(length(body))",
                           "CREATE TABLE more(x)", "ALTER TABLE record ADD COLUMN y AS (length(body))"}) {
    save(*DocumentFile::create(path), {1}, 1);
    sql(path, code);
    const std::string told = errorOf([&] { (void)DocumentFile::open(path, true); });
    EXPECT_NE(told.find("a.argil: is damaged (its tables are not those of a document)"), std::string::npos) << told;
  }
}

TEST(DocumentFile, SaysWhichArgilAFileNeeds) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  // Through the same door as a later Argil: the facts are summed up again. Here by hand, so only refusals can be seen.
  save(*DocumentFile::create(path), {1}, 1);
  sql(path, "PRAGMA user_version = 7");
  save(*DocumentFile::open(path, true), {2}, 2);  // A later schema that this one may read.
  EXPECT_EQ(DocumentFile::open(path, true)->head(), 2u);
  sql(path,
      "UPDATE meta SET value = 7 WHERE key = 'needs'; UPDATE meta SET value = '9.1' WHERE key = 'written_by'; CREATE "
      "TABLE more(x); PRAGMA user_version = 7");
  EXPECT_NE(errorOf([&] {
              (void)DocumentFile::open(path, true);
            }).find("was written by Argil 9.1 and needs at least that to be read; nothing was opened"),
            std::string::npos);
}

TEST(DocumentFile, AChangedFactIsNoticed) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  for (const char* change :
       {"UPDATE meta SET value = 1 WHERE key = 'head'", "UPDATE meta SET value = 900 WHERE key = 'next_id'",
        "DELETE FROM meta WHERE key = 'save'", "UPDATE meta SET value = '2' WHERE key = 'head'"}) {
    save(*DocumentFile::create(path), {1, 2}, 2);
    sql(path, change);
    EXPECT_NE(errorOf([&] { (void)DocumentFile::open(path, true); }).find("is damaged (its table of facts"),
              std::string::npos)
        << change;
  }
}

TEST(DocumentFile, ADamagedPageCostsWhatIsInItAlone) {
  const samples::Folder folder;
  constexpr RecordId kLast = 400;
  save(*DocumentFile::create(folder / "a.argil"), idsFromTo(1, kLast), kLast);
  const std::string whole = slurp(folder / "a.argil");
  constexpr size_t kPage = 4096;
  int opened = 0, complete = 0, around = 0;
  for (size_t page = 5; page < whole.size() / kPage; page += 7) {
    std::string bytes = whole;
    for (size_t i = 0; i < 64; ++i) bytes[page * kPage + 2000 + i] ^= 0x5a;
    const auto path = folder / ("b" + std::to_string(page) + ".argil");
    spill(path, bytes);
    std::vector<RecordId> sound;
    try {
      sound = soundSamples(*DocumentFile::open(path, false), idsFromTo(1, kLast));
    } catch (const Error&) {
      continue;
    }
    ++opened;
    complete += sound.size() == kLast;
    around += sound.size() < kLast && sound.size() > kLast * 3 / 4 && sound.front() == 1 && sound.back() == kLast;
  }
  std::cout << opened << " opened, " << complete << " complete, " << around << " all around the damage\n";
  EXPECT_GT(around, opened / 2);
}

// Many at once find what each search by itself finds, wherever the damage stops the walk.
TEST(DocumentFile, GetManyGoesOnBehindADamagedPage) {
  const samples::Folder folder;
  constexpr RecordId kLast = 400;
  save(*DocumentFile::create(folder / "a.argil"), idsFromTo(1, kLast), kLast);
  const std::string whole = slurp(folder / "a.argil");
  constexpr size_t kPage = 4096;
  const std::vector<RecordId> wanted = idsFromTo(1, kLast);
  int stopped = 0;
  for (size_t page = 5; page < whole.size() / kPage; page += 7) {
    std::string bytes = whole;
    // Its head, so that the page cannot be walked over.
    for (size_t i = 0; i < 64; ++i) bytes[page * kPage + i] ^= 0x5a;
    spill(folder / "b.argil", bytes);
    std::vector<RecordId> each, many;
    try {
      const auto file = DocumentFile::open(folder / "b.argil", false);
      std::vector<std::byte> record;
      for (const RecordId id : wanted) {
        if (file->get(id, record)) each.push_back(id);
      }
      file->getMany(wanted, [&](size_t i, auto) { many.push_back(wanted[i]); });
    } catch (const Error&) {
      continue;
    }
    // A walk may even find what an inner page no longer leads to.
    EXPECT_TRUE(std::includes(many.begin(), many.end(), each.begin(), each.end())) << "page " << page;
    stopped += !each.empty() && each.size() < kLast;
  }
  EXPECT_GT(stopped, 0);
}

TEST(DocumentFile, TheChecksumOfFactsIsAsTheFormatSays) {
  // Over key, kind and value of each row in order, each with the sum so far as its seed; half of it, as a positive
  // number. Files of earlier versions are refused where this changes.
  const samples::Folder folder;
  save(*DocumentFile::create(folder / "a.argil"), {1, 2}, 2);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "a.argil").c_str(), &database), SQLITE_OK);
  sqlite3_stmt* all = nullptr;
  ASSERT_EQ(sqlite3_prepare_v2(database, "SELECT key, value, typeof(value) FROM meta ORDER BY key", -1, &all, nullptr),
            SQLITE_OK);
  uint64_t sum = 0;
  int64_t stored = -1;
  while (sqlite3_step(all) == SQLITE_ROW) {
    const auto text = [&](int i) { return std::string(reinterpret_cast<const char*>(sqlite3_column_text(all, i))); };
    if (text(0) == "check") {
      stored = sqlite3_column_int64(all, 1);
      continue;
    }
    const std::string row = text(0) + (text(2) == "integer" ? "\1" : "\2") + text(1);
    sum = XXH3_64bits_withSeed(row.data(), row.size(), sum);
  }
  sqlite3_finalize(all);
  sqlite3_close(database);
  EXPECT_EQ(stored, int64_t(sum >> 1));
}

}  // namespace
}  // namespace argil::io
