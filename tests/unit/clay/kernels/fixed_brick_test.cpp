// Bricks of 16-bit distances: the codes, and a store of them.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/kernels/fixed_brick.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/change_precision.h"
#include "clay/whole/resample.h"
#include "tests/unit/clay/clay_checks.h"

namespace argil::clay {
namespace {

TEST(FixedBrick, CodesRoundToTheNearestOnTheirSide) {
  std::mt19937_64 random(20261120);
  for (const float band : {2.0f, 2.5f, 3.0f, 3.7f, 4.0f, 8.0f}) {
    const float step = stepOf(Precision::fixed16, band);
    ASSERT_EQ(static_cast<float>(kMostCode) * step, band);
    BrickValues values, back;
    int16_t codes[kBrickVoxels], mirrored[kBrickVoxels], again[kBrickVoxels];
    for (float& value : values) value = std::uniform_real_distribution<float>(-band, band)(random);
    values[0] = band, values[1] = -band, values[2] = 0, values[3] = 1e-9f, values[4] = -1e-9f, values[5] = -1e-42f,
    values[6] = std::nextafter(-band, 0.0f);
    ASSERT_TRUE(packDistances(values, band, codes));
    unpackDistances(codes, step, back);
    for (int i = 0; i < kBrickVoxels; ++i) {
      EXPECT_LE(std::abs(back[i] - values[i]), (values[i] < 0 && values[i] > -step ? 1.0f : 0.5001f) * step)
          << values[i];
      EXPECT_EQ(back[i] < 0, values[i] < 0) << values[i];
      EXPECT_FALSE(std::signbit(back[i]) && back[i] == 0);
    }
    EXPECT_EQ(back[0], band);
    EXPECT_EQ(back[1], -band);
    EXPECT_EQ(back[2], 0);
    EXPECT_EQ(codes[4], -1);
    EXPECT_EQ(codes[5], -1);
    EXPECT_EQ(codes[6], -kMostCode);
    // What was packed is packed as itself, and mirrored distances have mirrored codes but for the one step that keeps a
    // side.
    ASSERT_TRUE(packDistances(back, band, again));
    for (int i = 0; i < kBrickVoxels; ++i) EXPECT_EQ(again[i], codes[i]);
    for (float& value : values) value = value == 0 ? 0 : -value;
    ASSERT_TRUE(packDistances(values, band, mirrored));
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (std::abs(values[i]) > step) {
        EXPECT_EQ(mirrored[i], -codes[i]);
      }
    }
    // Every code is itself.
    for (int first = -kMostCode; first <= kMostCode; first += kBrickVoxels) {
      for (int i = 0; i < kBrickVoxels; ++i) codes[i] = static_cast<int16_t>(std::min(first + i, kMostCode));
      unpackDistances(codes, step, back);
      packDistances(back, band, again);
      for (int i = 0; i < kBrickVoxels; ++i) {
        ASSERT_EQ(again[i], codes[i]);
        ASSERT_LE(std::abs(back[i]), band);
      }
    }
    // Nothing of a band that rounds away is left.
    for (float& value : values) value = std::nextafter(band, 0.0f);
    EXPECT_FALSE(packDistances(values, band, codes));
  }
}

TEST(FixedBrick, TakesHalfTheMemory) {
  EXPECT_LE(sizeof(FixedBrick), 1228u);  // 1.2 KiB
  const Version floats = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 30),
                fixed = makeSphere(Store::make(Precision::fixed16), Grid{}, Vec3d::Zero(), 30);
  EXPECT_EQ(floats.stats().bricks, fixed.stats().bricks);
  EXPECT_EQ(fixed.stats().bytes() - fixed.stats().nodes * 4160, fixed.stats().bricks * sizeof(FixedBrick));
  EXPECT_LT(double(fixed.stats().bytes()), 0.56 * double(floats.stats().bytes()));
}

