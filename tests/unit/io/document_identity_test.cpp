// Whose a file is: each save has a stamp of its own, files know the saves that they grew from, nothing is replaced that
// somebody wrote meanwhile, and a document that is open elsewhere is known to be.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>
#include <set>

#include "io/bytes/atomic_file.h"
#include "io/records/document_facts.h"
#include "io/records/document_file.h"
#include "io/records/document_presence.h"
#include "io/records/sqlite.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

namespace fs = std::filesystem;
using samples::errorOf;
using samples::putSample;
using samples::slurp;
using samples::spill;

void save(DocumentFile& file, RecordId id) {
  const auto transaction = file.begin();
  putSample(*transaction, id);
  transaction->commit(id, id + 1);
}

TEST(DocumentIdentity, EverySaveHasAStampAndAFileKnowsTheOnesItGrewFrom) {
  const samples::Folder folder;
  // Of a long life before.
  Lineage before;
  std::vector<uint64_t> stamps;
  for (RecordId id = 1; id <= kMostLineage - 2; ++id) {
    before.push_back({1000 + id, id + 1});
    stamps.push_back(1000 + id);
  }
  const auto file = DocumentFile::create(folder / "a.argil", before);
  EXPECT_EQ(file->stamp(), 0u);
  EXPECT_EQ(file->sharedWith(0), 0u);
  for (RecordId id = kMostLineage - 1; id <= kMostLineage + 5; ++id) {
    save(*file, id);
    stamps.push_back(file->stamp());
    EXPECT_EQ(file->sharedWith(file->stamp()), id + 1);
  }
  EXPECT_EQ(std::set<uint64_t>(stamps.begin(), stamps.end()).size(), stamps.size());
  const auto again = DocumentFile::open(folder / "a.argil", false);
  EXPECT_EQ(again->stamp(), stamps.back());
  EXPECT_EQ(again->lineage().size(), kMostLineage);
  EXPECT_EQ(again->lineage(), file->lineage());
  for (size_t i = 0; i < stamps.size(); ++i)
    EXPECT_EQ(again->sharedWith(stamps[i]), i + 1 < stamps.size() - kMostLineage ? 0 : i + 2) << i;
}

TEST(DocumentIdentity, TwoFilesOfOneOriginShareWhatTheyHadTogether) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil", copy = folder / "b.argil";
  save(*DocumentFile::create(path), 1);
  fs::copy_file(path, copy);
  const uint64_t origin = DocumentFile::open(path, false)->stamp();
  EXPECT_EQ(DocumentFile::open(copy, false)->stamp(), origin);
  save(*DocumentFile::open(path, true), 2);
  save(*DocumentFile::open(copy, true), 2);
  const auto one = DocumentFile::open(path, false), other = DocumentFile::open(copy, false);
  EXPECT_EQ(one->save(), other->save());
  EXPECT_NE(one->stamp(), other->stamp());
  EXPECT_EQ(one->sharedWith(other->stamp()), 0u);
  EXPECT_EQ(one->sharedWith(origin), 2u);
  EXPECT_EQ(other->sharedWith(origin), 2u);
  // Of a file that takes over records, whoever makes it says from where.
  const auto third = DocumentFile::create(folder / "c.argil", {{origin, 2}});
  save(*third, 3);
  EXPECT_EQ(DocumentFile::open(folder / "c.argil", false)->sharedWith(origin), 2u);
  save(*DocumentFile::create(folder / "d.argil"), 1);
  EXPECT_EQ(DocumentFile::open(folder / "d.argil", false)->sharedWith(origin), 0u);
}

TEST(DocumentIdentity, ANewFileReplacesOnlyWhatWasThereWhenItWasBegun) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil";
  // Nothing was there.
  auto slow = DocumentFile::create(path);
  save(*DocumentFile::create(path), 7);
  const std::string first = slurp(path);
  EXPECT_NE(errorOf([&] { save(*slow, 1); }).find("another"), std::string::npos);
  EXPECT_EQ(slurp(path), first);
  // A document that is saved, or replaced by a copy.
  slow = DocumentFile::create(path);
  save(*DocumentFile::open(path, true), 8);
  const std::string second = slurp(path);
  EXPECT_NE(errorOf([&] { save(*slow, 1); }).find("was written by another program"), std::string::npos);
  EXPECT_EQ(slurp(path), second);
  slow = DocumentFile::create(path);
  spill(folder / "new", second);
  fs::rename(folder / "new", path);
  EXPECT_NE(errorOf([&] { save(*slow, 1); }).find("was written by another program"), std::string::npos);
  // Something else.
  spill(path, "a text");
  slow = DocumentFile::create(path);
  spill(path, "another text");
  EXPECT_NE(errorOf([&] { save(*slow, 1); }).find("was written by another program"), std::string::npos);
  EXPECT_EQ(slurp(path), "another text");
  EXPECT_EQ(folder.entries(), 1u);
  // What nobody touched is replaced.
  slow = DocumentFile::create(path);
  save(*slow, 1);
  EXPECT_EQ(DocumentFile::open(path, false)->head(), 1u);
}

TEST(DocumentIdentity, AFileOfTheSameNameIsNotReplacedWhereNoneWasExpected) {
  const samples::Folder folder;
  AtomicFile file(folder / "a.bin");
  spill(folder / "a.bin", "theirs");
  EXPECT_NE(errorOf([&] { file.commit(false); }).find("another program"), std::string::npos);
  EXPECT_EQ(slurp(folder / "a.bin"), "theirs");
}

