// Programs that work are killed, and programs whose disk fails go on: what is left opens, and holds all but the last
// second. ARGIL_SOAK=N: N kills, N / 5 runs with failing writes and N / 10 with a slow disk instead of a few;
// ARGIL_SOAK_VOXELS=48: at so many million active voxels (1).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <thread>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/session/recovery.h"
#include "tests/soak/engine/keeping_script.h"

extern char** environ;

namespace argil::soak {
namespace {

namespace fs = std::filesystem;

constexpr double kRadiusMm = 20;
constexpr double kBandVoxels = 6;  // both sides

uint64_t numberFrom(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

// Reads back to the same bits.
std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// A library that makes a disk fail or slow.
fs::path failingWrites() {
  return fs::canonical("/proc/self/exe").parent_path() / "libfailing_writes.so";
}

// Active voxels of a ball: its surface times the band.
double voxelFor(double millions) {
  return std::sqrt(4 * M_PI * kRadiusMm * kRadiusMm * kBandVoxels / (millions * 1e6));
}

class SavingSoak : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-soak-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
    millions = double(numberFrom("ARGIL_SOAK_VOXELS", 1));
    voxelMm = voxelFor(millions);
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(folder);
    if (runs > 0) {
      std::printf(
          "  %llu runs at %.0f million active voxels: %llu with something to recover, %llu cut off in mid-stroke; lost "
          "at most %.0f ms of work; reopened in %.2f s at most, "
          "mean %.2f s; %llu saves, %llu failed, %llu times told of the journal\n",
          (unsigned long long)runs, millions, (unsigned long long)withJournal, (unsigned long long)midStroke,
          mostLostMs, mostReopenS, sumReopenS / double(runs), (unsigned long long)saves, (unsigned long long)saveErrors,
          (unsigned long long)journalErrors);
    }
  }

