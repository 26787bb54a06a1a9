// What a new user tries in the first hour, by real mouse and keys.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "clay/whole/deform.h"
#include "engine/saving/saved_document.h"
#include "tests/e2e/hand/clay_on_screen.h"

namespace argil::tests {
namespace {

// The first number of a place in the settings of Carve, while several pieces are selected, on the small screen.
constexpr double kPlaceX = 236, kPlaceY = 500;
// The distance in the dialog of Offset.
constexpr double kDistanceX = 1000, kDistanceY = 366;

class FirstHour : public ClayOnScreen {
 protected:
  Json settings() const { return Json::parse(slurp(scratch_ / "argil" / "studio.json"), nullptr, false); }
  /// The command line without the word "studio".
  static std::vector<std::string> bare(const std::vector<std::string>& more) {
    std::vector<std::string> words = arguments(more);
    words.erase(words.begin());
    return words;
  }
};

TEST_P(FirstHour, AFileAloneOpensItsWindow) {
  const std::string file = block();
  {
    RunningStudio studio(bare({file}), scratch_.path());
    Person person(studio);
    seesClay(person);
    person.close();
    EXPECT_EQ(studio.wait(60), 0) << studio.said();
  }
  for (const std::string missing : {"nothing.argil", "./nothing", "folder/nothing"}) {
    const Outcome o = argil({missing});
    EXPECT_EQ(o.code, 2) << missing;
    EXPECT_NE(o.err.find("there is no such file"), std::string::npos) << o.err;
  }
  const Outcome verb = argil({"convrt"});
  EXPECT_EQ(verb.code, 2);
  EXPECT_EQ(verb.err.find("no such file"), std::string::npos) << "a verb that is mistyped is no file: " << verb.err;
}

TEST_P(FirstHour, AThemeOfTheCommandLineIsForOneStart) {
  const auto ground = [](const render::Image& image) {
    const uint8_t* p = image.pixel(image.width / 2, 5);  // The menu.
    return int(p[0]) + p[1] + p[2];
  };
  int own = 0;
  {
    RunningStudio studio(arguments(), scratch_.path());
    Person person(studio);
    own = ground(person.settled());
    person.close();
    ASSERT_EQ(studio.wait(60), 0) << studio.said();
  }
  {
    RunningStudio studio(arguments({"--theme", "light"}), scratch_.path());
    Person person(studio);
    EXPECT_GT(ground(person.shot("theme-light")), own + 200);
    person.close();
    ASSERT_EQ(studio.wait(60), 0) << studio.said();
  }
  EXPECT_EQ(settings()["theme"], "dark");
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio);
  EXPECT_NEAR(ground(person.settled()), own, 30);
}

// F held, then a drag with the button: the ring grows, the clay stays.
TEST_P(FirstHour, FAndADragSizeTheToolAndLeaveTheClay) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  const Saved before = saved();
  person.key("a");
  const auto grown = [&] {
    person.drag({{x - 60, y - 50}, {x + 60, y - 60}});
    offTheClay(person);
    const Saved now = otherClay(person, before);
    person.key("ctrl+z");
    person.ready();
    return now.volume - before.volume;
  };
  const double small = grown();
  for (const double side : {1.0, -1.0}) {
    person.move(x - 40 * side, y - 50);
    person.ready();
    person.keyDown("f");
    person.drag({{x - 40 * side, y - 50}, {x + 40 * side, y - 50}});
    person.keyUp("f");
    person.ready();
    person.shot("size-by-f");
    offTheClay(person);
    person.key("ctrl+s");
    (void)person.settled();
    EXPECT_TRUE(saved() == before) << "nothing was carved";
    if (side > 0) {
      EXPECT_GT(grown(), 1.5 * small) << "80 units to the right: e^0.5 times as large";
    } else {
      EXPECT_NEAR(grown() / small, 1, 0.25) << "and back";
    }
  }
}

// T, then a drag of the ring's upper right square: the piece is larger, by an exact operation of its own step.
TEST_P(FirstHour, TScalesThePiece) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const Saved before = saved();
  const double x = middleX(), y = middleY();
  person.key("t");  // Nothing is selected: the handles stand on the piece that is worked on.
  const render::Image handles = person.shot("scale-handles");
  // White squares on a ring of 50 units around the piece's middle.
  double best = 0;
  std::array<double, 2> square{x + 35, y - 35};
  for (double at = 20; at < 60; at += 1) {
    double white = 0;
    for (int dy = -3; dy <= 3; ++dy)
      for (int dx = -3; dx <= 3; ++dx) {
        const uint8_t* p = handles.pixel(int(x + at) + dx, int(y - at) + dy);
        white += p[0] > 235 && p[1] > 235 && p[2] > 235;
      }
    if (white > best) best = white, square = {x + at, y - at};
  }
  ASSERT_GT(best, 20) << "no handle is seen";
  person.drag({square, {square[0] + 35, square[1] - 35}});
  person.shot("scaled");
  const Saved now = otherClay(person, before);
  EXPECT_GT(now.volume, 2 * before.volume);
  EXPECT_EQ(now.steps, before.steps + 1);
}

