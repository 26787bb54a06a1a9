// Materials of a piece: added, named, coloured and made harder by the panel, laid by the tool, undone.

#include <cmath>
#include <optional>

#include "clay/store/editor.h"
#include "panels_rig.h"

namespace argil::studio {
namespace {

class Materials : public testing::Test {
 protected:
  Materials() {
    rig.bench.addBlock(Vec3d(12, 12, 8), 1, {.voxelMm = 1});
    rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1 && rig.bench.idle(); }, "a block");
    rig.state.shown.firstStart = false;
    rig.frames(2);
    rig.state.selected = 0;  // A new piece is selected; here the tool in hand shows its materials.
    rig.frames(2);
  }
  const engine::Piece& piece() { return (rig.now = rig.bench.snapshot())->document->pieces[0]; }
  size_t steps() { return rig.bench.snapshot()->done; }
  // Within the list: in the inspector of the selected piece, or of the tool in hand.
  ImVec2 within(std::optional<int> number, std::initializer_list<const char*> path) {
    ImGuiWindow* window = ImGui::FindWindowByName("Settings");
    const int selected = int(rig.state.selected);
    ImGuiID id = selected ? ImHashData(&selected, sizeof selected, window->ID) : window->ID;
    id = ImHashStr("materials", 0, id);
    if (number) id = ImHashData(&*number, sizeof *number, id);
    for (const char* part : path) id = ImHashStr(part, 0, id);
    return rig.findId(window, id);
  }
  ImVec2 line(int number) { return within(number, {"material"}); }
  ImVec2 inRow(int number, std::initializer_list<const char*> path) { return within(number, path); }
  void add() {
    const size_t before = steps();
    const ImVec2 at = within({}, {"Add a material", "button"});
    ASSERT_FALSE(std::isnan(at.x));
    rig.click(at);
    rig.until([&] { return steps() == before + 1 && rig.bench.idle(); }, "added");
    rig.frames(3);
  }
  PanelsRig rig{1280, 1400};
};

TEST_F(Materials, AreAddedChosenForTheToolNamedAndTakenAway) {
  rig.state.toolId = "material";
  rig.frames(2);
  EXPECT_TRUE(std::isnan(rig.find("Settings", {"material", "bar"}).x));
  add();
  add();
  ASSERT_EQ(piece().materials.size(), 2u);
  EXPECT_NE(piece().materials[0].colour, piece().materials[1].colour);
  EXPECT_EQ(rig.state.tool().material, 2) << "what was added is in hand";
  rig.click(line(1));
  EXPECT_EQ(rig.state.tool().material, 1);
  rig.frames(2);
  rig.click(inRow(1, {"##name"}));
  rig.type("Bone");
  rig.key(ImGuiKey_Enter);
  rig.until([&] { return piece().materials[0].name == "Bone"; }, "named");
  EXPECT_TRUE(std::isnan(inRow(1, {"Remove", "button"}).x)) << "the number of the second would be another one";
  rig.click(line(2));
  rig.frames(2);
  rig.click(inRow(2, {"Remove", "button"}));
  rig.until([&] { return piece().materials.size() == 1; }, "removed");
  rig.run("edit.undo");
  rig.until([&] { return piece().materials.size() == 2; }, "undone");
}

TEST_F(Materials, ADragOfANumberIsOneStepAndIsFeltByTheScene) {
  rig.state.selected = piece().id;
  rig.frames(2);
  add();
  const size_t before = steps();
  const double stiffness = piece().materials[0].material.stiffnessNmm;
  EXPECT_TRUE(std::isnan(inRow(1, {"stiffnessNmm", "bar"}).x)) << "no force device: folded away";
  rig.click(inRow(1, {"Feel", "fold"}));
  rig.frames(2);
  const ImVec2 at = inRow(1, {"stiffnessNmm", "bar"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.drag(at, {at.x + 60, at.y});
  rig.until([&] { return rig.bench.idle() && piece().materials[0].material.stiffnessNmm > stiffness; }, "harder");
  EXPECT_EQ(steps(), before + 1);
  EXPECT_DOUBLE_EQ(piece().material.stiffnessNmm, stiffness) << "the piece itself stays";
  engine::Document document = *rig.bench.snapshot()->document;
  EXPECT_FALSE(engine::sceneOf(document, haptics::Scene()).pieces[0].rows) << "no voxel is of it yet";
  clay::Editor editor(document.pieces[0].version);
  std::array<uint8_t, clay::kBrickVoxels> values;
  values.fill(1);
  document.pieces[0].version.forEachBrick(
      [&](const clay::Brick& brick) { editor.setChannel(clay::Channel::material, brick.coord, values); });
  document.pieces[0].version = editor.commit();
  const haptics::Scene scene = engine::sceneOf(document, haptics::Scene());
  ASSERT_TRUE(scene.pieces[0].rows);
  EXPECT_DOUBLE_EQ(scene.materials[(*scene.pieces[0].rows)[1]].stiffnessNmm,
                   piece().materials[0].material.stiffnessNmm);
  rig.run("edit.undo");
  rig.until([&] { return piece().materials[0].material.stiffnessNmm == stiffness; }, "undone");
}

TEST_F(Materials, ByNameFromTheKeyboard) {
  rig.run("clay.materialAdd");
  rig.until([&] { return piece().materials.size() == 1; }, "added");
  rig.state.selected = 0;
  rig.run("clay.materials");
  EXPECT_EQ(rig.state.selected, piece().id);
  rig.frames(2);
  EXPECT_FALSE(std::isnan(line(1).x));
}

}  // namespace
}  // namespace argil::studio
