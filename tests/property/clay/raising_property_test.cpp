// Raising: a layer is as thick as it was asked for, everywhere and however often the tool passes.

#include <random>

#include "clay/field/primitives.h"
#include "clay/import/height_image.h"
#include "clay/store/store.h"
#include "tests/property/clay/brush_checks.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

using namespace testing;

std::shared_ptr<const Brush> raising(float height, bool limited, Falloff shape = Falloff::smooth) {
  auto brush = std::make_shared<Brush>(*Brush::of(Method::raise, height < 0 ? -1.0f : 1.0f));
  brush->operations[0].shape = shape;
  brush->height = std::abs(height);
  brush->limited = limited;
  return brush;
}

TEST(Raise, LayerNeverExceedsItsHeightAndReachesIt) {
  const double radius = 40;
  const Vec3d centre(0.22, 0.14, 0.1);
  const Version base = makeSphere(Store::make(), Grid{}, centre / 2, radius / 2);
  for (const float height : {3.0f, 12.0f, 20.0f})
    for (const Falloff shape : {Falloff::smooth, Falloff::constant}) {
      const Version after = apply(base, raising(height, true, shape), arc(radius, 0, 1.2, 16), 2);
      double top = 0, sum = 0;
      int count = 0;
      for (const Vec3d& p : closedSurface(after)) {
        const double rise = (p - centre).norm() - radius, angle = std::atan2(p.y(), p.x());
        top = std::max(top, rise);
        if (angle < 0.2 || angle > 1 || std::abs(p.z()) > 4) continue;
        sum += std::abs(rise - height);
        ++count;
      }
      EXPECT_LE(top, height + 0.02) << height;
      EXPECT_LE(sum / count, 0.02) << height;
      const FieldErrors errors = fieldErrors(after);
      EXPECT_LE(errors.rms, 0.05) << height;
      EXPECT_LE(errors.worst, 0.25) << height;
    }
}

// The profile across a bead is that of the falloff, however often the stroke passes.
TEST(Raise, ABeadHasTheProfileOfItsFalloff) {
  for (const float amount : {1.0f, -1.0f}) {
    Brush brush = *Brush::of(Method::raise, amount);
    brush.height = 4;
    brush.limited = brush.bead = true;
    const double radius = 12;
    const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -20), {80, 60, 40}, 1);
    std::vector<Stamp> way = line({-20, 0, 0}, {20, 0, 0}, radius);
    const std::vector<Stamp> back(way.rbegin(), way.rend());
    way.insert(way.end(), back.begin(), back.end());
    Sampler sampler(apply(block, std::make_shared<const Brush>(brush), way));
    for (double y = -14; y <= 14; y += 0.5) {
      const double t2 = std::min(y * y / (radius * radius), 1.0), right = amount * 4 * (1 - t2) * (1 - t2);
      double z = right - 2;
      while (sampler.trilinear(Vec3d(0, y, z)) < 0) z += 0.005;
      EXPECT_NEAR(z, right, 0.08) << "amount " << amount << ", " << y << " beside the stroke";
    }
  }
}

TEST(Raise, LayerOverTheEdgesOfABlockAndIntoThem) {
  const Version base = makeBlock(Store::make(), Grid{}, Vec3d(0.1, 0.05, 0.15), {40, 30, 20}, 2);
  const Vec3d half = Vec3d(40, 30, 20) - Vec3d::Constant(4);
  const auto distance = [&](const Vec3d& p) {
    const Vec3d q = (p - Vec3d(0.2, 0.1, 0.3)).cwiseAbs() - half;
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0) - 4;
  };
  // Where the surface is sharp or tightly round its vertices lie beside the zero of the field by up to 0.3 voxels.
  for (const float height : {6.0f, -6.0f}) {
    const Version after = apply(base, raising(height, true), line({20, 0, 20}, {40, 30, 20}, 14), 2);
    double most = 0, flat = 0;
    for (const Vec3d& p : closedSurface(after)) {
      const double rise = distance(p) * (height < 0 ? -1 : 1);
      most = std::max(most, rise);
      EXPECT_GT(rise, -0.1);
      if (std::abs(p.x()) < 28 && std::abs(p.y()) < 18) flat = std::max(flat, rise);
    }
    EXPECT_NEAR(flat, 6, 0.02) << height;
    EXPECT_LE(most, height < 0 ? 6.4 : 6.04) << height;
  }
}