  // A saved document to begin with: made once.
  const fs::path& model() {
    if (modelFile.empty()) {
      modelFile = folder / "model.argil";
      clay::Grid grid;
      grid.voxelMm = voxelMm;
      engine::saveDocument(modelFile,
                           engine::Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kRadiusMm)));
    }
    return modelFile;
  }

  struct Ended {
    int64_t killedNs = 0;
    bool early = false;  // it was over before it was killed
  };
  // Runs a session in `at` for so long after it is ready, then kills it.
  Ended run(const fs::path& at, uint64_t seed, double seconds, const std::vector<std::string>& environment) {
    Progress& progress = *mapProgress(at / "progress", true);
    const fs::path program = fs::canonical("/proc/self/exe").parent_path() / "saving_session";
    std::vector<std::string> words{program.string(), at.string(), std::to_string(seed), exact(kRadiusMm),
                                   exact(voxelMm)};
    std::vector<char*> arguments, variables;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::vector<std::string> all = environment;
    for (char** each = environ; *each; ++each) all.emplace_back(*each);
    for (std::string& each : all) variables.push_back(each.data());
    variables.push_back(nullptr);
    pid_t child = 0;
    if (posix_spawn(&child, arguments[0], nullptr, nullptr, arguments.data(), variables.data()) != 0)
      throw std::runtime_error("no child");
    Ended ended;
    const int64_t begun = nowNs();
    int status = 0;
    const auto gone = [&] { return waitpid(child, &status, WNOHANG) == child; };
    while (progress.readyNs == 0 && nowNs() - begun < 120'000'000'000LL) {
      if (gone()) throw std::runtime_error("the session ended before it began");
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const int64_t end = progress.readyNs + int64_t(seconds * 1e9);
    while (nowNs() < end && !ended.early) {
      ended.early = gone();
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    ended.killedNs = nowNs();
    if (!ended.early) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
    } else {
      EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
          << "the session fell over by itself: status " << status;
    }
    return ended;
  }

  // The number of the op after which the document was this; the last one of that kind. Or none.
  static int64_t opOfHash(const Progress& progress, uint64_t hash, uint64_t ops) {
    for (int64_t op = int64_t(ops); op >= 0; --op) {
      if (progress.hash[size_t(op)] == hash) return op;
    }
    return -1;
  }

  struct Place {
    uint64_t op = 0;      // so many were finished
    uint64_t points = 0;  // of the next one
  };
  // Where in the script a document with these strokes stands: the latest such place.
  std::optional<Place> placeOf(const Progress& progress, uint64_t seed, uint64_t ops, uint64_t hash,
                               const std::vector<engine::JournalStroke>& strokes) const {
    for (int64_t from = int64_t(ops); from >= 0; --from) {
      if (progress.hash[size_t(from)] != hash) continue;
      Place place{uint64_t(from), 0};
      bool all = true;
      for (const engine::JournalStroke& stroke : strokes) {
        std::vector<Vec3d> points;
        for (const engine::JournalPoint& point : stroke.points) {
          if (!point.lift) points.push_back(point.point.mm);
        }
        // Ops that changed nothing are no steps.
        const auto matches = [&](uint64_t op) {
          const Op scripted = opOf(seed, op, kRadiusMm, voxelMm);
          return points.size() <= scripted.points.size() &&
                 std::equal(points.begin(), points.end(), scripted.points.begin()) &&
                 (!stroke.ended || points.size() == scripted.points.size());
        };
        // Nor are steps that were undone and redone.
        for (uint64_t op = place.op + 1; op <= ops && !matches(place.op); ++op)
          if (progress.hash[op] == progress.hash[place.op] && matches(op)) place.op = op;
        all = all && matches(place.op);
        if (stroke.ended)
          ++place.op;
        else
          place.points = points.size();
      }
      if (all) return place;
    }
    return std::nullopt;
  }

  // What is left after a run, against what was done. `promised`: whether no more than the last second may be missing.
  void look(const fs::path& at, uint64_t seed, const Ended& ended, bool promised) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " in " + at.string());
    Progress& progress = *mapProgress(at / "progress", false);
    const uint64_t actions = progress.actions;
    // An op's end may have been reached by the clay and not by the count.
    const uint64_t ops = progress.hash[progress.ops + 1] != 0 ? progress.ops + 1 : progress.ops.load();
    std::vector<uint64_t> actionsAfter{0};  // so many ops
    for (uint64_t op = 0; op <= ops + 1; ++op) {
      const Op each = opOf(seed, op, kRadiusMm, voxelMm);
      actionsAfter.push_back(actionsAfter.back() + (each.kind == Op::Kind::stroke ? each.points.size() : 1));
    }
    ++runs;
    saves += progress.saves;
    saveErrors += progress.saveErrors;
    journalErrors += progress.journalErrors;

    // What the last action before the last second is; 0: none has to be there.
    uint64_t owed = 0;
    while (owed < actions && progress.at[owed] < ended.killedNs - 1'000'000'000LL) ++owed;

    const int64_t reopenBegan = nowNs();
    uint64_t covered = 0;
    const fs::path file = at / "work.argil";
    if (fs::exists(file)) {
      const engine::OpenedDocument opened = engine::openDocument(file);
      EXPECT_TRUE(opened.notes.empty()) << opened.notes.front();
      ASSERT_NE(opened.base, nullptr);
      mostReopenS = std::max(mostReopenS, 1e-9 * double(nowNs() - reopenBegan));
      const int64_t op = opOfHash(progress, hashOf(*opened.states[opened.done].document), ops);
      ASSERT_GE(op, 0) << "the file holds a document that never was";
      EXPECT_GE(uint64_t(op), progress.savedOp) << "a save that was acknowledged is gone";
      covered = actionsAfter[size_t(op)];
    } else {
      EXPECT_EQ(progress.saves, 0u) << "a saved file is gone";
    }
    const int64_t recoverBegan = nowNs();
    const auto found = engine::recoverable(at / "state");
    ASSERT_LE(found.size(), 1u);
    if (!found.empty()) {
      if (found[0].steps == 0) {
        EXPECT_FALSE(promised) << found[0].sentence;
        return;
      }
      const engine::Recovered recovered = engine::recover(found[0].journal);
      // A step without a stroke is known by its document alone, which the last second's may not have yet: `covered`
      // judges that.
      for (const std::string& note : recovered.document.notes)
        EXPECT_THAT(note, ::testing::EndsWith("of the journal could not be read."));
      std::optional<Place> place = placeOf(
          progress, seed, ops, hashOf(*recovered.document.states[recovered.document.done].document), recovered.strokes);
      // Killed between the end of an op and the count of it: then the step before is where the count stands.
      if (!place && progress.hash[ops + 1] == 0 && recovered.strokes.empty() && recovered.document.done > 0) {
        engine::Session session(recovered.document.states, recovered.document.done);
        session.setReader([&](uint64_t kept, const engine::Document& near) {
          return engine::readState(*recovered.document.documentRecords, recovered.document.base, recovered.sources,
                                   kept, near);
        });
        session.undo();
        if (hashOf(*session.document()) == progress.hash[ops]) place = Place{ops + 1, 0};
      }
      ASSERT_TRUE(place) << "the journal holds a document or a stroke that never was";
      const uint64_t done = actionsAfter[place->op] + place->points;
      const uint64_t number = place->op;
      engine::Session session(recovered.document.states, recovered.document.done);
      EXPECT_EQ(engine::replay(session, recovered.strokes), 0u);
      if (!recovered.strokes.empty() && recovered.strokes.back().ended) {
        EXPECT_EQ(hashOf(*session.document()), progress.hash[number]) << "strokes done again gave other clay";
      }
      covered = std::max(covered, done);
      ++withJournal;
      midStroke += found[0].midStroke;
    }
    const double reopenS = 1e-9 * double(nowNs() - recoverBegan);
    mostReopenS = std::max(mostReopenS, reopenS);
    sumReopenS += reopenS;
    EXPECT_LE(reopenS, 20 * std::max(1.0, millions / 24)) << "as on a starved machine; the figure is printed";
    if (promised) {
      EXPECT_GE(covered, owed) << "of " << actions << " actions";
      if (covered < actions) mostLostMs = std::max(mostLostMs, 1e-6 * double(ended.killedNs - progress.at[covered]));
    }
    munmap(&progress, sizeof progress);
  }

  fs::path folder, modelFile;
  double millions = 1, voxelMm = 0.5;
  uint64_t runs = 0, withJournal = 0, midStroke = 0, saves = 0, saveErrors = 0, journalErrors = 0;
  double mostLostMs = 0, mostReopenS = 0, sumReopenS = 0;
};

