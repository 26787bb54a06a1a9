// What each kind of widget does when its own handles are dragged, and how guides are placed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/contact/guides.h"
#include "tests/unit/studio/widget_rig.h"
#include "ui3d/studio/widgets/build.h"
#include "ui3d/studio/widgets/picture_labels.h"

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

/// Drags a handle by a way in the world.
void pull(Rig& rig, std::string_view name, int index, const Vec3d& by) {
  rig.timeS += 10;
  const Handle handle = rig.handle(name, index);
  const Vec3d grab = handle.form == Form::path ? handle.points[handle.points.size() / 2] : handle.points.back();
  rig.drag(rig.at(grab), rig.at(grab + by));
}

TEST(WidgetKinds, APlanesCornersSizeItAboutItsCentre) {
  Rig rig(kIso);
  rig.addPlane();
  pull(rig, "corner", 2, {10, 5, 0});
  EXPECT_NEAR(rig.selected().sizeMm.x(), 60, 1e-6);
  EXPECT_NEAR(rig.selected().sizeMm.y(), 50, 1e-6);
  EXPECT_TRUE(rig.selected().pose.translation.isZero(1e-9));
  EXPECT_EQ(rig.labels.back(), "Resize " + rig.selected().name);
}

TEST(WidgetKinds, APlaneTiltsAtItsEdges) {
  Rig rig(kIso);
  rig.addPlane();
  const Handle tilt = rig.handle("tilt", 0);
  const Vec3d grab = tilt.points[tilt.points.size() / 2];
  EXPECT_NEAR(grab.x(), 20, 1e-9);
  rig.drag(rig.at(grab), rig.at(tilt.anchor + Eigen::AngleAxisd(0.3, tilt.axis) * (grab - tilt.anchor)));
  EXPECT_NEAR((rig.selected().pose.rotation * Vec3d::UnitX()).z(), std::sin(0.3), 1e-6)
      << "the edge rises with the hand";
  EXPECT_NEAR((rig.selected().pose.rotation * Vec3d::UnitY()).z(), 0, 1e-9);
}

TEST(WidgetKinds, ALinesEndMovesAndTheOtherStays) {
  Rig rig(kFront);
  Guide line;
  line.kind = Guide::Kind::line;
  line.pose.translation = {5, 0, 0};
  rig.add(line);
  const Vec3d other = rig.handle("end", 0).anchor;
  EXPECT_TRUE(other.isApprox(Vec3d(5, 0, -20)));
  pull(rig, "end", 1, {15, 0, 5});
  EXPECT_LT((rig.handle("end", 0).anchor - other).norm(), 1e-9);
  EXPECT_LT((rig.handle("end", 1).anchor - Vec3d(20, 0, 25)).norm(), 1e-6);
  EXPECT_NEAR(rig.selected().sizeMm.z(), Vec3d(15, 0, 45).norm(), 1e-6);
}

TEST(WidgetKinds, ACurvesPointsAreDraggedInsertedAndDeleted) {
  Rig rig(kFront);
  Guide curve;
  curve.kind = Guide::Kind::curve;
  curve.pointsMm = {{-30, 0, 0}, {0, 0, 10}, {30, 0, 0}};
  rig.add(curve);
  pull(rig, "point", 1, {0, 0, 12});
  EXPECT_LT((rig.selected().pointsMm[1] - Vec3d(0, 0, 22)).norm(), 1e-6);
  EXPECT_TRUE(rig.selected().pointsMm[0].isApprox(Vec3d(-30, 0, 0)));

  const Handle between = rig.handle("insert", 1);
  const Vec3d grab = between.points[between.points.size() / 2];
  rig.press(rig.at(grab));
  EXPECT_EQ(rig.selected().pointsMm.size(), 3u) << "a click inserts nothing";
  rig.drag(rig.at(grab), rig.at(grab + Vec3d(0, 0, -15)));
  ASSERT_EQ(rig.selected().pointsMm.size(), 4u);
  EXPECT_LT((rig.selected().pointsMm[2] - grab - Vec3d(0, 0, -15)).norm(), 0.05);
  EXPECT_EQ(rig.labels.back(), "Insert a point in " + rig.selected().name);

  World world = rig.world();
  EXPECT_TRUE(rig.widgets.removePoint(world)) << "the one that was dragged last";
  EXPECT_EQ(rig.selected().pointsMm.size(), 3u);
  EXPECT_FALSE(rig.widgets.removePoint(world));
  rig.timeS += 10;
  rig.hand(rig.mouse(2, 2));
  pull(rig, "point", 0, {-5, 0, 0});
  EXPECT_TRUE(rig.widgets.removePoint(world));
  pull(rig, "point", 0, {-5, 0, 0});
  EXPECT_FALSE(rig.widgets.removePoint(world)) << "two points are a curve, one is none";
}

