// Maps of space, lattices, and what deform() refuses.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <thread>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/cut.h"
#include "clay/whole/deform.h"
#include "clay/whole/lattice.h"
#include "tests/unit/clay/clay_checks.h"

namespace argil::clay {
namespace {

const BoxMm kBox{Vec3d(-10, -12, -14), Vec3d(10, 12, 14)};

TEST(Warp, SineAndCosineAreThoseOfTheLibrary) {
  for (double angle = -130; angle < 130; angle += 0.0173) {
    const Turn turn = turnBy(angle);
    ASSERT_NEAR(turn.sine, std::sin(angle), 4e-15);
    ASSERT_NEAR(turn.cosine, std::cos(angle), 4e-15);
  }
}

TEST(Warp, DerivativesAreThoseOfTheMap) {
  const uint64_t seed = 3;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  const WarpAxis axis{Vec3d(1, 2, 3), Vec3d(1, 0.5, 2), -4, 6};
  Lattice lattice(kBox, {4, 3, 5}), inner(kBox, {5, 5, 5});
  for (size_t i = 0; i < lattice.points().size(); ++i)
    lattice.setPoint(i, lattice.restPoint(i) + Vec3d(u(random), u(random), u(random)));
  inner.setPoint(inner.index(2, 2, 2), Vec3d(3, 1, 2));
  const Twist twist(axis, 2);
  const Taper taper(axis, 0.4);
  const Bend bend(axis, Vec3d(0, 1, 1), 1.5), straight(axis, Vec3d(0, 1, 1), 1e-9);
  for (const Warp* warp : std::initializer_list<const Warp*>{&lattice, &inner, &twist, &taper, &bend, &straight}) {
    for (int i = 0; i < 300; ++i) {
      const Vec3d p = 11 * Vec3d(u(random), u(random), u(random));
      const double along = (p - axis.originMm).dot(axis.direction.normalized());
      // Creases of the maps.
      if (std::abs(along - axis.fromMm) < 1e-3 || std::abs(along - axis.toMm) < 1e-3 ||
          std::abs(std::abs(p.x()) - 10) < 1e-3)
        continue;
      Eigen::Matrix3d j, unused;
      (void)warp->map(p, j);
      for (int k = 0; k < 3; ++k) {
        const Vec3d h = 1e-5 * Vec3d::Unit(k);
        const Vec3d slope = (warp->map(p + h, unused) - warp->map(p - h, unused)) / 2e-5;
        ASSERT_LE((slope - j.col(k)).norm(), 1e-7) << "seed " << seed;
      }
    }
  }
}

TEST(Warp, ABendKeepsTheLengthOfItsAxisAndWhatLiesBeforeIt) {
  const Bend bend({Vec3d::Zero(), Vec3d::UnitZ(), 0, 10}, Vec3d::UnitX(), 1.57079632679);
  Eigen::Matrix3d j;
  EXPECT_LE((bend.map({0, 0, 10}, j) - Vec3d(20 / 3.14159265359, 0, 20 / 3.14159265359)).norm(), 1e-9);
  EXPECT_NEAR(bend.map({0, 0, 15}, j).x(), 20 / 3.14159265359 + 5, 1e-9);
  EXPECT_EQ(bend.map({3, 4, -5}, j), Vec3d(3, 4, -5));
  EXPECT_TRUE(bend.fixes({{-1, -1, -3}, {1, 1, 0}}));
  EXPECT_FALSE(bend.fixes({{-1, -1, -3}, {1, 1, 0.1}}));
}

TEST(Warp, RefusesBadNumbers) {
  const WarpAxis good{Vec3d::Zero(), Vec3d::UnitZ(), 0, 1};
  WarpAxis none = good, empty = good, endless = good;
  none.direction.setZero();
  empty.toMm = 0;
  endless.fromMm = -INFINITY;
  for (const WarpAxis& axis : {none, empty, endless}) {
    EXPECT_THROW(Twist(axis, 1), Error);
    EXPECT_THROW(Taper(axis, 1), Error);
    EXPECT_THROW(Bend(axis, Vec3d::UnitX(), 1), Error);
  }
  EXPECT_THROW(Twist(good, NAN), Error);
  EXPECT_THROW(Taper(good, 0), Error);
  EXPECT_THROW(Taper(good, 0.049), Error);
  EXPECT_THROW(Taper(good, 20.5), Error);
  EXPECT_NO_THROW(Taper(good, 0.05));
  EXPECT_NO_THROW(Taper(good, 20));
  EXPECT_THROW(Bend(good, Vec3d::UnitZ(), 1), Error);
  EXPECT_THROW(Bend(good, Vec3d::UnitX(), 6.3), Error);
}

TEST(Lattice, AtRestMovesNothing) {
  for (const auto& counts : {std::array<int, 3>{2, 2, 2}, {4, 4, 4}, {8, 3, 5}}) {
    const Lattice lattice(kBox, counts);
    Eigen::Matrix3d j;
    EXPECT_FALSE(lattice.moved());
    for (const Vec3d& p : {Vec3d(1, 2, 3), Vec3d(-10, 12, 14), Vec3d(-20, 0, 40)}) {
      EXPECT_LE((lattice.map(p, j) - p).norm(), 1e-12);
      EXPECT_LE((j - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    }
  }
}

TEST(Lattice, ADraggedPlaceFollowsExactlyAndOthersAsLittleAsPossible) {
  Lattice lattice(kBox);
  const Vec3d p(3, -2, 5), by(1, 2, -1);
  lattice.drag(p, by);
  Eigen::Matrix3d j;
  EXPECT_LE((lattice.map(p, j) - p - by).norm(), 1e-12);
  double moved = 0;
  for (size_t i = 0; i < lattice.points().size(); ++i)
    moved += (lattice.points()[i] - lattice.restPoint(i)).squaredNorm();
  // Any other change of the control points that moves the place so is larger: scaled weights of a neighbour place are
  // one.
  Lattice other(kBox);
  const Vec3d q(3.5, -2, 5);
  other.drag(q, by);
  const Vec3d gets = other.map(p, j) - p;
  double otherMoved = 0;
  for (size_t i = 0; i < other.points().size(); ++i)
    otherMoved += (other.points()[i] - other.restPoint(i)).squaredNorm();
  EXPECT_GT(otherMoved * by.squaredNorm() / gets.squaredNorm(), moved);
}

TEST(Lattice, WithFixedSidesLeavesWhatIsOutside) {
  Lattice lattice(kBox);
  lattice.setPoint(lattice.index(1, 2, 1), Vec3d::Zero());
  Eigen::Matrix3d j;
  EXPECT_EQ(lattice.map({30, 2, 3}, j), Vec3d(30, 2, 3));
  EXPECT_TRUE(lattice.fixes({{11, 0, 0}, {12, 1, 1}}));
  EXPECT_FALSE(lattice.fixes({{9, 0, 0}, {12, 1, 1}}));
  const Version bar = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), {60, 21, 21}, 0);
  const Version deformed = deform(bar, lattice, Store::make());
  testing::expectProperBand(deformed, 1.3);
  EXPECT_EQ(deformed.find({5, 0, 0}).tile(), Tile::inside);
  const Brick* was = bar.find({7, 0, 0}).brick();
  const Brick* is = deformed.find({7, 0, 0}).brick();
  ASSERT_TRUE(was && is);
  EXPECT_TRUE(std::ranges::equal(testing::valuesOf(*was), testing::valuesOf(*is)));
  lattice.setPoint(0, Vec3d(-11, -12, -14));
  EXPECT_THROW((void)deform(bar, lattice, Store::make()), Error);
}

TEST(Lattice, RefusesBadNumbers) {
  EXPECT_THROW(Lattice({Vec3d::Zero(), Vec3d(1, 1, 0)}), Error);
  EXPECT_THROW(Lattice(kBox, {1, 4, 4}), Error);
  EXPECT_THROW(Lattice(kBox, {4, 9, 4}), Error);
  Lattice lattice(kBox);
  EXPECT_THROW(lattice.setPoint(64, Vec3d::Zero()), Error);
  EXPECT_THROW(lattice.setPoint(0, Vec3d(NAN, 0, 0)), Error);
  EXPECT_THROW(lattice.drag(Vec3d::Zero(), Vec3d(0, INFINITY, 0)), Error);
}

TEST(Deform, BoundsHoldTheSurfaceWithinAVoxel) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 40; ++n) {
    Grid grid;
    grid.voxelMm = 0.25 + 0.1 * (n % 5);
    const Vec3d middle(30 * u(random), 30 * u(random), 30 * u(random));
    const Version ball = makeSphere(Store::make(), grid, middle, 5 + 4 * u(random));
    Surface surface(false);
    surface.update(ball);
    Vec3d low = Vec3d::Constant(INFINITY), high = -low;
    for (const Vec3d& p : surface.toMesh().positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const BoxMm box = boundsOf(ball);
    EXPECT_TRUE((box.low.array() <= low.array()).all() && (box.high.array() >= high.array()).all()) << n;
    EXPECT_LE(std::max((low - box.low).maxCoeff(), (box.high - high).maxCoeff()), 1.0001 * grid.voxelMm) << n;
  }
  const BoxMm none = boundsOf(Version::empty(Store::make(), Grid{}));
  EXPECT_GT(none.low.x(), none.high.x());
}

TEST(Deform, RefusesFoldsInASentence) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 9);
  Lattice lattice(kBox);
  lattice.setPoint(lattice.index(1, 1, 1), {150, 0, 0});
  try {
    (void)deform(ball, lattice, Store::make());
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("folds"), std::string::npos) << e.what();
  }
  // Clay that is smaller than the places looked at are apart: a ball of 2 mm among places 6.25 mm apart.
  Lattice wide(BoxMm{Vec3d(-100, -100, -100), Vec3d(100, 100, 100)}, {3, 3, 3});
  wide.setPoint(wide.index(1, 1, 1), {2000, 0, 0});
  EXPECT_THROW((void)deform(makeSphere(Store::make(), Grid{}, Vec3d(59.4, 3, 3), 1), wide, Store::make()), Error);
  // A thick rod about a tight arc.
  EXPECT_THROW((void)deform(ball, Bend({Vec3d::Zero(), Vec3d::UnitZ(), -5, 5}, Vec3d::UnitX(), 2), Store::make()),
               Error);
  // 16 times thinner.
  EXPECT_THROW((void)deform(ball, Taper({Vec3d::Zero(), Vec3d::UnitZ(), -5, 5}, 0.06), Store::make()), Error);
}

