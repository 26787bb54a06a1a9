// Files are chosen, clay is exported, keys are changed, forces are stopped: by mouse and keys alone.

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "engine/document/beside.h"
#include "panels_rig.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;

class Dialogs : public testing::Test {
 protected:
  Dialogs() {
    folder = fs::path(testing::TempDir()) / ("argil_panels_" + std::to_string(::getpid()));
    fs::create_directories(folder / "models");
    std::ofstream(folder / "models" / "tetra.obj")
        << "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::ofstream(folder / "models" / "notes.txt") << "not a mesh";
    rig.state.shown.firstStart = false;
  }
  ~Dialogs() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  // Into a field of a dialog.
  void fillIn(const char* dialog, const char* field, const std::string& text) {
    const ImVec2 at = rig.find(dialog, {field});
    ASSERT_FALSE(std::isnan(at.x)) << field;
    rig.click(at);
    rig.type(text);
  }
  void press(const char* dialog, const char* button) {
    ImVec2 at{NAN, NAN};
    // Once the size of a model is shown the dialog is put in the middle anew: the button may move while it is looked
    // for.
    for (int tries = 0; tries < 5 && std::isnan(at.x); ++tries) {
      at = rig.find(dialog, {button, "button"});
      if (!rig.isAt(at, dialog, {button, "button"})) at = {NAN, NAN};
    }
    ASSERT_FALSE(std::isnan(at.x)) << button;
    rig.click(at);
  }
  // Until the model was read and its size is shown.
  void asked() {
    rig.until([&] { return !std::isnan(rig.find("Asked", {"height", "bar"}).x); }, "the size of the model");
  }
  ImGuiWindow* list(const char* dialog) { return PanelsRig::child(dialog, "list"); }
  size_t pieces() { return rig.bench.snapshot()->document->pieces.size(); }

  PanelsRig rig;
  fs::path folder;
};

TEST_F(Dialogs, AMeshIsImportedByItsPath) {
  rig.run("file.import");
  ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr);
  fillIn("Files", "##name", (folder / "models" / "nothing.obj").string());
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr) << "closed for a file that is not there";
  fillIn("Files", "##name", (folder / "models" / "tetra.obj").string());
  rig.key(ImGuiKey_Enter);
  asked();
  press("Asked", "Voxels  +");
  rig.click(rig.find("Asked", {"Voxel size by hand", "switch"}));
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  rig.until([&] { return pieces() == 1; }, "imported");
  EXPECT_DOUBLE_EQ(rig.bench.snapshot()->document->pieces[0].version.grid().voxelMm, 0.5);
}

// Enter is the main button of a dialog, whatever else is lit in it: a format that is chosen stays chosen.
TEST_F(Dialogs, EnterExportsAndUndoesNoChoice) {
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return pieces() == 1; }, "a block");
  rig.frames(3);
  rig.state.lastFolder = folder.string();
  for (const char* format : {"STL", "OBJ", "PLY"}) {
    SCOPED_TRACE(format);
    rig.run("file.export.3mf");
    press("Export", format);
    rig.frames(2);
    rig.key(ImGuiKey_Enter);
    rig.frames(3);
    EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr) << "Enter exports";
    std::string ending(format);
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    rig.until([&] { return rig.bench.idle(); }, "idle");
    EXPECT_TRUE(fs::exists(folder / ("Block." + ending)));
    EXPECT_TRUE(fs::exists(folder / "Block.3mf")) << "was chosen before";
    std::error_code ignored;
    for (const auto& file : fs::directory_iterator(folder))
      if (file.is_regular_file()) fs::remove(file, ignored);
  }
}

TEST_F(Dialogs, EnterEndsAPageThatHasNothingToDecide) {
  for (const char* id : {"panel.preferences", "panel.shortcuts", "panel.plugins", "file.recover"}) {
    SCOPED_TRACE(id);
    rig.run(id);
    rig.frames(2);
    ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr);
    const float scale = rig.state.interfaceScale;
    const Theme theme = rig.state.theme;
    rig.key(ImGuiKey_Enter);
    rig.frames(2);
    EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
    EXPECT_EQ(rig.state.interfaceScale, scale);
    EXPECT_EQ(rig.state.theme, theme);
  }
}

