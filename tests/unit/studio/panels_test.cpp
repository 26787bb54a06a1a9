// Panels are drawn, clicked, dragged and typed into, without a window.

#include "ui3d/studio/panels/panels.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <map>

#include "panels_rig.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

using engine::Document;

TEST(Panels, EveryPanelDrawsForAnEmptyAndAFullDocument) {
  PanelsRig rig;
  for (const bool full : {false, true}) {
    if (full) fill(rig);
    std::vector<engine::Id> ids{0};
    const engine::DocumentPtr now = rig.bench.snapshot()->document;
    for (const auto& t : now->pieces) ids.push_back(t.id);
    for (const auto& t : now->parts) ids.push_back(t.id);
    for (const auto& t : now->guides) ids.push_back(t.id);
    for (const engine::Id id : ids) {
      rig.state.selected = id;
      rig.frames(2);
    }
    for (const PanelRow& row : panelTable()) {
      const bool before = rig.state.shown.*row.shown;
      showPanel(rig.state.shown, row, true);
      rig.frames(3);
      EXPECT_GT(ImGui::GetDrawData()->TotalVtxCount, 100) << row.id;
      showPanel(rig.state.shown, row, false);
      rig.frames(3);
      if (before) showPanel(rig.state.shown, row, true);
    }
    for (const char* wish : {"open", "import", "part", "clay", "export", "export.obj"}) {
      rig.state.wishes.dialog = wish;
      rig.frames(3);
      EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr) << wish;
      rig.key(ImGuiKey_Escape);
      rig.frames(3);
      EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr) << wish;
    }
  }
}

TEST(Panels, AClickOnAToolTakesIt) {
  PanelsRig rig;
  const ImGuiWindow* window = ImGui::FindWindowByName("Tools");
  std::map<ImGuiID, ImVec2> places;  // One sweep over the panel for all of them.
  for (float y = window->Pos.y + 5; y < window->Pos.y + window->Size.y; y += 11) {
    for (float x = window->Pos.x + 8; x < window->Pos.x + window->Size.x; x += 13) {
      rig.moveTo(x, y);
      if (GImGui->HoveredId) places.emplace(GImGui->HoveredId, ImVec2(x, y));
    }
  }
  for (const engine::ToolRow& tool : engine::toolTable()) {
    const std::string id = "tool." + std::string(tool.id);
    const auto at = places.find(ImHashStr(id.c_str(), 0, window->ID));
    ASSERT_NE(at, places.end()) << id << ": a row of the table has no button";
    rig.click(at->second);
    EXPECT_EQ(rig.state.toolId, tool.id);
  }
}

TEST(Panels, EveryParameterOfAToolHasASlider) {
  PanelsRig rig;
  for (const engine::ToolRow& tool : engine::toolTable()) {
    rig.state.toolId = tool.id;
    rig.frame();
    for (const auto& parameter : engine::ownParameters(tool)) {
      const std::string id(parameter.id);
      // rows of another kind; materials are chosen by name
      if (!parameter.choices.empty() || parameter.unit == "on" || parameter.unit == "colour" ||
          (id == "material" && tool.id != "invisible"))
        continue;
      if (parameter.get(rig.state.tool()) >= parameter.high) parameter.change(rig.state.tool(), parameter.low);
      rig.state.tool().soft = id == "depth";  // The rows of the tip are those of a hard cut.
      const ImVec2 at = rig.find("Settings", {id.c_str(), "bar"});
      ASSERT_FALSE(std::isnan(at.x)) << tool.id << " " << id;
      const double before = parameter.get(rig.state.tool());
      rig.drag(at, {at.x + 60, at.y});
      EXPECT_GT(parameter.get(rig.state.tool()), before) << tool.id << " " << id;
      EXPECT_LE(parameter.get(rig.state.tool()), parameter.high);
    }
  }
}

