// A first day: what README and status line promise of a mouse and keys, on models of any size. All keys: keys_test.cpp;
// pieces, modifiers and pens closer: hand_test.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "clay_on_screen.h"

namespace argil::tests {
namespace {

class FirstDay : public ClayOnScreen {
 protected:
  /// Where the clay is, in parts of the picture that do not depend on the screen's size: 1 is 1/720 of the window's
  /// height.
  static double u() { return middleY() / 360; }
  static std::array<double, 2> on(double x, double y) { return {middleX() + x * u(), middleY() + y * u()}; }
  static Way line(double x0, double y0, double x1, double y1) { return {on(x0, y0), on(x1, y1)}; }
  /// Done, and the window is another.
  template <class Act>
  static render::Image changes(Person& person, const char* what, double least, const Act& act) {
    SCOPED_TRACE(what);
    offTheClay(person);
    const render::Image before = person.settled();
    act();
    return other(person, before, least);
  }
};

TEST_P(FirstDay, HoldsWhatIsPromised) {
  double grew[3] = {};
  int model = 0;
  for (const double size : {1.0, 100.0, 2000.0}) {
    SCOPED_TRACE(size);
    const auto mm = [&](double part) { return std::to_string(size * part); };
    const std::string file = document(R"({"voxel_mm": )" + mm(1.0 / 160) + R"(}, {"block": {"size_mm": [)" + mm(1) +
                                      "," + mm(1) + "," + mm(0.6) + R"(], "round_mm": )" + mm(0.06) + "}}");
    const fs::path home = scratch_ / ("home" + mm(1));  // Nothing is remembered from the model before.
    fs::create_directories(home);
    RunningStudio studio(arguments({file}), home);
    Person person(studio, at().scale);
    const auto shot = [&](const char* step) {
      person.shot("day-" + std::string(at().name) + "-" + std::to_string(int(size)) + "-" + step);
    };
    seesClay(person);
    shot("01-opened");
    const Saved begin = saved();
    Saved now = begin;
    const double all = begin.volume;
    const auto stroke = [&](const char* held, const Way& way) {
      if (*held) person.keyDown(held);
      person.drag(way);
      if (*held) person.keyUp(held);
      offTheClay(person);
      const Saved then = std::exchange(now, otherClay(person, now));
      return (now.volume - then.volume) / all;
    };
    // "Press the left button on the clay to work on it." "Ctrl: opposite, Shift: smooth."
    EXPECT_LT(stroke("", line(-70, -50, 50, -50)), -0.00005) << "the tool at the start carves";
    person.key("a");
    grew[model] = stroke("", line(-60, -90, 60, -90));
    EXPECT_GT(grew[model], 0.0002);
    EXPECT_LT(std::abs(stroke("shift", line(-60, -90, 60, -90))), 0.5 * grew[model]);
    EXPECT_LT(stroke("ctrl", line(-40, -20, 60, -20)), -0.00005);
    shot("02-strokes");
    // "[ ]: size", and "F and a drag".
    person.key("]");
    person.key("]");
    const double larger = stroke("", line(-60, -70, 60, -70));
    EXPECT_GT(larger, 1.1 * grew[model]) << "]";
    const auto [x, y] = on(0, 0);
    person.move(x, y);
    person.ready();
    person.keyDown("f");
    for (int i = 1; i <= 20; ++i) {
      person.move(x - 3 * i * u(), y);
      person.pause(0.01);
    }
    person.keyUp("f");
    person.ready();
    EXPECT_LT(stroke("", line(-60, 0, 60, 0)), 0.8 * larger) << "F and a drag to the left";
    // "X mirrors." Both sides grow by one stroke on one side.
    const double single = stroke("", line(45, -30, 75, -50));
    person.key("ctrl+z");
    now = otherClay(person, now);
    person.key("x");
    EXPECT_GT(stroke("", line(45, -30, 75, -50)), 1.4 * single) << "mirrored";
    person.key("x");
    shot("03-mirrored");
    // "Ctrl+Z goes back."
    const Saved last = now;
    person.key("ctrl+z");
    now = otherClay(person, now);
    person.key("ctrl+shift+z");
    now = otherClay(person, now);
    EXPECT_EQ(now.hash, last.hash);
    // "Drag beside it, or with the middle or right button, to turn the view; with Shift: move; wheel to zoom."
    changes(person, "a drag beside the clay", 0.02, [&] { person.drag(line(-230, 200, -130, 200)); });
    changes(person, "the middle button", 0.02, [&] { person.drag(line(0, 0, 80, 10), 0.5, 2); });
    changes(person, "the right button", 0.02, [&] { person.drag(line(0, 0, -80, 20), 0.5, 3); });
    changes(person, "with Shift", 0.02, [&] {
      person.keyDown("shift");
      person.drag(line(0, 0, 40, 30), 0.5, 2);
      person.keyUp("shift");
    });
    changes(person, "the wheel", 0.02, [&] {
      person.move(x, y);
      person.wheel(3);
    });
    shot("04-turned");
    // "Home shows all."
    changes(person, "all of it", 0.02, [&] { person.key("home"); });
    // A right click, or Q: the ring, whose upper left item undoes.
    changes(person, "the ring", 0.002, [&] {
      person.move(x, y);
      person.key("q");
    });
    shot("05-ring");
    person.click(x - 57 * 0.866, y - 57 * 0.5);
    now = otherClay(person, now);
    person.key("escape");
    person.key("ctrl+shift+z");
    now = otherClay(person, now);
    EXPECT_EQ(now.hash, last.hash) << "undone by the ring, redone by its key; turning the view is no step";
    // Menus open, and Escape closes them.
    for (const double menu : {23.0, 60.0, 100.0}) {
      changes(person, "a menu", 0.005, [&] { person.click(menu, 14); });
      person.key("escape");
      (void)person.settled();
    }
    // "Ctrl+P finds any command."
    changes(person, "a ball", 0.005, [&] { byPalette(person, "add a ball"); });
    person.key("home");
    (void)person.settled();
    shot("06-ball");
    const double before = now.volume;
    now = otherClay(person, now);
    EXPECT_GT(now.volume - before, 0.05 * all) << "a pearl beside a statue";
    EXPECT_LT(now.volume - before, 5 * all) << "a statue beside a pearl";
    person.key("ctrl+z");
    now = otherClay(person, now);
    EXPECT_EQ(now.hash, last.hash);
    person.key("home");
    // What is exported has the model's size.
    person.ready();
    byPalette(person, "export STL");
    person.ready();
    person.key("ctrl+a");
    person.type("out");
    person.key("enter");
    for (int i = 0; i < 200 && !fs::exists(scratch_ / "out.stl"); ++i) person.pause(0.1);
    (void)person.settled();
    const Json mesh = Json::parse(argil({"inspect", (scratch_ / "out.stl").string(), "--json"}).out, nullptr, false);
    ASSERT_TRUE(mesh.is_object());
    EXPECT_TRUE(mesh["mesh"]["closed"].get<bool>());
    EXPECT_NEAR(mesh["mesh"]["volume_mm3"].get<double>() / now.volume, 1, 0.01);
    shot("07-exported");
    fs::remove(scratch_ / "out.stl");
    // All of it back, step by step, is what was opened.
    for (int i = 0; i < 30 && !(now == begin); ++i) {
      person.key("ctrl+z");
      (void)person.settled();
      person.key("ctrl+s");
      (void)person.settled();
      now = saved();
    }
    EXPECT_EQ(now.hash, begin.hash);
    person.key("ctrl+q");
    for (int i = 0; i < 50 && studio.running(); ++i) person.pause(0.1);
    if (studio.running()) person.type("d");
    EXPECT_EQ(studio.wait(60), 0) << studio.said();
    ++model;
  }
  // The same hand does the same to each: tools are sized for the model.
  EXPECT_NEAR(grew[0] / grew[2], 1, 0.05);
  EXPECT_NEAR(grew[1] / grew[2], 1, 0.05);
}

constexpr Screen kLargeScreen{2560, 1440, 1, "1440at1"};
INSTANTIATE_TEST_SUITE_P(LongSizes, FirstDay, ::testing::Values(kSmallScreen, kLargeScreen, kDenseScreen), nameOf);

}  // namespace
}  // namespace argil::tests