// A list that is open takes arrows and Enter; the dialog below it stays.
TEST_F(Dialogs, ListsTakeArrowsAndEnter) {
  rig.run("panel.preferences");
  const ImVec2 at = rig.find("Preferences", {"Size", "##choice"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.frames(2);
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_UpArrow);
  EXPECT_EQ(rig.state.interfaceScale, 0) << "not before Enter";
  rig.key(ImGuiKey_Enter);
  rig.frames(2);
  EXPECT_EQ(rig.state.interfaceScale, 1) << "two below: 75 %, 100 %";
  ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr) << "Enter was the list's";
  rig.click(at);
  rig.frames(2);
  rig.key(ImGuiKey_UpArrow);
  rig.key(ImGuiKey_Escape);
  rig.frames(2);
  EXPECT_EQ(rig.state.interfaceScale, 1) << "Escape leaves it as it was";
}

TEST_F(Dialogs, FilesAndFoldersAreWalkedByArrows) {
  rig.run("file.part");
  fillIn("Files", "##folder", folder.string());
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  rig.click(rig.find("Files", {"##name"}));  // Where the keys go when the dialog opens.
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_Enter);  // The one folder.
  rig.frames(3);
  ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr);
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_DownArrow);  // There is but one mesh.
  rig.key(ImGuiKey_Enter);
  asked();
  rig.key(ImGuiKey_Enter);
  rig.until([&] { return rig.bench.snapshot()->document->parts.size() == 1; }, "a part");
}

TEST_F(Dialogs, RecentFilesAreWalkedByArrows) {
  for (const char* name : {"a.obj", "b.obj"})
    fs::copy_file(folder / "models" / "tetra.obj", folder / name, fs::copy_options::overwrite_existing);
  rig.state.recentFiles = {(folder / "gone.obj").string(), (folder / "a.obj").string(), (folder / "lost.obj").string(),
                           (folder / "b.obj").string()};
  rig.run("file.recent");
  rig.frames(2);
  rig.key(ImGuiKey_DownArrow);  // Over what is not there.
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_Enter);
  asked();
  EXPECT_STREQ(ImGui::GetTopMostPopupModal()->Name, "Asked");
  press("Asked", "Open");
  rig.until([&] { return pieces() == 1; }, "opened");
  EXPECT_EQ(rig.state.recentFiles[0], (folder / "b.obj").string());
}

TEST_F(Dialogs, FoldersAreWalkedByDoubleClicks) {
  rig.run("file.part");
  fillIn("Files", "##folder", folder.string());
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  const auto entry = [&](int i) {
    return rig.findId(list("Files"), ImHashStr("entry", 0, ImHashData(&i, sizeof i, list("Files")->ID)));
  };
  ImVec2 at = entry(0);
  ASSERT_FALSE(std::isnan(at.x)) << "no folder in the list";
  rig.doubleClick(at);
  rig.frames(3);
  at = entry(0);
  ASSERT_FALSE(std::isnan(at.x)) << "no file in the list";
  EXPECT_TRUE(std::isnan(entry(1).x)) << "a text file is offered as a mesh";
  rig.doubleClick(at);
  asked();
  rig.key(ImGuiKey_Enter);
  rig.until([&] { return rig.bench.snapshot()->document->parts.size() == 1; }, "a part");
}

// The model is guessed to be 20 cm and y up; what is chosen instead is what comes in: upright, on the ground, as high
// as was typed.
TEST_F(Dialogs, AModelStandsAsItIsAskedTo) {
  std::ofstream(folder / "models" / "tower.obj")
      << "v 0 5 0\nv 4 5 0\nv 0 5 10\nv 0 7 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n";
  const auto now = rig.bench.snapshot();
  Context context{rig.bench, *now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
  rig.panels->dropped(context, (folder / "models" / "tower.obj").string());
  asked();
  rig.key(ImGuiKey_Enter);  // As it is guessed: centimetres, y up.
  rig.until([&] { return pieces() == 1; }, "imported");
  const auto box = [&](size_t piece) { return engine::boundsOf(rig.bench.snapshot()->document->pieces[piece]); };
  EXPECT_NEAR(box(0).high.z() - box(0).low.z(), 20, 1.5);
  EXPECT_NEAR(box(0).low.z(), 0, 1);
  EXPECT_NEAR(box(0).high.x() - box(0).low.x(), 40, 1.5);
  EXPECT_NEAR(box(0).high.y() - box(0).low.y(), 100, 3);

  rig.panels->dropped(context, (folder / "models" / "tower.obj").string());
  asked();
  const ImVec2 height = rig.find("Asked", {"height", "bar"});
  ASSERT_FALSE(std::isnan(height.x));
  rig.doubleClick(height);
  rig.frames(3);
  rig.type("50");
  rig.key(ImGuiKey_Enter);
  rig.frames(2);
  EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr) << "the Enter that ends typing is not the one that accepts";
  press("Asked", "Import");
  rig.until([&] { return pieces() == 2; }, "imported again");
  EXPECT_NEAR(box(1).high.z() - box(1).low.z(), 50, 2);
  EXPECT_NEAR(box(1).low.z(), box(0).low.z(), 1) << "on the same ground";
  EXPECT_GT(box(1).low.x(), box(0).high.x()) << "beside what is there";
  // What came in is selected and worked on.
  rig.frames(2);
  EXPECT_EQ(rig.state.selected, rig.bench.snapshot()->document->pieces[1].id);
  EXPECT_EQ(rig.bench.snapshot()->document->active, rig.state.selected);
}

