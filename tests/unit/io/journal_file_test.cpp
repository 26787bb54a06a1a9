// Journals: what was flushed is there, in order; a torn end and damaged places cost no other record; one Argil at a
// time has it.

#include "io/records/journal_file.h"

#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "tests/support/mesh_samples.h"
#include "tests/support/record_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;
using samples::idsFromTo;
using samples::putSample;
using samples::slurp;
using samples::soundSamples;
using samples::spill;

void putEvent(RecordSink& sink, const std::string& text) {
  sink.put({RecordKind::step, RecordCodec::raw, 0, 0, 0}, bytesOf(text));
}

std::vector<std::string> events(const JournalReader& reader) {
  std::vector<std::string> all;
  reader.forEachEvent([&](const RecordView& record, uint64_t) {
    all.emplace_back(reinterpret_cast<const char*>(record.body.data()), record.body.size());
  });
  return all;
}

TEST(JournalFile, GivesBackWhatWasPutInOrder) {
  const samples::Folder folder;
  const auto path = folder / "state" / "journal" / "a";
  JournalWriter writer(path);
  for (RecordId id = 1; id <= 1000; ++id) {
    putSample(writer, id);
    if (id % 100 == 0) putEvent(writer, "event " + std::to_string(id / 100));
  }
  writer.sync();
  EXPECT_EQ(writer.bytes(), std::filesystem::file_size(path));
  EXPECT_GT(writer.syncSeconds(), 0);
  EXPECT_FALSE(writer.broken());
  JournalReader reader(path, false);
  EXPECT_EQ(reader.records(), 1010u);
  EXPECT_EQ(reader.damagedPlaces(), 0u);
  EXPECT_EQ(reader.highestId(), 1000u);
  EXPECT_EQ(soundSamples(reader, idsFromTo(1, 1100)), idsFromTo(1, 1000));
  std::vector<std::string> expected;
  for (int i = 1; i <= 10; ++i) expected.push_back("event " + std::to_string(i));
  EXPECT_EQ(events(reader), expected);
}

TEST(JournalFile, IsThePersonsAlone) {
  const samples::Folder folder;
  const auto path = folder / "state" / "journal" / "a";
  const JournalWriter writer(path);
  struct stat facts {};
  ::stat(path.c_str(), &facts);
  EXPECT_EQ(facts.st_mode & 0777, 0600u);
  for (const auto& each : {path.parent_path(), path.parent_path().parent_path()}) {
    ::stat(each.c_str(), &facts);
    EXPECT_EQ(facts.st_mode & 0777, 0700u);
  }
  EXPECT_NE(errorOf([&] { JournalWriter second(path); }).find("a: the journal cannot be made"), std::string::npos);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 1);
}

TEST(JournalFile, ATornEndIsIgnoredAndADamagedPlaceCounted) {
  const samples::Folder folder;
  const auto path = folder / "a";
  {
    JournalWriter writer(path);
    for (RecordId id = 1; id <= 9; ++id) putSample(writer, id);
    putEvent(writer, "last");
    writer.sync();
  }
  const std::string whole = slurp(path);
  spill(path, whole.substr(0, whole.size() - 1));
  {
    JournalReader reader(path, true);
    EXPECT_EQ(reader.records(), 9u);
    EXPECT_EQ(reader.damagedPlaces(), 0u);
  }
  std::string flipped = whole;
  flipped[kRecordHeaderBytes + 977 + 100] ^= 1;  // In the second record.
  spill(path, flipped);
  JournalReader reader(path, true);
  EXPECT_EQ(reader.damagedPlaces(), 1u);
  EXPECT_EQ(soundSamples(reader, idsFromTo(1, 9)), (std::vector<RecordId>{1, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(events(reader), std::vector<std::string>{"last"});
}

TEST(JournalFile, TheLivingHaveItAndTheDeadHaveNot) {
  const samples::Folder folder;
  EXPECT_TRUE(abandonedJournals(folder / "none").empty());
  const auto path = folder / "journal" / "b";
  auto living = std::make_unique<JournalWriter>(path);
  EXPECT_TRUE(abandonedJournals(folder / "journal").empty());
  EXPECT_NE(errorOf([&] { JournalReader reader(path, true); }).find("is in use by another Argil"), std::string::npos);
  living.reset();
  // A process that is killed lets go as well.
  const pid_t child = ::fork();
  if (child == 0) {
    JournalWriter writer(folder / "journal" / "a");
    putEvent(writer, "kept");
    writer.sync();
    putEvent(writer, "lost");
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(abandonedJournals(folder / "journal"), (std::vector<std::filesystem::path>{path, folder / "journal" / "a"}))
      << "by name, whichever was written last";
  JournalReader reader(folder / "journal" / "a", true);
  EXPECT_EQ(events(reader), std::vector<std::string>{"kept"});
  EXPECT_EQ(abandonedJournals(folder / "journal"), std::vector<std::filesystem::path>{path});
  reader.remove();
  EXPECT_FALSE(std::filesystem::exists(folder / "journal" / "a"));
}

TEST(JournalFile, RemoveLeavesNothing) {
  const samples::Folder folder;
  JournalWriter writer(folder / "a");
  putEvent(writer, "x");
  writer.remove();
  EXPECT_EQ(folder.entries(), 0u);
  EXPECT_NE(errorOf([&] { putEvent(writer, "y"); }).find("removed"), std::string::npos);
}

TEST(JournalFile, AFullDiskIsToldAndLeavesWhatWasFlushed) {
  const samples::Folder folder;
  const auto path = folder / "a";
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    JournalWriter writer(path);
    for (RecordId id = 1; id <= 5; ++id) putSample(writer, id);
    writer.sync();
    const rlimit limit{writer.bytes() + 3000, writer.bytes() + 3000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const uint64_t flushed = writer.bytes();
    int failures = 0;
    std::string told;
    for (RecordId id = 6; id <= 600; ++id) {
      try {
        putSample(writer, id);
      } catch (const Error& error) {
        ++failures;
        told = error.what();
        if (error.kind() != Error::Kind::work) std::_Exit(2);
      }
    }
    try {
      writer.sync();
      std::_Exit(3);
    } catch (const Error& error) {
      if (told != error.what()) std::_Exit(4);
    }
    if (failures < 2 || !writer.broken() ||
        told.find("a: the journal cannot be written (File too large)") == std::string::npos)
      std::_Exit(5);
    std::_Exit(std::filesystem::file_size(path) == flushed ? 0 : 6);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "the child's number: " << WEXITSTATUS(status);
  JournalReader reader(path, true);
  EXPECT_EQ(soundSamples(reader, idsFromTo(1, 600)), idsFromTo(1, 5));
}

TEST(JournalFile, KnowsWhereJournalsLie) {
  const auto with = [](const char* state, const char* xdg) {
    ::setenv("HOME", "/home/someone", 1);
    ::setenv("ARGIL_STATE", state, 1);
    ::setenv("XDG_STATE_HOME", xdg, 1);
    const auto folder = journalFolder();
    ::unsetenv("ARGIL_STATE");
    ::unsetenv("XDG_STATE_HOME");
    return folder.string();
  };
  const char* home = std::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  EXPECT_EQ(with("", ""), "/home/someone/.local/state/argil/journal");
  EXPECT_EQ(with("", "/x"), "/x/argil/journal");
  EXPECT_EQ(with("", "relative"), "/home/someone/.local/state/argil/journal");
  EXPECT_EQ(with("/mine", "/x"), "/mine/journal");
  ::setenv("HOME", before.c_str(), 1);
}

}  // namespace
}  // namespace argil::io
