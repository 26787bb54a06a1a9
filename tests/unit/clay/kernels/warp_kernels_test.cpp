// What moves clay, many places at once, beside plain arithmetic in double precision.

#include "clay/kernels/warp_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "clay/base/vec.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr int kSmooth = 1;  // (1 − t²)²
constexpr int kSteps = 3;

// The flow of one image at a place: its weight, and what that moves.
std::pair<double, Vec3d> flowOf(const WarpImage& image, const Vec3d& place, double time) {
  const Vec3d d(double(image.dx), double(image.dy), double(image.dz)),
      n(double(image.nx), double(image.ny), double(image.nz)),
      spin(double(image.spinX), double(image.spinY), double(image.spinZ));
  Vec3d e = place - Vec3d(double(image.ax), double(image.ay), double(image.az));
  const double t = image.fromSegment ? std::clamp(e.dot(d) * double(image.inverseLength2), 0.0, 1.0) : time;
  e -= t * d;
  const double radius = double(image.radius) + t * double(image.growth), t2 = e.squaredNorm() / (radius * radius);
  const double w = t2 < 1 ? (1 - t2) * (1 - t2) : 0;
  return {w, w * (double(image.move) * d - double(image.pull) * (e - n * n.dot(e)) + double(image.lift) * n +
                  spin.cross(e))};
}

Vec3d velocity(std::span<const WarpImage> images, const Vec3d& place, double time) {
  double sum = 0, left = 1;
  Vec3d flow = Vec3d::Zero();
  for (const WarpImage& image : images) {
    if (!image.active) continue;
    const auto [w, v] = flowOf(image, place, time);
    sum += w, left *= 1 - w, flow += v;
  }
  return images.size() == 1 || sum == 0 ? flow : Vec3d(flow * ((1 - left) / sum));
}

Vec3d traced(std::span<const WarpImage> images, Vec3d at) {
  const double step = 1.0 / kSteps;
  for (int i = kSteps; i > 0; --i) {
    const Vec3d k1 = velocity(images, at, i * step), k2 = velocity(images, at - 0.5 * step * k1, (i - 0.5) * step),
                k3 = velocity(images, at - 0.5 * step * k2, (i - 0.5) * step),
                k4 = velocity(images, at - step * k3, (i - 1) * step);
    at -= step / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return at;
}

WarpImage randomImage(std::mt19937& random) {
  std::uniform_real_distribution<float> any(-1, 1);
  WarpImage image{};
  image.ax = 6 * any(random), image.ay = 6 * any(random), image.az = 6 * any(random);
  image.dx = 2 * any(random), image.dy = 2 * any(random), image.dz = 2 * any(random);
  image.inverseLength2 = 1 / (image.dx * image.dx + image.dy * image.dy + image.dz * image.dz);
  image.radius = 3 + any(random), image.growth = 1.5f * any(random);
  image.move = 0.3f * any(random), image.pull = 0.2f * any(random), image.lift = 0.3f * any(random);
  image.nz = 1;
  image.spinX = 0.1f * any(random), image.spinY = 0.1f * any(random), image.spinZ = 0.2f * any(random);
  image.fromSegment = any(random) > 0;
  image.active = any(random) > -0.7f;
  return image;
}

// Tips of one voxel to several, some beside the block: most places are reached by none, and stay where they are.
TEST(WarpKernels, PlacesAreTracedAsOneByOne) {
  std::mt19937 random(7);
  int moved = 0, stayed = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<WarpImage> images;
    for (int i = 0; i <= round % 4; ++i) images.push_back(randomImage(random));
    std::vector<Vec3d> expected;
    for (int i = 0; i < kBlockNodes; ++i)
      expected.push_back(traced(images, Vec3d((i >> 6) - 3.5, (i >> 3 & 7) - 3.5, (i & 7) - 3.5)));
    const auto places = std::make_unique<NodePlaces>(), first = std::make_unique<NodePlaces>();
    bool any = false;
    tests::forEachSimdTarget([&](const std::string& name) {
      traceBack(images, kSmooth, kSteps, 1, *places);
      for (int i = 0; i < kBlockNodes; ++i) {
        const Vec3d found(double(places->x[i]), double(places->y[i]), double(places->z[i])),
            own((i >> 6) - 3.5, (i >> 3 & 7) - 3.5, (i & 7) - 3.5);
        // Places are multiples of 2⁻¹⁶.
        EXPECT_LT((found - expected[size_t(i)]).norm(), 3e-5) << name << " " << round << " " << i;
        (expected[size_t(i)] == own ? stayed : moved) += 1;
        if (expected[size_t(i)] == own) {
          EXPECT_EQ(found, own);
        }
        if (any) {
          EXPECT_EQ(places->x[i], first->x[i]);
          EXPECT_EQ(places->y[i], first->y[i]);
          EXPECT_EQ(places->z[i], first->z[i]);
        }
      }
      if (!any) *first = *places;
      any = true;
    });
  }
  EXPECT_GT(moved, 1000);
  EXPECT_GT(stayed, 1000);
}

