// Whole-piece operations on random clay: what every result must be.

#include <gtest/gtest.h>

#include <random>

#include "clay/field/loose_parts.h"
#include "clay/field/primitives.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/mirror.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "tests/support/tier.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/whole/whole_checks.h"

namespace argil::clay {
namespace {

Version randomClay(std::mt19937_64& random, const std::shared_ptr<Store>& store) {
  std::uniform_real_distribution<double> u(-1, 1);
  Version clay = makeSphere(store, Grid{}, Vec3d(u(random), u(random), u(random)) * 4, 8 + 2 * u(random));
  for (int i = 0; i < 4; ++i) {
    const Vec3d at = Vec3d(u(random), u(random), u(random)) * 9;
    const Version other =
        i % 2 ? makeBlock(store, Grid{}, at, Vec3d(7, 8, 9) + 3 * Vec3d(u(random), u(random), u(random)), 0)
              : makeSphere(store, Grid{}, at, 4.5 + 2 * u(random));
    clay = combine(clay, other, random() % 3 == 0 ? Combination::cut : Combination::join);
  }
  return clay;
}

// Equal content has equal bits, whatever path led there: written anew it is the same.
void expectCanonical(const Version& version) {
  Editor editor(Version::empty(Store::make(), version.grid()));
  version.forEachBrick([&](const Brick& brick) { editor.setVoxels(brick.coord, testing::valuesOf(brick)); });
  uint64_t bricks = 0;
  const Version again = editor.commit();
  version.forEachBrick([&](const Brick& brick) {
    ++bricks;
    const Brick* other = again.find(brick.coord).brick();
    ASSERT_NE(other, nullptr);
    ASSERT_TRUE(std::ranges::equal(testing::valuesOf(brick), testing::valuesOf(*other)));
    ASSERT_TRUE(std::equal(std::begin(brick.inside), std::end(brick.inside), other->inside));
  });
  EXPECT_EQ(again.stats().bricks, bricks);
}

// Distance of a version's field at world mm, in mm; `known` is false beyond the band.
struct Reading {
  double mm;
  bool known;
};
Reading readAt(const Version& version, const Vec3d& mm) {
  Sampler sampler(version);
  const double phi = double(sampler.trilinear(version.grid().toVoxel(mm)));
  return {phi * version.grid().voxelMm, std::abs(phi) < double(version.grid().band) - 0.1};
}

std::vector<Vec3d> surfacePoints(const Version& version, size_t most) {
  Surface surface(false);
  surface.update(version, 2);
  std::vector<Vec3d> points = surface.toMesh().positions;
  const size_t every = points.size() / most + 1;
  std::vector<Vec3d> some;
  for (size_t i = 0; i < points.size(); i += every) some.push_back(points[i]);
  return some;
}

// Voxels outside, a voxel or less from the surface, that have none of its clay within `reach` along each axis: what
// they were measured to is not there.
size_t measuredToNothing(const Version& version, int reach) {
  Sampler field(version);
  size_t count = 0;
  version.forEachBrick([&](const Brick& brick) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord at = brick.coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      const float phi = field.voxel(at);
      if (phi < 0 || phi > 1) continue;
      bool found = false;
      for (int size = 1; size <= reach && !found; ++size)
        for (int x = -size; x <= size && !found; ++x)
          for (int y = -size; y <= size && !found; ++y)
            for (int z = -size; z <= size && !found; z += std::max(std::abs(x), std::abs(y)) == size ? 1 : 2 * size)
              found = field.voxel(at + Coord{x, y, z}) < 0;
      count += !found;
    }
  });
  return count;
}

