// What makes a piece ready to print: infill, drain holes, cuts with pegs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <vector>

#include "clay/base/error.h"
#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/surface/wall_map.h"
#include "clay/whole/boolean.h"
#include "clay/whole/deform.h"
#include "clay/whole/drain.h"
#include "clay/whole/fill_hollows.h"
#include "clay/whole/offset.h"
#include "clay/whole/pegs.h"
#include "clay/whole/ways_out.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

using testing::bandFaults;
using testing::clayVolume;
using testing::errorAgainst;
using testing::expectClosed;

Grid grid(double voxelMm = 0.5) {
  Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = Vec3d(0.13, -0.2, 0.07);
  return grid;
}
Version ball(const Vec3d& at, double radius) {
  return makeSphere(Store::make(), grid(), at, radius);
}
Version block(const Vec3d& at, const Vec3d& size) {
  return makeBlock(Store::make(), grid(), at, size, 0);
}
Version hollowBall() {
  return shell(ball(Vec3d::Zero(), 20), 3, 0);
}

// Rod

TEST(Rod, IsExactInAnyDirection) {
  const Vec3d from(-4, 3, -6), to(7, -2, 5), axis = (to - from).normalized();
  const double length = (to - from).norm(), radius = 4, chamfer = 1.5;
  const Version rod = makeRod(Store::make(), grid(), from, to, radius, chamfer);
  const std::vector<Eigen::Vector2d> corners{
      {0, 0},     {radius - chamfer, 0}, {radius, chamfer}, {radius, length - chamfer}, {radius - chamfer, length},
      {0, length}};
  const auto exact = [&](const Vec3d& p) {
    const double z = (p - from).dot(axis), r = (p - from - z * axis).norm();
    double least = INFINITY;
    for (size_t i = 0; i + 1 < corners.size(); ++i) {
      const Eigen::Vector2d side = corners[i + 1] - corners[i], from2(r - corners[i].x(), z - corners[i].y());
      const double t = std::clamp(from2.dot(side) / side.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from2 - t * side).norm());
    }
    const double end = std::min(z, length - z);
    return r < radius && end > 0 && radius - r + end > chamfer ? -least : least;
  };
  EXPECT_LT(errorAgainst(rod, exact).bandMax, 0.01);
  const double cut = std::numbers::pi * chamfer * chamfer * (radius - chamfer / 3);  // Pappus, at either end
  EXPECT_NEAR(clayVolume(rod) * 0.125, std::numbers::pi * radius * radius * length - 2 * cut, 2);
  testing::expectProperBand(rod);
  expectClosed(rod);
  EXPECT_THROW((void)makeRod(Store::make(), grid(), from, from, 3), Error);
  EXPECT_THROW((void)makeRod(Store::make(), grid(), from, to, 3, 3.5), Error);
}

// Infill

double medianWall(const Version& version, double most) {
  Surface surface;
  WallMap map(most, 0);
  map.follow(surface.update(version, 2), 2, WorkPart(nullptr));
  std::vector<float> walls;
  surface.forEach([&](const BrickMesh& mesh) {
    for (const float each : map.sizes(mesh.brick, SideOf::wall))
      if (std::isfinite(each)) walls.push_back(each);
  });
  std::nth_element(walls.begin(), walls.begin() + std::ptrdiff_t(walls.size() / 2), walls.end());
  return walls[walls.size() / 2];
}

TEST(FillHollows, ReachTheDensityAndTheWallAskedFor) {
  const Version hollow = hollowBall();
  const double inside = 4.0 / 3 * std::numbers::pi * 17 * 17 * 17;
  for (const Infill kind : {Infill::gyroid, Infill::struts, Infill::cubic})
    for (const double density : {0.1, 0.3}) {
      SCOPED_TRACE(int(kind) * 100 + density);
      const FilledHollows made =
          fillHollows(hollow, {.kind = kind, .density = density, .wallMm = 2}, 2, WorkPart(nullptr));
      const double came = (clayVolume(made.version) - clayVolume(hollow)) * 0.125;
      std::printf("kind %d, %.2f asked: %.4f, cells of %.1f mm; %.2f without edges\n", int(kind), density,
                  came / inside, made.cellMm, infillDensity(kind, 2 / made.cellMm));
      EXPECT_NEAR(came / inside, density, 0.01);
      EXPECT_NEAR(made.density, came / inside, 0.002);
      EXPECT_NEAR(made.hollowMm3, inside, 0.005 * inside);
      EXPECT_EQ(bandFaults(made.version).besideTile, 0u);
      expectClosed(made.version, 0);
      EXPECT_EQ(bodyVolumes(made.version).size(), 1u);  // nothing hangs in the air
      // Outside it changed by less than a tenth of a voxel, where the join took out what is too thin.
      const Version solid = fillVoids(hollow).version;
      hollow.forEachBrick([&](const Brick& brick) {
        const Slot now = made.version.find(brick.coord), filled = solid.find(brick.coord);
        for (int i = 0; i < kBrickVoxels; ++i) {
          if (filled.phi(i, 3) < 0) continue;
          ASSERT_NEAR(now.phi(i, 3), brick.phi(i), 0.1);
        }
      });
    }
}

