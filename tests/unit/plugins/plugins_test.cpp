// Which plugins are there, which are enabled, and what is wrong with the others.

#include "engine/plugins/plugins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "clay/base/error.h"
#include "engine/plugins/check_plugin.h"
#include "engine/plugins/new_plugin.h"
#include "engine/plugins/start_mark.h"
#include "engine/text/script.h"
#include "tests/support/plugins/plugin_folders.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class PluginsTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    fs::create_directories(root_ / "a");
    fs::create_directories(root_ / "b");
  }
  void TearDown() override { fs::remove_all(root_); }
  [[nodiscard]] Plugins plugins() const { return Plugins({root_ / "a", root_ / "b"}, root_ / "settings.json"); }
  // A formula's plugin, `local.NAME`.
  fs::path formula(const std::string& name, const char* folder = "a") {
    const fs::path made = root_ / folder / (name + std::string(kPluginEnding));
    newPlugin("formula", made);
    return made;
  }
  static void change(const fs::path& file, const std::string& from, const std::string& to) {
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(file) << text;
  }
  const fs::path root_ = fs::temp_directory_path() / "plugins-test";
};

PluginState stateOf(const Plugins& plugins, size_t i = 0) {
  return plugins.found()[i].state;
}

TEST_F(PluginsTest, AreEnabledOnceAsTheyAre) {
  const fs::path made = formula("rings");
  Plugins first = plugins();
  ASSERT_EQ(first.found().size(), 1u);
  EXPECT_EQ(stateOf(first), PluginState::disabled);
  first.enable("local.rings");
  EXPECT_EQ(stateOf(first), PluginState::enabled);
  EXPECT_EQ(stateOf(plugins()), PluginState::enabled) << "it is kept";
  change(made / kPluginFile, "phi - height", "phi + height");
  EXPECT_EQ(stateOf(plugins()), PluginState::changed);
  plugins().enable("local.rings");
  EXPECT_EQ(stateOf(plugins()), PluginState::enabled);
  plugins().disable("local.rings");
  EXPECT_EQ(stateOf(plugins()), PluginState::disabled);
}

TEST_F(PluginsTest, ALibraryThatChangesIsNotUsed) {
  const fs::path made = tests::badPlugin(root_ / "a", "good");
  plugins().enable("test.bad.good");
  Plugins again = plugins();
  again.compareLibraries();
  EXPECT_EQ(stateOf(again), PluginState::enabled);
  std::ofstream(made / kPluginMachine / "bad.so", std::ios::app) << "more";
  again.compareLibraries();
  EXPECT_EQ(stateOf(again), PluginState::changed);
  // Nobody looks at libraries when the program starts: its first use does.
  Plugins fast = plugins();
  EXPECT_EQ(stateOf(fast), PluginState::enabled);
  fast.load();
  const ToolRow* row = findTool("test.bad.good.brush");
  ASSERT_NE(row, nullptr);
  try {
    (void)row->external->begin({});
    FAIL();
  } catch (const PluginError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is not as it was when it was enabled: argil plugins enable test.bad.good"));
  }
  fs::remove(made / kPluginMachine / "bad.so");
  again = plugins();
  again.compareLibraries();
  EXPECT_EQ(stateOf(again), PluginState::broken);
  EXPECT_THAT(again.found()[0].problem, HasSubstr("it is not built, or was made for another machine"));
}

TEST_F(PluginsTest, TheFirstFolderCounts) {
  formula("rings");
  formula("rings", "b");
  const Plugins found = plugins();
  ASSERT_EQ(found.found().size(), 2u);
  EXPECT_EQ(stateOf(found, 0), PluginState::disabled);
  EXPECT_EQ(stateOf(found, 1), PluginState::hidden);
}