TEST(Panels, ANumberIsTypedAfterADoubleClick) {
  PanelsRig rig;
  const ImVec2 at = rig.find("Settings", {"radius", "bar"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.doubleClick(at);
  rig.type("7,25 mm");
  rig.key(ImGuiKey_Enter);
  EXPECT_DOUBLE_EQ(rig.state.tool().radiusMm, 7.25);
  rig.doubleClick(at);
  rig.type("8");
  rig.key(ImGuiKey_Tab);
  EXPECT_DOUBLE_EQ(rig.state.tool().radiusMm, 8);
  rig.doubleClick(at);
  rig.type("1e9");
  rig.key(ImGuiKey_Enter);
  EXPECT_DOUBLE_EQ(rig.state.tool().radiusMm, 1000);  // The most that the table allows.
  rig.doubleClick(at);
  rig.type("clay");
  rig.key(ImGuiKey_Enter);
  EXPECT_DOUBLE_EQ(rig.state.tool().radiusMm, 1000);
}

TEST(Panels, ThePaletteRunsWhatWasTyped) {
  PanelsRig rig;
  rig.run("panel.palette");
  ASSERT_TRUE(rig.state.shown.palette);
  rig.type("smoo");
  rig.key(ImGuiKey_Enter);
  rig.frames(2);
  EXPECT_EQ(rig.state.toolId, "smooth");
  EXPECT_FALSE(rig.state.shown.palette);
  EXPECT_EQ(ImGui::GetTopMostPopupModal(), nullptr);

  rig.run("panel.palette");
  rig.type("view");
  const auto found = searchActions("view");
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_UpArrow);
  rig.key(ImGuiKey_Enter);
  EXPECT_FALSE(rig.state.shown.palette);
  ASSERT_GT(found.size(), 2u);

  rig.run("panel.palette");
  rig.type("smoo");
  rig.key(ImGuiKey_Escape);
  rig.frames(2);
  EXPECT_FALSE(rig.state.shown.palette);
}

// What nothing is called is not done by Enter: the nearest names are offered, to be chosen.
TEST(Panels, ThePaletteOffersTheNearestWhereNothingIsFound) {
  PanelsRig rig;
  rig.state.toolId = "carve";
  rig.run("panel.palette");
  rig.type("smotth");
  ASSERT_TRUE(searchActions("smotth").empty());
  rig.key(ImGuiKey_Enter);
  rig.frames(2);
  EXPECT_TRUE(rig.state.shown.palette);
  EXPECT_EQ(rig.state.toolId, "carve");
  ASSERT_EQ(nearestActions("smotth").front()->id, "tool.smooth");
  rig.key(ImGuiKey_DownArrow);
  rig.key(ImGuiKey_Enter);
  rig.frames(2);
  EXPECT_FALSE(rig.state.shown.palette);
  EXPECT_EQ(rig.state.toolId, "smooth");
}

TEST(Panels, SymmetryIsASwitchAndNoStep) {
  PanelsRig rig;
  rig.edit("Something", [](engine::Document& d) { d.add(engine::Guide()); });
  rig.run("edit.undo");
  rig.until([&] { return rig.bench.snapshot()->done == 0; }, "undone");
  const ImVec2 at = rig.find("Settings", {"Y", "button"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return rig.bench.snapshot()->document->symmetry.y; }, "symmetry");
  EXPECT_EQ(rig.bench.snapshot()->done, 0u);
  rig.run("edit.redo");
  rig.until([&] { return rig.bench.snapshot()->done == 1; }, "redone: the switch left it");
  EXPECT_TRUE(rig.bench.snapshot()->document->symmetry.y);
}

class ThingsList : public testing::Test {
 protected:
  ThingsList() {
    fill(rig);
    list = PanelsRig::child("Upper", "things") ? PanelsRig::child("Upper", "things")->Name : "";
  }
  // Of the row of a thing.
  ImVec2 find(engine::Id id, const char* item) {
    ImGuiWindow* window = nullptr;
    for (ImGuiWindow* each : GImGui->Windows) {
      if (each->ParentWindow && list == each->ParentWindow->Name && each->WasActive) window = each;
    }
    if (!window) return {NAN, NAN};
    const int number = int(id);
    return rig.findId(window, ImHashStr(item, 0, ImHashData(&number, sizeof number, window->ID)));
  }
  const Document& document() { return *(rig.now = rig.bench.snapshot())->document; }

  PanelsRig rig;
  std::string list;
};

TEST_F(ThingsList, SelectsRenamesHidesLocks) {
  const engine::Id id = document().guides[0].id;
  ImVec2 at = find(id, "row");
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  EXPECT_EQ(rig.state.selected, id);

  rig.doubleClick(at);
  rig.type("Waterline");
  rig.key(ImGuiKey_Enter);
  rig.until([&] { return document().guide(id)->name == "Waterline"; }, "renamed");
  EXPECT_EQ(rig.bench.snapshot()->history->back().substr(0, 6), "Rename");

  at = find(id, "eye");
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return !document().guide(id)->visible; }, "hidden");
  at = find(id, "lock");
  rig.click(at);
  rig.until([&] { return document().guide(id)->locked; }, "locked");
}

