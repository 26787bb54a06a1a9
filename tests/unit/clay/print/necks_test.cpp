// Hollows that open too narrowly: bores in any direction, chains of hollows, random ones beside a plain flood.

#include "clay/field/necks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"
#include "clay/field/air_rooms.h"
#include "clay/field/distance_box.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

constexpr double kVoxel = 0.25;

Grid grid() {
  Grid grid;
  grid.voxelMm = kVoxel;
  grid.originMm = Vec3d(0.11, -0.07, 0.03);
  return grid;
}
Version block(const Vec3d& at, const Vec3d& size) {
  return makeBlock(Store::make(), grid(), at, size, 0);
}
Version ball(const Vec3d& at, double radius) {
  return makeSphere(Store::make(), grid(), at, radius);
}
Version rod(const Vec3d& from, const Vec3d& to, double radius) {
  return makeRod(Store::make(), grid(), from, to, radius, 0);
}
Version cut(const Version& a, const Version& b) {
  return combine(a, b, Combination::cut);
}
std::vector<Neck> necks(const Version& version, double radiusMm, int threads = 2) {
  return narrowNecks(version, radiusMm, threads, WorkPart(nullptr));
}
Vec3d direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(Necks, AreAsWideAsTheBoreInAnyDirection) {
  std::mt19937 random(3);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  double worst = 0;
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    const Vec3d middle(in(-1, 1), in(-1, 1), in(-1, 1));
    const Vec3d way = i < 3 ? Vec3d(Vec3d::Unit(i)) : direction(random);
    const double radius = in(0.5, 1.9);
    const Version clay = cut(cut(ball(Vec3d::Zero(), 10), ball(middle, 6)), rod(middle, middle + 20 * way, radius));
    const std::vector<Neck> found = necks(clay, 2);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].radiusMm, radius, 0.5 * kVoxel);
    worst = std::max(worst, std::abs(found[0].radiusMm - radius) / kVoxel);
    const Vec3d at = found[0].atMm - middle;
    EXPECT_NEAR(at.cross(way).norm(), 0, kVoxel);
    EXPECT_GT(at.dot(way), 5);
    EXPECT_LT((found[0].hollowMm - middle).norm(), 4 + kVoxel) << "where the ball has room";
  }
  RecordProperty("worst_voxels", std::to_string(worst));
  EXPECT_LT(worst, 0.25);
}

TEST(Necks, AreNoneWhereNothingIsHeldBack) {
  EXPECT_TRUE(necks(ball(Vec3d::Zero(), 10), 2).empty());
  EXPECT_TRUE(necks(Version::empty(Store::make(), grid()), 2).empty());
  const Version hollow = cut(ball(Vec3d::Zero(), 10), ball(Vec3d::Zero(), 6));
  EXPECT_TRUE(necks(hollow, 2).empty()) << "it has no way out at all";
  // Wider than the ball by a tenth of a voxel and more, in a direction that no grid has.
  const Vec3d way = Vec3d(0.3, 0.5, 0.9).normalized();
  for (const double radius : {2.0, 2.05, 2.4}) {
    EXPECT_TRUE(necks(cut(hollow, rod(Vec3d::Zero(), 20 * way, radius)), 2).empty()) << radius;
    // A long tunnel alone is none either.
    EXPECT_TRUE(necks(cut(block(Vec3d::Zero(), {24, 24, 24}), rod(-40 * way, 40 * way, radius)), 2).empty()) << radius;
    EXPECT_TRUE(necks(cut(block(Vec3d::Zero(), {24, 24, 24}), rod(Vec3d::Zero(), 40 * way, radius)), 2).empty());
  }
  // No room for the ball in the hollow itself.
  EXPECT_TRUE(necks(cut(cut(ball(Vec3d::Zero(), 10), ball(Vec3d::Zero(), 1.8)), rod(Vec3d::Zero(), {20, 0, 0}, 0.8)), 2)
                  .empty());
  // A cup is open.
  EXPECT_TRUE(necks(cut(block({0, 0, 0}, {20, 20, 20}), block({0, 0, 5}, {14, 14, 22})), 2).empty());
}