TEST_F(PluginsTest, WhatIsWrongIsSaidInOneLineAndHarmsNoOther) {
  const std::vector<std::pair<std::string, const char*>> wrong{
      {"", "plugin.json"},
      {"[]", "must be an object {...}"},
      {R"({"format": 2})", "is of a newer Argil"},
      {R"({"format": 1, "id": "nodots", "name": "x"})", "give 40 small letters"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x", "brushes": []})",
       "1 to 100"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x", "what": 1, "brushes": []})",
       "what"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x", "library": "../x.so",
           "brushes": []})",
       "is no name of a file"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x",
           "brushes": [{"id": "c", "name": "n", "help": "h", "bricks": {"margin": 1, "leaves": "values"}}]})",
       "none is named: give \"library\""},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x", "library": "x.so",
           "brushes": [{"id": "c", "name": "n", "help": "h", "bricks": {"margin": 3, "leaves": "values"}}]})",
       "none of 0, 1, 2, 4"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x", "library": "x.so",
           "brushes": [{"id": "c", "name": "n", "help": "h", "bricks": {"margin": 1, "leaves": "nothing"}}]})",
       "leaves"},
      {R"({"format": 1, "id": "a.b", "name": "x", "version": "1", "licence": "x", "help": "x",
           "brushes": [{"id": "c", "name": "n", "help": "h", "formula": "phi +"}]})",
       "a value is missing at the end"},
  };
  formula("rings", "b");
  for (size_t i = 0; i < wrong.size(); ++i) {
    const fs::path made = root_ / "a" / (std::to_string(i) + std::string(kPluginEnding));
    fs::create_directories(made);
    std::ofstream(made / kPluginFile) << wrong[i].first;
  }
  fs::create_directories(root_ / "a" / ("empty" + std::string(kPluginEnding)));
  std::ofstream(root_ / "a" / ("file" + std::string(kPluginEnding))) << "no folder";
  const Plugins found = plugins();
  ASSERT_EQ(found.found().size(), wrong.size() + 3);
  std::map<std::string, std::string> problems;
  for (const FoundPlugin& each : found.found()) {
    problems[each.folder.stem()] = each.problem;
    EXPECT_EQ(each.problem.find('\n'), std::string::npos) << each.problem;
  }
  for (size_t i = 0; i < wrong.size(); ++i)
    EXPECT_THAT(problems[std::to_string(i)], HasSubstr(wrong[i].second)) << wrong[i].first;
  EXPECT_NE(problems["empty"], "");
  EXPECT_NE(problems["file"], "");
  EXPECT_NE(found.find("local.rings"), nullptr);
}

TEST_F(PluginsTest, SettingsThatCannotBeReadEnableNothingAndAreNotWrittenOver) {
  formula("rings");
  std::ofstream(root_ / "settings.json") << "{ broken";
  Plugins found = plugins();
  EXPECT_NE(found.problem(), "");
  EXPECT_EQ(stateOf(found), PluginState::disabled);
  EXPECT_THROW(found.enable("local.rings"), Error);
  std::ifstream in(root_ / "settings.json");
  EXPECT_EQ(std::string((std::istreambuf_iterator<char>(in)), {}), "{ broken");
}

TEST_F(PluginsTest, FiftyAreReadInAMomentAndStartNothing) {
  for (int i = 0; i < 25; ++i) formula("f" + std::to_string(i));
  for (int i = 0; i < 25; ++i) {
    const fs::path made = tests::badPlugin(root_ / "b", "good");
    const fs::path to = root_ / "b" / ("l" + std::to_string(i) + std::string(kPluginEnding));
    fs::rename(made, to);
    change(to / kPluginFile, "test.bad.good", "test.l" + std::to_string(i));
  }
  Plugins all = plugins();
  for (const FoundPlugin& each : all.found()) all.enable(each.plugin.id);
  double least = 1e9;
  for (int i = 0; i < 5; ++i) {
    const auto began = std::chrono::steady_clock::now();
    Plugins found = plugins();
    found.load();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    EXPECT_EQ(found.found().size(), 50u);
    for (const FoundPlugin& each : found.found()) EXPECT_EQ(each.state, PluginState::enabled) << each.problem;
  }
  std::printf("50 plugins are read in %.1f ms\n", least * 1e3);
  EXPECT_LT(least, 0.5) << "ten times what is meant, for a busy machine";
  const Plugins again = plugins();
  for (const FoundPlugin& each : again.found())
    for (const Plugin::Brush& brush : each.plugin.brushes) {
      const auto* external = dynamic_cast<const PluginBrush*>(findTool(brush.tool.id)->external);
      EXPECT_EQ(external ? external->processes().started() : 0u, 0u);
    }
}