// How far the surface lies from a place along a direction out of the clay; below zero: under it.
double topAlong(const Version& clay, const Vec3d& from, const Vec3d& out) {
  Sampler sampler(clay);
  double at = -30;
  while (sampler.trilinear(Vec3d(from + out * at)) < 0) at += 0.01;
  return at;
}

// A pass of the smooth falloff is a height, also over what the passes before have laid or taken, by a tool that stays
// where the surface was. On a ball what it lays is spread over more.
TEST(Raise, UnlimitedPassesAddUp) {
  const double radius = 60;
  for (const float height : {5.0f, -5.0f})
    for (const double tip : {12.0, 24.0})
      for (const int passes : {1, 2, 3}) {
        SCOPED_TRACE(::testing::Message() << height << ' ' << tip << ' ' << passes);
        const double laid = passes * static_cast<double>(height), most = 0.02 * std::abs(laid);
        const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -20), {60, 60, 40}, 4);
        const Version flat = apply(block, raising(height, false), line({-40, 3.3, 0}, {40, 3.3, 0}, tip), passes);
        EXPECT_NEAR(topAlong(flat, {0.2, 3.3, 0}, {0, 0, 1}), laid, most);
        const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), radius / 2);
        const Version after = apply(base, raising(height, false), arc(radius, 0, 1.2, tip), passes);
        const Vec3d out(std::cos(0.6), std::sin(0.6), 0);
        // A wide tip over a deep groove meets its walls.
        if (laid > -10) {
          EXPECT_NEAR(topAlong(after, out * radius, out), radius * (std::sqrt(1 + 2 * laid / radius) - 1), most);
        }
        for (const Version& each : {flat, after}) {
          const FieldErrors errors = fieldErrors(each);
          EXPECT_LE(errors.rms, 0.015);
          EXPECT_LE(errors.worst, 0.08);
        }
      }
}

// All over, whatever a stamp does of it and however little is spent on redistancing: nothing of the grid's axes is left
// in it.
TEST(Raise, ABallStaysABall) {
  Quality little;
  little.passes = 1;
  little.drift = 2;
  little.trail = 32;
  little.tolerance = 1;
  for (const float height : {11.0f, -18.0f, 25.0f})
    for (const Quality& quality : {Quality(), little}) {
      SCOPED_TRACE(::testing::Message() << height << (quality.passes == 0 ? "" : ", little"));
      const double radius = height > 0 ? 30 : 50;
      const Vec3d centre(0.1, 0.2, 0.3);
      const Version base = makeSphere(Store::make(), Grid{}, centre / 2, radius / 2);
      auto brush = std::make_shared<Brush>(*raising(height, false, Falloff::constant));
      brush->quality = quality;
      BrushStroke stroke(base, brush);
      double expected = radius;
      for (; std::abs(expected - radius) < 20; expected += static_cast<double>(height) * 3 / 35)
        stroke.apply({centre, centre, 400, 1});
      double sum = 0, squares = 0;
      const std::vector<Vec3d> places = closedSurface(stroke.finish());
      for (const Vec3d& each : places) {
        const double off = (each - centre).norm() - expected;
        sum += off;
        squares += off * off;
      }
      const double most = quality.passes == 0 ? 0.02 : 0.05;
      EXPECT_LE(std::abs(sum), most * double(places.size()));
      EXPECT_LE(squares, std::pow(most, 2) * double(places.size()));
    }
}

