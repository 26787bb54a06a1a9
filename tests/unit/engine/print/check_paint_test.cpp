// Thin walls, narrow gaps and too little draft as colours: as a picture has them after every stroke, beside a fresh
// measure of the clay.

#include "engine/print/check_paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/vertex_channels.h"
#include "clay/whole/boolean.h"
#include "engine/session/surfaces.h"

namespace argil::engine {
namespace {

using clay::Combination;
using clay::Version;

constexpr double kVoxel = 0.25;

Version block(const Vec3d& middle, const Vec3d& edges) {
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  return clay::makeBlock(clay::Store::make(), grid, middle, edges, 0);
}

// What a renderer has.
class Painted {
 public:
  void take(Surfaces& surfaces) {
    for (const SurfaceChange& change : surfaces.take().pieces) {
      if (change.whole || change.removed) bricks_.clear(), paint_.clear();
      for (const clay::BrickMeshPtr& mesh : change.delta.changed) {
        const auto was = bricks_.find(mesh->brick);
        // Other vertices have nothing set until it is said.
        if (was == bricks_.end() || was->second->vertexSerial != mesh->vertexSerial) paint_.erase(mesh->brick);
        bricks_[mesh->brick] = mesh;
      }
      for (const auto& paint : change.delta.painted) {
        paint_[paint->brick] = paint->vertices;
        ++said;
      }
    }
  }
  [[nodiscard]] size_t covered() const {
    size_t count = 0;
    for (const auto& [brick, vertices] : paint_)
      for (const clay::VertexPaint& each : vertices) count += each.cover > 0;
    return count;
  }
  [[nodiscard]] size_t greens() const {
    size_t count = 0;
    for (const auto& [brick, vertices] : paint_)
      for (const clay::VertexPaint& each : vertices) count += each.cover > 0 && each.green > each.red;
    return count;
  }
  [[nodiscard]] size_t magentas() const {
    size_t count = 0;
    for (const auto& [brick, vertices] : paint_)
      for (const clay::VertexPaint& each : vertices)
        count += each.cover > 0 && each.red > 200 && each.green < 60 && each.blue > 100;
    return count;
  }
  // Beside a fresh measure; of how many vertices something is thin.
  size_t expectAsFresh(const Version& version, const CheckLimits& limits) const {
    clay::Surface surface;
    clay::WallMap map(limits.wallMm / kVoxel, limits.gapMm / kVoxel);
    map.follow(surface.update(version), 1);
    size_t thin = 0;
    surface.forEach([&](const clay::BrickMesh& mesh) {
      const auto walls = map.sizes(mesh.brick, clay::SideOf::wall), gaps = map.sizes(mesh.brick, clay::SideOf::gap);
      const auto found = paint_.find(mesh.brick);
      for (size_t i = 0; i < walls.size(); ++i) {
        const bool isThin = std::isfinite(walls[i]) || std::isfinite(gaps[i]);
        thin += isThin;
        const bool shown = found != paint_.end() && i < found->second.size() && found->second[i].cover == 255;
        ASSERT_EQ(shown, isThin) << mesh.brick.x << " " << mesh.brick.y << " " << mesh.brick.z << " " << i;
        if (std::isfinite(walls[i])) {
          EXPECT_GT(found->second[i].red, 200);
        }
      }
    });
    return thin;
  }
  size_t said = 0;