TEST(FillHollows, WallsAreAsThickAsAsked) {
  const Version hollow = shell(ball(Vec3d::Zero(), 40), 5, 0);
  const FilledHollows made =
      fillHollows(hollow, {.kind = Infill::gyroid, .density = 0.15, .wallMm = 3}, 2, WorkPart(nullptr));
  EXPECT_NEAR(medianWall(made.version, 9), 6, 0.25);  // voxels, of 6 and of the shell's 10 that are cut off at 9
}

TEST(FillHollows, SaysWhatCannotBe) {
  const HollowFilling filling;
  EXPECT_THROW((void)fillHollows(ball(Vec3d::Zero(), 10), filling, 1, WorkPart(nullptr)), Error);
  HollowFilling thin = filling;
  thin.wallMm = 0.9;
  EXPECT_THROW((void)fillHollows(hollowBall(), thin, 1, WorkPart(nullptr)), Error);
  HollowFilling dense = filling;
  dense.density = NAN;
  EXPECT_THROW((void)fillHollows(hollowBall(), dense, 1, WorkPart(nullptr)), Error);
}

// Drain holes

// Air, voxels, from which nothing runs out although it may go down and sideways: told by going the other way from
// outside. `up`: an axis of the grid and its sign.
double staysIn(const Version& version, Coord up) {
  const BoxMm box = boundsOf(version);
  const Vec3d low = version.grid().toVoxel(box.low), high = version.grid().toVoxel(box.high);
  const Coord first{int(low.x()) - 3, int(low.y()) - 3, int(low.z()) - 3};
  const Coord size{int(high.x() - low.x()) + 7, int(high.y() - low.y()) + 7, int(high.z() - low.z()) + 7};
  const auto index = [&](Coord v) {
    return (size_t(v.x) * size_t(size.y) + size_t(v.y)) * size_t(size.z) + size_t(v.z);
  };
  const auto within = [&](Coord v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size.x && v.y < size.y && v.z < size.z;
  };
  std::vector<uint8_t> state(size_t(size.x) * size_t(size.y) * size_t(size.z));  // 1 clay, 2 runs out
  Sampler sampler(version);
  std::vector<Coord> todo;
  double air = 0;
  for (int x = 0; x < size.x; ++x)
    for (int y = 0; y < size.y; ++y)
      for (int z = 0; z < size.z; ++z) {
        const Coord v{x, y, z};
        if (sampler.voxel(first + v) < 0) {
          state[index(v)] = 1;
          continue;
        }
        ++air;
        if (x == 0 || y == 0 || z == 0 || x == size.x - 1 || y == size.y - 1 || z == size.z - 1)
          state[index(v)] = 2, todo.push_back(v);
      }
  double out = 0;
  while (!todo.empty()) {
    const Coord v = todo.back();
    todo.pop_back();
    ++out;
    for (const Coord way :
         {Coord{1, 0, 0}, Coord{-1, 0, 0}, Coord{0, 1, 0}, Coord{0, -1, 0}, Coord{0, 0, 1}, Coord{0, 0, -1}}) {
      if (way == Coord{0, 0, 0} - up) continue;
      const Coord next = v + way;
      if (within(next) && state[index(next)] == 0) state[index(next)] = 2, todo.push_back(next);
    }
  }
  return air - out;
}
double poolVoxels(double diameterMm) {
  return 2.0 / 3 * std::numbers::pi * std::pow(diameterMm / 2 / 0.5, 3);
}