// What one stamp lays may be more than the band: it is laid in parts, on all of its way.
TEST(Raise, AStampOfManyVoxels) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -10), {60, 60, 20}, 4);
  for (const float height : {10.0f, 18.0f, 30.0f, 90.0f})
    for (const bool dab : {true, false}) {
      SCOPED_TRACE(::testing::Message() << height << (dab ? " dab" : ""));
      const Stamp stamp{Vec3d(-8, 1, 0), Vec3d(dab ? -8 : 8, 1, 0), 20, 1};
      const auto brush = raising(height, false);
      BrushStroke stroke(block, brush), twice(block, brush);
      stroke.apply(stamp);
      twice.apply(std::vector{stamp, stamp});
      const Version after = stroke.finish();
      EXPECT_EQ(twice.finish().hash(), after.hash()) << "images that lie on each other are one";
      const double rise = static_cast<double>(height) * 3 / 35;
      // Where it rises much it leans over.
      const double most = rise < 2 ? 0.02 : 0.05 * rise;
      for (double x = -32; x <= 32; x += 0.5) {
        const double t = std::min(std::abs(x - std::clamp(x, -8.0, dab ? -8.0 : 8.0)) / 20, 1.0);
        EXPECT_NEAR(topAlong(after, {x, 1, 0}, {0, 0, 1}), rise * (1 - t * t) * (1 - t * t), t == 0 ? 0.02 : most) << x;
      }
      closedSurface(after);
    }
}

// Deeper than what the stroke has laid, or than two radii, a tool stands where it stands.
TEST(Raise, AToolThatTheStrokeHasNotBuriedIsNotLifted) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -30), {60, 60, 60}, 4);
  const float height = 5;
  const double step = static_cast<double>(height) * 3 / 35, tip = 20, depth = 8;
  // After a stamp aside, and after many: by its distance from the surface, and as one that stands on it.
  for (const int before : {1, 30}) {
    std::vector<Stamp> stamps(static_cast<size_t>(before), Stamp{Vec3d(35, 0, 0), Vec3d(35, 0, 0), 12, 1});
    stamps.push_back({Vec3d(-20, 0, -depth), Vec3d(-20, 0, -depth), tip, 1});
    const double t = before == 1 ? depth / tip : 0;
    EXPECT_NEAR(topAlong(apply(block, raising(height, false), stamps), {-20, 0, 0}, {0, 0, 1}),
                step * (1 - t * t) * (1 - t * t), 0.03)
        << before;
  }
  std::vector<Stamp> stamps(60, Stamp{Vec3d(35, 0, 0), Vec3d(35, 0, 0), 12, 1});
  stamps.push_back({Vec3d(-20, 0, -24), Vec3d(-20, 0, -24), tip / 2, 1});
  EXPECT_LT(topAlong(apply(block, raising(height, false), stamps), {-20, 0, 0}, {0, 0, 1}), 0.02);
}

// A plate thinner than the band, both faces within reach: thicker on both sides, whole.
TEST(Raise, ThinPlateIsNotTorn) {
  const Version base = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {40, 40, 1.6}, 0.5);
  const Version after = apply(base, raising(3, true), line({-20, 3, 1.6}, {20, 3, 1.6}, 12), 2);
  Surface surface(false);
  surface.update(after);
  const TopologyReport report = checkTopology(surface.toMesh());
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.bodies, 1u);
  for (const Vec3d& p : closedSurface(after)) EXPECT_LE(std::abs(p.z()), 1.6 + 3.02);
  Sampler sampler(after);
  EXPECT_NEAR(sampler.trilinear(Vec3d(0, 3, 4.6)), 0, 0.02);
  EXPECT_NEAR(sampler.trilinear(Vec3d(0, 3, -4.6)), 0, 0.02);
}

