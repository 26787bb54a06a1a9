// What each hand does to the clay: mouse with modifiers, pens, models of any size. The clay is judged by the document
// that is saved.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "clay_on_screen.h"
#include "engine/tools/tool_table.h"

namespace argil::tests {
namespace {

using HandOnClay = ClayOnScreen;

TEST_P(HandOnClay, AKeyThatIsHeldTurnsTheToolOverOrSmoothsForOneStroke) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  const Way way{{x - 60, y - 60}, {x, y - 50}, {x + 60, y - 60}};
  Saved before = saved();
  person.key("a");
  const auto stroke = [&](const std::string& held) {
    if (!held.empty()) person.keyDown(held);
    person.drag(way);
    if (!held.empty()) person.keyUp(held);
    offTheClay(person);
    const Saved now = otherClay(person, before);
    const double grown = now.volume - before.volume;
    before = now;
    return grown;
  };
  const double added = stroke("");
  EXPECT_GT(added, 50) << "Add lays clay";
  EXPECT_LT(std::abs(stroke("shift")), 0.2 * added) << "Shift held smooths the bead: nothing is laid";
  EXPECT_GT(stroke(""), 20) << "Shift is up again: Add";
  EXPECT_LT(stroke("ctrl"), -20) << "Ctrl held: the opposite";
  EXPECT_GT(stroke(""), 20) << "Ctrl is up again: Add";
  // A stroke keeps the tool that it began with, whatever is pressed meanwhile.
  const int steps = before.steps;
  person.move(x - 60, y + 10);
  person.pause(0.1);
  person.press();
  for (int i = 1; i <= 40; ++i) {
    if (i == 20) person.keyDown("ctrl");
    person.move(x - 60 + 3 * i, y + 10);
    person.pause(0.01);
  }
  person.release();
  person.ready();
  person.keyUp("ctrl");
  offTheClay(person);
  const Saved now = otherClay(person, before);
  EXPECT_GT(now.volume - before.volume, 0.8 * added);
  EXPECT_EQ(now.steps, steps + 1) << "one step";
}

// No pause between the strokes: each has the tool of its own modifiers.
TEST_P(HandOnClay, StrokesThatFollowEachOtherAtOnceHaveTheToolOfTheirOwnKeys) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  const Saved before = saved();
  person.key("a");
  const auto quick = [&](double line) {
    person.move(x - 50, line);
    person.press();
    for (int i = 1; i <= 20; ++i) {
      person.move(x - 50 + 5 * i, line);
      person.pause(0.008);
    }
    person.release();
  };
  quick(y - 70);
  person.keyDown("ctrl");
  quick(y - 30);
  person.keyUp("ctrl");
  quick(y + 10);
  offTheClay(person);
  Saved now = otherClay(person, before);
  for (int i = 0; i < 20 && now.steps < before.steps + 3; ++i) {
    (void)person.settled();
    person.key("ctrl+s");
    (void)person.settled();
    now = saved();
  }
  person.shot("hand-three-strokes");
  EXPECT_EQ(now.steps, before.steps + 3);
  // Undone one by one: add, carve, add.
  const auto undone = [&] {
    person.key("ctrl+z");
    const Saved back = otherClay(person, now);
    const double grew = now.volume - back.volume;
    now = back;
    return grew;
  };
  EXPECT_GT(undone(), 50);
  EXPECT_LT(undone(), -20);
  EXPECT_GT(undone(), 50);
}

// Stopped forces are for motors; a mouse has none, wherever the model lies and however fast the hand is.
TEST_P(HandOnClay, AMouseIsNeverStopped) {
  const std::string file = document(R"({"voxel_mm": 0.5}, {"sphere": {"radius_mm": 30, "centre_mm": [12000, 0, 0]}})");
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  Saved now = saved();
  // In and out of the clay, as fast as X takes it.
  for (int i = 0; i < 200; ++i) {
    const double away = i % 4 < 2 ? 40 : 260;
    person.move(x + away * std::cos(i * 1.3), y + 0.6 * away * std::sin(i * 1.7));
    person.pause(0.003);
  }
  person.drag({{x - 30, y - 20}, {x + 30, y - 20}}, 0.3);
  offTheClay(person);
  now = otherClay(person, now);
  person.key("ctrl+.");
  person.drag({{x - 30, y + 20}, {x + 30, y + 20}}, 0.3);
  offTheClay(person);
  now = otherClay(person, now);
  person.shot("hand-never-stopped");
}

