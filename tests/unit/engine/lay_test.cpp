#include "engine/lay.h"

#include <gtest/gtest.h>

#include "clay/primitives.h"
#include "clay/store.h"

namespace argil::engine {
namespace {

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 20);
}

ScriptStroke down(std::vector<PathPoint> path, double pressMm) {
  ScriptStroke stroke{{clay::Operation::carve, 3, 1}, Drive::hand, std::move(path)};
  stroke.onto = Onto{Vec3d(0, 0, -2), pressMm};
  return stroke;
}

TEST(Lay, PutsTheBallsFrontBelowTheSurface) {
  const LaidStroke laid = lay(ball(), down({{0, {0, 0, 60}}, {1, {12, 0, 50}}}, 2));
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
  const LaidStroke laid = lay(ball(), down({{0, {40, 0, 60}}, {1, {0, 0, 60}}, {2, {0, 21, 60}}, {3, {0, 0, -60}}}, 0));
  ASSERT_EQ(laid.stroke.path.size(), 1u);
  EXPECT_EQ(laid.stroke.path[0].timeS, 1);
  clay::Grid grid;
  EXPECT_TRUE(lay(clay::Version::empty(clay::Store::make(), grid), down({{0, {0, 0, 60}}}, 0)).stroke.path.empty());
}

TEST(Lay, LeavesOtherStrokesAlone) {
  const ScriptStroke stroke{{clay::Operation::add, 3, 1}, Drive::tip, {{0, {1, 2, 3}}}};
  const LaidStroke laid = lay(ball(), stroke);
  EXPECT_EQ(laid.stroke, stroke);
  EXPECT_FALSE(laid.from);
}

}  // namespace
}  // namespace argil::engine