// The box of T: the blue square on the block's top pulls that alone, with Ctrl the bottom too; one step each.
TEST_P(FirstHour, ASideOfTheBoxOfTStretchesThePieceAlongOneAxis) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const Saved before = saved();
  person.key("t");
  const auto squares = [](const render::Image& image) {
    std::vector<std::array<double, 2>> blue;
    for (int y = 80; y < 650; ++y)
      for (int x = 360; x < 1220; ++x) {
        const uint8_t* p = image.pixel(x, y);
        if (p[2] > 220 && p[0] < 110 && p[1] > 110 && p[1] < 175) blue.push_back({double(x), double(y)});
      }
    return blue;
  };
  // The middle of the upper one: the one below the block is faint.
  const auto top = [&](const render::Image& image) {
    const auto blue = squares(image);
    std::array<double, 2> sum{};
    double count = 0;
    for (const auto& [x, y] : blue)
      if (y < blue.front()[1] + 14) sum[0] += x, sum[1] += y, ++count;
    return std::array<double, 2>{sum[0] / std::max(1.0, count), sum[1] / std::max(1.0, count)};
  };
  const render::Image handles = until(person, [&](const render::Image& image) { return squares(image).size() > 30; });
  person.shot("stretch-handles");
  ASSERT_GT(squares(handles).size(), 30u) << "no handle is seen";
  const auto bounds = [&] {
    const Json surface = Json::parse(argil({"inspect", file, "--json"}).out, nullptr, false)["pieces"][0]["surface"];
    clay::BoxMm box;
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = surface["low_mm"][size_t(axis)];
      box.high[axis] = surface["high_mm"][size_t(axis)];
    }
    return box;
  };
  const clay::BoxMm was = bounds();
  const auto pulled = [&](double by, const std::string& name) {
    const auto square = top(until(person, [&](const render::Image& image) { return squares(image).size() > 30; }));
    person.move(square[0], square[1]);
    person.ready();
    person.press();
    for (int i = 1; i <= 5; ++i) {
      person.move(square[0], square[1] - by * i / 5);
      person.ready();
    }
    // The picture follows the hand before the clay is worked out.
    const render::Image dragged = person.shot(name);
    EXPECT_GT(difference(part(handles, 390, 100, 940, 600), part(dragged, 390, 100, 940, 600)), 0.02);
    person.release();
  };
  pulled(50, "stretch-dragged");
  const Saved longer = otherClay(person, before);
  EXPECT_EQ(longer.steps, before.steps + 1);
  const clay::BoxMm is = bounds();
  const double factor = (is.high.z() - is.low.z()) / (was.high.z() - was.low.z());
  EXPECT_GT(factor, 1.15);
  EXPECT_NEAR(is.low.z(), was.low.z(), 0.1) << "what lies opposite stays";
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(is.low[axis], was.low[axis], 0.1);
    EXPECT_NEAR(is.high[axis], was.high[axis], 0.1);
  }
  EXPECT_NEAR(longer.volume / before.volume, factor, 0.01 * factor);
  person.shot("stretched");
  person.key("ctrl+z");
  EXPECT_TRUE(otherClay(person, longer) == before) << "undone as one step";
  (void)until(person, [&](const render::Image& image) {
    return difference(part(handles, 390, 100, 940, 600), part(image, 390, 100, 940, 600)) < 0.02;
  });
  person.keyDown("ctrl");
  pulled(30, "stretch-both");
  person.keyUp("ctrl");
  (void)otherClay(person, before);
  const clay::BoxMm both = bounds();
  EXPECT_GT(both.high.z(), was.high.z() + 2);
  EXPECT_NEAR(both.high.z() + both.low.z(), was.high.z() + was.low.z(), 0.2) << "about the middle";
}