// A tip of 5 mm is of use for a block of 60 mm; a pearl and a statue get one of their own size.
TEST_P(HandOnClay, ToolsComeAtASizeThatFitsTheModel) {
  for (const double size : {1.0, 100.0, 2000.0}) {
    SCOPED_TRACE(size);
    const std::string file = document(R"({"voxel_mm": )" + std::to_string(size / 128) +
                                      R"(}, {"sphere": {"radius_mm": )" + std::to_string(size / 2) + "}}");
    RunningStudio studio(arguments({file}), scratch_.path());
    Person person(studio);
    seesClay(person);
    const double x = middleX(), y = middleY();
    const Saved before = saved();
    person.key("a");
    person.drag({{x - 40, y - 10}, {x + 40, y - 10}});
    offTheClay(person);
    const Saved after = otherClay(person, before);
    const double part = (after.volume - before.volume) / before.volume;
    EXPECT_GT(part, 0.0005) << "too small to be seen";
    EXPECT_LT(part, 0.05) << "as large as the model";
    person.move(x, y);
    person.shot("hand-size-" + std::to_string(int(size)));
    person.close();
    EXPECT_EQ(studio.wait(60), 0) << studio.said();
  }
}

// A mouse shows a ring and a dot: no ball, no shaft over the work, while it hovers and while it works.
TEST_P(HandOnClay, AMouseHidesHardlyAnythingOfTheClay) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  offTheClay(person);
  const render::Image bare = person.settled();
  const auto around = [&](const render::Image& image) { return part(image, x - 130, y - 150, x + 130, y + 110); };
  person.move(x, y - 20);
  const render::Image hover = other(person, bare, 1e-5);
  person.shot("hand-ring");
  EXPECT_GT(difference(around(bare), around(hover)), 0.001) << "nothing is shown";
  EXPECT_LT(difference(around(bare), around(hover)), 0.03) << "ball and shaft cover the clay";
}

