// What swept tips promise.

#include <gtest/gtest.h>

#include <random>

#include "clay/brush/brush.h"
#include "clay/brush/stamp_shape.h"
#include "clay/brush/swept_tip.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "tests/support/tier.h"

namespace argil::clay {
namespace {

Eigen::Matrix3f turned() {
  return Eigen::AngleAxisf(0.8f, Vec3f(1, -2, 0.5f).normalized()).toRotationMatrix();
}

// Signed distance to a rounded box or an ellipsoid by fine search; in the tip's axes.
double boxDistance(const Vec3d& p, const Vec3d& half, double round) {
  const Vec3d q = p.cwiseAbs() - (half - Vec3d::Constant(round));
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
}
double ellipsoidLevel(const Vec3d& p, const Vec3d& half) {
  return p.cwiseQuotient(half).norm() - 1;
}

struct Case {
  Tip tip;
  Vec3f proportions;
  Vec3d way;
};

TEST(SweptTip, IsTheUnionOfItsPlacesAndADistanceNearItsSurface) {
  for (const Case& c :
       {Case{Tip::ellipsoid, {1, 0.6f, 0.3f}, {5, 2, -3}}, Case{Tip::ellipsoid, {0.3f, 1, 0.5f}, {0, 0, 0}},
        Case{Tip::box, {1, 0.5f, 0.3f}, {4, -3, 2}}, Case{Tip::box, {0.6f, 0.6f, 1}, {0, 0, 0}}}) {
    Brush brush = *Brush::of(Method::carve);
    brush.tip = c.tip;
    brush.proportions = c.proportions;
    brush.round = 0.4f;
    Stamp stamp{{1.25, -0.5, 2}, Vec3d(1.25, -0.5, 2) + c.way, 20, 1};
    stamp.axes = turned();
    const Vec3d half = 20 * c.proportions.cast<double>();
    const Eigen::Matrix3d axes = stamp.axes.cast<double>();
    double worstSlope = 0, worst = 0;
    int near = 0, wrong = 0;
    for (int bx = -3; bx <= 3; ++bx)
      for (int by = -3; by <= 3; ++by)
        for (int bz = -3; bz <= 3; ++bz) {
          float d[kBrickVoxels];
          tipDistances(brush, stamp, {bx, by, bz}, d);
          for (int i = 0; i < kBrickVoxels; ++i) {
            const Vec3d p = (Coord{bx, by, bz} * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
            double expected = 1e9;
            for (int k = 0; k <= 32; ++k) {
              const Vec3d y = axes.transpose() * (p - stamp.a - (stamp.b - stamp.a) * k / 32.0);
              expected = std::min(
                  expected, c.tip == Tip::box ? boxDistance(y, half, 0.4 * half.minCoeff()) : ellipsoidLevel(y, half));
            }
            // The sign is that of the union.
            if (std::abs(expected) > 0.01) wrong += (d[i] < 0) != (expected < 0);
            if (c.tip == Tip::box && expected > 0 && expected < 3) worst = std::max(worst, std::abs(d[i] - expected));
            const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
            if (std::abs(d[i]) > 1 || x < 1 || y < 1 || z < 1 || x > 6 || y > 6 || z > 6) continue;
            // Where the second differences say that the surface is smooth, the slope is 1.
            double slope2 = 0, bend = 0;
            for (const int step : {64, 8, 1}) {
              slope2 += 0.25 * (d[i + step] - d[i - step]) * (d[i + step] - d[i - step]);
              bend = std::max<double>(bend, std::abs(d[i + step] + d[i - step] - 2 * d[i]));
            }
            if (bend > 0.04) continue;
            ++near;
            worstSlope = std::max(worstSlope, std::abs(std::sqrt(slope2) - 1));
          }
        }
    EXPECT_EQ(wrong, 0);
    EXPECT_LT(worst, 0.02);
    EXPECT_GT(near, 100);
    EXPECT_LT(worstSlope, 0.02);
    std::printf("tip %d: %d voxels near its surface, slope within %.4f of 1, distance within %.4f\n",
                static_cast<int>(c.tip), near, worstSlope, worst);
  }
}

TEST(SweptTip, CarvesAndAddsWhereNoSurfaceIsNear) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 40);
  for (const Tip tip : {Tip::box, Tip::ellipsoid}) {
    auto brush = std::make_shared<Brush>(*Brush::of(Method::carve));
    brush->tip = tip;
    BrushStroke stroke(base, brush);
    stroke.apply({{0, 0, 0}, {0, 0, 0}, 30});
    const Version after = stroke.finish();
    Sampler field(after);
    EXPECT_GT(field.voxel({0, 0, 0}), 2.9f);
    EXPECT_NEAR(field.trilinear(Vec3d(29, 0, 0)), 1, 0.01);
    EXPECT_NEAR(field.trilinear(Vec3d(31, 0, 0)), -1, 0.01);
  }
}

TEST(StampShape, OfABallIsABallAtAnySize) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d(3, 4, 5), 20);
  const auto shape = StampShape::of(ball);
  for (const double radius : {6.0, 25.0, tests::byTier(40.0, 60.0)}) {
    auto brush = std::make_shared<Brush>(*Brush::of(Method::add));
    brush->tip = Tip::shape;
    brush->shape = shape;
    BrushStroke stroke(Version::empty(ball.store(), Grid{}), brush);
    Stamp stamp{{0.3, 0.1, -0.2}, {0.3, 0.1, -0.2}, radius, 1};
    stamp.axes = turned();
    stroke.apply(stamp);
    const Version after = stroke.finish();
    double worst = 0;
    after.forEachBrick([&](const Brick& brick) {
      for (int i = 0; i < kBrickVoxels; ++i) {
        const double expected =
            ((brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d() - stamp.a).norm() - radius;
        if (std::abs(expected) < 1) worst = std::max(worst, std::abs(brick.phi(i) - expected));
      }
    });
    std::printf("a ball of %.0f voxels from samples: within %.3f voxel\n", radius, worst);
    EXPECT_LT(worst, radius < 10 ? 0.1 : 0.05 + radius / 1000);
    EXPECT_GT(after.stats().bricks, 10u);
  }
}

