// Plugins in the window, by real mouse and keys: enabled on their page, worked with, and one that crashes in
// mid-stroke.

#include "tests/e2e/hand/clay_on_screen.h"
#include "tests/support/plugins/plugin_folders.h"

namespace argil::tests {
namespace {

class PluginsInHand : public ClayOnScreen {
 protected:
  void SetUp() override {
    ClayOnScreen::SetUp();
    fs::create_directories(folder());
    setenv("ARGIL_PLUGIN_PATH", folder().c_str(), 1);
  }
  void TearDown() override { unsetenv("ARGIL_PLUGIN_PATH"); }
  [[nodiscard]] fs::path folder() const { return scratch_ / "plugins"; }
  void bring(const std::string& example) {
    fs::copy(examplePlugin(example), folder() / (example + ".argil-plugin"), fs::copy_options::recursive);
  }
  [[nodiscard]] std::string settings() const { return slurp(scratch_ / "argil" / "plugins.json"); }
  // The page with one plugin on it; its button.
  void enable(Person& person, const std::string& id) {
    byPalette(person, "plugins");
    (void)person.settled();
    (void)person.shot("plugins-page-" + id);
    for (int i = 0; i < 100 && settings().find(id) == std::string::npos; ++i) {
      person.click(middleX() + 560.0 / 2 - 66, middleY() - 560.0 / 2 + 86);
      (void)person.settled();
    }
    EXPECT_NE(settings().find(id), std::string::npos);
    (void)person.shot("plugins-enabled-" + id);
    person.key("escape");
    (void)person.settled();
  }
  Way across() {
    return {{middleX() - 80, middleY() - 10}, {middleX() - 20, middleY()}, {middleX() + 60, middleY() + 8}};
  }
};

TEST_P(PluginsInHand, OneIsEnabledAndWorkedWith) {
  bring("clay-strips");
  const std::string file = block();
  const Saved before = saved();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  enable(person, "org.argil.clay-strips");
  byPalette(person, "clay strips");
  (void)person.shot("plugins-tool");
  person.drag(across());
  const Saved after = otherClay(person, before);
  EXPECT_GT(after.volume, before.volume);
  (void)person.shot("plugins-stroke");
  EXPECT_EQ(after.steps, 1);
}

TEST_P(PluginsInHand, OneThatCrashesInMidStrokeCostsTheStampAndWorkGoesOn) {
  (void)badPlugin(folder(), "kill");
  const std::string file = block();
  const Saved before = saved();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  enable(person, "test.bad.kill");
  byPalette(person, "brush test");
  person.drag(across());
  const Saved left = otherClay(person, before);
  (void)person.shot("plugins-crash");
  EXPECT_TRUE(studio.running());
  byPalette(person, "carve");
  person.drag(across());
  const Saved carved = otherClay(person, left);
  EXPECT_LT(carved.volume, left.volume);
  (void)person.shot("plugins-after-crash");
}

TEST_P(PluginsInHand, OneThatHangsHoldsUpNoPicture) {
  (void)badPlugin(folder(), "hang");
  const std::string file = block();
  // As often as it can.
  fs::create_directories(scratch_ / "argil");
  std::ofstream(scratch_ / "argil" / "studio.json")
      << R"({"quality":{"supersample":1,"key_shadow":false,"cavity":false,"detail":8,"frames_per_second":120}})";
  {
    RunningStudio studio(arguments(), scratch_.path());
    Person person(studio, at().scale);
    (void)person.settled();
    enable(person, "test.bad.hang");
    person.close();
    EXPECT_EQ(studio.wait(60), 0);
  }
  // Times from one picture in motion to the next, ms.
  const auto pictures = [&](const std::string& tool) {
    const std::string report = (scratch_ / (tool + ".json")).string();
    const Saved before = saved();
    RunningStudio studio(arguments({file, "--report", report}), scratch_.path());
    Person person(studio, at().scale);
    (void)person.settled();
    byPalette(person, tool);
    // A window whose picture the software driver draws in some milliseconds: what is left is what the plugin does.
    person.resize(640, 400);
    (void)person.settled();
    person.drag({{270, 190}, {300, 200}, {360, 205}}, 3);
    (void)otherClay(person, before);
    (void)person.shot("plugins-hang-" + tool);
    person.close();
    EXPECT_EQ(studio.wait(60), 0);
    Json times = Json::parse(slurp(report));
    // Of the window's thread itself, however slow the driver is: it hands pictures on and answers the hand.
    std::printf("%s: the window's thread took %.1f ms at most, %.1f of them at work\n", tool.c_str(),
                times["turn_ms"]["max"].get<double>(), times["turn_core_ms"]["max"].get<double>());
    return times["stroke_gap_ms"];
  };
  const Json hangs = pictures("brush test"), carves = pictures("carve");
  const double hanging = hangs["max"], carving = carves["max"];
  std::printf(
      "between pictures of a stroke, median and most: %.1f and %.1f ms beside a plugin that hangs, %.1f and %.1f ms "
      "carving\n",
      hangs["median"].get<double>(), hanging, carves["median"].get<double>(), carving);
  // It hangs for a quarter of a second of its process's own time: that long no picture would come if the window, or
  // what draws, waited for it.
  EXPECT_LT(hanging, std::max(200.0, 3 * carving));
}

INSTANTIATE_TEST_SUITE_P(All, PluginsInHand, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
