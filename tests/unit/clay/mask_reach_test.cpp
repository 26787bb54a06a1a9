// What a mask covers beyond the band, against a plain search, and that it costs what lies near.

#include "clay/brush/mask_reach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

// A ball whose voxels of the band are masked by `cover`.
Version maskedBall(double radius, const std::function<int(Coord)>& cover) {
  Grid grid;
  grid.voxelMm = 1;
  const Version ball = makeSphere(Store::make(), grid, Vec3d(0.3, -0.2, 0.1), radius);
  Editor editor(ball);
  ball.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> values{};
    for (int v = 0; v < kBrickVoxels; ++v)
      if (std::abs(brick.phi(v)) < grid.band)
        values[size_t(v)] = uint8_t(cover(brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}));
    editor.setChannel(Channel::mask, brick.coord, values);
  });
  return editor.commit();
}

int halfWithARim(Coord voxel) {
  return std::clamp(128 + 40 * voxel.x, 0, 255);
}

// Neighbours have nothing to do with each other: each place that counts shows.
int speckled(Coord voxel) {
  return (voxel.x * 7 + voxel.y * 13 + voxel.z * 29) % 5 < 2 ? 255 : 0;
}

struct Place {
  Vec3d at;
  int cover;
};

std::vector<Place> placesOf(const Version& version) {
  std::vector<Place> places;
  version.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v)
      if (std::abs(brick.phi(v)) <= 0.5f)
        places.push_back({(brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}).toVec3d(),
                          version.find(Channel::mask, brick.coord).value(v)});
  });
  return places;
}

// The mean of the places within a voxel of the nearest, by how much nearer they are than that.
double plainly(const std::vector<Place>& places, const Vec3d& at) {
  double least = 1e30, sum = 0, weights = 0;
  for (const Place& place : places) least = std::min(least, (place.at - at).norm());
  for (const Place& place : places) {
    const double weight = std::max(0.0, 1 - ((place.at - at).norm() - least));
    sum += weight * place.cover;
    weights += weight;
  }
  return sum / weights;
}

// `far`: by how much they may differ at most, and in the mean, where they are not looked at voxel by voxel.
void expectThoseOfTheNearestSurface(const Version& ball, double far, double farMean) {
  std::mt19937 random(5);
  const std::vector<Place> places = placesOf(ball);
  MaskReach reach(ball);
  size_t some = 0, distant = 0;
  double differs = 0, most = 0;
  for (int i = 0; i < 40; ++i) {
    std::uniform_int_distribution<int> brick(-5, 4), voxel(0, kBrickVoxels - 1);
    const Coord at{brick(random) / 3, brick(random), brick(random)};
    const MaskCover& cover = reach.at(at, 60);
    for (int k = 0; k < 20; ++k) {
      const int v = voxel(random);
      const Coord place = at * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      const double expected = plainly(places, place.toVec3d());
      // A part of 4 voxels that reaches nearer than 12 is looked at voxel by voxel.
      const bool near = std::abs(place.toVec3d().norm() - 30) < 12 - 4 * 1.7321;
      ASSERT_NEAR(cover.value[size_t(v)], expected, near ? 1 : far) << place.x << ' ' << place.y << ' ' << place.z;
      distant += near ? 0 : 1;
      most = std::max(most, near ? 0 : std::abs(cover.value[size_t(v)] - expected));
      differs += near ? 0 : std::abs(cover.value[size_t(v)] - expected);
      some += expected > 0 && expected < 255 ? 1 : 0;
    }
    EXPECT_EQ(cover.none, *std::max_element(cover.value.begin(), cover.value.end()) == 0);
    EXPECT_EQ(cover.whole, *std::min_element(cover.value.begin(), cover.value.end()) == 255);
  }
  EXPECT_GT(some, 100u);
  std::printf("farther out they differ by %.1f of 255 in the mean, %.0f at most\n", differs / double(distant), most);
  EXPECT_LE(differs, farMean * double(distant));
}