// Where there was no clay to run into, wax is clay that is laid on; it looks at as many bricks.
TEST(Wax, CostsItsSurfaceAndRunsIntoTheClayAlone) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 100);
  uint64_t touched[2];
  Version after[2];
  for (const Method method : {Method::add, Method::wax}) {
    auto brush = std::make_shared<Brush>(*Brush::of(method));
    brush->blend = 3;
    BrushStroke stroke(base, brush);
    for (int i = 0; i < 4; ++i) stroke.apply({{200, 10.0 * i, 0}, {200, 10.0 * (i + 1), 0}, 100});
    touched[method == Method::wax] = stroke.touched();
    after[method == Method::wax] = stroke.finish();
  }
  std::printf("bricks looked at: add %llu, wax %llu\n", static_cast<unsigned long long>(touched[0]),
              static_cast<unsigned long long>(touched[1]));
  EXPECT_LE(touched[1], touched[0] * 11 / 10);
  // The tip is a ball of 100 about (200, 0..40, 0): far from the ball of clay both are the same, in the valley between
  // them wax stands higher.
  Sampler add(after[0]), wax(after[1]);
  EXPECT_NEAR(wax.trilinear(Vec3d(300, 20, 0)), 0, 0.01);
  EXPECT_NEAR(add.trilinear(Vec3d(300, 20, 0)), 0, 0.01);
  int lower = 0, higher = 0;
  after[0].forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; i += 7) {
      const Coord at = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      if (std::abs(brick.phi(i)) > 1) continue;
      const float more = brick.phi(i) - wax.voxel(at);
      lower += more < -0.15f;
      higher += more > 0.3f;
    }
  });
  EXPECT_EQ(lower, 0);
  EXPECT_GT(higher, 200);
}

