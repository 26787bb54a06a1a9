// Strokes on clay: what the whole chain from stamps to surface promises.

#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/jacobi_solver.h"
#include "clay/field/primitives.h"
#include "clay/field/redistance.h"
#include "clay/field/scratch.h"
#include "clay/field/settle.h"
#include "clay/import/height_image.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/simd_targets.h"
#include "tests/support/tier.h"

namespace argil::clay {
namespace {

struct RandomStroke {
  std::shared_ptr<const Brush> brush;
  std::vector<Stamp> stamps;
};

RandomStroke randomStroke(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> u(-1, 1);
  std::normal_distribution<double> normal;
  const Vec3d at = Vec3d(normal(random), normal(random), normal(random)).normalized() * reach;
  const Method method = std::array{Method::carve, Method::add, Method::smooth}[random() % 3];
  const double radius = 2 + 5 * (u(random) + 1);
  std::vector<Stamp> stamps;
  Vec3d a = at;
  const int count = 1 + static_cast<int>(random() % 6);
  for (int i = 0; i < count; ++i) {
    const Vec3d b = a + Vec3d(u(random), u(random), u(random)) * radius * 0.5;
    stamps.push_back({a, b, radius, static_cast<float>(0.5 + 0.5 * u(random))});
    a = b;
  }
  return {Brush::of(method), stamps};
}

// The outcome of a number of random strokes as hashes, so that whole runs can be compared.
struct Outcome {
  std::vector<uint64_t> versions;
  uint64_t surface = 0;
};

Outcome run(int strokes, uint64_t seed, int publishEvery) {
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  Version version = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  Outcome result;
  Surface surface;
  for (int s = 0; s < strokes; ++s) {
    const RandomStroke drawn = randomStroke(random, 40);
    BrushStroke stroke(version, drawn.brush);
    int n = 0;
    for (const Stamp& stamp : drawn.stamps) {
      stroke.apply(stamp);
      if (++n % publishEvery == 0) surface.update(stroke.publish());
    }
    version = stroke.finish();
    surface.update(version);
    result.versions.push_back(version.hash());
    store->collect();
  }
  result.surface = surface.hash();
  return result;
}

TEST(Strokes, EqualBitsOnEverySimdTargetHoweverPublished) {
  const Outcome reference = run(60, 7, 1);
  tests::forEachSimdTarget([&](const std::string& name) {
    for (const int publishEvery : {1, 3, 1000}) {
      const Outcome other = run(60, 7, publishEvery);
      EXPECT_EQ(other.versions, reference.versions) << name << ' ' << publishEvery;
      EXPECT_EQ(other.surface, reference.surface) << name << ' ' << publishEvery;
    }
  });
}

// A stamp may be taken in steps, and looked at between any two of them: closed all the time, and the stroke is the
// same.
TEST(Strokes, InStepsIsTheSameStroke) {
  struct Case {
    const char* what;
    Brush brush;
    double modelRadius, radius;
    int stamps, atLeast;  // pauses
    Precision precision = Precision::float32;
  };
  const auto of = [](Method method) { return *Brush::of(method); };
  Brush raise = of(Method::raise), layer = raise, tall = raise, wax = of(Method::wax), walled = of(Method::carve);
  raise.height = layer.height = 6;
  layer.limited = true;
  tall.height = 60;
  wax.blend = 3;
  walled.leastWall = 4;
  const Case cases[] = {{"a tug that begins anew", of(Method::tug), 15, 12, 60, 5},
                        {"raise", raise, 45, 70, 3, 10},
                        {"a raise in parts", tall, 45, 70, 3, 30},
                        {"layer", layer, 45, 70, 3, 10},
                        {"tug", of(Method::tug), 45, 70, 12, 10},
                        {"carve", of(Method::carve), 45, 90, 9, 3},
                        {"add", of(Method::add), 45, 70, 3, 3},
                        {"wax", wax, 45, 70, 3, 6},
                        {"smooth", of(Method::smooth), 45, 70, 12, 10},
                        {"smooth and keep", of(Method::smoothKeep), 45, 70, 3, 10},
                        {"scrape", of(Method::scrape), 45, 70, 3, 10},
                        {"carve to a wall", walled, 45, 90, 9, 3},
                        {"smooth 16 bits", of(Method::smooth), 45, 70, 12, 10, Precision::fixed16},
                        {"tug 16 bits", of(Method::tug), 45, 70, 12, 10, Precision::fixed16}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.what);
    const Version ball = makeSphere(Store::make(each.precision), Grid{}, Vec3d(0.2, 0.1, 0.3), each.modelRadius);
    const auto brush = std::make_shared<const Brush>(each.brush);
    // `look`: at every so many pauses a version is published.
    const auto drawn = [&](int look) {
      BrushStroke stroke(ball, brush);
      Surface surface;
      int pauses = 0;
      const double on = each.modelRadius / ball.grid().voxelMm + 1;  // voxels
      Vec3d before = on * Vec3d::UnitX();
      for (int i = 0; i < each.stamps; ++i) {
        const double angle = 0.05 * (i % 20);
        const Vec3d at = on * Vec3d(std::cos(angle), std::sin(angle), 0);
        const Stamp stamp{before, at, each.radius};
        while (stroke.step({&stamp, 1})) {
          if (++pauses % look != 0) continue;
          surface.update(stroke.publish());
          if (pauses % (5 * look) < look) {
            EXPECT_TRUE(checkTopology(surface.toMesh()).closed());
          }
        }
        before = at;
      }
      EXPECT_GE(pauses, each.atLeast);
      return stroke.finish().hash();
    };
    const uint64_t unseen = drawn(1 << 30);
    EXPECT_EQ(drawn(1), unseen);
    EXPECT_EQ(drawn(3), unseen);
  }
}

// The same on clay that is painted and masked, with two images; new clay is never seen without the colour that it gets.
TEST(Strokes, InStepsOnPaintedAndMaskedClay) {
  Version clay = makeSphere(Store::make(), Grid{}, Vec3d(0.2, 0.1, 0.3), 45);
  for (const Property property : {Property::colour, Property::mask}) {
    Brush set;
    set.operations = {{.property = property, .method = Method::set}};
    set.colour = {200, 10, 30};
    BrushStroke stroke(clay, std::make_shared<const Brush>(set));
    stroke.apply({Vec3d(80, 30, 0), Vec3d(70, 50, 10), 25});
    clay = stroke.finish();
  }
  for (const Method method : {Method::smooth, Method::tug, Method::add}) {
    uint64_t hash = 0;
    const auto drawn = [&](bool seen) {
      BrushStroke stroke(clay, Brush::of(method));
      int pauses = 0;
      for (int i = 0; i < 5; ++i) {
        const Stamp images[] = {{Vec3d(90, 5 * i, 0), Vec3d(89, 5 * i + 5, 0), 70},
                                {Vec3d(-90, 5 * i, 0), Vec3d(-89, 5 * i + 5, 0), 70}};
        const uint64_t before = seen ? stroke.publish().hash() : 0;
        while (stroke.step(images)) {
          ++pauses;
          if (seen) {
            ASSERT_EQ(stroke.publish().hash(), before);
          }
        }
      }
      EXPECT_GT(pauses, 10);
      hash = stroke.finish().hash();
    };
    drawn(false);
    const uint64_t unseen = hash;
    drawn(true);
    EXPECT_EQ(hash, unseen) << int(method);
  }
}

// Seen between its steps, the surface is closed all the time, also where it leaves whole bricks behind.
TEST(Strokes, WhatIsSeenOfAStampIsClosed) {
  Brush raise = *Brush::of(Method::raise), wax = *Brush::of(Method::wax);
  raise.height = 15.5;
  wax.blend = 3;
  const std::vector<uint8_t> white(64 * 64, 255);
  for (const char* what : {"raise", "lower", "up to a limit", "emboss", "wax"}) {
    SCOPED_TRACE(what);
    Brush brush = what[0] == 'w' ? wax : raise;
    if (what[0] == 'l') brush.operations[0].amount = -1;
    brush.limited = what[0] == 'u';
    if (what[0] == 'e') brush.image = std::make_shared<const HeightImage>(64, 64, white);
    // Its top lies so that a tile above it becomes clay through and through.
    const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -7.6), {80, 80, 20}, 0);
    BrushStroke stroke(block, std::make_shared<const Brush>(brush));
    Surface surface;
    int steps = 0;
    for (int i = 0; i < 5; ++i) {
      const double way = what[0] == 'w' ? 25 : 3;  // of wax, what lies behind is not looked at again
      const Stamp stamp{Vec3d(way * i, 0, 0), Vec3d(way * (i + 1), 0, 0), what[0] == 'w' ? 50.0 : 70.0};
      while (stroke.step({&stamp, 1})) {
        ++steps;
        if (surface.update(stroke.publish()).changed.empty()) continue;
        ASSERT_TRUE(checkTopology(surface.toMesh()).closed()) << steps;
      }
    }
    EXPECT_GT(steps, 3);
  }
}