// A click selects, Ctrl+click adds; a typed place moves all of them.
TEST_P(FirstHour, ATypedPlaceMovesAllThatAreSelected) {
  std::ofstream(scratch_ / "script.json")
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 1}, {"block": {"size_mm": [40, 40, 30], "centre_mm": [-30, 0, 0]}}],
             "strokes": [{"operation": "cylinder", "name": "Other", "centre_mm": [30, 0, 0], "radius_mm": 20, "height_mm": 30}]})";
  const fs::path file = scratch_ / "clay.argil";
  ASSERT_EQ(argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string(), "--overwrite"}).code, 0);
  RunningStudio studio(arguments({file.string()}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const double x = middleX(), y = middleY();
  person.key("1");
  (void)person.settled();
  person.click(x + 110, y);
  person.ready();
  person.keyDown("ctrl");
  person.click(x - 110, y);
  person.keyUp("ctrl");
  person.ready();
  // The place of the one that was selected first, in its settings.
  person.click(kPlaceX, kPlaceY);
  person.click(kPlaceX, kPlaceY);
  person.ready();
  person.key("ctrl+a");
  person.type("70");
  person.key("tab");  // As good as Enter.
  offTheClay(person);
  person.shot("typed-place");
  person.key("ctrl+s");
  (void)person.settled();
  const engine::OpenedDocument saved = engine::openDocument(file);
  const engine::Document& document = *saved.states[saved.done].document;
  ASSERT_EQ(document.pieces.size(), 2u);
  for (const engine::Piece& piece : document.pieces) {
    const clay::BoxMm box = clay::boundsOf(piece.version);
    const Vec3d middle = piece.pose.apply(Vec3d((box.low + box.high) / 2));
    EXPECT_NEAR(middle.x(), piece.name == "Other" ? 70 : 10, 0.6) << piece.name;
    EXPECT_NEAR(middle.y(), 0, 0.6) << piece.name;
  }
  person.key("ctrl+z");
  (void)person.settled();
  person.key("ctrl+s");
  (void)person.settled();
  const engine::OpenedDocument back = engine::openDocument(file);
  for (const engine::Piece& piece : back.states[back.done].document->pieces)
    EXPECT_NEAR(
        (piece.pose.apply(Vec3d((clay::boundsOf(piece.version).low + clay::boundsOf(piece.version).high) / 2))).x(),
        piece.name == "Other" ? 30 : -30, 0.6)
        << "one step";
}

// The plane is seen with what goes, and moves by its arrow; Enter cuts.
TEST_P(FirstHour, ACutByPlaneIsSeenBeforeItIsDone) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const Saved before = saved();
  const render::Image whole = person.settled();
  const auto red = [](const render::Image& image) {
    size_t count = 0;
    for (int y = 100; y < 600; y += 2)
      for (int x = 390; x < 940; x += 2) {
        const uint8_t* p = image.pixel(x, y);
        count += p[0] > 90 && 10 * p[0] > 17 * p[1] && 10 * p[0] > 17 * p[2];
      }
    return count;
  };
  ASSERT_LT(red(whole), 100u);
  byPalette(person, "cut by plane");
  offTheClay(person);
  const render::Image half = person.shot("plane-half");
  EXPECT_GT(red(half), 2000u) << "what goes is red";
  person.key("tab");
  const render::Image other = person.shot("plane-other-half");
  EXPECT_GT(difference(part(half, 390, 100, 940, 600), part(other, 390, 100, 940, 600)), 0.05);
  person.key("escape");
  person.ready();
  EXPECT_LT(red(person.settled()), 100u);
  person.key("ctrl+s");
  (void)person.settled();
  EXPECT_TRUE(saved() == before) << "given up";
  byPalette(person, "cut by plane");
  person.key("enter");
  const Saved now = otherClay(person, before);
  EXPECT_NEAR(now.volume, before.volume / 2, 0.03 * before.volume);
  person.shot("plane-cut");
}

// A dialog leaves its preview in sight while it is open: it stands beside the picture's middle and dims nothing.
TEST_P(FirstHour, ADialogLeavesItsPreviewInSight) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  offTheClay(person);
  // The block spans 420 to 860 units; of it the left two thirds are in sight whatever a dialog is wide.
  const auto seen = [](const render::Image& image) { return part(image, 400, 120, 780, 600); };
  const auto orange = [](const render::Image& image) {
    size_t count = 0;
    for (int y = 0; y < image.height; y += 2)
      for (int x = 0; x < image.width; x += 2) {
        const uint8_t* p = image.pixel(x, y);
        count += p[0] > 150 && p[0] > p[2] + 30;
      }
    return count;
  };
  const render::Image before = person.settled();
  byPalette(person, "offset");
  // The palette, while it is still open, hides most of the clay.
  const auto previewed = [&](const render::Image& now) {
    return difference(seen(now), seen(before)) > 0.005 && orange(seen(now)) > 0.8 * double(orange(seen(before)));
  };
  const render::Image offset = until(person, previewed);
  person.shot("preview-offset");
  EXPECT_GT(double(orange(seen(offset))), 0.95 * double(orange(seen(before))));
  EXPECT_GT(difference(seen(offset), seen(before)), 0.005) << "the grown block is shown";
  person.key("escape");
  (void)until(person, [&](const render::Image& now) { return difference(now, before) < 0.02; });
  byPalette(person, "cut with pegs");
  const render::Image pegs = until(person, previewed);
  person.shot("preview-pegs");
  EXPECT_GT(double(orange(seen(pegs))), 0.85 * double(orange(seen(before))));
  EXPECT_GT(difference(seen(pegs), seen(before)), 0.005) << "pegs and plane are shown";
}