// A body on three legs of different lengths, hollow.
Version hollowStool() {
  Version stool = block({0, 0, 12}, {40, 40, 14});
  for (const auto& [x, y, deep] : {std::tuple{-13.0, -13.0, 30.0}, {13.0, -13.0, 24.0}, {0.0, 13.0, 36.0}})
    stool = combine(stool, block({x, y, 12 - deep / 2}, {12, 12, deep}), Combination::join);
  return shell(stool, 2.5, 0);
}

TEST(Drain, EmptiesABallByOneHoleAndLetsAirInAtTheTop) {
  const Version hollow = hollowBall();
  EXPECT_GT(staysIn(hollow, {0, 0, 1}), 10000);
  const Drained made = drain(hollow, {.diameterMm = 4}, WorkPart(nullptr));
  ASSERT_EQ(made.holes.size(), 2u);
  for (const DrainHole& hole : made.holes) {
    const double side = hole.vent ? 1 : -1;
    EXPECT_LT((hole.toMm.normalized() - side * Vec3d::UnitZ()).norm(), 0.2);  // the wall is as thick everywhere
    EXPECT_LT((hole.toMm - hole.fromMm).norm(), 12);
  }
  EXPECT_LE(staysIn(made.version, {0, 0, 1}), poolVoxels(4));
  EXPECT_LE(staysIn(made.version, {0, 0, -1}), poolVoxels(4));
  expectClosed(made.version);
  EXPECT_EQ(bandFaults(made.version).besideTile, 0u);
  EXPECT_EQ(made.cups, 0);
  const Drained below = drain(hollow, {.diameterMm = 4, .vents = false}, WorkPart(nullptr));
  ASSERT_EQ(below.holes.size(), 1u);
  EXPECT_FALSE(below.holes[0].vent);
}

TEST(Drain, EmptiesEveryLegHoweverThePieceIsTurned) {
  const Version hollow = hollowStool();
  const struct {
    Vec3d axis;
    double quarters;
    Coord up;  // in the piece
    size_t least;
  } cases[] = {{Vec3d::UnitX(), 0, {0, 0, 1}, 3},
               {Vec3d::UnitX(), 2, {0, 0, -1}, 1},
               {Vec3d::UnitX(), 1, {0, 1, 0}, 1},
               {Vec3d::UnitY(), 1, {-1, 0, 0}, 1}};
  for (const auto& each : cases) {
    SCOPED_TRACE(each.axis.transpose());
    DrainOptions options{.diameterMm = 3, .vents = false};
    options.turn = Eigen::AngleAxisd(each.quarters * std::numbers::pi / 2, each.axis).toRotationMatrix();
    EXPECT_LT((options.turn * each.up.toVec3d() - Vec3d::UnitZ()).norm(), 1e-9);
    const Drained made = drain(hollow, options, WorkPart(nullptr));
    EXPECT_GE(made.holes.size(), each.least);
    EXPECT_LE(made.holes.size(), 8u);
    EXPECT_LE(staysIn(made.version, each.up), 3 * poolVoxels(3));
    // Nothing is bored upwards.
    for (const DrainHole& hole : made.holes)
      EXPECT_LE((hole.toMm - hole.fromMm).normalized().dot(each.up.toVec3d()), 0.11);
  }
}

TEST(Drain, PlugsFitTheirHoles) {
  const Version hollow = hollowBall();
  const double clearance = 0.25;
  const Drained made = drain(hollow, {.diameterMm = 6, .plugs = true, .clearanceMm = clearance}, WorkPart(nullptr));
  ASSERT_EQ(made.plugs.size(), made.holes.size());
  const double bored = (clayVolume(hollow) - clayVolume(made.version)) * 0.125;
  double plugs = 0;
  for (const Version& plug : made.plugs) {
    expectClosed(plug);
    plugs += clayVolume(plug) * 0.125;
    Sampler drained(made.version);
    // Free of the hole's side by the clearance; flush with both surfaces.
    double nearest = INFINITY;
    plug.forEachBrick([&](const Brick& brick) {
      for (int i = 0; i < kBrickVoxels; ++i) {
        if (brick.phi(i) >= 0) continue;
        const Coord v = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
        nearest = std::min(nearest, double(drained.voxel(v) - brick.phi(i)));
      }
    });
    EXPECT_GE(nearest * 0.5, clearance - 0.05);
  }
  EXPECT_NEAR(plugs / bored, std::pow((3 - clearance) / 3, 2), 0.03);
}

