// The tool chest in the window: tools are taken by a click and worked with, everything is undone, two pieces become one. By real mouse and keys.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "../cli/command.h"
#include "engine/tool_table.h"
#include "person.h"
#include "tests/support/x_server.h"

namespace argil::tests {
namespace {

struct Screen {
  int width, height;
  double scale;
  const char* name;
};

class ToolChest : public ::testing::TestWithParam<Screen> {
 protected:
  void SetUp() override {
    if (const std::string missing = support::XServer::missing({.windowManager = true}); !missing.empty()) GTEST_SKIP() << missing;
    server_ = std::make_unique<support::XServer>(support::XServer::Options{at().width + 60, at().height + 80, true});
  }
  static Screen at() { return GetParam(); }
  static double middleX() { return at().width / at().scale / 2; }
  static double middleY() { return at().height / at().scale / 2; }

  // Where a tool's button stands: below the menu and the bar, four columns of 32 units, 2 between them, the group's name above it 19 high.
  static std::array<double, 2> buttonOf(std::string_view id) {
    double y = 28 + 44 + 5 - 34;
    int column = 0;
    std::string_view group;
    for (const engine::ToolRow& row : engine::toolTable()) {
      if (row.group != group || column == 4) {
        y += 34 + (row.group != group ? 19 : 0);
        column = 0;
      }
      group = row.group;
      if (row.id == id) return {5 + 34.0 * column + 16, y + 16};
      ++column;
    }
    throw std::runtime_error("no tool " + std::string(id));
  }
  static void byPalette(Person& person, const std::string& words) {
    person.key("ctrl+p");
    person.pause(0.5);
    person.type(words);
    person.pause(0.3);
    person.key("enter");
    person.pause(0.5);
  }
  // A busy machine may take so long for a picture that the one before counts as settled: waits for a picture that is another one.
  static render::Image other(const Person& person, const render::Image& before, double least) {
    render::Image now = person.settled();
    for (int i = 0; i < 20 && difference(before, now) <= least; ++i) now = person.settled();
    return now;
  }
  // The clay, without panels and messages.
  static render::Image clay(const render::Image& whole) {
    render::Image part;
    const int left = int(390 * at().scale), right = int(940 * at().scale), top = int(150 * at().scale), bottom = int(600 * at().scale);
    part.width = right - left;
    part.height = bottom - top;
    for (int y = top; y < bottom; ++y)
      part.rgba.insert(part.rgba.end(), whole.rgba.begin() + 4 * (std::ptrdiff_t(y) * whole.width + left), whole.rgba.begin() + 4 * (std::ptrdiff_t(y) * whole.width + right));
    return part;
  }
  render::Image shot(Person& person, const std::string& step) { return person.shot(std::string("tools-") + at().name + "-" + step); }

  Scratch scratch_;
  std::unique_ptr<support::XServer> server_;
};

TEST_P(ToolChest, toolsAreTakenByAClickAndEverythingIsUndone) {
  RunningStudio studio({"studio", "--size", std::to_string(at().width) + "x" + std::to_string(at().height), "--scale", std::to_string(at().scale), "--report", "report.json"}, scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  const render::Image empty = person.settled();
  byPalette(person, "add a block");
  (void)other(person, empty, 0.05);
  person.move(x - 230, y + 230);  // No cursor in the picture.
  const render::Image block = shot(person, "01-block");

  const std::vector<std::string> tools{"wax", "layer", "groove", "crease", "inflate", "tug", "twist"};
  render::Image before = block;
  for (size_t i = 0; i < tools.size(); ++i) {
    const auto button = buttonOf(tools[i]);
    person.click(button[0], button[1]);
    const double line = y - 105 + 22 * double(i);
    person.drag({{x - 60, line}, {x - 20, line + 4}, {x + 20, line - 4}, {x + 60, line}});
    person.move(x - 230, y + 230);
    const render::Image after = other(person, before, 0.0005);
    EXPECT_GT(difference(clay(before), clay(after)), 0.0005) << tools[i];
    before = after;
  }
  shot(person, "02-worked");

  for (size_t i = 0; i < tools.size(); ++i) person.key("ctrl+z");
  render::Image undone = person.settled();
  for (int i = 0; i < 20 && difference(clay(block), clay(undone)) >= 0.001; ++i) undone = person.settled();
  EXPECT_LT(difference(clay(block), clay(undone)), 0.001);

  // A straight line, by the rubber line; an image that is missing is told.
  person.key("d");
  person.key("c");
  person.drag({{x - 60, y - 60}, {x + 70, y - 30}});
  person.move(x - 230, y + 230);
  const render::Image straight = other(person, undone, 0.001);
  EXPECT_GT(difference(clay(undone), clay(straight)), 0.001);
  shot(person, "03-straight");
  person.key("ctrl+z");
  person.key("d");
  const auto emboss = buttonOf("emboss");
  person.click(emboss[0], emboss[1]);
  person.move(x - 230, y + 230);
  shot(person, "04-emboss");

  person.close();
  person.pause(0.5);
  person.type("d");
  EXPECT_EQ(studio.wait(20), 0) << studio.said();
  const auto report = nlohmann::json::parse(slurp(scratch_ / "report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_GE(report["strokes"], tools.size() + 1);
}

TEST_P(ToolChest, twoPiecesBecomeOneByTheDialog) {
  RunningStudio studio({"studio", "--size", std::to_string(at().width) + "x" + std::to_string(at().height), "--scale", std::to_string(at().scale)}, scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  const render::Image empty = person.settled();
  byPalette(person, "add a block");
  const render::Image block = other(person, empty, 0.05);
  byPalette(person, "add a ball");
  (void)other(person, block, 0.002);
  const render::Image two = shot(person, "05-two-pieces");
  byPalette(person, "join");
  (void)other(person, two, 0.3);  // Everything behind the dialog is dimmed.
  shot(person, "06-join");
  // The chief button is the right one at the foot of the dialog.
  person.click(x + 134, y + 96);
  const render::Image joined = other(person, two, 0.002);
  shot(person, "07-joined");
  EXPECT_GT(difference(two, joined), 0.001);
  byPalette(person, "export STL");
  person.pause(0.5);
  person.key("ctrl+a");
  person.type("out");
  person.key("enter");
  for (int i = 0; i < 100 && !fs::exists(scratch_ / "out.stl"); ++i) person.pause(0.2);
  (void)person.settled();
  const Outcome o = argil({"inspect", (scratch_ / "out.stl").string(), "--json"});
  ASSERT_EQ(o.code, 0) << o.err;
  const auto mesh = nlohmann::json::parse(o.out, nullptr, false);
  EXPECT_EQ(mesh["mesh"]["bodies"], 1);
  // A block of 60 × 60 × 40 with edges rounded by 4 mm, and two caps of the ball, 10 mm high.
  EXPECT_NEAR(mesh["mesh"]["volume_mm3"].get<double>(), 141888 + 16755, 800);
}

std::string nameOf(const ::testing::TestParamInfo<Screen>& screen) { return std::string("on") + screen.param.name; }

INSTANTIATE_TEST_SUITE_P(Sizes, ToolChest, ::testing::Values(Screen{1280, 720, 1, "720"}), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, ToolChest, ::testing::Values(Screen{2560, 1440, 2, "1440"}), nameOf);

}  // namespace
}  // namespace argil::tests
