// Distances of second order: what is known before the passes begin.

#include "clay/field/renewal.h"

#include <gtest/gtest.h>

#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/brick_margins.h"
#include "clay/store/store.h"

namespace argil::clay {
namespace {

// Around a ball, beyond it and inside it, with the bricks of its surface and beside them: a tile among tiles is as it
// is when all around it is looked at.
TEST(Renewal, OfATileAmongTilesNothingIsKnownYet) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d(0.2, 0.1, 0.3), 20);
  Sampler field(ball);
  for (const bool withSurface : {true, false}) {
    std::vector<Coord> coords;
    for (int x = -7; x <= 6; ++x)
      for (int y = -7; y <= 6; ++y)
        for (int z = -7; z <= 6; ++z)
          if (withSurface || field.slot({x, y, z}).isTile()) coords.push_back({x, y, z});
    int among[2] = {};
    const auto solved = [&](bool shortcut) {
      Renewal renewal(coords, ball.grid().band, 1);
      float broad[kBroadSize] = {};
      for (size_t i = 0; i < coords.size(); ++i) {
        const Slot slot = field.slot(coords[i]);
        if (shortcut && isAmongTiles(field, coords[i], slot)) {
          ++among[slot.tile() == Tile::inside];
          renewal.beginUnknown(i, slot.tile());
          continue;
        }
        gatherBroad(field, coords[i], 4, broad);
        renewal.begin(i, broad, Renew::all);
      }
      renewal.run();
      std::vector<float> all, around(kWideSize);
      BrickValues sizes;
      for (size_t i = 0; i < coords.size(); ++i) {
        renewal.sizes(i, sizes);
        all.insert(all.end(), sizes, sizes + kBrickVoxels);
        renewal.around(i, around.data());
        all.insert(all.end(), around.begin(), around.end());
      }
      return all;
    };
    EXPECT_EQ(solved(false), solved(true));
    EXPECT_GT(among[0], 100);
    EXPECT_GT(among[1], 10);
  }
}

}  // namespace
}  // namespace argil::clay
