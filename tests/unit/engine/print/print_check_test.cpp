// What stands in the way of printing: shapes with one fault each, and one without.

#include "engine/print/print_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::engine {
namespace {

using clay::Version;

Version block(const Vec3d& middle, const Vec3d& edges, double voxelMm = 0.2) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  return clay::makeBlock(clay::Store::make(), grid, middle, edges, 0);
}
Version joined(const Version& a, const Version& b) {
  return clay::combine(a, b, clay::Combination::join);
}
PrintReport checked(const Version& version, const char* process, const haptics::Pose& pose = {}) {
  return checkPrint(version, pose, printProcess(process), nullptr);
}

TEST(PrintCheck, ABlockOnItsBaseHasNothingInItsWay) {
  for (const PrintProcess& process : printProcesses()) {
    SCOPED_TRACE(process.id);
    const PrintReport report = checked(block({0, 0, 10}, {20, 16, 20}), process.id.data());
    EXPECT_EQ(report.troubles(process), 0);
    EXPECT_EQ(report.overhangMm2, 0);
    EXPECT_NEAR(report.walls.surfaceMm2, 2 * (20 * 16 + 20 * 20 + 16 * 20), 50);
  }
  EXPECT_THROW((void)printProcess("clay"), Error);
}

TEST(PrintCheck, ThinWallsAndNarrowGapsAreMeasuredAndShown) {
  const Version base = block({0, 0, 2}, {30, 20, 4});
  const PrintReport thin = checked(joined(base, block({5, 0, 9}, {0.6, 20, 12})), "sla");
  ASSERT_EQ(thin.walls.parts.size(), 1u) << "both its sides are one wall";
  const clay::ThinPart& wall = thin.walls.parts[0];
  // Where its rim is round it is thinner, by half a voxel at most.
  EXPECT_NEAR(wall.leastMm, 0.6, 0.1);
  EXPECT_NEAR(wall.atMm.x(), 5, 0.5);
  EXPECT_GT(wall.atMm.z(), 3.5);
  // Both its sides, 11 mm high each, of all that there is.
  EXPECT_NEAR(wall.areaMm2, 2 * 11 * 20, 25);
  EXPECT_NEAR(thin.walls.share(), 2 * 11 * 20 / (2 * 30 * 20 + 2 * 4 * 50 + 2 * 11 * 20.0), 0.03);
  EXPECT_EQ(thin.troubles(printProcess("sla")), 1);
  const PrintReport narrow =
      checked(joined(base, joined(block({-3, 0, 9}, {6, 20, 12}), block({3.4, 0, 9}, {6, 20, 12}))), "sla");
  ASSERT_EQ(narrow.gaps.parts.size(), 1u);
  EXPECT_NEAR(narrow.gaps.parts[0].leastMm, 0.4, 0.1);
  EXPECT_NEAR(narrow.gaps.parts[0].atMm.x(), 0.2, 0.5);
  EXPECT_TRUE(narrow.walls.parts.empty());
  EXPECT_EQ(narrow.troubles(printProcess("sla")), 1);
}

// A spot of less than a filament's width carries itself; the same area again in one patch does not.
TEST(PrintCheck, SpotsThatHangNeedNoSupport) {
  Version spots = block({0, 0, 10}, {20, 16, 20}, 0.1);
  const PrintProcess& fdm = printProcess("fdm");
  for (const double x : {-6.0, 0.0, 6.0}) spots = joined(spots, block({x, 8, 12}, {0.5, 0.5, 0.5}, 0.1));
  const PrintReport small = checked(spots, "fdm");
  EXPECT_GT(small.overhangMm2, 0.05);
  EXPECT_LT(small.overhangMm2, 3 * 0.5 * 0.25 + 0.1);
  EXPECT_FALSE(small.overhangs);
  // They are thin, too, and begin in the air: that is told by itself.
  const auto others = [](const PrintReport& report) {
    return int(!report.walls.parts.empty()) + int(!report.slices.islands.empty());
  };
  EXPECT_EQ(small.troubles(fdm), others(small));
  const PrintReport large = checked(joined(spots, block({0, 8, 16}, {4, 3, 1}, 0.1)), "fdm");
  EXPECT_TRUE(large.overhangs);
  EXPECT_EQ(large.troubles(fdm), others(large) + 1);
}

