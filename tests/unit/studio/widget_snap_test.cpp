#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/studio/widget_rig.h"

namespace argil::studio {
namespace {

using engine::Guide;
using render::View;
using test::kHeight;
using test::kWidth;
using test::Rig;

const View kIso = View::named("iso", Rig::box(100), kWidth / kHeight);
const View kTop = View::named("top", Rig::box(100), kWidth / kHeight, render::Projection::orthographic);
const View kFront = View::named("front", Rig::box(100), kWidth / kHeight, render::Projection::orthographic);

Guide pointAt(const Vec3d& p) {
  Guide guide;
  guide.kind = Guide::Kind::point;
  guide.pose.translation = p;
  return guide;
}

Guide rulerFrom(const Vec3d& a, const Vec3d& b) {
  Guide guide;
  guide.kind = Guide::Kind::ruler;
  guide.pointsMm = {a, b};
  return guide;
}

class WidgetSnap : public testing::Test {
 protected:
  /// Drags an end of the ruler to a place in the picture that is so many units beside `to`.
  Vec3d end(Rig& rig, const Vec3d& to, double dx, double dy = 0) {
    rig.timeS += 10;  // What settled is forgotten.
    rig.drag(rig.at(rig.handle("point", 1).anchor), [&] {
      const Vec3d s = ScreenMap(rig.view, kWidth, kHeight).project(to);
      return rig.mouse(s.x() + dx, s.y() + dy);
    }());
    return rig.selected().pointsMm[1];
  }
};

TEST_F(WidgetSnap, AFreePointGoesToPointsWhateverTheirDepth) {
  Rig rig(kIso);
  rig.snapping = true;
  rig.document.add(pointAt({10, 20, 30}));
  rig.add(rulerFrom({-30, 0, 0}, {0, -10, 0}));
  EXPECT_TRUE(end(rig, {10, 20, 30}, 9).isApprox(Vec3d(10, 20, 30), 1e-12));
  EXPECT_FALSE(end(rig, {10, 20, 30}, 12).isApprox(Vec3d(10, 20, 30), 1e-3)) << "beyond ten units";
  rig.snapping = false;
  EXPECT_FALSE(end(rig, {10, 20, 30}, 5).isApprox(Vec3d(10, 20, 30), 1e-3)) << "the key that turns it off";
  rig.snapping = true;
  rig.state.snapWidgets = false;
  EXPECT_FALSE(end(rig, {10, 20, 30}, 5).isApprox(Vec3d(10, 20, 30), 1e-3)) << "the setting";
}

TEST_F(WidgetSnap, LinesAndCurvesTakeTheNearestPlace) {
  Rig rig(kIso);
  rig.snapping = true;
  Guide line;
  line.kind = Guide::Kind::line;
  line.pose.translation = {0, 30, 0};
  rig.document.add(line);
  Guide curve;
  curve.kind = Guide::Kind::curve;
  curve.pointsMm = {{40, 0, 0}, {40, 20, 0}, {40, 40, 10}};
  rig.document.add(curve);
  rig.add(rulerFrom({-30, 0, 0}, {0, -10, 0}));
  const Vec3d onLine = end(rig, {0, 30, 17}, 5);
  EXPECT_NEAR(onLine.x(), 0, 1e-9);
  EXPECT_NEAR(onLine.y(), 30, 1e-9);
  EXPECT_NEAR(onLine.z(), 17, 3);
  const Vec3d onCurve = end(rig, {40, 12, 0}, 4);
  EXPECT_NEAR(onCurve.x(), 40, 1e-6);
  EXPECT_GT(onCurve.y(), 5);
}

TEST_F(WidgetSnap, APointGoesBeforeALineThatIsNearer) {
  Rig rig(kFront);
  rig.snapping = true;
  Guide line;
  line.kind = Guide::Kind::line;
  rig.document.add(line);
  rig.document.add(pointAt({1, 0, 10}));
  rig.add(rulerFrom({-30, 0, 0}, {30, 0, 30}));
  EXPECT_TRUE(end(rig, {0, 0, 10}, 1).isApprox(Vec3d(1, 0, 10), 1e-9));
}

TEST_F(WidgetSnap, OverClayAPointRestsOnIt) {
  Rig rig(kFront);
  rig.snapping = true;
  rig.clayRadius = 20;
  rig.add(rulerFrom({-30, 0, 0}, {30, 0, 30}));
  const Vec3d on = end(rig, {5, 0, 7}, 0);
  EXPECT_NEAR(on.norm(), 20, 1e-9);
  EXPECT_LT(on.y(), 0) << "on the side of the person";
}

TEST_F(WidgetSnap, RightAnglesFromTheOtherEnd) {
  Rig rig(kFront);
  rig.snapping = true;
  rig.state.look.grid = false;
  rig.add(rulerFrom({-30, 0, 0}, {30, 0, 30}));
  const Vec3d level = end(rig, {25, 0, 0}, 0, 6);
  EXPECT_NEAR(level.z(), 0, 1e-9);
  EXPECT_NEAR(level.x(), 25, 1e-6);
}

TEST_F(WidgetSnap, APlaneThatMovesAlongItsNormalGoesThroughPoints) {
  Rig rig(kIso);
  rig.snapping = true;
  rig.state.look.grid = false;
  rig.document.add(pointAt({25, 25, 20}));
  rig.addPlane();
  const Handle arrow = rig.handle("along normal");
  rig.drag(rig.at(arrow.points[1]), rig.at(arrow.points[1] + Vec3d(0, 0, 20.7)));
  EXPECT_TRUE(rig.selected().pose.translation.isApprox(Vec3d(0, 0, 20), 1e-9));
}

TEST_F(WidgetSnap, AnArrowStopsAtPlanesAndGridLines) {
  Rig rig(kIso);
  rig.snapping = true;
  Guide& wall = rig.addPlane({17.3, 0, 0}, Vec3d::UnitX());
  wall.locked = true;
  rig.add(pointAt({0, 0, 0}));
  rig.state.gizmo = GizmoMode::move;
  Handle arrow = rig.handle("move axis", 0);
  const Vec3d grab = 0.3 * arrow.points[0] + 0.7 * arrow.points[1];
  rig.drag(rig.at(grab), rig.at(grab + Vec3d(17.9, 0, 0)));
  EXPECT_NEAR(rig.selected().pose.translation.x(), 17.3, 1e-9) << "the plane, not the grid";
  rig.timeS += 10;
  rig.selected().pose.translation = Vec3d::Zero();
  rig.drag(rig.at(grab), rig.at(grab + Vec3d(-10.4, 0, 0)));
  EXPECT_NEAR(rig.selected().pose.translation.x(), -10, 1e-9) << "the grid";
}

TEST_F(WidgetSnap, TurnsStopAtRightAngles) {
  Rig rig(kIso);
  rig.snapping = true;
  rig.addPlane();
  rig.selected().pose.rotation = Eigen::AngleAxisd(0.4, Vec3d::UnitX());
  rig.state.gizmo = GizmoMode::rotate;
  const Handle ring = rig.handle("turn axis", 0);
  const Vec3d grab = ring.points[ring.points.size() / 2];
  rig.drag(rig.at(grab), rig.at(ring.anchor + Eigen::AngleAxisd(-0.36, ring.axis) * (grab - ring.anchor)));
  EXPECT_NEAR(rig.selected().axis().z(), 1, 1e-12);
}

TEST_F(WidgetSnap, WhatAttractsIsLit) {
  Rig rig(kIso);
  rig.snapping = true;
  rig.document.add(pointAt({10, 20, 30}));
  rig.document.guides[0].name = "Nose";
  rig.add(rulerFrom({-30, 0, 0}, {0, -10, 0}));
  rig.hand(rig.at({0, -10, 0}));
  rig.hand(rig.at({0, -10, 0}, true));
  rig.hand(rig.at({10, 20, 30}, true));
  const World world = rig.world();
  render::Overlays overlays;
  rig.widgets.draw(world, overlays);
  int lit = 0;
  for (const auto& line : overlays.polylines) lit += line.colour == widget_colours::kSnap;
  EXPECT_GT(lit, 0);
  bool named = false;
  for (const auto& label : rig.widgets.labels(world)) named = named || label.text.find("Nose") != std::string::npos;
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace argil::studio
