// What versions do not share is what the store gets back.

#include <gtest/gtest.h>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/store/unshared.h"

namespace argil::clay {
namespace {

Version dabbed(const Version& from, const Vec3d& at, Method method) {
  BrushStroke brush(from, Brush::of(method));
  brush.apply({at, at, 6});
  return brush.finish();
}

TEST(Unshared, IsWhatIsFreedWithAVersion) {
  Grid grid;
  grid.voxelMm = 1;
  const auto store = Store::make();
  Version old = makeSphere(store, grid, Vec3d::Zero(), 40);
  Version next = dabbed(old, {40, 0, 0}, Method::carve);
  next = dabbed(next, {0, 43, 0}, Method::add);
  const auto freed = [&] {
    while (store->collect()) {
    }
    return store->usage();
  };
  const Store::Usage both = freed();
  const VersionStats lost = unshared(old, next), fresh = unshared(next, old);
  EXPECT_GT(lost.bricks, 0u);
  EXPECT_LT(lost.bricks, old.stats().bricks / 4);
  EXPECT_EQ(next.stats().bricks - old.stats().bricks, fresh.bricks - lost.bricks);
  EXPECT_EQ(both.bricks, next.stats().bricks + lost.bricks);
  EXPECT_EQ(both.nodes, next.stats().nodes + lost.nodes);
  old = {};
  const Store::Usage one = freed();
  EXPECT_EQ(both.bricks - one.bricks, lost.bricks);
  EXPECT_EQ(both.nodes - one.nodes, lost.nodes);
  EXPECT_EQ(unshared(next, next).bytes(), 0u);
  const Version other = makeSphere(Store::make(), grid, Vec3d::Zero(), 40);
  EXPECT_EQ(unshared(next, other).bricks, next.stats().bricks);
}

}  // namespace
}  // namespace argil::clay
