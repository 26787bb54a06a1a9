// What a crash left comes back: of several journals the right one, without the stroke that ended the program, wherever
// the saved file lies by now.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "engine/session/recovery.h"
#include "tests/unit/engine/saving_rig.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;
using Recovery = SavingRig;

// Of two journals of one document, the newer one written over here and there.
struct TwoJournals {
  fs::path older, newer;
  std::string olderTold, newerTold;
};
TwoJournals twoJournals(const fs::path& folder, Document first) {
  TwoJournals two{folder / "left" / "2.journal", folder / "left" / "1.journal", {}, {}};
  fs::create_directories(folder / "left");
  Kept kept(std::move(first), folder / "journals");
  kept.folder = folder / "journals";
  const auto change = [&](const char* label) {
    kept.session.change(label, [](Document& d) { d.pieces[0].pose.translation.x() += 1; });
  };
  change("one");
  kept.crash(two.older);
  two.olderTold = std::to_string(kept.session.document()->pieces[0].pose.translation.x());
  // Begun anew, as when it has grown.
  kept.autosave->begin(kept.session.states(), kept.session.undoSteps(), kept.documentRecords, nullptr, kept.writer,
                       Autosave::Continued{folder / "gone", nullptr, 1});
  change("two");
  kept.crash(two.newer);
  two.newerTold = std::to_string(kept.session.document()->pieces[0].pose.translation.x());
  // The clock was set back between them.
  fs::last_write_time(two.older, fs::last_write_time(two.newer) + std::chrono::hours(1));
  return two;
}

void overwrite(const fs::path& file, std::streamoff from, std::streamoff bytes) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(from);
  for (; bytes > 0; --bytes) stream.put('?');
}

TEST_F(Recovery, TheJournalThatWasBegunLaterCountsWhateverTheClockSaid) {
  const TwoJournals two = twoJournals(folder, fullDocument());
  EXPECT_EQ(examine(two.older).steps, 1u);
  const std::vector<Recoverable> found = recoverable(folder / "left");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].journal, two.newer);
  EXPECT_FALSE(found[0].damaged);
  EXPECT_FALSE(fs::exists(two.older)) << "the newer one holds all of it";
}

TEST_F(Recovery, AnOlderJournalStaysUntilTheNewerOneWasRead) {
  const TwoJournals two = twoJournals(folder, fullDocument());
  const auto size = std::streamoff(fs::file_size(two.newer));
  overwrite(two.newer, size / 4, size / 2);  // its clay
  const std::vector<Recoverable> found = recoverable(folder / "left");
  ASSERT_TRUE(fs::exists(two.older));
  ASSERT_TRUE(fs::exists(two.newer));
  ASSERT_EQ(found.size(), 2u);
  for (const Recoverable& each : found) EXPECT_TRUE(each.some()) << each.sentence;
  const Recovered recovered = recover(two.older);
  EXPECT_TRUE(recovered.document.notes.empty());
  EXPECT_EQ(std::to_string(recovered.document.states[recovered.document.done].document->pieces[0].pose.translation.x()),
            two.olderTold);
}

