// Rays to corners and edges that triangles share.

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "render/view/ray.h"

namespace argil::render {
namespace {

// A closed fan about a corner that a ray comes to, over its rim, or along one of its edges: one of its triangles is met
// whatever the last digits say.
TEST(Rays, NonePassesBetweenTrianglesThatShareACornerOrAnEdge) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 20000; ++round) {
    const bool onGrid = round % 2 == 0;  // As vertices of a flat or a symmetric surface lie.
    const auto any = [&](double size) {
      const auto number = [&] { return onGrid ? std::round(2 * size * unit(random)) / 2 : size * unit(random); };
      const double x = number(), y = number(), z = number();
      return Vec3d(x, y, z);
    };
    Vec3d direction = any(2);
    if (direction.norm() < 0.2) direction = Vec3d(1, 1, 1);
    direction.normalize();
    const Vec3d aside = direction.unitOrthogonal(), up = direction.cross(aside), middle = any(40);
    std::array<Vec3d, 6> rim;
    for (size_t i = 0; i < rim.size(); ++i) {
      const double angle = 2 * M_PI * (double(i) + 0.3 * unit(random)) / double(rim.size());
      rim[i] = middle + 2 * (std::cos(angle) * aside + std::sin(angle) * up) + 0.5 * unit(random) * direction;
    }
    const Vec3d onEdge = middle + std::abs(unit(random)) * 0.99 * (rim[2] - middle);
    for (const Vec3d& aim : {middle, onEdge}) {
      const double away = 30 + 25 * unit(random);
      const Ray ray{aim - away * direction, direction};
      double nearest = kNever;
      for (size_t i = 0; i < rim.size(); ++i)
        nearest = std::min(nearest, hitTriangle(ray, middle, rim[i], rim[(i + 1) % rim.size()]));
      ASSERT_NEAR(nearest, away, 1e-9) << "round " << round;
    }
  }
}

TEST(Rays, MeetWithinTheirReachOnly) {
  const Vec3d a(0, 0, 5), b(4, 0, 5), c(0, 4, 5);
  const Vec3d forward(0, 0, 1);
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 0), forward}, a, b, c), 5);
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 0), forward}, c, b, a), 5) << "from behind";
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 9), -forward}, a, b, c), 4);
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 9), forward}, a, b, c), kNever);
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 0), forward, 0, 4.9}, a, b, c), kNever);
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 0), forward, 5.1, 9}, a, b, c), kNever);
  EXPECT_EQ(hitTriangle({Vec3d(3, 3, 0), forward}, a, b, c), kNever);
  EXPECT_EQ(hitTriangle({Vec3d(-1, 1, 5), Vec3d(1, 0, 0)}, a, b, c), kNever) << "from its edge";
  EXPECT_EQ(hitTriangle({Vec3d(1, 1, 0), forward}, a, a, c), kNever) << "without area";
}

}  // namespace
}  // namespace argil::render
