// Documents and journals that were cut off or damaged at a thousand places: what is intact is given, what is not is
// told; nothing wrong is ever given, nothing crashes.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>
#include <random>
#include <set>

#include "io/records/document_file.h"
#include "io/records/journal_file.h"
#include "io/records/recovered_records.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

using samples::errorOf;
using samples::idsFromTo;
using samples::slurp;
using samples::spill;

constexpr uint32_t kSeed = 20264;
constexpr int kPlaces = 1000;
constexpr RecordId kRecords = 300;

std::vector<std::byte> smallBody(RecordId id) {
  return samples::someBytes(id * 37 % 700, id);
}

void putSmall(RecordSink& sink, RecordId id) {
  sink.put({id % 3 == 0 ? RecordKind::node : RecordKind::brick, RecordCodec::raw, 0, 1, id}, smallBody(id));
}

/// Of what a source gives: the ids with the content that they were given. Anything sound but different fails the test.
std::set<RecordId> soundOf(RecordSource& source) {
  std::set<RecordId> sound;
  const auto ids = idsFromTo(1, kRecords + 10);
  source.getMany(ids, [&](size_t i, std::span<const std::byte> bytes) {
    const auto record = parseRecord(bytes);
    if (!record) return;
    const auto body = smallBody(ids[i]);
    EXPECT_EQ(record->header.id, ids[i]);
    EXPECT_TRUE(std::equal(body.begin(), body.end(), record->body.begin(), record->body.end()))
        << "record " << ids[i] << " has become another";
    sound.insert(ids[i]);
  });
  return sound;
}

/// One kind of damage to a whole file: which bytes were changed, and from where all are gone.
struct Damage {
  std::string bytes;
  std::set<size_t> changed;
  std::string told;

  Damage(const std::string& whole, std::mt19937& random) : bytes(whole) {
    const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
    const size_t at = below(whole.size());
    switch (below(4)) {
      case 0:
        bytes.resize(at);
        told = "cut at " + std::to_string(at);
        break;
      case 1:
        change(at, char(bytes[at] ^ char(1u << below(8))));
        told = "a bit flipped at " + std::to_string(at);
        break;
      case 2:
        for (size_t i = at; i < std::min(whole.size(), at + 512); ++i) change(i, 0);
        told = "a sector of zeros at " + std::to_string(at);
        break;
      default:
        for (size_t i = 0; i < 5; ++i) change(below(whole.size()), char(below(256)));
        // The places that decide how a database is read: headers of the file and of its pages.
        change(below(2) == 0 ? below(100) : below(whole.size() / 8192) * 8192 + below(16), char(below(256)));
        told = "six bytes changed";
    }
  }
  void change(size_t at, char value) {
    if (bytes[at] == value) return;
    bytes[at] = value;
    changed.insert(at);
  }
  [[nodiscard]] bool leaves(size_t at, size_t size) const {
    const auto next = changed.lower_bound(at);
    return at + size <= bytes.size() && (next == changed.end() || *next >= at + size);
  }
};

/// The ids of which at least one copy is untouched.
std::set<RecordId> untouched(const std::string& whole, const Damage& damage) {
  std::set<RecordId> ids;
  const auto all = samples::bytesOf(whole);
  for (size_t at = 0; (at = findRecord(all, at)) < all.size();) {
    const auto record = *parseRecord(all.subspan(at));
    if (record.header.id != 0 && damage.leaves(at, record.whole.size())) ids.insert(record.header.id);
    at += record.whole.size();
  }
  return ids;
}

