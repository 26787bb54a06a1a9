// Walls and gaps at each vertex: shapes whose inscribed balls are known, shapes that have no walls, and clay that
// changes.

#include "clay/surface/wall_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kVoxel = 0.5;
constexpr int kThreads = 2;

Grid grid() {
  Grid grid;
  grid.voxelMm = kVoxel;
  grid.originMm = {0.13, -0.07, 0.21};
  return grid;
}
Version ball(const Vec3d& middle, double radiusMm) {
  return makeSphere(Store::make(), grid(), middle, radiusMm);
}
Version block(const Vec3d& middle, const Vec3d& edges) {
  return makeBlock(Store::make(), grid(), middle, edges, 0);
}
Version with(const Version& a, Combination how, const Version& b) {
  return combine(a, b, how);
}

struct Measured {
  Surface surface;
  WallMap map;

  Measured(const Version& version, double wall, double gap) : map(wall, gap) {
    map.follow(surface.update(version), kThreads);
  }
  void follow(const Version& version, int threads = 1) { map.follow(surface.update(version), threads); }
  /// visit(place in mm, normal, size in voxels) of each vertex.
  void forEach(SideOf side, const std::function<void(const Vec3d&, const Vec3f&, float)>& visit) const {
    surface.forEach([&](const BrickMesh& mesh) {
      const auto sizes = map.sizes(mesh.brick, side);
      ASSERT_EQ(sizes.size(), mesh.positions.size());
      for (size_t i = 0; i < sizes.size(); ++i)
        visit(surface.version().grid().toWorld(mesh.brick.toVec3d() * 8 + mesh.positions[i].cast<double>()),
              mesh.normals[i].unpack(), sizes[i]);
    });
  }
  [[nodiscard]] size_t found(SideOf side) const {
    size_t count = 0;
    forEach(side, [&](const Vec3d&, const Vec3f&, float size) { count += std::isfinite(size); });
    return count;
  }
};

// Each vertex beside what its ball is: `truth` in mm, not finite where the shape has no wall.
void expectSizes(const Measured& measured, SideOf side, double limit, const std::function<double(const Vec3d&)>& truth,
                 double most = 0.1) {
  size_t count = 0;
  double worst = 0, squares = 0;
  measured.forEach(side, [&](const Vec3d& p, const Vec3f&, float size) {
    const double voxels = truth(p) / kVoxel;
    if (std::isnan(voxels)) return;
    if (voxels < limit - 0.2) {
      ASSERT_TRUE(std::isfinite(size)) << p.transpose() << " should be " << voxels;
      worst = std::max(worst, std::abs(size - voxels));
      squares += (size - voxels) * (size - voxels);
      ++count;
    } else if (voxels > limit + 0.2) {
      ASSERT_FALSE(std::isfinite(size)) << p.transpose() << " is " << voxels << ", not " << size;
    }
  });
  EXPECT_GT(count, 100u);
  EXPECT_LT(worst, most);
  EXPECT_LT(std::sqrt(squares / double(count)), most / 3);
}

TEST(WallMap, ShellsAreAsThickAsTheyAreFromBothSides) {
  for (const double voxels : {2.0, 2.7, 4.0, 7.5, 20.0}) {
    SCOPED_TRACE(voxels);
    const double outer = 15;
    const Version shell = with(ball({0, 0, 0}, outer), Combination::cut, ball({0, 0, 0}, outer - voxels * kVoxel));
    const Measured measured(shell, voxels + 1, 0);
    expectSizes(measured, SideOf::wall, voxels + 1, [&](const Vec3d&) { return voxels * kVoxel; });
    EXPECT_EQ(Measured(shell, voxels - 0.3, 3).found(SideOf::wall), 0u);
    EXPECT_EQ(measured.found(SideOf::gap), 0u);
  }
}

