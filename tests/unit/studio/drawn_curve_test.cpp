// A curve drawn over the picture cuts the clay where it was drawn, or masks it.

#include "ui3d/studio/view/drawn_curve.h"

#include <cmath>

#include "clay/store/sampler.h"
#include "panels_rig.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr float kWide = 1280, kHigh = 720;

// A block of 40 × 30 × 20 mm about zero, seen from above; a unit of the window is 0.1 mm.
class Drawing : public testing::Test {
 protected:
  Drawing() {
    rig.bench.addBlock(Vec3d(40, 30, 20), 1, {.voxelMm = 1});
    rig.until([&] { return document().pieces.size() == 1 && rig.bench.idle(); }, "a block");
    render::View view;
    view.position = {0, 0, 200};
    view.target = Vec3d::Zero();
    view.up = Vec3d::UnitY();
    view.openingDegrees = 2 * std::atan(36.0 / 200) * 57.29577951308232;
    rig.camera.set(view);
    rig.state.shown.firstStart = false;
    rig.frames(2);
  }
  const engine::Document& document() { return *(rig.now = rig.bench.snapshot())->document; }
  std::optional<DrawnCurve>& curve() { return rig.state.drawnCurve; }
  bool follow() {
    rig.now = rig.bench.snapshot();
    Context c{rig.bench, *rig.now, rig.state, rig.camera, PanelsRig::renderer(), rig.timeS, 1 / 60.0, kWide, kHigh, 1};
    return followDrawnCurve(c);
  }
  // Millimetres of the world in the plane z = 0, in so many motions.
  void draw(const std::vector<std::array<double, 2>>& way, bool straight = false, int motions = 20) {
    const auto at = [](const std::array<double, 2>& mm) {
      return std::array<float, 2>{float(kWide / 2 + 10 * mm[0]), float(kHigh / 2 - 10 * mm[1])};
    };
    auto [x, y] = at(way.front());
    ASSERT_TRUE(curve()->press(rig.camera, x, y, kWide, kHigh));
    for (size_t i = 1; i < way.size(); ++i)
      for (int k = 1; k <= motions; ++k) {
        const double t = double(k) / motions;
        const auto p =
            at({way[i - 1][0] + t * (way[i][0] - way[i - 1][0]), way[i - 1][1] + t * (way[i][1] - way[i - 1][1])});
        curve()->move(rig.camera, p[0], p[1], kWide, kHigh, straight);
      }
    curve()->release(rig.camera, kWide, kHigh);
  }
  void apply() {
    curve()->apply = true;
    rig.until(
        [&] {
          follow();
          return !curve();
        },
        "begun");
    rig.until([&] { return rig.bench.idle(); }, "cut");
  }
  // Of the voxels within, at 1 mm.
  render::Box bounds(size_t piece = 0) {
    const clay::Version version = document().pieces[piece].version;
    clay::Sampler sampler(version);
    render::Box box;
    for (int x = -30; x <= 30; ++x)
      for (int y = -30; y <= 30; ++y)
        for (int z = -30; z <= 30; ++z)
          if (sampler.voxel({x, y, z}) < 0) box.add(version.grid().toWorld(Vec3d(x, y, z)));
    return box;
  }

  PanelsRig rig{kWide, kHigh};
};

TEST_F(Drawing, ALineFromLeftToRightKeepsWhatLiesAboveItAndUndoBringsAllBack) {
  const uint64_t whole = document().pieces[0].version.hash();
  const size_t steps = rig.bench.snapshot()->done;
  rig.run("piece.cut-curve");
  ASSERT_TRUE(curve());
  EXPECT_EQ(rig.camera.view().projection, render::Projection::orthographic) << "what is drawn goes straight through";
  draw({{-30, 5}, {30, 5}});
  ASSERT_TRUE(curve()->drawn());
  EXPECT_FALSE(curve()->closed);
  apply();
  EXPECT_EQ(rig.camera.view().projection, render::Projection::perspective);
  EXPECT_EQ(rig.bench.snapshot()->done, steps + 1);
  EXPECT_NEAR(bounds().min.y(), 5, 1.2);
  EXPECT_NEAR(bounds().max.y(), 15, 1.2);
  rig.run("edit.undo");
  rig.until([&] { return rig.bench.snapshot()->done == steps && rig.bench.idle(); }, "undone");
  EXPECT_EQ(document().pieces[0].version.hash(), whole);
}

