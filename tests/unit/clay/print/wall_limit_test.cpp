// Carving that stops where a wall would become too thin.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "clay/brush/brush.h"
#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/surface/wall_map.h"
#include "clay/whole/boolean.h"
#include "clay/whole/offset.h"

namespace argil::clay {
namespace {

Grid grid() {
  Grid grid;
  grid.voxelMm = 1;  // so that mm are voxels
  return grid;
}
Version block(const Vec3d& at, const Vec3d& size) {
  return makeBlock(Store::make(), grid(), at, size, 0);
}

std::shared_ptr<const Brush> carving(double leastWall) {
  auto brush = std::make_shared<Brush>(*Brush::of(Method::carve));
  brush->leastWall = static_cast<float>(leastWall);
  return brush;
}
Stamp stampOf(const Vec3d& a, const Vec3d& b, double radius) {
  Stamp stamp;
  stamp.a = a;
  stamp.b = b;
  stamp.radius = radius;
  return stamp;
}
Stamp grown(Stamp stamp, double endRadius) {
  stamp.endRadius = endRadius;
  return stamp;
}
/// Stamps a fifth of the radius apart, as tools have them; `pressure`: the part of the radius that each ends with.
Version carve(
    const Version& clay, double leastWall, const std::vector<Vec3d>& way, double radius, bool publishes = false,
    const std::function<double()>& pressure = [] { return 1.0; }) {
  BrushStroke stroke(clay, carving(leastWall));
  Vec3d last = way[0];
  double size = radius * pressure();
  stroke.apply(stampOf(last, last, size));
  for (size_t i = 1; i < way.size(); ++i) {
    const int steps = std::max(1, static_cast<int>((way[i] - way[i - 1]).norm() / (0.2 * radius)));
    for (int k = 1; k <= steps; ++k) {
      const Vec3d next = way[i - 1] + (way[i] - way[i - 1]) * k / steps;
      const double end = radius * pressure();
      stroke.apply(grown(stampOf(last, next, size), end));
      last = next;
      size = end;
      if (publishes) (void)stroke.publish();
    }
  }
  return stroke.finish();
}

constexpr int kRim = 8;  // vertices

/// The least wall between faces that are parallel within 18°: the wedges that a ball leaves are wider; infinity where
/// none is below the limit.
double leastWall(const Version& clay, double limit) {
  Surface surface;
  WallMap map(limit, 0);
  map.follow(surface.update(clay, 2), 2);
  std::vector<double> walls;
  surface.forEach([&](const BrickMesh& mesh) {
    const std::span<const float> sizes = map.sizes(mesh.brick, SideOf::wall);
    for (const WallMap::Partner& each : map.partners(mesh.brick, SideOf::wall)) {
      const Vec3f here = mesh.normals[each.vertex].unpack(),
                  there = surface.find(each.brick)->normals[each.other].unpack();
      if (here.dot(there) < -0.95f) walls.push_back(sizes[each.vertex]);
    }
  });
  // At the rim of a wedge normals are those of neither face: a wall has more places than that.
  if (walls.size() < kRim) return INFINITY;
  std::nth_element(walls.begin(), walls.begin() + kRim - 1, walls.end());
  return walls[kRim - 1];
}

// How thick the clay is along a line of sight: what a hole would make zero.
double thickAlong(const Version& clay, const Vec3d& from, const Vec3d& way, double length) {
  Sampler sampler(clay);
  double thick = 0;
  for (double t = 0; t < length; t += 0.05) thick += sampler.trilinear(from + t * way) < 0 ? 0.05 : 0;
  return thick;
}

TEST(WallLimit, LeavesAWallHoweverFarTheToolIsPushed) {
  const Version plate = block({0, 0, 0}, {80, 80, 16});
  for (const double deep : {9.0, 4.0, -9.0, -40.0}) {
    SCOPED_TRACE(deep);
    const std::vector<Vec3d> way{{0.3, 0.2, 30}, {0.3, 0.2, deep}, {14.3, 3.2, deep}};
    const Version free = carve(plate, 0, way, 8), limited = carve(plate, 6, way, 8);
    const double through = thickAlong(free, {0.3, 0.2, -40}, Vec3d::UnitZ(), 80),
                 left = thickAlong(limited, {0.3, 0.2, -40}, Vec3d::UnitZ(), 80);
    EXPECT_NEAR(left, std::max(6.0, deep - 8 + 8), 0.15) << "without: " << through;
    EXPECT_NEAR(thickAlong(limited, {10.3, 2.2, -40}, Vec3d::UnitZ(), 80), left, 0.15);
    EXPECT_GE(leastWall(limited, 8), 5.9);
  }
}

// Where nothing would become too thin the stroke is the same to the bit; a corner, an edge and the rim of a groove are
// no walls.
TEST(WallLimit, ChangesNothingWhereNoWallIsNear) {
  const Version thick = block({0, 0, 0}, {80, 80, 60});
  const std::vector<std::vector<Vec3d>> ways{{{-20, 3, 31}, {20, 8, 31}},                   // shallow
                                             {{-20, 3, 24}, {20, 8, 24}},                   // as deep as wide
                                             {{40, 40, 44}, {40, 40, 26}},                  // the corner
                                             {{-20, 50, 29}, {-20, 39, 29}, {20, 39, 29}},  // an edge
                                             {{0, 0, 34}, {0, 0, 12}, {9, 0, 12}}};         // a pit
  for (size_t i = 0; i < ways.size(); ++i)
    EXPECT_EQ(carve(thick, 7, ways[i], 8).hash(), carve(thick, 0, ways[i], 8).hash()) << i;
}

TEST(WallLimit, DoesNotTouchWhatIsTooThinAlready) {
  const Version plate = block({0, 0, 0}, {80, 80, 5});
  EXPECT_EQ(carve(plate, 6, {{0, 0, 20}, {0, 0, -20}, {20, 0, 0}}, 8).hash(), plate.hash());
  EXPECT_NE(carve(plate, 3, {{0, 0, 20}, {0, 0, -20}, {20, 0, 0}}, 8).hash(), plate.hash());
}

TEST(WallLimit, HoldsFromBothSidesAndUnderARoof) {
  Version plate = block({0, 0, 0}, {80, 80, 30});
  plate = carve(plate, 5, {{0, 0, 30}, {0, 0, -30}}, 8);
  // From below, into what is left and beside it.
  plate = carve(plate, 5, {{3, 0, -40}, {3, 0, 10}, {-20, 0, 10}}, 6);
  EXPECT_GE(leastWall(plate, 7), 4.9);
  // A tunnel from the side that would come out at the top.
  const Version tunnel = carve(plate, 5, {{-60, 20, -2}, {-30, 20, -2}, {-10, 20, 30}}, 5);
  EXPECT_NE(tunnel.hash(), plate.hash());
  EXPECT_GE(leastWall(tunnel, 7), 4.9);
  EXPECT_NEAR(thickAlong(tunnel, {-15, 20, 5}, Vec3d::UnitZ(), 20), 10, 5.2);
}

// A hand that presses harder: the tip grows within one stamp, in place or on its way, as far as it has room.
TEST(WallLimit, HoldsWhenTheTipGrows) {
  const Version plate = block({0, 0, 0}, {240, 80, 16});
  for (const double aside : {0.0, 0.4, 2.0})
    for (const double deep : {7.0, 2.0})
      for (const double radius : {5.0, 9.0, 14.0, 30.0}) {
        SCOPED_TRACE(std::to_string(radius) + ", " + std::to_string(aside) + " aside at " + std::to_string(deep));
        BrushStroke stroke(plate, carving(6));
        Vec3d last{0.3, 0.2, 20};
        const auto go = [&](const Vec3d& to, double size) {
          const Vec3d way = to - last;
          const int steps = std::max(1, static_cast<int>(way.norm() / (0.2 * size)));
          for (int i = 0; i < steps; ++i, last += way / steps) stroke.apply(stampOf(last, last + way / steps, size));
        };
        go({0.3, 0.2, deep}, 2);
        const Version before = stroke.publish();
        stroke.apply(grown(stampOf(last, last + Vec3d(aside, 0, 0), 2), radius));
        last.x() += aside;
        const Version pressed = stroke.publish();
        if (aside > 0) {
          EXPECT_NE(pressed.hash(), before.hash()) << "it grows as far as it can, and cuts";
        }
        EXPECT_GE(thickAlong(pressed, {0.3, 0.2, -40}, Vec3d::UnitZ(), 80), 5.9);
        EXPECT_GE(leastWall(pressed, 8), 5.9);
        go({10, 0, deep}, radius);
        EXPECT_GE(leastWall(stroke.publish(), 8), 5.9);
        if (deep < 5) continue;  // below the surface it may be held
        EXPECT_NEAR(thickAlong(stroke.publish(), {10, 0, -40}, Vec3d::UnitZ(), 80), std::max(6.0, 8 + deep - radius),
                    0.15);
        go({10, 0, 20 + radius}, radius);
        go({-80, 0, 20 + radius}, radius);
        go({-80, 0, 0}, radius);
        EXPECT_NEAR(thickAlong(stroke.finish(), {-80, 0, -40}, Vec3d::UnitZ(), 80), 6, 0.15);
      }
}

TEST(WallLimit, ATipThatBeginsDeepInTheClayCutsNothing) {
  const Version thick = block({0, 0, 0}, {120, 120, 120});
  EXPECT_EQ(carve(thick, 3, {{0, 0, 0}, {5, 0, 0}}, 4).hash(), thick.hash());
}

TEST(WallLimit, DoesNotDependOnWhatIsPublished) {
  const Version plate = block({0, 0, 0}, {80, 80, 24});
  const std::vector<Vec3d> way{{0.3, 0.2, 30}, {0.3, 0.2, -9}, {14.3, 3.2, -2}, {20, 20, 30}, {-10, 10, -30}};
  EXPECT_EQ(carve(plate, 6, way, 8, true).hash(), carve(plate, 6, way, 8, false).hash());
}

TEST(WallLimit, MirrorImagesLeaveAWallBetweenThem) {
  const Version bar = block({0, 0, 0}, {60, 40, 40});
  BrushStroke stroke(bar, carving(6));
  for (double x = 45; x > 0; x -= 1.5) {
    const Stamp one = stampOf({x, 0, 0}, {x - 1.5, 0, 0}, 8), other = stampOf({-x, 0, 0}, {1.5 - x, 0, 0}, 8);
    const Stamp images[] = {one, other};
    stroke.apply(images);
  }
  const Version cut = stroke.finish();
  EXPECT_NEAR(thickAlong(cut, {-40, 0, 0}, Vec3d::UnitX(), 80), 6, 0.5);
  EXPECT_GE(leastWall(cut, 8), 5.9);
}

// What the hand is told of: nothing far away, a wall some voxels before it, and the place where it is held.
TEST(WallLimit, SaysWhatIsAhead) {
  const Version plate = block({0, 0, 0}, {80, 80, 30});  // a wall of 6 ends a ball of 8 at −1
  BrushStroke stroke(plate, carving(6)), free(plate, carving(0));
  EXPECT_TRUE(stroke.wallsAhead().empty()) << "before the first stamp";
  Vec3d last{0.3, 0.2, 24};
  for (double z = 24; z > -20; z -= 1.5) {
    SCOPED_TRACE(z);
    const Vec3d next{0.3, 0.2, z};
    stroke.apply(stampOf(last, next, 8));
    free.apply(stampOf(last, next, 8));
    last = next;
    const std::vector<WallAhead> walls = stroke.wallsAhead();
    EXPECT_TRUE(free.wallsAhead().empty());
    if (z > 6 || z < 3) {
      ASSERT_EQ(walls.size(), z > 6 ? 0u : 1u);
    }
    if (walls.empty()) continue;
    EXPECT_NEAR(walls[0].place.z(), -1, 0.05);
    EXPECT_LT((walls[0].place - Vec3d(0.3, 0.2, -1)).norm(), 0.6);
    EXPECT_GT(-walls[0].wall.z(), 0.99);
    EXPECT_EQ(walls[0].image, 0u);
    EXPECT_EQ(stroke.wallsAhead().size(), walls.size()) << "asked again";
  }
  stroke.apply(stampOf({30, 30, 60}, {30, 30, 60}, 8));
  EXPECT_TRUE(stroke.wallsAhead().empty()) << "lifted and come down elsewhere";
}

TEST(WallLimit, SaysWhatIsAheadInACornerAndOfEachImage) {
  const Version thick = block({0, 0, 0}, {60, 60, 60});
  BrushStroke stroke(thick, carving(5));
  // Into the edge between two sides from within, and its mirror image.
  Vec3d last{0, 0, 40};
  const auto image = [](const Vec3d& p) { return Vec3d(-p.x(), p.y(), p.z()); };
  for (const Vec3d& next : {Vec3d(8, 0, 30), Vec3d(15, 0, 10), Vec3d(19, 0, -10), Vec3d(40, 0, -40)}) {
    const Vec3d way = next - last;
    const int steps = static_cast<int>(way.norm() / 1.2) + 1;
    for (int i = 1; i <= steps; ++i) {
      const Vec3d a = last + way * (i - 1) / steps, b = last + way * i / steps;
      const Stamp images[] = {stampOf(a, b, 6), stampOf(image(a), image(b), 6)};
      stroke.apply(images);
    }
    last = next;
  }
  const std::vector<WallAhead> walls = stroke.wallsAhead();
  ASSERT_EQ(walls.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    const bool mirrored = walls[i].image == 1;
    EXPECT_EQ(mirrored, i >= 2);
    const Vec3d wall = mirrored ? image(walls[i].wall) : walls[i].wall;
    const Vec3d place = mirrored ? image(walls[i].place) : walls[i].place;
    EXPECT_GT(std::max(wall.x(), -wall.z()), 0.99) << wall.transpose();
    EXPECT_NEAR(wall.x() > 0.5 ? place.x() : -place.z(), 30 - 6 - 5, 0.1);
  }
}

// Any stroke on any shape.
TEST(WallLimit, HoldsOnAnyShapeFromAnySide) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1, 1);
  const auto direction = [&] {
    for (;;)
      if (const Vec3d d(share(random), share(random), share(random)); d.norm() > 0.1 && d.norm() < 1)
        return Vec3d(d.normalized());
  };
  const std::vector<std::pair<const char*, Version>> shapes{
      {"ball", makeSphere(Store::make(), grid(), {0, 0, 0}, 30)},
      {"ring", makeTorus(Store::make(), grid(), {0, 0, 0}, 30, 13)},
      {"shell", shell(makeSphere(Store::make(), grid(), {0, 0, 0}, 36), 16, 0)},
      {"ellipsoid", makeEllipsoid(Store::make(), grid(), {0, 0, 0}, {40, 26, 17})},
      {"two", combine(makeSphere(Store::make(), grid(), {-14, 0, 0}, 22), block({16, 0, 0}, {36, 30, 26}),
                      Combination::join)}};
  int changed = 0;
  for (const auto& [name, clay] : shapes)
    for (int i = 0; i < 12; ++i) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(i));
      const double wall = 3 + 3 * (1 + share(random)), radius = 3 + 5 * (1 + share(random));
      std::vector<Vec3d> way{60 * direction()};
      for (int k = 0; k < 3; ++k) way.push_back(15 * direction());
      // Every other hand presses harder and less hard, at once or by and by.
      double pressed = 0.5;
      const auto pressure = [&] {
        pressed = i % 4 == 1 ? 0.55 + 0.45 * share(random) : std::clamp(pressed + 0.1 * share(random), 0.1, 1.0);
        return i % 2 == 0 ? 1.0 : std::max(0.51 / radius, pressed);
      };
      const Version cut = carve(clay, wall, way, radius, false, pressure);
      changed += cut.hash() != clay.hash();
      // Where tip and surface almost touch there are flakes of a few voxels, as without a limit.
      EXPECT_GE(leastWall(removeCrumbs(cut, 20).version, wall + 1), wall - 0.1)
          << "wall " << wall << ", radius " << radius;
    }
  EXPECT_GE(changed, 50);
}

}  // namespace
}  // namespace argil::clay
