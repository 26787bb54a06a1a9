// The window itself: its first size, the clay's part of it, what Escape and Enter do, the start page, what hovering
// costs. By real mouse and keys.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/e2e/support/command.h"
#include "tests/e2e/support/screen.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

constexpr double kMenu = 28, kBar = 44, kStatus = 26;

class StudioWindow : public ::testing::Test {
 protected:
  void screen(int width, int height, bool manager = true) {
    if (const std::string missing = support::XServer::missing({.windowManager = manager}); !missing.empty())
      GTEST_SKIP() << missing;
    server_ = nullptr;
    server_ = std::make_unique<support::XServer>(support::XServer::Options{width, height, manager});
  }
  // The part of the window that is picture: along a line above the status line, where panels are plain.
  static double clayPart(const render::Image& image, double scale) {
    const int y = image.height - int((kStatus + 3) * scale);
    int free = 0;
    for (int x = 0; x < image.width; ++x) {
      const uint8_t* p = image.pixel(x, y);
      const bool panel =
          (p[0] == 0x25 && p[1] == 0x27 && p[2] == 0x2b) || (p[0] == 0x1d && p[1] == 0x1f && p[2] == 0x22);
      free += panel ? 0 : 1;
    }
    return double(free) / image.width * (image.height - (kMenu + kBar + kStatus) * scale) / image.height;
  }
  static void failed(const render::Image& before, const render::Image& now, const std::string& what) {
    const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    keep(before, "failed-" + test + "-" + what + "-before");
    keep(now, "failed-" + test + "-" + what + "-now");
  }
  static render::Image other(const Person& person, const render::Image& before, double least, const std::string& what) {
    render::Image now = person.settled();
    for (int i = 0; i < 20 && difference(before, now) <= least; ++i) now = person.settled();
    EXPECT_GT(difference(before, now), least) << what;
    if (difference(before, now) <= least) failed(before, now, what);
    return now;
  }
  static void expectAgain(const Person& person, const render::Image& before, double most, const std::string& what) {
    // Above the messages, which come and go.
    const auto upper = [](const render::Image& whole) {
      render::Image cut;
      cut.width = whole.width;
      cut.height = whole.height * 7 / 10;
      cut.rgba.assign(whole.rgba.begin(),
                      whole.rgba.begin() + std::ptrdiff_t(4 * size_t(cut.width) * size_t(cut.height)));
      return cut;
    };
    double away = 1;
    render::Image now;
    for (int i = 0; i < 20 && away > most; ++i) {
      now = person.settled();
      away = difference(upper(before), upper(now));
    }
    EXPECT_LE(away, most) << what;
    if (away > most) failed(before, now, what);
  }
  // What was never saved, to this file.
  static void saveAndClose(RunningStudio& studio, Person& person, const fs::path& file) {
    person.key("ctrl+s");
    person.ready();
    (void)person.settled();
    person.type(file.string());
    person.key("enter");
    for (int i = 0; i < 600 && !fs::exists(file); ++i) person.pause(0.05);
    ASSERT_TRUE(fs::exists(file));
    (void)person.settled();
    person.close();
    EXPECT_EQ(studio.wait(60), 0) << studio.said();
  }
  static void byPalette(Person& person, const std::string& words) {
    const render::Image before = person.settled();
    person.key("ctrl+p");
    (void)other(person, before, 0.05, "the palette");
    person.type(words);
    person.ready();
    person.key("enter");
    person.ready();
  }

  // Until it is there: a busy machine takes its time to make one.
  static void addBlock(Person& person) {
    const render::Image empty = person.settled();
    byPalette(person, "add a block");
    (void)other(person, empty, 0.1, "the block");
  }

  Scratch scratch_;
  std::unique_ptr<support::XServer> server_;
};

TEST_F(StudioWindow, TheFirstOneFillsASmallScreen) {
  for (const bool manager : {true, false}) {
    screen(1280, 720, manager);
    if (!server_) return;
    RunningStudio studio({"studio"}, scratch_.path());
    Person person(studio);
    const render::Image image = person.shot(manager ? "window-first" : "window-first-alone");
    EXPECT_GE(image.width, 1270) << manager;
    EXPECT_GE(image.height, 680) << manager;
    EXPECT_GE(clayPart(image, 1), 0.58) << manager;  // Of a window whose frame takes some lines of the screen.
  }
}

