// Undercuts at the vertices of a surface: beside the exact look at each face, and followed beside a fresh look.

#include "clay/mould/pull_map.h"

#include <gtest/gtest.h>

#include <random>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mould/pull_faces.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid voxels() {
  Grid grid;
  grid.voxelMm = 1;
  return grid;
}
Version ball(const Vec3d& at, double radius) {
  return makeSphere(Store::make(), voxels(), at, radius);
}
Version block(const Vec3d& middle, const Vec3d& edges) {
  return makeBlock(Store::make(), voxels(), middle, edges, 0);
}
Version joined(const Version& a, const Version& b) {
  return combine(a, b, Combination::join);
}

std::vector<Coord> bricksOf(const Surface& surface) {
  std::vector<Coord> all;
  surface.forEach([&](const BrickMesh& mesh) { all.push_back(mesh.brick); });
  return all;
}

// Of all vertices, in the order of the surface.
std::vector<uint8_t> heldOf(const Surface& surface, const PullMap& map) {
  std::vector<uint8_t> all;
  surface.forEach([&](const BrickMesh& mesh) {
    const auto held = map.undercut(mesh.brick);
    for (size_t i = 0; i < mesh.positions.size(); ++i) all.push_back(held.empty() ? 0 : held[i]);
  });
  return all;
}

size_t count(const std::vector<uint8_t>& held) {
  return size_t(std::count(held.begin(), held.end(), uint8_t{1}));
}

TEST(PullMap, AMushroomHidesWhatItsHatCovers) {
  const Version stem = block({0, 0, 24}, {12, 12, 80});
  const Version mushroom = joined(stem, block({0, 0, 60}, {60, 60, 20}));
  for (const double side : {1.0, -1.0}) {
    Surface surface;
    surface.update(mushroom);
    PullMap map(side * Vec3d::UnitZ());
    map.follow(surface, bricksOf(surface), 1);
    // Nothing: the hat looks down and what is below it is free, the stem stands upright.
    EXPECT_EQ(count(heldOf(surface, map)), 0u);
    // A plate below the hat: between them, both look at each other.
    const Version plate = joined(mushroom, block({0, 0, -20}, {60, 60, 20}));
    surface.update(plate);
    PullMap anew(side * Vec3d::UnitZ());
    anew.follow(surface, bricksOf(surface), 1);
    size_t inner = 0, held = 0;
    surface.forEach([&](const BrickMesh& mesh) {
      const auto of = anew.undercut(mesh.brick);
      for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3d p = (mesh.brick * kBrickEdge).toVec3d() + mesh.positions[i].cast<double>();
        const bool between = p.z() > -12 && p.z() < 52 && p.head<2>().lpNorm<Eigen::Infinity>() < 28;
        inner += between;
        if (between) {
          EXPECT_TRUE(!of.empty() && of[i]) << p.transpose();
        }
        held += !of.empty() && of[i];
      }
    });
    EXPECT_GT(inner, 5000u);
    EXPECT_LT(held, inner + inner / 5) << "outer faces are free";
  }
}

TEST(PullMap, AgreesWithTheExactLookAtEachFace) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-30, 30), size(6, 18);
  size_t all = 0, wrong = 0, held = 0;
  for (int i = 0; i < 6; ++i) {
    Version clay = ball({0, 0, 0}, 20);
    for (int k = 0; k < 7; ++k) clay = joined(clay, ball({place(random), place(random), place(random)}, size(random)));
    const Vec3d pull = Vec3d(normal(random), normal(random), normal(random)).normalized();
    Surface surface;
    surface.update(clay);
    PullMap map(pull);
    map.follow(surface, bricksOf(surface), 2);
    const TriangleMesh mesh = surface.toMesh();
    const std::vector<uint8_t> ours = heldOf(surface, map);
    ASSERT_EQ(ours.size(), mesh.positions.size());
    const PullFaces exact = pullFaces(mesh, pull, 0.1, 2, 1);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& corners = mesh.triangles[t];
      const int of = ours[corners[0]] + ours[corners[1]] + ours[corners[2]];
      const bool is = exact.sides[t] == PullSide::undercut;
      ++all, held += is;
      wrong += is ? of == 0 : of == 3;
    }
  }
  std::printf("%zu of %zu faces undercut, %zu told otherwise\n", held, all, wrong);
  EXPECT_GT(held, all / 10);
  EXPECT_LT(wrong, all / 200) << "those at the border of a shadow, by less than a voxel";
}

