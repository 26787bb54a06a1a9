// A workbench keeps what is made: it saves, opens, says what is unsaved, and brings back what a crash left.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "engine/session/workbench.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class WorkbenchSaving : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("argil-workbench-keeping-" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder / "state");
  }
  void TearDown() override { fs::remove_all(folder); }

  Workbench::Options options() const {
    Workbench::Options given;
    given.realtime = false;
    given.journalFolder = folder / "state";
    return given;
  }
  static bool until(const std::function<bool()>& what) {
    for (int i = 0; i < 150'000; ++i) {
      if (what()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  static bool rest(Workbench& bench) {
    return until([&] { return bench.idle() && !bench.snapshot()->file.saving; });
  }
  static void block(Workbench& bench) {
    bench.addBlock({30, 30, 20}, 2, {.voxelMm = 1});
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
    ASSERT_TRUE(rest(bench));
  }
  static void lift(Workbench& bench, double mm) {
    const size_t done = bench.snapshot()->done;
    bench.edit("Lift", [mm](Document& d) { d.pieces[0].pose.translation.z() += mm; });
    ASSERT_TRUE(until([&] { return bench.snapshot()->done == done + 1; }));
  }
  static std::string told(Workbench& bench) {
    std::string all;
    for (const Message& message : bench.takeMessages()) all += message.text + "\n";
    return all;
  }

  fs::path folder;
};

TEST_F(WorkbenchSaving, SavesAndOpensAndKnowsWhatIsUnsaved) {
  const fs::path file = folder / "a.argil";
  uint64_t hash = 0;
  {
    Workbench bench(options());
    EXPECT_FALSE(bench.snapshot()->file.unsaved) << "nothing was made";
    block(bench);
    EXPECT_TRUE(bench.snapshot()->file.unsaved);
    bench.save({});
    ASSERT_TRUE(rest(bench));
    EXPECT_THAT(told(bench), HasSubstr("no file yet"));
    bench.saveAs(folder / "a", {"{\"camera\": 1}", {}});
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; }));
    EXPECT_EQ(bench.snapshot()->file.path, file) << "the ending is added";
    EXPECT_THAT(told(bench), HasSubstr("Saved"));
    lift(bench, 2);
    ASSERT_TRUE(until([&] { return bench.snapshot()->file.unsaved; }));
    bench.undo();
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << "back at what was saved";
    bench.redo();
    for (int i = 0; i < 3; ++i) bench.save({});  // one after the other
    ASSERT_TRUE(rest(bench));
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; }));
    const std::string text = told(bench);
    EXPECT_THAT(text, Not(HasSubstr("another program")));
    bench.saveAs("/nowhere/at/all.argil", {});
    ASSERT_TRUE(rest(bench));
    EXPECT_THAT(told(bench), HasSubstr("Not saved"));
    EXPECT_EQ(bench.snapshot()->file.path, file);
    hash = bench.snapshot()->document->pieces[0].version.hash();
  }
  EXPECT_TRUE(fs::is_empty(folder / "state")) << "who ends orderly leaves no journal";
  Workbench bench(options());
  const uint64_t before = bench.snapshot()->file.opened;
  bench.open(file);
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
  const auto now = bench.snapshot();
  EXPECT_GT(now->file.opened, before);
  EXPECT_FALSE(now->file.unsaved);
  ASSERT_NE(now->file.face, nullptr);
  EXPECT_EQ(*now->file.face, "{\"camera\": 1}");
  EXPECT_EQ(now->document->pieces[0].version.hash(), hash);
  EXPECT_EQ(now->document->pieces[0].pose.translation.z(), 2);
  EXPECT_EQ(*now->history, (std::vector<std::string>{"Add block", "Lift"}));
  bench.goTo(1);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == 1; })) << told(bench);
  EXPECT_EQ(bench.snapshot()->document->pieces[0].pose.translation.z(), 0);
  bench.goTo(0);
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.empty(); }));
}