// A stamp that was begun belongs to the stroke, whoever ends it; dropped, it leaves the clay and the store as they
// were.
TEST(Strokes, AStampThatWasBegunIsEndedOrDropped) {
  const auto store = Store::make();
  const Version ball = makeSphere(store, Grid{}, Vec3d(0.2, 0.1, 0.3), 45);
  const auto brush = Brush::of(Method::smoothKeep);
  const Stamp stamp{Vec3d(91, 0, 0), Vec3d(89, 15, 0), 70};
  BrushStroke whole(ball, brush);
  whole.apply(stamp);
  const uint64_t expected = whole.finish().hash();
  BrushStroke begun(ball, brush);
  ASSERT_TRUE(begun.step({&stamp, 1}));
  ASSERT_TRUE(begun.step({&stamp, 1}));
  EXPECT_EQ(begun.finish().hash(), expected);
  const auto settled = [&] {
    while (store->collect()) {
    }
    return store->usage().bytes();
  };
  (void)settled();
  const uint64_t before = store->usage().bricks;
  {
    BrushStroke dropped(ball, brush);
    for (int i = 0; i < 8; ++i) {
      ASSERT_TRUE(dropped.step({&stamp, 1}));
      (void)dropped.publish();
    }
  }
  (void)settled();
  EXPECT_EQ(store->usage().bricks, before);
}

