// The power is cut at any moment, and the disk has any part of what was not flushed: every saved file opens as the last
// save that was told of, or the one under way; at most a second of work is gone; and whatever comes back is compared
// with what was made, brick by brick.
//
// A session works in virtual time while every write and flush is traced (write_trace.h); from the trace follow the
// disks that a power cut may leave (power_cut.h). A part of them in every run, 10 000 in the long tier.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <thread>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/saved_document.h"
#include "engine/saving/session.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/recovery.h"
#include "tests/failing/engine/desk.h"
#include "tests/support/power_cut.h"
#include "tests/support/tier.h"
#include "tests/support/write_trace.h"

namespace argil::engine {
namespace {

using failing::CutDisk;
using failing::Trace;

// The entry of the folder that was changed last before operation `at`, or first behind it.
const TraceOp* entryBeside(const Trace& trace, size_t at, uint32_t folder, bool before) {
  for (size_t i = at; before ? i-- > 0 : ++i < trace.ops.size();) {
    const TraceOp& op = trace.ops[i];
    const bool entry =
        op.kind == TraceOp::Kind::create || op.kind == TraceOp::Kind::rename || op.kind == TraceOp::Kind::unlink;
    if (entry && op.folder == folder) return &op;
  }
  return nullptr;
}

class PowerCuts : public testing::Test {
 protected:
  struct Work {
    Truth truth;
    Trace trace;
    Promise promise;  // before the trace
  };