TEST(Necks, OfSeveralWaysTheWidestCounts) {
  const Version hollow = cut(ball(Vec3d::Zero(), 10), ball(Vec3d::Zero(), 6));
  const Version two = cut(cut(hollow, rod(Vec3d::Zero(), {20, 0, 0}, 0.7)), rod(Vec3d::Zero(), {0, -20, 3}, 1.3));
  const std::vector<Neck> found = necks(two, 2);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].radiusMm, 1.3, 0.25 * kVoxel);
  EXPECT_LT(found[0].atMm.y(), -5);
  EXPECT_TRUE(necks(cut(two, rod(Vec3d::Zero(), {1, 2, 20}, 2.3)), 2).empty()) << "a third one is wide";
}

TEST(Necks, OfHollowsInARowAreEachItsOwn) {
  const Version solid = block({0, 0, 0}, {50, 16, 16});
  const Vec3d left(-14, 0.3, 0.1), right(8, -0.2, 0.4);
  const auto row = [&](double between, double out) {
    return cut(cut(cut(cut(solid, ball(left, 5)), ball(right, 5.5)), rod(left, right, between)),
               rod(right, right + Vec3d(40, 3, 0), out));
  };
  const std::vector<Neck> behind = necks(row(0.8, 1.4), 2);
  ASSERT_EQ(behind.size(), 2u);
  EXPECT_NEAR(behind[0].radiusMm, 0.8, 0.25 * kVoxel);
  EXPECT_LT((behind[0].hollowMm - left).norm(), 5);
  EXPECT_LT(behind[0].atMm.x(), right.x());
  EXPECT_NEAR(behind[1].radiusMm, 1.4, 0.25 * kVoxel);
  EXPECT_LT((behind[1].hollowMm - right).norm(), 5);
  // Behind a wider way both open by the same narrow one.
  const std::vector<Neck> both = necks(row(1.4, 0.8), 2);
  ASSERT_EQ(both.size(), 1u);
  EXPECT_NEAR(both[0].radiusMm, 0.8, 0.25 * kVoxel);
  EXPECT_GT(both[0].atMm.x(), right.x());
}

TEST(Necks, OfHolesInAThinWallAndOfSlits) {
  const Version hollow = cut(ball(Vec3d::Zero(), 10), ball(Vec3d::Zero(), 9));
  const std::vector<Neck> hole = necks(cut(hollow, rod({0.1, 0, 0}, {0.2, 1, 20}, 1.2)), 2);
  ASSERT_EQ(hole.size(), 1u);
  EXPECT_NEAR(hole[0].radiusMm, 1.2, 0.25 * kVoxel);
  // The least ball through a slit is half as wide as it.
  const std::vector<Neck> slit = necks(cut(hollow, block({0, 0, 10}, {1.5, 9, 12})), 2);
  ASSERT_EQ(slit.size(), 1u);
  EXPECT_NEAR(slit[0].radiusMm, 0.75, 0.25 * kVoxel);
}

TEST(Necks, OfALargeHollowReachThroughEmptyBricks) {
  // 52 mm of air in it, most of it in tiles, and a wall that ends rows of bricks.
  Grid coarse = grid();
  coarse.voxelMm = 0.5;
  const auto store = Store::make();
  const Version hollow = cut(makeSphere(store, coarse, {1, 2, 3}, 30), makeSphere(store, coarse, {1, 2, 3}, 26));
  for (int axis = 0; axis < 3; ++axis)
    for (const double way : {-1.0, 1.0}) {
      const Vec3d to = Vec3d(1, 2, 3) + 40 * way * Vec3d::Unit(axis);
      const Version bored = cut(hollow, makeRod(store, coarse, {1, 2, 3}, to, 1.6, 0));
      const std::vector<Neck> found = necks(bored, 2.5);
      ASSERT_EQ(found.size(), 1u) << axis << way;
      EXPECT_NEAR(found[0].radiusMm, 1.6, 0.25 * coarse.voxelMm);
      EXPECT_TRUE(necks(bored, 1.5).empty());
    }
}

