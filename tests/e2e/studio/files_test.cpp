// Models come in as they are asked about, pieces are copied, and what was done is said. By real mouse and keys, in a
// real window.

#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "tests/e2e/support/screen.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

class Files : public OnScreen {
 protected:
  render::Image shot(Person& person, const std::string& step) {
    return person.shot(std::string("files-") + at().name + "-" + step);
  }
  static bool appears(const fs::path& file) {
    for (int i = 0; i < 1200; ++i) {
      if (fs::exists(file)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  // What the document holds, by a copy that is saved and looked at.
  Json saved(Person& person, const std::string& name) {
    const fs::path file = scratch_ / (name + ".argil");
    fs::remove(file);
    byPalette(person, "save a copy without history");
    person.ready();
    person.key("ctrl+a");
    person.type(file.string());
    person.key("enter");
    if (!appears(file)) {
      shot(person, "failed-" + name);
      throw std::runtime_error("no copy was saved: " + name);
    }
    const Outcome o = argil({"inspect", file.string(), "--json"});
    EXPECT_EQ(o.code, 0) << o.err;
    const Json json = Json::parse(o.out, nullptr, false);
    return json.is_object() && json.contains("pieces") ? json["pieces"] : Json::array();
  }
  // Until the document has so many pieces: imports take their time.
  Json pieces(Person& person, const std::string& name, size_t count) {
    Json now;
    for (int i = 0; i < 20; ++i) {
      now = saved(person, name + std::to_string(i));
      if (now.size() == count) break;
      person.pause(1);
    }
    EXPECT_EQ(now.size(), count) << name;
    return now;
  }
  static std::array<double, 3> triple(const Json& json) { return json.get<std::array<double, 3>>(); }
  // Imports by keys alone: the path, Enter, and Enter for what is guessed.
  void import(Person& person, const fs::path& file, const std::string& step) {
    // A dialog dims all behind it; a busy machine takes its time to open one.
    const render::Image before = person.settled();
    person.key("ctrl+i");
    (void)other(person, before, 0.2);
    person.type(file.string());
    const render::Image typed = person.settled();
    person.key("enter");
    (void)other(person, typed, 0.01);
    (void)other(person, before, 0.2);
    const render::Image asked = shot(person, step);
    person.key("enter");
    (void)other(person, asked, 0.2);  // Nothing is dimmed any more.
  }
};

struct Kind {
  std::string file;
  double height;  ///< mm, as it stands when what is guessed is taken.
};

// The height of what is guessed; a bust, a scan in metres and a part in inches, each in two questions: which file, and
// is it right so?
TEST_P(Files, ModelsComeInUprightOnTheGroundAtTheirSize) {
  if (!realData()) GTEST_SKIP() << "ARGIL_DATA is not set";
  const fs::path data = realData();
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  size_t count = 0;
  double right = -1e9;
  for (const Kind& kind : {Kind{"mesh/nefertiti_lowres.obj", 495}, Kind{"mesh/stanford-bunny.obj", 154},
                           Kind{"mesh/featuretype.STL", 34.925}}) {
    import(person, data / kind.file, "0" + std::to_string(count + 1) + "-asked");
    const Json all = pieces(person, "import" + std::to_string(count), count + 1);
    ASSERT_EQ(all.size(), ++count);
    // Figures of a piece are its own millimetres: the first stands where they say, the others were moved beside it.
    const Json& skin = all.back()["surface"];
    const auto low = triple(skin["low_mm"]), high = triple(skin["high_mm"]);
    EXPECT_NEAR(high[2] - low[2], kind.height, 0.02 * kind.height) << kind.file;
    EXPECT_NEAR(low[2], 0, 0.02 * kind.height) << kind.file;
    right = std::max(right, high[0]);
  }
  person.move(middleX(), at().height / at().scale - 30);
  shot(person, "04-three-models");
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

// A new ball stands beside the block, is worked on and is selected: Delete takes it, and it alone.
TEST_P(Files, ANewPieceStandsBesideAndIsSelected) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  byPalette(person, "add a block");
  ASSERT_EQ(pieces(person, "block", 1).size(), 1u);
  byPalette(person, "add a ball");
  const Json two = pieces(person, "two", 2);
  shot(person, "21-beside");
  byPalette(person, "export STL");
  person.ready();
  person.key("ctrl+a");
  person.type("two");
  person.key("enter");
  ASSERT_TRUE(appears(scratch_ / "two.stl"));
  (void)person.settled();
  const Outcome o = argil({"inspect", (scratch_ / "two.stl").string(), "--json"});
  ASSERT_EQ(o.code, 0) << o.err;
  const Json mesh = Json::parse(o.out)["mesh"];
  EXPECT_EQ(mesh["bodies"], 2);
  const auto low = triple(mesh["low_mm"]), high = triple(mesh["high_mm"]);
  EXPECT_GT(high[0] - low[0], 120) << "a ball of 60 mm within a block of 60 mm";
  EXPECT_NEAR(low[2], -20, 0.5) << "on the ground of the block";
  EXPECT_NEAR(high[2], 40, 0.5);
  person.key("delete");
  const Json one = pieces(person, "one", 1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0]["name"], "Block");
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

TEST_P(Files, PiecesAreDuplicatedCutAndPastedAlsoInAnotherDocument) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  byPalette(person, "add a ball");
  const Json ball = pieces(person, "ball", 1);
  ASSERT_EQ(ball.size(), 1u);
  person.key("ctrl+d");
  const Json two = pieces(person, "two", 2);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[1]["name"], "Sphere 2");
  EXPECT_EQ(two[1]["hash"], ball[0]["hash"]) << "a copy has equal bits";
  shot(person, "31-duplicated");
  person.key("ctrl+z");
  EXPECT_EQ(pieces(person, "undone", 1).size(), 1u);
  person.key("ctrl+c");
  person.key("ctrl+v");
  EXPECT_EQ(pieces(person, "pasted", 2).size(), 2u);
  person.key("ctrl+x");  // what was pasted is selected
  EXPECT_EQ(pieces(person, "cut", 1).size(), 1u);
  const render::Image before = person.settled();
  person.key("ctrl+n");
  (void)other(person, before, 0.2);  // Everything behind the question is dimmed.
  person.type("d");
  (void)person.settled();
  person.key("ctrl+v");
  const Json elsewhere = pieces(person, "elsewhere", 1);
  ASSERT_EQ(elsewhere.size(), 1u);
  EXPECT_EQ(elsewhere[0]["hash"], ball[0]["hash"]);
  shot(person, "32-in-another-document");
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

// X between undo and redo: what was undone is still to be had, and undo takes back the stroke, not the mirror.
TEST_P(Files, SymmetryIsNoStepAndLeavesRedo) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  byPalette(person, "add a block");
  const Json block = pieces(person, "block", 1);
  ASSERT_EQ(block.size(), 1u);
  const double x = middleX(), y = middleY();
  const render::Image before = person.settled();
  person.key("c");
  person.drag({{x - 80, y - 60}, {x, y - 50}, {x + 60, y - 60}});
  person.move(x - 230, y + 250);
  (void)other(person, before, 0.001);
  const Json carved = pieces(person, "carved", 1);
  ASSERT_NE(carved[0]["hash"], block[0]["hash"]);
  person.key("ctrl+z");
  EXPECT_EQ(pieces(person, "undone", 1)[0]["hash"], block[0]["hash"]);
  person.key("x");
  person.ready();
  shot(person, "41-symmetry-on");
  person.key("ctrl+y");
  EXPECT_EQ(pieces(person, "redone", 1)[0]["hash"], carved[0]["hash"]) << "the switch took redo along";
  person.key("x");
  person.key("ctrl+z");
  EXPECT_EQ(pieces(person, "again", 1)[0]["hash"], block[0]["hash"]) << "undo took back the switch";
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

TEST_P(Files, TheThicknessUnderThePointerIsReadAndKept) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  byPalette(person, "add a block");
  ASSERT_EQ(pieces(person, "block", 1).size(), 1u);
  person.key("7");  // from above: 40 mm through
  person.move(middleX() - 230, middleY() + 250);
  const render::Image before = person.settled();
  byPalette(person, "measure the thickness");
  person.move(middleX(), middleY());
  (void)other(person, before, 0.0003);
  shot(person, "51-thickness-under-the-pointer");
  person.click(middleX(), middleY());
  person.move(middleX() - 230, middleY() + 250);
  (void)person.settled();
  shot(person, "52-thickness-kept");
  const fs::path file = scratch_ / "measured.argil";
  byPalette(person, "save a copy without history");
  person.ready();
  person.key("ctrl+a");
  person.type(file.string());
  person.key("enter");
  ASSERT_TRUE(appears(file));
  const Json json = Json::parse(argil({"inspect", file.string(), "--json"}).out, nullptr, false);
  ASSERT_TRUE(json.is_object());
  EXPECT_EQ(json["guides"], 1);
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

// What is asked of the palette by name is done: zoom, x-ray; and the dialog of a join says what it will cost.
TEST_P(Files, ZoomXrayAndTheCostOfAJoinAreSeen) {
  RunningStudio studio(arguments(), scratch_.path());
  Person person(studio, at().scale);
  (void)person.settled();
  byPalette(person, "add a block");
  ASSERT_EQ(pieces(person, "block", 1).size(), 1u);
  person.move(middleX() - 230, middleY() + 250);
  const render::Image before = person.settled();
  byPalette(person, "zoom in");
  const render::Image near = other(person, before, 0.01);
  byPalette(person, "zoom out");
  (void)other(person, near, 0.01);
  byPalette(person, "add a ball");
  ASSERT_EQ(pieces(person, "two", 2).size(), 2u);
  const render::Image two = person.settled();
  byPalette(person, "join");
  (void)other(person, two, 0.3);
  shot(person, "61-join-says-its-cost");
  person.key("escape");
  person.close();
  person.ready();
  person.type("d");
  EXPECT_EQ(studio.wait(60), 0) << studio.said();
}

INSTANTIATE_TEST_SUITE_P(Sizes, Files, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
