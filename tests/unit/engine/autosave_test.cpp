// What the autosave does when its journal, or the file under it, cannot be had.

#include "engine/saving/autosave.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <mutex>

#include "engine/session/recovery.h"
#include "tests/unit/engine/saving_rig.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;
using AutosaveTest = SavingRig;

// The saved file under a journal goes: the next journal holds all. A save of the document before is no reason to wait.
TEST_F(AutosaveTest, AFileThatGoesIsNotCountedOn) {
  for (const bool savingBefore : {false, true}) {
    const fs::path file = folder / "s.argil", journal = folder / "left.journal";
    Kept kept(fullDocument(), folder / "journals");
    kept.folder = folder / "journals";
    const auto base =
        saveDocument(file, {kept.session.states(), 0, {}, kept.documentRecords, nullptr, {}, kept.writer});
    if (savingBefore) kept.autosave->saving(folder / "other.argil");
    kept.session.setWatch(nullptr);
    OpenedDocument opened = openDocument(file);
    kept.autosave->begin(opened.states, 0, opened.documentRecords, opened.base, newWriter());
    Session session(opened.states, 0);
    session.setWatch(kept.autosave.get());
    stroke(session, 2);
    kept.autosave->flush();
    fs::remove(file);
    stroke(session, 3);
    kept.crash(journal);
    session.setWatch(nullptr);
    const Recovered recovered = recover(journal);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), told(*session.document()));
    fs::remove(journal);
  }
}

// The wait after a failure is for the same trouble again: another document, or a save, is a new beginning.
TEST_F(AutosaveTest, AJournalThatFailedIsTriedAtOnceForAnotherDocumentAndAfterASave) {
  for (const bool another : {true, false}) {
    const fs::path journals = folder / "busy" / "journals", file = folder / "s.argil";
    std::ofstream(folder / "busy") << "no folder";
    AutosaveOptions options;
    options.folder = journals;
    options.syncS = 0.01;
    options.retryS = options.mostRetryS = 3600;
    std::mutex mutex;
    std::string trouble;
    Autosave autosave(options, [&](const std::string& text) {
      const std::lock_guard lock(mutex);
      trouble = text;
    });
    auto documentRecords = std::make_shared<DocumentRecords>();
    const std::string writer = newWriter();
    std::vector<HistoryState> states(1);
    states[0].document = std::make_shared<const Document>(fullDocument());
    autosave.begin(states, 0, documentRecords, nullptr, writer);
    autosave.catchUp();
    {
      const std::lock_guard lock(mutex);
      EXPECT_THAT(trouble, HasSubstr("journal cannot be kept"));
    }
    fs::remove(folder / "busy");
    autosave.catchUp();
    EXPECT_EQ(autosave.counts().generations, 0u) << "it waits";
    if (another) {
      autosave.begin(states, 0, std::make_shared<DocumentRecords>(), nullptr, newWriter());
    } else {
      autosave.saved(saveDocument(file, {states, 0, {}, documentRecords, nullptr, {}, writer}));
    }
    autosave.catchUp();
    EXPECT_EQ(autosave.counts().generations, 1u);
    fs::remove_all(folder / "busy");
  }
}

// It ends with no step: a recovery repeats nothing.
TEST_F(AutosaveTest, AStrokeThatMetNoClayIsNoneOfTheJournal) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  const Recoverable before = examine(kept.crash(folder / "0.journal"));
  Tool tool;
  tool.radiusMm = 2;
  kept.session.beginStroke(tool);
  for (int i = 0; i < 20; ++i) kept.session.addPoint(0.001 * i, Vec3d(500 + i, 0, 0));
  kept.session.endStroke();
  const Recoverable left = examine(kept.crash(folder / "1.journal"));
  EXPECT_EQ(left.steps, before.steps);
  EXPECT_EQ(left.strokes, 0u);
  EXPECT_FALSE(left.midStroke);
}

// How often a file was opened since this was last asked; nothing where the system does not tell.
class Openings {
 public:
  explicit Openings(const fs::path& file) : watch_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
    works_ = watch_ >= 0 && ::inotify_add_watch(watch_, file.c_str(), IN_OPEN) >= 0;
  }
  ~Openings() {
    if (watch_ >= 0) ::close(watch_);
  }
  Openings(const Openings&) = delete;
  Openings& operator=(const Openings&) = delete;
  [[nodiscard]] bool works() const { return works_; }
  int take() {
    alignas(inotify_event) char bytes[4096];
    int count = 0;
    for (ssize_t n = 0; (n = ::read(watch_, bytes, sizeof bytes)) > 0;)
      for (ssize_t at = 0; at < n; ++count)
        at += ssize_t(sizeof(inotify_event) + reinterpret_cast<const inotify_event*>(bytes + at)->len);
    return count;
  }

 private:
  int watch_;
  bool works_ = false;
};

// It looks at the saved file once a second, whoever sleeps: where that did not change it is left alone, and its disk.
TEST_F(AutosaveTest, AFileThatStaysAsItIsIsNotOpenedAgainAndAgain) {
  const fs::path file = folder / "s.argil";
  Kept kept(fullDocument(), folder / "journals");
  kept.session.setWatch(nullptr);
  (void)saveDocument(file, {kept.session.states(), 0, {}, kept.documentRecords, nullptr, {}, kept.writer});
  OpenedDocument opened = openDocument(file);
  kept.autosave->begin(opened.states, 0, opened.documentRecords, opened.base, newWriter());
  kept.autosave->flush();
  kept.autosave->catchUp();
  Openings openings(file);
  if (!openings.works()) GTEST_SKIP() << "no inotify here";
  for (int i = 0; i < 3; ++i) kept.autosave->catchUp();
  EXPECT_EQ(openings.take(), 0);
  // Touched, it is looked into once.
  fs::last_write_time(file, fs::last_write_time(file) - std::chrono::hours(1));
  kept.autosave->catchUp();
  EXPECT_GT(openings.take(), 0);
  for (int i = 0; i < 3; ++i) kept.autosave->catchUp();
  EXPECT_EQ(openings.take(), 0);
}

// The heap's bytes; zero under sanitizers, whose heap does not count.
size_t heapBytes() {
  const struct mallinfo2 heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

// A day's work makes many documents and much clay that is forgotten again.
TEST(DocumentRecordsTest, WhatIsGoneIsForgotten) {
  constexpr int kMany = 5000;
  DocumentRecords records;
  const auto lock = records.lock();
  const auto live = [&] {
    clay::Grid grid;
    Document document;
    Piece piece;
    piece.version = clay::Version::empty(clay::Store::make(), grid);
    document.add(piece);
    EXPECT_FALSE(records.knowsClay(document));
  };
  live();
  records.tidy({});
  const size_t before = heapBytes();
  for (int i = 0; i < kMany; ++i) {
    live();
    if (i % 100 == 0) records.tidy({});
  }
  records.tidy({});
  const size_t after = heapBytes();
  EXPECT_LT(after, before + kMany * 20) << after - before << " bytes more";
}

}  // namespace
}  // namespace argil::engine
