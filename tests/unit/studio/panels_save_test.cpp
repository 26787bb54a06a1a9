// Saving, the question before work is lost, recent files, recovery: by mouse and keys, with a real document.

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "engine/saving/saved_document.h"
#include "panels_rig.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;

const char* dialog() {
  const ImGuiWindow* top = ImGui::GetTopMostPopupModal();
  return top ? top->Name : "";
}
void press(PanelsRig& rig, const char* window, const char* button) {
  const ImVec2 at = rig.find(window, {button, "button"});
  ASSERT_FALSE(std::isnan(at.x)) << button;
  rig.click(at);
}
void addBlock(PanelsRig& rig) {
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1 && rig.bench.snapshot()->file.unsaved; },
            "a block that is not saved");
}

class SavePanels : public testing::Test {
 protected:
  SavePanels() {
    folder = fs::path(testing::TempDir()) / ("argil_keep_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    rig.state.shown.firstStart = false;
  }
  ~SavePanels() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  void typeName(const std::string& name) {
    const ImVec2 at = rig.find("Files", {"##name"});
    ASSERT_FALSE(std::isnan(at.x));
    rig.click(at);
    ImGui::GetIO().KeyCtrl = true;
    rig.key(ImGuiKey_A);
    ImGui::GetIO().KeyCtrl = false;
    rig.type(name);
    rig.key(ImGuiKey_Enter);
    rig.frames(3);
  }
  size_t pieces() { return rig.bench.snapshot()->document->pieces.size(); }

  PanelsRig rig;
  fs::path folder;
};

TEST_F(SavePanels, ANewDocumentAsksWhereWorkWouldBeLost) {
  rig.run("file.new");
  EXPECT_STREQ(dialog(), "") << "asks for an empty document";
  addBlock(rig);
  rig.run("file.new");
  ASSERT_STREQ(dialog(), "Keep") << "work is gone without a question";
  press(rig, "Keep", "Cancel");
  rig.frames(20);
  EXPECT_EQ(pieces(), 1u);
  EXPECT_STREQ(dialog(), "");
  rig.run("file.new");
  rig.key(ImGuiKey_Escape);
  rig.frames(20);
  EXPECT_EQ(pieces(), 1u) << "Escape is no leave";
  rig.run("file.new");
  press(rig, "Keep", "Don't save");
  rig.until([&] { return pieces() == 0; }, "a new document");
  EXPECT_STREQ(dialog(), "");
}

TEST_F(SavePanels, UntitledWorkIsSavedUnderANameAndThenLeft) {
  addBlock(rig);
  rig.state.quit = true;
  rig.frames(3);
  ASSERT_STREQ(dialog(), "Keep");
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  ASSERT_STREQ(dialog(), "Files");
  rig.key(ImGuiKey_Escape);
  rig.frames(30);
  EXPECT_FALSE(rig.state.leave) << "left though no name was given";
  rig.state.quit = true;
  rig.frames(3);
  press(rig, "Keep", "Save");
  rig.frames(3);
  typeName((folder / "head").string());
  rig.until([&] { return rig.state.leave; }, "leave");
  EXPECT_TRUE(fs::exists(folder / "head.argil"));
  EXPECT_EQ(rig.bench.snapshot()->file.path, folder / "head.argil");
}

TEST_F(SavePanels, ASaveThatFailsKeepsTheStudioOpen) {
  addBlock(rig);
  rig.state.quit = true;
  rig.frames(3);
  press(rig, "Keep", "Save");
  rig.frames(3);
  typeName("/proc/head.argil");
  rig.until([&] { return std::string(dialog()).empty(); }, "the question is over");
  rig.frames(60);
  EXPECT_FALSE(rig.state.leave);
  EXPECT_EQ(pieces(), 1u);
  EXPECT_TRUE(rig.bench.snapshot()->file.unsaved);
}

TEST_F(SavePanels, SaveGoesToTheSameFileAndSaveAsAsksBeforeItReplaces) {
  addBlock(rig);
  rig.run("file.save");
  typeName((folder / "a.argil").string());
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved");
  rig.edit("Work", [](engine::Document& d) { d.pieces[0].name = "Work"; });
  EXPECT_TRUE(rig.bench.snapshot()->file.unsaved);
  rig.run("file.save");
  EXPECT_STREQ(dialog(), "") << "the name is known";
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved again");

  std::ofstream(folder / "b.argil") << "something else";
  rig.run("file.saveAs");
  typeName((folder / "b.argil").string());
  ASSERT_STREQ(dialog(), "Files") << "replaced without a question";
  EXPECT_EQ(fs::file_size(folder / "b.argil"), 14u);
  press(rig, "Files", "Replace");
  rig.until([&] { return rig.bench.snapshot()->file.path == folder / "b.argil"; }, "saved as");
  EXPECT_GT(fs::file_size(folder / "b.argil"), 14u);
}

TEST_F(SavePanels, AnotherNameIsOfferedWhereTheFileIsSomebodyElsesByNow) {
  const fs::path file = folder / "a.argil", kept = folder / "kept";
  addBlock(rig);
  rig.run("file.save");
  typeName(file.string());
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved");
  fs::copy_file(file, kept);
  rig.edit("Work", [](engine::Document& d) { d.pieces[0].name = "Work"; });
  rig.run("file.save");
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved again");
  fs::rename(kept, file);  // as a sync program does
  const auto size = fs::file_size(file);
  rig.edit("More work", [](engine::Document& d) { d.pieces[0].name = "More work"; });
  rig.run("file.save");
  rig.until([&] { return std::string(dialog()) == "Files"; }, "another name is offered");
  EXPECT_EQ(fs::file_size(file), size);
  rig.frames(5);
  rig.key(ImGuiKey_Escape);
  rig.frames(5);
  ASSERT_STREQ(dialog(), "");
  // Before Argil is left, too.
  rig.state.quit = true;
  rig.frames(3);
  ASSERT_STREQ(dialog(), "Keep");
  press(rig, "Keep", "Save");
  rig.until([&] { return std::string(dialog()) == "Files"; }, "another name is offered before it is left");
  rig.frames(5);
  typeName((folder / "b.argil").string());
  rig.until([&] { return rig.state.leave; }, "leave");
  EXPECT_EQ(rig.bench.snapshot()->file.path, folder / "b.argil");
  EXPECT_EQ(fs::file_size(file), size);
}

TEST_F(SavePanels, ACopyWithoutHistoryLeavesTheDocumentWhereItIs) {
  addBlock(rig);
  rig.run("file.save");
  typeName((folder / "a.argil").string());
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved");
  rig.run("file.saveCopy");
  ASSERT_STREQ(dialog(), "Files");
  typeName((folder / "c.argil").string());
  rig.until([&] { return fs::exists(folder / "c.argil"); }, "a copy");
  rig.until([&] { return rig.bench.idle(); }, "at rest");
  EXPECT_EQ(rig.bench.snapshot()->file.path, folder / "a.argil");
  EXPECT_EQ(engine::openDocument(folder / "c.argil").steps, 0u);
  EXPECT_EQ(engine::openDocument(folder / "a.argil").steps, 1u);
}

TEST_F(SavePanels, RecentFilesOpenAndMissingOnesDoNot) {
  addBlock(rig);
  rig.run("file.save");
  typeName((folder / "a.argil").string());
  rig.until([&] { return !rig.bench.snapshot()->file.unsaved; }, "saved");
  rig.run("file.new");
  rig.until([&] { return pieces() == 0; }, "a new document");
  rig.state.recentFiles = {(folder / "gone.argil").string(), (folder / "a.argil").string()};
  rig.run("file.recent");
  ASSERT_STREQ(dialog(), "Recent");
  // The rows stand below the title.
  ImGuiWindow* window = ImGui::FindWindowByName("Recent");
  const auto row = [&](int i) { return ImVec2(window->Pos.x + 200, window->Pos.y + 66 + float(i) * 34); };
  rig.click(row(0));
  rig.frames(5);
  ASSERT_STREQ(dialog(), "Recent") << "opens a file that is not there";
  rig.click(row(1));
  rig.until([&] { return pieces() == 1; }, "opened");
  EXPECT_EQ(rig.bench.snapshot()->file.path, folder / "a.argil");
  EXPECT_EQ(rig.state.recentFiles[0], (folder / "a.argil").string());
  rig.run("file.recent");
  press(rig, "Recent", "Clear list");
  EXPECT_TRUE(rig.state.recentFiles.empty());
}

void crash() {
  engine::Workbench bench;
  bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (bench.snapshot()->document->pieces.empty() || !bench.idle()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  bench.leaveJournal();
}

TEST(SaveRecovery, WhatACrashLeftIsOfferedAndComesBack) {
  crash();
  PanelsRig rig;
  rig.state.shown.firstStart = false;
  rig.until([&] { return std::string(dialog()) == "Recover"; }, "offered");
  rig.frames(2);
  press(rig, "Recover", "Later");
  rig.frames(30);
  EXPECT_STREQ(dialog(), "") << "later is later";
  rig.run("file.recover");
  ASSERT_STREQ(dialog(), "Recover");
  ImGuiWindow* window = ImGui::FindWindowByName("Recover");
  const auto button = [&](const char* name) {
    const std::string journal = rig.bench.recoverable()->front().journal.string();
    return rig.findFrom(window, {journal.c_str(), name, "button"});
  };
  ASSERT_FALSE(std::isnan(button("Recover").x));
  rig.click(button("Recover"));
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "recovered");
  EXPECT_TRUE(rig.bench.snapshot()->file.unsaved);
  EXPECT_TRUE(rig.bench.snapshot()->file.path.empty());
}

TEST(SaveRecovery, ItIsThrownAwayByTwoPresses) {
  crash();
  PanelsRig rig;
  rig.state.shown.firstStart = false;
  rig.until([&] { return std::string(dialog()) == "Recover"; }, "offered");
  rig.frames(2);
  const fs::path journal = rig.bench.recoverable()->front().journal;
  const auto button = [&](const char* name) {
    return rig.findFrom(ImGui::FindWindowByName("Recover"), {journal.c_str(), name, "button"});
  };
  const ImVec2 at = button("Discard");
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.frames(20);
  EXPECT_TRUE(fs::exists(journal));
  rig.click(button("Discard for good"));
  rig.until([&] { return !fs::exists(journal); }, "discarded");
  rig.until([&] { return rig.bench.recoverable()->empty(); }, "out of the list");
}

}  // namespace
}  // namespace argil::studio