TEST_F(StudioWindow, OptionsNeedNoVerb) {
  screen(1000, 700);
  if (!server_) return;
  RunningStudio studio({"--size", "900x600", "--scale", "1"}, scratch_.path());
  Person person(studio);
  EXPECT_EQ(person.look().width, 900);
  for (const char* wrong : {"9", "0.1", "nan", "-1", "two", "1,5"}) {
    const Outcome o = argil({"--scale", wrong});
    EXPECT_EQ(o.code, 2) << wrong;
    EXPECT_NE(o.err.find("0.5 to 4"), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  }
  for (const char* wrong : {"0", "101", "nan", "-1", "fast"}) {
    const Outcome o = argil({"studio", "--speed", wrong});
    EXPECT_EQ(o.code, 2) << wrong;
    EXPECT_NE(o.err.find("0.1 to 100"), std::string::npos) << o.err;
  }
  EXPECT_NE(argil({"studio", "--help"}).out.find("0.5 to 4"), std::string::npos);
  EXPECT_EQ(argil({"--version"}).code, 0);
}

class ClayPart : public StudioWindow, public ::testing::WithParamInterface<Screen> {};

TEST_P(ClayPart, PanelsFoldAndOpenOverTheClay) {
  const Screen s = GetParam();
  screen(s.width + 20, s.height + 60);
  if (!server_) return;
  RunningStudio studio({"studio", "--size", std::to_string(s.width) + "x" + std::to_string(s.height), "--scale",
                        std::to_string(s.scale)},
                       scratch_.path());
  Person person(studio, s.scale);
  const std::string name = std::string("window-") + s.name;
  (void)person.shot(name + "-start");
  addBlock(person);
  person.move(s.width / s.scale - 60, 100);
  (void)person.shot(name + "-block");
  const render::Image block = person.settled();
  EXPECT_GE(clayPart(block, s.scale), 0.595);
  for (const char* key : {"F3", "F4", "F6"}) {
    person.key(key);
    (void)other(person, block, 0.02, key);
    (void)person.shot(name + "-" + key);
    if (key == std::string("F3") && s.width / s.scale >= 1280) {  // There it is docked: hidden and shown again.
      person.key(key);
    } else {
      person.key("escape");
    }
    expectAgain(person, block, 0.01, std::string(key) + " and back");
  }
  const render::Image before = person.settled();
  person.key("F4");
  (void)other(person, before, 0.02, "things");
  person.click(s.width / s.scale * 0.4, s.height / s.scale - 40);
  person.move(s.width / s.scale - 60, 100);
  // The click unselects as well: what is shown of the piece stands on the left.
  const auto right = [](const render::Image& whole) {
    render::Image cut;
    const int from = whole.width * 45 / 100;
    cut.width = whole.width - from;
    cut.height = whole.height * 7 / 10;
    for (int row = 0; row < cut.height; ++row)
      cut.rgba.insert(cut.rgba.end(), whole.pixel(from, row), whole.pixel(from, row) + ptrdiff_t(4) * cut.width);
    return cut;
  };
  double away = 1;
  for (int i = 0; i < 20 && away > 0.015; ++i) away = difference(right(before), right(person.settled()));
  EXPECT_LE(away, 0.015) << "a click beside the panel folds it";
}

INSTANTIATE_TEST_SUITE_P(Sizes, ClayPart, ::testing::Values(Screen{800, 600, 1, "800"}, Screen{1280, 720, 1, "720"}),
                         nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, ClayPart, ::testing::Values(Screen{1280, 720, 2, "720at2"}), nameOf);

TEST_F(StudioWindow, EscapeClosesWhatIsOnTopAndNothingElse) {
  screen(1340, 800);
  if (!server_) return;
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1"}, scratch_.path());
  Person person(studio);
  addBlock(person);
  person.move(1200, 400);
  const render::Image block = person.settled();
  // A curve that is being drawn would be given up by an Escape that reaches the picture.
  person.key("shift+c");
  (void)other(person, block, 0.05, "a curve is drawn");
  (void)person.shot("window-drawing");
  const render::Image drawing = person.settled();
  struct Row {
    const char* name;
    std::function<void()> open;
    double least;
  };
  const auto keys = [&](const char* k) { return [&person, k] { person.key(k); }; };
  const auto click = [&](double x, double y, int button = 1) {
    return [&person, x, y, button] { person.click(x, y, button); };
  };
  const std::vector<Row> table{
      {"File menu", click(23, 14), 0.01},
      {"submenu",
       [&] {
         person.click(177, 14);
         person.ready();
         person.move(200, 50);
       },
       0.01},
      {"palette", keys("ctrl+p"), 0.05},
      {"open", keys("ctrl+o"), 0.05},
      {"recent", keys("ctrl+shift+o"), 0.05},
      {"save as", keys("ctrl+s"), 0.05},
      {"keys", keys("F1"), 0.05},
      {"preferences", keys("ctrl+comma"), 0.05},
      {"the question", [&] { person.close(); }, 0.05},
  };
  for (const Row& row : table) {
    row.open();
    (void)other(person, drawing, row.least, row.name);
    person.key("escape");
    person.move(1200, 400);
    expectAgain(person, drawing, 0.004, std::string(row.name) + ": closed, and the curve is still being drawn");
  }
  // Then the curve itself.
  person.key("escape");
  (void)other(person, drawing, 0.004, "the curve is given up");
}

TEST_F(StudioWindow, ShortcutsWorkWhileAMenuIsOpen) {
  screen(1340, 800);
  if (!server_) return;
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1"}, scratch_.path());
  Person person(studio);
  addBlock(person);
  person.move(1200, 400);
  const render::Image block = person.settled();
  person.click(23, 14);
  (void)other(person, block, 0.01, "the menu");
  person.key("ctrl+p");  // The menu closes, the palette opens, and its own key closes it.
  person.move(1200, 400);
  (void)other(person, block, 0.2, "the palette");
  person.key("ctrl+p");
  expectAgain(person, block, 0.004, "closed by its own key");
  person.click(23, 14);
  (void)other(person, block, 0.01, "the menu");
  person.key("ctrl+z");
  person.move(1200, 400);
  (void)other(person, block, 0.05, "undone: the block is gone");
}

TEST_F(StudioWindow, EnterConfirmsADialog) {
  screen(1340, 800);
  if (!server_) return;
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1"}, scratch_.path());
  Person person(studio);
  person.key("escape");  // The start page.
  person.move(1200, 400);
  const render::Image empty = person.settled();
  byPalette(person, "add clay");
  (void)other(person, empty, 0.3, "the dialog");
  (void)person.shot("window-add-clay");
  person.key("enter");
  const render::Image block = other(person, empty, 0.02, "a block by Enter");
  byPalette(person, "add a ball");
  const render::Image two = other(person, block, 0.01, "a ball");
  byPalette(person, "join");
  (void)other(person, two, 0.3, "the dialog");
  person.key("enter");
  (void)other(person, two, 0.002, "joined by Enter");
  // The question before leaving: Enter saves, so a name is asked for.
  const render::Image joined = person.settled();
  person.close();
  (void)other(person, joined, 0.3, "the question");
  person.key("enter");
  person.ready();
  (void)person.settled();
  person.type((scratch_ / "a.argil").string());
  person.key("enter");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
  EXPECT_TRUE(fs::exists(scratch_ / "a.argil"));
}

TEST_F(StudioWindow, TheStartPageIsReachedByKeysAndGoesWhenWorkBegins) {
  screen(1340, 800);
  if (!server_) return;
  const std::vector<std::string> arguments{"studio", "--size", "1280x720", "--scale", "1"};
  const fs::path file = scratch_ / "clay.argil";
  {
    RunningStudio studio(arguments, scratch_.path());
    Person person(studio);
    person.move(1200, 400);
    const render::Image page = person.shot("start-first");
    person.key("tab");
    (void)other(person, page, 0.0005, "a tile is chosen");
    person.key("Right");
    (void)person.shot("start-chosen");
    person.key("Left");
    person.key("enter");
    (void)other(person, page, 0.1, "a block, and the page is gone");
    (void)person.shot("start-block");
    saveAndClose(studio, person, file);
  }
  {
    RunningStudio studio(arguments, scratch_.path());
    Person person(studio);
    person.move(1200, 400);
    // The picture of the document has clay in it.
    const auto clayPixels = [](const render::Image& image) {
      size_t count = 0;
      for (size_t i = 0; i < image.rgba.size(); i += 4)
        count += image.rgba[i] > 150 && image.rgba[i] > image.rgba[i + 2] + 40 ? 1 : 0;
      return count;
    };
    render::Image page = person.shot("start-with-picture");
    for (int i = 0; i < 20 && clayPixels(page) < 300; ++i) page = person.shot("start-with-picture");
    EXPECT_GE(clayPixels(page), 300u);
    // Tab goes through new clay and opening to it.
    for (int i = 0; i < 4; ++i) person.key("tab");
    (void)person.shot("start-picture-chosen");
    person.key("enter");
    (void)other(person, page, 0.1, "opened");
    (void)person.shot("start-opened");
    person.close();
    EXPECT_EQ(studio.wait(60), 0) << studio.said();
  }
}

TEST_F(StudioWindow, AQualityIsChosenKeptAndSaved) {
  screen(1340, 800);
  if (!server_) return;
  const fs::path file = scratch_ / "clay.argil";
  {
    RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1"}, scratch_.path());
    Person person(studio);
    person.move(1200, 400);
    person.key("tab");
    person.key("enter");
    person.ready();
    byPalette(person, "add clay");
    person.pause(2);  // the machine is measured beside it
    (void)person.shot("quality-new-clay");
    person.key("escape");
    person.key("f8");
    (void)person.shot("quality-balanced");
    byPalette(person, "draft quality");
    (void)person.shot("quality-draft");
    saveAndClose(studio, person, file);
  }
  std::ifstream settings(scratch_ / "argil" / "studio.json");
  const Json kept = Json::parse(settings);
  EXPECT_EQ(kept["quality"]["supersample"], 1);
  const Outcome tools = argil({"tools", "--quality", "--json"}), inspect = argil({"inspect", "--json", file.string()});
  ASSERT_EQ(inspect.code, 0) << inspect.err;
  const Json saved = Json::parse(inspect.out)["quality"];
  for (const Json& axis : Json::parse(tools.out)) {
    if (axis["part"] != "strokes") continue;
    std::string key = axis["id"];
    std::replace(key.begin(), key.end(), '-', '_');
    EXPECT_EQ(saved.value(key, axis["begins"].get<double>()), axis["draft"].get<double>()) << key;
  }
}

TEST_F(StudioWindow, HoveringAndTooltipsDrawNoClay) {
  screen(1340, 800);
  if (!server_) return;
  RunningStudio studio({"studio", "--size", "1280x720", "--scale", "1", "--report", "report.json"}, scratch_.path());
  Person person(studio);
  addBlock(person);
  person.move(1250, 680);
  render::Image before = person.settled();
  int pictures = 0;
  // Over tools, numbers and the rail: each lights up, and says what it is when the hand rests.
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{
           {21, 112}, {55, 165}, {89, 199}, {21, 286}, {250, 145}, {300, 210}, {1259, 133}, {1259, 181}, {1259, 257}}) {
    person.move(x, y);
    render::Image now = person.settled();  // The tooltip has come.
    for (int i = 0; i < 20 && difference(before, now) <= 0.0003; ++i) now = person.settled();
    EXPECT_GT(difference(before, now), 0.0003) << x << ", " << y;
    before = now;
    ++pictures;
  }
  (void)person.shot("window-tooltip");
  kill(studio.pid(), SIGTERM);
  EXPECT_EQ(studio.wait(30), 0) << studio.said();
  const Json r = Json::parse(slurp(scratch_ / "report.json"), nullptr, false);
  ASSERT_TRUE(r.is_object());
  EXPECT_GE(r["frames_since_clay"], pictures)
      << "each place changed the panels, and no picture among them drew the clay: " << r.dump(1);
}

