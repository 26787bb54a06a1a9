#include "clay/store/sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"

namespace argil::clay {
namespace {

// A field f(voxel) written as it is into the bricks around zero.
template <class F>
Version fieldOf(const F& f) {
  Editor editor(Version::empty(Store::make(), Grid{}));
  for (int x = -2; x < 2; ++x)
    for (int y = -2; y < 2; ++y)
      for (int z = -2; z < 2; ++z) {
        std::array<float, kBrickVoxels> phi;
        for (int i = 0; i < kBrickVoxels; ++i)
          phi[static_cast<size_t>(i)] =
              static_cast<float>(f(Vec3d(8 * x + (i >> 6), 8 * y + ((i >> 3) & 7), 8 * z + (i & 7))));
        editor.setVoxels({x, y, z}, phi);
      }
  return editor.commit();
}

Vec3d randomPoint(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> u(-reach, reach);
  return {u(random), u(random), u(random)};
}

TEST(Sampler, TrilinearIsExactForLinearFields) {
  const Vec3d slope(0.05, -0.03, 0.08);
  const Version v = fieldOf([&](const Vec3d& p) { return slope.dot(p) + 0.2; });
  Sampler sampler(v);
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d p = randomPoint(random, 14);
    Vec3f g;
    EXPECT_NEAR(sampler.trilinear(p, g), slope.dot(p) + 0.2, 2e-6);
    EXPECT_LT((g.cast<double>() - slope).norm(), 2e-6);
  }
}

TEST(Sampler, TricubicIsExactForQuadraticFields) {
  const auto f = [](const Vec3d& p) {
    return 0.004 * p.x() * p.x() - 0.003 * p.y() * p.z() + 0.002 * p.z() * p.z() + 0.05 * p.y() - 0.1;
  };
  const Version v = fieldOf(f);
  Sampler sampler(v);
  std::mt19937_64 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d p = randomPoint(random, 13);
    Vec3f g;
    EXPECT_NEAR(sampler.tricubic(p, g), f(p), 1e-5);
    const Vec3d exact(0.008 * p.x(), -0.003 * p.z() + 0.05, -0.003 * p.y() + 0.004 * p.z());
    EXPECT_LT((g.cast<double>() - exact).norm(), 1e-5);
  }
}

TEST(Sampler, TricubicDirectionOnASphere) {
  const Version v = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 40);
  Sampler sampler(v);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double sum = 0;
  const int n = 5000;
  for (int i = 0; i < n; ++i) {
    const Vec3d d = Vec3d(normal(random), normal(random), normal(random)).normalized();
    Vec3f g;
    sampler.tricubic(d * 80, g);
    const double sine = d.cross(g.cast<double>().normalized()).norm();
    sum += sine * sine;
  }
  EXPECT_LT(std::sqrt(sum / n) * 180 / M_PI, 0.05);  // degrees RMS
}

// A spline reads two voxels farther: beyond the band those only say so much.
TEST(Sampler, DistancesGoOnAtTheBandsEnd) {
  std::mt19937_64 random(7);
  constexpr double kFar = 2;
  for (const double bend : {0.0, 0.01}) {
    Vec3d normal = randomPoint(random, 1).normalized();
    const auto f = [&](const Vec3d& p) {
      const double d = normal.dot(p), aside = (p - d * normal).squaredNorm();
      return d + bend * (aside < 100 ? aside : 100) / 2;
    };
    const Version v = fieldOf(f);  // ±3 at most
    Sampler sampler(v);
    double worst = 0, plain = 0;
    int looked = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3d p = randomPoint(random, 5);
      const double exact = f(p);
      if (std::abs(exact) > kFar) continue;
      Vec3f unused;
      worst = std::max(worst, std::abs(sampler.distance(p) - exact));
      plain = std::max(plain, std::abs(sampler.tricubic(p, unused) - exact));
      ++looked;
    }
    EXPECT_GT(looked, 5000);
    EXPECT_LT(worst, 0.01) << bend;
    EXPECT_LT(worst, plain / 2) << "else little is gained";
  }
}

// Beside an edge splines swing over; a distance stays within what is around it.
TEST(Sampler, DistancesAreNoSteeperThanDistances) {
  Grid grid;
  const Version block = makeBlock(Store::make(), grid, Vec3d::Zero(), Vec3d(9, 8, 7), 0);
  Sampler sampler(block);
  std::mt19937_64 random(8);
  for (int i = 0; i < 20000; ++i) {
    const Vec3d p = randomPoint(random, 12);
    const Coord base{int(std::floor(p.x())), int(std::floor(p.y())), int(std::floor(p.z()))};
    const float here = sampler.distance(p);
    for (int c = 0; c < 8; ++c) {
      const Coord corner = base + Coord{c >> 2, (c >> 1) & 1, c & 1};
      EXPECT_LE(std::abs(here - sampler.voxel(corner)), (p - corner.toVec3d()).norm() + 1e-5);
    }
  }
}

TEST(Sampler, AnyNumberIsAnswered) {
  const Version v = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 5);
  Sampler sampler(v);
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(), 1e300, -1e18};
  for (const double x : bad)
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d p = Vec3d::Zero();
      p[axis] = x;
      Vec3f g;
      EXPECT_EQ(sampler.tricubic(p, g), 3);
      EXPECT_EQ(sampler.trilinear(p, g), 3);
      EXPECT_TRUE(g.allFinite());
    }
}

TEST(Sampler, AgreesWithThePlainLookUpEverywhere) {
  const Version v = makeSphere(Store::make(), Grid{}, Vec3d(3, 1, 2), 30);
  Sampler sampler(v);
  std::mt19937_64 random(4);
  for (int i = 0; i < 20000; ++i) {
    const Coord c{static_cast<int>(random() % 200) - 100, static_cast<int>(random() % 200) - 100,
                  static_cast<int>(random() % 200) - 100};
    ASSERT_EQ(sampler.voxel(c), v.find(c >> 3).phi(Brick::offset(c.x & 7, c.y & 7, c.z & 7), 3));
  }
}

// What is solved on several threads looks masks up in one editor.
TEST(Editor, IsReadByManyThreadsAtOnce) {
  constexpr int kRegions = 6, kThreads = 4, kLooks = 200'000;
  Editor editor(Version::empty(Store::make(), Grid{}));
  const auto brickOf = [](int region) { return Coord{8 * region, 0, 0}; };
  for (int region = 0; region < kRegions; ++region) {
    std::array<uint8_t, kBrickVoxels> values;
    values.fill(static_cast<uint8_t>(10 + region));
    editor.setChannel(Channel::mask, brickOf(region), values);
  }
  std::atomic<int> wrong{0};
  std::vector<std::jthread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < kLooks; ++i) {
        const int region = (i + t) % kRegions;
        wrong += editor.find(Channel::mask, brickOf(region)).value(0) != 10 + region;
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace argil::clay
