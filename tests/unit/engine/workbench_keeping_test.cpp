// A workbench keeps what is made: it saves, opens, says what is unsaved, and brings back what a crash left.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "engine/workbench.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class WorkbenchKeeping : public testing::Test {
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
    for (int i = 0; i < 5000; ++i) {
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

TEST_F(WorkbenchKeeping, savesAndOpensAndKnowsWhatIsUnsaved) {
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

TEST_F(WorkbenchKeeping, whatACrashLeftIsOfferedAndComesBack) {
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

TEST_F(WorkbenchKeeping, aDamagedDocumentIsToldAndMended) {
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

}  // namespace
}  // namespace argil::engine