TEST(FixedBrick, ReadsTheSameWholeInRowsAndByVoxel) {
  const Version clay = makeSphere(Store::make(Precision::fixed16), Grid{}, Vec3d(0.3, 0.2, 0.1), 12);
  clay.forEachBrick([&](const Brick& brick) {
    ASSERT_NE(brick.step, 0);
    BrickValues room, rows;
    const BrickValues& all = brick.values(room);
    for (int row = 0; row < kBrickVoxels; row += 8) brick.read(row, 8, rows + row);
    for (int i = 0; i < kBrickVoxels; ++i) {
      ASSERT_EQ(std::bit_cast<uint32_t>(all[i]), std::bit_cast<uint32_t>(brick.phi(i)));
      ASSERT_EQ(std::bit_cast<uint32_t>(all[i]), std::bit_cast<uint32_t>(rows[i]));
      ASSERT_EQ((brick.inside[i >> 6] >> (i & 63)) & 1, uint64_t{all[i] < 0});
    }
  });
}

TEST(FixedBrick, EqualContentKeepsItsBrickAndWorkBricksGoBack) {
  const auto store = Store::make(Precision::fixed16);
  const Version clay = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  Editor editor(clay);
  clay.forEachBrick([&](const Brick& brick) {
    std::array<float, kBrickVoxels> moved = testing::valuesOf(brick);
    for (float& value : moved)
      if (std::abs(value) > 0.001f && std::abs(value) < 2.9f) value += 1e-6f;  // less than a step
    editor.setVoxels(brick.coord, moved);
  });
  EXPECT_EQ(editor.counts().bricksMade, 0u);
  EXPECT_EQ(editor.commit(), clay);
  // Back to nothing: every brick becomes a tile.
  Editor clear(clay);
  clay.forEachBrick([&](const Brick& brick) {
    std::array<float, kBrickVoxels> far;
    far.fill(std::nextafter(3.0f, 0.0f));
    clear.setVoxels(brick.coord, far);
  });
  const Version empty = clear.commit();
  EXPECT_EQ(empty.stats().bricks, 0u);
}

TEST(FixedBrick, ChangesThereAndBack) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d(0.3, 0.2, 0.1), 20);
  Editor editor(ball);
  ball.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> mask;
    for (int i = 0; i < kBrickVoxels; ++i)
      mask[size_t(i)] = std::abs(brick.phi(i)) < 3 ? uint8_t(1 + i % 255) : uint8_t{0};
    editor.setChannel(Channel::mask, brick.coord, mask);
  });
  const Version painted = editor.commit();
  const Version fixed = withPrecision(painted, Precision::fixed16), back = withPrecision(fixed, Precision::float32),
                again = withPrecision(back, Precision::fixed16);
  EXPECT_EQ(fixed.store()->precision(), Precision::fixed16);
  EXPECT_EQ(fixed.hash(), again.hash());
  double worst = 0;
  uint64_t lost = 0;
  painted.forEachBrick([&](const Brick& brick) {
    const Slot there = back.find(brick.coord);
    for (int i = 0; i < kBrickVoxels; ++i) {
      worst = std::max(worst, double(std::abs(there.phi(i, 3) - brick.phi(i))));
      ASSERT_EQ(there.phi(i, 3) < 0, brick.phi(i) < 0);
      lost += std::abs(there.phi(i, 3)) < 3 &&
              painted.find(Channel::mask, brick.coord).value(i) != back.find(Channel::mask, brick.coord).value(i);
    }
  });
  EXPECT_LE(worst, 4.6e-5 * 2);  // half a step, a whole one beside zero
  EXPECT_EQ(lost, 0u);
}

TEST(FixedBrick, ResultsKeepThePrecisionOfTheirSource) {
  const Version fixed = makeSphere(Store::make(Precision::fixed16), Grid{}, Vec3d::Zero(), 20),
                floats = makeSphere(Store::make(), Grid{}, Vec3d(6, 0, 0), 15);
  EXPECT_EQ(combine(fixed, floats, Combination::join).store()->precision(), Precision::fixed16);
  EXPECT_EQ(combine(floats, fixed, Combination::cut).store()->precision(), Precision::float32);
  Grid coarse;
  coarse.voxelMm = 0.8;
  EXPECT_EQ(resample(fixed, coarse, Eigen::Isometry3d::Identity()).store()->precision(), Precision::fixed16);
  Grid odd;
  odd.band = std::nextafter(4.0f, 0.0f);
  EXPECT_THROW((void)Version::empty(Store::make(Precision::fixed16), odd), Error);
}

}  // namespace
}  // namespace argil::clay