// Distance of a place from all that a stroke swept, as the kernels say it of one segment.
double sweptDistance(const std::vector<Stamp>& stamps, const Vec3d& p) {
  double least = HUGE_VAL;
  for (const Stamp& s : stamps) {
    const Vec3d d = s.b - s.a;
    const double t = d.squaredNorm() > 0 ? std::clamp((p - s.a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
    least = std::min(least, (p - s.a - t * d).norm() - (s.radius + t * (s.radiusAtEnd() - s.radius)));
  }
  return least;
}

// A stroke as hands make them: most stamps go on from where the last one ended, some jump, rest, turn back or change
// their size, between two or on the way.
std::vector<Stamp> wandering(uint32_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1), part(0, 1);
  std::vector<Stamp> stamps;
  Vec3d at(u(random), u(random), u(random));
  double radius = 6 + 10 * part(random);
  for (int i = 0; i < 8; ++i) {
    if (part(random) < 0.15) at += 20 * Vec3d(u(random), u(random), u(random));
    if (part(random) < 0.25) radius = 6 + 10 * part(random);
    Stamp stamp{at, at + 12 * Vec3d(u(random), u(random), u(random)), radius, 1};
    if (part(random) < 0.15) stamp.b = stamp.a;
    if (part(random) < 0.3) stamp.endRadius = radius = 6 + 10 * part(random);
    at = stamp.b;
    stamps.push_back(stamp);
  }
  return stamps;
}

TEST(Sweep, AStrokeThatWandersIsAllThatItsTipSwept) {
  int goesOn = 0, all = 0;
  for (uint32_t seed = 0; seed < tests::byTier(12u, 400u); ++seed) {
    const std::vector<Stamp> stamps = wandering(seed);
    for (const Method method : {Method::add, Method::carve}) {
      const bool carves = method == Method::carve;
      auto store = Store::make();
      const Version base =
          carves ? makeBlock(store, Grid{}, Vec3d::Zero(), {90, 90, 90}, 0) : Version::empty(std::move(store), Grid{});
      auto brush = std::make_shared<Brush>(*Brush::of(method));
      BrushStroke stroke(base, brush);
      for (const Stamp& each : stamps) stroke.apply(each);
      const Version after = stroke.finish();
      int wrong = 0;
      after.forEachBrick([&](const Brick& brick) {
        for (int i = 0; i < kBrickVoxels; ++i) {
          const Vec3d p = (brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
          const double expected = (carves ? -1 : 1) * sweptDistance(stamps, p);
          if (p.cwiseAbs().maxCoeff() > 80 || std::abs(expected) > 2.5) continue;
          wrong += std::abs(expected) > 0.2 && (brick.phi(i) < 0) != (expected < 0);
        }
      });
      EXPECT_EQ(wrong, 0) << "seed " << seed << (carves ? " carve" : " add");
      ++all;
    }
    for (size_t i = 1; i < stamps.size(); ++i) goesOn += stamps[i].a == stamps[i - 1].b;
  }
  std::printf("%d strokes; %d stamps went on from the last\n", all, goesOn);
}

// Another tip than the ball may have turned since: where it goes on it cuts behind as well.
TEST(Sweep, ABoxThatTurnsWhereItStandsCutsWhatItTurnsInto) {
  const Version base = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {60, 60, 60}, 0);
  auto brush = std::make_shared<Brush>(*Brush::of(Method::carve));
  brush->tip = Tip::box;
  BrushStroke stroke(base, brush);
  Stamp stamp{{0, 0, 0}, {0, 0, 0}, 10, 1};
  stroke.apply(stamp);
  stamp.axes = Eigen::AngleAxisf(float(M_PI / 4), Vec3f::UnitZ()).toRotationMatrix();
  stroke.apply(stamp);
  const Version after = stroke.finish();
  Sampler field(after);
  EXPECT_GT(field.trilinear(Vec3d(8, 8, 0)), 0.5f);   // a corner of the first
  EXPECT_GT(field.trilinear(Vec3d(12, 0, 0)), 0.5f);  // of the second
  EXPECT_LT(field.trilinear(Vec3d(13, 13, 0)), -0.5f);
}

// What a mask covers in part is taken by shares, each time again.
TEST(Sweep, WhatIsMaskedInPartIsSweptAgain) {
  Version clay = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {30, 30, 30}, 0);  // its top at z = 30 voxels
  Brush half;
  half.operations = {{.property = Property::mask, .method = Method::set, .amount = 0.5f}};
  BrushStroke masking(clay, std::make_shared<const Brush>(half));
  masking.apply({{0, 0, 30}, {0, 0, 30}, 20});
  clay = masking.finish();
  double cut[2];
  for (const int dabs : {1, 2}) {
    BrushStroke stroke(clay, Brush::of(Method::carve));
    for (int i = 0; i < dabs; ++i) stroke.apply({{0, 0, 34}, {0, 0, 34}, 6});
    const Version after = stroke.finish();
    Sampler field(after);
    double z = 20;
    while (field.trilinear(Vec3d(0, 0, z)) < 0) z += 0.01;
    cut[dabs - 1] = 30 - z;
  }
  std::printf("cut by one dab %.2f, by two %.2f voxels\n", cut[0], cut[1]);
  EXPECT_GT(cut[0], 0.2);
  EXPECT_GT(cut[1], cut[0] + 0.1);
}

