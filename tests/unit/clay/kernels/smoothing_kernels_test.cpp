// Means beside the formulas in plain loops.

#include "clay/kernels/smoothing_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "clay/field/unbent_plane.h"
#include "clay/store/brick_set.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr double kBinomial[3] = {0.25, 0.5, 0.25};

TEST(SmoothingKernels, MeansOfMeansAreThoseOfATriangle) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> number(-3, 3);
  std::vector<float> broad(kBroadSize);
  for (float& each : broad) each = number(random);
  constexpr double kTriangle[7] = {1, 2, 3, 4, 3, 2, 1};
  tests::forEachSimdTarget([&](const std::string& target) {
    float mean[kBrickVoxels];
    broadMeanOfMeans(broad.data(), mean);
    for (int v = 0; v < kBrickVoxels; ++v) {
      double expected = 0;
      for (int i = 0; i < 343; ++i)
        expected +=
            kTriangle[i / 49] * kTriangle[i / 7 % 7] * kTriangle[i % 7] / 4096 *
            broad[size_t(broadOffset((v >> 6) + 1 + i / 49, ((v >> 3) & 7) + 1 + i / 7 % 7, (v & 7) + 1 + i % 7))];
      ASSERT_NEAR(mean[v], expected, 1e-5) << target << " voxel " << v;
    }
  });
}

TEST(SmoothingKernels, FarMeansAreOfTheSameVoxelsOfTheBricksAround) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-3, 3);
  std::vector<float> values(kBricksAround * kBrickVoxels);
  for (float& each : values) each = number(random);
  const float* around[kBricksAround];
  for (size_t k = 0; k < kBricksAround; ++k) around[k] = values.data() + k * kBrickVoxels;
  tests::forEachSimdTarget([&](const std::string& target) {
    float mean[kBrickVoxels];
    farMean(around, mean);
    for (int v = 0; v < kBrickVoxels; ++v) {
      double expected = 0;
      for (size_t k = 0; k < kBricksAround; ++k)
        expected += kBinomial[kAroundSteps[k].x + 1] * kBinomial[kAroundSteps[k].y + 1] *
                    kBinomial[kAroundSteps[k].z + 1] * around[k][v];
      ASSERT_NEAR(mean[v], expected, 1e-5) << target << " voxel " << v;
    }
  });
}

// The mean of a field that ends at the band says, by the table, the distance that it is the mean of.
TEST(SmoothingKernels, AMeanOfAPlaneIsUnbentToItsDistance) {
  const auto mean = [](double d) {
    double sum = 0;
    for (int k = -7; k <= 7; ++k) sum += (8 - std::abs(k)) * std::clamp(d + k, -3.0, 3.0);
    return sum / 64;
  };
  const UnbentPlane plane(mean, 3);
  float values[kBrickVoxels];
  for (int v = 0; v < kBrickVoxels; ++v) values[v] = float(mean(-3 + 6 * v / 511.0));
  plane.distances(values);
  for (int v = 0; v < kBrickVoxels; ++v) EXPECT_NEAR(values[v], -3 + 6 * v / 511.0, 0.01) << v;
}

}  // namespace
}  // namespace argil::clay
