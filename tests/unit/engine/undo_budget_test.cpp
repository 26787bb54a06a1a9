// Steps beyond the budget leave memory, nothing of them is lost, and the count of bytes is the store's own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/saving/autosave.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/recovery.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kRadiusMm = 15;
constexpr uint64_t kSmall = uint64_t{500} << 10;

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kRadiusMm);
}

uint64_t hashOf(const Session& session) {
  return session.version().hash();
}

void stroke(Session& session, uint64_t seed) {
  Random random(seed);
  Tool tool;
  tool.radiusMm = 2;
  tool.id = std::array{"carve", "add", "smooth"}[seed % 3];
  session.beginStroke(tool);
  Vec3d at = kRadiusMm * random.inBall().normalized();
  for (int i = 0; i < 12; ++i) {
    session.addPoint(0.001 * i, at);
    if (i % 4 == 0) session.publish();
    at += random.inBall();
  }
  session.endStroke();
}

// What the store holds beside the newest version, when all that was dropped is freed.
uint64_t besideTheNewest(const Session& session) {
  const clay::Version now = session.version();
  while (now.store()->collect(100000)) {
  }
  return now.store()->usage().bytes() - now.stats().bytes();
}

size_t countInMemory(const Session& session) {
  size_t count = 0;
  for (const HistoryState& state : session.states()) count += state.document != nullptr;
  return count;
}

class UndoBudgetTest : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-undo-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
};

// A session with its autosave, as a workbench has them.
struct Kept {
  explicit Kept(const fs::path& folder, uint64_t rollBytes = uint64_t{512} << 20)
      : journals(folder / "journals"), session(Document::of(ball())) {
    AutosaveOptions options;
    options.folder = journals;
    options.syncS = 0.005;
    options.rollBytes = rollBytes;
    autosave = std::make_unique<Autosave>(options, [this](const std::string& text) {
      if (!text.empty()) trouble = text;
    });
    records = autosave->begin(session.states(), 0, documentRecords, nullptr, writer);
    session.setWatch(autosave.get());
    session.setReader([this](uint64_t kept, const Document& near) {
      return readStep(*autosave, *documentRecords, records, kept, near);
    });
    hashes.push_back(hashOf(session));
  }
  ~Kept() { session.setWatch(nullptr); }
  void strokes(int count, uint64_t seed) {
    hashes.resize(session.undoSteps() + 1);
    for (int i = 0; i < count; ++i) {
      stroke(session, seed + uint64_t(i));
      hashes.push_back(hashOf(session));
    }
  }
  UndoUse keep(uint64_t bytes) {
    autosave->flush();
    budget.set(bytes);
    // What is new is counted a few steps at a time.
    UndoUse use;
    for (size_t i = 0; i <= session.states().size() / UndoBudget::kMostNew; ++i)
      use = budget.keep(session, [this](const DocumentPtr& document) { return autosave->kept(document); });
    autosave->flush();  // lets go too
    return use;
  }
  void saveTo(const fs::path& file) {
    SaveRequest request{session.states(), session.undoSteps(), {}, documentRecords, base, {records}, writer};
    autosave->saving(file);
    base = saveDocument(file, request);
    autosave->saved(base);
    autosave->flush();
  }
  void expectAllSteps() {
    for (const size_t to : {size_t{0}, hashes.size() - 1}) {
      while (session.undoSteps() != to) {
        if (to == 0)
          session.undo();
        else
          session.redo();
        ASSERT_EQ(hashOf(session), hashes[session.undoSteps()]) << session.undoSteps();
        if (session.undoSteps() % 7 == 0) (void)keep(budget.bytes());
      }
    }
  }

  fs::path journals;
  Session session;
  std::shared_ptr<DocumentRecords> documentRecords = std::make_shared<DocumentRecords>();
  std::shared_ptr<const Base> base;
  std::string writer = newWriter();
  std::string trouble;
  std::unique_ptr<Autosave> autosave;
  std::shared_ptr<SavedHistory> records;
  UndoBudget budget;
  std::vector<uint64_t> hashes;  // of each state
};