TEST(WidgetKinds, CurvesAreDrawnThroughTheirPoints) {
  const std::vector<Vec3d> points{{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 3}};
  for (const bool closed : {false, true}) {
    std::vector<size_t> starts;
    const auto samples = sampleCurve(points, closed, &starts);
    ASSERT_EQ(starts.size(), closed ? 5u : 4u);
    for (size_t i = 0; i < points.size(); ++i) EXPECT_LT((samples[starts[i]] - points[i]).norm(), 1e-3) << i << closed;
    if (closed) {
      EXPECT_LT((samples.back() - points[0]).norm(), 1e-3);
    }
  }
  EXPECT_EQ(sampleCurve({{1, 2, 3}}, false).size(), 1u) << "haptics refuses it, the eye does not";
}

TEST(WidgetKinds, ABoxesFaceMovesAlone) {
  Rig rig(kIso);
  Guide box;
  box.kind = Guide::Kind::keepOutBox;
  box.sizeMm = {40, 30, 20};
  rig.add(box);
  pull(rig, "face", 1, {10, 0, 0});
  EXPECT_NEAR(rig.selected().sizeMm.x(), 50, 1e-6);
  EXPECT_NEAR(rig.selected().pose.translation.x(), 5, 1e-6);
  EXPECT_NEAR(rig.handle("face", 0).anchor.x(), -20, 1e-6) << "the opposite one stays";
  pull(rig, "face", 1, {-200, 0, 0});
  EXPECT_GT(rig.selected().sizeMm.x(), 0);
}

TEST(WidgetKinds, RulersAndAnglesSayWhatTheyMeasure) {
  Rig rig(kFront);
  Guide ruler;
  ruler.kind = Guide::Kind::ruler;
  ruler.pointsMm = {{0, 0, 0}, {30, 0, 40}};
  rig.add(ruler);
  Guide angle;
  angle.kind = Guide::Kind::angle;
  angle.pointsMm = {{10, 0, 0}, {0, 0, 0}, {0, 0, 25}};
  rig.add(angle);
  World world = rig.world();
  std::vector<std::string> texts;
  for (const auto& label : rig.widgets.labels(world)) texts.push_back(label.text);
  EXPECT_NE(std::find(texts.begin(), texts.end(), "50.00 mm"), texts.end());
  EXPECT_NE(std::find(texts.begin(), texts.end(), "90.0°"), texts.end());
  EXPECT_EQ(lengthText(0.0123), "12.3 µm");
  EXPECT_EQ(lengthText(12345), "12.345 m");
}

TEST(WidgetKinds, GizmoScalesWhatHasASize) {
  Rig rig(kIso);
  rig.addPlane();
  rig.state.gizmo = GizmoMode::scale;
  const Handle x = rig.handle("scale axis", 0);
  const double length = x.points[0].norm();
  rig.drag(rig.at(x.points[0]), rig.at(1.5 * x.points[0]));
  EXPECT_NEAR(rig.selected().sizeMm.x(), 60, 1e-5);
  EXPECT_NEAR(rig.selected().sizeMm.y(), 40, 1e-9);
  EXPECT_GT(length, 0);
  rig.timeS += 10;
  const Handle all = rig.handle("scale", -1);
  const Vec3d grab = all.points[6];
  rig.drag(rig.at(grab), rig.at(2 * grab));
  EXPECT_GT(rig.selected().sizeMm.y(), 70);
  EXPECT_NEAR(rig.selected().sizeMm.x() / rig.selected().sizeMm.y(), 1.5, 1e-5);
}

TEST(WidgetKinds, TheGizmoKeepsItsSizeInThePicture) {
  for (const double away : {1.0, 0.01, 100.0}) {
    Rig rig(kIso);
    rig.view.position = rig.view.target + away * (rig.view.position - rig.view.target);
    rig.addPlane();
    rig.state.gizmo = GizmoMode::rotate;
    const Handle ring = rig.handle("turn view");
    EXPECT_NEAR((rig.place(ring.points[0]) - rig.place(ring.anchor)).norm() * kHeight, 100, 2);
  }
}