// So many steps as were done since the save, however many were done before it.
TEST_F(Recovery, StepsAreCountedFromTheSave) {
  const fs::path journals = folder / "journals", file = folder / "s.argil", left = folder / "left";
  fs::create_directories(left);
  {
    Kept kept(fullDocument(), journals);
    kept.folder = journals;
    for (uint64_t i = 0; i < 16; ++i) stroke(kept.session, i);
    ASSERT_EQ(kept.session.undoSteps(), 16u);
    SaveRequest request{kept.session.states(), 16, {}, kept.documentRecords, nullptr, {}, kept.writer};
    kept.autosave->saved(saveDocument(file, request));
    kept.autosave->flush();  // the journal is begun anew
    for (uint64_t i = 0; i < 4; ++i) stroke(kept.session, 100 + i);
    ASSERT_EQ(kept.session.undoSteps(), 20u);
    const Recoverable found = examine(kept.crash(left / "1.journal"));
    EXPECT_EQ(found.steps, 4u) << found.sentence;
    EXPECT_LE(found.from, found.to);
    EXPECT_LT(std::chrono::system_clock::now() - found.to, std::chrono::minutes(10)) << "when its last thing was done";
    EXPECT_THAT(found.sentence, testing::HasSubstr(": 4 steps since it was saved"));
    // Undone to before the save, and otherwise on: two steps back, one on.
    kept.session.goTo(14);
    stroke(kept.session, 300);
    const Recoverable otherwise = examine(kept.crash(left / "2.journal"));
    EXPECT_EQ(otherwise.steps, 3u) << otherwise.sentence;
  }
  // Opened with its history, and worked on.
  OpenedDocument opened = openDocument(file);
  Session session(opened.states, opened.done);
  AutosaveOptions options;
  options.folder = folder / "others";
  options.syncS = 0.01;
  Autosave autosave(options, [](const std::string&) {});
  autosave.begin(session.states(), session.undoSteps(), opened.documentRecords, opened.base, newWriter());
  session.setWatch(&autosave);
  for (uint64_t i = 0; i < 4; ++i) stroke(session, 200 + i);
  const size_t steps = session.undoSteps() - 16;
  autosave.flush();
  for (const auto& entry : fs::directory_iterator(options.folder)) {
    if (entry.path().extension() != ".journal") continue;
    const Recoverable found = examine(entry.path());
    EXPECT_EQ(found.steps, steps) << found.sentence;
  }
  session.setWatch(nullptr);
}

TEST_F(Recovery, OneDamagedRecordCostsNoJournalAndNoDocument) {
  const fs::path journals = folder / "journals", file = folder / "s.argil", left = folder / "left";
  fs::create_directories(left);
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  SaveRequest request{kept.session.states(), 0, {}, kept.documentRecords, nullptr, {}, kept.writer};
  kept.autosave->saved(saveDocument(file, request));
  kept.autosave->flush();  // the journal is begun anew
  kept.session.change("New ball", [](Document& d) { d.pieces[1].version = ball(6); });
  const fs::path journal = kept.crash(left / "1.journal");
  // The record that says which document the step led to; the document is whole.
  std::string bytes;
  {
    std::ifstream in(journal, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  const size_t at = bytes.rfind("{\"number\":1,\"state\":");
  ASSERT_NE(at, std::string::npos);
  overwrite(journal, std::streamoff(at) + 3, 4);
  const std::vector<Recoverable> found = recoverable(left);
  ASSERT_TRUE(fs::exists(journal)) << "it is taken for one without unsaved work";
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].damaged);
  EXPECT_TRUE(found[0].some());
  EXPECT_THAT(found[0].sentence, HasSubstr("cannot be read"));
  Recovered recovered = recover(journal);
  ASSERT_FALSE(recovered.document.notes.empty()) << "damage is told";
  ASSERT_EQ(recovered.document.states.size(), recovered.document.done + 2);
  Session session(recovered.document.states, recovered.document.done);
  ASSERT_TRUE(session.redo());
  EXPECT_EQ(told(*session.document()), told(*kept.session.document()));
}

// What tells no story is offered too, behind what does.
TEST_F(Recovery, AJournalWithoutABeginningIsOfferedForRepair) {
  const fs::path left = folder / "left";
  fs::create_directories(left);
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  kept.autosave->flush();  // begun before anything is done: an end that is torn off would be none to mend
  kept.session.change("New ball", [](Document& d) { d.pieces[1].version = ball(6); });
  const fs::path whole = kept.crash(left / "1.journal"), damaged = kept.crash(left / "2.journal");
  std::string bytes;
  {
    std::ifstream in(damaged, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  const size_t at = bytes.find("{\"state\":");  // of its beginning
  ASSERT_NE(at, std::string::npos);
  overwrite(damaged, std::streamoff(at) + 3, 4);
  const std::vector<Recoverable> found = recoverable(left);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].journal, whole);
  EXPECT_FALSE(found[0].damaged);
  EXPECT_EQ(found[1].journal, damaged);
  EXPECT_TRUE(found[1].damaged);
  EXPECT_TRUE(found[1].some());
  EXPECT_THAT(found[1].sentence, HasSubstr("can be repaired"));
}