TEST_F(SavingSoak, KilledAtAnyMomentLosesNoMoreThanTheLastSecond) {
  const uint64_t kills = numberFrom("ARGIL_SOAK", 4), first = numberFrom("ARGIL_SOAK_SEED", 1);
  for (uint64_t seed = first; seed < first + kills && !HasFatalFailure(); ++seed) {
    const fs::path at = folder / std::to_string(seed);
    fs::create_directories(at);
    if (seed % 3 != 0 || millions > 1) fs::copy_file(model(), at / "work.argil");
    engine::Random random(seed);
    const Ended ended = run(at, seed, random.between(0, random.below(4) == 0 ? 5 : 2), {});
    look(at, seed, ended, true);
    if (!HasFailure()) fs::remove_all(at);
  }
}

// A disk that others keep busy takes seconds for a flush: that may cost what a power cut takes, not what a crash does.
TEST_F(SavingSoak, ASlowDiskDoesNotLoseMore) {
  for (uint64_t seed = 0; seed < numberFrom("ARGIL_SOAK", 20) / 10 && !HasFatalFailure(); ++seed) {
    const fs::path at = folder / ("s" + std::to_string(seed));
    fs::create_directories(at);
    if (seed % 2 == 1) fs::copy_file(model(), at / "work.argil");
    const Ended ended = run(at, seed, 2 + 0.1 * double(seed % 20),
                            {"LD_PRELOAD=" + failingWrites().string(), "ASAN_OPTIONS=verify_asan_link_order=0",
                             "ARGIL_SLOW_FLUSH_MS=4000"});
    look(at, seed, ended, true);
    if (!HasFailure()) fs::remove_all(at);
  }
}

TEST_F(SavingSoak, FailingWritesAreToldAndLeaveTheSavedFileWhole) {
  const uint64_t wanted = numberFrom("ARGIL_SOAK", 15) / 5, first = numberFrom("ARGIL_SOAK_SEED", 1);
  for (uint64_t seed = first; seed < first + wanted && !HasFatalFailure(); ++seed) {
    const fs::path at = folder / ("f" + std::to_string(seed));
    fs::create_directories(at);
    fs::copy_file(model(), at / "work.argil");
    engine::Random random(seed + 77'000);
    const bool once = random.below(2) == 0, full = random.below(2) == 0;
    const uint64_t call = 1 + random.below(random.below(2) == 0 ? 30 : 600);
    const Ended ended =
        run(at, seed, random.between(0.6, 3),
            {"LD_PRELOAD=" + failingWrites().string(),
             "ASAN_OPTIONS=verify_asan_link_order=0",  // the library stands before AddressSanitizer's
             "ARGIL_FAIL=" + std::string(full ? "enospc:" : "eio:") + std::to_string(call) + (once ? ":once" : ""),
             "ARGIL_FAIL_PATH=" + at.string()});
    // While the disk takes nothing, what is made is in memory alone, and the person knows.
    const Progress& progress = *mapProgress(at / "progress", false);
    const bool told = progress.journalErrors + progress.saveErrors > 0;
    look(at, seed, ended, once || !told);
    if (!HasFailure()) fs::remove_all(at);
  }
}

}  // namespace
}  // namespace argil::soak
