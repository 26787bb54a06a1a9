#include "clay/brush/displacement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace argil::clay {
namespace {

// A field of nodes that lead anywhere, of which a share is at rest.
DisplacementField randomField(int spacing, std::mt19937& random) {
  std::uniform_real_distribution<float> number(-1, 1);
  DisplacementField field(spacing);
  std::vector<Coord> blocks;
  for (int i = 0; i < 8; ++i) blocks.push_back({i >> 2, i >> 1 & 1, i & 1});
  const float most = 0.9f * static_cast<float>(spacing);
  field.compose(blocks, most, [&](Coord, NodePlaces& places) {
    const bool rests = random() % 3 == 0;
    for (int i = 0; i < kBlockNodes; ++i) {
      const auto node = [&](int at) { return (static_cast<float>(at) - 3.5f) * static_cast<float>(spacing); };
      const auto moved = [&] { return rests ? 0.0f : 0.5f * most * number(random); };
      places.x[i] = node(i >> 6) + moved();
      places.y[i] = node((i >> 3) & 7) + moved();
      places.z[i] = node(i & 7) + moved();
    }
  });
  return field;
}

// Bounds of a cube of bricks hold the displacement of each of its voxels; where there are none all are at rest.
TEST(DisplacementField, BoundsHoldEveryVoxel) {
  std::mt19937 random(8);
  int cubes = 0, resting = 0;
  for (const int spacing : {1, 2, 4, 8, 16}) {
    const DisplacementField field = randomField(spacing, random);
    for (int round = 0; round < 40; ++round) {
      const int edge = 1 << (random() % 4), range = 2 * spacing + 2;
      const auto any = [&] { return static_cast<int>(random() % static_cast<unsigned>(range)) - 1; };
      const Coord first{any(), any(), any()};
      Vec3f low = Vec3f::Zero(), high = low;
      const bool moves = field.bounds(first, edge, low, high);
      resting += !moves;
      Vec3f least = Vec3f::Constant(1e6f), most = -least;
      for (int i = 0; i < edge * edge * edge; ++i) {
        Displacement at[1000];
        if (!field.atVoxels(first + Coord{i / (edge * edge), i / edge % edge, i % edge}, at)) {
          least = least.cwiseMin(0), most = most.cwiseMax(0);
          continue;
        }
        for (const Displacement& each : at) {
          const Vec3f d(each.x, each.y, each.z);
          least = least.cwiseMin(d), most = most.cwiseMax(d);
        }
      }
      if (!moves) low = high = Vec3f::Zero();
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(low[k], least[k] + 1e-4f) << spacing << " edge " << edge;
        EXPECT_GE(high[k], most[k] - 1e-4f) << spacing << " edge " << edge;
      }
      ++cubes;
    }
  }
  EXPECT_GT(cubes - resting, 50);
  EXPECT_GT(resting, 5);
}

// Clay that is drawn out evenly, by nodes far apart: the bounds are those of the voxels, not those of the nodes.
TEST(DisplacementField, BoundsFollowASlope) {
  constexpr int kSpacing = 16;
  DisplacementField field(kSpacing);
  std::vector<Coord> blocks;
  for (int i = 0; i < 27; ++i) blocks.push_back({i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1});
  field.compose(blocks, 40, [&](Coord block, NodePlaces& places) {
    for (int i = 0; i < kBlockNodes; ++i) {
      const auto node = [&](int at) { return static_cast<float>((at - 3.5) * kSpacing); };
      const double x = field.middle(block).x() + static_cast<double>(node(i >> 6));
      places.x[i] = node(i >> 6) + static_cast<float>(0.1 * x);
      places.y[i] = node((i >> 3) & 7);
      places.z[i] = node(i & 7);
    }
  });
  for (int brick = 0; brick < 12; ++brick) {
    Vec3f low, high;
    ASSERT_TRUE(field.bounds({brick, 3, 3}, 1, low, high));
    EXPECT_NEAR(low.x(), 0.1 * (8 * brick - 1), 0.05);
    EXPECT_NEAR(high.x(), 0.1 * (8 * brick + 8), 0.05);
    EXPECT_NEAR(high.y(), low.y(), 0.05);
  }
}

}  // namespace
}  // namespace argil::clay