  void SetUp() override {
    std::error_code ignored;
    const fs::path memory = "/dev/shm";
    folder = (fs::is_directory(memory, ignored) ? memory : fs::temp_directory_path()) /
             ("argil-power-cuts-" + std::to_string(getpid()));
    fs::remove_all(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  // Cuts are looked at in the same place: journals name the files that they belong to.
  [[nodiscard]] fs::path root() const { return folder / "work"; }
  [[nodiscard]] fs::path freshRoot() const {
    fs::remove_all(root());
    fs::create_directories(root() / "docs");
    return root();
  }

  // What a disk that got all of the trace has is what is there: nothing was written past the trace.
  static void endTrace(const fs::path& root, Work& work) {
    work.trace = failing::endTrace();
    CutDisk disk(work.trace);
    disk.advance(work.trace.ops.size());
    const auto whole = disk.image(CutDisk::Loss::nothing, 0);
    EXPECT_TRUE(whole == failing::readImage(root)) << "something was written past the trace";
  }

  // Begun, saved, worked on, saved again, undone, saved over somebody else's file.
  Work firstSaves() {
    Work work;
    const fs::path root = freshRoot();
    work.promise.files[1].before = foreignFile(root);
    failing::beginTrace(root);
    Desk desk(root, work.truth);
    desk.beginUntitled();
    desk.stroke(1, 70);
    desk.move();
    desk.stroke(2, 30);
    desk.save(0);
    desk.stroke(3, 80);
    desk.undo();
    desk.redo();
    desk.save(0);
    desk.stroke(4, 20);
    desk.undo();
    desk.undo();
    desk.stroke(5, 60);
    desk.save(1);
    desk.stroke(6, 20);
    desk.beginStroke(7);
    desk.points(90);
    endTrace(root, work);
    return work;
  }

  // A journal that grows and is begun anew, and saves beside strokes.
  Work growth() {
    Work work;
    const fs::path root = freshRoot();
    savedFile(root, work);
    failing::beginTrace(root);
    Desk desk(root, work.truth, 120'000);
    OpenedDocument opened = openDocument(root / kFiles[0]);
    desk.begin(opened.states, opened.done, opened.documentRecords, opened.base, newWriter());
    for (uint64_t i = 10; i < 16; ++i) desk.stroke(i, 40);
    Desk::Saving saving = desk.beginSave(0);
    std::thread saver([&] { desk.save(saving); });
    desk.stroke(16, 60);
    saver.join();
    desk.endSave(saving);
    desk.stroke(17, 60);
    desk.move();
    desk.save(0);
    desk.stroke(18, 70);
    endTrace(root, work);
    return work;
  }

  // A crash in mid-stroke, its recovery, and work behind it.
  Work recovery() {
    Work work;
    const fs::path root = freshRoot();
    std::map<std::string, std::string> crashed;
    {
      savedFile(root, work);
      Desk desk(root, work.truth);
      OpenedDocument opened = openDocument(root / kFiles[0]);
      desk.begin(opened.states, opened.done, opened.documentRecords, opened.base, newWriter());
      desk.stroke(20, 60);
      desk.beginStroke(21);
      desk.points(70);
      desk.flush();
      crashed = failing::readImage(root);
      work.promise.acted = work.promise.flushed = work.truth.actedMs.size();
    }
    failing::writeImage(root, crashed);
    failing::beginTrace(root);
    const auto found = recoverable(root / kJournals);
    EXPECT_EQ(found.size(), 1u);
    RecoverChoice choice;
    choice.boot = "before the cut";
    Recovered recovered = recover(found.at(0).journal, nullptr, choice);
    EXPECT_EQ(recovered.strokes.size(), 1u);
    Repeating watch;
    EXPECT_EQ(replay(recovered, nullptr, &watch), 0u);
    Desk desk(root, work.truth);
    OpenedDocument& opened = recovered.document;
    desk.begin(opened.states, opened.done, opened.documentRecords, opened.base, recovered.writer,
               std::move(recovered.continued), recovered.sources);
    recovered.journal.reset();
    desk.stroke(22, 60);
    desk.save(0);
    desk.stroke(23, 60);
    endTrace(root, work);
    return work;
  }
  struct Repeating : SessionWatch {
    void strokeBegan(const Tool&, const StrokeImages&) override { say(Said::repeating, 0); }
    void strokePoint(const PathPoint&) override {}
    void toolLifted() override {}
    void strokeEnded() override { say(Said::repeated, 0); }
    void stepped(const std::string&, const DocumentPtr&, bool) override {}
    void went(size_t) override {}
  };

  // Steps leave memory and come back from the disk.
  Work spilling() {
    Work work;
    const fs::path root = freshRoot();
    failing::beginTrace(root);
    Desk desk(root, work.truth, 150'000);
    UndoBudget budget(1);
    size_t onDisk = 0;
    desk.beginUntitled();
    const auto stroke = [&](uint64_t seed) {
      desk.stroke(seed, 25);
      onDisk = std::max(onDisk, desk.keepBudget(budget).onDisk);
    };
    for (uint64_t i = 30; i < 36; ++i) stroke(i);
    desk.save(0);
    stroke(36);
    desk.goTo(2);
    desk.goTo(5);
    desk.goTo(1);
    stroke(37);
    stroke(38);
    desk.save(0);
    stroke(39);
    EXPECT_GT(onDisk, 3u);
    endTrace(root, work);
    return work;
  }

  // Somebody else's save was cut off: its rollback journal still lies beside the file that is saved over.
  Work overACutSave() {
    Work work;
    const fs::path root = freshRoot();
    work.promise.files[1].before = cutSave(root);
    EXPECT_TRUE(fs::exists(root / (std::string(kFiles[1]) + "-journal")));
    failing::beginTrace(root);
    Desk desk(root, work.truth);
    desk.beginUntitled();
    desk.stroke(40, 30);
    desk.save(1);
    desk.stroke(41, 30);
    endTrace(root, work);
    return work;
  }

  static uint64_t foreignFile(const fs::path& root) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    const Document document = Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 3));
    saveDocument(root / kFiles[1], document);
    return hashOf(document);
  }
  // A document with some history in a file of ours; the truth goes on from there.
  static void savedFile(const fs::path& root, Work& work) {
    {
      Desk desk(root, work.truth);
      desk.beginUntitled();
      desk.stroke(8, 40);
      desk.stroke(9, 40);
      desk.save(0);
    }
    work.promise.files[0].saved = work.truth.moments.size() - 1;
    work.promise.acted = work.promise.flushed = work.truth.actedMs.size();
  }
  static uint64_t cutSave(const fs::path& root) {
    const uint64_t hash = foreignFile(root);
    const fs::path file = root / kFiles[1];
    OpenedDocument opened = openDocument(file);
    Session session(opened.states, opened.done);
    session.change("Much", [](Document& d) {
      clay::Grid grid;
      grid.voxelMm = 0.5;
      Piece more;
      more.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 5);
      d.add(more);
    });
    failing::beginTrace(root);
    (void)saveDocument(
        file, {session.states(), session.undoSteps(), {}, opened.documentRecords, opened.base, {}, newWriter()});
    const Trace trace = failing::endTrace();
    // Just before the rollback journal goes, which is the commit.
    size_t at = 0;
    for (size_t i = 0; i < trace.ops.size(); ++i) {
      if (trace.ops[i].kind == TraceOp::Kind::unlink && trace.ops[i].name.ends_with("-journal")) at = i;
    }
    CutDisk disk(trace);
    disk.advance(at);
    failing::writeImage(root, disk.image(CutDisk::Loss::nothing, 0));
    return hash;
  }

