// Narrow bands of every width that a file may bring: strokes and operations leave distances in the whole of it.

#include <gtest/gtest.h>

#include <cmath>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/smooth_all.h"

namespace argil::clay {
namespace {

constexpr double kRadius = 40;

class EveryBand : public ::testing::TestWithParam<float> {
 protected:
  [[nodiscard]] static Version ball(double radius, const Vec3d& at = Vec3d::Zero(),
                                    std::shared_ptr<Store> store = Store::make()) {
    Grid grid;
    grid.voxelMm = 1;
    grid.band = GetParam();
    return makeSphere(std::move(store), grid, at, radius);
  }
  // Distances change by no more than the way: a band that was cut off jumps from what it knows to its edge.
  static void expectDistances(const Version& version, const char* what) {
    const float band = version.grid().band;
    uint64_t steep = 0, voxels = 0;
    float most = 0;
    version.forEachBrick([&](const Brick& brick) {
      for (int x = 0; x < kBrickEdge; ++x)
        for (int y = 0; y < kBrickEdge; ++y)
          for (int z = 0; z < kBrickEdge; ++z) {
            const Coord at = brick.coord * kBrickEdge + Coord{x, y, z};
            const float own = brick.phi(Brick::offset(x, y, z));
            for (const Coord next : {at + Coord{1, 0, 0}, at + Coord{0, 1, 0}, at + Coord{0, 0, 1}}) {
              const Slot slot = version.find(next >> kBrickBits);
              const float other = slot.phi(Brick::offset(next.x & 7, next.y & 7, next.z & 7), band);
              most = std::max(most, std::abs(other - own));
              steep += std::abs(other - own) > 1.3f;
              ++voxels;
            }
          }
    });
    EXPECT_EQ(steep, 0u) << what << ": " << voxels << " looked at, the steepest step " << most;
  }
};

TEST_P(EveryBand, StrokesLeaveDistances) {
  for (const Method method : {Method::carve, Method::add, Method::smooth, Method::scrape, Method::tug}) {
    const Version before = ball(kRadius);
    BrushStroke stroke(before, Brush::of(method));
    for (int i = 0; i < 8; ++i) stroke.apply({Vec3d(kRadius, 2.0 * i, 0), Vec3d(kRadius, 2.0 * i + 2, 0), 10});
    const Version after = stroke.finish();
    EXPECT_NE(after.hash(), before.hash());
    expectDistances(after, ("method " + std::to_string(int(method))).c_str());
    // The band is as wide as it was: a voxel in it for each one before, but for what the stroke did to the surface.
    EXPECT_NEAR(double(after.activeVoxels()), double(before.activeVoxels()), 0.05 * double(before.activeVoxels()));
  }
}

TEST_P(EveryBand, OperationsLeaveDistances) {
  const Version a = ball(kRadius);
  for (const Combination how : {Combination::join, Combination::cut, Combination::intersect}) {
    const Version result = combine(a, ball(kRadius, {30, 5, 0}), how);
    expectDistances(result, ("combination " + std::to_string(int(how))).c_str());
  }
  expectDistances(smoothAll(a, 3, true), "smoothed");
}

// Half of a groove is morphed away: there the clay is what it was, beside the tip what it is.
TEST_P(EveryBand, MorphGoesBackUnderTheTipAlone) {
  const Version before = ball(kRadius);
  BrushStroke carving(before, Brush::of(Method::carve));
  carving.apply({Vec3d(kRadius, -20, 0), Vec3d(kRadius, 20, 0), 6});
  const Version carved = carving.finish();
  Brush brush;
  brush.operations = {{Property::distance, Method::morph, Falloff::constant, 1}};
  brush.before = before;
  BrushStroke morphing(carved, std::make_shared<const Brush>(brush));
  const Vec3d tip(kRadius, 14, 0);
  constexpr double kTip = 12, kRim = 4;
  for (int i = 0; i < 2; ++i) morphing.apply({tip, tip, kTip});
  const Version after = morphing.finish();
  const float band = before.grid().band;
  const auto at = [&](const Version& version, Coord voxel) {
    return version.find(voxel >> kBrickBits).phi(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), band);
  };
  uint64_t under = 0, beside = 0;
  for (int x = 30; x <= 46; ++x)
    for (int y = -30; y <= 30; ++y)
      for (int z = -10; z <= 10; ++z) {
        const Coord voxel{x, y, z};
        const float was = at(before, voxel), is = at(carved, voxel), becomes = at(after, voxel);
        if (std::abs(is - was) < 0.5f) continue;
        const double distance = (voxel.toVec3d() - tip).norm();
        if (distance < kTip - kRim && std::abs(was) < 1.5f) {
          ++under;
          ASSERT_NEAR(becomes, was, 0.25) << x << ' ' << y << ' ' << z;
        } else if (distance > kTip + kRim && std::abs(is) < 1.5f) {
          ++beside;
          ASSERT_NEAR(becomes, is, 0.25) << x << ' ' << y << ' ' << z;
        }
      }
  EXPECT_GT(under, 50u);
  EXPECT_GT(beside, 50u);
}

INSTANTIATE_TEST_SUITE_P(Bands, EveryBand, ::testing::Values(2.0f, 3.0f, 4.5f, 6.0f, 8.0f));

}  // namespace
}  // namespace argil::clay
