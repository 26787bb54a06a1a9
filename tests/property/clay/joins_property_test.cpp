// Pieces that are cut at random, put back or stacked, and joined again: one body, without inner skins.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/field/primitives.h"
#include "clay/field/thin_parts.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "clay/whole/cut.h"
#include "clay/whole/offset.h"
#include "tests/support/tier.h"
#include "tests/unit/clay/whole/seam_checks.h"

namespace argil::clay {
namespace {

using testing::expectAsOne;

constexpr double kVoxels[] = {0.8, 0.5, 0.35};

class Joins {
 public:
  explicit Joins(uint64_t seed) : random_(seed) {}

  /// `i`: kind of shape and of seam.
  void round(int i) {
    grid_.voxelMm = kVoxels[i % 3];
    // Faces on voxels, and anywhere between them.
    grid_.originMm = (i / 3 % 2 == 0 ? 0 : grid_.voxelMm) * Vec3d(u(), u(), u());
    const int kind = i / 6 % 6;
    gone_ = {};
    SCOPED_TRACE(::testing::Message() << "round " << i << ", kind " << kind << ", voxels of " << grid_.voxelMm
                                      << " mm");
    if (kind == 5) {
      stacked();
      return;
    }
    const Version whole = shape();
    if (kind == 4) {
      const Version tool = plug();
      // Thin clay beside a plug that comes out nearly along the surface goes, and is told of to a third of it.
      const Version rest = combine(whole, tool, Combination::cut, {.gone = &gone_});
      expectAsOne(combine(rest, tool, Combination::join), combine(whole, tool, Combination::join), lost(), 0.0015);
    } else if (kind == 3) {
      const Version again = rejoined(whole, CurveDivider(curve()));
      expectAsOne(again, whole, lost());
    } else {
      // On voxels, along an axis between them, or slanted.
      Vec3d normal = Vec3d::Unit(static_cast<int>(random_() % 3));
      Vec3d point =
          grid_.originMm + grid_.voxelMm * Vec3d(std::round(6 * u()), std::round(6 * u()), std::round(6 * u()));
      if (kind >= 1) point += grid_.voxelMm * Vec3d(u(), u(), u());
      if (kind == 2) normal = Vec3d(u(), u(), u()).normalized();
      const Version again = rejoined(whole, PlaneDivider(point, normal));
      expectAsOne(again, whole, lost());
    }
  }

 private:
  double u() { return std::uniform_real_distribution<double>(-1, 1)(random_); }

