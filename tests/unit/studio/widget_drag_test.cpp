// Drags in views from everywhere: what is held stays under the hand, and moves as it is allowed to.

#include <gtest/gtest.h>

#include <numbers>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/unit/studio/widget_rig.h"

namespace argil::studio {
namespace {

using engine::Guide;
using test::kHeight;
using test::kWidth;
using test::Random;
using test::Rig;

constexpr double kWindow = 1e-6;  // Of the window's height.

/// The half-edge between the two hands of a drag, far enough that it is one.
Vec3d screenOf(const Rig& rig, const Vec3d& p) {
  return rig.place(p) * kHeight;
}

TEST(WidgetDrag, WhatIsHeldStaysUnderTheRayWithoutAJump) {
  Random random(11);
  int planes = 0, frees = 0;
  for (int i = 0; i < 200; ++i) {
    Rig rig(random.view());
    Guide& plane = rig.addPlane(random.vector(20), random.vector());
    plane.pose.rotation = random.rotation();
    rig.state.gizmo = GizmoMode::move;
    const bool inPlane = i % 2 == 0;
    if (inPlane && !rig.has("move plane")) continue;
    World world = rig.world();
    std::optional<Handle> handle;
    for (const Handle& each : rig.widgets.handles(world))
      if (each.name == (inPlane ? "move plane" : "move")) handle = each;
    if (!handle) continue;
    // Somewhere on the handle, not in its middle.
    Vec3d grab = handle->anchor;
    if (inPlane) grab = 0.5 * handle->points[0] + 0.3 * handle->points[1] + 0.2 * handle->points[2];
    const Vec3d start = plane.pose.translation, at = screenOf(rig, grab);
    const double off = inPlane ? 0 : 3;  // Units beside a dot.
    rig.hand(rig.mouse(at.x() + off, at.y()));
    rig.hand(rig.mouse(at.x() + off, at.y(), true));
    ASSERT_TRUE(rig.widgets.held());
    EXPECT_EQ(rig.edits, 0) << "a press alone moves nothing";
    if (!rig.widgets.drag()->handle().same(*handle)) continue;  // Another one is nearer to the eye or the hand there.
    const double dx = random.between(-60, 60), dy = random.between(-60, 60);
    if (std::hypot(dx, dy) < 4) continue;
    rig.hand(rig.mouse(at.x() + off + dx, at.y() + dy, true));
    const Guide& now = rig.selected();
    const Vec3d grabbed = grab + now.pose.translation - start;
    if (!rig.edits) continue;  // Beyond the horizon of the plane.
    EXPECT_LT((rig.place(grabbed) - rig.place(grab) - Vec3d(dx, dy, 0) / kHeight).norm(), kWindow);
    if (inPlane) {
      EXPECT_NEAR((now.pose.translation - start).dot(handle->axis), 0, 1e-9);
      ++planes;
    } else {
      EXPECT_NEAR((now.pose.translation - start).dot(rig.view.axes().forward), 0, 1e-9);
      ++frees;
    }
  }
  EXPECT_GT(planes, 30);
  EXPECT_GT(frees, 80);
}

TEST(WidgetDrag, AnArrowGoesAlongItsAxisAndItsTipWithTheHand) {
  Random random(12);
  int count = 0;
  for (int i = 0; i < 200; ++i) {
    Rig rig(random.view());
    Guide& plane = rig.addPlane(random.vector(20));
    plane.pose.rotation = random.rotation();
    rig.state.gizmo = GizmoMode::move;
    World world = rig.world();
    std::vector<Handle> arrows;
    for (const Handle& each : rig.widgets.handles(world))
      if (each.name == "move axis") arrows.push_back(each);
    for (const Handle& arrow : arrows) {
      const Vec3d start = rig.selected().pose.translation;
      const Vec3d grab = 0.3 * arrow.points[0] + 0.7 * arrow.points[1];
      const double way = random.between(5, 20) * (random.between(0, 1) < 0.5 ? -1 : 1);
      const int before = rig.edits;
      rig.drag(rig.at(grab), rig.at(grab + way * arrow.axis), 3);
      if (rig.edits == before) continue;  // Nearly along the view.
      const Vec3d moved = rig.selected().pose.translation - start;
      EXPECT_LT(moved.cross(arrow.axis).norm(), 1e-9) << "off its axis";
      EXPECT_NEAR(moved.dot(arrow.axis), way, 1e-6) << "the held point is under the ray";
      ++count;
      break;
    }
  }
  EXPECT_GT(count, 150);
}

TEST(WidgetDrag, TurnsAreExactAboutTheirAxis) {
  Random random(13);
  int count = 0;
  for (int i = 0; i < 200; ++i) {
    Rig rig(random.view());
    Guide& plane = rig.addPlane(random.vector(20));
    plane.pose.rotation = random.rotation();
    rig.state.gizmo = GizmoMode::rotate;
    World world = rig.world();
    std::vector<Handle> rings;
    for (const Handle& each : rig.widgets.handles(world))
      if (each.name == "turn axis") rings.push_back(each);
    ASSERT_EQ(rings.size(), 3u);
    const Handle& ring = rings[size_t(i % 3)];
    const auto before = rig.selected().pose;
    const Vec3d grab = ring.points[ring.points.size() / 2];
    if (std::abs(ScreenMap(rig.view, kWidth, kHeight).toEye(grab).dot(ring.axis)) < 0.2) continue;
    const double angle = random.between(0.1, 2.5) * (i % 2 ? 1 : -1);
    const Vec3d to = ring.anchor + Eigen::AngleAxisd(angle, ring.axis) * (grab - ring.anchor);
    rig.hand(rig.at(grab));
    rig.hand(rig.at(grab, true));
    if (!rig.widgets.held() || rig.widgets.drag()->handle().name != "turn axis" ||
        rig.widgets.drag()->handle().index != ring.index)
      continue;
    rig.hand(rig.at(to, true));
    rig.hand(rig.at(to));
    const auto after = rig.selected().pose;
    EXPECT_LT((after.translation - before.translation).norm(), 1e-12) << "the centre stays";
    const Eigen::Quaterniond turned = after.rotation * before.rotation.conjugate();
    EXPECT_LT((turned * ring.axis - ring.axis).norm(), 1e-9) << "the axis stays";
    const Eigen::Quaterniond wanted(Eigen::AngleAxisd(angle, ring.axis));
    EXPECT_LT(turned.angularDistance(wanted), 1e-6) << "the held point is under the ray";
    ++count;
  }
  EXPECT_GT(count, 80);
}

TEST(WidgetDrag, ARingSeenFromItsEdgeFollowsItsTangent) {
  Rig rig(render::View::named("front", Rig::box(100), kWidth / kHeight, render::Projection::orthographic));
  rig.addPlane();
  rig.state.gizmo = GizmoMode::rotate;
  const Handle ring = rig.handle("turn axis", 2);              // About z: a level line in this view.
  const Vec3d grab = ring.points[ring.points.size() * 3 / 4];  // Beside the middle, where it crosses another one.
  const Vec3d tangent = ring.axis.cross(grab - ring.anchor);   // As long as a turn by 1 rad moves it.
  rig.drag(rig.at(grab), rig.at(grab + 0.5 * tangent));
  EXPECT_NEAR(rig.selected().pose.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.5, 1e-6);
}

TEST(WidgetDrag, ConstrainedDragsGoInSteps) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  rig.constrain = true;
  rig.state.gizmo = GizmoMode::rotate;
  const Handle ring = rig.handle("turn axis", 0);
  const Vec3d grab = ring.points[ring.points.size() / 2];
  rig.drag(rig.at(grab), rig.at(ring.anchor + Eigen::AngleAxisd(0.6, ring.axis) * (grab - ring.anchor)));
  const double turned = rig.selected().pose.rotation.angularDistance(Eigen::Quaterniond::Identity());
  EXPECT_NEAR(turned, 30 * std::numbers::pi / 180, 1e-9);

