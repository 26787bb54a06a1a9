// Default settings in the window, by real mouse and keys: strokes are shallow and soft, guides do not take strokes,
// steps of the history stay.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clay/store/sampler.h"
#include "clay_on_screen.h"
#include "engine/saving/saved_document.h"

namespace argil::tests {
namespace {

class Defaults : public ClayOnScreen {
 protected:
  static constexpr double kTopMm = 20, kEdgeMm = 60;
  // What the file holds, after a save.
  engine::Document opened(Person& person) {
    (void)person.settled();
    person.key("ctrl+s");
    (void)person.settled();
    const engine::OpenedDocument file = engine::openDocument(scratch_ / "clay.argil");
    return *file.states[file.done].document;
  }
  // The highest place of the clay at x, y, from the world's z = 30 down.
  static double heightAt(const engine::Document& document, double x, double y) {
    const engine::Piece& piece = document.pieces.front();
    clay::Sampler sampler(piece.version);
    for (double z = 30; z > -20; z -= 0.02)
      if (sampler.trilinear(piece.version.grid().toVoxel(piece.pose.applyInverse(Vec3d(x, y, z)))) < 0) return z;
    return -20;
  }
  // Heights along y across the middle of a stroke that went along x.
  static std::vector<double> profile(const engine::Document& document, double x = 0) {
    std::vector<double> heights;
    for (double y = -15; y <= 15; y += 0.25) heights.push_back(heightAt(document, x, y));
    return heights;
  }
  static double steepest(const std::vector<double>& heights) {
    double most = 0;
    for (size_t i = 1; i < heights.size(); ++i) most = std::max(most, std::abs(heights[i] - heights[i - 1]) / 0.25);
    return most;
  }
  void lookFromAbove(Person& person) {
    person.key("7");
    (void)person.settled();
  }
  static Way across() { return {{middleX() - 70, middleY()}, {middleX() + 70, middleY()}}; }
  void shot(Person& person, const std::string& step) {
    offTheClay(person);
    person.shot(std::string("defaults-") + at().name + "-" + step);
  }
};

// In the settings of Carve, on the small screen: the switch "Soft"; the first row of the history.
constexpr double kSoftX = 321, kSoftY = 192, kHistoryTop = 110;
constexpr double kRadiusMm = 60 * 5.0 / 96;  // of the tools on a model of 60 mm

TEST_P(Defaults, CarveIsShallowAndSoftAndTheHardCutIsOneClickAway) {
  RunningStudio studio(arguments({block()}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  lookFromAbove(person);
  const std::vector<double> before = profile(opened(person));
  ASSERT_NEAR(before[60], kTopMm, 0.1);
  person.key("c");
  person.drag(across());
  shot(person, "01-carve");
  const std::vector<double> soft = profile(opened(person));
  const double depth = kTopMm - *std::min_element(soft.begin(), soft.end());
  EXPECT_GT(depth, 0.15 * kRadiusMm);
  EXPECT_LT(depth, 0.3 * kRadiusMm);
  EXPECT_LT(steepest(soft), 0.6) << "a smooth rim";
  person.key("ctrl+z");
  (void)person.settled();
  // "Soft" in the settings, as the second row.
  person.click(kSoftX, kSoftY);
  (void)person.settled();
  person.drag(across());
  shot(person, "02-hard");
  const std::vector<double> hard = profile(opened(person));
  EXPECT_GT(kTopMm - *std::min_element(hard.begin(), hard.end()), 1.2 * kRadiusMm) << "the tip is cut out";
  EXPECT_GT(steepest(hard), 1);
}

TEST_P(Defaults, ClayBuildsUpWithEveryPassAndCtrlDigs) {
  RunningStudio studio(arguments({block()}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  lookFromAbove(person);
  person.key("b");
  double last = kTopMm;
  for (int pass = 1; pass <= 3; ++pass) {
    person.drag(across());
    shot(person, "03-clay-" + std::to_string(pass));
    const std::vector<double> now = profile(opened(person));
    const double high = *std::max_element(now.begin(), now.end());
    EXPECT_GT(high - last, 0.05 * kRadiusMm) << "pass " << pass;
    EXPECT_LT(high - last, 0.25 * kRadiusMm) << "pass " << pass;
    EXPECT_LT(steepest(now), 0.5 * pass + 0.2);
    last = high;
  }
  for (int i = 0; i < 3; ++i) person.key("ctrl+z");
  (void)person.settled();
  person.keyDown("ctrl");
  person.drag(across());
  person.keyUp("ctrl");
  shot(person, "04-clay-ctrl");
  const std::vector<double> dug = profile(opened(person));
  EXPECT_LT(*std::min_element(dug.begin(), dug.end()), kTopMm - 0.05 * kRadiusMm);
}

TEST_P(Defaults, SmoothIsSeenAfterOnePass) {
  // A ridge 8 mm wide along x.
  std::ofstream(scratch_ / "script.json")
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.3}, {"block": {"size_mm": [60, 60, 40]}}],
            "strokes": [{"tool": "add", "radius_mm": 4, "path": [[0, -26, 0, 20], [1, 26, 0, 20]]}]})";
  const fs::path file = scratch_ / "clay.argil";
  ASSERT_EQ(argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string(), "--overwrite"}).code, 0);
  RunningStudio studio(arguments({file.string()}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  lookFromAbove(person);
  ASSERT_NEAR(heightAt(opened(person), 0, 0), 24, 0.1);
  shot(person, "05-ridge");
  person.key("s");
  person.drag(across(), 1.2);
  shot(person, "06-smoothed");
  const double after = heightAt(opened(person), 0, 0);
  EXPECT_LT(after, 24 - 0.4) << "a tenth of the ridge";
  EXPECT_GT(after, 21) << "and not all of it";
}

TEST_P(Defaults, AStrokeOverAFreshGuideIsAStroke) {
  for (const char* kind : {"add a line", "add a keep-out box", "add a ruler", "add a plane"}) {
    SCOPED_TRACE(kind);
    const fs::path home = scratch_ / ("home" + std::string(kind));
    fs::create_directories(home);
    RunningStudio studio(arguments({block()}), home);
    Person person(studio, at().scale);
    seesClay(person);
    lookFromAbove(person);
    const double x = middleX(), y = middleY();
    byPalette(person, kind);
    person.drag({{x - 50, y}, {x + 50, y}});
    (void)person.settled();
    shot(person, std::string("07-") + kind);
    const engine::Document before = opened(person);
    ASSERT_EQ(before.guides.size(), 1u);
    // On the line, or the box's edge, and on.
    person.drag({{x - 20, y}, {x + 20, y + 2}, {x + 40, y + 4}});
    const engine::Document after = opened(person);
    ASSERT_EQ(after.guides.size(), 1u);
    EXPECT_NE(after.pieces[0].version.hash(), before.pieces[0].version.hash()) << "no stroke";
    EXPECT_EQ(after.guides[0].pose.translation, before.guides[0].pose.translation);
    EXPECT_EQ(after.guides[0].sizeMm, before.guides[0].sizeMm);
    EXPECT_EQ(after.guides[0].pointsMm, before.guides[0].pointsMm);
    person.key("ctrl+q");
    for (int i = 0; i < 50 && studio.running(); ++i) person.pause(0.1);
  }
}

TEST_P(Defaults, AStrokeAfterGoingBackInHistoryKeepsTheLaterSteps) {
  RunningStudio studio(arguments({block()}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  lookFromAbove(person);
  const Saved begin = saved();
  for (const double y : {-40.0, 0.0, 40.0})
    person.drag({{middleX() - 60, middleY() + y}, {middleX() + 60, middleY() + y}});
  const Saved three = otherClay(person, begin);
  ASSERT_EQ(three.steps, begin.steps + 3);
  byPalette(person, "history");
  (void)person.settled();
  // Rows of 26 units below the title of the panel on the right; the first is the beginning.
  person.click(at().width / at().scale - 42 - 144, kHistoryTop + 26 * (begin.steps + 1) + 13);
  const Saved back = otherClay(person, three);
  person.drag({{middleX() - 60, middleY() - 80}, {middleX() + 60, middleY() - 80}});
  const Saved on = otherClay(person, back);
  shot(person, "08-history");
  EXPECT_EQ(on.steps, three.steps + 2) << "the later steps, \"Back to …\" and the stroke";
  person.key("ctrl+z");
  EXPECT_EQ(otherClay(person, on).hash, back.hash);
}

TEST_P(Defaults, SideBySideNoPanelCoversAnEye) {
  RunningStudio studio(arguments({block()}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  offTheClay(person);
  const render::Image panels = person.settled();
  byPalette(person, "side by side");
  offTheClay(person);
  person.pause(6);  // the hint fades
  const render::Image both = person.settled();
  keep(both, std::string("defaults-") + at().name + "-09-stereo");
  const double w = at().width / at().scale, h = at().height / at().scale;
  // Where the menu, the tools and the panels on the right stood there is the background alone.
  const auto lively = [&](const render::Image& image, double l, double t, double r, double b) {
    const render::Image cut = part(image, l, t, r, b);
    int most = 0;
    for (int i = 4; i < cut.width * 4; i += 4)
      for (int row = 0; row < cut.height; ++row)
        most = std::max(most, std::abs(int(cut.pixel(i / 4, row)[0]) - int(cut.pixel(i / 4 - 1, row)[0])));
    return most;
  };
  EXPECT_GT(lively(panels, 0, 0, 200, 28), 60) << "the menu";
  EXPECT_LT(lively(both, 0, 0, w / 2 - 20, 28), 30);
  EXPECT_LT(lively(both, w - 42, 80, w, h - 30), 80) << "the rail's signs; lines of the grid have 55";
  // As much clay in either half.
  const auto orange = [&](double from, double to) {
    size_t count = 0;
    const render::Image cut = part(both, from, 0, to, h);
    for (int py = 0; py < cut.height; ++py)
      for (int px = 0; px < cut.width; ++px) {
        const uint8_t* p = cut.pixel(px, py);
        count += p[0] > 150 && p[0] > p[2] + 30;
      }
    return double(count);
  };
  const double left = orange(0, w / 2), right = orange(w / 2, w);
  EXPECT_GT(left, 1000);
  EXPECT_NEAR(left / right, 1, 0.1);
  person.key("escape");
  (void)other(person, both, 0.1);
}

TEST_P(Defaults, ASimulatedDeviceIsMovedByTheMouseAndRestsByItself) {
  RunningStudio studio(arguments({block(), "--device", "simulated:touch"}), scratch_.path());
  Person person(studio, at().scale);
  seesClay(person);
  lookFromAbove(person);
  const Saved begin = saved();
  person.pause(3);
  person.key("ctrl+s");
  (void)person.settled();
  EXPECT_EQ(saved().hash, begin.hash) << "nobody moved it";
  person.key("c");
  person.move(middleX() - 60, middleY());
  person.pause(1);
  person.drag(across(), 2);
  const Saved after = otherClay(person, begin);
  EXPECT_LT(after.volume, begin.volume - 1);
  shot(person, "10-simulated");
}

INSTANTIATE_TEST_SUITE_P(Sizes, Defaults, ::testing::Values(kSmallScreen), nameOf);

}  // namespace
}  // namespace argil::tests