TEST(Strokes, ThousandStrokesFollowedUndoneAndRedone) {
  const uint64_t seed = 1000;
  std::mt19937_64 random(seed);
  const auto store = Store::make();
  std::vector<Version> history{makeSphere(store, Grid{}, Vec3d::Zero(), 25)};
  const uint64_t first = history[0].hash();
  Surface following[3];
  const int threads[3] = {1, 2, 4};
  for (int s = 0; s < tests::byTier(500, 1000); ++s) {
    const RandomStroke drawn = randomStroke(random, 50);
    BrushStroke stroke(history.back(), drawn.brush);
    for (const Stamp& stamp : drawn.stamps) {
      stroke.apply(stamp);
      following[0].update(stroke.publish());
    }
    history.push_back(stroke.finish());
    for (int i = 0; i < 3; ++i) following[i].update(history.back(), threads[i]);
    store->collect();
    if (s % 50 != 49) continue;
    for (int i = 0; i < 3; ++i) {
      Surface anew;
      anew.update(history.back(), threads[2 - i]);
      ASSERT_EQ(following[i].hash(), anew.hash()) << "seed " << seed << " stroke " << s << " threads " << threads[i];
    }
    ASSERT_TRUE(checkTopology(following[0].toMesh()).closed()) << "seed " << seed << " stroke " << s;
  }
  const uint64_t last = history.back().hash(), lastSurface = following[0].hash();
  for (size_t i = history.size(); i-- > 0;) following[0].update(history[i]);
  EXPECT_EQ(following[0].version().hash(), first);
  Surface anew;
  anew.update(history[0]);
  EXPECT_EQ(following[0].hash(), anew.hash());
  for (const Version& v : history) following[0].update(v);
  EXPECT_EQ(following[0].version().hash(), last);
  EXPECT_EQ(following[0].hash(), lastSurface);
}