  rig.document.guides[0].pose = {};
  rig.timeS += 10;
  rig.state.gizmo = GizmoMode::move;
  const Handle arrow = rig.handle("move axis", 0);
  const Vec3d from = 0.3 * arrow.points[0] + 0.7 * arrow.points[1];
  rig.drag(rig.at(from), rig.at(from + 13.7 * Vec3d::UnitX()));
  const double x = rig.selected().pose.translation.x();
  EXPECT_GT(x, 5);
  EXPECT_NEAR(x, std::round(x / 5) * 5, 1e-9) << "whole lines of the grid";
}

TEST(WidgetDrag, OneDragIsOneStepAndAPressIsNone) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  rig.document.guides[0].name = "Plane 1";
  const Handle arrow = rig.handle("along normal");
  const Vec3d grab = 0.5 * (arrow.points[0] + arrow.points[1]);
  rig.press(rig.at(grab));
  EXPECT_TRUE(rig.labels.empty());
  rig.drag(rig.at(grab), rig.at(grab + Vec3d(0, 0, 20)), 100);
  EXPECT_GT(rig.edits, 60);
  ASSERT_EQ(rig.labels.size(), 1u);
  EXPECT_EQ(rig.labels[0], "Move Plane 1");
  rig.timeS += 10;
  const Handle again = rig.handle("along normal");
  rig.drag(rig.at(again.points[1]), rig.at(again.points[1] + Vec3d(0, 0, 10)), 100);
  EXPECT_EQ(rig.labels.size(), 2u) << "the next drag is a step of its own";
}

