// What the studio keeps from one day to the next.

#include "ui3d/studio/files/settings.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>

#include "ui3d/studio/panels/settings_tables.h"

namespace argil::studio {
namespace {

namespace fs = std::filesystem;

// `--theme` is for one start: what was chosen before is what the next day has, unless it is chosen anew.
TEST(Settings, AThemeThatWasGivenForOneStartIsNotKept) {
  for (const Theme own : {Theme::dark, Theme::light}) {
    for (const Theme given : {Theme::dark, Theme::light}) {
      StudioState state;
      state.theme = own;
      state.look.lightBackground = own == Theme::light;
      state.keptTheme = {state.theme, state.look.lightBackground};
      state.theme = given;
      state.look.lightBackground = given == Theme::light;
      StudioState back;
      ASSERT_TRUE(applySettings(settingsText(state), back));
      EXPECT_EQ(back.theme, own);
      EXPECT_EQ(back.look.lightBackground, own == Theme::light);
      state.keptTheme.reset();  // By hand.
      ASSERT_TRUE(applySettings(settingsText(state), back));
      EXPECT_EQ(back.theme, given);
      EXPECT_EQ(back.look.lightBackground, given == Theme::light);
    }
  }
}

// A background of another brightness than the theme's stays.
TEST(Settings, ABackgroundOfItsOwnIsKept) {
  StudioState state, back;
  state.theme = Theme::dark;
  state.look.lightBackground = true;
  ASSERT_TRUE(applySettings(settingsText(state), back));
  EXPECT_TRUE(back.look.lightBackground);
  EXPECT_TRUE(applySettings(R"({"theme": "light"})", back));
  EXPECT_TRUE(back.look.lightBackground) << "a file of one line";
}

TEST(Settings, ComeBackAsTheyWere) {
  StudioState state;
  state.theme = Theme::light;
  state.interfaceScale = 1.5f;
  state.toolId = "smooth";
  state.tool().radiusMm = 7.5;
  state.tool().strength = 0.25f;
  state.tools["emboss"] = engine::standardTool(*engine::findTool("emboss"));
  state.tools["emboss"].file = "/a b/µ.png";
  state.tools["emboss"].inverted = true;
  state.shown.history = true;
  state.look.shading = render::Shading::matcap;
  state.look.grid = false;
  state.stereo.mode = render::StereoMode::anaglyph;
  state.quality.supersample = 3;
  state.keys["edit.undo"] = "Ctrl+U";
  state.recentFiles = {"/a b/µ.stl"};
  state.lastFolder = "/a b";
  state.imports = {true, 0.25};
  state.undoGiB = 0.5;
  state.surface = clay::Grade::fine;
  state.print = {3, 0.7, 0.25, 1.75, true, 2, 7.5, {180, 181, 182}};
  StudioState back;
  ASSERT_TRUE(applySettings(settingsText(state), back));
  EXPECT_EQ(back.theme, Theme::light);
  EXPECT_EQ(back.interfaceScale, 1.5f);
  EXPECT_EQ(back.toolId, "smooth");
  EXPECT_EQ(back.tool().radiusMm, 7.5);
  EXPECT_EQ(back.tool().strength, 0.25f);
  EXPECT_EQ(back.tools["emboss"].file, "/a b/µ.png");
  EXPECT_TRUE(back.tools["emboss"].inverted);
  EXPECT_TRUE(back.shown.history);
  EXPECT_EQ(back.look.shading, render::Shading::matcap);
  EXPECT_FALSE(back.look.grid);
  EXPECT_EQ(back.stereo.mode, render::StereoMode::anaglyph);
  EXPECT_EQ(back.quality, state.quality);
  EXPECT_EQ(back.keys, state.keys);
  EXPECT_EQ(back.recentFiles, state.recentFiles);
  EXPECT_EQ(back.lastFolder, state.lastFolder);
  EXPECT_EQ(back.imports, state.imports);
  EXPECT_EQ(back.undoBytes(), uint64_t{512} << 20);
  EXPECT_EQ(back.surface, clay::Grade::fine);
  EXPECT_EQ(back.print.process, 3);
  EXPECT_EQ(back.print.wallMm, 0.7);
  EXPECT_EQ(back.print.gapMm, 0.25);
  EXPECT_EQ(back.print.outletMm, 1.75);
  EXPECT_EQ(back.print.draftDegrees, 7.5);
  EXPECT_EQ(back.print.bedMm, Vec3d(180, 181, 182));
  EXPECT_FALSE(back.print.shown) << "clay begins as it is";
  EXPECT_EQ(back.print.pull, 0);
  EXPECT_EQ(settingsText(back), settingsText(state));
}

// Sets each row to something else, alone, and looks whether it comes back.
template <class Owner>
void expectKept(std::span<const Row<Owner>> rows, Owner& (*of)(StudioState&)) {
  for (const Row<Owner>& each : rows) {
    StudioState state, back;
    Owner &set = of(state), &got = of(back);
    std::visit(
        [&](const auto& row) {
          SCOPED_TRACE(row.id);
          using R = std::decay_t<decltype(row)>;
          if constexpr (std::is_same_v<R, Switch<Owner>>) {
            set.*row.on = !(got.*row.on);
            ASSERT_TRUE(applySettings(settingsText(state), back));
            EXPECT_EQ(got.*row.on, set.*row.on);
          } else if constexpr (std::is_same_v<R, Choice<Owner>>) {
            row.set(set, (row.get(got) + 1) % int(row.options.size()));
            const int wanted = row.get(set);
            ASSERT_TRUE(applySettings(settingsText(state), back));
            EXPECT_EQ(row.get(got), wanted);
          } else {
            row.set(set, row.get(got) == row.high ? row.low : row.high);
            const double wanted = row.get(set);
            ASSERT_NE(row.get(got), wanted);
            ASSERT_TRUE(applySettings(settingsText(state), back));
            EXPECT_EQ(row.get(got), wanted);
          }
        },
        each);
  }
}

TEST(Settings, EveryRowOfThePanelsIsKept) {
  expectKept<render::Look>(lookRows(), [](StudioState& s) -> render::Look& { return s.look; });
  expectKept<render::Stereo>(stereoRows(), [](StudioState& s) -> render::Stereo& { return s.stereo; });
  expectKept<render::Quality>(qualityRows(), [](StudioState& s) -> render::Quality& { return s.quality; });
  expectKept<StudioState>(pictureRows(), [](StudioState& s) -> StudioState& { return s; });
  for (const auto& row : touchQualityRows()) {
    SCOPED_TRACE(row.id);
    StudioState state, back;
    engine::Quality set, got;
    row.set(set, row.get(got) == row.high ? row.low : row.high);
    state.touchQuality = set.touch;
    ASSERT_TRUE(applySettings(settingsText(state), back));
    got.touch = back.touchQuality;
    EXPECT_EQ(row.get(got), row.get(set));
  }
  expectKept<haptics::Workspace>(workspaceRows(), [](StudioState& s) -> haptics::Workspace& { return s.workspace; });
  expectKept<haptics::PanWalls>(wallRows(), [](StudioState& s) -> haptics::PanWalls& { return s.workspace.walls; });
}

TEST(Settings, WhatIsWrongInThemLeavesTheStandard) {
  const std::string standard = settingsText(StudioState());
  for (
      const char* text :
      {"{}",
       R"({"theme": 3, "interface_scale": 99, "tool": "hammer", "tools": {"carve": 5, "hammer": {}}, "panels": [], "look": {"shading": 17,
                            "cavity_strength": "much"}, "stereo": {"mode": -1, "eyes": 4}, "quality": {"supersample": 100, "surface": 2}, "keys": {"a": 5}, "recent": [1, {}], "folder": 5,
                            "import": {"units": 9, "voxel": -1, "voxel_given": "yes"}})",
       R"({"tools": {"carve": {"radius": -5}}})"}) {
    StudioState state;
    EXPECT_TRUE(applySettings(text, state)) << text;
    state.tools.clear();
    EXPECT_EQ(settingsText(state), standard) << text;
    StudioState again;
    applySettings(text, again);
    EXPECT_EQ(again.tool(), StudioState().newTool(*engine::findTool("carve"))) << text;
  }
  StudioState state;
  EXPECT_FALSE(applySettings("[1, 2", state));
  EXPECT_FALSE(applySettings("", state));
  const std::string whole = settingsText(state);
  for (size_t length = 0; length < whole.size(); ++length) (void)applySettings(whole.substr(0, length), state);
  EXPECT_EQ(settingsText(state), standard);
}