// Each operation did what it is for: an operation that gives its input back, or one that does something else, fails
// here.
TEST(WholePieces, ResultsAreWhatTheOperationSays) {
  constexpr uint64_t kSeed = 20261121;
  std::printf("seed %lu\n", static_cast<unsigned long>(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < tests::byTier(2, 4); ++i) {
    SCOPED_TRACE(::testing::Message() << "clay " << i);
    const auto store = Store::make();
    const Version clay = randomClay(random, store), other = randomClay(random, store);
    const double voxel = clay.grid().voxelMm;
    const std::vector<Vec3d> points = surfacePoints(clay, 3000);

    // Booleans: a point well away from both surfaces is inside exactly when set theory says so.
    const Version join = combine(clay, other, Combination::join), cut = combine(clay, other, Combination::cut),
                  both = combine(clay, other, Combination::intersect);
    uint64_t decided = 0;
    for (int k = 0; k < 4000; ++k) {
      const Vec3d p = Vec3d(u(random), u(random), u(random)) * 22;
      const double a = readAt(clay, p).mm, b = readAt(other, p).mm;
      if (std::abs(a) < voxel / 2 || std::abs(b) < voxel / 2) continue;
      ++decided;
      EXPECT_EQ(readAt(join, p).mm < 0, a < 0 || b < 0);
      EXPECT_EQ(readAt(cut, p).mm < 0, a < 0 && b > 0);
      EXPECT_EQ(readAt(both, p).mm < 0, a < 0 && b < 0);
    }
    EXPECT_GT(decided, 3000u);
    // Slivers that no voxel holds are gone with their distances; tips of wedges are up to three voxels from a voxel.
    for (const Version* each : {&clay, &join, &cut, &both}) EXPECT_EQ(measuredToNothing(*each, 5), 0u);

    // An offset outwards lies `mm` from the old surface everywhere; inwards it lies at least so far.
    for (const double mm : {1.7, -1.1}) {
      const Version moved = offset(clay, mm, 2);
      const TriangleMesh mesh = [&] {
        Surface surface(false, Grade::fine);
        surface.update(clay, 2);
        return surface.toMesh();
      }();
      const NearestTriangle nearest(mesh);
      double sum = 0, least = 1e9, most = 0;
      const std::vector<Vec3d> there = surfacePoints(moved, 1500);
      for (const Vec3d& p : there) {
        const double d = std::sqrt(nearest.nearest(p).squared);
        least = std::min(least, d), most = std::max(most, d);
        sum += std::abs(d - std::abs(mm));
        EXPECT_EQ(readAt(clay, p).mm > 0, mm > 0);
      }
      EXPECT_LE(sum / double(there.size()), 0.1 * voxel) << mm;
      EXPECT_GE(least, std::abs(mm) - 2 * voxel) << mm;   // draft vertices cut creases off
      EXPECT_LE(most, std::abs(mm) + 2.5 * voxel) << mm;  // beside a tip that triangles do not reach
    }

    // A shell has clay beside its outer surface and none in its depth.
    const Version wall = shell(clay, 1.5, 0, 2);
    const Version core = offset(clay, -1.5, 2);
    uint64_t hollow = 0, solid = 0;
    core.forEachBrick([&](const Brick& brick) {
      const Vec3d p = core.grid().toWorld((brick.coord * 8).toVec3d() + Vec3d::Constant(3.5));
      const double inner = readAt(core, p).mm, outer = readAt(clay, p).mm;
      if (inner < -voxel) hollow += readAt(wall, p).mm > 0, solid += readAt(wall, p).mm <= 0;
      if (inner > voxel && outer < -voxel) {
        EXPECT_LT(readAt(wall, p).mm, 0);
      }
    });
    EXPECT_GT(hollow, 0u);
    EXPECT_EQ(solid, 0u);
    for (const Vec3d& p : points) EXPECT_NEAR(readAt(wall, p).mm, 0, 0.6 * voxel);

    // Moved and resampled, the old surface lies on the new one.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(1 + u(random), Vec3d(u(random), u(random), 1).normalized()));
    pose.pretranslate(Vec3d(u(random), u(random), u(random)) * 7);
    Grid grid;
    grid.voxelMm = 0.4;
    const Version resampled = resample(clay, grid, pose, 2);
    double sum = 0;
    for (const Vec3d& p : points) sum += std::abs(readAt(resampled, pose * p).mm);
    EXPECT_LE(sum / double(points.size()), 0.1 * voxel);

    // A mirrored half: the kept side is as it was, the other is its image.
    const Vec3d at(u(random), 0, 0), normal = Vec3d(1, 0.5 * u(random), 0.3 * u(random)).normalized();
    const Version mirrored = mirrorHalf(clay, at, normal, 2);
    for (const Vec3d& p : points) {
      const double side = (p - at).dot(normal);
      if (side < 8) continue;  // distances near the plane are to what the mirror has put there
      EXPECT_NEAR(readAt(mirrored, p).mm, readAt(clay, p).mm, 0.2 * voxel);  // creases are read by splines
      EXPECT_NEAR(readAt(mirrored, p - 2 * side * normal).mm, readAt(clay, p).mm, 0.3 * voxel);
    }

    // Evened out: less area, the volume that was.
    const auto areaAndVolume = [](const Version& version) {
      Surface surface(false);
      surface.update(version, 2);
      const TriangleMesh mesh = surface.toMesh();
      double area = 0, volume = 0;
      for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d &A = mesh.positions[a], &B = mesh.positions[b], &C = mesh.positions[c];
        area += (B - A).cross(C - A).norm() / 2;
        volume += A.dot(B.cross(C)) / 6;
      }
      return std::pair(area, volume);
    };
    const auto [area, volume] = areaAndVolume(clay);
    const auto [smoothArea, smoothVolume] = areaAndVolume(smoothAll(clay, 6, true, 2));
    EXPECT_LT(smoothArea, 0.99 * area);
    EXPECT_NEAR(smoothVolume / volume, 1,
                6e-3);  // of draft surfaces, which cut the creases off that are gone afterwards

    // Parts are disjoint and together the whole; a crumb and a cavity that were put in go, and nothing else.
    const Version apart = makeSphere(store, clay.grid(), Vec3d(30, 0, 0), 2);
    const Version two = combine(clay, apart, Combination::join);
    const std::vector<Version> parts = splitParts(two);
    ASSERT_EQ(parts.size(), splitParts(clay).size() + 1);
    double together = 0;
    for (const Version& part : parts) together += areaAndVolume(part).second;
    EXPECT_NEAR(together / (volume + areaAndVolume(apart).second), 1, 1e-4);
    EXPECT_EQ(removeCrumbs(two, 40).version.hash(), removeCrumbs(clay, 40).version.hash());
    const Version ball = makeSphere(store, clay.grid(), Vec3d(1, 2, 3), 9);
    const Version holed = combine(ball, makeSphere(store, clay.grid(), Vec3d(2, 2, 3), 3), Combination::cut);
    const Cleaned filled = fillVoids(holed);
    EXPECT_EQ(filled.count, 1u);
    // Distances inside were measured to the cavity: they are made anew to what is left, by the first-order solver.
    ball.forEachBrick([&](const Brick& brick) {
      for (int k = 0; k < kBrickVoxels; ++k)
        EXPECT_NEAR(filled.version.find(brick.coord).phi(k, 3), brick.phi(k), 0.12);
    });
    EXPECT_NEAR(filled.volumeMm3, 36 * M_PI, 4);  // voxels, counted
  }
}