// An offset inwards draws what it will leave in the clay's place; where nothing is left the dialog says so and does
// nothing.
TEST_P(FirstHour, AnOffsetInwardsShowsWhatRemains) {
  const std::string file = block();  // 60 × 60 × 40 mm: nothing is left from 20 mm on.
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  offTheClay(person);
  const Saved before = saved();
  // Beside the dialog.
  const auto clay = [](const render::Image& image) {
    size_t count = 0;
    for (int y = 100; y < 680; ++y)
      for (int x = 360; x < 820; ++x) {
        const uint8_t* p = image.pixel(x, y);
        count += p[0] > 80 && p[0] > p[2] + 30;
      }
    return double(count);
  };
  const double whole = clay(person.settled());
  byPalette(person, "offset");
  (void)until(person, [&](const render::Image& now) { return clay(now) > 0.9 * whole; });
  const auto typed = [&](const std::string& mm) {
    person.click(kDistanceX, kDistanceY);
    person.click(kDistanceX, kDistanceY);
    person.ready();
    person.key("ctrl+a");
    person.type(mm);
    person.key("tab");
    person.ready();
  };
  typed("-2");
  const double two = clay(until(person, [&](const render::Image& now) { return clay(now) < 0.95 * whole; }));
  person.shot("inwards-2");
  typed("-10");
  const double ten = clay(until(person, [&](const render::Image& now) { return clay(now) < 0.7 * whole; }));
  person.shot("inwards-10");
  EXPECT_LT(two, 0.95 * whole);
  EXPECT_GT(two, 0.75 * whole);
  // 40 × 40 × 20 mm of 60 × 60 × 40: a little over a third of its faces.
  EXPECT_LT(ten, 0.6 * whole);
  EXPECT_GT(ten, 0.2 * whole);
  typed("-21");
  const auto warned = [](const render::Image& image) {  // In the colour of warnings, within the dialog.
    size_t count = 0;
    for (int y = 380; y < 470; ++y)
      for (int x = 840; x < 1215; ++x) {
        const uint8_t* p = image.pixel(x, y);
        count += p[0] > 180 && p[0] > p[2] + 80;
      }
    return count;
  };
  EXPECT_GT(warned(until(person, [&](const render::Image& now) { return warned(now) > 100; })), 100u);
  person.shot("inwards-nothing");
  person.key("enter");  // Nothing is done.
  (void)person.settled();
  person.key("ctrl+s");
  (void)person.settled();
  EXPECT_TRUE(saved() == before);
  typed("-10");
  EXPECT_GT(clay(until(person, [&](const render::Image& now) { return clay(now) > 0.9 * ten; })), 0.9 * ten);
  // The preview is what comes of it.
  const render::Image shown = person.settled();
  person.key("enter");
  const Saved left = otherClay(person, before);
  EXPECT_NEAR(left.volume, 40 * 40 * 20, 0.03 * 40 * 40 * 20);
  offTheClay(person);
  const auto alike = [&](const render::Image& now) {
    return difference(part(shown, 360, 100, 820, 600), part(now, 360, 100, 820, 600)) < 0.03;
  };
  EXPECT_TRUE(alike(until(person, alike)));
  person.shot("inwards-done");
}

// Alt+X: its switch is seen in the bar; where no guide is there to be seen, it says so.
TEST_P(FirstHour, TheKeyOfXrayIsSeen) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  offTheClay(person);
  const auto bar = [](const render::Image& image) { return part(image, 640, 30, 900, 72); };
  const render::Image before = person.settled();
  person.key("alt+x");
  const auto changed = [&](const render::Image& now) { return difference(bar(now), bar(before)) > 0.005; };
  const render::Image off = until(person, changed);
  person.shot("xray-off");
  EXPECT_TRUE(changed(off));
  EXPECT_GT(difference(part(off, 390, 540, 1240, 690), part(before, 390, 540, 1240, 690)), 0.01) << "a message";
  person.key("alt+x");
  const auto back = [&](const render::Image& now) { return difference(bar(now), bar(before)) < 0.001; };
  EXPECT_TRUE(back(until(person, back)));
}

