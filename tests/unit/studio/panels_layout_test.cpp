// Nothing overlaps, nothing leaves the window, everything can be read.

#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "panels_rig.h"
#include "ui3d/studio/kit/layout.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/view/panel_table.h"

namespace argil::studio {
namespace {

struct Screen {
  float width, height, scale;
};

void expectApart(const Screen& screen, const std::string& what) {
  std::vector<ImGuiWindow*> roots;
  for (ImGuiWindow* window : GImGui->Windows) {
    if (window->WasActive && !window->ParentWindow &&
        !(window->Flags & (ImGuiWindowFlags_Popup | ImGuiWindowFlags_Tooltip)) &&
        std::string(window->Name).find("##Default") == std::string::npos &&
        std::string(window->Name).find("Debug") == std::string::npos) {
      roots.push_back(window);
    }
  }
  ASSERT_GE(roots.size(), 4u) << what;
  for (size_t i = 0; i < roots.size(); ++i) {
    const ImRect a = roots[i]->Rect();
    EXPECT_GE(a.Min.x, 0) << what << ": " << roots[i]->Name;
    EXPECT_GE(a.Min.y, 0) << what << ": " << roots[i]->Name;
    EXPECT_LE(a.Max.x, screen.width + 0.01f) << what << ": " << roots[i]->Name;
    EXPECT_LE(a.Max.y, screen.height + 0.01f) << what << ": " << roots[i]->Name;
    for (size_t j = i + 1; j < roots.size(); ++j) {
      ImRect b = roots[j]->Rect();
      b.Expand(-0.01f);
      EXPECT_FALSE(a.Overlaps(b)) << what << ": " << roots[i]->Name << " and " << roots[j]->Name;
    }
  }
}

// What a window draws into is as wide as it is: nothing is cut off at its right edge.
void expectFits(const std::string& what) {
  for (ImGuiWindow* window : GImGui->Windows) {
    if (!window->WasActive || (window->Flags & ImGuiWindowFlags_Tooltip)) continue;
    const std::string name = window->Name;
    if (name.find("##Default") != std::string::npos) continue;
    const float room = window->InnerRect.GetWidth() - 2 * window->WindowPadding.x;
    EXPECT_LE(window->ContentSize.x, room + 1) << what << ": " << name << " is too narrow for what is in it";
  }
}

TEST(PanelsLayout, NothingOverlapsOrLeavesTheWindow) {
  // The second is 2560 × 1440 pixels at scale 2.
  for (const Screen& screen :
       {Screen{1280, 720, 1}, Screen{1280, 720, 2}, Screen{1920, 1080, 1}, Screen{1024, 640, 1}}) {
    PanelsRig rig(screen.width, screen.height, screen.scale);
    for (const bool full : {false, true}) {
      if (full) fill(rig);
      if (full) rig.state.selected = rig.bench.snapshot()->document->guides[0].id;
      rig.state.toolId = "smooth";
      rig.bench.tell(engine::Message::Level::warning,
                     "A sentence that is long enough to be broken into two lines where it stands, over the picture.");
      for (const PanelRow& row : panelTable()) {
        if (row.dock == Dock::middle) continue;
        const PanelsShown before = rig.state.shown;
        showPanel(rig.state.shown, row, !(rig.state.shown.*row.shown));
        rig.frames(3);
        const std::string what =
            std::string(row.id) + (full ? " full" : " empty") + " at " + std::to_string(int(screen.width));
        expectApart(screen, what);
        expectFits(what);
        rig.state.shown = before;
      }
      rig.timeS += 60;
    }
  }
}

struct Asked {
  int width, height;
  float scale;
};

// All that are asked for, and their size in interface units.
std::vector<std::pair<Asked, Screen>> windows() {
  std::vector<std::pair<Asked, Screen>> all;
  for (const auto& [width, height] : {std::pair{800, 600}, {1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}}) {
    for (const float scale : {1.0f, 1.5f, 2.0f, 3.0f}) {
      const float fits = scaleThatFits(scale, width, height);
      all.push_back({{width, height, scale}, {float(width) / fits, float(height) / fits, fits}});
    }
  }
  return all;
}

std::string named(const Asked& w) {
  return std::to_string(w.width) + "x" + std::to_string(w.height) + " at scale " + kit::written(double(w.scale));
}

TEST(PanelsLayout, TheClayHasItsPartOfEveryWindow) {
  for (const auto& [window, screen] : windows()) {
    EXPECT_GE(screen.width, kLeastWindowWidth - 0.01f) << named(window);
    EXPECT_GE(screen.height, kLeastWindowHeight - 0.01f) << named(window);
    for (int mask = 0; mask < 16; ++mask) {
      PanelsShown shown;
      shown.tools = mask & 1;
      shown.settings = mask & 2;
      shown.things = mask & 4;
      shown.view = mask & 8;
      const Layout l = layOut(screen.width, screen.height, shown, toolGroups());
      const double part =
          double(l.free.width()) * double(l.free.height()) / (double(screen.width) * double(screen.height));
      EXPECT_GE(part, kClayPart - 1e-6) << named(window) << ", panels " << mask;
      double area = 0;
      for (const kit::Rect& r : {l.menu, l.bar, l.tools, l.settings, l.upper, l.lower, l.rail, l.status, l.free})
        area += r.empty() ? 0 : double(r.width()) * double(r.height());
      EXPECT_NEAR(area, double(screen.width) * double(screen.height), 1) << named(window) << ", panels " << mask;
      // What is shown and does not stand there opens over the clay, and leaves some of it.
      for (const PanelRow& row : panelTable()) {
        if (!l.folded(row.dock)) continue;
        const Layout over = layOut(screen.width, screen.height, shown, toolGroups(), row.id);
        const kit::Rect& at = row.dock == Dock::tools      ? over.tools
                              : row.dock == Dock::settings ? over.settings
                              : row.dock == Dock::upper    ? over.upper
                                                           : over.lower;
        EXPECT_FALSE(at.empty()) << named(window) << ": " << row.id;
        EXPECT_GE(at.left, l.free.left) << named(window) << ": " << row.id;
        EXPECT_LE(at.right, l.free.right) << named(window) << ": " << row.id;
        EXPECT_EQ(over.free.width(), l.free.width()) << named(window) << ": " << row.id;
        EXPECT_GE(over.clear.width(), 0.3f * screen.width) << named(window) << ": " << row.id;
      }
    }
    const Layout l = layOut(screen.width, screen.height, PanelsShown(), toolGroups());
    EXPECT_GE(l.railEdge, 20) << named(window);
    for (const float stop : {0.0f, 140.0f}) {
      const int folded = int(l.toolsFolded) + int(l.settingsFolded);
      EXPECT_LE(barWidth(barGroups(screen.width, folded, stop), folded, stop), screen.width) << named(window);
    }
  }
  EXPECT_FALSE(layOut(1920, 1080, PanelsShown(), toolGroups()).sideFolded);
  const Layout laptop = layOut(1280, 720, PanelsShown(), toolGroups());
  EXPECT_TRUE(laptop.sideFolded);
  EXPECT_FALSE(laptop.settingsFolded);
  EXPECT_GT(layOut(1280, 720, PanelsShown(), toolGroups(), {}, kLeastClayPart).upper.width(), 0)
      << "by choice panels stay";
}

TEST(PanelsLayout, NothingIsCutOffOrOverlapsInAnyWindow) {
  std::set<std::pair<int, int>> seen;
  for (const auto& [window, screen] : windows()) {
    // Units decide; the largest have room for what the smaller ones have.
    if (screen.width > 1930 || !seen.insert({int(screen.width), int(screen.height)}).second) continue;
    PanelsRig rig(screen.width, screen.height, screen.scale);
    rig.state.foldPanels = true;
    rig.bench.tell(engine::Message::Level::warning,
                   "A sentence that is long enough to be broken into two lines where it stands, over the picture.");
    for (const bool full : {false, true}) {
      if (full) fill(rig);
      rig.state.shown.firstStart = !full;
      rig.frames(3);
      expectApart(screen, named(window));
      expectFits(named(window));
      rig.state.shown.firstStart = false;
      for (const PanelRow& row : panelTable()) {
        if (row.dock == Dock::middle) continue;
        const PanelsShown before = rig.state.shown;
        rig.run(("panel." + std::string(row.id)).c_str());
        const std::string what = named(window) + ", " + std::string(row.id) + (full ? " full" : " empty");
        expectApart(screen, what);
        expectFits(what);
        rig.state.shown = before;
        rig.state.over.clear();
        rig.timeS += 60;
      }
    }
    // Dialogs are lower than the window, or scroll.
    for (const char* dialog : {"open", "saveAs", "import", "picture", "recover", "clay", "export", "recent",
                               "piece.join", "piece.cut-pegs", "palette", "shortcuts", "preferences"}) {
      const PanelRow* panel = findPanel(dialog);
      if (panel)
        rig.state.shown.*panel->shown = true;
      else
        rig.state.wishes.dialog = dialog;
      rig.frames(4);
      ASSERT_FALSE(GImGui->OpenPopupStack.empty()) << dialog;
      const ImRect at = GImGui->OpenPopupStack.back().Window->Rect();
      const std::string what = named(window) + ", " + dialog;
      EXPECT_GE(at.Min.x, 0) << what;
      EXPECT_GE(at.Min.y, 0) << what;
      EXPECT_LE(at.Max.x, screen.width) << what;
      EXPECT_LE(at.Max.y, screen.height) << what;
      expectFits(what);
      rig.key(ImGuiKey_Escape);
      rig.frames(3);
      EXPECT_TRUE(GImGui->OpenPopupStack.empty()) << what << " does not close by Escape";
    }
  }
}

TEST(PanelsLayout, TheFirstWindowIsLargeOnEveryScreen) {
  for (const auto& [width, height] : {std::pair{800, 600}, {1280, 720}, {1366, 768}, {1920, 1080}})
    EXPECT_TRUE(firstWindow(width, height, 1).maximised) << width;
  EXPECT_TRUE(firstWindow(2560, 1440, 2).maximised);
  EXPECT_TRUE(firstWindow(3840, 2160, 3).maximised);
  for (const auto& [width, height, scale] :
       {std::tuple{2560, 1440, 1.0f}, {3840, 2160, 1.0f}, {3840, 2160, 1.5f}, {5120, 2880, 2.0f}}) {
    const FirstWindow window = firstWindow(width, height, scale);
    EXPECT_FALSE(window.maximised) << width;
    EXPECT_LE(window.width, width);
    EXPECT_LE(window.height, height);
    EXPECT_GE(float(window.width) / scale, 1600) << width;
    EXPECT_GE(float(window.height) / scale, 900) << width;
  }
}

TEST(PanelsLayout, AScaleIsNoLargerThanTheWindowHolds) {
  EXPECT_EQ(scaleThatFits(2, 1280, 720), 2);
  EXPECT_EQ(scaleThatFits(3, 1280, 720), 2);
  EXPECT_EQ(scaleThatFits(1, 640, 400), 1);
  EXPECT_EQ(scaleThatFits(0.5f, 3840, 2160), 0.5f);
  EXPECT_EQ(scaleThatFits(2, 0, 0), 2) << "a window whose size is not known yet";
  EXPECT_GE(scaleThatFits(4, 100, 100), 0.5f);
}

TEST(PanelsLayout, AFoldedPanelOpensOverTheClayAndFoldsAgain) {
  PanelsRig rig(800, 600);
  rig.state.foldPanels = true;
  rig.state.shown.firstStart = false;
  rig.frames(2);
  const auto clay = rig.panels->free();
  ImGuiWindow* things = ImGui::FindWindowByName("Upper");
  EXPECT_TRUE(!things || !things->WasActive);
  const auto seen = [&] {
    things = ImGui::FindWindowByName("Upper");
    return things && things->WasActive;
  };
  rig.run("panel.things");
  EXPECT_TRUE(seen());
  EXPECT_EQ(rig.panels->free(), clay) << "the view does not jump";
  rig.key(ImGuiKey_Escape);
  rig.frames(2);
  EXPECT_FALSE(seen()) << "by Escape";
  rig.run("panel.things");
  rig.run("panel.history");
  EXPECT_EQ(rig.state.over, "history");
  rig.run("panel.history");
  EXPECT_FALSE(seen()) << "by its own key";
  rig.run("panel.things");
  rig.click({(clay[0] + clay[2]) / 2 - 100, (clay[1] + clay[3]) / 2});
  rig.frames(2);
  EXPECT_FALSE(seen()) << "by a click beside it";
  EXPECT_TRUE(rig.state.shown.things) << "in a larger window it stands where it stood";
}

// What is over the clay works as it does in its place: it is looked for what stands in the way of printing, and what is
// felt is drawn all the time.
TEST(PanelsLayout, WhatOpensOverTheClayIsAtWork) {
  for (const bool folded : {false, true}) {
    SCOPED_TRACE(folded);
    const float width = folded ? 1000 : 2200, height = folded ? 700 : 1400;
    PanelsRig rig(width, height);
    rig.state.foldPanels = folded;
    rig.state.shown.print = rig.state.shown.touch = rig.state.shown.firstStart = false;
    rig.edit("a ball", [](engine::Document& document) {
      engine::Piece piece;
      piece.version = clay::makeSphere(clay::Store::make(), clay::Grid{}, Vec3d::Zero(), 10);
      document.active = document.add(std::move(piece));
    });
    rig.until([&] { return !rig.panels->moves(); }, "at rest");
    const auto turn = [&](const char* id) {
      const Layout layout =
          layOut(width, height, rig.state.shown, toolGroups(), rig.state.over, folded ? kClayPart : kLeastClayPart);
      ASSERT_EQ(layout.folded(findPanel(id)->dock), folded);
      turnPanel(layout, rig.state, *findPanel(id));
      rig.frames(3);
    };
    turn("print");
    EXPECT_TRUE(rig.panels->moves()) << "something is to come";
    rig.until([&] { return !rig.panels->moves(); }, "looked at");
    turn("print");
    turn("touch");
    EXPECT_TRUE(rig.panels->moves());
    rig.frames(200);
    EXPECT_TRUE(rig.panels->moves());
    turn("touch");
    EXPECT_FALSE(rig.panels->moves());
  }
}

TEST(PanelsLayout, TheFreeMiddleIsWhatIsLeft) {
  for (int mask = 0; mask < 16; ++mask) {
    PanelsShown shown;
    shown.tools = mask & 1;
    shown.settings = mask & 2;
    shown.things = mask & 4;
    shown.view = mask & 8;
    const std::array groups{14};
    const Layout l = layOut(1280, 720, shown, groups, {}, kLeastClayPart);
    double area = 0;
    for (const kit::Rect& r : {l.menu, l.bar, l.tools, l.settings, l.upper, l.lower, l.rail, l.status, l.free})
      area += double(r.width()) * double(r.height());
    EXPECT_DOUBLE_EQ(area, 1280.0 * 720.0) << mask;
    EXPECT_GT(l.free.width(), 600) << mask;
    EXPECT_GT(l.free.height(), 580) << mask;
  }
}

TEST(PanelsLayout, MoreToolsMakeMoreColumns) {
  const PanelsShown shown;
  const std::vector<int> few{14}, more{20, 20, 5};
  EXPECT_EQ(layOut(1280, 720, shown, few).toolColumns, 2);
  EXPECT_TRUE(layOut(1280, 720, shown, few).toolHeadings);
  EXPECT_EQ(layOut(1280, 720, shown, more).toolColumns, 3);  // 7 + 7 + 2 rows; two columns would need 23.
  EXPECT_TRUE(layOut(1280, 720, shown, more).toolHeadings);
  EXPECT_EQ(layOut(1280, 690, shown, more).toolColumns, 3);
  EXPECT_FALSE(layOut(1280, 690, shown, more).toolHeadings);
}

TEST(PanelsLayout, TextIsLargeEnough) {
  for (const float scale : {1.0f, 1.5f, 2.0f, 3.0f}) {
    PanelsRig rig(1280, 720, scale);
    for (const ImFont* font : {fonts().body, fonts().strong, fonts().small, fonts().title}) {
      ASSERT_NE(font, nullptr);
      EXPECT_GE(font->FontSize, 13 * scale - 0.5f) << scale;
    }
    EXPECT_NEAR(ImGui::GetIO().FontGlobalScale * scale, 1, 1e-6);
    if (!fontFile(false).empty()) {
      for (const ImWchar letter : {u'µ', u'°', u'é', u'ß', u'→', u'↑', u'²', u'−', u'×', u'…', u'σ'}) {
        EXPECT_NE(fonts().body->FindGlyphNoFallback(letter), nullptr) << int(letter);
      }
    }
  }
}

TEST(PanelsTheme, ColoursContrast) {
  EXPECT_NEAR(contrast(IM_COL32(0, 0, 0, 255), IM_COL32(255, 255, 255, 255)), 21, 1e-9);
  // The known grey that just passes.
  EXPECT_NEAR(contrast(IM_COL32(118, 118, 118, 255), IM_COL32(255, 255, 255, 255)), 4.54, 0.01);
  for (const Theme theme : {Theme::dark, Theme::light}) {
    for (const TextPair& pair : textPairs(theme)) {
      EXPECT_GE(contrast(pair.text, pair.ground), 4.5) << (theme == Theme::dark ? "dark, " : "light, ") << pair.name
                                                       << " " << std::hex << pair.text << " on " << pair.ground;
    }
  }
}

}  // namespace
}  // namespace argil::studio
