#include "ui3d/studio/view/cursor.h"

#include <gtest/gtest.h>

namespace argil::studio {
namespace {

using render::Cursor;
using render::View;

haptics::StylusSample sampleAt(const Vec3d& proxy) {
  haptics::StylusSample sample;
  sample.proxy = proxy;
  sample.device.translation = proxy - Vec3d(0, 0, 2);
  return sample;
}

TEST(Cursor, TheBallIsWhereItIsFeltAndAsLargeAsTheTool) {
  const View view = View::named("front", {}, 1);
  haptics::StylusSample sample = sampleAt({1, 2, 3});
  engine::Tool tool;
  tool.radiusMm = 4;
  Cursor cursor = makeCursor(sample, tool, view, {});
  EXPECT_EQ(cursor.positionMm, Vec3d(1, 2, 3)) << "at the proxy, not at the device";
  EXPECT_EQ(cursor.radiusMm, 4);
  EXPECT_FALSE(cursor.contact);
  EXPECT_TRUE(cursor.drop.isApprox(-Vec3d::UnitZ()));

  sample.flags = haptics::kTouching;
  sample.forceN = {0, 0, 1};
  CursorOptions options;
  options.dropAlongView = true;
  cursor = makeCursor(sample, tool, view, options);
  EXPECT_TRUE(cursor.contact);
  EXPECT_EQ(cursor.forceN, sample.forceN);
  EXPECT_TRUE(cursor.drop.isApprox(Vec3d::UnitY()));
}

TEST(Cursor, ASmallToolInAWideViewStaysVisible) {
  View view = View::named("front", {}, 1);
  engine::Tool tool;
  tool.radiusMm = 0.001;
  const double unit = view.heightAtTarget() / 720;
  EXPECT_NEAR(makeCursor(sampleAt(view.target), tool, view, {}).radiusMm, kLeastBallUnits * unit, 1e-9);
  const Vec3d farther = view.target + view.distance() * view.axes().forward;
  EXPECT_NEAR(makeCursor(sampleAt(farther), tool, view, {}).radiusMm, 2 * kLeastBallUnits * unit, 1e-9);
}

TEST(Cursor, TheShaftFollowsTheDeviceAndNeverHidesTheBall) {
  const View view = View::named("front", {}, 1);  // Looks along +y.
  haptics::StylusSample sample = sampleAt(Vec3d::Zero());
  const engine::Tool tool;
  EXPECT_TRUE(makeCursor(sample, tool, view, {}).shaft.isApprox(Vec3d::UnitZ()));
  sample.device.rotation = haptics::rotationBetween(Vec3d::UnitZ(), Vec3d::UnitX());
  EXPECT_TRUE(makeCursor(sample, tool, view, {}).shaft.isApprox(Vec3d::UnitX()));
  // At the eye, as a mouse is.
  sample.device.rotation = haptics::rotationBetween(Vec3d::UnitZ(), -Vec3d::UnitY());
  const Vec3d shaft = makeCursor(sample, tool, view, {}).shaft;
  EXPECT_GT(shaft.cross(Vec3d::UnitY()).norm(), 0.5);
  EXPECT_LT(shaft.y(), 0) << "still comes from the person";
}

TEST(Cursor, AMouseIsARingAndADotOnTheSurface) {
  const View view = View::named("top", {}, 1);
  engine::Tool tool;
  tool.radiusMm = 5;
  const Cursor cursor = pointerCursor({{1, 2, 3}, {0, 0, 2}}, tool, view, {});
  EXPECT_TRUE(cursor.flat) << "neither ball nor stylus over the work";
  EXPECT_EQ(cursor.radiusMm, 5);
  ASSERT_TRUE(cursor.footprint);
  EXPECT_EQ(cursor.footprint->pointMm, Vec3d(1, 2, 3));
  EXPECT_FALSE(cursor.contact);
}

TEST(Cursor, TheFootprintIsOnTheSurfaceThatHoldsTheTool) {
  const View view = View::named("front", {}, 1);
  engine::Tool tool;
  tool.radiusMm = 5;
  // Clay is everything below z = 0; rays that do not go down meet nothing.
  const PickSurface ground = [](const Vec3d& origin, const Vec3d& direction) -> std::optional<Cursor::Footprint> {
    if (!(direction.z() < 0) || origin.z() < 0) return {};
    return Cursor::Footprint{origin - origin.z() / direction.z() * direction, Vec3d::UnitZ()};
  };
  haptics::StylusSample sample = sampleAt({0, 0, 5});
  sample.flags = haptics::kTouching;
  sample.forceN = Vec3d(0.6, 0, 0.8);
  auto footprint = footprintOf(sample, tool, view, ground);
  ASSERT_TRUE(footprint);
  EXPECT_NEAR(footprint->pointMm.x(), -3.75, 1e-9) << "against the force";
  sample.flags = 0;
  footprint = footprintOf(sample, tool, view, ground);
  ASSERT_TRUE(footprint) << "free, close above: below it";
  EXPECT_NEAR(footprint->pointMm.x(), 0, 1e-9);
  EXPECT_FALSE(footprintOf(sampleAt({0, 0, 16}), tool, view, ground)) << "too far away";
}

TEST(Cursor, EachToolHasItsTint) {
  engine::Tool carve, add, smooth;
  add.id = "add";
  smooth.id = "smooth";
  EXPECT_FALSE(tintOf(carve) == tintOf(add));
  EXPECT_FALSE(tintOf(carve) == tintOf(smooth));
  EXPECT_FALSE(tintOf(add) == tintOf(smooth));
}

}  // namespace
}  // namespace argil::studio
