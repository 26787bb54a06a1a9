// What is fitted and compared for many cells at once, beside plain loops.

#include "clay/kernels/crease_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "clay/surface/tangent_plane.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr int kStepX = BrickSurroundings::kStepX, kStepY = BrickSurroundings::kStepY;

TEST(CreaseKernels, CellsAreFittedAsOneByOne) {
  std::mt19937 random(5);
  int flats = 0, others = 0;
  for (int round = 0; round < 20; ++round) {
    // A plane with bumps, some cells of which are bent, flat, near, far and without a slope.
    std::uniform_real_distribution<float> any(-1, 1);
    const Vec3f normal = Vec3f(any(random), any(random), any(random)).normalized() * (round % 3 == 2 ? 0.51f : 1.0f);
    const float bump = 0.05f * float(round % 4), offset = 3 * any(random);
    std::vector<float> phi(13 * kStepX, 1e9f);  // what is read beside the block shows
    for (int x = 0; x < 13; ++x)
      for (int y = 0; y < 13; ++y)
        for (int z = 0; z < 13; ++z)
          phi[size_t(x * kStepX + y * kStepY + z)] =
              normal.dot(Vec3f(float(x), float(y), float(z)) - Vec3f::Constant(6)) + offset + bump * any(random);
    const CellBends bends{.slight = 0.01f, .strong = 0.03f, .flat = 0.02f};
    tests::forEachSimdTarget([&](const std::string& name) {
      const auto fits = std::make_unique<CellFits>();
      fitCells(phi.data(), kStepX, kStepY, bends, *fits);
      for (int x = 0; x < kBlockCells; ++x)
        for (int y = 0; y < kBlockCells; ++y) {
          unsigned slight = 0, strong = 0;
          for (int z = 0; z < kBlockCells; ++z) {
            const auto at = [&](int c) {
              return phi[size_t((x + (c >> 2)) * kStepX + (y + (c >> 1 & 1)) * kStepY + z + (c & 1))];
            };
            // The plane through the corners by their mean and their slopes, and what it leaves of them.
            float mean = 0, bend = 0;
            Vec3f slope = Vec3f::Zero();
            for (int c = 0; c < 8; ++c) {
              mean += at(c) / 8;
              for (int axis = 0; axis < 3; ++axis) slope[axis] += (c >> (2 - axis) & 1 ? at(c) : -at(c)) / 4;
            }
            for (int c = 0; c < 8; ++c) {
              const Vec3f to = Vec3f(float(c >> 2), float(c >> 1 & 1), float(c & 1)) - Vec3f::Constant(0.5f);
              const float off = at(c) - mean - slope.dot(to);
              bend += off * off / 8;
            }
            slight |= unsigned{bend > bends.slight * bends.slight} << z;
            strong |= unsigned{bend > bends.strong * bends.strong} << z;
            const float steep = slope.norm(), distance = mean / steep, flat2 = bends.flat * bends.flat;
            const bool flat = bend < flat2 && steep > 0.5f && std::abs(distance) < 1.5f;
            (flat ? flats : others) += 1;
            EXPECT_EQ(fits->flat[x][y] >> z & 1, unsigned{flat}) << name << " " << x << " " << y << " " << z;
            EXPECT_NEAR(fits->quality[x][y][z], flat ? 1 - bend / flat2 : 0, 1e-3f);
            if (!flat) continue;
            EXPECT_NEAR(fits->distance[x][y][z], distance, 1e-5f);
            const Vec3f unit(fits->x[x][y][z], fits->y[x][y][z], fits->z[x][y][z]);
            EXPECT_LT((unit - slope / steep).norm(), 1e-5f);
          }
          EXPECT_EQ(fits->slight[x][y], slight) << name << " " << x << " " << y;
          EXPECT_EQ(fits->strong[x][y], strong) << name << " " << x << " " << y;
        }
    });
  }
  EXPECT_GT(flats, 1000);
  EXPECT_GT(others, 1000);
}

TEST(CreaseKernels, NormalsAgreeAsOneByOne) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(-1, 1);
  const auto normals = std::make_unique<CellFits>();
  int yes = 0, no = 0;
  for (int round = 0; round < 400; ++round) {
    // Where there is no plane the rest may be anything.
    std::fill_n(&normals->quality[0][0][0], sizeof(normals->quality) / sizeof(float), 0.0f);
    for (auto* each : {&normals->x, &normals->y, &normals->z})
      std::fill_n(&(*each)[0][0][0], sizeof(*each) / sizeof(float), round % 2 ? NAN : -1e30f);
    // Faces that turn by up to 45°, known in some of the cells, and what lies beyond the window turned right away.
    const float spread = 0.5f * float(round % 20) / 20;
    const int x = 2 + int(random() % 8), y = 2 + int(random() % 8), z = 2 + int(random() % 8);
    for (int i = 0; i < kBlockCells; ++i)
      for (int j = 0; j < kBlockCells; ++j)
        for (int k = 0; k < kBlockCells; ++k) {
          if (random() % 3 == 0) continue;
          const bool inside = std::max({std::abs(i - x), std::abs(j - y), std::abs(k - z)}) <= 2;
          const Vec3f n = inside ? Vec3f(1, spread * any(random), spread * any(random)).normalized() : Vec3f(-1, 0, 0);
          normals->x[i][j][k] = n.x(), normals->y[i][j][k] = n.y(), normals->z[i][j][k] = n.z();
          normals->quality[i][j][k] = 0.1f + 0.9f * std::abs(any(random));
        }
    const Vec3f p = Vec3f(float(x), float(y), float(z)) + 0.5f * Vec3f(any(random), any(random), any(random));
    const float most = 0.094f;
    const auto normalOf = [&](int i, int j, int k) {
      return Vec3f(normals->x[i][j][k], normals->y[i][j][k], normals->z[i][j][k]);
    };
    float heaviest = 0;
    Vec3f chosen = Vec3f::Zero();
    for (int i = x - 2; i <= x + 2; ++i)
      for (int j = y - 2; j <= y + 2; ++j)
        for (int k = z - 2; k <= z + 2; ++k) {
          const float d2 = 0.25f + (Vec3f(float(i), float(j), float(k)) - p).squaredNorm();
          if (const float weight = normals->quality[i][j][k] / (d2 * d2); weight > heaviest)
            heaviest = weight, chosen = normalOf(i, j, k);
        }
    float turned = 0;
    for (int i = x - 2; i <= x + 2; ++i)
      for (int j = y - 2; j <= y + 2; ++j)
        for (int k = z - 2; k <= z + 2; ++k)
          if (normals->quality[i][j][k] > 0) turned = std::max(turned, 1 - chosen.dot(normalOf(i, j, k)));
    if (std::abs(turned - most) < 1e-5f) continue;  // either answer is right
    (turned < most ? yes : no) += 1;
    tests::forEachSimdTarget([&](const std::string& name) {
      EXPECT_EQ(normalsAgree(*normals, x, y, z, p.data(), most), turned < most) << name << " " << round;
    });
  }
  EXPECT_GT(yes, 50);
  EXPECT_GT(no, 50);
}

}  // namespace
}  // namespace argil::clay
