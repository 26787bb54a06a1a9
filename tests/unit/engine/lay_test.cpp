#include "engine/text/lay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "engine/session/feel.h"

namespace argil::engine {
namespace {

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 20);
}

ScriptStroke down(std::vector<PathPoint> path, double pressMm) {
  ScriptStroke stroke{{"carve", 3, 1}, Drive::hand, std::move(path)};
  stroke.onto = Onto{Vec3d(0, 0, -2), pressMm};
  return stroke;
}

TEST(Lay, PutsTheBallsFrontBelowTheSurface) {
  const auto parts = lay(ball(), down({{0, {0, 0, 60}}, {1, {12, 0, 50}}}, 2));
  ASSERT_EQ(parts.size(), 1u);
  const LaidStroke& laid = parts[0];
  ASSERT_EQ(laid.stroke.path.size(), 2u);
  EXPECT_NEAR(laid.stroke.path[0].mm.z(), 20 - 2 + 3, 0.02);
  EXPECT_NEAR(laid.stroke.path[1].mm.z(), 16 - 2 + 3, 0.02);
  EXPECT_EQ(laid.stroke.path[1].mm.x(), 12);
  EXPECT_EQ(laid.stroke.path[1].timeS, 1);
  EXPECT_FALSE(laid.stroke.onto);
  EXPECT_EQ(laid.from, Vec3d(0, 0, 60));
  EXPECT_EQ(laid.to, Vec3d(12, 0, 50));
}

TEST(Lay, LeavesOutWhatMeetsNoClay) {
  const auto parts = lay(ball(), down({{0, {40, 0, 60}}, {1, {0, 0, 60}}, {2, {0, 21, 60}}, {3, {0, 0, -60}}}, 0));
  ASSERT_EQ(parts.size(), 1u);
  ASSERT_EQ(parts[0].stroke.path.size(), 1u);
  EXPECT_EQ(parts[0].stroke.path[0].timeS, 1);
  EXPECT_EQ(parts[0].to, Vec3d(0, 0, 60));
  EXPECT_TRUE(lay(clay::Version::empty(clay::Store::make(), clay::Grid()), down({{0, {0, 0, 60}}}, 0)).empty());
}

TEST(Lay, LiftsTheToolAtEdges) {
  // Two slabs, the lower one 12 mm below the upper: an edge at x = 0, and air beyond x = ±20.
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const auto store = clay::Store::make();
  const clay::Version upper = clay::makeBlock(store, grid, Vec3d(-10, 0, 20), Vec3d(20, 20, 8), 0);
  clay::BrushStroke brush(upper, clay::Brush::of(clay::Method::add));
  clay::Stamp stamp;
  stamp.radius = 8;
  stamp.a = grid.toVoxel({6, 0, 8});
  stamp.b = grid.toVoxel({16, 0, 8});
  brush.apply(stamp);
  std::vector<PathPoint> path;
  for (int x = -30; x <= 30; ++x) path.push_back({0.01 * x, Vec3d(x, 0, 60)});
  const auto parts = lay(brush.finish(), down(path, 1));
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(parts[0].from->x(), -20, 1);
  EXPECT_NEAR(parts[0].to->x(), 0, 1);
  for (const PathPoint& point : parts[0].stroke.path) EXPECT_NEAR(point.mm.z(), 24 - 1 + 3, 0.1);
  EXPECT_NEAR(parts[1].from->x(), 2, 1);
  for (const PathPoint& point : parts[1].stroke.path) EXPECT_LE(point.mm.z(), 12 - 1 + 3 + 0.1);
}

TEST(Lay, LeavesOtherStrokesAlone) {
  const ScriptStroke stroke{{"add", 3, 1}, Drive::tip, {{0, {1, 2, 3}}}};
  const auto parts = lay(ball(), stroke);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].stroke, stroke);
  EXPECT_FALSE(parts[0].from);
}

// Two balls with a gap between them: the hand comes from where the path was written, and goes back there to pass the
// gap, without a jump.
TEST(PlacePath, AHandLeavesTheClayWhereThePathMeetsNone) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const auto store = clay::Store::make();
  const clay::Version two = clay::combine(clay::makeSphere(store, grid, Vec3d(-30, 0, 0), 10),
                                          clay::makeSphere(store, grid, Vec3d(30, 0, 0), 10), clay::Combination::join);
  std::vector<haptics::HandPoint> points;
  for (int i = 0; i <= 90; ++i) {
    haptics::HandPoint point;
    point.timeS = 0.02 * i;
    point.position = Vec3d(i - 45, 0, 60);
    points.push_back(point);
  }
  PathPlacement placement;
  placement.onto = Vec3d(0, 0, -1);
  placement.pressMm = 0.5;
  const std::vector<haptics::HandPoint> laid = placePath(haptics::HandPath(points), two, 2, placement).points();
  EXPECT_NEAR(laid.front().position.z(), 60, 1e-9);
  EXPECT_NEAR(laid.back().position.z(), 60, 1e-9);
  double top = 0, least = 1e9;
  for (size_t i = 1; i < laid.size(); ++i) {
    EXPECT_LT((laid[i].position - laid[i - 1].position).norm(), 4) << i;
    if (std::abs(laid[i].position.x()) < 15) top = std::max(top, laid[i].position.z());
    if (std::abs(laid[i].position.x()) < 15) least = std::min(least, laid[i].position.z());
  }
  EXPECT_NEAR(top, 60, 1e-6) << "it passes the gap where it was written";
  EXPECT_GT(least, 12);
}

}  // namespace
}  // namespace argil::engine