TEST_F(ThingsList, DeletesAndReordersTheSelected) {
  const engine::Id first = document().guides[0].id, second = document().guides[1].id;
  rig.state.selected = second;
  rig.run("edit.moveUp");
  rig.until([&] { return document().guides[0].id == second; }, "moved up");
  const ImVec2 trash = rig.findFrom(PanelsRig::child("Upper", "things"), {"edit.delete"});
  ASSERT_FALSE(std::isnan(trash.x));
  rig.click(trash);
  rig.until([&] { return document().guide(second) == nullptr; }, "deleted");
  EXPECT_EQ(rig.state.selected, 0u);
  EXPECT_EQ(document().guides[0].id, first);
}

TEST_F(ThingsList, ReordersByDragging) {
  const engine::Id first = document().guides[0].id, third = document().guides[2].id;
  const ImVec2 from = find(first, "row"), to = find(third, "row");
  ASSERT_FALSE(std::isnan(from.x) || std::isnan(to.x));
  rig.drag(from, to);
  rig.until([&] { return document().guides[2].id == first; }, "dragged to the third place");
  EXPECT_EQ(document().guides[1].id, third);
  // Not among things of another kind.
  const size_t steps = rig.bench.snapshot()->done;
  rig.drag(find(third, "row"), find(document().pieces[0].id, "row"));
  rig.frames(20);
  EXPECT_EQ(rig.bench.snapshot()->done, steps);
}

TEST_F(ThingsList, AClickOnAPieceWorksOnIt) {
  for (const size_t i : {0, 1, 0}) {
    const engine::Id id = document().pieces[i].id;
    rig.click(find(id, "row"));
    rig.until([&] { return document().active == id; }, "active");
  }
}

TEST_F(ThingsList, ADraggedSliderIsOneStep) {
  rig.state.toolId = "smooth";  // few rows above the guide's
  rig.state.selected = document().guides[0].id;
  rig.frames(2);
  const int number = int(rig.state.selected);
  ImGuiWindow* window = ImGui::FindWindowByName("Settings");
  ImGui::SetScrollY(window, window->ScrollMax.y);  // The guide's rows are the last ones.
  rig.frames(2);
  const ImGuiID id = ImHashStr("bar", 0, ImHashStr("rangeMm", 0, ImHashData(&number, sizeof number, window->ID)));
  const ImVec2 at = rig.findId(window, id);
  ASSERT_FALSE(std::isnan(at.x));
  const size_t steps = rig.bench.snapshot()->done;
  const double before = document().guides[0].rangeMm;
  for (int drags = 1; drags <= 2; ++drags) {
    rig.drag(at, {at.x + 40, at.y}, 20);
    rig.until([&] { return rig.bench.idle(); }, "all that was sent is in the document");
    rig.frames(10);
    EXPECT_EQ(rig.bench.snapshot()->done, steps + size_t(drags));
  }
  EXPECT_GT(document().guides[0].rangeMm, before * 1.5);
}

TEST_F(ThingsList, TwoSlidersDraggedWhileTheEditThreadIsBusyAreBothChanged) {
  rig.state.toolId = "smooth";  // few rows above the guide's
  const engine::Id id = document().guides[0].id;
  rig.edit("A well", [id](Document& d) { d.guide(id)->feel = engine::Guide::Feel::well; });
  rig.state.selected = id;
  rig.frames(2);
  const int number = int(id);
  ImGuiWindow* window = ImGui::FindWindowByName("Settings");
  ImGui::SetScrollY(window, window->ScrollMax.y);
  rig.frames(2);
  const auto bar = [&](const char* row) {
    return rig.findId(window, ImHashStr("bar", 0, ImHashStr(row, 0, ImHashData(&number, sizeof number, window->ID))));
  };
  const ImVec2 range = bar("rangeMm"), force = bar("forceN");
  ASSERT_FALSE(std::isnan(range.x) || std::isnan(force.x));
  const engine::Guide before = *document().guide(id);
  std::promise<void> held;
  rig.bench.edit("Busy", [until = held.get_future().share()](Document&) { until.wait(); });
  rig.drag(range, {range.x + 40, range.y});
  rig.drag(force, {force.x + 40, force.y});
  held.set_value();
  rig.until([&] { return rig.bench.idle(); }, "all that was sent is in the document");
  EXPECT_GT(document().guide(id)->rangeMm, before.rangeMm);
  EXPECT_GT(document().guide(id)->forceN, before.forceN);
}