TEST_F(UndoBudgetTest, TheOldestGoFirstAndTheirMemoryComesBack) {
  Kept kept(folder);
  kept.strokes(40, 100);
  const UndoUse all = kept.keep(0);
  EXPECT_EQ(all.inMemory, 40u);
  EXPECT_EQ(all.onDisk, 0u);
  EXPECT_FALSE(all.over);
  EXPECT_EQ(all.bytes, besideTheNewest(kept.session)) << "what is counted is what the store holds";
  ASSERT_GT(all.bytes, 3 * kSmall);
  const UndoUse less = kept.keep(kSmall);
  EXPECT_LE(less.bytes, kSmall);
  EXPECT_GT(less.bytes, kSmall / 2) << "no more than needed";
  EXPECT_FALSE(less.over);
  EXPECT_EQ(less.inMemory + less.onDisk, 40u);
  EXPECT_EQ(less.bytes, besideTheNewest(kept.session));
  for (size_t i = 0; i <= 40; ++i) EXPECT_EQ(kept.session.states()[i].document != nullptr, i >= less.onDisk) << i;
  // Undo and redo as if nothing had gone; what was undone counts as well, and the farthest redo goes when nothing older
  // is left.
  kept.expectAllSteps();
  kept.session.goTo(0);
  const UndoUse undone = kept.keep(kSmall);
  EXPECT_LE(undone.bytes, kSmall);
  EXPECT_EQ(undone.bytes, besideTheNewest(kept.session));
  EXPECT_EQ(kept.session.states()[40].document, nullptr);
  EXPECT_EQ(undone.inMemory + 1, countInMemory(kept.session));
  kept.session.goTo(20);
  EXPECT_EQ(hashOf(kept.session), kept.hashes[20]);
  (void)kept.keep(1);
  EXPECT_EQ(countInMemory(kept.session), 1u);
  EXPECT_EQ(besideTheNewest(kept.session), 0u);
  EXPECT_EQ(kept.trouble, "");
}

TEST_F(UndoBudgetTest, StrokesAfterASpilledStepGoOnToTheBit) {
  Kept kept(folder);
  Session plain(Document::of(ball()));
  for (uint64_t seed = 1; seed <= 10; ++seed) stroke(plain, seed);
  kept.strokes(10, 1);
  (void)kept.keep(1);
  for (int i = 0; i < 6; ++i) {
    kept.session.undo();
    plain.undo();
  }
  EXPECT_EQ(hashOf(kept.session), hashOf(plain));
  kept.strokes(5, 50);
  for (uint64_t seed = 50; seed < 55; ++seed) stroke(plain, seed);
  EXPECT_EQ(hashOf(kept.session), hashOf(plain));
  EXPECT_EQ(kept.session.redoSteps(), 0u);
  (void)kept.keep(1);
  kept.expectAllSteps();
}

TEST_F(UndoBudgetTest, AStepThatIsReadSharesWithItsNeighbour) {
  Kept kept(folder);
  kept.strokes(10, 1);
  (void)kept.keep(1);
  const uint64_t whole = kept.session.version().stats().bytes();
  kept.session.undo();
  const uint64_t step = bytesAlone(*kept.session.states()[10].document, *kept.session.document());
  EXPECT_LT(step, whole / 10);
  EXPECT_LT(besideTheNewest(kept.session), step + 1);
  // At once after a stroke, before the journal has it.
  kept.session.redo();
  stroke(kept.session, 77);
  kept.session.undo();
  kept.session.undo();
  EXPECT_EQ(hashOf(kept.session), kept.hashes[9]);
  EXPECT_LT(besideTheNewest(kept.session), whole / 5);
}

TEST_F(UndoBudgetTest, StepsOutliveJournalsAndSaves) {
  Kept kept(folder, 1 << 19);  // begun anew again and again
  for (int i = 0; i < 6; ++i) {
    kept.strokes(25, 1000 + 100 * uint64_t(i));
    (void)kept.keep(kSmall);
    if (i == 1) kept.saveTo(folder / "a.argil");
    if (i == 3) kept.saveTo(folder / "a.argil");
    if (i == 4) kept.saveTo(folder / "b.argil");
  }
  EXPECT_GT(kept.autosave->counts().generations, 6u);
  EXPECT_GT(kept.keep(kSmall).onDisk, 110u) << "more than a journal or a file takes over";
  fs::remove(folder / "a.argil");
  kept.expectAllSteps();
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(kept.journals)) files += entry.path().extension() == ".journal";
  EXPECT_EQ(files, 1u) << "to anybody else there is one journal";
  // A crash brings back what it would have brought back without a budget.
  kept.autosave->flush();
  fs::path crashed;
  for (const auto& entry : fs::directory_iterator(kept.journals)) {
    crashed = folder / entry.path().filename();
    fs::copy_file(entry.path(), crashed);
  }
  Recovered recovered = recover(crashed);
  EXPECT_TRUE(recovered.document.notes.empty());
  EXPECT_GE(recovered.document.states.size(), 101u);
  Session session(recovered.document.states, recovered.document.done);
  session.setReader([&](uint64_t id, const Document& near) {
    return readState(*recovered.document.documentRecords, recovered.document.base, recovered.sources, id, near);
  });
  EXPECT_EQ(hashOf(session), kept.hashes.back());
  for (size_t back = 1; back <= 100; back += 9) {
    session.goTo(recovered.document.done - back);
    EXPECT_EQ(hashOf(session), kept.hashes[kept.hashes.size() - 1 - back]) << back;
  }
  // Saved steps that had left memory are in the file.
  kept.saveTo(folder / "c.argil");
  OpenedDocument opened = openDocument(folder / "c.argil");
  Session again(opened.states, opened.done);
  again.setReader(
      [&](uint64_t id, const Document& near) { return readState(*opened.documentRecords, opened.base, {}, id, near); });
  ASSERT_EQ(again.undoSteps(), 100u);
  for (size_t back = 0; back <= 100; back += 10) {
    again.goTo(100 - back);
    EXPECT_EQ(hashOf(again), kept.hashes[kept.hashes.size() - 1 - back]) << back;
  }
}

