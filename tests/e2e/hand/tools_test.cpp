// The tool chest in the window: tools are taken by a click and worked with, everything is undone, two pieces become
// one. By real mouse and keys.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/tools/tool_table.h"
#include "tests/e2e/support/screen.h"

namespace argil::tests {
namespace {

class ToolChest : public OnScreen {
 protected:
  static constexpr double kTabs = 180;  // Of the deform box, interface units from the upper edge.
  // The white point of the deform box that is nearest to the middle of the window.
  static std::array<double, 2> whitePoint(const render::Image& image) {
    const int reach = std::max(1, int(at().scale));
    const auto white = [&](int px, int py) {
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i)
          for (int c = 0; c < 3; ++c)
            if (image.pixel(px + i, py + j)[c] < 225) return false;
      return true;
    };
    std::array<double, 2> best{0, 0};
    double nearest = 1e9;
    for (int py = int(150 * at().scale); py < int(600 * at().scale); ++py)
      for (int px = int(400 * at().scale); px < int(930 * at().scale); ++px) {
        const double ux = px / at().scale, uy = py / at().scale, away = std::hypot(ux - middleX(), uy - middleY());
        if (away >= nearest || !white(px, py)) continue;
        nearest = away;
        best = {ux, uy};
      }
    EXPECT_LT(nearest, 1e9) << "no point of the deform box is seen";
    return best;
  }
  // Where a tool's button stands: below the menu and the bar, four columns of 32 units, 2 between them, the group's
  // name above it 19 high.
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
  // The clay, without panels and messages.
  static render::Image clay(const render::Image& whole) { return part(whole, 390, 150, 940, 600); }
  // A block that stands in the picture: on a busy machine that takes longer than a key.
  static render::Image addBlock(Person& person) {
    (void)person.settled();
    byPalette(person, "add a block");
    person.move(middleX() - 230, middleY() + 250);  // No cursor in the picture.
    const auto stands = [](const render::Image& image) {
      const uint8_t* p = image.pixel(int(middleX() * at().scale), int(middleY() * at().scale));
      return p[0] > 150 && p[0] > p[2] + 30;
    };
    render::Image now = person.settled();
    for (int i = 0; i < 60 && !stands(now); ++i) now = person.settled();
    EXPECT_TRUE(stands(now)) << "no block";
    return now;
  }
  // The middle of the dialog's chief button: the accent of the dark theme, 80 units wide at least.
  static std::array<double, 2> chiefButton(const Person& person) {
    constexpr std::array<uint8_t, 3> kAccent{0x74, 0xb6, 0xe2};  // Of the dark theme.
    const render::Image image = person.settled();
    const int least = int(80 * at().scale);
    for (int py = image.height / 4; py < image.height; ++py)
      for (int px = image.width / 3, run = 0; px < image.width; ++px) {
        const uint8_t* p = image.pixel(px, py);
        run = p[0] == kAccent[0] && p[1] == kAccent[1] && p[2] == kAccent[2] ? run + 1 : 0;
        if (run >= least) return {(px - run / 2) / at().scale, py / at().scale + 12};
      }
    ADD_FAILURE() << "no chief button";
    return {0, 0};
  }
  // Waits until the clay looks otherwise: a job may take seconds.
  static render::Image otherClay(const Person& person, const render::Image& before, double least) {
    render::Image now = person.settled();
    for (int i = 0; i < 100 && difference(clay(before), clay(now)) <= least; ++i) now = person.settled();
    EXPECT_GT(difference(clay(before), clay(now)), least);
    return now;
  }
  // Waits until the settings look as they did and the clay does not: what was asked for is over, and done.
  static render::Image done(const Person& person, const render::Image& settings, const render::Image& before,
                            double least) {
    const auto over = [&](const render::Image& now) {
      return difference(part(settings, 150, 80, 345, 680), part(now, 150, 80, 345, 680)) < 0.002 &&
             difference(clay(before), clay(now)) > least;
    };
    render::Image now = person.settled();
    for (int i = 0; i < 100 && !over(now); ++i) now = person.settled();
    EXPECT_TRUE(over(now));
    return now;
  }
  render::Image shot(Person& person, const std::string& step) {
    return person.shot(std::string("tools-") + at().name + "-" + step);
  }
};

// The part of a picture that a soft stroke on a lit face changes by more than a little: some pixels.
constexpr double kSoftStroke = 4e-6;

TEST_P(ToolChest, ToolsAreTakenByAClickAndEverythingIsUndone) {
  RunningStudio studio(arguments({"--report", "report.json"}), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  (void)addBlock(person);
  const render::Image block = shot(person, "01-block");

  const std::vector<std::string> tools{"wax", "layer", "groove", "crease", "inflate", "tug", "twist"};
  render::Image before = block;
  for (size_t i = 0; i < tools.size(); ++i) {
    const auto button = buttonOf(tools[i]);
    person.click(button[0], button[1]);
    const double line = y - 105 + 22 * double(i);
    person.drag({{x - 60, line}, {x - 20, line + 4}, {x + 20, line - 4}, {x + 60, line}});
    person.move(x - 230, y + 230);
    const render::Image after = other(person, before, kSoftStroke);
    EXPECT_GT(difference(clay(before), clay(after)), kSoftStroke) << tools[i];
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
  const render::Image straight = other(person, undone, kSoftStroke);
  EXPECT_GT(difference(clay(undone), clay(straight)), kSoftStroke);
  shot(person, "03-straight");
  person.key("ctrl+z");
  person.key("d");
  const auto emboss = buttonOf("emboss");
  person.click(emboss[0], emboss[1]);
  person.move(x - 230, y + 230);
  shot(person, "04-emboss");

  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(20), 0) << studio.said();
  const auto report = nlohmann::json::parse(slurp(scratch_ / "report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_GE(report["strokes"], tools.size() + 1);
}

TEST_P(ToolChest, TwoPiecesBecomeOneByTheDialog) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const render::Image block = addBlock(person);
  byPalette(person, "add a ball");
  (void)other(person, block, 0.002);
  const render::Image two = shot(person, "05-two-pieces");
  byPalette(person, "join");
  (void)other(person, two, 0.3);  // Everything behind the dialog is dimmed.
  shot(person, "06-join");
  const auto chief = chiefButton(person);
  person.click(chief[0], chief[1]);
  const render::Image joined = other(person, two, 0.002);
  shot(person, "07-joined");
  EXPECT_GT(difference(two, joined), 0.001);
  byPalette(person, "export STL");
  person.ready();
  person.key("ctrl+a");
  person.type("out");
  person.key("enter");
  for (int i = 0; i < 100 && !fs::exists(scratch_ / "out.stl"); ++i) person.pause(0.2);
  (void)person.settled();
  const Outcome o = argil({"inspect", (scratch_ / "out.stl").string(), "--json"});
  ASSERT_EQ(o.code, 0) << o.err;
  const auto mesh = nlohmann::json::parse(o.out, nullptr, false);
  EXPECT_EQ(mesh["mesh"]["bodies"], 2) << "the ball stands beside the block";
  // A block of 60 × 60 × 40 with edges rounded by 4 mm, and a ball of 60 mm.
  EXPECT_NEAR(mesh["mesh"]["volume_mm3"].get<double>(), 141888 + 113097, 800);
}

TEST_P(ToolChest, APieceIsCutByADrawnCurve) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  (void)addBlock(person);
  const render::Image block = shot(person, "11-before-the-cut");
  const std::vector<std::array<double, 2>> way{{x - 255, y - 20}, {x - 150, y - 60}, {x - 40, y + 10},
                                               {x + 60, y + 30},  {x + 150, y - 40}, {x + 265, y - 10}};
  const auto draw = [&] {
    person.key("shift+c");
    (void)other(person, block, 0.002);
    person.drag(way, 1);
  };
  // Given up in mid-drawing, then after it.
  person.key("shift+c");
  const render::Image before = shot(person, "12-draw");
  person.move(way[0][0], way[0][1]);
  person.press();
  person.move(way[1][0], way[1][1]);
  (void)other(person, before, 0.0002);  // The line is seen: keys and buttons come by different ways.
  person.key("escape");
  person.ready();
  person.release();
  person.drag(way, 1);
  const render::Image drawn = shot(person, "13-drawn");
  person.key("tab");
  (void)other(person, drawn, 0.02);
  shot(person, "14-the-other-side");
  person.key("escape");
  person.move(x - 230, y + 230);
  render::Image again = person.settled();
  for (int i = 0; i < 20 && difference(clay(block), clay(again)) >= 0.002; ++i) again = person.settled();
  EXPECT_LT(difference(clay(block), clay(again)), 0.002) << "given up";
  draw();
  person.key("enter");
  person.move(x - 230, y + 230);
  const render::Image cut = done(person, block, block, 0.05);
  shot(person, "15-cut");
  person.key("ctrl+z");
  again = otherClay(person, cut, 0.05);
  for (int i = 0; i < 20 && difference(clay(block), clay(again)) >= 0.002; ++i) again = person.settled();
  EXPECT_LT(difference(clay(block), clay(again)), 0.002) << "undone";
}

TEST_P(ToolChest, AMaskedPartIsHiddenAndTheRestWorkedOn) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  const render::Image block = addBlock(person);
  person.key("shift+m");
  (void)other(person, block, 0.002);
  const render::Image flat = person.settled();
  person.drag({{x - 255, y - 170}, {x - 20, y - 170}, {x - 20, y + 240}, {x - 255, y + 200}, {x - 255, y - 160}}, 1);
  person.move(x - 230, y + 250);
  (void)otherClay(person, flat, 0.1);
  const render::Image masked = shot(person, "21-masked");
  person.key("escape");
  person.key("shift+h");
  const render::Image hidden = otherClay(person, masked, 0.1);
  shot(person, "22-hidden");
  person.key("c");
  person.drag({{x + 20, y - 60}, {x + 60, y - 50}, {x + 120, y - 70}});
  person.move(x - 230, y + 250);
  (void)otherClay(person, hidden, kSoftStroke);
  shot(person, "23-worked-on");
  person.key("ctrl+h");
  const render::Image all = otherClay(person, hidden, 0.1);
  shot(person, "24-all-shown");
  person.key("ctrl+m");
  const render::Image inverted = otherClay(person, all, 0.2);
  shot(person, "25-inverted");
  person.key("alt+m");
  (void)otherClay(person, inverted, 0.1);
  shot(person, "26-cleared");
}

TEST_P(ToolChest, ThePointsOfTheDeformBoxArePulled) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  const render::Image first = addBlock(person);
  // The view goes back until all points are seen; it stays so.
  byPalette(person, "deform box");
  (void)otherClay(person, first, 0.02);
  person.key("escape");
  person.ready();
  person.move(x - 230, y + 250);
  const render::Image block = person.settled();
  byPalette(person, "deform box");
  (void)other(person, block, 0.005);
  person.move(x - 230, y + 250);
  // The palette is closed.
  for (int i = 0; i < 20 && difference(clay(block), clay(person.settled())) > 0.3; ++i) continue;
  const render::Image box = shot(person, "31-deform-box");
  const auto [px, py] = whitePoint(box);
  person.drag({{px, py}, {px + 10, py - 60}, {px + 20, py - 110}}, 1);
  person.move(x - 230, y + 250);
  const render::Image grid = person.settled();
  EXPECT_GT(difference(clay(box), clay(grid)), 0.001);
  (void)done(person, box, box, 0.03);  // The clay follows: no progress is shown any more.
  shot(person, "32-pulled");
  // Bend, twist and taper stand in the settings, to be chosen above their numbers.
  for (int tab = 1; tab < 4; ++tab) {
    person.click(156 + 45 * tab + 22, kTabs);
    person.ready();
    shot(person, std::array{"33-bend", "34-twist", "35-taper"}[size_t(tab - 1)]);
  }
  byPalette(person, "cancel the deform box");
  person.move(x - 230, y + 230);
  render::Image again = person.settled();
  for (int i = 0; i < 20 && difference(clay(block), clay(again)) >= 0.002; ++i) again = person.settled();
  EXPECT_LT(difference(clay(block), clay(again)), 0.002) << "cancelled";
}