TEST(Settings, OfTwoProgramsThatSaveAtOnceAreThoseOfOne) {
  const fs::path folder = fs::temp_directory_path() / "settings";  // The tests' own.
  const char* before = std::getenv("XDG_CONFIG_HOME");
  const std::string old = before ? before : "";
  setenv("XDG_CONFIG_HOME", folder.c_str(), 1);
  std::array<pid_t, 2> programs{};
  for (size_t i = 0; i < 2; ++i)
    if (programs[i] = fork(); programs[i] == 0) {
      StudioState state;  // One text is longer than the other: what is left of it would show.
      if (i) state.recentFiles.assign(20, std::string(2000, 'x'));
      bool kept = true;
      for (int round = 0; round < 200; ++round) kept &= saveSettings(state);
      _exit(kept ? 0 : 1);
    }
  int torn = 0, running = 2;
  while (running > 0) {
    for (const pid_t program : programs) {
      int status = 0;
      if (waitpid(program, &status, WNOHANG) != program) continue;
      EXPECT_EQ(status, 0);
      --running;
    }
    std::ifstream in(settingsFile());
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    StudioState state;
    torn += in.is_open() && !applySettings(text, state);
  }
  EXPECT_EQ(torn, 0);
  fs::remove(settingsFile());
  fs::create_directories(settingsFile() / "in the way");
  EXPECT_FALSE(saveSettings(StudioState{}));
  EXPECT_EQ(std::distance(fs::directory_iterator(settingsFile().parent_path()), {}), 1) << "something is left";
  old.empty() ? unsetenv("XDG_CONFIG_HOME") : setenv("XDG_CONFIG_HOME", old.c_str(), 1);
}