TEST(DocumentIdentity, AFileOfANewerSchemaKeepsIt) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil";
  save(*DocumentFile::create(path), 1);
  EXPECT_EQ(DocumentFile::open(path, false)->schema(), kDocumentSchema);
  {
    Database database(path, "a.argil");
    DocumentFacts facts = readFacts(database, "a.argil");
    facts.schema = kDocumentSchema + 3;
    writeFacts(database, facts, "a.argil");
  }
  EXPECT_EQ(DocumentFile::open(path, false)->schema(), kDocumentSchema + 3);
  EXPECT_FALSE(DocumentFile::open(path, false)->writtenBy().empty());
  save(*DocumentFile::open(path, true), 2);
  EXPECT_EQ(DocumentFile::open(path, false)->schema(), kDocumentSchema + 3)
      << "what the newer one wrote may be in it still";
}

TEST(DocumentPresence, IsToldOfADocumentThatIsOpenElsewhere) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil", state = folder / "state" / "open";
  spill(path, "a");
  spill(folder / "b.argil", "b");
  fs::create_symlink(path, folder / "symlink.argil");
  fs::create_hard_link(path, folder / "link.argil");
  {
    std::optional<DocumentPresence> first(std::in_place, path, state);
    EXPECT_FALSE(first->elsewhere());
    EXPECT_FALSE(DocumentPresence(folder / "b.argil", state).elsewhere());
    for (const char* name : {"a.argil", "symlink.argil", "link.argil"})
      EXPECT_TRUE(DocumentPresence(folder / name, state).elsewhere()) << name;
    // By its name also when a sync program has replaced it; the lock is the window's, not the first one's.
    spill(folder / "new", "c");
    fs::rename(folder / "new", path);
    const DocumentPresence second(path, state);
    EXPECT_TRUE(second.elsewhere());
    first.reset();
    EXPECT_TRUE(DocumentPresence(path, state).elsewhere());
  }
  EXPECT_FALSE(DocumentPresence(path, state).elsewhere());
  EXPECT_TRUE(fs::is_empty(state)) << "whoever ends orderly leaves nothing";
  // A name that no file has yet.
  const DocumentPresence untold(folder / "none.argil", state);
  EXPECT_FALSE(untold.elsewhere());
  EXPECT_TRUE(DocumentPresence(folder / "none.argil", state).elsewhere());
}

// The one that was there first finds the other when it looks again, and is found as before.
TEST(DocumentPresence, FindsThoseThatComeAndGoLater) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil", state = folder / "open";
  spill(path, "a");
  DocumentPresence first(path, state);
  EXPECT_FALSE(first.look());
  for (int round = 0; round < 3; ++round) {
    std::optional<DocumentPresence> second(std::in_place, path, state);
    EXPECT_TRUE(second->elsewhere());
    EXPECT_FALSE(first.elsewhere()) << "until it looks";
    EXPECT_TRUE(first.look());
    EXPECT_TRUE(first.elsewhere());
    EXPECT_TRUE(second->look());
    EXPECT_TRUE(DocumentPresence(path, state).elsewhere()) << "looking gives nothing up";
    {
      const DocumentPresence third(path, state);
      EXPECT_TRUE(first.look());
    }
    second.reset();
    EXPECT_FALSE(first.look());
    EXPECT_FALSE(first.elsewhere());
  }
  EXPECT_TRUE(DocumentPresence(path, state).elsewhere());
}

TEST(DocumentPresence, EndsWithItsProgramHoweverThatEnds) {
  const samples::Folder folder;
  const fs::path path = folder / "a.argil", state = folder / "open";
  spill(path, "a");
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const DocumentPresence mine(path, state);
    (void)!::write(ready[1], "r", 1);
    for (;;) ::pause();
  }
  char one = 0;
  ASSERT_EQ(::read(ready[0], &one, 1), 1);
  EXPECT_TRUE(DocumentPresence(path, state).elsewhere());
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_FALSE(DocumentPresence(path, state).elsewhere());
  EXPECT_TRUE(fs::is_empty(state)) << "what a crash left is cleared away";
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(DocumentPresence, WantsNothingOfAFolderThatCannotBeWritten) {
  const samples::Folder folder;
  fs::create_directory(folder / "documents");
  spill(folder / "documents" / "a.argil", "a");
  fs::permissions(folder / "documents", fs::perms::owner_read | fs::perms::owner_exec);
  {
    const DocumentPresence mine(folder / "documents" / "a.argil", folder / "state");
    EXPECT_TRUE(DocumentPresence(folder / "documents" / "a.argil", folder / "state").elsewhere());
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "documents"), {}), 1);
  }
  fs::permissions(folder / "documents", fs::perms::owner_all);
  // Nowhere to announce it: nobody is found, nothing fails.
  const DocumentPresence one(folder / "documents" / "a.argil", "/proc/nowhere"),
      two(folder / "documents" / "a.argil", "/proc/nowhere");
  EXPECT_FALSE(two.elsewhere());
}

TEST(DocumentPresence, KeepsTheLocksOfAnOpenDocument) {
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  const auto file = DocumentFile::create(path);
  save(*file, 1);
  const auto transaction = file->begin();
  { const DocumentPresence looked(path, folder / "state"); }
  const pid_t child = ::fork();
  if (child == 0) {
    const int fd = ::open(path.c_str(), O_RDWR);
    struct flock lock {};
    lock.l_type = F_WRLCK;
    lock.l_start = 0x40000000;  // SQLite's locks (sqlite.org/fileformat2.html, "The lock-byte page")
    lock.l_len = 512;
    std::_Exit(::fcntl(fd, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK ? 1 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 1) << "SQLite's lock is gone";
}

}  // namespace
}  // namespace argil::io