TEST(Raise, EmbossStandsAsHighAsItsImageIsBright) {
  const Version base = makeBlock(Store::make(), Grid{}, Vec3d(0, 0, -10), {60, 60, 20}, 1);
  std::vector<uint8_t> grey(64 * 64);
  for (int y = 0; y < 64; ++y)
    // brighter to the right
    for (int x = 0; x < 64; ++x) grey[static_cast<size_t>(y * 64 + x)] = static_cast<uint8_t>(x * 4);
  auto brush = std::make_shared<Brush>(*raising(8, false, Falloff::constant));
  brush->image = std::make_shared<const HeightImage>(64, 64, grey);
  Stamp stamp{{0, 0, 0}, {0, 0, 0}, 24};
  stamp.axes.col(0) = Vec3f(0.6f, 0.8f, 0);
  stamp.axes.col(1) = Vec3f(-0.8f, 0.6f, 0);
  const Version after = apply(base, brush, {stamp});
  closedSurface(after);
  Sampler sampler(after);
  for (const double x : {-12.0, -3.0, 5.0, 14.0})
    for (const double y : {-10.0, 0.0, 9.0}) {
      const double expected = 8 * ((x / 24 + 1) * 32 - 0.5) * 4 / 255;
      EXPECT_NEAR(sampler.trilinear(Vec3d(0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y, expected)), 0, 0.05) << x << ' ' << y;
    }
}

TEST(Raise, MirroredStampsLeaveMirroredBits) {
  // symmetric about x = -0.5 voxels
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(-0.25, 0.3, 0.1), 15);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const bool limited : {false, true}) {
    BrushStroke stroke(base, raising(limited ? 5.0f : -4.0f, limited));
    for (int i = 0; i < 12; ++i) {
      const Vec3d a = Vec3d(0.5 + 0.5 * u(random), u(random), 0.3).normalized() * 30;
      Stamp stamp{a, a + Vec3d(u(random), u(random), u(random)), 9, 0.9f};
      Stamp image = stamp;
      image.a.x() = -1 - stamp.a.x();
      image.b.x() = -1 - stamp.b.x();
      stroke.apply(std::vector{stamp, image});
    }
    const Version after = stroke.finish();
    uint64_t bricks = 0;
    after.forEachBrick([&](const Brick& brick) {
      const Slot other = after.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
      ASSERT_FALSE(other.isTile());
      for (int i = 0; i < kBrickVoxels; ++i)
        ASSERT_EQ(brick.phi(i), other.brick()->phi(i ^ 0x1c0))
            << brick.coord.x << ' ' << brick.coord.y << ' ' << brick.coord.z;
      ++bricks;
    });
    EXPECT_NE(after.hash(), base.hash());
  }
}

TEST(Raise, EqualBitsOnEverySimdTarget) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(0.1, 0.2, 0), 15);
  const auto stamps = arc(30, 0, 0.8, 8);
  for (const bool limited : {true, false}) {
    const uint64_t reference = apply(base, raising(5, limited, Falloff::dome), stamps).hash();
    tests::forEachSimdTarget([&](const std::string& name) {
      EXPECT_EQ(apply(base, raising(5, limited, Falloff::dome), stamps).hash(), reference) << name;
    });
  }
}

// Strokes back and forth over the same place, on the surface that is there: every part of one costs what the first did.
TEST(Raise, AStrokeCostsTheSameHoweverLongItLasts) {
  struct Case {
    float height;
    bool limited;
  };
  for (const Case& c : {Case{2.5f, false}, Case{-2.5f, false}, Case{6, false}, Case{2.5f, true}}) {
    const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 30);
    BrushStroke stroke(base, raising(c.height, c.limited));
    Version shown = base;
    const auto onSurface = [&](double angle, double z) {
      const Vec3d out = Vec3d(std::cos(angle), std::sin(angle), z).normalized();
      Sampler sampler(shown);
      double at = 140;
      while (at > 10 && sampler.trilinear(out * at) > 0) at -= 0.25;
      return Vec3d(out * at);
    };
    constexpr int kStrokes = 24, kStamps = 30;
    uint64_t touched[4] = {}, made[4] = {};
    for (int n = 0; n < kStrokes; ++n) {
      const uint64_t before = stroke.touched(), bricksBefore = stroke.counts().bricksMade;
      for (int i = 0; i < kStamps; ++i) {
        const double from = 0.5 * (n % 2 ? kStamps - i : i) / kStamps, z = 0.02 * (n % 5);
        stroke.apply({onSurface(from, z), onSurface(from + (n % 2 ? -0.5 : 0.5) / kStamps, z), 10, 1});
        if (i % 5 == 0) shown = stroke.publish();
      }
      touched[n * 4 / kStrokes] += stroke.touched() - before;
      made[n * 4 / kStrokes] += stroke.counts().bricksMade - bricksBefore;
    }
    const Version after = stroke.finish();
    std::printf("height %g%s: bricks touched in each quarter %llu %llu %llu %llu, made %llu %llu %llu %llu\n",
                double(c.height), c.limited ? ", limited" : "", static_cast<unsigned long long>(touched[0]),
                static_cast<unsigned long long>(touched[1]), static_cast<unsigned long long>(touched[2]),
                static_cast<unsigned long long>(touched[3]), static_cast<unsigned long long>(made[0]),
                static_cast<unsigned long long>(made[1]), static_cast<unsigned long long>(made[2]),
                static_cast<unsigned long long>(made[3]));
    // A tower has more surface within reach of the tip than a ball.
    EXPECT_LE(touched[3], 2 * touched[0]) << c.height;
    EXPECT_LE(touched[3], touched[2] * 5 / 4) << c.height;
    EXPECT_LE(made[3], 2 * made[0] + 100) << c.height;
    EXPECT_NE(after.hash(), base.hash());
    // Swollen and whole, not torn.
    Surface surface(false);
    surface.update(after);
    const TopologyReport report = checkTopology(surface.toMesh());
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.bodies, 1u) << c.height;
    const FieldErrors errors = fieldErrors(after);
    EXPECT_LE(errors.rms, 0.05) << c.height;
    EXPECT_LE(errors.worst, 0.25) << c.height;
  }
}

