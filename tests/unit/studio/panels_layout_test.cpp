// Nothing overlaps, nothing leaves the window, everything can be read.

#include <array>
#include <cmath>

#include "panels_rig.h"
#include "ui3d/studio/panels/layout.h"
#include "ui3d/studio/panels/panel_table.h"
#include "ui3d/studio/panels/theme.h"

namespace argil::studio {
namespace {

struct Screen {
  float width, height, scale;
};

void expectApart(const Screen& screen, const std::string& what) {
  std::vector<ImGuiWindow*> roots;
  for (ImGuiWindow* window : GImGui->Windows) {
    if (window->WasActive && !window->ParentWindow && !(window->Flags & (ImGuiWindowFlags_Popup | ImGuiWindowFlags_Tooltip)) && std::string(window->Name).find("##Default") == std::string::npos &&
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
  for (const Screen& screen : {Screen{1280, 720, 1}, Screen{1280, 720, 2}, Screen{1920, 1080, 1}, Screen{1024, 640, 1}}) {
    PanelsRig rig(screen.width, screen.height, screen.scale);
    for (const bool full : {false, true}) {
      if (full) fill(rig);
      if (full) rig.state.selected = rig.bench.snapshot()->document->guides[0].id;
      rig.state.toolId = "smooth";
      rig.bench.tell(engine::Message::Level::warning, "A sentence that is long enough to be broken into two lines where it stands, over the picture.");
      for (const PanelRow& row : panelTable()) {
        if (row.dock == Dock::middle) continue;
        const PanelsShown before = rig.state.shown;
        showPanel(rig.state.shown, row, !(rig.state.shown.*row.shown));
        rig.frames(3);
        const std::string what = std::string(row.id) + (full ? " full" : " empty") + " at " + std::to_string(int(screen.width));
        expectApart(screen, what);
        expectFits(what);
        rig.state.shown = before;
      }
      rig.timeS += 60;
    }
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
    const Layout l = layOut(1280, 720, shown, groups);
    double area = 0;
    for (const kit::Rect& r : {l.menu, l.bar, l.tools, l.settings, l.upper, l.lower, l.rail, l.status, l.free}) area += double(r.width()) * double(r.height());
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
  EXPECT_NEAR(contrast(IM_COL32(118, 118, 118, 255), IM_COL32(255, 255, 255, 255)), 4.54, 0.01);  // The known grey that just passes.
  for (const Theme theme : {Theme::dark, Theme::light}) {
    for (const TextPair& pair : textPairs(theme)) {
      EXPECT_GE(contrast(pair.text, pair.ground), 4.5) << (theme == Theme::dark ? "dark, " : "light, ") << pair.name << " " << std::hex << pair.text << " on " << pair.ground;
    }
  }
}

}  // namespace
}  // namespace argil::studio
