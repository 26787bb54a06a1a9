// Bricks with voxels of their neighbours around them, against voxels read one by one.

#include "clay/store/brick_margins.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "clay/field/primitives.h"
#include "clay/kernels/smoothing_kernels.h"
#include "clay/kernels/warp_kernels.h"
#include "clay/store/store.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

class Margins : public ::testing::TestWithParam<Precision> {
 protected:
  // Bricks, tiles inside and tiles outside next to each other.
  const Version ball_ = makeSphere(Store::make(GetParam()), Grid{}, Vec3d(0.3, 0.2, 0.1), 12.4);
  // Of the ball's lower half, and somewhat beyond.
  template <class Visit>
  void forPlaces(const Visit& visit) {
    for (int x = -3; x <= 2; ++x)
      for (int y = -3; y <= 0; ++y)
        for (int z = -3; z <= 2; ++z) visit(Coord{x, y, z});
  }
};

TEST_P(Margins, GatheringIsReadingVoxelByVoxel) {
  Sampler field(ball_), again(ball_);
  forPlaces([&](Coord coord) {
    const auto expectVoxels = [&](int margin, const float* gathered, const auto& offset) {
      for (int x = -margin; x < kBrickEdge + margin; ++x)
        for (int y = -margin; y < kBrickEdge + margin; ++y)
          for (int z = -margin; z < kBrickEdge + margin; ++z)
            ASSERT_EQ(gathered[offset(x, y, z)], again.voxel(coord * kBrickEdge + Coord{x, y, z}))
                << margin << ": " << x << " " << y << " " << z;
    };
    float padded[kPaddedSize], broad[kBroadSize];
    gatherPadded(field, coord, padded);
    expectVoxels(1, padded, [](int x, int y, int z) { return paddedOffset(x + 1, y + 1, z + 1); });
    for (const int margin : {1, 2, 4}) {
      gatherBroad(field, coord, margin, broad);
      expectVoxels(margin, broad, [](int x, int y, int z) { return broadOffset(x + 4, y + 4, z + 4); });
    }
  });
}

TEST_P(Margins, WhatStandsInsteadOfABrickCountsThereAlone) {
  Sampler field(ball_), again(ball_);
  BrickValues other;
  for (int i = 0; i < kBrickVoxels; ++i) other[i] = static_cast<float>(1000 + i);
  const Coord coord{-1, -1, 0};
  float broad[kBroadSize];
  for (size_t k = 0; k < kBricksAround; ++k) {
    std::array<const float*, kBricksAround> instead{};
    instead[k] = other;
    EXPECT_EQ(aroundNumber(kAroundSteps[k]), k);
    gatherBroad(field, coord, 4, broad, instead.data());
    for (int x = -4; x < 12; ++x)
      for (int y = -4; y < 12; ++y)
        for (int z = -4; z < 12; ++z) {
          const Coord in{x, y, z};
          const bool there = in >> kBrickBits == kAroundSteps[k];
          const float wanted = there ? other[Brick::offset(x & 7, y & 7, z & 7)] : again.voxel(coord * kBrickEdge + in);
          ASSERT_EQ(broad[broadOffset(x + 4, y + 4, z + 4)], wanted) << k << ": " << x << " " << y << " " << z;
        }
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, Margins, ::testing::Values(Precision::float32, Precision::fixed16),
                         [](const auto& of) { return of.param == Precision::float32 ? "float32" : "fixed16"; });

TEST(BrickMargins, BesideEachIsAskingForEach) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> place(-4, 4);
  for (const int count : {0, 1, 20, 300}) {
    std::vector<Coord> bricks;
    for (int i = 0; i < count; ++i) bricks.push_back({place(random), place(random), place(random)});
    std::sort(bricks.begin(), bricks.end());
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    const auto beside = besideEach(std::span<const Coord>(bricks), kAroundSteps);
    ASSERT_EQ(beside.size(), bricks.size());
    for (size_t i = 0; i < bricks.size(); ++i)
      for (size_t k = 0; k < kBricksAround; ++k) {
        const auto at = std::find(bricks.begin(), bricks.end(), bricks[i] + kAroundSteps[k]);
        EXPECT_EQ(beside[i][k], at == bricks.end() ? -1 : at - bricks.begin());
      }
  }
}