// A ball that is painted where x is positive, in the band.
Version halfPainted() {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 9);
  Editor editor(ball);
  ball.forEachBrick([&](const Brick& brick) {
    std::array<uint8_t, kBrickVoxels> values;
    for (int i = 0; i < kBrickVoxels; ++i)
      values[size_t(i)] = brick.coord.x >= 0 && std::abs(brick.phi(i)) < 3 ? 200 : 0;
    editor.setChannel(Channel::cover, brick.coord, values);
  });
  return editor.commit();
}

// Painted voxels are those on the side where `side` is positive, but for a rim of a voxel; none is out of the band.
void expectPaintedWhere(const Version& version, const std::function<double(const Vec3d&)>& side) {
  size_t painted = 0, wrong = 0, loose = 0;
  version.forEachBrick([&](const Brick& brick) {
    const ChannelSlot slot = version.find(Channel::cover, brick.coord);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const bool is = slot.value(i) == 200;
      EXPECT_TRUE(is || slot.value(i) == 0);
      painted += is;
      loose += is && std::abs(brick.phi(i)) >= 3;
      const double at = side((brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d());
      if (std::abs(brick.phi(i)) < 2.5f && std::abs(at) > 2) wrong += is != (at > 0);
    }
  });
  version.forEachBrick(Channel::cover,
                       [&](const ChannelBrick& brick) { EXPECT_FALSE(version.find(brick.coord).isTile()); });
  EXPECT_GT(painted, 1000u);
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(loose, 0u);
}