TEST_F(Recovery, AJournalFindsTheFileThatWasMoved) {
  const fs::path journals = folder / "journals", file = folder / "s.argil", moved = folder / "unplugged" / "t.argil";
  fs::create_directories(moved.parent_path());
  Kept kept(fullDocument(), journals);
  kept.folder = journals;
  SaveRequest request{kept.session.states(), 0, {}, kept.documentRecords, nullptr, {}, kept.writer};
  const auto base = saveDocument(file, request);
  // Opened again by a later session, whose journal counts on the file.
  kept.session.setWatch(nullptr);
  OpenedDocument opened = openDocument(file);
  kept.autosave->begin(opened.states, 0, opened.documentRecords, opened.base, newWriter());
  Session session(opened.states, 0);
  session.setWatch(kept.autosave.get());
  stroke(session, 2);
  fs::create_directories(folder / "left");
  const fs::path journal = kept.crash(folder / "left" / "1.journal");
  session.setWatch(nullptr);
  fs::copy_file(file, folder / "copy.argil");
  fs::rename(file, moved);

  const std::vector<Recoverable> found = recoverable(folder / "left");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].fileMissing);
  EXPECT_TRUE(found[0].some());
  EXPECT_THAT(found[0].sentence, HasSubstr("not there"));
  EXPECT_THROW((void)recover(journal), Error);
  RecoverChoice choice;
  choice.base = moved;
  {
    Recovered recovered = recover(journal, nullptr, choice);
    EXPECT_TRUE(recovered.document.notes.empty());
    EXPECT_EQ(replay(recovered), 0u);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), told(*session.document()));
    ASSERT_NE(recovered.document.base, nullptr);
    EXPECT_EQ(recovered.document.base->path, moved);
  }
  // A document of somebody else with the same count of saves, and a copy that was worked on.
  saveDocument(folder / "foreign.argil", Document::of(ball(3)));
  {
    OpenedDocument copy = openDocument(folder / "copy.argil");
    (void)saveDocument(folder / "copy.argil", {copy.states, 0, {}, copy.documentRecords, copy.base, {}, newWriter()});
  }
  for (const char* other : {"foreign.argil", "copy.argil", "none.argil"}) {
    choice.base = folder / other;
    try {
      (void)recover(journal, nullptr, choice);
      ADD_FAILURE() << other;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr(other));
    }
  }
  // Without any: what the journal alone holds, told as repaired.
  choice.base.clear();
  choice.repair = true;
  const Recovered repaired = recover(journal, nullptr, choice);
  EXPECT_FALSE(repaired.document.notes.empty());
  EXPECT_FALSE(repaired.document.states.empty());
}

// Three strokes that are known by their samples alone: the autosave never got at the records.
fs::path journalOfSamples(Kept& kept, const fs::path& to, std::vector<std::string>& tale,
                          const std::function<std::string(const Document&)>& tell,
                          const std::function<void(Session&, uint64_t)>& stroke) {
  kept.autosave->flush();
  const DocumentRecords::Lock lock = kept.documentRecords->lock();
  tale.push_back(tell(*kept.session.document()));
  for (uint64_t i = 1; i <= 3; ++i) {
    stroke(kept.session, i);
    tale.push_back(tell(*kept.session.document()));
  }
  return kept.crash(to);
}