// Walls are measured while the page is looked at; what is about to be pressed stays where it is. An open sheet of 0.3
// mm is thinner than one of 256 voxels.
TEST_F(Dialogs, NothingMovesOnceWallsAreMeasured) {
  std::ofstream plate(folder / "models" / "plate.obj");
  for (int i = 0; i < 8; ++i)
    plate << "v " << (i & 1) * 100 << ' ' << (i >> 1 & 1) * 10 << ' ' << (i >> 2) * 0.3 << '\n';
  plate << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\n";
  plate.close();
  const auto now = rig.bench.snapshot();
  Context context{rig.bench, *now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
  rig.panels->dropped(context, (folder / "models" / "plate.obj").string());
  std::vector<float> heights;
  const auto see = [&] {
    rig.frame();
    const float height = ImGui::FindWindowByName("Asked")->Size.y;
    if (heights.empty() || heights.back() != height) heights.push_back(height);
  };
  // Dim until walls are known.
  const std::initializer_list<const char*> toggle = {"Voxels that keep every wall", "switch"};
  ImVec2 keep{NAN, NAN};
  const auto known = [&] {
    for (int i = 0; i < 50; ++i) see();
    keep = rig.find("Asked", toggle);
    return rig.isAt(keep, "Asked", toggle) && !GImGui->HoveredIdDisabled;
  };
  rig.until(known, "the walls");
  for (int i = 0; i < 5; ++i) see();
  EXPECT_EQ(std::ranges::count_if(heights, [&](float each) { return each > 0.5f * heights.back(); }), 1)
      << "low while the file is read, then as it stays";
  rig.click(keep);
  press("Asked", "Import");
  rig.until([&] { return pieces() == 1; }, "imported");
  const engine::Piece& piece = rig.bench.snapshot()->document->pieces[0];
  const auto box = engine::boundsOf(piece);
  EXPECT_NEAR(piece.version.grid().voxelMm / (box.high - box.low).maxCoeff(), 0.15 / 100, 0.0001);
}

// Files that are dropped together are asked about one after the other; what is cancelled is left out alone.
TEST_F(Dialogs, FilesThatAreDroppedTogetherAreAllAskedAbout) {
  for (const char* name : {"one.obj", "two.obj", "three.obj"})
    std::ofstream(folder / "models" / name)
        << "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const auto now = rig.bench.snapshot();
  Context context{rig.bench, *now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
  for (const char* name : {"one.obj", "two.obj", "three.obj"})
    rig.panels->dropped(context, (folder / "models" / name).string());
  asked();
  press("Asked", "Import");
  rig.until([&] { return pieces() == 1; }, "the first");
  asked();
  press("Asked", "Cancel");
  rig.frames(3);
  asked();
  press("Asked", "Import");
  rig.until([&] { return pieces() == 2; }, "the third");
  rig.frames(3);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr) << "nobody is asked a fourth time";
  EXPECT_EQ(rig.bench.snapshot()->document->pieces[1].name, "three");
}

TEST_F(Dialogs, AModelThatCannotBeReadIsToldWhereItIsAskedFor) {
  std::ofstream(folder / "models" / "bad.stl") << "solid nothing\nendsolid\n";
  const auto now = rig.bench.snapshot();
  Context context{rig.bench, *now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
  rig.panels->dropped(context, (folder / "models" / "bad.stl").string());
  rig.frames(60);
  rig.key(ImGuiKey_Enter);
  rig.frames(60);
  EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr) << "accepted";
  press("Asked", "Cancel");
  rig.frames(3);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  EXPECT_EQ(pieces(), 0u);
}

TEST_F(Dialogs, ADroppedMeshAsksForItsUnits) {
  const auto now = rig.bench.snapshot();
  Context context{rig.bench, *now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
  rig.panels->dropped(context, (folder / "models" / "tetra.obj").string());
  asked();
  rig.click(rig.find("Asked", {"As a part: seen and felt, not clay", "switch"}));
  press("Asked", "Import");
  rig.until([&] { return rig.bench.snapshot()->document->parts.size() == 1; }, "imported");
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
}

TEST_F(Dialogs, ExportProposesTheDocumentsOwnName) {
  rig.run("clay.block");
  rig.until([&] { return pieces() == 1; }, "a block");
  rig.run("file.export");
  // What the field holds, as a person copies it.
  const auto name = [&] {
    rig.click(rig.find("Export", {"##name"}));
    return std::string(GImGui->InputTextState.TextA.Data);
  };
  EXPECT_EQ(name(), "Block");
  rig.state.shown.exporting = false;
  rig.frames(3);
  for (const char* file : {"three", "a b", "four"}) {
    rig.bench.saveAs(folder / (std::string(file) + ".argil"), {});
    rig.until([&] { return rig.bench.snapshot()->file.path.stem() == file; }, "saved");
    rig.frames(2);
    rig.run("file.export");
    EXPECT_EQ(name(), file);
    rig.state.shown.exporting = false;
    rig.frames(3);
  }
  rig.run("file.export");
  rig.click(rig.find("Export", {"##name"}));
  ImGui::GetIO().KeyCtrl = true;
  rig.key(ImGuiKey_A);
  ImGui::GetIO().KeyCtrl = false;
  rig.type("mine");
  rig.frames(2);
  rig.state.shown.exporting = false;
  rig.frames(3);
  rig.run("file.export");
  EXPECT_EQ(name(), "mine") << "what was typed stays";
}

TEST_F(Dialogs, ExportWritesWhatIsChosenAndAsksBeforeItWritesOver) {
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return pieces() == 1; }, "a block");
  rig.run("file.export.stl");
  fillIn("Export", "##folder", folder.string());
  fillIn("Export", "##name", "cube");
  press("Export", "PLY");
  press("Export", "Export");
  rig.until(
      [&] { return fs::exists(folder / "cube.stl") && fs::exists(folder / "cube.ply") && rig.bench.jobs().empty(); },
      "two files");
  EXPECT_FALSE(fs::exists(folder / "cube.obj"));
  EXPECT_FALSE(rig.state.shown.exporting);

  const auto before = fs::last_write_time(folder / "cube.stl");
  rig.run("file.export.stl");
  press("Export", "Export");
  EXPECT_TRUE(rig.state.shown.exporting) << "wrote over a file without asking";
  EXPECT_EQ(fs::last_write_time(folder / "cube.stl"), before);
  rig.frames(2);
  press("Export", "Write over");
  rig.until([&] { return fs::last_write_time(folder / "cube.stl") > before; }, "written over");
  EXPECT_FALSE(rig.state.shown.exporting);
}

