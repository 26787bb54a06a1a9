// What scraping, filling and flattening compute brick by brick, beside the formulas in plain loops.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "clay/kernels/brush_kernels.h"
#include "clay/kernels/shaping_kernels.h"
#include "clay/kernels/warp_kernels.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

TEST(LevellingKernels, RowsWithAVoxelNearTheSurfaceAreFound) {
  for (int v = 0; v < kBrickVoxels; ++v) {
    std::array<float, kBrickVoxels> phi;
    phi.fill(v % 2 == 0 ? 2.0f : -2.0f);
    phi[size_t(v)] = v % 3 == 0 ? -1.99f : 1.99f;
    tests::forEachSimdTarget([&](const std::string& target) {
      ASSERT_EQ(rowsWithin(phi.data(), 2), uint64_t{1} << (v / kBrickEdge)) << target << " voxel " << v;
    });
  }
}

TEST(LevellingKernels, WeightsOfOtherRowsStayAsTheyAre) {
  const SweptBall ball{0.5f, -0.25f, 1, 1, 2, 0, 0.2f, 5, 0};
  const uint64_t rows = 0x8100f0000ff00581;
  tests::forEachSimdTarget([&](const std::string& target) {
    float all[kBrickVoxels] = {}, some[kBrickVoxels] = {};
    ballWeights(ball, 1, 0.75f, all);
    ballWeights(ball, 1, 0.75f, some, rows);
    for (int v = 0; v < kBrickVoxels; ++v)
      ASSERT_EQ(some[v], (rows >> (v / kBrickEdge) & 1) != 0 ? all[v] : 0) << target << " voxel " << v;
  });
}

TEST(LevellingKernels, ValuesAreThoseWithGradients) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(-3, 3), part(0, 1);
  std::vector<float> field(12 * 12 * 12);
  for (float& each : field) each = value(random);
  std::vector<FieldSample> samples;
  for (int i = 0; i < 300; ++i)
    samples.push_back({field.data() + random() % 9 * 144 + random() % 9 * 12 + random() % 9, part(random),
                       i % 5 == 0 ? 0 : part(random), part(random)});
  tests::forEachSimdTarget([&](const std::string& target) {
    std::vector<FieldValue> with(samples.size());
    std::vector<float> alone(samples.size());
    sampleField(samples, 144, 12, with.data());
    sampleValues(samples, 144, 12, alone.data());
    for (size_t i = 0; i < samples.size(); ++i) ASSERT_EQ(alone[i], with[i].value) << target << " " << i;
  });
}

std::vector<SurfacePart> someParts(size_t count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> number(-1, 1);
  std::vector<SurfacePart> parts;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f n = Eigen::Vector3f(number(random), number(random), number(random)).normalized();
    parts.push_back({.normal = {n.x(), n.y(), n.z()},
                     .place = {20 * number(random), 20 * number(random), 20 * number(random)},
                     .weight = std::abs(number(random))});
  }
  return parts;
}

TEST(LevellingKernels, SumsWeighByTheFourthPowerOfTheCosine) {
  const std::vector<SurfacePart> parts = someParts(1000);
  const float facing[3] = {0.6f, 0, 0.8f};
  tests::forEachSimdTarget([&](const std::string& target) {
    for (const bool faced : {false, true}) {
      double sums[8] = {1, 2, 3, 4, 5, 6, 7, 0}, expected[8] = {1, 2, 3, 4, 5, 6, 7, 0};  // adds to what is there
      sumParts(parts, faced ? facing : nullptr, sums);
      for (const SurfacePart& each : parts) {
        const double cosine = each.normal[0] * 0.6 + each.normal[2] * 0.8;
        const double w = each.weight * (faced ? std::pow(std::max(cosine, 0.0), 4) : 1);
        expected[0] += w;
        for (int k = 0; k < 3; ++k) expected[1 + k] += w * each.normal[k], expected[4 + k] += w * each.place[k];
      }
      // A rounding to 2⁻¹⁹ each.
      for (int k = 0; k < 7; ++k) EXPECT_NEAR(sums[k], expected[k], 2.5e-3) << target << " " << faced << " " << k;
    }
  });
}