TEST(Strokes, FieldStaysCanonicalAndFinite) {
  std::mt19937_64 random(3);
  const auto store = Store::make();
  Version version = makeSphere(store, Grid{}, Vec3d::Zero(), 20);
  for (int s = 0; s < 100; ++s) {
    const RandomStroke drawn = randomStroke(random, 40);
    BrushStroke stroke(version, drawn.brush);
    for (const Stamp& stamp : drawn.stamps) stroke.apply(stamp);
    version = stroke.finish();
  }
  uint64_t bricks = 0;
  version.forEachBrick([&](const Brick& brick) {
    ++bricks;
    bool inBand = false;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float phi = brick.phi(i);
      ASSERT_TRUE(phi >= -3 && phi <= 3 && !(phi == 0 && std::signbit(phi)));
      ASSERT_EQ((brick.inside[i >> 6] >> (i & 63)) & 1, phi < 0 ? 1u : 0u);
      inBand |= std::abs(phi) < 3;
    }
    ASSERT_TRUE(inBand);
    // An inside tile never touches an outside one: beside a tile no voxel has the other sign.
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        Coord step{0, 0, 0};
        (axis == 0 ? step.x : axis == 1 ? step.y : step.z) = side;
        const Slot next = version.find(brick.coord + step);
        if (!next.isTile()) continue;
        for (int i = 0; i < 64; ++i) {
          int at[3];
          at[axis] = side < 0 ? 0 : 7;
          at[(axis + 1) % 3] = i >> 3;
          at[(axis + 2) % 3] = i & 7;
          ASSERT_EQ(brick.phi(Brick::offset(at[0], at[1], at[2])) < 0, next.tile() == Tile::inside);
        }
      }
  });
  EXPECT_EQ(bricks, version.stats().bricks);
}

TEST(Brush, CarveAndAddAreTheCsgOfDistances) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  std::mt19937_64 random(11);
  for (const Method method : {Method::carve, Method::add}) {
    const Stamp stamp{{35, 3, -2}, {38, 20, 5}, 9.5};
    BrushStroke stroke(base, Brush::of(method));
    stroke.apply(stamp);
    const Version after = stroke.publish();
    Sampler before(base), now(after);
    for (int i = 0; i < 100000; ++i) {
      const Coord c{static_cast<int>(random() % 60) + 5, static_cast<int>(random() % 50) - 15,
                    static_cast<int>(random() % 40) - 20};
      const Vec3d d = stamp.b - stamp.a, p = c.toVec3d() - stamp.a;
      const double t = std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 1.0), distance = (p - t * d).norm() - stamp.radius,
                   old = before.voxel(c);
      const double expected = method == Method::carve ? std::max(old, -distance) : std::min(old, distance);
      ASSERT_NEAR(now.voxel(c), std::clamp(expected, -3.0, 3.0), 2e-5);
    }
  }
}