TEST(WallMap, AShellWhoseHollowIsOffItsMiddle) {
  const Vec3d off(2.1, -1.3, 1.7);
  const double outer = 15, inner = 10;
  const Version shell = with(ball({0, 0, 0}, outer), Combination::cut, ball(off, inner));
  expectSizes(Measured(shell, 14, 0), SideOf::wall, 14, [&](const Vec3d& p) -> double {
    if (std::abs(p.norm() - outer) > 1) return NAN;
    const Vec3d u = p.normalized();
    const double along = u.dot(off);
    return (outer * outer - 2 * outer * along + off.squaredNorm() - inner * inner) / (outer - along + inner);
  });
}

TEST(WallMap, ATube) {
  const auto cylinder = [&](double radius, double height) {
    return makeCylinder(Store::make(), grid(), {0, 0, 0}, radius, height);
  };
  const Version tube = with(cylinder(9, 40), Combination::cut, cylinder(7.5, 60));
  expectSizes(Measured(tube, 5, 0), SideOf::wall, 5,
              [](const Vec3d& p) { return std::abs(p.z()) < 18 ? 1.5 : double(NAN); });
  // A ball in its bore touches all around: the vertex's normal, by a degree, says where its middle is.
  expectSizes(
      Measured(tube, 0, 32), SideOf::gap, 32,
      [](const Vec3d& p) { return std::abs(p.z()) < 16 && std::hypot(p.x(), p.y()) < 8 ? 15.0 : double(NAN); },
      0.02 * 30);
}

TEST(WallMap, ALensIsAsThinAsItIsUpToItsRim) {
  // What two balls of 30 mm have in common: 8 mm thick, and thinner and thinner up to its rim.
  const double radius = 30;
  const Vec3d a(0, 0, -26), b(0, 0, 26);
  const Version lens = with(ball(a, radius), Combination::intersect, ball(b, radius));
  size_t checked = 0;
  expectSizes(Measured(lens, 20, 0), SideOf::wall, 20, [&](const Vec3d& p) -> double {
    const Vec3d centre = p.z() > 0 ? a : b, d = centre - (p.z() > 0 ? b : a), u = (p - centre).normalized();
    const double size = 2 * (radius + d.squaredNorm() / (2 * d.dot(u)));
    if (size < 2 * kVoxel) return NAN;  // the rim itself
    ++checked;
    return size;
  });
  EXPECT_GT(checked, 1000u);
}

TEST(WallMap, TwoBallsHaveAGapWhereTheyAreNear) {
  const Version two = with(ball({-10.5, 0, 0}, 10), Combination::join, ball({10.5, 0, 0}, 10));
  const Measured measured(two, 4, 6);
  EXPECT_EQ(measured.found(SideOf::wall), 0u);
  expectSizes(measured, SideOf::gap, 6, [](const Vec3d& p) -> double {
    const Vec3d own(p.x() < 0 ? -10.5 : 10.5, 0, 0), other = -own, u = (p - own).normalized();
    // |own + (10 + r) u − other| = 10 + r
    const Vec3d d = own - other;
    const double size = 2 * (-d.squaredNorm() / (2 * d.dot(u)) - 10);
    // Opposite alone counts.
    const Vec3d at = p + size / 2 * u;
    return size > 0 && (at - other).normalized().dot(u) < -0.55 ? size : NAN;
  });
}

TEST(WallMap, WhatIsThickHasNoWalls) {
  EXPECT_EQ(Measured(block({0, 0, 0}, {14, 14, 14}), 24, 24).found(SideOf::wall), 0u);
  EXPECT_EQ(Measured(block({0, 0, 0}, {14, 14, 14}), 24, 24).found(SideOf::gap), 0u);
  EXPECT_EQ(Measured(ball({0, 0, 0}, 8), 28, 28).found(SideOf::wall), 0u);
  EXPECT_EQ(Measured(makeTorus(Store::make(), grid(), {0, 0, 0}, 12, 4), 14, 12).found(SideOf::wall), 0u);
  // A notch at right angles is no gap, and what it leaves is no wall.
  const Version notched = with(block({0, 0, 0}, {14, 14, 14}), Combination::cut, block({7, 7, 0}, {7, 7, 20}));
  EXPECT_EQ(Measured(notched, 10, 10).found(SideOf::wall), 0u);
  EXPECT_EQ(Measured(notched, 10, 10).found(SideOf::gap), 0u);
}