  struct Looked {
    std::string wrong;  // empty: all is as promised
    double lostMs = 0;
    bool recovered = false, midStroke = false, damaged = false;
  };

  // Compares what is on the disk in `cut` with the truth.
  static Looked look(const fs::path& cut, Truth& truth, const Promise& promise, bool thorough) {
    Looked looked;
    uint64_t covered = 0;
    std::string doubts;
    try {
      for (const auto& [number, file] : promise.files) {
        const fs::path path = cut / kFiles[number];
        if (!fs::exists(path)) {
          if (file.saved || file.before) return {.wrong = path.filename().string() + ": a saved file is gone"};
          continue;
        }
        const OpenedDocument opened = openDocument(path);
        if (!opened.notes.empty()) return {.wrong = path.filename().string() + ": " + opened.notes.front()};
        const uint64_t hash = hashOf(*opened.states[opened.done].document);
        const auto is = [&](const std::optional<size_t>& moment) {
          return moment && truth.moments[*moment].hash == hash;
        };
        const std::optional<size_t> moment = is(file.saving) ? file.saving : is(file.saved) ? file.saved : std::nullopt;
        if (!moment) {
          if (!file.saved && file.before == hash) continue;
          return {.wrong = path.filename().string() + ": holds what was not saved last: " + hex(hash)};
        }
        covered = std::max(covered, truth.moments[*moment].actions);
        if (!thorough) continue;
        if (const std::string wrong = compareHistory(opened.states, opened.done, *opened.documentRecords, opened.base,
                                                     {}, truth.moments[*moment]);
            !wrong.empty())
          return {.wrong = path.filename().string() + ": " + wrong};
      }
      if (promise.repeating && !isNoted(cut))
        return {.wrong = "a stroke is being repeated and the journal does not say so"};
      for (const Recoverable& each : recoverable(cut / kJournals)) {
        if (!each.some()) {
          doubts += each.sentence + " ";
          continue;
        }
        RecoverChoice choice;
        choice.boot = "after the cut";
        Recovered recovered;
        try {
          recovered = recover(each.journal, nullptr, choice);
        } catch (const Error& e) {
          doubts += std::string(e.what()) + " ";
          continue;
        }
        OpenedDocument& document = recovered.document;
        looked.damaged = looked.damaged || !document.notes.empty();
        // What was repaired is told as such: it is worth what it is worth, and covers nothing.
        if (document.states.size() == 1 && recovered.file.empty() && !document.notes.empty() &&
            document.notes.front().find("was repaired") != std::string::npos) {
          doubts += document.notes.front() + " ";
          continue;
        }
        looked.midStroke = looked.midStroke || (!recovered.strokes.empty() && !recovered.strokes.back().ended);
        size_t from = 0;
        const uint64_t hash = hashOf(*document.states[document.done].document);
        const auto place = truth.find(hash, recovered.strokes, promise.acted + 1, &from);
        if (!place)
          return {.wrong = "the journal tells of a document or a stroke that never was: " + hex(hash) + ", " +
                           std::to_string(recovered.strokes.size()) + " strokes: " + recovered.sentence};
        if (thorough && document.notes.empty()) {
          const std::string wrong = compareHistory(document.states, document.done, *document.documentRecords,
                                                   document.base, recovered.sources, truth.moments[from]);
          if (!wrong.empty()) return {.wrong = "recovered: " + wrong};
        }
        if (replay(recovered) != 0) return {.wrong = "a stroke cannot be repeated"};
        const uint64_t after = hashOf(*document.states[document.done].document);
        if (after != truth.hashAt(*place)) return {.wrong = "strokes done again gave other clay"};
        covered = std::max(covered, truth.actionsOf(*place));
        looked.recovered = true;
      }
    } catch (const std::exception& e) {
      return {.wrong = std::string("thrown: ") + e.what()};
    }
    const auto msAt = [&](uint64_t actions) { return actions == 0 ? 0 : truth.actedMs[actions - 1]; };
    looked.lostMs = std::max(0.0, msAt(promise.acted) - msAt(covered));
    if (covered < promise.flushed) {
      looked.wrong = std::to_string(covered) + " of " + std::to_string(promise.flushed) +
                     " actions are there that were flushed; " + std::to_string(promise.acted) + " were done. " + doubts;
    } else if (looked.lostMs > kMostLostMs) {
      looked.wrong = std::to_string(looked.lostMs) + " ms of work are gone. " + doubts;
    }
    return looked;
  }