TEST(MaskReach, VoxelsAreCoveredLikeTheNearestSurface) {
  expectThoseOfTheNearestSurface(maskedBall(30, halfWithARim), 80, 3);
  expectThoseOfTheNearestSurface(maskedBall(30, speckled), 40, 2);
}

TEST(MaskReach, WhatIsFarFromAllSurfaceIsFree) {
  const Version ball = maskedBall(40, [](Coord) { return 255; });
  MaskReach reach(ball);
  EXPECT_TRUE(reach.at({0, 0, 4}, 16).whole);
  EXPECT_TRUE(reach.at({0, 0, 0}, 16).none);
  EXPECT_TRUE(reach.at({0, 0, 0}, 60).whole);
  EXPECT_TRUE(reach.at({0, 0, 20}, 16).none);
  EXPECT_EQ(reach.compared(), 0u) << "where all is masked or nothing, no voxel is looked at";
}

TEST(MaskReach, CoversAreEqualOnEverySimdTarget) {
  const Version ball = maskedBall(30, speckled);
  std::vector<MaskCover> first;
  tests::forEachSimdTarget([&](const std::string& target) {
    MaskReach reach(ball);
    size_t i = 0;
    for (const Coord at : {Coord{0, 0, 3}, Coord{1, 2, 4}, Coord{0, -3, -3}, Coord{0, 0, 9}, Coord{2, 2, -1}}) {
      const MaskCover& cover = reach.at(at, 60);
      if (first.size() == i) first.push_back(cover);
      EXPECT_EQ(cover.value, first[i++].value) << target;
    }
  });
  EXPECT_FALSE(first.at(0).none);
  EXPECT_FALSE(first.at(0).whole);
}

// A pen that is pressed harder and harder reaches farther with every stamp.
TEST(MaskReach, AGrowingReachLooksAgainAFewTimesInAll) {
  const Version ball = maskedBall(30, halfWithARim);
  MaskReach grows(ball), once(ball);
  for (double reach = 10; reach < 80; reach += 0.1) (void)grows.at({0, 3, 1}, reach);
  (void)once.at({0, 3, 1}, 80);
  EXPECT_GT(once.compared(), 0u);
  EXPECT_LE(grows.compared(), 8 * once.compared());
}

// Near the surface a voxel is compared with the surface near it, however large model and tool are.
TEST(MaskReach, CostFollowsWhatIsNear) {
  const auto perVoxel = [](double radius, double reach) {
    const Version ball = maskedBall(radius, halfWithARim);
    MaskReach mask(ball);
    const int top = int(std::floor(radius / kBrickEdge));
    for (int z = top - 1; z <= top; ++z) {
      (void)mask.at({0, 0, z}, reach);
      (void)mask.at({-1, 0, z}, reach);
    }
    return double(mask.compared()) / (4 * kBrickVoxels);
  };
  const double small = perVoxel(20, 20), large = perVoxel(150, 600);
  std::printf("places a voxel is compared with: %.0f, on large clay with a large tool %.0f\n", small, large);
  EXPECT_LE(small, 1500);
  EXPECT_LE(large, 1500);
}

// The farther from the surface, the more places count for a voxel, and the fewer voxels are looked at.
TEST(MaskReach, ABrickFarOutCostsNoMoreThanOneNearTheSurface) {
  const Version ball = maskedBall(60, halfWithARim);
  const auto ofBrick = [&](int z) {
    MaskReach mask(ball);
    EXPECT_FALSE(mask.at({0, 0, z}, 200).none);
    return mask.compared();
  };
  const uint64_t near = ofBrick(7), middle = ofBrick(12), far = ofBrick(17);
  std::printf("%zu places near the surface, %zu at 40 voxels, %zu at 80\n", size_t(near), size_t(middle), size_t(far));
  EXPECT_LE(middle, near);
  EXPECT_LT(far, middle);
}

}  // namespace
}  // namespace argil::clay