// A brush that swallows whole regions of 64 voxels decides them without their voxels, with the same result.
TEST(Brush, LargeBrushesCostTheirSurface) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 120);
  const Stamp stamp{{150, 10, 20}, {170, 30, 10}, 140};
  BrushStroke stroke(base, Brush::of(Method::carve));
  stroke.apply(stamp);
  const Version after = stroke.publish();
  Sampler before(base), now(after);
  std::mt19937_64 random(12);
  for (int i = 0; i < 200000; ++i) {
    const Coord c{static_cast<int>(random() % 500) - 250, static_cast<int>(random() % 500) - 250,
                  static_cast<int>(random() % 500) - 250};
    const Vec3d d = stamp.b - stamp.a, p = c.toVec3d() - stamp.a;
    const double t = std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 1.0), distance = (p - t * d).norm() - stamp.radius;
    ASSERT_NEAR(now.voxel(c), std::clamp(std::max<double>(before.voxel(c), -distance), -3.0, 3.0), 5e-5);
  }
  // All of it, and canonical.
  BrushStroke everything(base, Brush::of(Method::carve));
  everything.apply({{0, 0, 0}, {0, 0, 0}, 4000});
  EXPECT_LT(everything.touched(), 1000u);  // regions; there are 24 000 bricks to go
  EXPECT_EQ(everything.finish().hash(), Version::empty(base.store(), base.grid()).hash());
}

TEST(Brush, OutOfRangeStampsAreRefusedAndChangeNothing) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 10);
  BrushStroke stroke(base, Brush::of(Method::carve));
  const double bad = std::nan("");
  EXPECT_THROW(stroke.apply({{bad, 0, 0}, {0, 0, 0}, 5}), Error);
  EXPECT_THROW(stroke.apply({{0, 0, 0}, {0, 0, 0}, bad}), Error);
  EXPECT_THROW(stroke.apply({{0, 0, 0}, {0, 0, 0}, 0.1}), Error);
  EXPECT_THROW(stroke.apply({{1e9, 0, 0}, {0, 0, 0}, 5}), Error);
  EXPECT_THROW(stroke.apply({{0, 0, 0}, {0, 0, 0}, 5, 1.5f}), Error);
  EXPECT_EQ(stroke.finish(), base);
}

TEST(Brush, SmoothFlattensABumpAndLeavesTheRestToTheBit) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  BrushStroke bump(ball, Brush::of(Method::add));
  bump.apply({{40, 0, 0}, {40, 0, 0}, 4});
  const Version rough = bump.finish();
  BrushStroke stroke(rough, Brush::of(Method::smooth));
  for (int i = 0; i < 40; ++i) stroke.apply({{40, 0, 0}, {40, 0, 0}, 12});
  const Version smooth = stroke.finish();
  Sampler before(rough), after(smooth);
  EXPECT_LT(before.trilinear(Vec3d(43, 0, 0)), 0);
  EXPECT_GT(after.trilinear(Vec3d(42, 0, 0)), 0);
  Version::forEachDifference(rough, smooth, [&](Coord c, Slot, Slot) {
    EXPECT_LT(((c * 8).toVec3d() + Vec3d::Constant(3.5) - Vec3d(40, 0, 0)).norm(), 12 + 3 + 2 * 6.1 + 8)
        << c.x << ' ' << c.y << ' ' << c.z;
  });
}

std::vector<Coord> allBricks(const Version& version) {
  std::vector<Coord> all;
  version.forEachBrick([&](const Brick& brick) { all.push_back(brick.coord); });
  std::sort(all.begin(), all.end());
  return all;
}

TEST(Redistance, LeavesExactDistancesToTheBit) {
  const Version sphere = makeSphere(Store::make(), Grid{}, Vec3d(0.2, 0.1, 0.3), 15);
  Editor editor(sphere);
  EXPECT_TRUE(redistance(editor, allBricks(sphere)).empty());
  EXPECT_EQ(editor.commit(), sphere);
}

