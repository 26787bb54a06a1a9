// What a workbench says of the hand, and does for it.

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

TEST_F(WorkbenchTest, SaysWhatTheSystemGrantedTheServo) {
  ASSERT_TRUE(until([&] { return bench.touch(false).device == "pointer"; }));
  EXPECT_NE(bench.touch(false).grant, "");
}

// On a widget the tool touches; what is pressed there leaves no mark.
TEST_F(WorkbenchTest, CutsOnlyWhereItMay) {
  block();
  Tool tool;
  tool.radiusMm = 3;
  bench.setTool(tool);
  const uint64_t before = document()->pieces[0].version.hash();
  bench.setCutting(false);
  ASSERT_TRUE(rest());
  drag(2);
  ASSERT_TRUE(rest());
  EXPECT_EQ(document()->pieces[0].version.hash(), before);
  EXPECT_EQ(bench.snapshot()->done, 1u);
  bench.setCutting(true);
  ASSERT_TRUE(rest());
  bool cut = false;
  for (int i = 0; i < 20 && !cut; ++i) {
    drag(2);
    ASSERT_TRUE(rest());
    cut = document()->pieces[0].version.hash() != before;
  }
  EXPECT_TRUE(cut);
}

// A large piece comes from the helper, when nothing else happens that would look for it.
TEST_F(WorkbenchTest, ShowsALargePieceThatTheHelperMadeThoughNothingElseHappens) {
  clay::Grid grid;
  grid.voxelMm = 0.2;
  Piece ball;
  ball.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 40);
  ASSERT_GT(ball.version.stats().bricks, Surfaces::kMostOwnBricks) << "more than the edit thread makes itself";
  ASSERT_TRUE(rest());
  bench.edit("Add ball", [&ball](Document& d) { d.add(ball); });
  uint64_t shown = 0;
  EXPECT_TRUE(until([&] {
    for (const SurfaceChange& change : bench.takeSurfaces().pieces) shown += change.delta.changed.size();
    return shown > Surfaces::kMostOwnBricks;
  })) << shown;
}

}  // namespace
}  // namespace argil::engine