// All of a dense box, by thresholds that fall: rooms that join the outside below the radius.
struct Plain {
  std::vector<double> widths;  // of each hollow that is held back, at voxels
};
Plain flooded(const Version& version, Coord low, Coord size, float radius) {
  DistanceBox box;
  EXPECT_TRUE(box.fill(version, low, size, {.inside = 0, .outside = radius}));
  const auto number = [&](Coord v) { return static_cast<uint32_t>(voxelIndex(size, v)); };
  const uint32_t count = number({size.x, 0, 0});
  std::vector<std::pair<float, Coord>> voxels;
  for (int x = 0; x < size.x; ++x)
    for (int y = 0; y < size.y; ++y)
      for (int z = 0; z < size.z; ++z) {
        const float d = box.at(low + Coord{x, y, z});
        if (d > 0) voxels.emplace_back(std::min(d, radius * 0.999999f), Coord{x, y, z});
      }
  std::stable_sort(voxels.begin(), voxels.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  JoinedSets sets(count + 1);
  std::vector<bool> in(count);
  std::vector<uint32_t> free(count + 1, 0);  // voxels of a set that have room
  Plain plain;
  const uint32_t outside = count;
  // JoinedSets names a set by its lowest; counts move along.
  const auto join = [&](uint32_t a, uint32_t b, float at) {
    a = sets.find(a), b = sets.find(b);
    if (a == b) return;
    const uint32_t out = sets.find(outside);
    if ((a == out || b == out) && at < radius * 0.999f) {
      const uint32_t hollow = a == out ? b : a;
      if (free[hollow] >= 8) plain.widths.push_back(at);
    }
    sets.join(a, b);
    free[std::min(a, b)] = free[a] + free[b];
  };
  for (const auto& [d, v] : voxels) {
    const uint32_t me = number(v);
    in[me] = true;
    free[me] = d >= radius * 0.999f;
    if (v.x == 0 || v.y == 0 || v.z == 0 || v.x == size.x - 1 || v.y == size.y - 1 || v.z == size.z - 1)
      join(me, outside, radius);
    for (const Coord step :
         {Coord{1, 0, 0}, Coord{-1, 0, 0}, Coord{0, 1, 0}, Coord{0, -1, 0}, Coord{0, 0, 1}, Coord{0, 0, -1}}) {
      const Coord w = v + step;
      if (std::min({w.x, w.y, w.z}) < 0 || w.x >= size.x || w.y >= size.y || w.z >= size.z) continue;
      if (in[number(w)]) join(me, number(w), d);
    }
  }
  std::sort(plain.widths.begin(), plain.widths.end());
  return plain;
}

TEST(Necks, OfRandomHollowsAreThoseOfAPlainFlood) {
  size_t together = 0;
  for (uint32_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    Version clay = block(Vec3d::Zero(), {16, 16, 16});
    const auto store = Store::make();
    std::vector<Vec3d> middles;
    for (int i = 0; i < 5; ++i) {
      middles.emplace_back(in(-6, 6), in(-6, 6), in(-6, 6));
      clay = cut(clay, ball(middles.back(), in(1.5, 3)));
    }
    for (int i = 0; i < 5; ++i) {
      const Vec3d to = i < 2 ? Vec3d(middles[size_t(i)] + 30 * direction(random)) : middles[size_t(i - 1)];
      clay = cut(clay, rod(middles[size_t(i)], to, in(0.5, 1.5)));
    }
    const double radius = in(1, 1.5);
    const std::vector<Neck> found = necks(clay, radius);
    const int edge = 80;
    const Plain plain = flooded(clay, {-40, -40, -40}, {edge, edge, edge}, float(radius / kVoxel));
    // A voxel's own distance is up to √3/2 less than that of the way between voxels.
    size_t least = 0;
    for (const double width : plain.widths) least += width < radius / kVoxel - 0.97;
    EXPECT_GE(found.size(), least);
    EXPECT_LE(found.size(), plain.widths.size());
    together += found.size();
    for (size_t i = 0; i < std::min(found.size(), plain.widths.size()); ++i) {
      const double here = found[i].radiusMm / kVoxel;
      EXPECT_TRUE(std::any_of(plain.widths.begin(), plain.widths.end(), [&](double width) {
        return here > width - 0.1 && here < width + 0.97;
      })) << here;
    }
  }
  EXPECT_GT(together, 30u);
}

// Plates and balls anywhere: rooms and their voxels are those of a flood over a dense box.
TEST(AirRooms, AreThoseOfAPlainFlood) {
  constexpr int kHalf = 88, kEdge = 2 * kHalf;
  size_t together = 0;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    Version clay = cut(ball({in(-8, 8), in(-8, 8), in(-8, 8)}, 8), ball({in(-8, 8), in(-8, 8), in(-8, 8)}, 5));
    for (int i = 0; i < 16; ++i) {
      const Vec3d at(in(-12, 12), in(-12, 12), in(-12, 12));
      Vec3d size(in(2, 16), in(2, 16), in(2, 16));
      size[i % 3] = 1;
      clay = combine(clay, i % 5 == 0 ? ball(at, in(1, 3)) : block(at, size), Combination::join);
    }
    const double radius = in(3, 9);
    AirRooms air(clay, radius, 2, WorkPart(nullptr));
    uint64_t voxels = 0;
    for (const AirRooms::Room& room : air.closedRooms()) voxels += room.voxels;
    DistanceBox box;
    const Coord low{-kHalf, -kHalf, -kHalf}, size{kEdge, kEdge, kEdge};
    ASSERT_TRUE(box.fill(clay, low, size, {.inside = 3, .outside = float(radius)}));
    std::vector<uint8_t> free(static_cast<size_t>(kEdge) * kEdge * kEdge), seen(free.size());
    uint64_t all = 0, outside = 0;
    for (int x = 0; x < kEdge; ++x)
      for (int y = 0; y < kEdge; ++y)
        for (int z = 0; z < kEdge; ++z)
          all += free[voxelIndex(size, {x, y, z})] = box.at(low + Coord{x, y, z}) >= float(radius) * (1 - 1e-6f);
    std::vector<Coord> next{{0, 0, 0}};
    ASSERT_TRUE(free[0]);
    seen[0] = 1;
    while (!next.empty()) {
      const Coord at = next.back();
      next.pop_back();
      ++outside;
      for (const Coord step :
           {Coord{1, 0, 0}, Coord{-1, 0, 0}, Coord{0, 1, 0}, Coord{0, -1, 0}, Coord{0, 0, 1}, Coord{0, 0, -1}}) {
        const Coord to = at + step;
        if (std::min({to.x, to.y, to.z}) < 0 || std::max({to.x, to.y, to.z}) >= kEdge) continue;
        if (!free[voxelIndex(size, to)] || std::exchange(seen[voxelIndex(size, to)], 1)) continue;
        next.push_back(to);
      }
    }
    EXPECT_EQ(voxels, all - outside);
    together += voxels > 0;
  }
  EXPECT_GT(together, 4u) << "too few of them have rooms";
}