// A file may not grow beyond this many bytes, as on a full disk.
struct FullDisk {
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit now{bytes, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before); }
  rlimit before{};
};

TEST_F(UndoBudgetTest, NothingLeavesMemoryThatTheDiskDoesNotTake) {
  Kept kept(folder);
  kept.strokes(10, 1);
  kept.autosave->flush();
  uint64_t onDisk = 0;
  for (const auto& entry : fs::directory_iterator(kept.journals)) onDisk = fs::file_size(entry.path());
  size_t before = 0;
  {
    const FullDisk full(onDisk);
    kept.strokes(10, 20);
    kept.autosave->flush();
    EXPECT_THAT(kept.trouble, HasSubstr("journal cannot be"));
    const UndoUse use = kept.keep(1);
    before = use.onDisk;
    EXPECT_EQ(before, 11u) << "what the journal had before can be read from it still";
    EXPECT_TRUE(use.over);
    EXPECT_EQ(use.inMemory, 9u);
    kept.expectAllSteps();
  }
  kept.autosave->flush();
  EXPECT_EQ(kept.keep(1).onDisk, 20u) << "once there is room again";
  kept.expectAllSteps();
  // A journal that never was.
  fs::remove_all(folder / "other");
  std::ofstream(folder / "other").put('x');
  Kept without(folder / "other");
  without.strokes(3, 1);
  const UndoUse use = without.keep(1);
  EXPECT_TRUE(use.over);
  EXPECT_EQ(use.onDisk, 0u);
}

TEST_F(UndoBudgetTest, AWorkbenchKeepsToItWithAJournalAndWithout) {
  for (const bool journal : {true, false}) {
    Workbench::Options options;
    options.realtime = false;
    options.journalFolder = folder / "state";
    options.journal = journal;
    options.undoBytes = 0;
    Workbench bench(options);
    bench.addSphere(kRadiusMm, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return bench.snapshot()->done == 1; }));
    std::vector<uint64_t> hashes{0, bench.snapshot()->document->pieces[0].version.hash()};
    for (uint64_t i = 1; i <= 20; ++i) {
      bench.edit("Cut", [i](Document& document) {
        Random random(i);
        clay::BrushStroke brush(document.pieces[0].version, clay::Brush::of(clay::Method::carve));
        clay::Stamp stamp;
        stamp.radius = 10;
        stamp.a = stamp.b = 30 * random.inBall().normalized();
        brush.apply(stamp);
        document.pieces[0].version = brush.finish();
      });
      ASSERT_TRUE(until([&] { return bench.snapshot()->done == i + 1; }));
      hashes.push_back(bench.snapshot()->document->pieces[0].version.hash());
    }
    ASSERT_TRUE(until([&] { return bench.snapshot()->undo.inMemory == 21 && bench.snapshot()->undo.bytes > 0; }));
    const uint64_t all = bench.snapshot()->undo.bytes;
    bench.setUndoBudget(all / 4);
    ASSERT_TRUE(until([&] { return bench.snapshot()->undo.bytes <= all / 4; })) << journal;
    EXPECT_GT(bench.snapshot()->undo.onDisk, 10u);
    EXPECT_EQ(fs::is_empty(folder / "state"), !journal);
    for (size_t to = 21; to-- > 0;) {
      bench.undo();
      ASSERT_TRUE(until([&] { return bench.snapshot()->done == to; }));
      const DocumentPtr now = bench.snapshot()->document;
      EXPECT_EQ(now->pieces.empty() ? 0 : now->pieces[0].version.hash(), hashes[to]) << to;
    }
    for (const Message& message : bench.takeMessages()) ADD_FAILURE() << message.text;
  }
}

}  // namespace
}  // namespace argil::engine