TEST(WidgetKinds, TheSectionIsTheStudiosAndNoEdit) {
  Rig rig(kIso);
  rig.state.look.section = render::Section{{0, 0, 5}, Vec3d::UnitZ()};
  pull(rig, "along normal", 0, {0, 0, 12});
  EXPECT_EQ(rig.edits, 0);
  ASSERT_TRUE(rig.state.look.section);
  EXPECT_NEAR(rig.state.look.section->pointMm.z(), 17, 1e-6);
  ASSERT_TRUE(rig.state.section);
  EXPECT_NEAR(rig.state.section->pointMm.z(), 17, 1e-6);
  rig.timeS += 10;
  const Handle arrow = rig.handle("along normal");
  rig.hand(rig.at(arrow.points[1]));
  rig.hand(rig.at(arrow.points[1], true));
  rig.hand(rig.at(arrow.points[1] + Vec3d(0, 0, 20), true));
  World world = rig.world();
  rig.widgets.escape(world);
  EXPECT_NEAR(rig.state.look.section->pointMm.z(), 17, 1e-6);
}

TEST(WidgetKinds, SymmetryMovesByItsRim) {
  Rig rig(kIso);
  rig.clayRadius = 30;
  rig.document.symmetry.x = true;
  pull(rig, "along normal", 0, {8, 0, 0});
  EXPECT_NEAR(rig.document.symmetry.pose.translation.x(), 8, 1e-6);
  EXPECT_EQ(rig.labels.back(), "Move symmetry");
  EXPECT_FALSE(rig.hand(rig.at({8, 0, 0}))) << "the middle is the clay's";
}

TEST(WidgetKinds, TheWorkspaceBoxIsWhatTheDeviceReaches) {
  Rig rig(kIso);
  EXPECT_FALSE(rig.has("face"));
  rig.state.showWorkspaceBox = true;
  rig.state.workspace.scale = 0.5;
  EXPECT_TRUE(rig.handle("face", 1).anchor.isApprox(Vec3d(25, 0, 0))) << "half of 100 mm, by half";
  pull(rig, "face", 1, {25, 0, 0});
  EXPECT_NEAR(rig.state.workspace.scale, 1, 1e-6);
  ASSERT_FALSE(rig.workspaces.empty());
  EXPECT_NEAR(rig.workspaces.back().scale, 1, 1e-6) << "the hand gets it";
  pull(rig, "turn", 0, {5, 5, 0});
  EXPECT_GT(rig.state.workspace.pose.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.05);
  EXPECT_LT(rig.state.workspace.toWorld(Vec3d::Zero()).norm(), 1e-9) << "about its middle";
  EXPECT_EQ(rig.edits, 0);
}

// While a tool is in hand a drag is a stroke, also where a fresh guide lies.
TEST(WidgetKinds, ABrushInHandMovesGuidesByTheirHandlesAlone) {
  using Kind = engine::Guide::Kind;
  for (const Kind kind : {Kind::line, Kind::keepOutBox, Kind::ruler, Kind::plane, Kind::curve, Kind::angle}) {
    SCOPED_TRACE(int(kind));
    Rig rig(kIso);
    rig.document = engine::Document::of(clay::makeSphere(clay::Store::make(), clay::Grid{1.0}, Vec3d::Zero(), 20));
    engine::Guide guide;
    guide.kind = kind;
    if (kind == Kind::ruler || kind == Kind::curve) guide.pointsMm = {{-30, 0, 40}, {30, 0, 40}};
    if (kind == Kind::angle) guide.pointsMm = {{-30, 0, 40}, {0, 0, 40}, {0, 30, 40}};
    if (guide.pointsMm.empty()) guide.pose.translation = Vec3d(0, 0, 40);
    (void)rig.add(guide);
    World world = rig.world();
    size_t bodies = 0;
    const std::vector<Handle> handles = rig.widgets.handles(world);
    for (const bool clay : {true, false}) {
      rig.clayRadius = clay ? 500 : 0;  // all over the picture, or nowhere
      for (const Handle& each : handles) {
        if (!each.body || each.points.size() < 2) continue;
        ++bodies;
        const Vec3d on = 0.7 * each.points[0] + 0.3 * each.points[1];
        const bool nearHandle = std::any_of(handles.begin(), handles.end(), [&](const Handle& other) {
          return !other.body && std::any_of(other.points.begin(), other.points.end(), [&](const Vec3d& p) {
            return (rig.place(p) - rig.place(on)).norm() < 0.04;
          });
        });
        if (nearHandle) continue;
        rig.state.gizmo = GizmoMode::none;
        EXPECT_FALSE(rig.hand(rig.at(on, true))) << each.name << (clay ? " over clay" : " beside it");
        (void)rig.hand(rig.at(on, false));
      }
    }
    EXPECT_GT(bodies, 0u);
    EXPECT_EQ(rig.edits, 0);
  }
  // Its handles do, and with those of Move so does its body.
  Rig rig(kIso);
  rig.document = engine::Document::of(clay::makeSphere(clay::Store::make(), clay::Grid{1.0}, Vec3d::Zero(), 20));
  engine::Guide line;
  line.kind = Kind::line;
  line.pose.translation = Vec3d(0, 0, 40);
  (void)rig.add(line);
  const Vec3d end = rig.handle("end", 1).anchor;
  EXPECT_TRUE(rig.hand(rig.at(end, true)));
  (void)rig.hand(rig.at(end, false));
  rig.state.gizmo = GizmoMode::move;
  const Vec3d on = 0.75 * rig.handle("end", 1).anchor + 0.25 * rig.handle("end", 0).anchor;
  EXPECT_TRUE(rig.hand(rig.at(on, false)));
}