TEST(BrickMargins, RedistancingBeginsWithWhatIsKnown) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(-4, 4);
  float broad[kBroadSize] = {}, near[kPaddedSize];
  for (float& each : broad) each = value(random);
  for (float& each : near) each = std::abs(value(random));
  broad[broadOffset(5, 6, 7)] = broad[broadOffset(2, 3, 4)] = 0;
  uint64_t frozen[kBrickEdge];
  for (uint64_t& word : frozen) word = uint64_t{random()} << 32 | random();
  constexpr float kBand = 3;
  tests::forEachSimdTarget([&](const std::string& target) {
    float wide[kWideSize];
    startWide(broad, near, frozen, kBand, wide);
    for (int x = -2; x < 10; ++x)
      for (int y = -2; y < 10; ++y)
        for (int z = -2; z < 10; ++z) {
          const float phi = broad[broadOffset(x + 4, y + 4, z + 4)];
          const bool own = ((x | y | z) & ~7) == 0;
          const bool known = own ? (frozen[x & 7] >> ((y & 7) * 8 + (z & 7))) & 1 : std::abs(phi) < kBand;
          const float size = !known ? kUnknownDistance : own ? near[paddedOffset(x + 1, y + 1, z + 1)] : std::abs(phi);
          ASSERT_EQ(wide[wideOffset(x + 2, y + 2, z + 2)], phi < 0 ? -size : size)
              << target << " " << x << " " << y << " " << z;
        }
  });
}

// Against the product of rows of Pascal's triangle, in double.
TEST(BrickMargins, MeansOfPassesAreBinomial) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> value(-3, 3);
  float broad[kBroadSize] = {};
  for (float& each : broad) each = value(random);
  constexpr double kPascal[5][9] = {
      {1}, {1, 2, 1}, {1, 4, 6, 4, 1}, {1, 6, 15, 20, 15, 6, 1}, {1, 8, 28, 56, 70, 56, 28, 8, 1}};
  for (int passes = 0; passes <= 4; ++passes) {
    constexpr float kShift = 0.3f, kBand = 0.5f;  // so that some are cut off
    const int width = 2 * passes + 1;
    BrickValues exact, first;
    for (int v = 0; v < kBrickVoxels; ++v) {
      double sum = 0;
      for (int i = 0; i < width * width * width; ++i) {
        const int a = i / (width * width), b = i / width % width, c = i % width;
        sum += kPascal[passes][a] * kPascal[passes][b] * kPascal[passes][c] *
               broad[broadOffset((v >> 6) + 4 + a - passes, ((v >> 3) & 7) + 4 + b - passes, (v & 7) + 4 + c - passes)];
      }
      exact[v] = static_cast<float>(std::clamp(sum / std::pow(4.0, 3 * passes) - kShift, -0.5, 0.5));
    }
    bool begun = false;
    tests::forEachSimdTarget([&](const std::string& target) {
      BrickValues mean;
      const float least = broadMeans(broad, passes, kShift, kBand, mean);
      float smallest = kBand;
      for (int v = 0; v < kBrickVoxels; ++v) {
        ASSERT_NEAR(mean[v], exact[v], 1e-6) << target << " " << passes << " " << v;
        smallest = std::min(smallest, std::abs(mean[v]));
      }
      EXPECT_EQ(least, smallest) << target;
      EXPECT_TRUE(!begun || std::memcmp(mean, first, sizeof mean) == 0) << target;
      std::memcpy(first, mean, sizeof mean);
      begun = true;
    });
  }
}

// Slopes of cells, in double: planes of any direction, of a wrong slope, with a kink that one cell alone sees, and
// beyond what counts.
TEST(BrickMargins, SlopesOfOneAreToldFromOthers) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> away(-6, 6), slope(0.94, 1.06);
  int ones = 0;
  for (int round = 0; round < 2000; ++round) {
    const Vec3d n = Vec3d(normal(random), normal(random), normal(random)).normalized() * slope(random);
    const double d = away(random);
    BrickValues values;
    for (int v = 0; v < kBrickVoxels; ++v)
      values[v] = static_cast<float>(n.dot(Vec3d((v >> 6) - 3.5, ((v >> 3) & 7) - 3.5, (v & 7) - 3.5)) + d);
    if (round % 2 != 0) values[random() % kBrickVoxels] += 0.3f;
    constexpr float kWithin = 2, kTolerance = 0.03f;
    bool one = true, close = false;
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (v >> 6 == 7 || (v >> 3 & 7) == 7 || (v & 7) == 7) continue;
      Vec3d g = Vec3d::Zero();
      double middle = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const double value = values[v + 64 * (corner >> 2) + 8 * (corner >> 1 & 1) + (corner & 1)];
        g += value / 4 * Vec3d(corner >> 2 ? 1 : -1, corner >> 1 & 1 ? 1 : -1, corner & 1 ? 1 : -1);
        middle += value / 8;
      }
      const double off = std::abs(g.norm() - 1) - kTolerance;
      close = close || std::abs(off) < 1e-5 || std::abs(std::abs(middle) - kWithin) < 1e-5;
      one = one && (std::abs(middle) > kWithin || off < 0);
    }
    if (close) continue;
    ones += one;
    tests::forEachSimdTarget([&](const std::string& target) {
      EXPECT_EQ(isSlopeOne(values, kWithin, kTolerance), one) << target << " " << round;
    });
  }
  EXPECT_GT(ones, 200);
  EXPECT_LT(ones, 1800);
}