TEST(PullMap, StrokesAreFollowedAsIfAllWereNew) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (const Vec3d& pull : {Vec3d(0, 0, 1), Vec3d(1, 2, 3).normalized()}) {
    Version clay = joined(ball({0, 0, 0}, 75), ball({0, 0, 190}, 60));
    Surface surface;
    surface.update(clay);
    PullMap map(pull);
    map.follow(surface, bricksOf(surface), 1);
    size_t most = 0, looked = 0, fresh = 0;
    for (int i = 0; i < 14; ++i) {
      if (i == 9) {
        // What hid much is gone at once.
        clay = combine(clay, block({0, 0, 190}, {200, 200, 130}), Combination::cut);
      } else {
        BrushStroke stroke(clay, Brush::of(i % 3 ? Method::carve : Method::add));
        const Vec3d at = (i % 2 ? Vec3d(0, 0, 0) : Vec3d(0, 0, 170)) +
                         72 * Vec3d(normal(random), normal(random), normal(random)).normalized();
        stroke.apply({at, at + Vec3d(4, 2, 0), 9, 1});
        clay = stroke.finish();
      }
      std::vector<Coord> changed;
      for (const BrickMeshPtr& mesh : surface.update(clay).changed) changed.push_back(mesh->brick);
      looked += map.follow(surface, changed, 1 + i % 2).size();
      PullMap anew(pull);
      fresh += anew.follow(surface, bricksOf(surface), 1).size();
      const std::vector<uint8_t> held = heldOf(surface, map);
      ASSERT_EQ(held, heldOf(surface, anew)) << i;
      most = std::max(most, count(held));
    }
    EXPECT_GT(most, 500u);
    EXPECT_LT(looked, fresh / 2) << "columns of what changed, not all";
  }
}

// What hides is found wherever it lies in the grid, also where nothing is above it.
TEST(PullMap, APlateOfTwoVoxelsHides) {
  const Version clay = block({0, 0, 0}, {60, 60, 30});
  for (int i = 0; i < 8; ++i) {
    const double low = 30 + 0.27 * i;
    Surface surface;
    surface.update(joined(clay, block({0, 0, low + 1}, {80, 80, 2})));
    PullMap map((i % 2 ? 1 : -1) * Vec3d::UnitZ());
    map.follow(surface, bricksOf(surface), 1);
    surface.forEach([&](const BrickMesh& mesh) {
      const auto held = map.undercut(mesh.brick);
      for (size_t k = 0; k < mesh.positions.size(); ++k) {
        const Vec3d p = (mesh.brick * kBrickEdge).toVec3d() + mesh.positions[k].cast<double>();
        if (p.head<2>().lpNorm<Eigen::Infinity>() > 28) continue;
        const bool between = p.z() > 10 && p.z() < low + 1;
        EXPECT_EQ(!held.empty() && held[k], between) << p.transpose() << ", " << low;
      }
    });
  }
}

TEST(PullMap, WhatStandsUprightIsFreeAndAnUnevenWallDoesNotHideItself) {
  Surface surface;
  surface.update(block({0.3, 0.4, 0.1}, {40, 30, 50}));
  for (const Vec3d& pull : {Vec3d(0, 0, 1), Vec3d(0, 1, 0), Vec3d(std::sin(0.01), 0, std::cos(0.01)).normalized()}) {
    PullMap map(pull);
    map.follow(surface, bricksOf(surface), 1);
    EXPECT_EQ(count(heldOf(surface, map)), 0u) << pull.transpose();
  }
}

}  // namespace
}  // namespace argil::clay