TEST(WidgetKinds, TheBedLiesBelowTheClayAndIsTheOneThatIsChecked) {
  Rig rig(kIso);
  rig.state.bedShown = true;
  rig.state.print.bedMm = {120, 110, 150};
  World world = rig.world();
  render::Overlays overlays;
  rig.widgets.draw(world, overlays);
  render::Box drawn;
  for (const auto& line : overlays.polylines)
    for (const Vec3d& p : line.pointsMm) drawn.add(p);
  EXPECT_LT((drawn.size() - Vec3d(120, 110, 150)).norm(), 1e-9);
  EXPECT_NEAR(drawn.min.z(), world.bounds.min.z(), 1e-9) << "on the ground";
  EXPECT_LT((drawn.centre() - world.bounds.centre()).head<2>().norm(), 1e-9);
  // Clay of 100 mm does not fit on 90: it begins at the bed's corner, as nested pieces do.
  const Vec3d middle = printBedMiddle(world.bounds, {90, 200, 50});
  EXPECT_NEAR(middle.x(), world.bounds.min.x() + 45, 1e-9);
  EXPECT_NEAR(middle.y(), world.bounds.centre().y(), 1e-9);
}

TEST(PictureLabels, CanBeReadInBothThemes) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const auto luminance = [&](const render::Colour& c) {
    return 0.2126 * linear(double(c.r)) + 0.7152 * linear(double(c.g)) + 0.0722 * linear(double(c.b));
  };
  for (const Theme theme : {Theme::dark, Theme::light}) {
    const render::Colour ground =
        theme == Theme::light ? render::Colour{1, 1, 1, 1} : render::Colour{20 / 255.f, 22 / 255.f, 26 / 255.f, 1};
    for (float r = 0; r <= 1; r += 0.25f)
      for (float g = 0; g <= 1; g += 0.25f)
        for (float b = 0; b <= 1; b += 0.25f) {
          const double ink = luminance(readableOn({r, g, b, 1}, theme)), back = luminance(ground);
          EXPECT_GE((std::max(ink, back) + 0.05) / (std::min(ink, back) + 0.05), 4.5) << r << ' ' << g << ' ' << b;
        }
  }
}

// Placing

TEST(WidgetPlace, APlaneTouchesTheClayWhereItIsClicked) {
  Rig rig(kFront);
  rig.clayRadius = 30;
  World world = rig.world();
  rig.widgets.place(world, "plane");
  EXPECT_TRUE(rig.widgets.placing());
  EXPECT_TRUE(rig.hand(rig.at({10, 0, 12}))) << "the clay is not touched meanwhile";
  rig.press(rig.at({10, 0, 12}));
  EXPECT_FALSE(rig.widgets.placing());
  ASSERT_EQ(rig.document.guides.size(), 1u);
  const Guide& plane = rig.document.guides[0];
  EXPECT_NEAR(plane.pose.translation.norm(), 30, 1e-9);
  EXPECT_TRUE(plane.axis().isApprox(plane.pose.translation.normalized(), 1e-9)) << "tangent";
  rig.hand(rig.mouse(3, 3));
  EXPECT_EQ(rig.state.selected, plane.id);
  EXPECT_EQ(rig.labels, std::vector<std::string>{"Add a plane"});
  EXPECT_TRUE(rig.widgets.click(world, rig.at({10, 0, 12}))) << "the same click, told twice";
  EXPECT_EQ(rig.document.guides.size(), 1u);
}