TEST(Deform, PaintGoesWithTheClay) {
  const Version ball = halfPainted();
  expectPaintedWhere(ball, [](const Vec3d& p) { return p.x() + 0.5; });
  // A quarter turn about z for all that lies above the ball's foot, and a little back: what was x is y.
  const Twist twist({Vec3d::Zero(), Vec3d::UnitZ(), -31, -30}, 1.5707963267948966);
  expectPaintedWhere(deform(ball, twist, Store::make()), [](const Vec3d& p) { return p.y() + 0.5; });
}

TEST(Cut, PaintStaysWhereTheClayStays) {
  const Version ball = halfPainted();
  const Vec3d n(1, 1, 0);
  for (const bool copied : {false, true}) {
    const Version part = cut(ball, PlaneDivider(Vec3d(2, 0, 0), n), true, copied ? Store::make() : ball.store());
    size_t painted = 0, wrong = 0, loose = 0;
    part.forEachBrick([&](const Brick& brick) {
      for (int i = 0; i < kBrickVoxels; ++i) {
        const uint8_t value = part.find(Channel::cover, brick.coord).value(i);
        painted += value > 0;
        const Slot was = ball.find(brick.coord);
        const bool both = std::abs(brick.phi(i)) < 3 && std::abs(was.phi(i, 3)) < 3;
        wrong += value != (both ? ball.find(Channel::cover, brick.coord).value(i) : 0);
      }
    });
    part.forEachBrick(Channel::cover, [&](const ChannelBrick& brick) { loose += part.find(brick.coord).isTile(); });
    EXPECT_GT(painted, 500u);
    EXPECT_EQ(wrong, 0u);
    EXPECT_EQ(loose, 0u);
  }
}

TEST(Deform, EmptyClayStaysEmpty) {
  EXPECT_EQ(deform(Version::empty(Store::make(), Grid{}), Lattice(kBox), Store::make()).stats().bricks, 0u);
}

TEST(Deform, ReportsProgressAndCanBeCancelled) {
  const Version ball = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 15);
  const Twist twist({Vec3d::Zero(), Vec3d::UnitZ(), -10, 10}, 1);
  Job job;
  (void)deform(ball, twist, Store::make(), &job);
  EXPECT_GT(job.fraction(), 0.99);
  for (const double at : {0.0, 0.15, 0.3}) {
    Job cancelled;
    const auto store = Store::make();
    std::jthread canceller([&](const std::stop_token& stop) {
      while (!stop.stop_requested() && cancelled.fraction() < at) std::this_thread::yield();
      cancelled.cancel();
    });
    EXPECT_THROW((void)deform(ball, twist, store, &cancelled), Cancelled) << at;
  }
}

}  // namespace
}  // namespace argil::clay
