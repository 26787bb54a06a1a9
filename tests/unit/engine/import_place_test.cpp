// How a model that was read stands in the world, where its file does not say it.

#include "engine/models/import_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "clay/field/primitives.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "engine/document/beside.h"

namespace argil::engine {
namespace {

// A pyramid on the ground, whose tip points along an axis of the file, its size in any unit.
std::shared_ptr<io::ModelFile> pyramid(int tip, double size) {
  auto model = std::make_shared<io::ModelFile>();
  io::ModelObject& object = model->objects.emplace_back();
  const int u = (tip + 1) % 3, v = (tip + 2) % 3;
  for (int i = 0; i < 4; ++i) {
    Vec3d corner = Vec3d::Zero();
    corner[u] = i == 1 || i == 2 ? size : -size;
    corner[v] = i >= 2 ? size : -size;
    object.mesh.positions.push_back(corner);
  }
  Vec3d top = Vec3d::Zero();
  top[tip] = 3 * size;
  object.mesh.positions.push_back(top);
  object.mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return model;
}

// The base tells, against what is usual for the kind of file, in whatever unit the file is.
TEST(ImportPlace, StandsOnItsBaseWhateverItsUnit) {
  for (const double size : {1e-4, 1.0, 1e4}) {
    for (const char* file : {"a.stl", "a.obj"}) {
      EXPECT_EQ(lookAtModel(pyramid(2, size), file).up, UpAxis::z) << file << " " << size;
      EXPECT_EQ(lookAtModel(pyramid(1, size), file).up, UpAxis::y) << file << " " << size;
    }
    // Neither axis has a base: as is usual.
    EXPECT_EQ(lookAtModel(pyramid(0, size), "a.stl").up, UpAxis::z) << size;
    EXPECT_EQ(lookAtModel(pyramid(0, size), "a.obj").up, UpAxis::y) << size;
  }
}

clay::Version ball(double radiusMm, const Vec3d& at) {
  clay::Grid grid;
  grid.voxelMm = 1;
  return clay::makeSphere(clay::Store::make(), grid, at, radiusMm);
}

Piece pieceOf(const clay::Version& version) {
  Piece piece;
  piece.version = version;
  return piece;
}

TEST(Beside, APieceOfOneBrickTakesRoomAndOneWithoutClayNone) {
  clay::Editor editor(clay::Version::empty(clay::Store::make(), clay::Grid{.voxelMm = 1}));
  std::array<float, clay::kBrickVoxels> phi;
  for (int v = 0; v < clay::kBrickVoxels; ++v)
    phi[size_t(v)] = std::min(3.0f, float((Vec3d(v >> 6, (v >> 3) & 7, v & 7) - Vec3d(4, 4, 4)).norm()) - 1.5f);
  editor.setVoxels({0, 0, 0}, phi);
  const clay::Version small = editor.commit();
  ASSERT_EQ(small.stats().bricks, 1u);
  const clay::BoxMm box = boundsOf(pieceOf(small));
  EXPECT_LT(box.low.x(), 4);
  EXPECT_GT(box.high.x(), 4);
  Document document;
  document.add(pieceOf(ball(5, {100, 0, 0})));
  const clay::BoxMm before = boundsOf(document);
  document.add(pieceOf(clay::Version::empty(clay::Store::make(), small.grid())));
  EXPECT_EQ(boundsOf(document).low, before.low);
  EXPECT_EQ(boundsOf(document).high, before.high);
}

// A sheet that stands across has no width: it is something to be beside all the same.
TEST(Beside, WhatIsFlatIsPassedToo) {
  auto sheet = std::make_shared<clay::TriangleMesh>();
  sheet->positions = {{3, 0, 0}, {3, 10, 0}, {3, 0, 10}};
  sheet->triangles = {{0, 1, 2}};
  Part part;
  part.mesh = sheet;
  Document document;
  document.add(part);
  const clay::BoxMm box{{-2, -2, -2}, {2, 2, 2}};
  const Vec3d move = moveBeside(document, box);
  EXPECT_GT(box.low.x() + move.x(), 3);
  EXPECT_NEAR(move.y(), 5, 0.01);
  Document balls;
  balls.add(pieceOf(ball(5, {0, 0, 0})));
  EXPECT_NEAR(moveBeside(balls, {{0, -5, -5}, {0, 5, 5}}).x(), 5, 0.1);
}

}  // namespace
}  // namespace argil::engine
