// The same clay on another grid.

#include "clay/whole/resample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::errorAgainst;
using testing::expectClosed;
using testing::expectProperBand;

Grid gridOf(double voxelMm, const Vec3d& origin = Vec3d(0.3, -0.2, 0.1)) {
  Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = origin;
  return grid;
}

TEST(Resample, SphereFinerCoarserAndMoved) {
  const Version sphere = makeSphere(Store::make(), gridOf(0.5), Vec3d::Zero(), 12);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.rotate(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  pose.pretranslate(Vec3d(5, 6, 7));
  for (const double voxel : {0.25, 0.37, 0.5, 0.8, 1.1, 1.7}) {
    const Version result = resample(sphere, gridOf(voxel, Vec3d(1.1, 2.2, -0.3)), pose, 2);
    const auto error = errorAgainst(result, [](const Vec3d& p) { return (p - Vec3d(5, 6, 7)).norm() - 12; });
    std::printf("sphere from 0.5 to %g mm: %s\n", voxel, error.text().c_str());
    EXPECT_LT(error.surfaceMax, 0.01);
    EXPECT_LT(error.bandMax, 0.03);
    expectProperBand(result, 1.02);
    expectClosed(result);
    const ResampleError told = resampleError(sphere, result, pose, 2, WorkPart(nullptr));
    EXPECT_GT(told.points, 1000u);
    // Chords of both samplings: an eighth of the curvature in voxels, at most.
    EXPECT_LT(told.maxMm(), 0.5 * std::max(voxel, 0.5) * std::max(voxel, 0.5) / 12);
  }
}

TEST(Resample, HalvesAndBack) {
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), Vec3d(20, 16, 14), 4);
  const Version fine = resample(block, gridOf(0.25), Eigen::Isometry3d::Identity(), 2);
  const Version back = resample(fine, gridOf(0.5), Eigen::Isometry3d::Identity(), 2);
  double worst = 0;
  block.forEachBrick([&](const Brick& brick) {
    const Slot other = back.find(brick.coord);
    for (int v = 0; v < kBrickVoxels; ++v)
      if (std::abs(brick.phi(v)) < 1) worst = std::max(worst, double(std::abs(brick.phi(v) - other.phi(v, 3))));
  });
  std::printf("0.5 to 0.25 to 0.5 mm: %.5f voxel at most near the surface\n", worst);
  EXPECT_LT(worst, 0.01);
}

TEST(Resample, WholeVoxelsKeepEveryBit) {
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), Vec3d(20, 16, 14), 0);
  // Moved by 5, −3 and 8 voxels: the same values in other bricks.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Vec3d(2.5, -1.5, 4));
  const Version moved = resample(block, gridOf(0.5), pose, 2);
  const Version back = resample(moved, gridOf(0.5), pose.inverse(), 1);
  EXPECT_EQ(back.hash(), block.hash());
  EXPECT_NE(moved.hash(), block.hash());
  EXPECT_EQ(moved.activeVoxels(), block.activeVoxels());
}

TEST(Resample, SameBitsOnAnyThreadsAndRefuses) {
  const Version block = makeBlock(Store::make(), gridOf(0.5), Vec3d::Zero(), Vec3d(20, 16, 14), 2);
  const Eigen::Isometry3d stay = Eigen::Isometry3d::Identity();
  EXPECT_EQ(resample(block, gridOf(0.33), stay, 1).hash(), resample(block, gridOf(0.33), stay, 3).hash());
  EXPECT_THROW((void)resample(block, gridOf(0), stay), Error);
  EXPECT_THROW((void)resample(block, gridOf(0.001), stay), Error);
  Eigen::Isometry3d bad = stay;
  bad.translation().x() = std::nan("");
  EXPECT_THROW((void)resample(block, gridOf(0.5), bad), Error);
  Job job;
  job.cancel();
  EXPECT_THROW((void)resample(block, gridOf(0.3), stay, 2, &job), Cancelled);
}

// Thin rings and small balls have bricks that hold little of the band.
TEST(Resample, WhatIsRefusedIsSaidInVoxelsAsTheyComeOut) {
  const Version ring = makeTorus(Store::make(), gridOf(0.5), Vec3d::Zero(), 40, 3);
  const double voxel = 0.003, tried = 0.125;
  const Version finer = resample(ring, gridOf(tried), Eigen::Isometry3d::Identity(), 2);
  try {
    (void)resample(ring, gridOf(voxel), Eigen::Isometry3d::Identity());
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    const std::string sentence = e.what(), words = "would take about ";
    ASSERT_NE(sentence.find(words), std::string::npos) << sentence;
    const double said = std::stod(sentence.substr(sentence.find(words) + words.size())) * 1e6;
    EXPECT_NEAR(said * voxel * voxel / (tried * tried) / double(finer.activeVoxels()), 1, 0.03) << sentence;
  }
}

// A field three times as steep as a distance, as strokes may leave, that is zero between two bricks: no voxel of either
// is near to the surface.
TEST(Resample, ASteepSurfaceBetweenTwoBricksIsFound) {
  Editor editor(Version::empty(Store::make(), gridOf(0.5, Vec3d::Zero())));
  for (int b = 0; b < 512; ++b) {
    const Coord brick{b >> 6, (b >> 3) & 7, b & 7};
    std::array<float, kBrickVoxels> phi;
    for (int v = 0; v < kBrickVoxels; ++v)
      phi[static_cast<size_t>(v)] = std::clamp(3 * (static_cast<float>(8 * brick.x + (v >> 6)) - 23.5f), -3.0f, 3.0f);
    editor.setVoxels(brick, phi);
  }
  const Version result = resample(editor.commit(), gridOf(0.4, Vec3d::Zero()), Eigen::Isometry3d::Identity(), 1);
  Sampler sampler(result);
  for (const double x : {11.4, 12.1})
    EXPECT_EQ(sampler.trilinear(result.grid().toVoxel(Vec3d(x, 16, 16))) < 0, x < 11.75) << x;
}

}  // namespace
}  // namespace argil::clay