TEST(WidgetPlace, RulersByClicksOrByOneDrag) {
  for (const bool dragged : {false, true}) {
    Rig rig(kFront);
    rig.clayRadius = 30;
    World world = rig.world();
    rig.widgets.place(world, "ruler");
    if (dragged) {
      rig.drag(rig.at({-15, 0, 0}), rig.at({15, 0, 0}));
    } else {
      rig.press(rig.at({-15, 0, 0}));
      EXPECT_TRUE(rig.document.guides.empty());
      rig.hand(rig.at({15, 0, 0}));
      rig.press(rig.at({15, 0, 0}));
    }
    ASSERT_EQ(rig.document.guides.size(), 1u);
    EXPECT_NEAR((rig.document.guides[0].pointsMm[1] - rig.document.guides[0].pointsMm[0]).norm(), 30, 1e-6);
    EXPECT_NEAR(rig.document.guides[0].pointsMm[0].norm(), 30, 1e-9) << "on the clay";
  }
}

TEST(WidgetPlace, ThicknessGoesThroughTheClay) {
  Rig rig(kFront);
  rig.clayRadius = 30;
  World world = rig.world();
  rig.widgets.place(world, "thickness");
  rig.press(rig.at({10, 0, 12}));
  ASSERT_EQ(rig.document.guides.size(), 1u);
  const Guide& ruler = rig.document.guides[0];
  EXPECT_EQ(ruler.kind, Guide::Kind::ruler);
  EXPECT_NEAR((ruler.pointsMm[1] - ruler.pointsMm[0]).norm(), 60, 1e-6) << "a ball is as thick as it is wide";
}

TEST(WidgetPlace, ACurveEndsWithEnterAndClosesAtItsBeginning) {
  Rig rig(kFront);
  rig.clayRadius = 30;
  World world = rig.world();
  rig.widgets.place(world, "curve");
  rig.press(rig.at({-15, 0, 0}));
  EXPECT_FALSE(rig.widgets.finish(world)) << "one point is none";
  rig.press(rig.at({0, 0, 10}));
  rig.press(rig.at({15, 0, 0}));
  rig.press(rig.at({15, 0, -15}));
  EXPECT_TRUE(rig.widgets.removePoint(world)) << "the last one goes";
  EXPECT_TRUE(rig.widgets.finish(world));
  ASSERT_EQ(rig.document.guides.size(), 1u);
  EXPECT_EQ(rig.document.guides[0].pointsMm.size(), 3u);
  EXPECT_FALSE(rig.document.guides[0].closed);

  rig.widgets.place(world, "curve");
  rig.snapping = false;
  for (const Vec3d& p : {Vec3d(-5, 0, -20), Vec3d(5, 0, -20), Vec3d(0, 0, -12), Vec3d(-5, 0, -20)})
    rig.press(rig.at(p));
  ASSERT_EQ(rig.document.guides.size(), 2u);
  EXPECT_TRUE(rig.document.guides[1].closed);
  EXPECT_EQ(rig.document.guides[1].pointsMm.size(), 3u);
}

TEST(WidgetPlace, LineAngleAndPoint) {
  Rig rig(kFront);
  World world = rig.world();
  rig.widgets.place(world, "line");
  rig.press(rig.at({-10, 0, 0}));
  rig.press(rig.at({20, 0, 10}));
  ASSERT_EQ(rig.document.guides.size(), 1u);
  EXPECT_NEAR(std::abs(rig.document.guides[0].axis().dot(Vec3d(30, 0, 10).normalized())), 1, 1e-9);
  rig.widgets.place(world, "angle");
  rig.press(rig.at({-10, 0, 20}));
  rig.press(rig.at({0, 0, 20}));
  rig.press(rig.at({0, 0, 35}));
  ASSERT_EQ(rig.document.guides.size(), 2u);
  EXPECT_EQ(rig.document.guides[1].pointsMm.size(), 3u);
  rig.widgets.place(world, "point");
  rig.press(rig.at({-30, 0, 30}));
  ASSERT_EQ(rig.document.guides.size(), 3u);
  EXPECT_LT((rig.document.guides[2].pose.translation - Vec3d(-30, 0, 30)).norm(), 1e-6);
}