TEST_F(Dialogs, QuadsComeWithTheirPicturesAndNoneIsWrittenOverUnasked) {
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return pieces() == 1; }, "a block");
  rig.run("file.export.stl");
  fillIn("Export", "##folder", folder.string());
  fillIn("Export", "##name", "cube");
  press("Export", "Quads");  // what it is for: GLB
  press("Export", "glTF binary");
  press("Export", "OBJ");
  std::ofstream(folder / "cube_normal.png") << "somebody's own";
  press("Export", "Export");
  EXPECT_TRUE(rig.state.shown.exporting) << "wrote over a picture without asking";
  EXPECT_EQ(fs::file_size(folder / "cube_normal.png"), 14u);
  rig.frames(2);
  press("Export", "Write over");
  rig.until([&] { return fs::exists(folder / "cube.obj") && rig.bench.jobs().empty(); }, "quads");
  EXPECT_GT(fs::file_size(folder / "cube_normal.png"), 100u);
  EXPECT_TRUE(fs::exists(folder / "cube.mtl"));
  EXPECT_FALSE(fs::exists(folder / "cube.glb"));
}

TEST_F(Dialogs, SolidsForCadComeWithinAnError) {
  rig.bench.addSphere(8, {.voxelMm = 1});
  rig.until([&] { return pieces() == 1; }, "a ball");
  const auto faces = [&] {
    std::ifstream in(folder / "ball.step");
    size_t count = 0;
    for (std::string line; std::getline(in, line);) count += line.find("=ADVANCED_FACE(") != std::string::npos;
    return count;
  };
  const auto choose = [&](const char* segmented, int which) {
    ImGuiWindow* dialog = ImGui::FindWindowByName("Export");
    const ImVec2 at = rig.findId(
        dialog, ImHashStr("segment", 0, ImHashData(&which, sizeof which, ImHashStr(segmented, 0, dialog->ID))));
    if (!std::isnan(at.x)) rig.click(at);
    return !std::isnan(at.x);
  };
  rig.run("file.export.stl");
  fillIn("Export", "##folder", folder.string());
  fillIn("Export", "##name", "ball");
  EXPECT_FALSE(choose("smooth", 1)) << "offered for triangles";
  press("Export", "STEP");
  EXPECT_TRUE(choose("reduce", 0));
  press("Export", "STL");  // off again
  rig.frames(2);
  EXPECT_FALSE(choose("reduce", 0)) << "there are no triangles";
  ASSERT_TRUE(choose("smooth", 1));
  press("Export", "Export");
  rig.until([&] { return fs::exists(folder / "ball.step") && rig.bench.jobs().empty(); }, "within an error");
  EXPECT_LT(faces(), 200u) << "500 to a count";
}

