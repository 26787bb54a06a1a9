// The closest point of the surface, against every cell around: planes, spheres, grooves, rims, noise.

#include "haptics/scene/closest_surface.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "clay_fields.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr uint32_t kSeed = 7;
// Voxels; the truth itself errs by the square of a twelfth over twice the distance.
constexpr double kTolerance = 0.03;

struct Case {
  const char* name;
  Field field;
};

std::vector<Case> cases() {
  return {{"plane", planeField({0.3, -0.2, 1}, 1.37)},
          {"sphere", sphereField({0.3, 0.2, -0.4}, 21.3)},
          {"groove", grooveField(12.6)},
          {"rim", rimField(14.2, 6.3)},
          {"noise", noiseField(kSeed, 1.5, 5.0)}};
}

TEST(ClosestSurface, IsTheNearestOfAllCells) {
  for (const Case& c : cases()) {
    const clay::Version version = makeClay(c.field, 6);
    ClosestSurface surface;
    surface.reset(version);
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> spread(-12, 12);
    double worst = 0;
    for (double r : {0.5, 1.0, 3.0, 6.0, 12.0, 16.0}) {
      // Balls that about touch: from a random place towards the surface until the slow distance is near r.
      for (int i = 0; i < (r > 10 ? 3 : 10); ++i) {
        Vec3d p(spread(random), spread(random), 0);
        p.z() = r * (0.6 + 0.5 * spread(random) / 12);
        if (c.field(p) < 0.2) p.z() += r + 1;
        const double reach = r * 1.3 + 2;
        const SurfacePoint found = surface.nearest(p, reach);
        const double truth = bruteDistance(version, p, found.found ? std::min(reach, found.distance + 0.5) : reach, 12);
        if (truth > reach) {
          EXPECT_FALSE(found.found && found.distance < reach - kTolerance);
          continue;
        }
        ASSERT_TRUE(found.found) << c.name << " r " << r << " at " << p.transpose() << " truth " << truth;
        EXPECT_NEAR(found.distance, truth, kTolerance) << c.name << " r " << r << " at " << p.transpose();
        EXPECT_NEAR((found.point - p).norm(), found.distance, 1e-5);
        EXPECT_LT(std::abs(surface.sampler().trilinear(found.point)), 0.01f);
        worst = std::max(worst, std::abs(found.distance - truth));
        // A hint from nearby changes the cost alone.
        const Vec3d hint = found.point + Vec3d(0.3, -0.2, 0.1);
        const SurfacePoint again = surface.nearest(p, reach, &hint);
        ASSERT_TRUE(again.found);
        EXPECT_NEAR(again.distance, truth, kTolerance);
      }
    }
    std::printf("seed %u, %s: worst difference %.4f voxels\n", kSeed, c.name, worst);
  }
}

TEST(ClosestSurface, SeesNothingWhereNothingIs) {
  const clay::Version version = makeClay(sphereField(Vec3d::Zero(), 10), 3);
  ClosestSurface surface;
  surface.reset(version);
  EXPECT_FALSE(surface.nearest({40, 0, 0}, 29).found);
  EXPECT_TRUE(surface.nearest({40, 0, 0}, 31).found);
  EXPECT_FALSE(surface.nearest({1e300, 0, 0}, 100).found);
  EXPECT_FALSE(surface.nearest({std::nan(""), 0, 0}, 100).found);
  EXPECT_TRUE(surface.inside({0, 0, 0}));
  EXPECT_FALSE(surface.inside({40, 0, 0}));
}

}  // namespace
}  // namespace argil::haptics
