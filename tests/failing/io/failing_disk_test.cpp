// Every call of a save or of a journal that can fail for want of space or by a bad disk does so once: the old content
// stands, and the person is told.

#include <gtest/gtest.h>

#include <cerrno>
#include <system_error>

#include "io/records/document_file.h"
#include "io/records/journal_file.h"
#include "tests/support/failing_writes.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

using samples::idsFromTo;
using samples::putSample;
using samples::soundSamples;

/// How a disk fails.
struct Failure {
  int error;
  bool once, shortFirst;
};
constexpr Failure kFailures[] = {{ENOSPC, false, false}, {ENOSPC, false, true}, {ENOSPC, true, false},
                                 {EIO, false, false},    {EIO, true, false},    {EIO, true, true}};

/// What one save does to a document.
struct Save {
  const char* name;
  bool fresh;     ///< Into a new file.
  bool replaces;  ///< Which takes the place of another.
  bool removes;   ///< Most records go, the file shrinks.
};
constexpr Save kSaves[] = {{"in place", false, false, false},
                           {"new", true, false, false},
                           {"new over old", true, true, false},
                           {"shrinks", false, false, true}};

/// Together more than the MiB below which files are not shrunk, when most go.
constexpr RecordId kOld = 300, kNew = 20;

class Disk {
 public:
  Disk() {
    failing::begin({.flushes = false});
    const auto file = DocumentFile::create(folder_ / "template");
    const auto transaction = file->begin();
    for (const RecordId id : idsFromTo(1, kOld)) putSample(*transaction, id);
    transaction->commit(kOld, kOld + 1);
    failing::end();
  }
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "work" / "a.argil"; }
  void prepare(const Save& save) const {
    std::filesystem::remove_all(folder_ / "work");
    std::filesystem::create_directory(folder_ / "work");
    if (!save.fresh || save.replaces) std::filesystem::copy_file(folder_ / "template", path());
  }
  [[nodiscard]] std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& each : std::filesystem::directory_iterator(folder_ / "work"))
      names.push_back(each.path().filename());
    return names;
  }
  [[nodiscard]] static std::unique_ptr<DocumentFile> open(const Save& save, const std::filesystem::path& path) {
    return save.fresh ? DocumentFile::create(path) : DocumentFile::open(path, true);
  }
  static void write(DocumentFile& file, const Save& save) {
    const auto transaction = file.begin();
    if (save.removes) transaction->removeAllBut({});
    for (const RecordId id : idsFromTo(kOld + 1, kOld + kNew)) putSample(*transaction, id);
    transaction->commit(kOld + kNew, kOld + kNew + 1);
  }
  /// The ids that the file has to hold, before or after.
  static std::vector<RecordId> expected(const Save& save, bool saved) {
    if (!saved) return idsFromTo(1, kOld);
    return idsFromTo(save.fresh || save.removes ? kOld + 1 : 1, kOld + kNew);
  }
  void expectContent(const Save& save, bool saved) const {
    if (!saved && save.fresh && !save.replaces) {
      EXPECT_FALSE(std::filesystem::exists(path()));
      return;
    }
    const auto file = DocumentFile::open(path(), false);
    EXPECT_EQ(file->head(), saved ? kOld + kNew : kOld);
    EXPECT_EQ(soundSamples(*file, idsFromTo(1, 500)), expected(save, saved));
    const RecordSet held = file->held();
    for (const RecordId id : idsFromTo(1, 500))
      EXPECT_EQ(held.contains(id), std::ranges::binary_search(expected(save, saved), id)) << id;
  }

 private:
  samples::Folder folder_;
};

void expectSentence(const std::string& told, int error) {
  EXPECT_NE(told.find("a.argil"), std::string::npos) << told;
  const bool reason = told.find(std::generic_category().message(error)) != std::string::npos ||
                      (error == ENOSPC && told.find("no space left") != std::string::npos);
  EXPECT_TRUE(reason) << told;
  EXPECT_EQ(told.find('\n'), std::string::npos) << told;
}