// Saved again, and killed in what came next before the journal heard of the save: what is made from then on must take
// no number that the file has.
TEST_F(Recovery, WorkGoesOnInAFileThatWasSavedAfterItsJournalWasBegun) {
  const fs::path file = folder / "s.argil";
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  FaceData face;
  const auto save = [&](const std::shared_ptr<const Base>& base) {
    return saveDocument(
        file, {kept.session.states(), kept.session.undoSteps(), face, kept.documentRecords, base, {}, kept.writer});
  };
  const auto first = save(nullptr);
  kept.autosave->saved(first);
  kept.autosave->flush();  // the journal is begun anew
  stroke(kept.session, 1);
  kept.autosave->flush();
  kept.autosave->saving(file);
  kept.autosave->flush();
  face.thumbnail.assign(2000, std::byte{7});  // that the journal knows nothing of
  const auto second = save(first);
  std::vector<std::string> tale;
  const fs::path journal = journalOfSamples(kept, folder / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  Recovered recovered = recover(journal);
  OpenedDocument& document = recovered.document;
  ASSERT_NE(document.base, nullptr);
  ASSERT_EQ(document.base->stamp, second->stamp);
  EXPECT_GE(document.documentRecords->ids().next(), second->next);
  EXPECT_EQ(replay(recovered), 0u);
  EXPECT_EQ(told(*document.states[document.done].document), tale.back());
  (void)saveDocument(file, {document.states,
                            document.done,
                            {},
                            document.documentRecords,
                            document.base,
                            recovered.sources,
                            recovered.writer});
  const OpenedDocument opened = openDocument(file);
  EXPECT_TRUE(opened.notes.empty()) << opened.notes[0];
  EXPECT_EQ(told(*opened.states[opened.done].document), tale.back());
  EXPECT_EQ(opened.face.thumbnail, face.thumbnail);
  Session walked(opened.states, opened.done);
  walked.setReader(
      [&](uint64_t id, const Document& near) { return readState(*opened.documentRecords, opened.base, {}, id, near); });
  for (size_t i = tale.size(); i-- > 0;) {
    walked.goTo(opened.done - (tale.size() - 1 - i));
    EXPECT_EQ(told(*walked.document()), tale[i]) << i;
  }
}

// Ends the program when the stroke of this number begins.
struct Aborting : SessionWatch {
  explicit Aborting(int at) : left(at) {}
  void strokeBegan(const Tool&, const StrokeImages&) override {
    if (--left == 0) std::abort();
  }
  void strokePoint(const PathPoint&) override {}
  void toolLifted() override {}
  void strokeEnded() override {}
  void stepped(const std::string&, const DocumentPtr&, bool) override {}
  void went(size_t) override {}
  int left;
};

// Run by the test below in a program of its own.
TEST(RecoveryChild, DISABLED_repeatsStrokesUntilTheSecond) {
  const char* journal = std::getenv("ARGIL_TEST_JOURNAL");
  ASSERT_NE(journal, nullptr);
  Recovered recovered = recover(journal);
  Aborting watch(2);
  EXPECT_EQ(replay(recovered, nullptr, &watch), 0u);
}

TEST_F(Recovery, AStrokeThatEndsTheProgramDoesSoOnce) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  std::vector<std::string> tale;
  fs::create_directories(folder / "left");
  const fs::path journal = journalOfSamples(kept, folder / "left" / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  setenv("ARGIL_TEST_JOURNAL", journal.c_str(), 1);
  const std::string child = fs::canonical("/proc/self/exe").string() +
                            " --gtest_also_run_disabled_tests --gtest_filter=RecoveryChild.* > /dev/null 2>&1";
  EXPECT_NE(std::system(child.c_str()), 0) << "its second stroke was to end it";
  ASSERT_TRUE(fs::exists(journal));
  const std::vector<Recoverable> found = recoverable(folder / "left");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].strokes, 3u);
  EXPECT_EQ(found[0].leavesOut, 2u);
  EXPECT_THAT(found[0].sentence, HasSubstr("left out"));
  EXPECT_EQ(std::system(child.c_str()), 0) << "the next recovery stops before it";
  unsetenv("ARGIL_TEST_JOURNAL");
  Recovered recovered = recover(journal);
  ASSERT_EQ(recovered.strokes.size(), 1u);
  ASSERT_FALSE(recovered.document.notes.empty());
  EXPECT_THAT(recovered.document.notes.back(), HasSubstr("left out"));
  EXPECT_EQ(replay(recovered), 0u);
  EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), tale[1]);
}

TEST_F(Recovery, WhatFollowsAHoleIsNotTakenForWhatCameBeforeIt) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  std::vector<std::string> tale;
  const fs::path journal = journalOfSamples(kept, folder / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  std::string bytes;
  {
    std::ifstream in(journal, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  // The end of the first stroke and the beginning of the second: the samples of the second are there, but not its tool.
  const size_t end = bytes.find("\"number\":1,");
  ASSERT_NE(end, std::string::npos);
  for (const size_t at : {end, bytes.find("\"mirrors\"", end)}) {
    ASSERT_NE(at, std::string::npos);
    std::ofstream(journal, std::ios::binary | std::ios::trunc) << bytes;
    SCOPED_TRACE(bytes.substr(at - 20, 120));
    overwrite(journal, std::streamoff(at), 4);
    Recovered recovered = recover(journal);
    EXPECT_FALSE(recovered.document.notes.empty());
    EXPECT_EQ(recovered.strokes.size(), 1u) << ::testing::PrintToString(recovered.document.notes) << recovered.sentence;
    EXPECT_EQ(replay(recovered), 0u);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), tale[1]);
  }
}