TEST_F(WorkbenchSaving, TwoWindowsWithOneDocumentAreToldOfEachOtherAndNeverMixed) {
  const fs::path file = folder / "x.argil", other = folder / "y.argil";
  Workbench first(options()), second(options());
  block(first);
  first.saveAs(file, {});
  ASSERT_TRUE(until([&] { return !first.snapshot()->file.unsaved; })) << told(first);
  second.open(file);
  ASSERT_TRUE(until([&] { return second.snapshot()->document->pieces.size() == 1; }));
  ASSERT_TRUE(rest(second));
  EXPECT_THAT(told(second), HasSubstr("x.argil is open in another window"));
  EXPECT_TRUE(second.snapshot()->file.elsewhere);
  ASSERT_TRUE(until([&] { return first.snapshot()->file.elsewhere; })) << "the first window finds out too";
  EXPECT_THAT(told(first), HasSubstr("x.argil is open in another window"));
  lift(first, 2);
  lift(second, 5);
  second.save({});
  ASSERT_TRUE(until([&] { return !second.snapshot()->file.unsaved; })) << told(second);
  told(first);
  first.save({});
  ASSERT_TRUE(until([&] { return first.snapshot()->file.refused == 1; })) << "another name is to be offered";
  ASSERT_TRUE(rest(first));
  EXPECT_THAT(told(first), AllOf(HasSubstr("x.argil"), HasSubstr("another name")));
  EXPECT_THAT(first.snapshot()->file.refusal, AllOf(HasSubstr("x.argil"), HasSubstr("another name")));
  EXPECT_TRUE(first.snapshot()->file.unsaved);
  // Nor does a window replace what another one has open.
  second.saveAs(other, {});
  ASSERT_TRUE(until([&] { return second.snapshot()->file.path == other; })) << told(second);
  first.saveAs(other, {});
  ASSERT_TRUE(rest(first));
  EXPECT_THAT(told(first), HasSubstr("y.argil is open in another window"));
  EXPECT_EQ(first.snapshot()->file.refused, 1u);
  first.saveAs(folder / "z.argil", {});
  ASSERT_TRUE(until([&] { return !first.snapshot()->file.unsaved; })) << told(first);
  EXPECT_TRUE(until([&] { return !first.snapshot()->file.elsewhere && !second.snapshot()->file.elsewhere; }))
      << "each has a file of its own by now";
  for (const auto& [path, mm] : {std::pair{file, 5.0}, {other, 5.0}, {folder / "z.argil", 2.0}}) {
    const OpenedDocument opened = openDocument(path);
    EXPECT_EQ(opened.states[opened.done].document->pieces[0].pose.translation.z(), mm) << path;
  }
}

TEST_F(WorkbenchSaving, AFileThatWasGivenUpIsNobodysAndIsSavedOverAgain) {
  const fs::path file = folder / "x.argil";
  Workbench bench(options());
  block(bench);
  {
    Workbench other(options());
    block(other);
    other.saveAs(file, {});
    ASSERT_TRUE(until([&] { return !other.snapshot()->file.unsaved; }));
    bench.saveAs(file, {});
    ASSERT_TRUE(rest(bench));
    EXPECT_THAT(told(bench), HasSubstr("open in another window"));
  }
  bench.saveAs(file, {});
  ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << told(bench);
}

TEST_F(WorkbenchSaving, ACopyWithoutHistoryIsSavedBesideTheDocument) {
  const fs::path file = folder / "x.argil", copy = folder / "copy.argil";
  Workbench bench(options());
  block(bench);
  lift(bench, 2);
  bench.saveAs(file, {});
  ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; }));
  lift(bench, 3);
  told(bench);
  bench.saveCopy(folder / "copy", {"{\"camera\": 1}", {}});
  ASSERT_TRUE(until([&] { return fs::exists(copy); }));
  ASSERT_TRUE(rest(bench));
  EXPECT_THAT(told(bench), AllOf(HasSubstr("copy.argil"), HasSubstr("without its 3 steps of history")));
  EXPECT_EQ(bench.snapshot()->file.path, file);
  EXPECT_TRUE(bench.snapshot()->file.unsaved) << "the document is in no file of its own still";
  const OpenedDocument opened = openDocument(copy);
  EXPECT_EQ(opened.steps, 0u);
  EXPECT_EQ(opened.face.face, "{\"camera\": 1}");
  EXPECT_EQ(opened.states[0].document->pieces[0].pose.translation.z(), 5);
  bench.saveCopy(file, {});
  ASSERT_TRUE(rest(bench));
  EXPECT_THAT(told(bench), HasSubstr("another name"));
  EXPECT_EQ(openDocument(file).steps, 2u);
  // Who opens a document is told what is in it besides.
  bench.open(file);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == 2; }));
  ASSERT_TRUE(rest(bench));
  EXPECT_THAT(told(bench), HasSubstr("x.argil holds 2 steps of its history"));
  bench.open(copy);
  ASSERT_TRUE(until([&] { return bench.snapshot()->file.path == copy; }));
  ASSERT_TRUE(rest(bench));
  EXPECT_THAT(told(bench), Not(HasSubstr("history")));
}