 private:
  std::map<Coord, clay::BrickMeshPtr> bricks_;
  std::map<Coord, std::vector<clay::VertexPaint>> paint_;
};

TEST(CheckPaint, FollowsEveryStrokeAndGoesWhenItIsSwitchedOff) {
  const CheckLimits limits{1, 0.6};
  Document document;
  Piece piece;
  piece.version = clay::combine(block({0, 0, 2}, {30, 20, 4}), block({5, 0, 9}, {1.5, 20, 12}), Combination::join);
  document.add(std::move(piece));
  Surfaces surfaces;
  Painted picture;
  surfaces.follow(document, 0);
  picture.take(surfaces);
  EXPECT_EQ(picture.said, 0u) << "nothing is measured where nobody asks";
  surfaces.setChecks(limits);
  surfaces.follow(document, 0);
  picture.take(surfaces);
  EXPECT_EQ(picture.expectAsFresh(document.pieces[0].version, limits), 0u);
  size_t most = 0;
  for (int i = 0; i < 12; ++i) {
    // Along the wall's face, deeper and deeper.
    clay::BrushStroke stroke(document.pieces[0].version,
                             clay::Brush::of(i % 4 == 3 ? clay::Method::add : clay::Method::carve));
    const Vec3d at = document.pieces[0].version.grid().toVoxel(Vec3d(5.75 + 2 - 0.05 * i, -8 + 1.3 * i, 9));
    stroke.apply({at, at + Vec3d(0, 4, 0), 10, 1});
    document.pieces[0].version = stroke.finish();
    surfaces.follow(document, 1 + i % 2);
    picture.take(surfaces);
    most = std::max(most, picture.expectAsFresh(document.pieces[0].version, limits));
  }
  EXPECT_GT(most, 100u);
  EXPECT_GT(picture.covered(), 0u);
  surfaces.setChecks(std::nullopt);
  surfaces.follow(document, 0);
  picture.take(surfaces);
  EXPECT_EQ(picture.covered(), 0u);
}

// Faces of a block along the pull, and of a stroke in it; as the piece is turned, and only then.
TEST(CheckPaint, FacesWithTooLittleDraftAreShownHoweverAPieceIsTurned) {
  Document document;
  Piece piece;
  piece.version = block({0, 0, 0}, {20, 14, 8});
  document.add(std::move(piece));
  Surfaces surfaces;
  Painted picture;
  surfaces.setChecks(CheckLimits{0, 0, DraftLimit{Vec3d::UnitZ(), 5}});
  const auto expected = [&](const Vec3d& pull) {
    clay::Surface surface;
    surface.update(document.pieces[0].version);
    std::vector<Coord> bricks;
    surface.forEach([&](const clay::BrickMesh& mesh) { bricks.push_back(mesh.brick); });
    clay::PullMap map(pull);
    map.follow(surface, bricks, 1);
    size_t count = 0;
    surface.forEach([&](const clay::BrickMesh& mesh) {
      const auto held = map.undercut(mesh.brick);
      for (size_t i = 0; i < mesh.normals.size(); ++i)
        count += (!held.empty() && held[i]) ||
                 std::abs(mesh.normals[i].unpack().cast<double>().dot(pull)) < std::sin(5 * std::numbers::pi / 180);
    });
    return count;
  };
  const auto follow = [&] {
    surfaces.follow(document, 0);
    picture.take(surfaces);
    return picture.covered();
  };
  const size_t sides = follow();
  EXPECT_EQ(sides, expected(Vec3d::UnitZ()));
  EXPECT_GT(sides, 4000u);
  EXPECT_EQ(picture.greens(), sides);
  // A cut with steep walls.
  clay::BrushStroke stroke(document.pieces[0].version, clay::Brush::of(clay::Method::carve));
  const Vec3d at = document.pieces[0].version.grid().toVoxel(Vec3d(3, 2, 3));
  stroke.apply({at, at + Vec3d(0, 0, 30), 8, 1});
  document.pieces[0].version = stroke.finish();
  EXPECT_EQ(follow(), expected(Vec3d::UnitZ()));
  EXPECT_NE(picture.covered(), sides);
  document.pieces[0].pose.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitY());
  EXPECT_EQ(follow(), expected(Vec3d::UnitX()));
  const size_t said = picture.said;
  follow();
  document.pieces[0].pose.translation = Vec3d(3, 4, 5);
  follow();
  EXPECT_EQ(picture.said, said) << "what was not turned shows the same";
  // Walls come before draft: those of 8 mm that stand along the pull are red, those of 14 mm stay green.
  const size_t before = picture.covered();
  surfaces.setChecks(CheckLimits{10, 0, DraftLimit{Vec3d::UnitZ(), 5}});
  EXPECT_GE(follow(), before);
  EXPECT_GT(picture.greens(), before / 10);
  EXPECT_LT(picture.greens(), before / 2);
  surfaces.setChecks(std::nullopt);
  EXPECT_EQ(follow(), 0u);
}

// A groove along a side is undercut from above, and free from that side.
TEST(CheckPaint, UndercutsAreMagentaAsThePieceLies) {
  Document document;
  Piece piece;
  piece.version = block({0, 0, 0}, {20, 14, 8});
  document.add(std::move(piece));
  Surfaces surfaces;
  Painted picture;
  surfaces.setChecks(CheckLimits{0, 0, DraftLimit{Vec3d::UnitZ(), 5}});
  const auto follow = [&] {
    surfaces.follow(document, 0);
    picture.take(surfaces);
    return picture.magentas();
  };
  EXPECT_EQ(follow(), 0u);
  const Version before = document.pieces[0].version;
  clay::BrushStroke stroke(before, clay::Brush::of(clay::Method::carve));
  const Vec3d at = before.grid().toVoxel(Vec3d(10, -4, 0));
  stroke.apply({at, at + Vec3d(0, 32, 0), 8, 1});
  document.pieces[0].version = stroke.finish();
  // Its roof and its floor hide each other: a half tube of 2 mm, 8 mm long, and a quarter of a ball at both ends. The
  // flattest faces have a vertex for each square of a voxel, the steepest √3.
  const double squares = (3.14 * 2 * 8 + 3.14 * 2 * 2) / (kVoxel * kVoxel);
  const size_t held = follow();
  EXPECT_GT(double(held), squares);
  EXPECT_LT(double(held), 1.73 * squares);
  document.pieces[0].pose.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitY());
  EXPECT_EQ(follow(), 0u);
  document.pieces[0].pose.rotation = Eigen::Quaterniond::Identity();
  EXPECT_GT(follow(), 500u);
  document.pieces[0].version = before;
  EXPECT_EQ(follow(), 0u);
}