// Beyond the rim of a hole cut square into a block the CSG of distances is too small; redistanced it is nearer to the
// distance from the surface that is there, by brute force over points spread on its triangles.
TEST(Redistance, MendsTheFieldBeyondARimAndKeepsTheSurface) {
  const auto store = Store::make();
  const Version block = makeBlock(store, Grid{}, Vec3d::Zero(), {40, 40, 20}, 0);
  BrushStroke stroke(block, Brush::of(Method::carve));
  // A ball whose centre lies on the upper face: the rim is a circle of its radius there, at a right angle.
  stroke.apply({{0, 0, 20}, {0, 0, 20}, 12});
  const Version cut = stroke.publish(), repaired = stroke.finish();
  Surface a(false), b(false);
  a.update(cut);
  b.update(repaired);
  EXPECT_EQ(a.hash(), b.hash());  // no vertex moved
  std::vector<Vec3d> points;
  const TriangleMesh mesh = a.toMesh();
  for (const auto& t : mesh.triangles)
    for (int i = 0; i <= 4; ++i)
      for (int j = 0; i + j <= 4; ++j)
        points.push_back((mesh.positions[t[0]] * i + mesh.positions[t[1]] * j + mesh.positions[t[2]] * (4 - i - j)) /
                         4 / cut.grid().voxelMm);
  std::erase_if(points,
                [](const Vec3d& p) { return p.x() < -1 || p.y() < -1 || p.x() > 20 || p.y() > 20 || p.z() < 0; });
  Sampler before(cut), after(repaired);
  double worstBefore = 0, worstAfter = 0, sumBefore = 0, sumAfter = 0;
  int count = 0;
  for (int x = 2; x <= 15; ++x)
    for (int y = 2; y <= 15; ++y)
      for (int z = 10; z <= 23; ++z) {
        const Coord c{x, y, z};
        const float u = before.voxel(c), v = after.voxel(c);
        ASSERT_EQ(u < 0, v < 0);
        // Around the rim alone: elsewhere both are right.
        if (std::hypot(std::hypot(x, y) - 12, z - 20) > 4) continue;
        double nearest = 9;
        for (const Vec3d& p : points) nearest = std::min(nearest, (p - c.toVec3d()).squaredNorm());
        const double exact = std::copysign(std::min(3.0, std::sqrt(nearest)), u);
        worstBefore = std::max(worstBefore, std::abs(u - exact));
        worstAfter = std::max(worstAfter, std::abs(v - exact));
        sumBefore += (u - exact) * (u - exact);
        sumAfter += (v - exact) * (v - exact);
        ++count;
      }
  std::printf("around a square rim: error %.3f voxels RMS, %.2f worst; after redistancing %.3f and %.2f\n",
              std::sqrt(sumBefore / count), worstBefore, std::sqrt(sumAfter / count), worstAfter);
  EXPECT_GT(worstBefore, 0.8);
  EXPECT_LT(worstAfter, 0.5 * worstBefore);
  EXPECT_LT(sumAfter, 0.25 * sumBefore);
}

TEST(Redistance, SecondTimeChangesNothing) {
  std::mt19937_64 random(17);
  Version version = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 20);
  for (int s = 0; s < 20; ++s) {
    const RandomStroke drawn = randomStroke(random, 40);
    BrushStroke stroke(version, drawn.brush);
    for (const Stamp& stamp : drawn.stamps) stroke.apply(stamp);
    version = stroke.finish();
  }
  Editor once(version);
  redistance(once, allBricks(version));
  const Version first = once.commit();
  Editor twice(first);
  EXPECT_TRUE(redistance(twice, allBricks(first)).empty());
}