TEST(Necks, AreTheSameOnAnyThreads) {
  const Version hollow = cut(cut(ball(Vec3d::Zero(), 10), ball({1, 0, 0}, 6)), rod(Vec3d::Zero(), {20, 7, 3}, 1.1));
  const std::vector<Neck> one = necks(hollow, 2, 1), five = necks(hollow, 2, 5);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(five.size(), 1u);
  EXPECT_EQ(one[0].atMm, five[0].atMm);
  EXPECT_EQ(one[0].hollowMm, five[0].hollowMm);
  EXPECT_EQ(one[0].radiusMm, five[0].radiusMm);
}

TEST(Necks, EndWhereTheyAreCancelledAndRefuseWhatIsNoRadius) {
  const Version hollow = cut(cut(ball(Vec3d::Zero(), 10), ball({1, 0, 0}, 6)), rod(Vec3d::Zero(), {20, 7, 3}, 1.1));
  Job job;
  job.cancel();
  EXPECT_THROW((void)narrowNecks(hollow, 2, 2, WorkPart(&job)), Cancelled);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_THROW((void)necks(hollow, bad), Error) << bad;
  EXPECT_TRUE(necks(hollow, 0.9 * kLeastNeckVoxels * kVoxel).empty());
}

}  // namespace
}  // namespace argil::clay