TEST_F(Dialogs, AFolderIsChosenWithinTheExport) {
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until([&] { return pieces() == 1; }, "a block");
  rig.run("file.export.stl");
  const ImVec2 at = rig.find("Export", {"folders"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.frames(3);
  fillIn("Files", "##folder", folder.string());
  rig.key(ImGuiKey_Enter);
  press("Files", "Choose");
  rig.frames(3);
  ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr) << "the export is gone";
  EXPECT_STREQ(ImGui::GetTopMostPopupModal()->Name, "Export");
  press("Export", "Export");
  rig.until([&] { return fs::exists(folder / "Block.stl"); }, "written there");
}

TEST_F(Dialogs, AKeyIsChangedAndATakenOneRefused) {
  rig.run("panel.shortcuts");
  rig.click(rig.find("Shortcuts", {"##filter"}));
  rig.type("opposite");
  ImGuiWindow* rows = list("Shortcuts");
  ASSERT_NE(rows, nullptr);
  const auto change = [&](const char* shown, const char* to) {
    const ImVec2 at = rig.findFrom(rows, {"tool.opposite", shown, "button"});
    ASSERT_FALSE(std::isnan(at.x)) << shown;
    rig.click(at);
    rig.frames(2);
    rig.type(to);
    rig.key(ImGuiKey_Enter);
    rig.frames(2);
  };
  change("I", "Alt+O");
  EXPECT_EQ(rig.state.keys["tool.opposite"], "Alt+O");
  change("Alt+O", "Ctrl+Z");
  EXPECT_EQ(rig.state.keys["tool.opposite"], "Alt+O");
  const ImVec2 reset = rig.findFrom(rows, {"tool.opposite", "reset"});
  ASSERT_FALSE(std::isnan(reset.x));
  rig.click(reset);
  EXPECT_TRUE(rig.state.keys.empty());
}

TEST_F(Dialogs, TheStopButtonStopsForces) {
  rig.bench.useDevice("simulated:touch");
  rig.bench.addBlock(Vec3d(10, 10, 10), 1, {.voxelMm = 1});
  rig.until(
      [&] {
        return !rig.bench.usesPointer() && pieces() == 1 &&
               rig.bench.touch(false).state == haptics::ServoState::running;
      },
      "a device that runs");
  rig.frames(2);
  ImVec2 at = rig.find("Bar", {"Stop forces", "button"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.frames(2);
  EXPECT_TRUE(std::isnan(rig.find("Bar", {"Stop forces", "button"}).x)) << "still offers to stop";
  at = rig.find("Bar", {"Resume forces", "button"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return !std::isnan(rig.find("Bar", {"Stop forces", "button"}).x); }, "running again");
}

TEST_F(Dialogs, ALongJobShowsItsProgressAndIsCancelled) {
  rig.bench.addSphere(60, {.voxelMm = 0.1});
  rig.until([&] { return !rig.bench.jobs().empty() && rig.bench.jobs()[0].seconds > 0.35; }, "a job of 0.3 s");
  const int id = int(rig.bench.jobs()[0].id);
  rig.frames(2);
  ImGuiWindow* notices = ImGui::FindWindowByName("Notices");
  ASSERT_NE(notices, nullptr);
  EXPECT_TRUE(rig.panels->moves());
  const ImVec2 at =
      rig.findId(notices, ImHashStr("button", 0, ImHashStr("Cancel", 0, ImHashData(&id, sizeof id, notices->ID))));
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return rig.bench.jobs().empty(); }, "cancelled");
  EXPECT_EQ(pieces(), 0u);
}

TEST_F(Dialogs, TheThemeTurnsTheBackgroundToo) {
  rig.run("window.theme");
  EXPECT_EQ(rig.state.theme, Theme::light);
  EXPECT_TRUE(rig.state.look.lightBackground);
  rig.run("window.theme");
  EXPECT_EQ(rig.state.theme, Theme::dark);
  EXPECT_FALSE(rig.state.look.lightBackground);
}

TEST_F(Dialogs, NewClayIsAdded) {
  rig.run("clay.add");
  press("New clay", "Add");
  rig.until([&] { return pieces() == 1; }, "clay");
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  EXPECT_EQ(rig.bench.snapshot()->document->pieces[0].version.stats().precision, clay::Precision::float32);
  rig.run("clay.add");
  rig.click(rig.find("New clay", {kHalfMemory, "switch"}));
  press("New clay", "Add");
  rig.until([&] { return pieces() == 2; }, "clay of 16 bits");
  EXPECT_EQ(rig.bench.snapshot()->document->pieces[1].version.stats().precision, clay::Precision::fixed16);
}

class Operations : public testing::Test {
 protected:
  Operations() {
    rig.bench.addBlock(Vec3d(12, 12, 8), 1, {.voxelMm = 1});
    rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "a block");
    rig.bench.addSphere(5, {.voxelMm = 1, .centreMm = Vec3d(6, 0, 0)});
    rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 2 && rig.bench.idle(); }, "a ball");
    rig.frames(2);
  }
  void press(const char* button) {
    const ImVec2 at = rig.find("Operation", {button, "button"});
    ASSERT_FALSE(std::isnan(at.x)) << button;
    rig.click(at);
  }
  const engine::Document& document() { return *(rig.now = rig.bench.snapshot())->document; }
  PanelsRig rig;
};