TEST_F(Recovery, APowerCutInARecoveryLeavesOutNoStrokeUnlessItComesAgain) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  std::vector<std::string> tale;
  const fs::path journal = journalOfSamples(kept, folder / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  // What a recovery under this start of the machine leaves behind when the power is cut at the second stroke.
  const auto cutAtTheSecond = [&](const std::string& boot) {
    RecoverChoice choice;
    choice.boot = boot;
    const Recovered recovered = recover(journal, nullptr, choice);
    if (recovered.strokes.size() < 2) return recovered.strokes.size();
    const bool again = recovered.before && recovered.before->stroke == 2;
    putReplay(*recovered.journal, {2, boot, again ? recovered.before->times + 1 : 1});
    return recovered.strokes.size();
  };
  EXPECT_EQ(cutAtTheSecond("first"), 3u);
  EXPECT_EQ(cutAtTheSecond("second"), 3u) << "a power cut is no stroke's fault";
  EXPECT_EQ(cutAtTheSecond("third"), 1u) << "twice it is";
}

TEST_F(Recovery, TheLastStrokeCanBeLeftOutAndACancelledRecoveryLeavesNoMark) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  std::vector<std::string> tale;
  const fs::path journal = journalOfSamples(kept, folder / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  {
    Recovered recovered = recover(journal);
    Job job;
    job.cancel();
    EXPECT_THROW((void)replay(recovered, &job), Cancelled);
    EXPECT_EQ(recovered.strokes.size(), 3u);
  }
  RecoverChoice choice;
  choice.withoutLast = true;
  {
    Recovered recovered = recover(journal, nullptr, choice);
    ASSERT_EQ(recovered.strokes.size(), 2u);
    EXPECT_EQ(replay(recovered), 0u);
    EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), tale[2]);
  }
  Recovered recovered = recover(journal);
  EXPECT_EQ(replay(recovered), 0u);
  EXPECT_TRUE(recovered.document.notes.empty());
  EXPECT_EQ(told(*recovered.document.states[recovered.document.done].document), tale[3]);
}

TEST_F(Recovery, SaysFromWhenToWhenItIs) {
  const auto before = std::chrono::system_clock::now();
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  kept.session.change("one", [](Document& d) { d.pieces[0].pose.translation.x() += 1; });
  const Recoverable told = examine(kept.crash(folder / "1.journal"));
  const auto after = std::chrono::system_clock::now();
  EXPECT_GE(told.from, before - std::chrono::seconds(1));
  EXPECT_LE(told.from, told.to);
  EXPECT_LE(told.to, after + std::chrono::seconds(1));
}

TEST_F(Recovery, AStrokeThatEndsThePowerTwiceIsLeftOutTheThirdTime) {
  Kept kept(fullDocument(), folder / "journals");
  kept.folder = folder / "journals";
  std::vector<std::string> tale;
  const fs::path journal = journalOfSamples(kept, folder / "1.journal", tale, told,
                                            [](Session& session, uint64_t i) { stroke(session, i); });
  // The power is cut when the second stroke is about to be repeated: nothing is noted after it.
  struct Cut : Aborting {
    using Aborting::Aborting;
    void strokeBegan(const Tool&, const StrokeImages&) override {
      if (--left == 0) _exit(7);
    }
  };
  const auto recoverUnder = [&](const std::string& boot) {
    const pid_t child = fork();
    if (child == 0) {
      RecoverChoice choice;
      choice.boot = boot;
      Recovered recovered = recover(journal, nullptr, choice);
      Cut cut(2);
      const int strokes = int(recovered.strokes.size());
      (void)replay(recovered, nullptr, &cut);
      _exit(strokes);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  EXPECT_EQ(recoverUnder("first"), 7);
  EXPECT_EQ(recoverUnder("second"), 7) << "once is no stroke's fault";
  EXPECT_EQ(recoverUnder("third"), 1) << "twice is: it is left out, and what came after it";
}

}  // namespace
}  // namespace argil::engine
