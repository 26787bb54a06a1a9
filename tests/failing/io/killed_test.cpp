// A program that is killed while it saves: the file opens and holds the last save that was acknowledged, or the one
// under way.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>

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

constexpr uint32_t kSeed = 20263;
constexpr int kKills = 200;

/// Runs `work` in a child, kills it after a random time, and returns the last number that it told through the pipe.
template <class Work>
uint64_t killedWithin(std::mt19937& random, double mostMicroseconds, Work&& work) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    failing::begin({.flushes = false});
    try {
      work([&](uint64_t number) { (void)!::write(ends[1], &number, sizeof number); });
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    std::_Exit(1);
  }
  ::close(ends[1]);
  ::usleep(std::uniform_int_distribution<useconds_t>(0, useconds_t(mostMicroseconds))(random));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the child failed by itself";
  uint64_t last = 0, number = 0;
  while (::read(ends[0], &number, sizeof number) == ssize_t(sizeof number)) last = number;
  ::close(ends[0]);
  return last;
}

/// So long that about as many kills come too early as too late, however busy the machine is.
double next(double within, bool early) {
  return early ? std::min(within * 1.3, 1e6) : within * 0.8;
}

/// After save n the file holds the records of the saves (n - 20, n], each of ten.
std::vector<RecordId> idsOfSave(uint64_t save) {
  return idsFromTo(save > 20 ? (save - 20) * 10 + 1 : 1, save * 10);
}

void saveOn(DocumentFile& file) {
  const uint64_t save = file.save() + 1;
  const auto transaction = file.begin();
  for (const RecordId id : idsFromTo(save * 10 - 9, save * 10)) putSample(*transaction, id);
  if (save % 7 == 0) {
    RecordSet live;
    for (const RecordId id : idsOfSave(save)) live.add(id);
    transaction->removeAllBut(live);
  }
  transaction->commit(save * 10, save * 10 + 1);
}

TEST(Killed, ADocumentOpensEveryTime) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  failing::begin({.flushes = false});
  saveOn(*DocumentFile::create(path));
  uint64_t before = 1;
  int underWay = 0, journals = 0;
  double within = 20000;
  for (int kill = 0; kill < kKills; ++kill) {
    const uint64_t told = std::max(before, killedWithin(random, within, [&](const auto& tell) {
                                     for (const auto file = DocumentFile::open(path, true);; tell(file->save()))
                                       saveOn(*file);
                                   }));
    journals += std::filesystem::exists(path.string() + "-journal");
    const auto file = DocumentFile::open(path, kill % 2 == 0);
    ASSERT_GE(file->save(), told) << "kill " << kill;
    ASSERT_LE(file->save(), told + 1) << "kill " << kill;
    underWay += file->save() > told;
    within = next(within, file->save() == before);
    before = file->save();
    ASSERT_EQ(file->head(), before * 10);
    const RecordSet held = file->held();
    const auto ids = idsOfSave(before);
    ASSERT_EQ(soundSamples(*file, ids), ids) << "kill " << kill;
    for (RecordId id = before * 10 + 1; id < before * 10 + 100; ++id)
      ASSERT_FALSE(held.contains(id)) << "kill " << kill;
  }
  saveOn(*DocumentFile::open(path, true));
  EXPECT_FALSE(std::filesystem::exists(path.string() + "-journal"));
  failing::end();
  std::cout << before << " saves, " << journals << " rolled back, " << underWay << " whole but not yet acknowledged\n";
  EXPECT_GT(before, 20u);
  EXPECT_GT(journals, 5) << "no kill has met a save";
}

TEST(Killed, ANewDocumentIsThereOrNot) {
  std::mt19937 random(kSeed);
  const samples::Folder folder;
  const auto path = folder / "a.argil";
  int there = 0;
  double within = 10000;
  for (int kill = 0; kill < 50; ++kill) {
    std::filesystem::remove(path);
    const uint64_t told = killedWithin(random, within, [&](const auto& tell) {
      const auto file = DocumentFile::create(path);
      const auto transaction = file->begin();
      for (const RecordId id : idsFromTo(1, 100)) putSample(*transaction, id);
      transaction->commit(100, 101);
      tell(1);
      for (;;) ::pause();
    });
    if (!std::filesystem::exists(path)) {
      ASSERT_EQ(told, 0u);
      within = next(within, true);
      continue;
    }
    ++there;
    within = next(within, false);
    ASSERT_EQ(soundSamples(*DocumentFile::open(path, false), idsFromTo(1, 200)), idsFromTo(1, 100));
  }
  EXPECT_GT(there, 2);
}

TEST(Killed, AJournalHasWhatWasFlushed) {
  std::mt19937 random(kSeed);
  const samples::Folder folder;
  uint64_t most = 0;
  double within = 2000;
  for (int kill = 0; kill < kKills; ++kill) {
    const auto path = folder / std::to_string(kill);
    const uint64_t told = killedWithin(random, within, [&](const auto& tell) {
      JournalWriter writer(path);
      for (RecordId id = 1;; ++id) {
        putSample(writer, id);
        if (id % 5 != 0) continue;
        writer.sync();
        tell(id);
      }
    });
    most = std::max(most, told);
    within = next(within, told < 20);
    if (!std::filesystem::exists(path)) {
      ASSERT_EQ(told, 0u);
      continue;
    }
    JournalReader reader(path, true);
    const auto sound = soundSamples(reader, idsFromTo(1, told + 100));
    ASSERT_GE(sound.size(), told);
    ASSERT_EQ(sound, idsFromTo(1, sound.size()));
    ASSERT_EQ(reader.damagedPlaces(), 0u);
    reader.remove();
  }
  EXPECT_GT(most, 10u);
}

}  // namespace
}  // namespace argil::io