TEST_F(Operations, TwoPiecesAreJoinedByTheDialogInOneStep) {
  const size_t steps = rig.bench.snapshot()->done;
  const engine::Id ball = document().pieces[1].id;
  rig.state.selected = ball;
  rig.run("piece.join");
  ASSERT_NE(ImGui::GetTopMostPopupModal(), nullptr);
  press("Join");
  rig.until([&] { return document().pieces.size() == 1 && rig.bench.idle(); }, "joined");
  EXPECT_EQ(document().pieces[0].id, ball) << "the selected piece stays";
  EXPECT_EQ(rig.bench.snapshot()->done, steps + 1);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  rig.run("edit.undo");
  rig.until([&] { return document().pieces.size() == 2; }, "undone");
}

TEST_F(Operations, EveryOneOpensOrRunsAndIsCancelled) {
  for (const engine::PieceJob& job : engine::pieceJobs()) {
    const std::string id = "piece." + std::string(job.id);
    if (!findAction(id) || !findAction(id)->name.ends_with("…")) continue;
    SCOPED_TRACE(id);
    const size_t steps = rig.bench.snapshot()->done;
    rig.run(id.c_str());
    if (job.takesCurve) {  // Drawn over the picture.
      EXPECT_TRUE(rig.state.drawnCurve);
      rig.state.drawnCurve.reset();
      continue;
    }
    if (placesPlane(job)) {
      EXPECT_TRUE(rig.state.planeCut);
      rig.state.planeCut.reset();
      continue;
    }
    EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr);
    EXPECT_GT(ImGui::GetDrawData()->TotalVtxCount, 100);
    press("Cancel");
    rig.frames(3);
    EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
    rig.until([&] { return rig.bench.idle(); }, "idle");  // Its threads may still be at what the set-up began.
    EXPECT_EQ(rig.bench.snapshot()->done, steps);
  }
}