TEST(StudioState, RecentFilesAreEachOnceAndTheNewestFirst) {
  StudioState state;
  state.remember("/x/a.argil");
  state.remember("/y/b.stl");
  state.remember("/x/../x/a.argil");
  EXPECT_EQ(state.recentFiles, (std::vector<std::string>{"/x/a.argil", "/y/b.stl"}));
  EXPECT_EQ(state.lastFolder, "/x");
  state.remember("here.argil");
  EXPECT_EQ(state.recentFiles[0], (std::filesystem::current_path() / "here.argil").string());
  for (int i = 0; i < 40; ++i) state.remember("/z/" + std::to_string(i));
  EXPECT_EQ(state.recentFiles.size(), StudioState::kMostRecent);
  EXPECT_EQ(state.recentFiles[0], "/z/39");
}

TEST(StudioState, ToolsBeginSoftAndWithASizeThatSuitsTheModel) {
  StudioState state;
  EXPECT_EQ(engine::toolTable().front().id, "clay");
  EXPECT_TRUE(state.effectiveTool().soft);
  EXPECT_FALSE(state.effectiveTool(false).soft) << "the tip of a device rules the depth";
  EXPECT_GE(state.tool().depth, 0.1);
  EXPECT_LE(state.tool().depth, 0.25);
  EXPECT_FALSE(engine::scriptTool(*engine::findTool("carve")).soft) << "scripts cut as they always did";
  for (const double model : {1.0, 60.0, 96.0, 180.0, 250.0, 2000.0}) {
    StudioState fresh;
    fresh.sizeTools(model);
    for (const char* id : {"clay", "carve", "smooth", "inflate"}) {
      fresh.toolId = id;
      const double part = fresh.tool().radiusMm / (model / 2);
      EXPECT_GE(part, 0.1) << id << " on a model of " << model << " mm";
      EXPECT_LE(part, 0.2) << id;
    }
  }
  // One click makes the hard cut of it.
  for (const bool soft : {true, false}) {
    state.tool().soft = soft;
    std::set<std::string_view> shown;
    for (const auto& parameter : engine::ownParameters(*engine::findTool("carve")))
      if (counts(parameter, state.tool(), true)) shown.insert(parameter.id);
    EXPECT_TRUE(shown.count("soft"));
    EXPECT_EQ(shown.count("depth"), soft ? 1u : 0u);
    EXPECT_EQ(shown.count("tip"), soft ? 0u : 1u);
  }
}

TEST(StudioState, KeysThatAreHeldTurnTheToolOverAtItsSize) {
  StudioState state;
  state.tool().radiusMm = 9;
  EXPECT_EQ(state.effectiveTool().id, "carve");
  state.inverted = true;
  EXPECT_EQ(state.effectiveTool().id, "clay") << "a soft cut turned over is as soft";
  EXPECT_EQ(state.effectiveTool().radiusMm, 9);
  EXPECT_EQ(state.effectiveTool(false).id, "add") << "a device cuts hard";
  state.tool().soft = false;
  EXPECT_EQ(state.effectiveTool().id, "add");
  EXPECT_EQ(state.effectiveTool().radiusMm, 9);
  state.smoothing = true;
  EXPECT_EQ(state.effectiveTool().id, "smooth");
  state.inverted = state.smoothing = false;
  state.toolId = "nothing of this name";
  EXPECT_EQ(state.tool().id, "carve");
}

}  // namespace
}  // namespace argil::studio
