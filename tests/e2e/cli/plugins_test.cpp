// Plugins as somebody at the command line meets them: the tutorial word for word, and one that misbehaves.

#include "tests/e2e/support/command.h"

#include <nlohmann/json.hpp>

namespace argil::tests {
namespace {

// A home of the test's own, with nothing enabled.
class Home {
 public:
  explicit Home(const fs::path& folder) {
    for (const char* name : {"XDG_CONFIG_HOME", "XDG_DATA_HOME"}) {
      before_.emplace_back(name, std::getenv(name) ? std::getenv(name) : "");
      setenv(name, (folder / name).c_str(), 1);
    }
  }
  ~Home() {
    for (const auto& [name, value] : before_) setenv(name.c_str(), value.c_str(), 1);
    unsetenv("ARGIL_PLUGIN_PATH");
  }
  Home(const Home&) = delete;
  Home& operator=(const Home&) = delete;

 private:
  std::vector<std::pair<std::string, std::string>> before_;
};

// The commands of the page, in order: lines "$ ..." of its blocks of console.
std::string commandsOf(const fs::path& page) {
  std::istringstream in(slurp(page));
  std::string script;
  bool console = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) console = line == "```console";
    if (console && line.starts_with("$ ")) script += line.substr(2) + "\n";
  }
  return script;
}

TEST(Plugins, TheTutorialWordForWord) {
  const Scratch scratch;
  const Home home(scratch.path());
  const std::string commands = commandsOf(fs::path(ARGIL_SOURCE_DIR) / "docs" / "plugins.md");
  ASSERT_NE(commands.find("argil plugins new brush"), std::string::npos);
  const fs::path script = scratch / "tutorial.sh", said = scratch / "said.txt";
  std::ofstream(script) << "set -e\ncd '" << scratch.path().string() << "'\nPATH='"
                        << fs::path(ARGIL_COMMAND).parent_path().string() << "':$PATH\n"
                        << commands;
  const int code = std::system(("bash '" + script.string() + "' > '" + said.string() + "' 2>&1").c_str());
  EXPECT_EQ(code, 0) << slurp(said);
  EXPECT_GT(fs::file_size(scratch / "tried.stl"), 1000u);
  EXPECT_EQ(slurp(said).find("FAILED"), std::string::npos) << slurp(said);
  // The brush did something: without its stroke the ball is another one.
  setenv("ARGIL_PLUGIN_PATH", scratch.path().c_str(), 1);
  const fs::path plain = scratch / "plain.json";
  std::ofstream(plain) << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"sphere": {"radius_mm": 20}}],
    "strokes": []})";
  ASSERT_EQ(argil({"sculpt", plain.string(), "-o", (scratch / "plain.stl").string()}).code, 0);
  EXPECT_NE(slurp(scratch / "plain.stl"), slurp(scratch / "tried.stl"));
}

TEST(Plugins, AreListedDescribedAndChecked) {
  const Scratch scratch;
  const Home home(scratch.path());
  setenv("ARGIL_PLUGIN_PATH", scratch.path().c_str(), 1);
  EXPECT_NE(argil({"plugins"}).out.find("There are no plugins. They are looked for in"), std::string::npos);
  const std::string made = (scratch / "rings.argil-plugin").string();
  ASSERT_EQ(argil({"plugins", "new", "formula", made}).code, 0);
  EXPECT_EQ(argil({"plugins", "new", "formula", made}).code, 2) << "nothing is written over";
  EXPECT_EQ(argil({"plugins", "new", "teapot", made + "2"}).code, 2);
  const auto all = nlohmann::json::parse(argil({"plugins", "--json"}).out);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].at("state"), "not enabled");
  EXPECT_NE(argil({"plugins", "describe", "local.rings"}).out.find("phi - height"), std::string::npos);
  EXPECT_EQ(argil({"plugins", "describe", "local.none"}).code, 2);
  EXPECT_EQ(argil({"plugins", "check", made}).code, 0);
  EXPECT_EQ(argil({"plugins", "check", (scratch / "none").string()}).code, 1);
  // Tools of what is not enabled are not there, and it is said why.
  const Outcome before = argil({"sculpt", made + "/try.json", "-o", (scratch / "x.stl").string()});
  EXPECT_EQ(before.code, 2);
  EXPECT_NE(before.err.find("argil plugins enable local.rings"), std::string::npos) << before.err;
  EXPECT_FALSE(fs::exists(scratch / "x.stl"));
  EXPECT_EQ(argil({"tools", "--ids"}).out.find("local.rings"), std::string::npos);
  ASSERT_EQ(argil({"plugins", "enable", "local.rings"}).code, 0);
  EXPECT_NE(argil({"tools", "--ids"}).out.find("local.rings.ripple"), std::string::npos);
  EXPECT_EQ(argil({"sculpt", made + "/try.json", "-o", (scratch / "x.stl").string()}).code, 0);
  ASSERT_EQ(argil({"plugins", "disable", "local.rings"}).code, 0);
  EXPECT_EQ(argil({"tools", "--ids"}).out.find("local.rings"), std::string::npos);
}