TEST(WallMap, ChangesAreFollowedAsIfAllWereNew) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  Version version = with(block({0, 0, 0}, {24, 24, 6}), Combination::join, block({0, 0, 6}, {24, 3, 10}));
  Measured kept(version, 9, 7);
  size_t again = 0, all = 0;
  for (int step = 0; step < 24; ++step) {
    BrushStroke stroke(version, Brush::of(step % 3 ? Method::carve : Method::add));
    const Vec3d at = version.grid().toVoxel(Vec3d(12 * unit(random), 12 * unit(random), 3 + 3 * unit(random)));
    stroke.apply({at, at + Vec3d(4 * unit(random), 4, 0), 3 + 2 * unit(random), 1});
    version = stroke.finish();
    again += kept.map.follow(kept.surface.update(version), 1 + step % 3).size();
    const Measured fresh(version, 9, 7);
    for (const SideOf side : {SideOf::wall, SideOf::gap})
      fresh.surface.forEach([&](const BrickMesh& mesh) {
        ++all;
        const auto a = fresh.map.sizes(mesh.brick, side), b = kept.map.sizes(mesh.brick, side);
        ASSERT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << step;
        ASSERT_EQ(fresh.map.partners(mesh.brick, side).size(), kept.map.partners(mesh.brick, side).size());
      });
  }
  EXPECT_LT(4 * again, all) << "what is far from a change is not measured again";
}

TEST(WallMap, StopsWhenItIsToldTo) {
  Job job;
  job.cancel();
  Surface surface;
  WallMap map(4, 4);
  EXPECT_THROW(map.follow(surface.update(ball({0, 0, 0}, 10)), 1, WorkPart(&job)), Cancelled);
}

TEST(WallMap, WithoutClayThereIsNothing) {
  Measured measured(ball({0, 0, 0}, 3), 20, 20);
  EXPECT_GT(measured.found(SideOf::wall), 0u);
  measured.follow(Version::empty(measured.surface.version().store(), grid()));
  EXPECT_EQ(measured.found(SideOf::wall), 0u);
  EXPECT_TRUE(measured.map.sizes({0, 0, 0}, SideOf::wall).empty());
  EXPECT_THROW(WallMap(257, 0), Error);
  EXPECT_THROW(WallMap(1, -1), Error);
  EXPECT_THROW(WallMap(NAN, 1), Error);
}

TEST(ThinParts, AWallIsOnePartWithBothItsSides) {
  Version plates = block({0, 0, 0}, {30, 20, 6});
  for (const double x : {-10.0, 0.0, 10.0})
    plates = with(plates, Combination::join, block({x, 0, 8}, {1.5 + 0.05 * x, 20, 12}));
  const Measured measured(plates, 4, 2);
  const ThinParts thin = thinParts(measured.surface, measured.map, SideOf::wall, 1.8);
  ASSERT_THAT(thin.parts, SizeIs(2));  // of 1 and of 1.5 mm; not of 2
  // Beside a rim it seems thinner, by half a voxel at most.
  EXPECT_NEAR(thin.parts[0].leastMm, 1, kVoxel / 2);
  EXPECT_NEAR(thin.parts[0].atMm.x(), -10, 0.6);
  EXPECT_NEAR(thin.parts[1].leastMm, 1.5, kVoxel / 2);
  EXPECT_NEAR(thin.parts[1].areaMm2, 2 * 20 * 11, 60);
  EXPECT_NEAR(thin.areaMm2, thin.parts[0].areaMm2 + thin.parts[1].areaMm2, 1e-6);
  EXPECT_NEAR(thin.share(), thin.areaMm2 / thin.surfaceMm2, 1e-9);
  EXPECT_THAT(thinParts(measured.surface, measured.map, SideOf::gap, 1).parts, IsEmpty());
}

}  // namespace
}  // namespace argil::clay