TEST_F(Drawing, TheOtherSideStaysByItsKeyAndBothByTheButton) {
  rig.run("piece.cut-curve");
  draw({{-30, 5}, {30, 5}});
  rig.run("draw.side");
  EXPECT_EQ(curve()->kept(), -1);
  rig.run("draw.side");
  EXPECT_EQ(curve()->kept(), 1);
  const auto segment = [&](int i) {
    ImGuiWindow* window = ImGui::FindWindowByName("Settings");
    return rig.findId(window, ImHashStr("segment", 0, ImHashData(&i, sizeof i, ImHashStr("keep", 0, window->ID))));
  };
  rig.frames(2);
  ASSERT_FALSE(std::isnan(segment(1).x));
  rig.click(segment(1));
  EXPECT_EQ(curve()->kept(), 0);
  apply();
  ASSERT_EQ(document().pieces.size(), 2u);
  EXPECT_NEAR(bounds(0).min.y(), 5, 1.2);
  EXPECT_NEAR(bounds(1).max.y(), 5, 1.2);
}

TEST_F(Drawing, WhatComesBackToItsBeginningIsClosedAndItsInsideIsShown) {
  rig.run("piece.cut-curve");
  std::vector<std::array<double, 2>> circle;
  for (int i = 0; i <= 60; ++i) circle.push_back({8 * std::cos(i * 0.1047), 8 * std::sin(i * 0.1047)});
  draw(circle, false, 2);
  ASSERT_TRUE(curve()->drawn());
  EXPECT_TRUE(curve()->closed);
  // Triangles of both sides: the inside is the disc, together they fill a rectangle around the piece.
  double areas[2] = {0, 0};
  bool behind = false;
  for (size_t side = 0; side < 2; ++side) {
    const std::vector<Vec3d>& corners = curve()->sides.sides[side].trianglesMm;
    for (size_t i = 0; i + 2 < corners.size(); i += 3) {
      areas[side] += 0.5 * (corners[i + 1] - corners[i]).cross(corners[i + 2] - corners[i]).norm();
      if (corners[i].z() < 10) behind = true;
    }
  }
  EXPECT_FALSE(behind) << "the clay hides it";
  EXPECT_NEAR(areas[0], 3.14159 * 64, 4);
  EXPECT_GT(areas[1], 40 * 30 - areas[0]);
  EXPECT_LT(curve()->sides.sides[0].middleMm.head<2>().norm(), 2);
  apply();
  EXPECT_NEAR(bounds().max.x(), 8, 1.2);
  EXPECT_NEAR(bounds().min.y(), -8, 1.2);
}

TEST_F(Drawing, ShiftDrawsOneStraightLine) {
  rig.run("piece.cut-curve");
  draw({{-30, -10}, {0, 20}, {30, -10}}, true);
  EXPECT_EQ(curve()->pointsMm.size(), 2u);
}

TEST_F(Drawing, AClickAndEscapeCutNothing) {
  const size_t steps = rig.bench.snapshot()->done;
  rig.run("piece.cut-curve");
  draw({{0, 0}, {0.3, 0}});
  EXPECT_FALSE(curve()->drawn());
  curve()->apply = true;
  follow();
  EXPECT_TRUE(curve()) << "nothing is drawn yet";
  draw({{-30, 5}, {30, 5}});
  rig.run("draw.cancel");
  EXPECT_TRUE(follow());
  EXPECT_FALSE(curve());
  EXPECT_EQ(rig.camera.view().projection, render::Projection::perspective);
  rig.until([&] { return rig.bench.idle(); }, "idle");
  EXPECT_EQ(rig.bench.snapshot()->done, steps);
}

TEST_F(Drawing, ACurveThatWasDrawnBeforeTheViewTurnedCutsAlongTheOldView) {
  rig.run("piece.cut-curve");
  draw({{-30, 5}, {30, 5}});
  rig.camera.orbit(300, 100, kHigh, Vec3d::Zero());
  apply();
  EXPECT_NEAR(bounds().min.y(), 5, 1.2);
  EXPECT_NEAR(bounds().min.z(), -10, 1.2);
  EXPECT_NEAR(bounds().max.z(), 10, 1.2);
}