// Menus opened by the mouse or by a tap of Alt take arrows and Enter.
TEST_P(FirstHour, MenusTakeArrowsAndEnter) {
  const std::string file = block();
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const Saved begin = saved();
  const double ball = std::numbers::pi / 6 * 60 * 60 * 60;
  // Clay: "Add a block", "Add a ball". By the mouse the first arrow marks the first row.
  offTheClay(person);
  const render::Image closed = person.settled();
  person.click(112, 14);
  (void)other(person, closed, 0.005);
  person.key("down");
  person.ready();
  person.key("down");
  person.shot("menu-marked");
  person.key("enter");
  const Saved one = otherClay(person, begin);
  EXPECT_NEAR(one.volume - begin.volume, ball, 0.02 * ball);
  // By Alt: File, Edit, Clay with the first row marked. Left goes back.
  offTheClay(person);
  person.keyDown("alt");
  person.keyUp("alt");
  person.ready();
  person.key("right");
  person.ready();
  person.key("right");
  person.ready();
  person.key("right");
  person.ready();
  person.key("left");
  person.ready();
  person.key("down");
  person.shot("menu-by-alt");
  person.key("enter");
  const Saved two = otherClay(person, one);
  // A ball again, twice as large beside more clay.
  EXPECT_NEAR(two.volume - one.volume, 8 * ball, 0.02 * 8 * ball);
  // Piece, the menu in it, and back: Join, of three pieces that stand apart, is asked about.
  person.keyDown("alt");
  person.keyUp("alt");
  person.ready();
  for (int i = 0; i < 3; ++i) {
    person.key("right");
    person.ready();
  }
  // Looks at the menus alone: messages below come and go.
  const auto menus = [](const render::Image& whole) { return part(whole, 0, 0, 640, 360); };
  const render::Image piece = person.settled();
  person.key("right");
  const render::Image inner =
      until(person, [&](const render::Image& now) { return difference(menus(now), menus(piece)) > 0.01; });
  person.key("left");
  const auto back = [&](const render::Image& now) { return difference(menus(now), menus(piece)) < 0.01; };
  EXPECT_TRUE(back(until(person, back)));
  person.key("right");
  (void)other(person, piece, 0.003);
  person.key("enter");
  (void)other(person, inner, 0.2);
  person.shot("menu-join");
  person.key("escape");
  (void)person.settled();
  // A second tap closes; Alt held for a drag turns the view and opens nothing.
  offTheClay(person);
  const render::Image bare = person.settled();
  for (int i = 0; i < 2; ++i) {
    person.keyDown("alt");
    person.keyUp("alt");
    person.ready();
  }
  EXPECT_LT(difference(person.settled(), bare), 0.002);
  person.keyDown("alt");
  person.drag({{middleX(), middleY()}, {middleX() + 60, middleY()}});
  person.keyUp("alt");
  const render::Image turned = other(person, bare, 0.02);
  EXPECT_LT(difference(part(turned, 0, 0, 340, 300), part(bare, 0, 0, 340, 300)), 0.01) << "no menu";
}

// A thing that is seen as a whole stays in the middle, whichever named view comes after which.
TEST_P(FirstHour, ViewKeysTurnAboutTheMiddleOfWhatIsSeen) {
  const std::string file = document(
      R"({"voxel_mm": 1}, {"block": {"size_mm": [60, 60, 74], "centre_mm": [300, -200, 80], "round_mm": 20}})");
  RunningStudio studio(arguments({file}), scratch_.path());
  Person person(studio);
  seesClay(person);
  const auto middle = [](const render::Image& image) {
    double sum = 0, count = 0;
    for (int y = 80; y < 690; y += 2)
      for (int x = 350; x < 1235; x += 2) {
        const uint8_t* p = image.pixel(x, y);
        if (p[0] > p[2] + 30) sum += x, ++count;
      }
    return count > 0 ? sum / count : 0;
  };
  for (const std::string first : {"0", "1", "3", "7", "ctrl+3"})
    for (const std::string then : {"1", "3", "7"}) {
      SCOPED_TRACE(first + " " + then);
      person.key(first);
      (void)person.settled();
      person.key("home");
      offTheClay(person);
      EXPECT_NEAR(middle(person.settled()), middleX(), 12);
      person.key(then);
      (void)person.settled();
      EXPECT_NEAR(middle(person.shot("view-" + first + "-" + then)), middleX(), 12);
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, FirstHour, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
