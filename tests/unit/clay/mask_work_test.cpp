// Masks of whole pieces.

#include "clay/whole/mask_work.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"

namespace argil::clay {
namespace {

Grid unitGrid() {
  return {1, Vec3d::Zero(), 3};
}
Version ball(double radius = 30) {
  return makeSphere(Store::make(), unitGrid(), Vec3d::Zero(), radius);
}

Version masked(const Version& version, const Vec3d& at, double radius) {
  auto brush = std::make_shared<Brush>();
  brush->operations.push_back({Property::mask, Method::set, Falloff::constant, 1});
  BrushStroke stroke(version, brush);
  stroke.apply(Stamp{at, at, radius});
  return stroke.finish();
}

uint8_t maskAt(const Version& version, Coord v) {
  return version.find(Channel::mask, v >> 3).value(Brick::offset(v.x & 7, v.y & 7, v.z & 7));
}

template <class Visit>
void forBand(const Version& version, const Visit& visit) {
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Coord at = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      if (std::abs(brick.phi(i)) < version.grid().band) visit(at, brick.phi(i));
    }
  });
}

size_t difference(const Version& a, const Version& b) {
  size_t count = 0;
  Version::forEachDifference(a, b, [&](Coord, Slot, Slot) { ++count; });
  return count;
}

TEST(MaskWork, InvertedTwiceIsTheSameToTheBitAndDistancesAreShared) {
  const Version version = masked(ball(), {30, 0, 0}, 12);
  const Version other = invertMask(version, nullptr, 2);
  EXPECT_EQ(difference(version, other), 0u);
  size_t masks = 0;
  forBand(version, [&](Coord at, float) {
    ASSERT_EQ(maskAt(other, at), 255 - maskAt(version, at));
    masks += maskAt(other, at) == 255;
  });
  EXPECT_GT(masks, 10000u);
  EXPECT_EQ(invertMask(other).hash(), version.hash());
  EXPECT_EQ(clearMask(other).hash(), ball().hash());
  EXPECT_EQ(clearMask(ball()).hash(), ball().hash());
}

// More than two slices, between which the job is looked at, the last one short.
TEST(MaskWork, InvertsAllOfALargePiece) {
  const Version version = masked(ball(90), {90, 0, 0}, 12), other = invertMask(version, nullptr, 2);
  ASSERT_GT(version.stats().bricks, 2048u);
  ASSERT_NE(version.stats().bricks % 1024, 0u);
  forBand(version, [&](Coord at, float) { ASSERT_EQ(maskAt(other, at), 255 - maskAt(version, at)); });
}

TEST(MaskWork, BlurKeepsTheMiddleAndSoftensTheRim) {
  const Version version = masked(ball(), {30, 0, 0}, 12), soft = blurMask(version, 4, nullptr, 2);
  EXPECT_EQ(soft.hash(), blurMask(version, 4).hash());
  EXPECT_EQ(maskAt(soft, {29, 0, 0}), 255);
  EXPECT_EQ(maskAt(soft, {-29, 0, 0}), 0);
  size_t between = 0, sharp = 0;
  forBand(version, [&](Coord at, float) {
    between += maskAt(soft, at) > 0 && maskAt(soft, at) < 255;
    sharp += maskAt(version, at) > 0 && maskAt(version, at) < 255;
  });
  EXPECT_GT(sharp, 0u) << "its rim is within a voxel";
  EXPECT_GT(between, 3 * sharp);
  EXPECT_THROW((void)blurMask(version, 0), Error);
}

TEST(MaskWork, ALassoTakesWhatItWindsAroundAndOnlyTheFrontWhereAnEyeIsGiven) {
  MaskLasso lasso;  // looks along z: x and y of the view are those of the clay
  lasso.curve = {{-10, -10}, {10, -10}, {10, 10}, {0, 0}, {-10, 10}};
  const Version version = ball(), through = maskByLasso(version, lasso, nullptr, 2);
  forBand(version, [&](Coord at, float) {
    const bool on = std::abs(std::abs(at.x) - at.y) == 0 || std::abs(at.x) == 10 || at.y == -10;
    if (on) return;  // on the curve itself
    const bool in = std::abs(at.x) < 10 && at.y > -10 && at.y < std::abs(at.x);
    ASSERT_EQ(maskAt(through, at), in ? 255 : 0) << at.x << ' ' << at.y << ' ' << at.z;
  });
  lasso.eye = Vec3d(0, 0, 1000);
  const Version front = maskByLasso(version, lasso);
  EXPECT_EQ(maskAt(front, {3, -3, 29}), 255);
  EXPECT_EQ(maskAt(front, {3, -3, -29}), 0);
  lasso.eye.reset();
  lasso.erase = true;
  EXPECT_EQ(maskByLasso(through, lasso).hash(), version.hash());
  lasso.curve.resize(2);
  EXPECT_THROW((void)maskByLasso(version, lasso), Error);
}

TEST(MaskWork, CurvatureOfABallIsOneOverItsRadius) {
  for (const double radius : {10.0, 20.0, 40.0}) {
    const Version version = ball(radius);
    Sampler field(version);
    double sum = 0, worst = 0;
    size_t count = 0;
    forBand(version, [&](Coord at, float phi) {
      if (std::abs(phi) > 1.5f) return;
      const double found = meanCurvature(field, at) * radius;
      sum += found;
      worst = std::max(worst, std::abs(found - 1));
      ++count;
    });
    EXPECT_NEAR(sum / static_cast<double>(count), 1, 0.1) << radius;
    EXPECT_LT(worst, 0.6) << radius;
    std::printf("radius %g: mean %.3f of 1/radius, worst off by %.3f\n", radius, sum / static_cast<double>(count),
                worst);
  }
}

TEST(MaskWork, HollowsAndRidgesAreMaskedByTheirRadius) {
  BrushStroke stroke(ball(40), Brush::of(Method::carve));
  stroke.apply(Stamp{{40, 0, 0}, {40, 0, 0}, 10});
  const Version version = stroke.finish();
  const Version hollows = maskByCavity(version, {12, false, false}, nullptr, 2),
                ridges = maskByCavity(version, {12, true, false});
  EXPECT_GT(maskAt(hollows, {30, 0, 0}), 200);  // bottom of the hollow of radius 10
  EXPECT_EQ(maskAt(ridges, {30, 0, 0}), 0);
  EXPECT_EQ(maskAt(hollows, {-39, 0, 0}), 0);  // a ball of radius 40 is nearly flat
  EXPECT_EQ(maskAt(ridges, {-39, 0, 0}), 0);
  size_t rim = 0;
  forBand(version, [&](Coord at, float phi) { rim += at.x > 34 && std::abs(phi) < 1 && maskAt(ridges, at) > 200; });
  EXPECT_GT(rim, 50u);
  EXPECT_THROW((void)maskByCavity(version, {0, false, false}), Error);
  EXPECT_EQ(maskByCavity(invertMask(version), {12, false, true}).hash(), invertMask(version).hash());
}

TEST(MaskWork, ACancelledJobLeavesNothing) {
  const Version version = ball();
  Job job;
  job.cancel();
  EXPECT_THROW((void)invertMask(version, &job), Cancelled);
  EXPECT_EQ(version.store()->usage().channelBricks, 0u);
}

}  // namespace
}  // namespace argil::clay
