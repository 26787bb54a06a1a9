#include "ui3d/studio/files/new_clay.h"

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"

namespace argil::studio {
namespace {

engine::Document ballOf(double acrossMm) {
  clay::Grid grid;
  grid.voxelMm = acrossMm / 40;
  engine::Piece piece;
  piece.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), acrossMm / 2);
  engine::Document document;
  document.add(std::move(piece));
  return document;
}

TEST(NewClay, IsAHandsSizeInAnEmptyDocument) {
  NewClay clay;
  clay.fit({});
  EXPECT_EQ(clay.xMm, 60);
  EXPECT_EQ(clay.voxelMm, 0.5);
}

TEST(NewClay, IsFromAHalfToAQuarterMoreOfWhatIsThere) {
  for (const double across : {0.2, 1.0, 29.0, 60.0, 61.0, 100.0, 119.0, 400.0, 2000.0, 3e4}) {
    SCOPED_TRACE(across);
    NewClay clay;
    clay.fit(ballOf(across));
    EXPECT_GT(2 * clay.radiusMm, 0.49 * across);
    EXPECT_LT(2 * clay.radiusMm, 1.3 * across);  // Ours is a voxel wider than it says.
    EXPECT_NEAR(clay.voxelMm / clay.radiusMm, 0.5 / 30, 1e-12) << "as fine for its size";
    EXPECT_NEAR(clay.roundMm / clay.xMm, 4.0 / 60, 1e-12);
  }
  NewClay small;
  small.fit(ballOf(0.04));
  EXPECT_GE(small.voxelMm, 0.001) << "finer than grids go";
  NewClay clay;
  clay.fit(ballOf(60));
  EXPECT_EQ(clay.xMm, 60) << "beside the first block the standard sizes";
  clay.fit(ballOf(2000));
  EXPECT_NEAR(clay.xMm, 1200, 1e-9) << "a round number";
}

TEST(NewClay, WhatWasChosenIsKeptWhileTheModelIsOfOneSize) {
  NewClay clay;
  clay.fit(ballOf(60));
  clay.zMm = 10;
  clay.fit(ballOf(70));
  EXPECT_EQ(clay.zMm, 10);
  clay.fit(ballOf(600));
  EXPECT_NEAR(clay.zMm, 100, 1e-9);
  clay.fit(ballOf(60));
  EXPECT_NEAR(clay.zMm, 10, 1e-9) << "and back";
}

}  // namespace
}  // namespace argil::studio