TEST(LevellingKernels, SumsAreTheSameInAnyOrder) {
  std::vector<SurfacePart> parts = someParts(1000);
  const float facing[3] = {0.6f, 0, 0.8f};
  double first[8] = {};
  sumParts(parts, facing, first);
  std::mt19937 random(1);
  tests::forEachSimdTarget([&](const std::string& target) {
    std::shuffle(parts.begin(), parts.end(), random);
    double sums[8] = {};
    sumParts(parts, facing, sums);
    for (int k = 0; k < 7; ++k) EXPECT_EQ(sums[k], first[k]) << target << " " << k;
  });
}

// Random fields, weights and planes.
TEST(LevellingKernels, ClayRisesByAShareOfItsWayToThePlane) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-1, 1);
  const auto at = [](int x, int y, int z) { return size_t(broadOffset(x + 4, y + 4, z + 4)); };
  int moved = 0, capped = 0;
  for (int round = 0; round < 60; ++round) {
    const Eigen::Vector3f n = Eigen::Vector3f(number(random), number(random), number(random)).normalized();
    const Eigen::Vector3f slope = Eigen::Vector3f(number(random), number(random), number(random)).normalized();
    std::vector<float> broad(kBroadSize, 3);
    for (int x = -1; x <= kBrickEdge; ++x)
      for (int y = -1; y <= kBrickEdge; ++y)
        for (int z = -1; z <= kBrickEdge; ++z)
          broad[at(x, y, z)] =
              std::clamp(slope.dot(Eigen::Vector3f(float(x), float(y), float(z)) - Eigen::Vector3f::Constant(3.5f)) +
                             0.2f * number(random),
                         -3.0f, 3.0f);
    float weight[kBrickVoxels];
    for (float& each : weight) each = std::max(number(random), 0.0f);
    const LevelPlane plane{.nx = n.x(),
                           .ny = n.y(),
                           .nz = n.z(),
                           .offset = 2 * number(random),
                           .down = round % 3 != 0,
                           .up = round % 3 != 1,
                           .share = 0.75f,
                           .most = 1.5f};
    tests::forEachSimdTarget([&](const std::string& target) {
      float height[kBrickVoxels], rise[kBrickVoxels];
      uint64_t moves[kBrickEdge];
      levelRises(broad.data(), 3, weight, plane, height, rise, moves);
      for (int i = 0; i < kBrickVoxels; ++i) {
        const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
        const Vec3d g(broad[at(x + 1, y, z)] - broad[at(x - 1, y, z)], broad[at(x, y + 1, z)] - broad[at(x, y - 1, z)],
                      broad[at(x, y, z + 1)] - broad[at(x, y, z - 1)]);
        const double up = n.cast<double>().dot(Vec3d(x, y, z) - Vec3d::Constant(3.5)) - plane.offset;
        const double facing = std::clamp(g.dot(n.cast<double>()) / std::max(g.norm(), 0.2), 0.0, 1.0);
        const double phi = broad[at(x, y, z)], whole = phi * facing - up,
                     way = std::clamp(whole, -1.5, 1.5) * 0.75 * weight[i];
        if (std::abs(way) < 1e-6 && way != 0) continue;  // which way it goes rounding may tell
        const bool may = weight[i] > 0 && std::abs(phi) < 3 && (way > 0 ? plane.up : way < 0 && plane.down);
        ASSERT_EQ((moves[x] >> (i & 63) & 1) != 0, may) << target << " " << round << " " << i;
        if (!may) continue;
        ASSERT_NEAR(height[i], up, 2e-5) << target;
        ASSERT_NEAR(rise[i], way, 2e-5) << target;
        ++moved;
        capped += std::abs(whole) > 1.5;
      }
    });
  }
  EXPECT_GT(moved, 10000);
  EXPECT_GT(capped, 1000);
}

}  // namespace
}  // namespace argil::clay