TEST(BrickMargins, StepsFromVoxelToVoxelAreSeenAcrossFacesToo) {
  std::mt19937 random(7);
  for (int round = 0; round < 1000; ++round) {
    float padded[kPaddedSize] = {};
    const int at[3] = {int(random() % 10), int(random() % 10), int(random() % 10)};
    padded[paddedOffset(at[0], at[1], at[2])] = round % 2 != 0 ? 1.06f : -1.06f;
    // Beside a voxel of the brick, or one of it.
    const auto rim = std::count_if(at, at + 3, [](int k) { return k == 0 || k == 9; });
    tests::forEachSimdTarget([&](const std::string& target) {
      EXPECT_EQ(isSteep(padded, 1.05f), rim < 2) << target << " " << at[0] << " " << at[1] << " " << at[2];
      EXPECT_FALSE(isSteep(padded, 1.07f)) << target;
    });
  }
}

TEST(BrickMargins, ATableBendsValues) {
  float table[kBendSteps + 2];
  for (int i = 0; i <= kBendSteps; ++i) table[i] = static_cast<float>(std::sqrt(i));
  table[kBendSteps + 1] = table[kBendSteps];
  constexpr float kScale = 100;
  BrickValues first;
  for (int v = 0; v < kBrickVoxels; ++v) first[v] = static_cast<float>(v - 256) * 0.0131f;
  tests::forEachSimdTarget([&](const std::string& target) {
    BrickValues bent;
    std::memcpy(bent, first, sizeof bent);
    bendValues(table, kScale, bent);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const double at = std::min(std::abs(double{first[v]}) * kScale, double{kBendSteps}), low = std::floor(at);
      const double exact = std::sqrt(low) + (at - low) * (std::sqrt(std::min(low + 1, 256.0)) - std::sqrt(low));
      ASSERT_NEAR(bent[v], std::copysign(exact, first[v]), 2e-4) << target << " " << v;
    }
  });
}

// Voxels that stay, that move by whole voxels, that came from between two, with a window that just holds them.
TEST(BrickMargins, TheNearestVoxelSaysWhatIsFarFromTheSurface) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> by(-3.4f, 5.4f), value(-4, 4);
  constexpr int kLow = -4, kEdge = 18;
  std::vector<float> values(kEdge * kEdge * (kEdge + 1));
  for (float& each : values) each = std::clamp(value(random), -3.0f, 3.0f);
  const VoxelWindow window{values.data(), kLow, kLow, kLow, kEdge, kEdge + 1};
  BrickValues now;
  for (float& each : now) each = value(random);
  MovedVoxels moved{};
  for (int i = 0; i < 1000; ++i) {
    if (i % 5 == 0) continue;  // stays
    moved.x[i] = i % 7 == 0 ? 2.5f : by(random), moved.y[i] = i % 11 == 0 ? -1.0f : by(random);
    moved.z[i] = i % 13 == 0 ? 0.49995f : by(random);
  }
  int sure = 0;
  tests::forEachSimdTarget([&](const std::string& target) {
    float phi[kBrickVoxels];
    uint64_t doubtful[kBrickEdge];
    nearestValues(moved, window, now, 3, phi, doubtful);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int x = i >> 6, y = (i >> 3) & 7, z = i & 7, at = ((x + 1) * 10 + y + 1) * 10 + z + 1;
      const bool open = (doubtful[x] >> (i & 63)) & 1;
      const float d[3] = {moved.x[at], moved.y[at], moved.z[at]};
      if (d[0] == 0 && d[1] == 0 && d[2] == 0) {
        EXPECT_FALSE(open);
        EXPECT_EQ(phi[i], now[i]);
        continue;
      }
      const auto to = [&](int voxel, float step) { return voxel + static_cast<int>(std::lround(step)) - kLow; };
      const bool between = std::any_of(d, d + 3, [](float each) { return std::abs(each - std::rint(each)) > 0.4999f; });
      const float nearest =
          values[static_cast<size_t>((to(x, d[0]) * kEdge + to(y, d[1])) * (kEdge + 1) + to(z, d[2]))];
      EXPECT_EQ(open, between || std::abs(nearest) < 3) << target << " " << i;
      if (open) continue;
      EXPECT_EQ(phi[i], nearest) << target << " " << i;
      ++sure;
    }
  });
  EXPECT_GT(sure, 50);
}

}  // namespace
}  // namespace argil::clay