TEST(CheckPaint, WhatIsPaintedComesBackWhereItIsThinNoMore) {
  const CheckLimits limits{1, 0};
  auto brush = std::make_shared<clay::Brush>();
  brush->operations = {{clay::Property::colour, clay::Method::set}};
  brush->colour = {10, 20, 30};
  clay::BrushStroke painting(block({0, 0, 0}, {12, 12, 0.75}), brush);
  painting.apply({Vec3d(0, 0, 0), Vec3d(10, 0, 0), 12, 1});
  Version version = painting.finish();
  clay::Surface surface;
  CheckPaint paint(limits);
  clay::SurfaceDelta delta = surface.update(version);
  paint.follow(surface, delta, 1);
  size_t thin = 0, own = 0;
  const auto count = [&] {
    for (const auto& each : delta.painted)
      for (const clay::VertexPaint& vertex : each->vertices) {
        thin += vertex.red > 200;
        own += vertex.red == 10 && vertex.green == 20;
      }
  };
  count();
  EXPECT_GT(thin, 1000u);
  EXPECT_EQ(own, 0u) << "all of the plate is thin but its rim, which is not painted";
  // Thick all over: every brick that was coloured is said again, with its own colours.
  clay::BrushStroke thicker(version, clay::Brush::of(clay::Method::add));
  for (int x = -30; x <= 30; x += 3)
    for (int y = -30; y <= 30; y += 3) thicker.apply({Vec3d(x, y, 3), Vec3d(x, y, 3), 7, 1});
  version = thicker.finish();
  delta = surface.update(version);
  paint.follow(surface, delta, 1);
  thin = own = 0;
  count();
  EXPECT_EQ(thin, 0u);
  EXPECT_GT(own, 100u);
}

}  // namespace
}  // namespace argil::engine