  static bool isNoted(const fs::path& cut) {
    for (const auto& each : fs::directory_iterator(cut / kJournals)) {
      if (each.path().extension() != ".journal") continue;
      try {
        io::JournalReader reader(each.path(), false);
        if (readStory(reader).replay) return true;
      } catch (const Error&) {
      }
    }
    return false;
  }

  // Every step that can be gone to.
  static std::string compareHistory(const std::vector<HistoryState>& states, size_t done,
                                    DocumentRecords& documentRecords, const std::shared_ptr<const Base>& base,
                                    const std::vector<std::shared_ptr<io::RecordSource>>& sources,
                                    const Truth::Moment& moment) {
    if (done != moment.done || states.size() > moment.history.size())
      return "another history: " + std::to_string(done) + " of " + std::to_string(states.size() - 1) + " steps";
    Session session(states, done);
    session.setReader(
        [&](uint64_t kept, const Document& near) { return readState(documentRecords, base, sources, kept, near); });
    for (size_t i = 0; i < states.size(); ++i) {
      session.goTo(i);
      if (hashOf(*session.document()) != moment.history[i]) return "step " + std::to_string(i) + " is not what it was";
    }
    return {};
  }

  struct Sum {
    size_t cuts = 0, recovered = 0, midStroke = 0, damaged = 0;
    double mostLostMs = 0;
    std::string wrong;  // the first one
  };

  struct Cut {
    size_t ops = 0;
    CutDisk::Loss loss = CutDisk::Loss::all;
    uint64_t seed = 0;
  };

  // In the order of time. Stops at the first that is wrong.
  Sum cutAndLook(Work& work, const std::vector<Cut>& cuts, const CutDisk::Ignores& ignores = {}) const {
    Sum sum;
    CutDisk disk(work.trace, ignores);
    Promise promise = work.promise;
    const auto& ops = work.trace.ops;
    size_t at = 0;
    for (const Cut& cut : cuts) {
      // Notes behind an operation are heard: what was promised was promised on the strength of it.
      size_t to = cut.ops;
      while (to < ops.size() && ops[to].kind == TraceOp::Kind::note) {
        if (Said(ops[to++].at >> 56) == Said::repeating) break;
      }
      for (; at < to; ++at) {
        if (ops[at].kind == TraceOp::Kind::note) promise.hear(ops[at]);
      }
      disk.advance(to);
      failing::writeImage(root(), disk.image(cut.loss, cut.seed));
      const Looked looked = look(root(), work.truth, promise, sum.cuts % 4 == 1);
      ++sum.cuts;
      sum.recovered += looked.recovered;
      sum.midStroke += looked.midStroke;
      sum.damaged += looked.damaged;
      sum.mostLostMs = std::max(sum.mostLostMs, looked.lostMs);
      if (looked.wrong.empty()) continue;
      sum.wrong = "cut " + std::to_string(sum.cuts) + ", behind operation " + std::to_string(to) + " of " +
                  std::to_string(ops.size()) + ", seed " + std::to_string(cut.seed) + ", " +
                  (cut.loss == CutDisk::Loss::nothing ? "nothing lost"
                   : cut.loss == CutDisk::Loss::all   ? "all lost"
                                                      : "some lost") +
                  ": " + looked.wrong;
      break;
    }
    return sum;
  }