TEST_F(WorkbenchSaving, WhatACrashLeftIsOfferedAndComesBack) {
  {
    Workbench bench(options());
    block(bench);
    lift(bench, 5);
    bench.leaveJournal();
  }
  {
    Workbench bench(options());
    ASSERT_TRUE(until([&] { return bench.recoverable() != nullptr; }));
    ASSERT_EQ(bench.recoverable()->size(), 1u);
    const Recoverable left = bench.recoverable()->front();
    EXPECT_TRUE(left.file.empty());
    EXPECT_EQ(left.steps, 2u);
    bench.recover(left);
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; })) << told(bench);
    EXPECT_EQ(bench.snapshot()->document->pieces[0].pose.translation.z(), 5);
    EXPECT_TRUE(bench.snapshot()->file.unsaved);
    EXPECT_TRUE(bench.recoverable()->empty());
    bench.undo();
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces[0].pose.translation.z() == 0; })) << told(bench);
    bench.saveAs(folder / "r.argil", {});
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << told(bench);
    lift(bench, 7);
    bench.leaveJournal();
  }
  Workbench bench(options());
  ASSERT_TRUE(until([&] { return bench.recoverable() != nullptr; }));
  ASSERT_EQ(bench.recoverable()->size(), 1u);
  EXPECT_EQ(bench.recoverable()->front().file, folder / "r.argil");
  bench.discard(bench.recoverable()->front());
  ASSERT_TRUE(until([&] { return bench.recoverable()->empty(); }));
  Workbench third(options());
  ASSERT_TRUE(until([&] { return third.recoverable() != nullptr; }));
  EXPECT_TRUE(third.recoverable()->empty());
}

// Where the saved file is another one by now, the work still has its name; it is not written over that file.
TEST_F(WorkbenchSaving, WhatIsRecoveredKeepsItsName) {
  const fs::path file = folder / "head.argil";
  {
    Workbench bench(options());
    block(bench);
    bench.saveAs(file, {});
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << told(bench);
    lift(bench, 5);
    bench.leaveJournal();
  }
  const auto recovered = [&](Workbench& bench) {
    ASSERT_TRUE(until([&] { return bench.recoverable() != nullptr; }));
    ASSERT_EQ(bench.recoverable()->size(), 1u);
    bench.recover(bench.recoverable()->front());
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; })) << told(bench);
    EXPECT_EQ(bench.snapshot()->document->pieces[0].pose.translation.z(), 5);
    EXPECT_TRUE(bench.snapshot()->file.unsaved);
  };
  {
    Workbench bench(options());
    recovered(bench);
    EXPECT_EQ(bench.snapshot()->file.path, file) << "nothing has happened to it";
    bench.leaveJournal();
  }
  {
    Workbench other(options());
    other.open(file);
    ASSERT_TRUE(until([&] { return other.snapshot()->document->pieces.size() == 1; }));
    lift(other, 1);
    other.save({});
    ASSERT_TRUE(until([&] { return !other.snapshot()->file.unsaved; })) << told(other);
  }
  Workbench bench(options());
  recovered(bench);
  EXPECT_EQ(bench.snapshot()->file.path, fs::path());
  EXPECT_EQ(bench.snapshot()->file.name, "head.argil");
  bench.saveAs(folder / "other.argil", {});
  ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << told(bench);
  EXPECT_EQ(bench.snapshot()->file.name, "") << "it has a file of its own";
}

TEST_F(WorkbenchSaving, ADamagedDocumentIsToldAndMended) {
  const fs::path file = folder / "d.argil";
  {
    Workbench bench(options());
    block(bench);
    bench.saveAs(file, {});
    ASSERT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; }));
  }
  // A place in the middle: some bricks.
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  const auto size = static_cast<std::streamoff>(fs::file_size(file));
  stream.seekp(size / 2);
  for (int i = 0; i < 4000; ++i) stream.put('?');
  stream.close();
  Workbench bench(options());
  bench.open(file);
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
  EXPECT_THAT(told(bench), HasSubstr("damaged"));
  EXPECT_TRUE(bench.snapshot()->file.unsaved);
  EXPECT_TRUE(bench.snapshot()->file.path.empty()) << "the damaged file is not written over";
}

// Steps that are more than the budget stay in memory when there is no journal to take them: said once.
TEST_F(WorkbenchSaving, UndoThatCannotGoToTheDiskIsToldOnce) {
  std::ofstream(folder / "in the way") << "a file, where the journals' folder should be";
  Workbench::Options given = options();
  given.journalFolder = folder / "in the way" / "state";
  given.undoBytes = 1;
  Workbench bench(given);
  block(bench);
  std::string all;
  const auto times = [&] {
    all += told(bench);
    size_t count = 0;
    for (size_t at = 0; (at = all.find("Undo takes", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  for (int i = 0; i < 4; ++i) {
    bench.addBlock({8, 8, 8}, 1, {.voxelMm = 1});
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == size_t(i) + 2; }));
    bench.edit("Take away", [](Document& document) { document.remove(document.pieces.back().id); });
    bench.addBlock({8, 8, 8}, 1, {.voxelMm = 1});
    ASSERT_TRUE(until([&] { return bench.idle() && bench.snapshot()->document->pieces.size() == size_t(i) + 2; }));
  }
  ASSERT_TRUE(until([&] { return times() > 0; })) << all;
  std::this_thread::sleep_for(std::chrono::milliseconds(600));  // It looks four times a second.
  lift(bench, 1);
  ASSERT_TRUE(rest(bench));
  EXPECT_EQ(times(), 1u) << all;
}

}  // namespace
}  // namespace argil::engine