TEST(WidgetDrag, EscapeRestoresAndTheRestOfTheDragDoesNothing) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane({1, 2, 3});
  const Handle arrow = rig.handle("along normal");
  const Vec3d grab = arrow.points[1];
  rig.hand(rig.at(grab));
  rig.hand(rig.at(grab, true));
  rig.hand(rig.at(grab + Vec3d(0, 0, 15), true));
  EXPECT_GT(rig.selected().pose.translation.z(), 10);
  World world = rig.world();
  rig.widgets.escape(world);
  EXPECT_TRUE(rig.selected().pose.translation.isApprox(Vec3d(1, 2, 3)));
  const int edits = rig.edits;
  EXPECT_TRUE(rig.hand(rig.at(grab + Vec3d(0, 0, 30), true))) << "still not the clay's";
  EXPECT_FALSE(rig.widgets.held());
  rig.hand(rig.at(grab + Vec3d(0, 0, 30)));
  EXPECT_EQ(rig.edits, edits);
  EXPECT_LE(rig.labels.size(), 1u);
  rig.widgets.escape(world);
  EXPECT_EQ(rig.state.selected, 0u);
}

TEST(WidgetDrag, AStylusDragsByItsTip) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  const Handle arrow = rig.handle("along normal");
  const Vec3d tip = 0.5 * (arrow.points[0] + arrow.points[1]) + Vec3d(0.5, 0, 0);
  EXPECT_FALSE(rig.hand(Rig::tip(tip + Vec3d(0, 30, 30))));
  EXPECT_TRUE(rig.hand(Rig::tip(tip)));
  rig.drag(Rig::tip(tip), Rig::tip(tip + Vec3d(3, 4, 12)));
  EXPECT_TRUE(rig.selected().pose.translation.isApprox(Vec3d(0, 0, 12), 1e-9)) << "along the normal alone";

  Guide point;
  point.kind = Guide::Kind::point;
  point.pose.translation = {30, 0, 0};
  rig.add(point);
  rig.drag(Rig::tip({31, 0, 0}), Rig::tip({41, -5, 8}));
  EXPECT_TRUE(rig.selected().pose.translation.isApprox(Vec3d(40, -5, 8), 1e-9)) << "free in all three";
}

TEST(WidgetDrag, LockedAndHiddenThingsAreNotGrabbed) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  const Vec3d grab = rig.handle("along normal").points[1];
  EXPECT_TRUE(rig.hand(rig.at(grab)));
  rig.selected().locked = true;
  EXPECT_FALSE(rig.hand(rig.at(grab)));
  rig.selected().locked = false;
  rig.selected().visible = false;
  EXPECT_FALSE(rig.hand(rig.at(grab)));
  World world = rig.world();
  render::Overlays overlays;
  rig.widgets.draw(world, overlays);
  EXPECT_TRUE(overlays.polylines.empty());
}

TEST(WidgetDrag, GuidesThatAreNotSelectedLeaveTheClayAlone) {
  Rig rig;
  rig.clayRadius = 10;
  Guide curve;
  curve.kind = Guide::Kind::curve;
  curve.pointsMm = {{-30, -20, 0}, {0, -20, 0}, {30, -20, 0}};
  const engine::Id id = rig.add(curve).id;
  rig.state.selected = 0;
  EXPECT_FALSE(rig.hand(rig.at({4, -20, 0}))) << "there is clay under it";
  EXPECT_TRUE(rig.hand(rig.at({25, -20, 0}))) << "beside the clay";
  EXPECT_FALSE(rig.hand(Rig::tip({25, -20, 0}))) << "a stylus cuts along it";
  rig.drag(rig.at({25, -20, 0}), rig.at({25, -20, 12}));
  EXPECT_EQ(rig.state.selected, id);
  EXPECT_NEAR(rig.selected().pointsMm[0].z(), 12, 1e-6);
}