bool contains(const std::set<RecordId>& all, const std::set<RecordId>& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

TEST(DamagedDocuments, GiveWhatIsIntactOrSayWhy) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  // In another process: one that has written a file itself does not look for damage again.
  const pid_t writer = ::fork();
  if (writer == 0) {
    const auto file = DocumentFile::create(path);
    for (RecordId first = 1; first <= kRecords; first += 100) {
      const auto transaction = file->begin();
      if (first > 100) {
        RecordSet live;
        for (RecordId id = 1; id < first; ++id) {
          if (id % 4 != 0) live.add(id);
        }
        transaction->removeAllBut(live);
      }
      for (RecordId id = first; id < first + 100; ++id) putSmall(*transaction, id);
      transaction->commit(first, first + 100);
    }
    std::_Exit(0);
  }
  int status = 0;
  ::waitpid(writer, &status, 0);
  ASSERT_EQ(status, 0);
  const std::string whole = slurp(path);
  const std::set<RecordId> written = soundOf(*DocumentFile::open(path, false));
  ASSERT_EQ(written.size(), kRecords - 50);
  int refused = 0, complete = 0, lossy = 0, saved = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const Damage damage(whole, random);
    SCOPED_TRACE(damage.told);
    std::filesystem::remove(path);  // Some file systems flush a file that is written over.
    spill(path, damage.bytes);
    {
      RecoveredRecords found(path);
      EXPECT_TRUE(contains(soundOf(found), untouched(whole, damage)));
    }
    std::unique_ptr<DocumentFile> file;
    try {
      file = DocumentFile::open(path, false);
    } catch (const Error& error) {
      const std::string told = error.what();
      EXPECT_NE(told.find("a.argil: "), std::string::npos) << told;
      EXPECT_EQ(told.find_first_of("\r\n"), std::string::npos) << told;
      ++refused;
      continue;
    }
    EXPECT_EQ(file->head(), 201u);
    EXPECT_EQ(file->save(), 3u);
    EXPECT_EQ(file->nextId(), 301u);
    const auto sound = soundOf(*file);
    // What was removed may come back where a page has become an old one; what is given is what was written.
    const bool all = contains(sound, written);
    ++(all ? complete : lossy);
    try {
      (void)file->held();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("is damaged"), std::string::npos) << error.what();
    }
    // A save into it succeeds or is refused; it takes nothing that was there. Not each time, for the disk's sake.
    if (i % 4 == 0) try {
        file = DocumentFile::open(path, true);
        const auto transaction = file->begin();
        for (RecordId id = kRecords + 1; id <= kRecords + 10; ++id) putSmall(*transaction, id);
        transaction->commit(201, kRecords + 11);
        ++saved;
        EXPECT_TRUE(contains(soundOf(*file), sound));
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("a.argil: "), std::string::npos) << error.what();
      }
    if (HasFailure()) FAIL() << "place " << i;
  }
  std::cout << refused << " refused, " << complete << " complete, " << lossy << " opened with losses, " << saved
            << " saved into\n";
  EXPECT_GT(refused, kPlaces / 5);
  EXPECT_GT(complete, kPlaces / 20);
  EXPECT_GT(lossy, kPlaces / 20);
}

TEST(DamagedJournals, GiveEveryRecordThatIsUntouched) {
  std::mt19937 random(kSeed);
  const samples::Folder folder;
  const auto path = folder / "a";
  {
    JournalWriter writer(path);
    for (RecordId id = 1; id <= kRecords; ++id) {
      putSmall(writer, id);
      if (id % 10 == 0) writer.put({RecordKind::step, RecordCodec::raw, 0, 0, 0}, smallBody(id));
    }
    writer.sync();
  }
  const std::string whole = slurp(path);
  for (int i = 0; i < kPlaces; ++i) {
    const Damage damage(whole, random);
    SCOPED_TRACE(damage.told);
    std::filesystem::remove(path);  // Some file systems flush a file that is written over.
    spill(path, damage.bytes);
    JournalReader reader(path, true);
    const auto intact = untouched(whole, damage);
    EXPECT_EQ(soundOf(reader), intact);
    size_t events = 0;
    reader.forEachEvent([&](const RecordView& record, uint64_t) {
      ++events;
      EXPECT_EQ(record.header.kind, RecordKind::step);
    });
    EXPECT_EQ(reader.records(), intact.size() + events);
    EXPECT_LE(events, 30u);
    if (HasFailure()) FAIL() << "place " << i;
  }
}

}  // namespace
}  // namespace argil::io
