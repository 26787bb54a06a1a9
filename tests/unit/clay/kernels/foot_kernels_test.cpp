// Distances to what a surface is beside a point: where they are known, and where a curvature cannot be true.

#include "clay/kernels/foot_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace argil::clay {
namespace {

FootShape shapeAt(const Vec3d& point, const Vec3d& normal, double curvature, float beside) {
  const Vec3d first = normal.unitOrthogonal();
  FootShape shape{};
  for (int k = 0; k < 3; ++k) {
    shape.point[k] = static_cast<float>(point[k]);
    shape.normal[k] = static_cast<float>(normal[k]);
    shape.first[k] = static_cast<float>(first[k]);
  }
  shape.curvature[0] = shape.curvature[1] = static_cast<float>(curvature);
  shape.beside2 = beside * beside;
  return shape;
}

// Of all voxels of the block from zero on.
std::array<float, kBrickVoxels> distances(const FootShape& shape) {
  const uint32_t nearest[kBrickVoxels] = {};
  const float low[3] = {};
  std::array<float, kBrickVoxels> distance{};
  float out[kBrickVoxels];
  distancesToShapes(&shape, nearest, low, ~uint64_t{0}, out);
  std::copy(std::begin(out), std::end(out), distance.begin());
  return distance;
}

Vec3d voxel(size_t v) {
  return {double(v >> 6), double((v >> 3) & 7), double(v & 7)};
}

TEST(FootKernels, BesideAPointABallIsABall) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  size_t looked = 0;
  for (int i = 0; i < 60; ++i) {
    // Above zero: round outwards as seen from the voxels.
    const double radius = (i % 2 == 0 ? 1 : -1) * (i % 3 == 0 ? 12 : 40);
    const Vec3d up = Vec3d(normal(random), normal(random), normal(random)).normalized();
    const Vec3d point = Vec3d(3.5, 3.5, 3.5) - 5 * up, middle = point - radius * up;
    const auto distance = distances(shapeAt(point, up, 1 / radius, 2.2f));
    for (size_t v = 0; v < distance.size(); ++v) {
      const Vec3d way = voxel(v) - point;
      const double height = way.dot(up), beside = (way - height * up).norm();
      if (height < 0.5 || beside > 1.5 || height > (radius > 0 ? 100 : -0.55 * radius)) continue;
      ++looked;
      EXPECT_NEAR(distance[v], std::abs((voxel(v) - middle).norm() - std::abs(radius)), 0.05)
          << "radius " << radius << ", " << height << " over it, " << beside << " beside";
    }
  }
  EXPECT_GT(looked, 1000u);
}

// A crease looks like a hollow that is much deeper than what is nearest could be in.
TEST(FootKernels, NothingIsNearestBehindTheMiddleOfItsHollow) {
  const Vec3d up = Vec3d::UnitZ(), point(3.2, 3.4, -1);
  const auto distance = distances(shapeAt(point, up, -1.0 / 3, 2.2f));
  size_t looked = 0;
  for (size_t v = 0; v < distance.size(); ++v) {
    const Vec3d way = voxel(v) - point;
    const double height = way.dot(up), beside = (way - height * up).norm();
    if (height < 5 || beside > 0.85) continue;
    ++looked;
    EXPECT_GE(distance[v], height - 0.8 * beside * beside / height) << height << " over it, " << beside << " beside";
    EXPECT_LE(distance[v], way.norm());
  }
  EXPECT_GE(looked, 8u);
}

// The nearest place is never farther aside than is said, nor nearer than that allows; without a normal it is the point.
TEST(FootKernels, DistancesStayBetweenThePointAndWhatIsBesideIt) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 40; ++i) {
    const Vec3d up = Vec3d(normal(random), normal(random), normal(random)).normalized();
    const Vec3d point = Vec3d(3.5, 3.5, 3.5) - 6 * up;
    const float beside = i % 4 == 0 ? 0 : 0.8f;
    const auto distance = distances(shapeAt(point, up, 0.3 * normal(random), beside));
    for (size_t v = 0; v < distance.size(); ++v) {
      const double far = (voxel(v) - point).norm();
      EXPECT_LE(distance[v], far + 1e-4);
      if (beside == 0) {
        EXPECT_NEAR(distance[v], far, 1e-4);
      }
    }
  }
}

}  // namespace
}  // namespace argil::clay