TEST_F(Operations, AnOffsetIsShownWhileItIsAskedForAndUntilItIsThere) {
  const engine::Id ball = document().pieces[1].id;
  rig.state.selected = ball;
  rig.run("piece.offset");
  ASSERT_TRUE(rig.state.grown);
  EXPECT_EQ(rig.state.grown->piece, ball);
  EXPECT_EQ(rig.state.grown->mm, 1) << "what the dialog says";
  EXPECT_FALSE(rig.state.growing);
  press("Cancel");
  rig.frames(2);
  EXPECT_FALSE(rig.state.grown);

  rig.run("piece.offset");
  const clay::Version before = document().piece(ball)->version;
  press("Offset");
  ASSERT_TRUE(rig.state.growing);
  EXPECT_EQ(rig.state.growing->before, before);
  rig.until([&] { return document().piece(ball)->version != before && rig.bench.idle(); }, "offset");
  rig.frames(2);
  EXPECT_TRUE(rig.state.grown) << "until its surface comes, which the window takes";
  rig.state.growing.reset();
  rig.frames(2);
  EXPECT_FALSE(rig.state.grown);

  // What is cancelled leaves nothing that is shown.
  rig.run("piece.offset");
  press("Offset");
  for (const engine::JobView& job : rig.bench.jobs()) rig.bench.cancelJob(job.id);
  rig.until([&] { return rig.bench.idle(); }, "cancelled");
  rig.frames(2);
  EXPECT_EQ(rig.state.grown, rig.state.growing);
  if (document().piece(ball)->version == rig.state.growing.value_or(GrownPiece{}).before)
    FAIL() << "nothing is at work";

  // A shell grows by its outer wall, which is none at first; what has no such meaning is not shown.
  rig.state.growing.reset();
  rig.run("piece.shell");
  EXPECT_FALSE(rig.state.grown);
  press("Cancel");
  rig.run("piece.smooth-all");
  EXPECT_FALSE(rig.state.grown);
  press("Cancel");
}

// The plane is placed in the picture: nothing covers the clay, and the settings have its numbers.
class PlacedPlanes : public Operations {
 protected:
  void press(const char* button) {
    const ImVec2 at = rig.find("Settings", {button, "button"});
    ASSERT_FALSE(std::isnan(at.x)) << button;
    rig.click(at);
  }
  bool follow() {
    rig.now = rig.bench.snapshot();
    Context c{rig.bench, *rig.now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, 1280, 720, 1};
    return followPlaneCut(c);
  }
  ImVec2 segment(int number) {
    ImGuiWindow* window = ImGui::FindWindowByName("Settings");
    return rig.findId(window,
                      ImHashStr("segment", 0, ImHashData(&number, sizeof number, ImHashStr("keep", 0, window->ID))));
  }
};

TEST_F(PlacedPlanes, ACutGoesThroughTheMiddleOfThePiece) {
  rig.state.shown.firstStart = false;
  rig.state.selected = document().pieces[0].id;
  const uint64_t before = document().pieces[0].version.hash();
  rig.run("piece.cut-plane");
  ASSERT_TRUE(rig.state.planeCut);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  EXPECT_EQ(rig.state.planeCut->kept(), 1);
  rig.run("draw.side");
  EXPECT_EQ(rig.state.planeCut->kept(), -1) << "Tab: the other side";
  const ImVec2 both = segment(1);
  ASSERT_FALSE(std::isnan(both.x)) << "what stays";
  rig.click(both);
  EXPECT_EQ(rig.state.planeCut->kept(), 0);
  EXPECT_FALSE(follow()) << "nothing was asked for";
  press("Apply");
  EXPECT_TRUE(follow());
  EXPECT_FALSE(rig.state.planeCut);
  rig.until([&] { return document().pieces.size() == 3 && rig.bench.idle(); }, "cut");
  EXPECT_NE(document().pieces[0].version.hash(), before);
  const auto a = document().pieces[0].version.stats().bricks, b = document().pieces[2].version.stats().bricks;
  EXPECT_NEAR(double(a), double(b), 0.3 * double(a)) << "two halves";
}

TEST_F(PlacedPlanes, TheSideThatStaysIsTheOneThatIsShown) {
  rig.state.shown.firstStart = false;
  const engine::Id id = document().pieces[0].id;
  for (const bool mirror : {false, true}) {
    for (const int side : {1, -1}) {
      SCOPED_TRACE(side);
      rig.state.selected = id;
      rig.run(mirror ? "piece.mirror" : "piece.cut-plane");
      ASSERT_TRUE(rig.state.planeCut);
      rig.state.planeCut->arguments.plane.normal = Vec3d::UnitX();
      rig.state.planeCut->setOffset(2);
      EXPECT_NEAR(rig.state.planeCut->offsetMm(), 2, 1e-12);
      if (side < 0) rig.run("draw.side");
      rig.until([&] { return rig.bench.idle(); }, "idle");
      rig.state.planeCut->apply = true;
      const size_t done = rig.bench.snapshot()->done;
      EXPECT_TRUE(follow());
      rig.until([&] { return rig.bench.idle() && rig.bench.snapshot()->done == done + 1; }, "done");
      const clay::BoxMm box = engine::boundsOf(*document().piece(id));
      // A block from −6 to 6, cut at 2: 4 long or 8; mirrored there, twice that.
      const double length = (side > 0 ? 4 : 8) * (mirror ? 2 : 1);
      EXPECT_NEAR(box.high.x() - box.low.x(), length, 0.6);
      if (!mirror) {
        EXPECT_NEAR(side > 0 ? box.low.x() : box.high.x(), 2, 0.4);
      }
      rig.run("edit.undo");
      rig.until([&] { return rig.bench.snapshot()->done == done; }, "undone");
    }
  }
}