TEST(Drain, LeavesCupsThatWereOpenAndSaysSo) {
  // A ball with a hollow, and a dish in its top.
  const Version both = combine(hollowBall(), ball({0, 0, 22.8}, 5), Combination::cut);
  const Drained made = drain(both, {.diameterMm = 3, .vents = false}, WorkPart(nullptr));
  EXPECT_EQ(made.holes.size(), 1u);
  EXPECT_EQ(made.cups, 1);
}

// What a check of a print finds is what this mends.
TEST(Drain, HollowsThatOpenTooNarrowlyAreDrainedToo) {
  const auto store = Store::make();
  Version narrow = hollowBall();
  for (const Vec3d& way : {Vec3d(0, 0, 30), Vec3d(0, 0, -30), Vec3d(25, 5, -3)})
    narrow = combine(narrow, makeRod(store, grid(), Vec3d::Zero(), way, 0.9, 0), Combination::cut);
  const double asked = 4;
  ASSERT_EQ(narrowWaysOut(narrow, asked / 2, 1, WorkPart(nullptr)).size(), 1u);
  const Drained made = drain(narrow, {.diameterMm = asked}, WorkPart(nullptr));
  EXPECT_EQ(made.holes.size(), 2u) << "one below and one for air";
  EXPECT_TRUE(narrowWaysOut(made.version, asked / 2 - 0.25, 1, WorkPart(nullptr)).empty());
  EXPECT_LE(staysIn(made.version, {0, 0, 1}), poolVoxels(asked));
  expectClosed(made.version);
  // Both bores are as they were: plugs are only thought of.
  Sampler sampler(made.version);
  for (const Vec3d& at : {Vec3d(0, 0, 18.5), Vec3d(18.1, 3.6, -2.2)})
    EXPECT_GT(sampler.trilinear(made.version.grid().toVoxel(at)), 0.9);
  // A way as wide as the holes is open.
  const Version open =
      combine(hollowBall(), makeRod(store, grid(), Vec3d::Zero(), {0, 0, -30}, 2.2, 0), Combination::cut);
  EXPECT_THROW((void)drain(open, {.diameterMm = asked}, WorkPart(nullptr)), Error);
}

TEST(Drain, SaysWhatCannotBe) {
  EXPECT_THROW((void)drain(ball(Vec3d::Zero(), 10), {}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)drain(hollowBall(), {.diameterMm = 1.9}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)drain(hollowBall(), {.diameterMm = NAN}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)drain(hollowBall(), {.diameterMm = 3, .plugs = true, .clearanceMm = 1.2}, WorkPart(nullptr)),
               Error);
  EXPECT_NO_THROW((void)drain(hollowBall(), {.diameterMm = 3, .clearanceMm = 1.2}, WorkPart(nullptr)));
}

// Pegs

// The deepest that one piece reaches into the other when it is moved, voxels.
double overlap(const Version& one, const Version& other, const Vec3d& moveVoxels) {
  Sampler sampler(other);
  double deepest = 0;
  one.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (brick.phi(i) >= 0) continue;
      const Vec3d p = (brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d() + moveVoxels;
      deepest = std::max(deepest, std::min(-double(sampler.trilinear(p)), -double(brick.phi(i))));
    }
  });
  return deepest;
}

