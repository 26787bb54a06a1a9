// A head from a ball with the tools at their defaults, as somebody sculpts in the first ten minutes. For eyes: set
// ARGIL_SHOTS. What can be counted is.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "clay_on_screen.h"

namespace argil::tests {
namespace {

constexpr Screen kWideScreen{1600, 1000, 1, "1000"};

class LongHead : public ClayOnScreen {
 protected:
  /// "b" is a key, longer words go to the palette.
  static void take(Person& person, const std::string& tool) {
    if (tool.size() == 1)
      person.key(tool);
    else
      byPalette(person, tool);
    person.ready();
  }
  /// F and a drag to the right: e times as large after 160 units.
  static void size(Person& person, double units) {
    person.move(middleX(), middleY());
    person.ready();
    person.keyDown("f");
    person.drag({{middleX(), middleY()}, {middleX() + units, middleY()}});
    person.keyUp("f");
    person.ready();
  }
  static void view(Person& person, const std::string& key) {
    for (const std::string& each : {key, std::string("home")}) {
      person.key(each);
      (void)person.settled();
    }
  }
  static void shot(Person& person, const std::string& name) {
    person.move(at().width - 300, 200);
    (void)person.shot("head-" + name);
  }
  // The wheel goes to what is under the pointer.
  static void closeUp(Person& person, const std::string& key, double x, double y, const std::string& name) {
    view(person, key);
    person.move(x, y);
    person.wheel(8);
    shot(person, name);
    view(person, key);
  }
};

TEST_P(LongHead, IsSculptedInTenMinutes) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio);
  person.key("escape");
  (void)person.settled();
  byPalette(person, "add a ball");
  seesClay(person);
  person.key("x");
  view(person, "1");
  const double m = middleX();
  struct Stroke {
    std::string tool;
    Way way;
    int times = 1;
  };
  const auto work = [&](const std::vector<Stroke>& strokes) {
    std::string last;
    for (const Stroke& stroke : strokes) {
      if (stroke.tool != last) take(person, stroke.tool);
      last = stroke.tool;
      for (int i = 0; i < stroke.times; ++i) {
        person.drag(stroke.way, 1);
        person.ready();
      }
    }
  };
  // Chin, neck and jaw.
  take(person, "tug");
  size(person, 240);
  work({{"tug", {{m, 700}, {m, 800}}},
        {"tug", {{m - 40, 740}, {m - 35, 850}}},
        {"tug", {{m - 180, 560}, {m - 150, 600}}}});
  view(person, "ctrl+1");
  work({{"tug", {{m, 600}, {m, 700}}}});
  view(person, "1");
  shot(person, "01-neck");
  // Sockets, brows, nose.
  take(person, "c");
  size(person, 60);
  work({{"c", {{m - 95, 390}, {m - 70, 380}, {m - 60, 400}, {m - 85, 410}, {m - 95, 390}, {m - 65, 385}}},
        {"b", {{m - 125, 345}, {m - 95, 325}, {m - 40, 340}}, 2},
        {"b", {{m, 350}, {m, 480}}, 2},
        {"b", {{m, 430}, {m, 490}}},
        {"b", {{m - 15, 480}, {m + 15, 480}}, 2}});
  shot(person, "02-face");
  // Eyes, mouth, cheeks, forehead, ears.
  work({{"a", {{m - 84, 392}, {m - 78, 394}}},
        {"crease", {{m - 60, 560}, {m - 30, 566}, {m, 562}, {m + 30, 566}, {m + 60, 560}}},
        {"b", {{m - 40, 548}, {m - 15, 544}, {m, 548}}},
        {"b", {{m - 35, 578}, {m, 584}}, 2},
        {"ridge", {{m - 160, 470}, {m - 120, 520}, {m - 100, 560}}},
        {"groove", {{m - 135, 350}, {m - 100, 325}, {m - 40, 345}}},
        {"flatten", {{m - 80, 250}, {m, 240}, {m - 40, 290}, {m, 300}}},
        {"pinch", {{m, 380}, {m, 440}}},
        {"inflate", {{m - 110, 470}, {m - 100, 480}}},
        {"scrape", {{m - 60, 640}, {m, 650}}}});
  view(person, "3");
  work({{"b", {{m - 20, 380}, {m + 20, 360}, {m + 40, 420}, {m + 10, 480}}, 3},
        {"s", {{m - 120, 520}, {m - 60, 560}, {m, 580}}, 2}});
  view(person, "1");
  work({{"s", {{m - 160, 470}, {m - 130, 510}}, 2}});
  shot(person, "03-front");
  closeUp(person, "1", m - 85, 390, "04-eye");
  closeUp(person, "1", m, 560, "05-mouth");
  closeUp(person, "1", m - 130, 520, "06-cheek");
  view(person, "3");
  shot(person, "07-side");
  view(person, "0");
  shot(person, "08-three-quarters");
  person.key("ctrl+s");
  person.ready();
  person.key("ctrl+a");
  person.type((scratch_ / "clay.argil").string());
  person.key("enter");
  for (int i = 0; i < 200 && !fs::exists(scratch_ / "clay.argil"); ++i) person.pause(0.1);
  (void)person.settled();
  const Outcome o = argil({"inspect", (scratch_ / "clay.argil").string(), "--json"});
  ASSERT_EQ(o.code, 0) << o.err;
  const Json json = Json::parse(o.out, nullptr, false);
  ASSERT_EQ(json["pieces"].size(), 1u);
  const Json& surface = json["pieces"][0]["surface"];
  EXPECT_TRUE(surface["closed"].get<bool>());
  EXPECT_EQ(surface["bodies"], 1) << "nothing hangs alone";
  EXPECT_EQ(surface["degenerate_triangles"], 0);
  EXPECT_GT(json["history_steps"].get<int>(), 30);
  // Mirrored strokes leave both sides alike.
  EXPECT_NEAR(surface["low_mm"][0].get<double>() + surface["high_mm"][0].get<double>(), 0, 0.25);
}

INSTANTIATE_TEST_SUITE_P(LongSizes, LongHead, ::testing::Values(kWideScreen), nameOf);

}  // namespace
}  // namespace argil::tests
