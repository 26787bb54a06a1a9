// A person's way through the studio, in a real window, by real mouse and keys.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/e2e/support/screen.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

class Studio : public OnScreen {
 protected:
  Json report() const { return Json::parse(slurp(scratch_ / "report.json"), nullptr, false); }
};

// Volume and topology of a file that was exported, as `argil inspect` sees them.
Json inspected(const fs::path& file) {
  const Outcome o = argil({"inspect", file.string(), "--json"});
  EXPECT_EQ(o.code, 0) << o.err;
  return Json::parse(o.out, nullptr, false);
}

std::vector<std::array<double, 2>> wave(double x, double y, double width, double height) {
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i <= 24; ++i) points.push_back({x + width * i / 24, y + height * std::sin(i / 4.0)});
  return points;
}

TEST_P(Studio, FromAnEmptyWindowToThreeFiles) {
  const Screen s = at();
  RunningStudio studio(arguments({"--validate", "--report", "report.json", "--record", "events.jsonl"}),
                       scratch_.path());
  Person person(studio, s.scale);
  const auto shot = [&](const std::string& step) { return person.shot(std::string(s.name) + "-" + step); };
  const double x = middleX(), y = middleY();  // The middle of the block's upper face is a little above.
  shot("01-start");

  byPalette(person, "add a block");
  const render::Image block = shot("02-block");

  person.key("c");
  person.drag(wave(x - 110, y - 60, 190, 14));
  const render::Image carved = shot("03-carve");
  EXPECT_GT(difference(block, carved), 0.001);
  person.key("a");
  person.drag(wave(x - 60, y - 110, 130, 8));
  const render::Image added = shot("04-add");
  EXPECT_GT(difference(carved, added), 0.002);
  person.key("s");
  person.drag(wave(x - 110, y - 55, 190, 14));
  const render::Image smoothed = shot("05-smooth");
  EXPECT_GT(difference(added, smoothed), 0.0005);

  person.key("x");
  person.key("c");
  person.drag({{x + 60, y + 40}, {x + 20, y + 90}});
  const render::Image mirrored = shot("06-symmetry");
  person.key("x");
  EXPECT_GT(difference(smoothed, mirrored), 0.001);

  for (int i = 0; i < 3; ++i) person.key("ctrl+z");
  shot("07-undone");
  for (int i = 0; i < 3; ++i) person.key("ctrl+shift+z");
  shot("08-redone");

  // A plane where the clay is clicked; a stroke along it.
  byPalette(person, "add a plane");
  shot("09-placing");
  person.click(x - 40, y - 40);
  shot("10-plane");
  person.drag(wave(x - 90, y - 20, 150, 6));
  shot("11-along-the-plane");

  // A ball beside it, selected and worked on from now on; the block is chosen by a click and hidden.
  byPalette(person, "add a ball");
  const render::Image ball = shot("12-ball");
  // A click on the plane's border chooses the plane, and one beside everything nothing: where the plane stands and how
  // far the view has gone may differ on a busy machine. The ball fades when the block is worked on.
  const auto faded = [&](const render::Image& now) {
    const auto middle = [&](const render::Image& of) { return part(of, x + 80, y + 10, x + 130, y + 60); };
    return difference(middle(ball), middle(now)) > 0.5;
  };
  const std::array<std::array<double, 2>, 3> spots{{{-100, 60}, {-75, 105}, {-205, 30}}};
  bool chosen = false;
  for (size_t i = 0; i < spots.size() && !chosen; ++i) {
    person.click(x + spots[i][0], y + spots[i][1]);
    chosen = faded(shot("13-chosen"));
  }
  EXPECT_TRUE(chosen);
  person.key("h");
  shot("14-hidden");

  for (const std::string format : {"STL", "OBJ", "PLY"}) {
    byPalette(person, "export " + format);
    person.ready();
    person.key("ctrl+a");
    person.type("out");
    shot("15-export-" + format);
    person.key("enter");
    person.ready();
    shot("16-exported-" + format);
  }
  // Everything behind the question is dimmed.
  const render::Image exported = person.settled();
  person.close();
  for (int i = 0; i < 20 && difference(exported, person.settled()) <= 0.3; ++i) continue;
  shot("17-leaving");
  person.type("d");  // Exports keep the shape, not the document: it is asked about.
  EXPECT_EQ(studio.wait(20), 0) << studio.said();
  for (const char* name : {"out.stl", "out.obj", "out.ply"}) {
    const Json mesh = inspected(scratch_ / name);
    ASSERT_TRUE(mesh.is_object()) << name;
    EXPECT_TRUE(mesh["mesh"]["closed"].get<bool>()) << name << ": " << mesh.dump();
    EXPECT_EQ(mesh["mesh"]["bodies"], 1) << name;
    EXPECT_NEAR(mesh["mesh"]["volume_mm3"].get<double>(), 4.0 / 3 * 3.14159265 * 27000, 200)
        << name << ": the ball alone, the block is hidden";
  }
  const Json r = report();
  ASSERT_TRUE(r.is_object());
  EXPECT_GE(r["strokes"], 5);
  EXPECT_EQ(r["dropped_samples"], 0);
  if (r["validating"].get<bool>()) {
    EXPECT_EQ(r["validation_messages"].size(), 0u) << r["validation_messages"].dump(1);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Studio, ::testing::Values(kSmallScreen), nameOf);
INSTANTIATE_TEST_SUITE_P(LongSizes, Studio, ::testing::Values(kDenseScreen), nameOf);

}  // namespace
}  // namespace argil::tests