// Whoever spares a battery, or draws for a slow line, says how many pictures a second are enough.
TEST_F(StudioWindow, DrawsNoMorePicturesASecondThanAreAskedFor) {
  screen(1000, 640);
  if (!server_) return;
  fs::create_directories(scratch_ / "argil");
  std::ofstream(scratch_ / "argil" / "studio.json")
      << R"({"quality":{"supersample":1,"key_shadow":false,"cavity":false,"frames_per_second":5}})";
  const auto begin = std::chrono::steady_clock::now();
  RunningStudio studio({"studio", "--size", "800x600", "--scale", "1", "--report", "report.json"}, scratch_.path());
  Person person(studio);
  addBlock(person);
  person.drag({{400, 300}, {480, 330}, {400, 300}, {480, 330}}, 4, 2);
  (void)person.settled();
  kill(studio.pid(), SIGTERM);
  EXPECT_EQ(studio.wait(30), 0) << studio.said();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const Json r = Json::parse(slurp(scratch_ / "report.json"), nullptr, false);
  ASSERT_TRUE(r.is_object());
  EXPECT_GT(r["clay_frames"], 5) << "the view turned";
  EXPECT_LT(r["frames"].get<double>(), 5 * took.count() + 2);
}

}  // namespace
}  // namespace argil::tests