// However many bricks are solved at once, on either path; the field is wrong all over, so that all of it is solved.
TEST(Redistance, InPartsIsAsAtOnceToTheBit) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0.1, 0.2, 0.05), {60, 50, 40}, 4);
  Editor wrong(block);
  for (const Coord& coord : allBricks(block)) {
    std::array<float, kBrickVoxels> values;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float phi = block.find(coord).phi(i, 3);
      // What is far is a bound alone, and slopes differ from place to place.
      values[size_t(i)] = std::abs(phi) > 1 ? std::copysign(2.99f, phi) : phi * (0.4f + 0.1f * float(coord.x & 3));
    }
    wrong.setVoxels(coord, values);
  }
  const Version field = wrong.commit();
  const std::vector<Coord> all = allBricks(field);
  for (const Renew how : {Renew::none, Renew::slopes, Renew::all}) {
    const std::vector<Renew> renew(how == Renew::none ? 0 : all.size(), how);
    const auto hash = [&](size_t atOnce) {
      Editor editor(field);
      EXPECT_GT(redistance(editor, all, renew, 1, {.atOnce = atOnce}).size(), 300u);
      return editor.commit().hash();
    };
    const uint64_t expected = hash(all.size());
    for (const size_t atOnce : {size_t(1), size_t(40), size_t(700)})
      EXPECT_EQ(hash(atOnce), expected) << int(how) << " " << atOnce;
  }
}

// The second would write over what the first solves.
TEST(Redistance, TwoSolversOnAThreadAreRefused) {
  const std::vector<Coord> one{Coord{0, 0, 0}};
  {
    const JacobiSolver<1> first(one, 1);
    EXPECT_THROW(JacobiSolver<2>(one, 1), std::logic_error);
    std::thread([&] { EXPECT_NO_THROW(JacobiSolver<2>(one, 1)); }).join();
  }
  EXPECT_NO_THROW(JacobiSolver<2>(one, 1));
}

// Memory is kept while strokes want it, and given back some time after a large one.
TEST(Redistance, RoomIsGivenBack) {
  std::thread([] {  // with rooms of its own
    constexpr auto kRoom = Scratch::Room::bricks;
    (void)Scratch::of<float>(1 << 20, kRoom);
    const size_t large = Scratch::kept();
    EXPECT_GE(large, sizeof(float) << 20);
    float* const first = Scratch::of<float>(1 << 10, kRoom).data();
    EXPECT_EQ(Scratch::of<double>(1 << 9, kRoom).data(), static_cast<void*>(first)) << "one room for all";
    EXPECT_NE(Scratch::of<float>(1 << 9, Scratch::Room::rims).data(), first);
    const size_t both = Scratch::kept();
    for (int i = 0; i < 200; ++i) (void)Scratch::of<float>(1 << 10, kRoom);
    EXPECT_EQ(Scratch::kept(), both) << "between a stroke's stamps";
    (void)Scratch::of<float>(1 << 20, kRoom);
    for (int i = 0; i < 1000; ++i) (void)Scratch::of<float>(1 << 10, kRoom);
    EXPECT_LT(Scratch::kept(), size_t(1) << 14);
  })
      .join();
}

// Bounds all along regions of 64 voxels: solved region by region they come out as if all had been solved together.
TEST(Redistance, ByRegionLeavesNoSeams) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0.1, 0.2, 0.05), {100, 100, 40}, 0);
  BrushStroke stroke(block, Brush::of(Method::carve));
  for (int i = 0; i < 12; ++i) stroke.apply({{-90.0 + 15 * i, -5.0 + i, 40}, {-85.0 + 15 * i, 5.0 - i, 40}, 9});
  const Version cut = stroke.publish();
  const std::vector<Coord> all = allBricks(cut);
  Editor together(cut), threads(cut), byRegion(cut);
  EXPECT_GT(redistance(together, all).size(), 100u);
  redistance(threads, all, {}, 3);
  redistanceByRegion(byRegion, all);
  const uint64_t expected = together.commit().hash();
  EXPECT_EQ(threads.commit().hash(), expected);
  EXPECT_EQ(byRegion.commit().hash(), expected);
  // A job that is cancelled gives all back.
  Job job;
  job.cancel();
  Editor cancelled(cut);
  EXPECT_THROW(redistanceByRegion(cancelled, all, &job), Cancelled);
  EXPECT_EQ(cancelled.commit(), cut);
}

}  // namespace
}  // namespace argil::clay
