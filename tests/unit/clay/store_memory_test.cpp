// What a model costs beside its clay: a document may have a thousand of them.

#include <gtest/gtest.h>

#include <vector>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"

namespace argil::clay {
namespace {

constexpr uint64_t kMostOverhead = 100'000;  // bytes

Version ball(double radius, Precision precision = Precision::float32) {
  Grid grid;
  grid.voxelMm = 1;
  return makeSphere(Store::make(precision), grid, Vec3d::Zero(), radius);
}

void collectAll(Store& store) {
  while (store.collect()) {
  }
}

uint64_t overhead(const Version& version) {
  const Store::Usage usage = version.store()->usage();
  return usage.slabBytes - version.stats().bytes();
}

TEST(StoreMemory, ASmallModelTakesLittleBesideItsClay) {
  for (const Precision precision : {Precision::float32, Precision::fixed16}) {
    for (const double radius : {2.0, 6.0, 12.0, 20.0}) {
      const Version model = ball(radius, precision);
      // As often as a session looks.
      for (int i = 0; i < 3; ++i) collectAll(*model.store());
      EXPECT_LE(overhead(model), kMostOverhead + model.stats().bytes() / 4) << radius;
    }
  }
}

TEST(StoreMemory, AModelThatIsEditedHasStockWaitingForIt) {
  Version model = ball(60);
  collectAll(*model.store());
  const uint64_t born = model.store()->usage().slabBytes;
  BrushStroke stroke(model, Brush::of(Method::carve));
  // What is in stock is never taken from the system while the stroke goes on, once the collector has seen that there is
  // a stroke.
  uint64_t grownInStroke = 0;
  std::vector<Version> kept;  // as undo does: every dab needs memory that nobody has used yet
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.03 * i;
    const Vec3d at(60 * std::cos(angle), 60 * std::sin(angle), 0);
    const uint64_t before = model.store()->usage().slabBytes;
    stroke.apply({at, at, 6});
    kept.push_back(stroke.publish());
    if (i > 10) grownInStroke += model.store()->usage().slabBytes - before;
    collectAll(*model.store());
  }
  EXPECT_EQ(grownInStroke, 0u);
  model = stroke.finish();
  EXPECT_GT(model.store()->usage().slabBytes, born);
}

TEST(StoreMemory, CollectingIsAskedForWhenThereIsSomethingToFree) {
  Version model = ball(20);
  collectAll(*model.store());
  EXPECT_FALSE(model.store()->wantsCollecting());
  Editor editor(model);
  editor.setTile({0, 0, 0}, Tile::outside);
  Version other = editor.commit();
  other = {};
  EXPECT_TRUE(model.store()->wantsCollecting());
  collectAll(*model.store());
  EXPECT_FALSE(model.store()->wantsCollecting());
  EXPECT_EQ(model.store()->usage().versions, 1u);
}

}  // namespace
}  // namespace argil::clay