// Displacements that are cubic along each axis are told exactly, and those of a mirror image are the mirror's.
TEST(WarpKernels, DisplacementsAreComposedAsOneByOne) {
  constexpr int kMargin = 4, n = 8 + 2 * kMargin;
  const auto cubic = [](const Vec3d& p) {
    const Vec3d q = 0.1 * p;
    return Vec3d(q.x() * q.x() * q.x() - q.y() * q.z(), q.y() * q.y() + q.x() * q.z() * q.z() * q.z(),
                 0.5 * q.z() - q.x() * q.y() * q.y() * q.y());
  };
  std::vector<Displacement> window(size_t{n} * n * n), turned(window.size());
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const Vec3d d = cubic(Vec3d(x, y, z) - Vec3d::Constant(kMargin + 3.5));
        const Displacement of{float(d.x()), float(d.y()), float(d.z())};
        window[size_t((x * n + y) * n + z)] = of;
        turned[size_t(((n - 1 - x) * n + y) * n + (n - 1 - z))] = {-of.x, of.y, -of.z};
      }
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1.9f, 1.9f);
  const auto places = std::make_unique<NodePlaces>(), mirrored = std::make_unique<NodePlaces>();
  const auto imageOf = [](int i) { return (7 - (i >> 6)) << 6 | (i & 56) | (7 - (i & 7)); };
  for (int i = 0; i < kBlockNodes; ++i) {
    const bool same = i % 5 == 0;
    const auto at = [&](int node) { return float(node) - 3.5f + (same ? 0 : std::round(any(random) * 64) / 64); };
    places->x[i] = at(i >> 6), places->y[i] = at(i >> 3 & 7), places->z[i] = at(i & 7);
    const int j = imageOf(i);
    mirrored->x[j] = -places->x[i], mirrored->y[j] = places->y[i], mirrored->z[j] = -places->z[i];
  }
  std::array<Displacement, kBlockNodes> first{};
  bool known = false;
  tests::forEachSimdTarget([&](const std::string& name) {
    std::array<Displacement, kBlockNodes> out, image;
    composeDisplacements(*places, 1, window.data(), kMargin, out.data());
    composeDisplacements(*mirrored, 1, turned.data(), kMargin, image.data());
    for (int i = 0; i < kBlockNodes; ++i) {
      const Vec3d place(double(places->x[i]), double(places->y[i]), double(places->z[i])),
          own((i >> 6) - 3.5, (i >> 3 & 7) - 3.5, (i & 7) - 3.5), expected = cubic(place) + place - own;
      const Displacement &found = out[size_t(i)], &other = image[size_t(imageOf(i))];
      EXPECT_LT((Vec3d(double(found.x), double(found.y), double(found.z)) - expected).norm(), 2e-6) << name << " " << i;
      EXPECT_EQ(other.x, -found.x);
      EXPECT_EQ(other.y, found.y);
      EXPECT_EQ(other.z, -found.z);
      if (!known) continue;
      EXPECT_EQ(found.x, first[size_t(i)].x) << name;
      EXPECT_EQ(found.y, first[size_t(i)].y) << name;
      EXPECT_EQ(found.z, first[size_t(i)].z) << name;
    }
    first = out;
    known = true;
  });
}

// The same of nodes that are refined: places along each axis by their own weights.
TEST(WarpKernels, DisplacementsAreRefinedAsOneByOne) {
  constexpr int n = 9;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  std::vector<Displacement> window(size_t{n} * n * n);
  for (Displacement& d : window) d = {any(random), any(random), any(random)};
  int firsts[3][10];
  float weights[3][10][4];
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 10; ++i) {
      firsts[axis][i] = int(random() % (n - 3));
      for (float& w : weights[axis][i]) w = any(random);
    }
  tests::forEachSimdTarget([&](const std::string& name) {
    std::vector<Displacement> scratch(10 * n * n + 100 * n), out(1000);
    refineDisplacements(window.data(), n, firsts, weights, scratch.data(), out.data());
    for (int i = 0; i < 1000; ++i) {
      const int at[3] = {i / 100, i / 10 % 10, i % 10};
      Vec3d sum = Vec3d::Zero();
      for (int k = 0; k < 64; ++k) {
        const int step[3] = {k >> 4, k >> 2 & 3, k & 3};
        double w = 1;
        int node = 0;
        for (int axis = 0; axis < 3; ++axis) {
          w *= double(weights[axis][at[axis]][step[axis]]);
          node = node * n + firsts[axis][at[axis]] + step[axis];
        }
        const Displacement& d = window[size_t(node)];
        sum += w * Vec3d(double(d.x), double(d.y), double(d.z));
      }
      const Displacement& found = out[size_t(i)];
      EXPECT_LT((Vec3d(double(found.x), double(found.y), double(found.z)) - sum).norm(), 1e-5) << name << " " << i;
    }
  });
}

}  // namespace
}  // namespace argil::clay
