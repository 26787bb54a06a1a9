// Pieces that a printer would make one body of.

#include "engine/print/pieces_meet.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::engine {
namespace {

PlacedClay ball(const Vec3d& at, double radius, double voxelMm = 0.25) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  return {clay::makeSphere(clay::Store::make(), grid, at, radius), {}};
}
PlacedClay block(const Vec3d& middle, const Vec3d& edges, double voxelMm = 0.25) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  return {clay::makeBlock(clay::Store::make(), grid, middle, edges, 0), {}};
}
haptics::Pose turned(double radians, const Vec3d& axis, const Vec3d& by) {
  return {by, Eigen::Quaterniond(Eigen::AngleAxisd(radians, axis.normalized()))};
}

TEST(PiecesMeet, BallsAtAnyDistanceAndTurn) {
  std::mt19937 random(1126);
  std::uniform_real_distribution<double> unit(-1, 1), apart(-2, 1);
  for (int i = 0; i < 30; ++i) {
    const double gap = apart(random);
    const Vec3d way = Vec3d(unit(random), unit(random), unit(random)).normalized();
    // Each in a frame of its own.
    const haptics::Pose a = turned(2 * unit(random), way, {3, 1, 4}), b = turned(1, Vec3d(1, 2, 3), {-2, 5, 0});
    PlacedClay one = ball({0, 0, 0}, 5), other = ball(b.applyInverse(a.translation + (9 + gap) * way), 4, 0.2);
    one.pose = a, other.pose = b;
    const std::vector<PlacedClay> both{one, other};
    const std::vector<PiecesMeet> found = piecesThatMeet(both, 0.6, nullptr);
    SCOPED_TRACE(gap);
    if (gap > 0.65) {
      EXPECT_TRUE(found.empty());
      continue;
    }
    if (gap > 0.55) continue;
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].first, 0u);
    EXPECT_EQ(found[0].second, 1u);
    if (std::abs(gap) < 0.05) continue;
    EXPECT_EQ(found[0].overlap, gap < 0);
    EXPECT_NEAR(found[0].mm, std::abs(gap), 0.03);
    EXPECT_LT((found[0].atMm - (a.translation + 5 * way)).norm(), 2.5 + std::abs(gap));
  }
}

TEST(PiecesMeet, OneInsideAnotherIsAnOverlapWhicheverComesFirst) {
  for (const bool swapped : {false, true}) {
    std::vector<PlacedClay> both{ball({0, 0, 0}, 8), ball({2, 0, 0}, 2)};
    if (swapped) std::swap(both[0], both[1]);
    const auto found = piecesThatMeet(both, 0.4, nullptr);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].overlap);
    EXPECT_NEAR(found[0].mm, 8, 0.25) << "its far side lies in the middle";
  }
}

TEST(PiecesMeet, FacesOnOnePlaneTouch) {
  const auto found =
      piecesThatMeet(std::vector{block({0, 0, 2}, {10, 10, 4}), block({1, 2, 6}, {6, 6, 4})}, 0.4, nullptr);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].overlap);
  EXPECT_EQ(found[0].mm, 0);
  EXPECT_NEAR(found[0].atMm.z(), 4, 0.05);
}

TEST(PiecesMeet, LessThanATenthOfAVoxelIsATouchHoweverTheyAreTurned) {
  for (const double voxels : {-0.07, 0.07}) {
    std::vector<PlacedClay> both{block({0, 0, 2}, {10, 10, 4}), block({1, 2, 6 + voxels * 0.25}, {6, 6, 4})};
    for (PlacedClay& each : both) each.pose = turned(0.7, {1, 2, 3}, {4, 5, 6});
    const auto found = piecesThatMeet(both, 0.4, nullptr);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_FALSE(found[0].overlap);
    EXPECT_EQ(found[0].mm, 0);
  }
}

TEST(PiecesMeet, WideGapsAreLookedForBeyondTheirBricks) {
  const auto found =
      piecesThatMeet(std::vector{block({0, 0, 2}, {8, 8, 4}), block({0, 0, 11}, {8, 8, 4})}, 5.5, nullptr);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].mm, 5, 0.03);
}

TEST(PiecesMeet, ACopyThatWasNotMovedOverlaps) {
  for (const PlacedClay& one : {block({0, 0, 2}, {10, 10, 4}), ball({1, 2, 3}, 6)}) {
    const auto found = piecesThatMeet(std::vector{one, one}, 0.4, nullptr);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].overlap);
  }
}

TEST(PiecesMeet, APinInItsHoleIsAsFarAsItsClearance) {
  const PlacedClay plate = block({0, 0, 2}, {20, 20, 4});
  PlacedClay hole = plate;
  hole.version = combine(plate.version, block({0, 0, 2}, {5, 5, 10}).version, clay::Combination::cut);
  const PlacedClay pin = block({0, 0, 2}, {4.4, 4.4, 8});
  EXPECT_TRUE(piecesThatMeet(std::vector{hole, pin}, 0.25, nullptr).empty());
  const auto found = piecesThatMeet(std::vector{hole, pin}, 0.4, nullptr);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].overlap);
  EXPECT_NEAR(found[0].mm, 0.3, 0.03);
}

TEST(PiecesMeet, PairsComeInOrderAndOfOneAlone) {
  std::vector<PlacedClay> row;
  for (int i = 0; i < 5; ++i) row.push_back(ball({i * 7.0, 0, 0}, 4));
  row[3].version = combine(row[3].version, ball({21, 0, 0}, 9).version, clay::Combination::cut);
  ASSERT_EQ(row[3].version.stats().bricks, 0u);
  const auto all = piecesThatMeet(row, 0.4, nullptr);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].first, 0u);
  EXPECT_EQ(all[0].second, 1u);
  EXPECT_EQ(all[1].first, 1u);
  EXPECT_EQ(all[1].second, 2u);
  EXPECT_EQ(piecesThatMeet(row, 0.4, nullptr, 0).size(), 1u);
  EXPECT_EQ(piecesThatMeet(row, 0.4, nullptr, 1).size(), 2u);
  EXPECT_TRUE(piecesThatMeet(row, 0.4, nullptr, 4).empty());
}

TEST(PiecesMeet, IsCancelledBetweenTwoLooks) {
  Job job;
  job.cancel();
  EXPECT_THROW((void)piecesThatMeet(std::vector{ball({0, 0, 0}, 5), ball({1, 0, 0}, 5)}, 0.4, &job), Cancelled);
}

}  // namespace
}  // namespace argil::engine