// A time-lapse of a document's steps.
TEST(Plugins, AHistoryBecomesASequenceOfFiles) {
  const Scratch scratch;
  const Home home(scratch.path());
  setenv("ARGIL_PLUGIN_PATH", (fs::path(ARGIL_COMMAND).parent_path().parent_path() / "plugins").c_str(), 1);
  ASSERT_EQ(argil({"plugins", "enable", "org.argil.obj-sequence"}).code, 0);
  const fs::path script = scratch / "steps.json", document = scratch / "steps.argil";
  std::ofstream(script) << R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 10}}], "strokes": [
    {"tool": "carve", "radius_mm": 2, "path": [[0, -3, 0, 10], [1, 3, 0, 10]]},
    {"tool": "add", "radius_mm": 2, "path": [[0, 0, -3, 10], [1, 0, 3, 10]]}]})";
  ASSERT_EQ(argil({"sculpt", script.string(), "-o", document.string()}).code, 0);
  const Outcome made = argil({"convert", document.string(), (scratch / "lapse.objs").string()});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("3 files written, lapse-0001.obj to 0003"), std::string::npos) << made.out;
  for (const char* name : {"lapse-0001.obj", "lapse-0002.obj", "lapse-0003.obj"})
    EXPECT_NE(argil({"inspect", (scratch / name).string(), "--units", "mm"}).out.find("closed      yes"),
              std::string::npos)
        << name;
  EXPECT_EQ(argil({"convert", (scratch / "lapse-0001.obj").string(), (scratch / "x.objs").string()}).code, 2);
}

// Each kind as it is begun with: compiled by its own script, without a fault, listed, and where users look for it.
TEST(Plugins, EveryKindCanBeBegunWith) {
  const Scratch scratch;
  const Home home(scratch.path());
  setenv("ARGIL_PLUGIN_PATH", scratch.path().c_str(), 1);
  for (const std::string kind : {"texture", "operation", "format", "guide", "device"}) {
    SCOPED_TRACE(kind);
    const std::string made = (scratch / ("my-" + kind + ".argil-plugin")).string();
    ASSERT_EQ(argil({"plugins", "new", kind, made}).code, 0);
    ASSERT_EQ(std::system(("sh '" + made + "/build.sh'").c_str()), 0);
    const Outcome checked = argil({"plugins", "check", made});
    EXPECT_EQ(checked.code, 0) << checked.out;
    ASSERT_EQ(argil({"plugins", "enable", "local.my-" + kind}).code, 0);
    EXPECT_NE(argil({"plugins"}).out.find(", 1 " + kind + "."), std::string::npos);
    const std::string described = argil({"plugins", "describe", "local.my-" + kind}).out;
    EXPECT_NE(described.find(": a " + kind + " (local.my-" + kind + "."), std::string::npos) << described;
  }
  EXPECT_NE(argil({"devices"}).out.find("local.my-device.hand"), std::string::npos);
  EXPECT_EQ(argil({"devices", "--sheet", "local.my-device.hand"}).code, 0);
  EXPECT_NE(argil({"tools", "--operations"}).out.find("local.my-operation.roughen"), std::string::npos);
}

// A script whose plugin fails writes nothing and says whose fault it is in one line.
TEST(Plugins, AScriptWhosePluginFailsWritesNothing) {
  const Scratch scratch;
  const Home home(scratch.path());
  setenv("ARGIL_PLUGIN_PATH", scratch.path().c_str(), 1);
  const fs::path made = scratch / "broken.argil-plugin";
  ASSERT_EQ(argil({"plugins", "new", "brush", made.string()}).code, 0);
  std::string source = slurp(made / "soften.c");
  const size_t at = source.find("  return ARGIL_OK;\n}\n\nstatic const argil_brush");
  ASSERT_NE(at, std::string::npos);
  source.insert(at, "  *(volatile int*)(uintptr_t)batch->count = 1;\n");
  std::ofstream(made / "soften.c") << source;
  ASSERT_EQ(std::system(("CFLAGS=-w sh '" + (made / "build.sh").string() + "'").c_str()), 0);
  ASSERT_EQ(argil({"plugins", "enable", "local.broken"}).code, 0);
  const Outcome failed = argil({"sculpt", (made / "try.json").string(), "-o", (scratch / "x.stl").string()});
  EXPECT_EQ(failed.code, 1);
  EXPECT_NE(failed.err.find("broken crashed (Segmentation fault)"), std::string::npos) << failed.err;
  EXPECT_EQ(std::count(failed.err.begin(), failed.err.end(), '\n'), 1) << failed.err;
  EXPECT_FALSE(fs::exists(scratch / "x.stl"));
  const Outcome checked = argil({"plugins", "check", made.string()});
  EXPECT_EQ(checked.code, 1);
  EXPECT_NE(checked.out.find("crash: broken crashed"), std::string::npos) << checked.out;
}

}  // namespace
}  // namespace argil::tests