TEST_F(Drawing, TheCurveAndBothSidesAreSeen) {
  rig.run("piece.cut-curve");
  const auto build = [&] {
    World world(document(), rig.state, ScreenMap(rig.camera.view(), kWide, kHigh));
    return buildAll(world, document(), {});
  };
  EXPECT_TRUE(build().lines.empty());
  draw({{-30, 5}, {30, 5}});
  const Build all = build();
  EXPECT_FALSE(all.lines.empty());
  EXPECT_EQ(all.fills.size(), 3u) << "the wall and two sides";
  ASSERT_EQ(all.texts.size(), 2u);
  EXPECT_EQ(all.texts[0].text, "stays");
  EXPECT_GT(all.texts[0].at.y(), 5);
  EXPECT_EQ(all.texts[1].text, "goes");
  EXPECT_LT(all.texts[1].at.y(), 5);
}

TEST_F(Drawing, ALassoMasksAtOnceAndTheMaskedPartIsHiddenAndShown) {
  rig.run("piece.mask-lasso");
  ASSERT_TRUE(curve());
  const size_t steps = rig.bench.snapshot()->done;
  const uint64_t before = document().pieces[0].version.hash();
  draw({{-30, -20}, {0, -20}, {0, 20}, {-30, 20}});
  rig.until(
      [&] {
        follow();
        return rig.bench.snapshot()->done == steps + 1 && rig.bench.idle();
      },
      "masked");
  EXPECT_NE(document().pieces[0].version.hash(), before);
  ASSERT_TRUE(curve()) << "ready for the next";
  EXPECT_TRUE(curve()->pointsMm.empty());
  rig.run("draw.cancel");
  follow();
  const auto allowed = [&](const char* id) {
    rig.now = rig.bench.snapshot();
    Context c{rig.bench, *rig.now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, kWide, kHigh, 1};
    const Action* action = findAction(id);
    return !action->enabled || action->enabled(c);
  };
  EXPECT_FALSE(allowed("piece.mask-show"));
  const auto key = [&](const char* keys) {
    rig.now = rig.bench.snapshot();
    Context c{rig.bench, *rig.now, rig.state, rig.camera, PanelsRig::renderer(), 0, 0, kWide, kHigh, 1};
    return runShortcut(c, *parseShortcut(keys));
  };
  ASSERT_TRUE(key("Shift+H"));
  rig.until([&] { return document().pieces[0].hideMasked && rig.bench.idle(); }, "hidden");
  rig.frames(2);
  ASSERT_TRUE(allowed("piece.mask-show"));
  const ImVec2 show = rig.find("Settings", {"Show all", "button"});
  ASSERT_FALSE(std::isnan(show.x)) << "nobody sees that a part is hidden";
  ASSERT_TRUE(key("Ctrl+M"));  // The other half instead.
  rig.until([&] { return rig.bench.snapshot()->done == steps + 3 && rig.bench.idle(); }, "inverted");
  EXPECT_TRUE(document().pieces[0].hideMasked);
  rig.click(show);
  rig.until([&] { return !document().pieces[0].hideMasked && rig.bench.idle(); }, "shown");
  ASSERT_TRUE(key("Alt+M"));
  rig.until([&] { return rig.bench.snapshot()->done == steps + 5 && rig.bench.idle(); }, "cleared");
  EXPECT_EQ(document().pieces[0].version.hash(), before);
}

TEST_F(Drawing, ACurveGuideThatIsSelectedGoesToTheDialog) {
  rig.edit("Curve", [](engine::Document& d) {
    engine::Guide guide;
    guide.kind = engine::Guide::Kind::curve;
    guide.pointsMm = {Vec3d(-30, 0, 0), Vec3d(30, 0, 0)};
    d.add(guide);
  });
  rig.state.selected = document().guides[0].id;
  rig.run("piece.cut-curve");
  EXPECT_FALSE(curve());
  EXPECT_NE(ImGui::GetTopMostPopupModal(), nullptr);
}

}  // namespace
}  // namespace argil::studio