TEST_F(ThingsList, HistoryGoesToAnyStep) {
  rig.edit("Something", [](engine::Document& d) { d.pieces.front().colour[0] = 0.25f; });
  const size_t steps = rig.bench.snapshot()->done;
  rig.run("panel.history");
  ImGuiWindow* steppes = nullptr;
  for (ImGuiWindow* each : GImGui->Windows) {
    if (each->WasActive && std::string(each->Name).find("/steps_") != std::string::npos) steppes = each;
  }
  ASSERT_NE(steppes, nullptr);
  const int wanted = 1;
  const ImVec2 at = rig.findId(steppes, ImHashStr("step", 0, ImHashData(&wanted, sizeof wanted, steppes->ID)));
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return rig.bench.snapshot()->done == 1; }, "back to the first step");
  EXPECT_EQ(document().pieces.size(), 1u);
  EXPECT_EQ(rig.bench.snapshot()->history->size(), steps);
  rig.run("edit.redo");
  rig.until([&] { return rig.bench.snapshot()->done == 2; }, "a step forward");
}

TEST(Panels, TheFirstPageMakesABlock) {
  PanelsRig rig;
  ASSERT_TRUE(rig.state.shown.firstStart);
  const ImVec2 at = rig.find("First start", {"clay.block", "tile"});
  ASSERT_FALSE(std::isnan(at.x));
  rig.click(at);
  rig.until([&] { return rig.bench.snapshot()->document->pieces.size() == 1; }, "a block");
  EXPECT_FALSE(rig.state.shown.firstStart);
}

TEST(Panels, MessagesAreSeenAndKept) {
  PanelsRig rig;
  rig.state.shown.firstStart = false;
  rig.bench.tell(engine::Message::Level::error, "The disk is full: make room and export again.");
  rig.frames(3);
  ImGuiWindow* notices = ImGui::FindWindowByName("Notices");
  ASSERT_NE(notices, nullptr);
  EXPECT_TRUE(notices->WasActive);
  rig.timeS += 60;
  rig.frames(3);
  EXPECT_FALSE(notices->WasActive);
}

TEST(Panels, NumbersAreWrittenShort) {
  EXPECT_EQ(kit::written(0), "0");
  EXPECT_EQ(kit::written(0.05), "0.05");
  EXPECT_EQ(kit::written(12.5), "12.5");
  EXPECT_EQ(kit::written(200), "200");
  EXPECT_EQ(kit::written(0.002), "0.002");
  EXPECT_EQ(kit::written(0.0001), "0.0001");
  EXPECT_EQ(kit::written(-0.0000001), "-0.0000001") << "no exponent";
  EXPECT_EQ(kit::written(0.0000321), "0.0000321");
  EXPECT_EQ(kit::written(1.06e3), "1060");
  EXPECT_EQ(kit::written(1.234567e7), "12345670");
  EXPECT_EQ(kit::written(1e-20), "0");
  EXPECT_EQ(kit::written(NAN), "–");
  EXPECT_EQ(kit::counted(1234567), "1\u202f234\u202f567");
  EXPECT_EQ(kit::counted(999), "999");
  EXPECT_EQ(kit::bytes(1234567), "1.23 MB");
  EXPECT_DOUBLE_EQ(kit::readNumber(" 12,5 mm"), 12.5);
  EXPECT_TRUE(std::isnan(kit::readNumber("mm")));
}

TEST(Panels, HardCutIsOneClickAway) {
  PanelsRig rig;
  rig.state.shown.firstStart = false;
  rig.frames(3);
  ASSERT_TRUE(rig.state.tool().soft);
  EXPECT_FALSE(std::isnan(rig.find("Settings", {"depth", "bar"}).x));
  EXPECT_TRUE(std::isnan(rig.find("Settings", {"least_wall", "bar"}).x)) << "nothing that has no effect";
  rig.click(rig.find("Settings", {"Soft", "switch"}));
  EXPECT_FALSE(rig.state.tool().soft);
  rig.frames(3);
  EXPECT_FALSE(std::isnan(rig.find("Settings", {"least_wall", "bar"}).x));
}

TEST(Panels, IconsOfTablesAreThere) {
  for (const PanelRow& row : panelTable()) EXPECT_TRUE(hasIcon(row.icon)) << row.id;
  for (const engine::ToolRow& row : engine::toolTable())
    EXPECT_TRUE(hasIcon(row.icon)) << row.id << ": shown by its letters until an icon is drawn";
}

}  // namespace
}  // namespace argil::studio