TEST(Pegs, HoldTwoHalvesThatComeTogetherFreely) {
  const Version whole = block({1, 2, 3}, {30, 22, 34});
  for (const bool loose : {false, true})
    for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(0.2, -0.3, 1)}) {
      SCOPED_TRACE(loose);
      const PegOptions options{.pointMm = {0, 0, 4}, .normal = normal, .clearanceMm = 0.3, .loose = loose};
      const PeggedHalves made = cutWithPegs(whole, options, WorkPart(nullptr));
      ASSERT_EQ(made.pegs.size(), 2u);
      EXPECT_EQ(made.areas, 1);
      EXPECT_EQ(made.without, 0);
      EXPECT_EQ(made.pins.size(), loose ? 2u : 0u);
      EXPECT_GT((made.pegs[0].atMm - made.pegs[1].atMm).norm(), 9);
      EXPECT_NEAR(made.pegs[0].diameterMm, 7, 3);
      expectClosed(made.front);
      expectClosed(made.back);
      const double d = made.pegs[0].diameterMm, deep = made.pegs[0].depthMm;
      const double peg = std::numbers::pi * d * d / 4 * deep,
                   hole = std::numbers::pi * std::pow(d / 2 + 0.3, 2) * (deep + 0.3);
      const double lost = (clayVolume(whole) - clayVolume(made.front) - clayVolume(made.back)) * 0.125;
      EXPECT_NEAR(lost, loose ? 4 * hole : 2 * (hole - peg), 0.12 * 2 * hole);
      // Moved apart along the normal they never meet, from the first step on.
      const Vec3d n = normal.normalized();
      for (const double step : {0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 19.0, 25.0, 40.0})
        EXPECT_LE(overlap(made.back, made.front, -n * step), 0.1) << step;
      for (const Version& pin : made.pins) {
        expectClosed(pin);
        EXPECT_LE(overlap(pin, made.front, Vec3d::Zero()), 0.02);
        EXPECT_LE(overlap(pin, made.back, Vec3d::Zero()), 0.02);
      }
      // Turned or pushed aside by more than the clearance they do.
      EXPECT_GT(overlap(loose ? made.pins[0] : made.back, made.front, n.unitOrthogonal() * 2), 0.3);
    }
}

TEST(Pegs, StandInEveryAreaOfTheCut) {
  const Version ring = makeTorus(Store::make(), grid(), Vec3d::Zero(), 30, 8);
  const PeggedHalves made =
      cutWithPegs(ring, {.pointMm = {0, 0, 0}, .normal = Vec3d::UnitX(), .pegs = 1}, WorkPart(nullptr));
  ASSERT_EQ(made.pegs.size(), 2u);
  EXPECT_EQ(made.areas, 2);
  EXPECT_LT(made.pegs[0].atMm.y() * made.pegs[1].atMm.y(), 0);
  for (const Peg& peg : made.pegs) EXPECT_LT(std::abs(std::abs(peg.atMm.y()) - 30), 1.5);
}

TEST(Pegs, HaveClayAroundThem) {
  // In the wall of a hollow block; the hollow is no place for a peg, nor is what lies close behind the cut.
  const Version hollow = shell(block(Vec3d::Zero(), {50, 50, 50}), 9, 0);
  const PeggedHalves made = cutWithPegs(hollow, {.normal = Vec3d::UnitZ()}, WorkPart(nullptr));
  ASSERT_EQ(made.pegs.size(), 2u);
  const auto clayAround = [](const Version& whole, const Peg& peg) {
    Sampler sampler(whole);
    double least = INFINITY;
    for (double z = -peg.depthMm; z <= peg.depthMm; z += 0.25)
      for (int i = 0; i < 32; ++i) {
        const double turn = 2 * std::numbers::pi * i / 32,
                     r = peg.diameterMm / 2 + 0.15 + std::max(1.0, 0.3 * peg.diameterMm) - 0.3;
        least = std::min(least, -double(sampler.trilinear(whole.grid().toVoxel(
                                    peg.atMm + Vec3d(r * std::cos(turn), r * std::sin(turn), z)))));
      }
    return least;
  };
  for (const Peg& peg : made.pegs) EXPECT_GT(clayAround(hollow, peg), 0);
  // A cap of 6 mm above the cut leaves no room for what is deeper.
  const Version cap = block({0, 0, -22}, {50, 50, 56});
  const PeggedHalves low = cutWithPegs(cap, {.normal = Vec3d::UnitZ()}, WorkPart(nullptr));
  ASSERT_FALSE(low.pegs.empty());
  for (const Peg& peg : low.pegs) EXPECT_LT(peg.depthMm, 5);
}

TEST(Pegs, SayWhatCannotBe) {
  const Version whole = block({0, 0, 0}, {30, 30, 30});
  EXPECT_THROW((void)cutWithPegs(whole, {.pointMm = {0, 0, 40}}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)cutWithPegs(whole, {.diameterMm = 28}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)cutWithPegs(whole, {.diameterMm = 1}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)cutWithPegs(whole, {.pegs = 0}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)cutWithPegs(whole, {.depthMm = NAN}, WorkPart(nullptr)), Error);
  EXPECT_THROW((void)cutWithPegs(block({0, 0, 0}, {30, 3, 30}), {}, WorkPart(nullptr)), Error);
}

}  // namespace
}  // namespace argil::clay