TEST(FailingDisk, EveryCallOfASave) {
  const Disk disk;
  for (const Save& save : kSaves) {
    disk.prepare(save);
    auto file = Disk::open(save, disk.path());
    failing::begin({.flushes = false});
    Disk::write(*file, save);
    const long calls = failing::end();
    file.reset();
    disk.expectContent(save, true);
    ASSERT_GT(calls, 5) << save.name;
    for (const Failure& failure : kFailures) {
      long told = 0, toldButThere = 0;
      for (long call = 1; call <= calls; call += save.removes && call < calls - 60 ? 7 : 1) {
        SCOPED_TRACE(std::string(save.name) + ", error " + std::to_string(failure.error) +
                     (failure.once ? ", once" : "") + (failure.shortFirst ? ", short" : "") + ", call " +
                     std::to_string(call) + " of " + std::to_string(calls));
        disk.prepare(save);
        file = Disk::open(save, disk.path());
        failing::begin({.error = failure.error,
                        .from = call,
                        .once = failure.once,
                        .shortFirst = failure.shortFirst,
                        .flushes = false});
        const uint64_t before = file->save();
        bool saved = true;
        try {
          Disk::write(*file, save);
        } catch (const Error& error) {
          saved = file->save() > before;
          toldButThere += saved;
          ++told;
          EXPECT_EQ(error.kind(), Error::Kind::work);
          expectSentence(error.what(), failure.error);
        }
        failing::begin({.flushes = false});
        // The program goes on: with a disk that works again, the next save is a whole one.
        if (!saved && call % 2 == 0) {
          Disk::write(*file, save);
          saved = true;
        }
        file.reset();
        disk.expectContent(save, saved);
        EXPECT_EQ(disk.entries(), std::vector<std::string>(saved || !save.fresh || save.replaces ? 1 : 0, "a.argil"));
        if (HasFailure()) return;
      }
      std::cout << save.name << ": " << calls << " calls, " << told << " told\n";
      EXPECT_GT(told, save.removes ? 20 : calls / 2);
      EXPECT_LE(toldButThere, 1) << "only where all is written but the folder cannot be flushed";
    }
  }
}

TEST(FailingDisk, EveryCallOfAJournal) {
  const samples::Folder folder;
  // Records with a flush after every fourth; what a flush has acknowledged is there.
  const auto write = [&](RecordId& acknowledged) {
    JournalWriter writer(folder / "a.argil");
    const auto step = [&](RecordId id) {
      putSample(writer, id);
      if (id % 4 != 0) return;
      writer.sync();
      acknowledged = id;
    };
    try {
      for (RecordId id = 1; id <= 40; ++id) step(id);
    } catch (const Error&) {
      EXPECT_TRUE(writer.broken());
      EXPECT_THROW(writer.sync(), Error);
      throw;
    }
    EXPECT_FALSE(writer.broken());
  };
  RecordId acknowledged = 0;
  failing::begin({.flushes = false});
  write(acknowledged);
  const long calls = failing::end();
  ASSERT_EQ(acknowledged, 40u);
  ASSERT_GT(calls, 20);
  for (const Failure& failure : kFailures) {
    for (long call = 1; call <= calls; ++call) {
      SCOPED_TRACE("error " + std::to_string(failure.error) + ", call " + std::to_string(call) + " of " +
                   std::to_string(calls));
      std::filesystem::remove(folder / "a.argil");
      acknowledged = 0;
      failing::begin({.error = failure.error,
                      .from = call,
                      .once = failure.once,
                      .shortFirst = failure.shortFirst,
                      .flushes = false});
      bool threw = false;
      try {
        write(acknowledged);
      } catch (const Error& error) {
        threw = true;
        expectSentence(error.what(), failure.error);
      }
      failing::end();
      if (!std::filesystem::exists(folder / "a.argil")) {
        EXPECT_TRUE(threw);
        EXPECT_EQ(acknowledged, 0u);
        EXPECT_EQ(folder.entries(), 0u) << "temporary files";
        continue;
      }
      JournalReader reader(folder / "a.argil", true);
      const auto sound = soundSamples(reader, idsFromTo(1, 40));
      EXPECT_GE(sound.size(), acknowledged);
      EXPECT_EQ(sound, idsFromTo(1, sound.size())) << "in order, without holes";
      if (threw && failure.once && !failure.shortFirst) {
        EXPECT_EQ(sound.size(), acknowledged) << "what was not flushed was taken back";
      }
      EXPECT_EQ(reader.damagedPlaces(), 0u);
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace argil::io