// Of tools whose plugin is not enabled it is said so.
TEST_F(PluginsTest, WhyAToolIsNotThereIsSaid) {
  formula("off");
  plugins().load();
  try {
    (void)parseScript(R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 5}}],
      "strokes": [{"tool": "local.off.ripple", "radius_mm": 1, "path": [[0, 0, 0, 5], [1, 1, 0, 5]]}]})",
                      "script.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("is of the plugin off, which is not enabled: argil plugins enable local.off"));
  }
}

TEST_F(PluginsTest, AnExamplePassesItsTrial) {
  for (const char* name : {"soften", "clay-strips", "formulas", "ripples", "obj-sequence", "roughen", "rail", "pebbles",
                           "pendulum", "wide-mean"})
    for (const PluginCheck& check : checkPlugin(tests::examplePlugin(name))) EXPECT_EQ(check.problem, "") << check.name;
}

TEST_F(PluginsTest, AStartThatDiesIsKnownToTheNext) {
  const fs::path file = root_ / "plugins.starting";
  const auto diesAt = [&](bool good) {
    const pid_t child = ::fork();
    if (child == 0) {
      auto* mark = new StartMark(file);  // nobody ends it
      if (good) mark->good();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
  };
  EXPECT_FALSE(StartMark(file).lastDied());
  EXPECT_FALSE(StartMark(file).lastDied()) << "it came to its end";
  diesAt(true);
  EXPECT_FALSE(StartMark(file).lastDied()) << "it died later";
  diesAt(false);
  {
    const StartMark mark(file);
    EXPECT_TRUE(mark.lastDied());
    EXPECT_FALSE(StartMark(file).lastDied()) << "another window that begins";
  }
  EXPECT_FALSE(StartMark(file).lastDied()) << "once alone";
  EXPECT_FALSE(StartMark({}).lastDied());
  EXPECT_FALSE(StartMark(root_ / "none" / "x").lastDied());
}

struct Found {
  const char* name;
  const char* problem;
};
class BadPluginTrial : public testing::TestWithParam<Found> {};

TEST_P(BadPluginTrial, NamesTheFault) {
  const fs::path root = fs::temp_directory_path() / "trial";
  std::string problems;
  for (const PluginCheck& check : checkPlugin(tests::badPlugin(root, GetParam().name)))
    if (!check.problem.empty()) problems += check.name + ": " + check.problem + "\n";
  EXPECT_THAT(problems, HasSubstr(GetParam().problem));
  fs::remove_all(root);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadPluginTrial,
    testing::Values(Found{"crash", ": crash: "}, Found{"hang", ": hang: "},
                    Found{"nan", ": a number that is not finite: "},
                    Found{"wrong_version", ": no plugin of this version: "},
                    Found{"fork", ": forbidden: it tried to start another process"},
                    Found{"hog", ": too much memory: "}, Found{"outside", ": a write outside of its batch: "},
                    Found{"id", ": not as plugin.json says: "}, Found{"margin", ": not as plugin.json says: "},
                    Found{"socket", ": forbidden: it tried to open a connection"},
                    Found{"file", ": forbidden: it tried to look at files"}, Found{"leak", "MB more after"},
                    Found{"batches", "one brick at a time: it does not"},
                    Found{"remembers", "does the same once more: it does not"}, Found{"fails", ": failure: "}),
    [](const auto& each) { return std::string(each.param.name); });
INSTANTIATE_TEST_SUITE_P(LongSlow, BadPluginTrial, testing::Values(Found{"slow", "times as long as smoothing"}));

}  // namespace
}  // namespace argil::engine