TEST(WholePieces, ResultsAreClosedBandsOnRandomClay) {
  constexpr uint64_t kSeed = 20261120;
  std::printf("seed %lu\n", static_cast<unsigned long>(kSeed));
  std::mt19937_64 random(kSeed);
  double steepest = 0;
  for (int i = 0; i < tests::byTier(3, 6); ++i) {
    const auto store = Store::make();
    const Version clay = randomClay(random, store), other = randomClay(random, store);
    std::uniform_real_distribution<double> u(-1, 1);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(u(random) * 3, Vec3d(u(random), u(random), u(random)).normalized()));
    Grid grid;
    grid.voxelMm = 0.5 * std::exp2(u(random));
    std::vector<Version> results{combine(clay, other, static_cast<Combination>(i % 3)),
                                 offset(clay, 1 + 3 * std::abs(u(random)), 2),
                                 shell(clay, 0.8, 0.8, 2),
                                 resample(clay, grid, pose, 2),
                                 mirrorHalf(clay, Vec3d(u(random), 0, 0), Vec3d(1, u(random), 0), 2),
                                 smoothAll(clay, 2, true, 2),
                                 fillVoids(clay).version,
                                 removeCrumbs(clay, 5).version};
    const std::vector<Version> parts = splitParts(clay);
    results.insert(results.end(), parts.begin(), parts.end());
    for (size_t k = 0; k < results.size(); ++k) {
      SCOPED_TRACE(::testing::Message() << "clay " << i << " result " << k);
      if (results[k].stats().bricks == 0) continue;
      const auto faults = testing::bandFaults(results[k]);
      steepest = std::max(steepest, faults.steepest);
      EXPECT_EQ(faults.besideTile, 0u);
      EXPECT_LE(faults.steepest, 1.1);
      testing::expectClosed(results[k], 0);
      expectCanonical(results[k]);
    }
  }
  std::printf("steepest difference between neighbours: %.3f voxel\n", steepest);
}

}  // namespace
}  // namespace argil::clay