TEST_F(PlacedPlanes, BeginAlongTheSelectedGuideOrAcrossTheLongestSide) {
  rig.state.shown.firstStart = false;
  const engine::Id block = document().pieces[0].id;
  rig.edit("A plane", [](engine::Document& d) {
    engine::Guide guide;
    guide.kind = engine::Guide::Kind::plane;
    guide.pose.translation = Vec3d(0, 0, 1);
    d.add(guide);
    d.active = d.pieces[0].id;
  });
  rig.state.selected = document().guides[0].id;
  rig.run("piece.cut-plane");
  ASSERT_TRUE(rig.state.planeCut);
  EXPECT_EQ(rig.state.planeCut->arguments.pieces, std::vector<engine::Id>{block}) << "the piece that is worked on";
  EXPECT_EQ(rig.state.planeCut->arguments.plane.pointMm, Vec3d(0, 0, 1));
  EXPECT_NEAR(rig.state.planeCut->arguments.plane.normal.z(), 1, 1e-12);
  rig.frames(2);
  press("Cancel");
  EXPECT_TRUE(follow());
  rig.state.selected = block;
  rig.run("piece.cut-plane");
  ASSERT_TRUE(rig.state.planeCut);
  EXPECT_NEAR(rig.state.planeCut->arguments.plane.normal.x(), 1, 1e-12) << "12 × 12 × 8 mm";
  // Another tool is taken: the hand wants to work.
  rig.run("tool.smooth");
  EXPECT_TRUE(follow());
  EXPECT_FALSE(rig.state.planeCut);
  // What is locked is told.
  rig.edit("Lock", [](engine::Document& d) { d.pieces[0].locked = true; });
  rig.run("piece.mirror");
  EXPECT_FALSE(rig.state.planeCut);
}

// Whose voxels the result gets is said and can be chosen, where the pieces differ.
TEST_F(Operations, ACombinationOffersTheVoxelsOfEitherPiece) {
  rig.bench.addSphere(5, {.voxelMm = 0.5, .centreMm = Vec3d(0, 6, 0)});
  rig.until([&] { return document().pieces.size() == 3 && rig.bench.idle(); }, "a finer ball");
  rig.frames(3);
  const engine::Id block = document().pieces[0].id, fine = document().pieces[2].id;
  const std::array<double, 2> sizes{1, 0.5};
  for (size_t wanted = 0; wanted < 2; ++wanted) {
    rig.state.selected = block;
    rig.state.alsoSelected = {block, {fine}};
    rig.run("piece.join");
    const ImVec2 list = rig.find("Operation", {"Voxels of", "##choice"});
    ASSERT_FALSE(std::isnan(list.x));
    rig.click(list);
    rig.frames(2);
    for (int i = 0; i < 4; ++i) rig.key(ImGuiKey_UpArrow);
    for (size_t i = 0; i < wanted; ++i) rig.key(ImGuiKey_DownArrow);
    rig.key(ImGuiKey_Enter);
    rig.frames(2);
    press("Join");
    rig.until([&] { return rig.bench.idle() && document().pieces.size() == 2; }, "joined");
    EXPECT_DOUBLE_EQ(document().piece(block)->version.grid().voxelMm, sizes[wanted]);
    rig.run("edit.undo");
    rig.until([&] { return document().pieces.size() == 3; }, "undone");
  }
  // Two of one size: there is nothing to choose.
  rig.state.selected = block;
  rig.state.alsoSelected = {block, {document().pieces[1].id}};
  rig.run("piece.join");
  EXPECT_TRUE(std::isnan(rig.find("Operation", {"Voxels of", "##choice"}).x));
}

TEST_F(Operations, AToolsFileIsAskedForAndKept) {
  const std::string path = testing::TempDir() + "/argil_tool_" + std::to_string(::getpid()) + ".png";
  std::ofstream(path) << "x";
  rig.state.toolId = "emboss";
  rig.frames(2);
  const ImVec2 at = rig.find("Settings", {"Choose…", "button"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.frames(3);
  rig.click(rig.find("Files", {"##name"}));
  rig.type(path);
  rig.key(ImGuiKey_Enter);
  rig.frames(3);
  EXPECT_EQ(rig.state.tool().file, path);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace argil::studio