  // So many, spread evenly over the trace.
  static std::vector<Cut> cutsEverywhere(const Trace& trace, size_t count, uint64_t seed) {
    std::vector<size_t> moments;  // after an operation that changes something
    for (size_t i = 0; i < trace.ops.size(); ++i) {
      if (trace.ops[i].kind != TraceOp::Kind::note) moments.push_back(i + 1);
    }
    std::vector<Cut> cuts;
    for (size_t i = 0; i < count; ++i) {
      const auto loss = i % 8 == 0 ? CutDisk::Loss::nothing : i % 8 < 3 ? CutDisk::Loss::all : CutDisk::Loss::some;
      cuts.push_back({moments[i * moments.size() / count], loss, seed * 1'000'003 + i});
    }
    return cuts;
  }

  // Where most is at stake: something was just promised, or is about to be flushed, renamed or removed.
  static std::vector<Cut> cutsWhereItMatters(const Trace& trace) {
    std::vector<Cut> cuts;
    for (size_t i = 1; i < trace.ops.size(); ++i) {
      const auto kind = trace.ops[i].kind;
      const bool promised = kind == TraceOp::Kind::note && Said(trace.ops[i].at >> 56) != Said::acted;
      if (!promised && kind != TraceOp::Kind::flush && kind != TraceOp::Kind::rename && kind != TraceOp::Kind::unlink)
        continue;
      cuts.push_back({i, CutDisk::Loss::all, 0});
      // A name that came without another change of the folder needs some luck.
      const TraceOp* last = kind == TraceOp::Kind::flush ? entryBeside(trace, i, trace.ops[i].node, true) : nullptr;
      const uint64_t seeds = last && last->kind == TraceOp::Kind::rename ? 64 : 3;
      for (uint64_t seed = 0; seed < seeds; ++seed) cuts.push_back({i, CutDisk::Loss::some, 100 * i + seed});
    }
    return cuts;
  }

  static size_t cutsOf(size_t share) { return tests::byTier(share / 20, share); }

  void expectAllPromisesKept(Work work, size_t share) {
    const char* first = std::getenv("ARGIL_POWER_CUT_SEED");
    const uint64_t seed = first ? std::strtoull(first, nullptr, 10) : 1;
    const Sum sum = cutAndLook(work, cutsEverywhere(work.trace, cutsOf(share), seed));
    std::printf(
        "  seed %llu: %zu cuts of a trace of %zu operations: %zu recovered from a journal, %zu in mid-stroke, %zu told "
        "of damage; at most %.0f ms of work lost\n",
        static_cast<unsigned long long>(seed), sum.cuts, work.trace.ops.size(), sum.recovered, sum.midStroke,
        sum.damaged, sum.mostLostMs);
    EXPECT_EQ(sum.wrong, "");
    EXPECT_GT(sum.recovered, sum.cuts / 4);
  }