TEST(WidgetPlace, ABoxIsDraggedOrClicked) {
  Rig rig(kTop);
  World world = rig.world();
  rig.widgets.place(world, "box");
  rig.drag(rig.at({-10, -10, 0}), rig.at({20, 10, 0}));
  ASSERT_EQ(rig.document.guides.size(), 1u);
  EXPECT_NEAR(rig.document.guides[0].sizeMm.x(), 30, 1e-6);
  EXPECT_NEAR(rig.document.guides[0].sizeMm.y(), 20, 1e-6);
  EXPECT_NEAR(rig.document.guides[0].sizeMm.z(), 10, 1e-6);
  EXPECT_EQ(rig.document.guides[0].feel, Guide::Feel::keepOut);
  rig.widgets.place(world, "box");
  rig.press(rig.at({30, 30, 0}));
  ASSERT_EQ(rig.document.guides.size(), 2u);
  EXPECT_GT(rig.document.guides[1].sizeMm.minCoeff(), 5);
}

TEST(WidgetPlace, EscapeGivesUpAndPreviewsAreNotInTheDocument) {
  Rig rig(kFront);
  rig.clayRadius = 30;
  World world = rig.world();
  rig.widgets.place(world, "ruler");
  EXPECT_FALSE(rig.widgets.hint().empty());
  rig.press(rig.at({-15, 0, 0}));
  rig.hand(rig.at({15, 0, 0}));
  render::Overlays overlays;
  rig.widgets.draw(world, overlays);
  EXPECT_FALSE(overlays.polylines.empty());
  EXPECT_TRUE(rig.document.guides.empty());
  rig.widgets.escape(world);
  EXPECT_FALSE(rig.widgets.placing());
  EXPECT_EQ(rig.edits, 0);
  rig.widgets.place(world, "teapot");
  EXPECT_FALSE(rig.widgets.placing());
}

TEST(WidgetPlace, AClickSelectsGuidesAndPieces) {
  Rig rig(kFront);
  Guide ruler;
  ruler.kind = Guide::Kind::ruler;
  ruler.pointsMm = {{0, 0, 0}, {30, 0, 40}};
  const engine::Id id = rig.add(ruler).id;
  rig.state.selected = 0;
  World world = rig.world();
  world.pickThing = [](const Ray&) { return engine::Id(7); };
  EXPECT_TRUE(rig.widgets.click(world, rig.at({15, 0, 20})));
  EXPECT_EQ(rig.state.selected, id);
  EXPECT_TRUE(rig.widgets.click(world, rig.at({-30, 0, 20})));
  EXPECT_EQ(rig.state.selected, 7u);
  world.pickThing = nullptr;
  EXPECT_TRUE(rig.widgets.click(world, rig.at({-30, 0, 20}))) << "nothing is selected any more";
  EXPECT_EQ(rig.state.selected, 0u);
  EXPECT_FALSE(rig.widgets.click(world, rig.at({-30, 0, 20})));
}

// The hand

TEST(WidgetFeel, ADraggedPlaneMovesTheLock) {
  Rig rig(kIso);
  rig.addPlane().feel = Guide::Feel::lock;
  const auto lock = [&] {
    const auto felt = engine::felt(rig.selected(), 1);
    EXPECT_TRUE(felt && std::holds_alternative<haptics::LockToPlane>(felt->shape));
    return std::get<haptics::LockToPlane>(felt->shape);
  };
  EXPECT_NEAR(lock().point.z(), 0, 1e-12);
  pull(rig, "along normal", 0, {0, 0, 14});
  EXPECT_NEAR(lock().point.z(), 14, 1e-6);
  const Handle tilt = rig.handle("tilt", 0);
  const Vec3d grab = tilt.points[tilt.points.size() / 2];
  rig.drag(rig.at(grab), rig.at(tilt.anchor + Eigen::AngleAxisd(0.3, tilt.axis) * (grab - tilt.anchor)));
  EXPECT_NEAR(lock().normal.z(), std::cos(0.3), 1e-6);
  const haptics::Scene scene = engine::sceneOf(rig.document, {});
  ASSERT_EQ(scene.guides.size(), 1u);
  EXPECT_NO_THROW(scene.check());
}

}  // namespace
}  // namespace argil::studio