TEST(PrintCheck, HangsAndTrapsFollowHowItStands) {
  // A table: a plate of 20 × 20 mm on a foot of 6 × 6.
  const Version table = joined(block({0, 0, 6.5}, {6, 6, 13}), block({0, 0, 14}, {20, 20, 4}));
  const PrintReport standing = checked(table, "fdm");
  // Two voxels around its rim are round.
  EXPECT_NEAR(standing.overhangMm2, 20 * 20 - 6 * 6, 80 * 0.4);
  EXPECT_TRUE(standing.slices.islands.empty());
  haptics::Pose turned;
  turned.rotation = Eigen::AngleAxisd(std::numbers::pi, Vec3d::UnitX());
  turned.translation = {100, 0, 0};
  const PrintReport lying = checked(table, "fdm", turned);
  EXPECT_EQ(lying.overhangMm2, 0);
  EXPECT_NEAR(lying.lowMm.x(), 90, 0.1);
  EXPECT_NEAR(lying.highMm.z(), 0, 0.1);
  // A cup holds resin as it stands, and nothing upside down.
  const Version cup =
      clay::combine(block({0, 0, 10}, {20, 20, 20}), block({0, 0, 15}, {12, 12, 20}), clay::Combination::cut);
  EXPECT_EQ(checked(cup, "sla").slices.traps.size(), 1u);
  EXPECT_EQ(checked(cup, "sla", turned).slices.traps.size(), 0u);
  EXPECT_EQ(checked(cup, "fdm").troubles(printProcess("fdm")), 0) << "filament holds no liquid";
  EXPECT_EQ(checked(cup, "sla").troubles(printProcess("sla")), 1);
}

TEST(PrintCheck, HollowsThatOpenTooNarrowlyAreToldWhereTheyDo) {
  const auto bored = [](double radius, double voxelMm) {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    const auto store = clay::Store::make();
    const Version hollow = clay::combine(block({0, 0, 10}, {20, 20, 20}, voxelMm),
                                         clay::makeSphere(store, grid, {0, 0, 10}, 6), clay::Combination::cut);
    return clay::combine(hollow, clay::makeRod(store, grid, {0, 0, 10}, {0, 0, -5}, radius, 0), clay::Combination::cut);
  };
  haptics::Pose turned;
  turned.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitY());
  turned.translation = {100, 0, 0};
  for (const haptics::Pose& pose : {haptics::Pose{}, turned}) {
    const PrintReport report = checked(bored(0.7, 0.2), "sla", pose);
    ASSERT_EQ(report.necks.size(), 1u);
    EXPECT_NEAR(report.necks[0].radiusMm, 0.7, 0.1);
    const Vec3d at = pose.rotation.conjugate() * (report.necks[0].atMm - pose.translation);
    EXPECT_NEAR(at.head<2>().norm(), 0, 0.2);
    EXPECT_LT(at.z(), 5);
  }
  EXPECT_EQ(checked(bored(0.7, 0.2), "sla").troubles(printProcess("sla")), 2) << "and its roof";
  EXPECT_TRUE(checked(bored(1.1, 0.2), "sla").necks.empty());
  EXPECT_EQ(checked(bored(1.1, 0.2), "metal").necks.size(), 1u) << "powder of metal asks for more";
  EXPECT_TRUE(checked(bored(0.7, 0.2), "fdm").necks.empty()) << "nothing has to leave";
  // Of a radius beyond 24 voxels it is found in coarser clay.
  const PrintReport fine = checked(bored(0.8, 0.035), "sla");
  ASSERT_EQ(fine.necks.size(), 1u);
  EXPECT_NEAR(fine.necks[0].radiusMm, 0.8, 0.03);
  // One that nothing is as large as.
  PrintProcess process = printProcess("sla");
  process.outletMm = 900;
  EXPECT_TRUE(checkPrint(bored(0.7, 0.2), {}, process, nullptr).necks.empty());
}

TEST(PrintCheck, TheBedIsLookedAtBothWays) {
  EXPECT_TRUE(checked(block({0, 0, 2}, {60, 100, 4}, 1), "casting").fits);
  EXPECT_TRUE(checked(block({0, 0, 2}, {100, 60, 4}, 1), "casting").fits);
  EXPECT_FALSE(checked(block({0, 0, 2}, {100, 80, 4}, 1), "casting").fits);
}

TEST(PrintCheck, WithoutClayOrWithLimitsOfTooManyVoxelsIsAnError) {
  EXPECT_THROW((void)checked(Version::empty(clay::Store::make(), clay::Grid{}), "sla"), Error);
  EXPECT_THROW((void)checked(block({0, 0, 0}, {0.1, 0.1, 0.1}, 0.002), "sla"), Error);
}

}  // namespace
}  // namespace argil::engine