TEST(WidgetDrag, HandlesGoBeforeBodiesAndTheNearestWins) {
  Rig rig(render::View::named("top", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  rig.hand(rig.at(Vec3d(20, 20, 0), true));
  rig.hand(rig.at(Vec3d(20, 20, 0)));
  const auto name = [&](const Vec3d& p, double dx, double dy = 0) {
    const Vec3d s = screenOf(rig, p);
    rig.hand(rig.mouse(s.x() + dx, s.y() + dy));
    rig.hand(rig.mouse(s.x() + dx, s.y() + dy, true));
    const std::string result = rig.widgets.held() ? std::string(rig.widgets.drag()->handle().name) : "";
    rig.hand(rig.mouse(s.x() + dx, s.y() + dy));
    return result;
  };
  EXPECT_EQ(name({20, 20, 0}, 0), "corner");
  EXPECT_EQ(name({20, 20, 0}, 7), "corner") << "generous";
  EXPECT_EQ(name({20, 20, 0}, 9), "");
  EXPECT_EQ(name({20, 20, 0}, 0, 6), "corner") << "though the rim is right under the hand";
  EXPECT_EQ(name({20, 12, 0}, 0), "body");
}

TEST(WidgetDrag, PiecesMoveAboutTheirMiddle) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  engine::Piece piece;
  piece.version = clay::makeSphere(clay::Store::make(), {}, Vec3d::Zero(), 5);
  piece.pose.translation = {5, 6, 7};
  rig.state.selected = rig.document.add(piece);
  rig.state.gizmo = GizmoMode::rotate;
  const Handle ring = rig.handle("turn axis", 2);
  EXPECT_TRUE(ring.anchor.isApprox(Vec3d(5, 6, 7)));
  rig.state.gizmo = GizmoMode::move;
  const Handle arrow = rig.handle("move axis", 1);
  rig.drag(rig.at(arrow.points[1]), rig.at(arrow.points[1] + Vec3d(0, -9, 0)));
  EXPECT_LT((rig.document.pieces[0].pose.translation - Vec3d(5, -3, 7)).norm(), 1e-6);
  EXPECT_EQ(rig.labels.back(), "Move " + rig.document.pieces[0].name);
  rig.state.gizmo = GizmoMode::scale;
  EXPECT_FALSE(rig.has("scale axis")) << "clay has no size of its own";
}

TEST(WidgetDrag, TurnsKeepTheirPivotWhereverTheThingsOwnPlaceIs) {
  Random random(14);
  for (int i = 0; i < 50; ++i) {
    const Vec3d pivot = random.vector(50), axis = random.vector().normalized(), body = random.vector(30);
    const double angle = random.between(-3, 3);
    const haptics::Pose before{random.vector(50), random.rotation()};
    Subject subject = before;
    turn(subject, pivot, axis, angle);
    const Vec3d wanted = pivot + Eigen::AngleAxisd(angle, axis) * (before.apply(body) - pivot);
    EXPECT_LT((std::get<haptics::Pose>(subject).apply(body) - wanted).norm(), 1e-9);
    Guide ruler;
    ruler.pointsMm = {pivot, before.apply(body)};
    subject = ruler;
    turn(subject, pivot, axis, angle);
    EXPECT_LT((std::get<Guide>(subject).pointsMm[1] - wanted).norm(), 1e-9);
    EXPECT_LT((std::get<Guide>(subject).pointsMm[0] - pivot).norm(), 1e-9);
  }
}

TEST(WidgetDrag, WhatIsLetGoIsShownWhereItIsUntilTheEditComesBack) {
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.addPlane();
  const Handle arrow = rig.handle("along normal");
  const engine::Document old = rig.document;
  rig.drag(rig.at(arrow.points[1]), rig.at(arrow.points[1] + Vec3d(0, 0, 20)));
  const engine::Document fresh = rig.document;
  rig.document = old;  // The snapshot of a frame that was faster than the edit thread.
  EXPECT_NEAR(rig.handle("along normal").anchor.z(), 20, 1e-6);
  rig.timeS += 2;  // It never came: it was refused.
  rig.hand(rig.mouse(5, 5));
  EXPECT_NEAR(rig.handle("along normal").anchor.z(), 0, 1e-6);
}

}  // namespace
}  // namespace argil::studio
