// Lines of sight to clay as it was.

#include "ui3d/studio/view/clay_ray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/unit/haptics/painted_clay.h"

namespace argil::studio {
namespace {

constexpr double kRadius = 10, kVoxel = 0.25;

engine::Document ball(const haptics::Pose& pose) {
  engine::Document document =
      engine::Document::of(clay::makeSphere(clay::Store::make(), {.voxelMm = kVoxel}, Vec3d::Zero(), kRadius));
  document.pieces[0].pose = pose;
  return document;
}

TEST(ClayRay, MeetsABallWhereGeometrySaysSo) {
  haptics::Pose pose;
  pose.translation = {30, -20, 5};
  pose.rotation = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized());
  const engine::Document document = ball(pose);
  render::Box box;
  box.add(pose.translation - Vec3d::Constant(kRadius));
  box.add(pose.translation + Vec3d::Constant(kRadius));
  const PinnedClay clay(document, [&](engine::Id) { return box; });
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  int hits = 0, misses = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3d from = pose.translation + 80 * Vec3d(unit(random), unit(random), unit(random)).normalized();
    const Vec3d to = pose.translation + 14 * Vec3d(unit(random), unit(random), unit(random));
    const Vec3d direction = (to - from).normalized(), v = from - pose.translation;
    const double b = v.dot(direction), c = v.squaredNorm() - kRadius * kRadius, d = b * b - c;
    if (std::abs(d) < 4) continue;  // A graze depends on the voxels.
    const auto hit = clay.distance(from, direction);
    ASSERT_EQ(hit.has_value(), d > 0) << "seed " << kSeed << ", ray " << i;
    (d > 0 ? hits : misses)++;
    if (hit) {
      EXPECT_NEAR(*hit, -b - std::sqrt(d), 0.3 * kVoxel) << "seed " << kSeed << ", ray " << i;
    }
  }
  EXPECT_GT(hits, 50);
  EXPECT_GT(misses, 20);
}

TEST(ClayRay, ASectionsCutFaceIsMetWhereTheClayIsInside) {
  const engine::Document document = ball({});
  const PinnedClay clay(document, [](engine::Id) {
    render::Box box;
    box.add(Vec3d::Constant(-kRadius));
    box.add(Vec3d::Constant(kRadius));
    return box;
  });
  EXPECT_NEAR(*clay.distance({0, 0, 50}, -Vec3d::UnitZ()), 40, 0.01);
  EXPECT_NEAR(*clay.distance({0, 0, 50}, -Vec3d::UnitZ(), 47), 47, 1e-9) << "inside: the cut face";
  EXPECT_FALSE(clay.distance({0, 0, 50}, -Vec3d::UnitZ(), 65).has_value()) << "behind it";
}

TEST(ClayRay, HiddenClayIsNotMet) {
  engine::Document document = ball({});
  document.pieces[0].visible = false;
  EXPECT_TRUE(PinnedClay(document, [](engine::Id) { return render::Box(); }).empty());
}

TEST(ClayRay, GoesThroughAHiddenHalfToTheInnerSideOfTheOther) {
  engine::Document document = ball({});
  const clay::Version masked = haptics::testing::painted(document.pieces[0].version, clay::Channel::mask,
                                                         [](Coord v) { return v.z > 0 ? uint8_t{255} : uint8_t{0}; });
  document.pieces[0].version = masked;
  render::Box box;
  box.add(Vec3d::Constant(-kRadius));
  box.add(Vec3d::Constant(kRadius));
  const auto bounds = [&](engine::Id) { return box; };
  EXPECT_NEAR(*PinnedClay(document, bounds).distance({1, 2, 50}, -Vec3d::UnitZ()), 50 - std::sqrt(95), 0.02);
  document.pieces[0].hideMasked = true;
  const PinnedClay hiding(document, bounds);
  EXPECT_NEAR(*hiding.distance({1, 2, 50}, -Vec3d::UnitZ()), 50 + std::sqrt(95), 0.02);
  EXPECT_NEAR(*hiding.distance({1, 2, -50}, Vec3d::UnitZ()), 50 - std::sqrt(95), 0.02);
  EXPECT_FALSE(hiding.distance({50, 0, 5}, -Vec3d::UnitX()).has_value()) << "in through what is hidden, and out";
}

}  // namespace
}  // namespace argil::studio