TEST_P(HandOnClay, AClickOnAPieceWorksOnIt) {
  // A block and a cylinder side by side; the block is worked on.
  std::ofstream(scratch_ / "script.json")
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [40, 40, 30], "centre_mm": [-30, 0, 0]}}],
             "strokes": [{"operation": "cylinder", "name": "Other", "centre_mm": [30, 0, 0], "radius_mm": 20, "height_mm": 30}]})";
  const fs::path file = scratch_ / "clay.argil";
  const Outcome o = argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string(), "--overwrite"});
  ASSERT_EQ(o.code, 0) << o.err;
  RunningStudio studio(arguments({file.string()}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  const auto volumes = [&] {
    const Json json = Json::parse(argil({"inspect", file.string(), "--json"}).out, nullptr, false);
    return std::array{json["pieces"][0]["surface"]["volume_mm3"].get<double>(),
                      json["pieces"][1]["surface"]["volume_mm3"].get<double>()};
  };
  const auto before = volumes();
  person.key("1");  // From the front: one left, one right.
  const render::Image front = person.settled();
  person.shot("hand-two-pieces");
  person.click(x + 110, y);
  person.ready();
  person.shot("hand-other-piece");
  Saved now = saved();
  person.key("a");
  person.drag({{x + 70, y}, {x + 130, y}});
  offTheClay(person);
  (void)otherClay(person, now);
  now = saved();
  auto after = volumes();
  EXPECT_NEAR(after[0], before[0], 1) << "the left one";
  EXPECT_GT(after[1], before[1] + 20) << "the right one was clicked";
  person.click(x - 110, y);
  person.ready();
  person.drag({{x - 130, y}, {x - 70, y}});
  offTheClay(person);
  (void)otherClay(person, now);
  const auto last = volumes();
  EXPECT_GT(last[0], before[0] + 20) << "the left one was clicked";
  EXPECT_NEAR(last[1], after[1], 1);
}

// A pen that says what it does: events of a recording, as the tablet's driver would give them.
class PenOnClay : public HandOnClay {
 protected:
  PenOnClay() { add({{"kind", "check"}}, 0.3); }
  void add(Json more, double seconds = 0.02) {
    Json e = {{"t", std::round(t_ * 1000) / 1000}};
    e.update(more);
    lines_ += e.dump() + "\n";
    t_ += seconds;
  }
  void at(const char* kind, double x, double y, double pressure, Json more = Json::object()) {
    more.update({{"kind", kind}, {"x", x}, {"y", y}, {"pressure", pressure}, {"tilt", {0, 0}}});
    if (eraser_) more["eraser"] = true;
    add(more, 0.01);
  }
  void key(const std::string& name, const std::vector<std::string>& held = {}) {
    Json more = {{"key", name}};
    if (!held.empty()) more["modifiers"] = held;
    more["kind"] = "down";
    add(more);
    add({{"kind", "up"}, {"key", name}});  // Nothing is held any more.
  }
  void drag(const Way& way, double pressure, const std::string& button = "left") {
    at("move", way[0][0], way[0][1], 0);
    at("move", way[0][0], way[0][1], 0);
    at("press", way[0][0], way[0][1], pressure, {{"button", button}});
    for (size_t k = 0; k + 1 < way.size(); ++k)
      for (int i = 1; i <= 30; ++i) {
        const double f = i / 30.0;
        at("move", way[k][0] + f * (way[k + 1][0] - way[k][0]), way[k][1] + f * (way[k + 1][1] - way[k][1]), pressure);
      }
    at("release", way.back()[0], way.back()[1], 0, {{"button", button}});
    check();
  }
  void click(double x, double y, const std::string& button) {
    at("move", x, y, 0);
    at("press", x, y, button == "left" ? 0.5 : 0, {{"button", button}});
    at("release", x, y, 0, {{"button", button}});
    check();
  }
  void check() { add({{"kind", "check"}}, 0.1); }
  void away() { at("move", middleX() - 230, middleY() + 250, 0); }
  void screenshot(const std::string& name) {
    away();
    check();
    add({{"kind", "screenshot"}, {"text", (scratch_ / (name + ".png")).string()}}, 0.1);
  }
  void save() {
    key("S", {"ctrl"});
    check();
  }
  /// Plays what was added so far on a clay, and begins anew.
  Saved play(const std::string& file) {
    std::ofstream(scratch_ / "pen.jsonl") << lines_;
    RunningStudio studio(arguments({file, "--play", (scratch_ / "pen.jsonl").string()}), scratch_.path());
    EXPECT_EQ(studio.wait(1800), 0) << studio.said();  // four minutes of work beside a build
    lines_.clear();
    t_ = 0.5;
    eraser_ = false;
    add({{"kind", "check"}}, 0.3);
    return saved();
  }
  render::Image picture(const std::string& name) {
    render::Image image = readPng(scratch_ / (name + ".png"));
    if (const char* folder = std::getenv("ARGIL_SHOTS"))
      render::writePng(image, (fs::path(folder) / (name + ".png")).string());
    return image;
  }
  /// How much clay is seen, as a part of the picture, and where its middle is.
  struct Seen {
    double part = 0, x = 0, y = 0;
  };
  static Seen seen(const render::Image& image) {
    Seen s;
    for (int py = 80; py < 640; ++py)
      for (int px = 385; px < 945; ++px) {
        const uint8_t* p = image.pixel(px, py);
        if (!(p[0] > 90 && p[0] > p[2] + 25)) continue;
        s.part += 1;
        s.x += px;
        s.y += py;
      }
    s.x /= std::max(1.0, s.part);
    s.y /= std::max(1.0, s.part);
    s.part /= 560.0 * 560.0;
    return s;
  }
  double t_ = 0.5;
  std::string lines_;
  bool eraser_ = false;
};

TEST_P(PenOnClay, AHeavyHandDoesMoreThanALightOne) {
  const double x = middleX(), y = middleY();
  const Way way{{x - 60, y - 60}, {x + 60, y - 60}};
  for (const char* tool : {"C", "A", "W"}) {
    SCOPED_TRACE(tool);
    double done[2];
    for (const int heavy : {0, 1}) {
      const std::string file = block();
      const Saved before = saved();
      key(tool);
      drag(way, heavy ? 0.95 : 0.25);
      save();
      done[heavy] = std::abs(play(file).volume - before.volume);
    }
    EXPECT_GT(done[0], 1) << "a light hand does something";
    EXPECT_GT(done[1], 2 * done[0]) << "a light hand did " << done[0];
  }
}

// Each tool as it begins, by a light hand and by a heavy one, on clay that has something for each of them: a groove,
// two colours, a mask.
class EveryToolByPen : public PenOnClay {};

TEST_P(EveryToolByPen, ALightHandAndAHeavyOneDiffer) {
  const double x = middleX(), y = middleY();
  const std::string file = block();
  const auto tool = [&](std::string_view name) {
    key("P", {"ctrl"});
    for (const char c : name) add({{"kind", "text"}, {"character", int(c)}});
    key("enter");
    check();
  };
  tool("Carve");
  drag({{x - 60, y - 60}, {x + 20, y - 30}}, 0.9);
  tool("Paint");
  drag({{x - 30, y - 90}, {x + 70, y - 90}}, 0.9);
  tool("Mask");
  drag({{x + 20, y - 110}, {x + 50, y - 70}}, 0.9);
  // Those that work with a file of the person's have none here, and the clay has no materials to choose from.
  std::vector<const engine::ToolRow*> rows;
  for (const engine::ToolRow& row : engine::toolTable())
    if (row.file == engine::ToolFile::none && row.id != "material") rows.push_back(&row);
  screenshot("pen-tool-none");
  for (const engine::ToolRow* row : rows) {
    tool(row->name);
    for (const char* hand : {"light", "heavy"}) {
      drag({{x - 40, y - 45}, {x, y - 75}, {x + 60, y - 100}}, *hand == 'l' ? 0.25 : 0.95);
      screenshot("pen-tool-" + std::string(row->id) + "-" + hand);
      key("Z", {"ctrl"});
      check();
    }
  }
  (void)play(file);
  // A stroke that misses the clay turns the view, which would count as an effect.
  const render::Image still = part(readPng(scratch_ / "pen-tool-none.png"), 360, 80, 430, 690);
  const auto clay = [&](const std::string& name) {
    const render::Image whole = picture("pen-tool-" + name);
    EXPECT_LT(difference(still, part(whole, 360, 80, 430, 690)), 0.001) << name << ": the view turned";
    return part(whole, 430, 80, 945, 690);
  };
  const render::Image none = clay("none");
  EXPECT_GE(rows.size(), 28u);
  for (const engine::ToolRow* row : rows) {
    const std::string id(row->id);
    const render::Image light = clay(id + "-light"), heavy = clay(id + "-heavy");
    EXPECT_GT(difference(none, heavy), 3e-4) << id << ": a heavy hand does nothing";
    // The rim of a softened mask differs by less than a picture shows (PenPressure.EveryToolFollowsItAsItBegins sees
    // it).
    if (id != "blur_mask") {
      EXPECT_GT(difference(light, heavy), 1e-4) << id << ": the hand does not matter";
    }
  }
}

TEST_P(PenOnClay, TheOtherEndIsTheOppositeTool) {
  const double x = middleX(), y = middleY();
  const Way way{{x - 60, y - 60}, {x + 60, y - 60}};
  const std::string file = block();
  const Saved before = saved();
  key("A");
  eraser_ = true;
  drag(way, 0.9);
  save();
  const Saved carved = play(file);
  EXPECT_LT(carved.volume, before.volume - 15) << "the eraser of Add";
  key("A");
  drag(way, 0.9);
  save();
  EXPECT_GT(play(file).volume, carved.volume + 50) << "the tip of Add";
}

TEST_P(PenOnClay, ItsButtonTurnsAndMovesTheView) {
  const double x = middleX(), y = middleY();
  const std::string file = block();
  at("move", x, y, 0);
  add({{"kind", "wheel"}, {"x", x}, {"y", y}, {"dx", 0}, {"dy", -6}});  // All of it stays in the picture.
  screenshot("pen-before");
  drag({{x, y}, {x + 90, y - 20}}, 0, "right");
  screenshot("pen-turned");
  // The button, then the tip too.
  at("move", x, y, 0);
  at("press", x, y, 0, {{"button", "right"}});
  at("press", x, y, 0.5, {{"button", "left"}});
  for (int i = 1; i <= 20; ++i) at("move", x - 4 * i, y + 3 * i, 0.5);
  at("release", x - 80, y + 60, 0, {{"button", "left"}});
  at("release", x - 80, y + 60, 0, {{"button", "right"}});
  check();
  screenshot("pen-moved");
  save();
  const Saved before = saved();
  EXPECT_EQ(play(file).hash, before.hash) << "nothing was carved";
  const render::Image turned = picture("pen-turned"), moved = picture("pen-moved");
  EXPECT_GT(difference(picture("pen-before"), turned), 0.02);
  EXPECT_NEAR(seen(moved).x - seen(turned).x, -80, 25);
  EXPECT_NEAR(seen(moved).y - seen(turned).y, 60, 25);
}

// A click of the button opens a ring: zoom at the top, then clockwise redo, show all, move, size, undo.
TEST_P(PenOnClay, TheRingZoomsMovesSizesAndUndoes) {
  const double x = middleX(), y = middleY(), away = 57, side = away * 0.866, half = away / 2;
  const std::string file = block();
  const Saved before = saved();
  screenshot("ring-before");
  click(x, y, "right");
  add({{"kind", "screenshot"}, {"text", (scratch_ / "ring-open.png").string()}}, 0.1);
  drag({{x, y - away}, {x, y - away - 90}}, 0.5);  // Upwards: nearer.
  screenshot("ring-zoomed");
  click(x, y, "right");
  drag({{x, y + away}, {x - 60, y + away}}, 0.5);
  screenshot("ring-moved");
  save();
  EXPECT_EQ(play(file).hash, before.hash) << "nothing was carved";
  (void)picture("ring-open");
  const Seen first = seen(picture("ring-before")), zoomed = seen(picture("ring-zoomed")),
             moved = seen(picture("ring-moved"));
  EXPECT_GT(zoomed.part, 1.2 * first.part);
  EXPECT_LT(moved.x, zoomed.x - 20);

  const Way way{{x - 50, y - 40}, {x + 50, y - 40}};
  key("A");
  drag(way, 0.9);
  save();
  const double usual = play(block()).volume - before.volume;
  key("A");
  click(x, y, "right");
  drag({{x - side, y + half}, {x - side + 100, y + half}}, 0.5);  // Size: larger.
  drag(way, 0.9);
  save();
  EXPECT_GT(play(block()).volume - before.volume, 1.5 * usual);
  key("A");
  drag(way, 0.9);
  click(x, y, "right");
  click(x - side, y - half, "left");  // Undo.
  save();
  EXPECT_EQ(play(block()).hash, before.hash);
  key("A");
  drag(way, 0.9);
  click(x, y, "right");
  click(x - side, y - half, "left");
  click(x + side, y - half, "left");  // Redo: the ring is still there.
  click(x + 200, y + 200, "left");    // Beside it: put away.
  save();
  EXPECT_GT(play(block()).volume - before.volume, 50);
}

INSTANTIATE_TEST_SUITE_P(Sizes, HandOnClay, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, EveryToolByPen, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(Sizes, PenOnClay, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