// The same stroke with a tool that is lifted on the way: what it laid stays, and a limit still holds.
TEST(Raise, AToolThatWasLiftedTakesNothingBack) {
  for (const bool limited : {false, true}) {
    const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 30);
    const Version lifted = apply(base, raising(4, limited), arc(60, 0, 0.6, 12));
    BrushStroke stroke(lifted, raising(4, limited), base);
    for (Stamp each : arc(60, 0, 0.3, 12)) {
      each.strength = 0.02f;
      stroke.apply(each);
    }
    const Version after = stroke.finish();
    Sampler was(lifted), is(after);
    for (double angle = 0; angle <= 0.6; angle += 0.05) {
      const Vec3d out(std::cos(angle), std::sin(angle), 0);
      double at = 60;
      while (was.trilinear(out * at) < 0) at += 0.01;
      EXPECT_LT(is.trilinear(out * at), 0.05) << angle << (limited ? " limited" : "");
      EXPECT_GT(is.trilinear(out * at), -0.5) << angle << (limited ? " limited" : "");
    }
  }
}

TEST(Raise, MirroredStrokesLeaveMirroredBitsOnAnyCountOfThreads) {
  // symmetric about x = -0.5 voxels
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(-0.25, 0.3, 0.1), 15);
  std::vector<uint64_t> hashes;
  for (const int threads : {1, 3})
    for (const int publishEvery : {1000, 7}) {
      BrushStroke stroke(base, raising(5, false), {}, threads);
      for (int i = 0; i < 60; ++i) {
        const Vec3d a = Vec3d(0.4 + 0.1 * std::sin(i), 0.1 * std::cos(3 * i), 0.6).normalized() * (30 + 0.2 * i);
        Stamp stamp{a, a + Vec3d(0.5, 0.25, 0), 14, 1};
        Stamp image = stamp;
        image.a.x() = -1 - stamp.a.x();
        image.b.x() = -1 - stamp.b.x();
        stroke.apply(std::vector{stamp, image});
        if (i % publishEvery == 0) (void)stroke.publish();
      }
      const Version after = stroke.finish();
      hashes.push_back(after.hash());
      after.forEachBrick([&](const Brick& brick) {
        const Slot other = after.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
        ASSERT_FALSE(other.isTile());
        for (int i = 0; i < kBrickVoxels; ++i)
          ASSERT_EQ(brick.phi(i), other.brick()->phi(i ^ 0x1c0))
              << brick.coord.x << ' ' << brick.coord.y << ' ' << brick.coord.z;
      });
    }
  for (const uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

}  // namespace
}  // namespace argil::clay