TEST_P(ToolChest, AMaterialIsAddedAndLaidInItsColour) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  (void)addBlock(person);
  const auto button = buttonOf("material");
  person.click(button[0], button[1]);
  const render::Image none = person.settled();
  byPalette(person, "add a material");
  person.move(x - 230, y + 250);
  // The palette is closed.
  for (int i = 0; i < 20 && difference(clay(none), clay(person.settled())) > 0.01; ++i) continue;
  const render::Image added = shot(person, "41-material");
  EXPECT_GT(difference(none, added), 0.005) << "its row is in the settings";
  for (int i = 0; i < 3; ++i)
    person.drag({{x - 60, y - 100 + 25 * i}, {x + 20, y - 90 + 25 * i}, {x + 90, y - 100 + 25 * i}});
  person.move(x - 230, y + 250);
  (void)otherClay(person, added, 0.01);
  shot(person, "42-laid");
}

// The large screen costs four times the pixels: what the others do at length is seen there once.
class ToolGlance : public ToolChest {};

TEST_P(ToolGlance, EveryGroupIsOpenedAndTheDialogsStandWhereTheyBelong) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  const double x = middleX(), y = middleY();
  const render::Image before = addBlock(person);
  std::string_view group;
  int groups = 0;
  render::Image last;
  for (const engine::ToolRow& row : engine::toolTable()) {
    if (row.group == group) continue;
    group = row.group;
    ++groups;
    const auto button = buttonOf(row.id);
    person.click(button[0], button[1]);
    const auto settings = [](const render::Image& image) { return part(image, 150, 80, 345, 300); };
    // A busy machine looks still before it has answered.
    for (int i = 0; i < 20 && groups > 1 && difference(settings(last), settings(person.settled())) <= 0.005; ++i)
      continue;
    const double line = y - 110 + 25 * groups;
    person.drag({{x - 60, line}, {x - 20, line + 4}, {x + 20, line - 4}, {x + 60, line}});
    person.move(x - 230, y + 250);
    const render::Image now = shot(person, "51-" + std::string(row.group));
    if (groups > 1) {
      EXPECT_GT(difference(settings(last), settings(now)), 0.005) << row.id << " was not taken";
    }
    last = now;
  }
  const render::Image worked = person.settled();
  EXPECT_GT(difference(clay(before), clay(worked)), 0.005);
  byPalette(person, "cut by plane");
  (void)other(person, worked, 0.1);  // The plane, and what goes.
  shot(person, "52-dialog");
  person.key("escape");
  const render::Image still = person.settled();
  byPalette(person, "deform box");
  (void)other(person, still, 0.02);
  shot(person, "53-deform-box");
  person.click(156 + 45 + 22, kTabs);
  const render::Image bend = shot(person, "54-bend");
  person.key("escape");
  const render::Image carve = other(person, bend, 0.02);
  person.key("shift+c");
  (void)other(person, carve, 0.02);
  person.drag({{x - 255, y - 20}, {x - 40, y + 10}, {x + 60, y + 30}, {x + 265, y - 10}}, 1);
  person.move(x - 230, y + 250);
  const render::Image drawn = shot(person, "55-drawn");
  person.key("enter");
  person.move(x - 230, y + 250);
  (void)done(person, worked, carve, 0.05);
  EXPECT_GT(difference(clay(carve), clay(drawn)), 0.05);
  shot(person, "56-cut");
}

INSTANTIATE_TEST_SUITE_P(Sizes, ToolGlance, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, ToolGlance, ::testing::Values(kDenseScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(Sizes, ToolChest, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, ToolChest, ::testing::Values(kDenseScreen), nameOf);

}  // namespace
}  // namespace argil::tests