  Version shape() {
    const Vec3d at = Vec3d(u(), u(), u()), size = Vec3d(18, 17, 16) + 3 * Vec3d(u(), u(), u());
    switch (random_() % 6) {
      case 0:
        return makeBlock(Store::make(), grid_, at, size, 0);
      case 1:
        return makeSphere(Store::make(), grid_, at, 9 + u());
      case 2:
        return makeCylinder(Store::make(), grid_, at, 9 + u(), 16 + u());
      case 3:
        return makeEllipsoid(Store::make(), grid_, at, size / 2);
      case 4:
        return makeBlock(Store::make(), grid_, at, size, 3);
      default:
        return makeTorus(Store::make(), grid_, at, 8 + u(), 4.5 + u() / 2);
    }
  }
  Version plug() {
    const Vec3d at = 5 * Vec3d(u(), u(), u());
    switch (random_() % 4) {
      case 0:
        return makeBlock(Store::make(), grid_, at, Vec3d(8, 9, 10) + 2 * Vec3d(u(), u(), u()), 0);
      case 1:
        return makeSphere(Store::make(), grid_, at, 6 + u());
      case 2:
        return makeRod(Store::make(), grid_, at - Vec3d(0, 0, 8), at + 8 * Vec3d(u(), u(), 1), 4 + u());
      default:
        return makeCylinder(Store::make(), grid_, at, 5 + u(), 9 + u());
    }
  }
  CurveDivider::Curve curve() {
    CurveDivider::Curve curve;
    const double height = 2 * u(), wide = 2 * u(), rate = 0.4 + 0.1 * u();
    for (int i = 0; i <= 60; ++i) curve.pointsMm.emplace_back(-15 + 0.5 * i, 0, height + wide * std::sin(rate * i / 2));
    curve.direction = Vec3d::UnitY();
    return curve;
  }
  Version rejoined(const Version& whole, const Divider& divider) {
    return combine(cut(whole, divider, true, whole.store(), nullptr, 0, &gone_),
                   cut(whole, divider, false, Store::make(), nullptr, 0, &gone_), Combination::join);
  }
  // Volume that cuts say they lost, mm³: caps that are lower than a voxel.
  [[nodiscard]] double lost() const { return (gone_.clayVolume + gone_.betweenVoxels) * std::pow(grid_.voxelMm, 3); }
  // Beside the block that both are.
  void stacked() {
    const Vec3d size = Vec3d(18, 17, 16) + 3 * Vec3d(u(), u(), u());
    const double below = size.z() * (0.5 + 0.2 * u());
    const Version lower = makeBlock(Store::make(), grid_, {0, 0, below / 2}, {size.x(), size.y(), below}, 0),
                  upper = makeBlock(Store::make(), grid_, {0, 0, (below + size.z()) / 2},
                                    {size.x(), size.y(), size.z() - below}, 0);
    expectAsOne(combine(lower, upper, Combination::join),
                makeBlock(Store::make(), grid_, {0, 0, size.z() / 2}, size, 0));
  }

  std::mt19937_64 random_;
  Grid grid_;
  ThinParts gone_;
};

TEST(Joins, PartsOfOneAreOneAgain) {
  constexpr uint64_t kSeed = 20261130;
  std::printf("seed %lu\n", static_cast<unsigned long>(kSeed));
  Joins joins(kSeed);
  // 500 of them with each of three voxels.
  for (int i = 0; i < tests::byTier(144, 1500); ++i) joins.round(i);
}

// Moved inwards by what its thinnest place is half as thick as, and a tenth of a voxel more or less, nothing is left.
TEST(Joins, NothingIsLeftBesideTheVanishingDistance) {
  constexpr uint64_t kSeed = 20261201;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < tests::byTier(12, 40); ++i) {
    Grid grid;
    grid.voxelMm = kVoxels[i % 3];
    if (i % 2 == 1) grid.originMm = grid.voxelMm * Vec3d(u(random), u(random), u(random));
    const double half = (4 + 2 * u(random)) * grid.voxelMm / 0.5;
    Version clay;
    switch (i / 3 % 5) {
      case 0:
        clay = makeBlock(Store::make(), grid, Vec3d::Zero(), {6 * half, 5 * half, 2 * half}, 0);
        break;
      case 1:
        clay = makeSphere(Store::make(), grid, Vec3d::Zero(), half);
        break;
      case 2:
        clay = makeCylinder(Store::make(), grid, Vec3d::Zero(), 3 * half, 2 * half);
        break;
      case 3:
        clay = makeCylinder(Store::make(), grid, Vec3d::Zero(), half, 6 * half);
        break;
      default:
        clay = makeTorus(Store::make(), grid, Vec3d::Zero(), 3 * half, half);
        break;
    }
    for (const double off : {-0.1, -0.05, 0.0, 0.05, 0.1}) {
      SCOPED_TRACE(::testing::Message() << "shape " << i << ", " << half / grid.voxelMm << " voxels and " << off);
      EXPECT_THROW((void)offset(clay, -half - off * grid.voxelMm, 2), Error);
    }
    EXPECT_NO_THROW((void)offset(clay, -half + grid.voxelMm, 2));
    EXPECT_THROW((void)shell(clay, half, 0, 2), Error);
  }
}

}  // namespace
}  // namespace argil::clay