  fs::path folder;
};

TEST_F(PowerCuts, BetweenFirstSaves) {
  expectAllPromisesKept(firstSaves(), 3000);
}
TEST_F(PowerCuts, WhileAJournalGrowsAndASaveGoesOn) {
  expectAllPromisesKept(growth(), 2500);
}
TEST_F(PowerCuts, InTheMiddleOfARecovery) {
  expectAllPromisesKept(recovery(), 2000);
}
TEST_F(PowerCuts, WhileStepsLeaveMemory) {
  expectAllPromisesKept(spilling(), 2000);
}
TEST_F(PowerCuts, InASaveOverAFileThatACutLeftHalfSaved) {
  expectAllPromisesKept(overACutSave(), 500);
}

// The tests above would be worth little if they held on a disk that flushes nothing: each kind of flush that Argil asks
// for is left out once, and some cut has to show it.
TEST_F(PowerCuts, AFlushThatIsLeftOutIsNoticed) {
  enum class In { saves, recovery, overACutSave };
  struct Kind {
    const char* name;
    In work;
    bool (*is)(const Trace&, size_t);
  };
  static const auto named = [](const Trace& trace, size_t at, const char* name) { return trace.ops[at].name == name; };
  static const auto ending = [](const Trace& trace, size_t at, const char* end) {
    return trace.ops[at].name.ends_with(end);
  };
  // Of the documents' folder, behind and before such changes of it.
  static const auto docs = [](const Trace& trace, size_t at, TraceOp::Kind before, const char* end) {
    const TraceOp* last = entryBeside(trace, at, trace.ops[at].node, true);
    return named(trace, at, "docs") && last && last->kind == before && last->name.ends_with(end);
  };
  static const auto thenRenamed = [](const Trace& trace, size_t at) {
    const TraceOp* next = entryBeside(trace, at, trace.ops[at].node, false);
    return next && next->kind == TraceOp::Kind::rename;
  };
  static constexpr Kind kKinds[] = {
      {"a journal", In::saves, [](const Trace& trace, size_t at) { return ending(trace, at, ".journal"); }},
      {"the folder of journals", In::saves, [](const Trace& trace, size_t at) { return named(trace, at, "journal"); }},
      {"the folder above that", In::saves, [](const Trace& trace, size_t at) { return named(trace, at, "argil"); }},
      {"the folder above both", In::saves, [](const Trace& trace, size_t at) { return named(trace, at, "state"); }},
      {"the folder that was there", In::saves, [](const Trace& trace, size_t at) { return named(trace, at, "work"); }},
      {"a new document before it gets its name", In::saves,
       [](const Trace& trace, size_t at) { return ending(trace, at, ".tmp"); }},
      {"the folder behind that", In::saves,
       [](const Trace& trace, size_t at) { return docs(trace, at, TraceOp::Kind::rename, ".tmp"); }},
      {"the rollback journal of a save", In::saves,
       [](const Trace& trace, size_t at) { return ending(trace, at, ".argil-journal"); }},
      {"the folder behind that", In::saves,
       [](const Trace& trace, size_t at) { return docs(trace, at, TraceOp::Kind::create, ".argil-journal"); }},
      {"a document before its rollback journal goes", In::saves,
       [](const Trace& trace, size_t at) { return ending(trace, at, ".argil"); }},
      {"the folder when that has gone", In::saves,
       [](const Trace& trace, size_t at) {
         return docs(trace, at, TraceOp::Kind::unlink, ".argil-journal") && !thenRenamed(trace, at);
       }},
      {"the folder between a rollback and a new document", In::overACutSave,
       [](const Trace& trace, size_t at) {
         return docs(trace, at, TraceOp::Kind::unlink, ".argil-journal") && thenRenamed(trace, at);
       }},
      {"the note that a stroke is repeated", In::recovery,
       [](const Trace& trace, size_t at) {
         return ending(trace, at, ".journal") && trace.ops[at].node < trace.before.size();
       }},
      {"the journal behind a recovery", In::recovery,
       [](const Trace& trace, size_t at) {
         return ending(trace, at, ".journal") && trace.ops[at].node >= trace.before.size();
       }},
  };
  std::map<In, Work> works;
  for (const Kind& kind : kKinds) {
    if (!works.contains(kind.work))
      works[kind.work] = kind.work == In::saves      ? firstSaves()
                         : kind.work == In::recovery ? recovery()
                                                     : overACutSave();
    Work& work = works[kind.work];
    size_t left = 0;
    for (size_t i = 0; i < work.trace.ops.size(); ++i)
      left += work.trace.ops[i].kind == TraceOp::Kind::flush && kind.is(work.trace, i);
    EXPECT_GT(left, 0u) << kind.name << ": never flushed";
    const Sum sum = cutAndLook(work, cutsWhereItMatters(work.trace), kind.is);
    std::printf("  without the flush of %s (%zu times): %s\n", kind.name, left,
                sum.wrong.empty() ? "nothing is noticed" : sum.wrong.c_str());
    EXPECT_NE(sum.wrong, "") << kind.name;
  }
}

}  // namespace
}  // namespace argil::engine