// The formula of a tip that grows fast on its way is no distance; its slope here is 1.22. New clay of it is redistanced
// from what it says within a voxel of the surface, which stays.
TEST(Sweep, ClayOfATipThatGrowsFastIsRedistanced) {
  BrushStroke stroke(Version::empty(Store::make(), Grid{}), Brush::of(Method::add));
  Stamp stamp{{0, 0, 0}, {20, 0, 0}, 6, 1};
  stamp.endRadius = 20;
  stroke.apply(stamp);
  const Version after = stroke.finish();
  Sampler field(after);
  double steepest = 0;
  int places = 0;
  after.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (std::abs(brick.phi(i)) < 1.5f || std::abs(brick.phi(i)) > 2) continue;
      Vec3f slope;
      const Coord at = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      if (at.x < 2 || at.x > 16) continue;  // on its way, away from both ends
      static_cast<void>(field.trilinear(at.toVec3d() + Vec3d::Constant(0.5), slope));
      steepest = std::max(steepest, double(slope.norm()));
      ++places;
    }
  });
  std::printf("steepest slope %.3f at %d places\n", steepest, places);
  EXPECT_GT(places, 500);
  EXPECT_LT(steepest, 1.15);
}

TEST(Sweep, WhatLiesBehindATipThatGoesOnIsNotLookedAtAgain) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 60);
  for (const Method method : {Method::carve, Method::add, Method::wax}) {
    uint64_t touched[2];
    for (const bool backwards : {false, true}) {
      auto brush = std::make_shared<Brush>(*Brush::of(method));
      brush->blend = method == Method::wax ? 3 : 0;
      BrushStroke stroke(base, brush);
      for (int i = 0; i < 8; ++i) {
        Stamp stamp{{125, 8.0 * i, 0}, {125, 8.0 * (i + 1), 0}, 40, 1};
        if (backwards) std::swap(stamp.a, stamp.b);  // the same tip, but it begins where nothing ended
        stroke.apply(stamp);
      }
      touched[backwards] = stroke.touched();
      (void)stroke.finish();
    }
    std::printf("method %d: bricks of 8 stamps %llu, each by itself %llu\n", static_cast<int>(method),
                static_cast<unsigned long long>(touched[0]), static_cast<unsigned long long>(touched[1]));
    EXPECT_LT(touched[0], touched[1] * 4 / 5);
  }
}

}  // namespace
}  // namespace argil::clay
