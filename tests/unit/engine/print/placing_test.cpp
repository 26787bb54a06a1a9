// Pieces laid flat, on bases, on beds, and into moulds, as scripts and the studio do it.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/offset.h"
#include "engine/document/beside.h"
#include "engine/print/base.h"
#include "engine/print/lay_flat.h"
#include "engine/print/nest.h"
#include "engine/print/pull_check.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {
namespace {

using ::testing::HasSubstr;

clay::Grid grid(double voxelMm = 0.5) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = {0.1, 0.2, -0.15};
  return grid;
}
haptics::Pose askew(double radians) {
  haptics::Pose pose;
  pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(radians, Vec3d(1, -2, 0.7).normalized()));
  pose.translation = {80, -30, 12};
  return pose;
}
clay::Version block(const Vec3d& size, double voxelMm = 0.5) {
  return clay::makeBlock(clay::Store::make(), grid(voxelMm), {3, 1, -2}, size, 0);
}
Document holding(const clay::Version& version, const haptics::Pose& pose = {}) {
  Document document = Document::of(version);
  document.pieces[0].name = "Thing";
  document.pieces[0].pose = pose;
  return document;
}
Document done(const Document& before, const char* id, const std::function<void(PieceArguments&)>& change,
              std::vector<std::string>* notes = nullptr) {
  const PieceJob& row = *findPieceJob(id);
  PieceArguments arguments = standardArguments(row, before);
  change(arguments);
  const PieceResult result = runPieceJob(row, before, arguments);
  Document after = before;
  applyPieceResult(result, before, after);
  if (notes) *notes = result.notes;
  return after;
}
const auto kAsItIs = [](PieceArguments&) {};

// Places of a piece's surface in the world.
std::vector<Vec3d> placesOf(const Piece& piece) {
  clay::Surface surface(false, clay::Grade::crisp);
  (void)surface.update(piece.version);
  std::vector<Vec3d> places = surface.toMesh().positions;
  for (Vec3d& each : places) each = piece.pose.apply(each);
  return places;
}
Eigen::AlignedBox3d boxOf(const Piece& piece) {
  Eigen::AlignedBox3d box;
  for (const Vec3d& each : placesOf(piece)) box.extend(each);
  return box;
}

// LayFlat

TEST(LayFlat, ABlockLiesOnItsLargestSideHoweverItStood) {
  for (const double radians : {0.0, 0.4, 1.1, 2.6}) {
    const Document before = holding(block({40, 30, 12}), askew(radians));
    std::vector<std::string> notes;
    const Document after = done(before, "lay-flat", kAsItIs, &notes);
    const Eigen::AlignedBox3d was = boxOf(before.pieces[0]), is = boxOf(after.pieces[0]);
    EXPECT_NEAR(is.sizes().z(), 12, 0.1) << radians;
    EXPECT_NEAR(is.min().z(), was.min().z(), 0.05);  // on the ground that it stood on
    // Turned about the middle of its mass.
    const Vec3d middle(3, 1, -2);
    EXPECT_LT((before.pieces[0].pose.apply(middle) - after.pieces[0].pose.apply(middle)).head<2>().norm(), 0.2);
    EXPECT_THAT(notes.at(0), HasSubstr("12 mm high"));
    // Done again nothing moves.
    const Document again = done(after, "lay-flat", kAsItIs);
    EXPECT_LT(again.pieces[0].pose.rotation.angularDistance(after.pieces[0].pose.rotation), 0.01);
    EXPECT_NEAR(boxOf(again.pieces[0]).min().z(), is.min().z(), 0.05);
  }
}

TEST(LayFlat, TellsEveryWayToLieAndWhenItFalls) {
  const Rests rests = restsOf(block({40, 30, 12}), askew(0.8), nullptr);
  ASSERT_EQ(rests.ways.size(), 6u);
  const std::array<std::array<double, 3>, 3> sides{{{40, 30, 12}, {40, 12, 30}, {30, 12, 40}}};
  for (size_t i = 0; i < 6; ++i) {
    const auto& [a, b, high] = sides[i / 2];
    EXPECT_NEAR(rests.ways[i].footMm2 / (a * b), 1, 0.06);
    EXPECT_NEAR(rests.ways[i].heightMm, high, 0.1);
    EXPECT_NEAR(rests.ways[i].tipsDegrees, std::atan2(std::min(a, b) / 2, high / 2) * 180 / std::numbers::pi, 2);
  }
  // A cone lies on its foot or anywhere on its side, but does not stand on its tip.
  const Rests cone = restsOf(clay::makeCone(clay::Store::make(), grid(), Vec3d::Zero(), 15, 0, 40), askew(2), nullptr);
  EXPECT_NEAR(cone.ways.at(0).footMm2 / (std::numbers::pi * 225), 1, 0.05);
  EXPECT_NEAR(cone.ways[0].heightMm, 40, 0.7);
  for (size_t i = 1; i < cone.ways.size(); ++i) EXPECT_LT(cone.ways[i].heightMm, 30);
  EXPECT_THROW((void)restsOf(clay::Version::empty(clay::Store::make(), grid()), {}, nullptr), Error);
}

TEST(LayFlat, WhatIsHeavyBelowDoesNotLieOnItsHead) {
  // A block with a large flat head on a thin, high stem off its middle: it falls over to the side of the head.
  clay::Version clay = block({6, 6, 60});
  clay = clay::combine(clay, clay::makeBlock(clay::Store::make(), grid(), {23, 1, 26}, {40, 6, 6}, 0),
                       clay::Combination::join);
  for (const Rest& rest : restsOf(clay, {}, nullptr).ways) EXPECT_GE(rest.tipsDegrees, 0);
  // Its stem's foot alone holds the middle of nothing.
  const Rests rests = restsOf(clay, {}, nullptr);
  EXPECT_TRUE(std::none_of(rests.ways.begin(), rests.ways.end(), [](const Rest& each) {
    return each.turn.angularDistance(Eigen::Quaterniond::Identity()) < 0.05;
  }));
}

// A body rests where the height of its middle over the bed is least of all directions near by: looked for by
// directions.
TEST(LayFlat, FindsEveryLeastHeightOfTheMiddle) {
  const clay::Grid voxels = grid();
  clay::Version clay = clay::makeSphere(clay::Store::make(), voxels, Vec3d::Zero(), 9);
  for (const Vec3d& at : {Vec3d(14, 2, 1), Vec3d(-9, 11, -3), Vec3d(-4, -13, 6), Vec3d(3, 1, -15), Vec3d(5, 6, 13)})
    clay = clay::combine(clay, clay::makeSphere(clay::Store::make(), voxels, at, 4), clay::Combination::join);
  const Rests rests = restsOf(clay, {}, nullptr);
  const std::vector<Vec3d> places = placesOf(holding(clay).pieces[0]);
  const auto height = [&](const Vec3d& up) {
    double low = INFINITY;
    for (size_t i = 0; i < places.size(); i += 2) low = std::min(low, (places[i] - rests.middleMm).dot(up));
    return -low;
  };
  std::vector<std::pair<Vec3d, double>> all;
  constexpr int kDirections = 12000;  // a degree and a half apart: a ridge between two rests falls off more within nine
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2.0 * i + 1) / kDirections, r = std::sqrt(1 - z * z), turn = 2.399963 * i;
    const Vec3d up(r * std::cos(turn), r * std::sin(turn), z);
    all.emplace_back(up, height(up));
  }
  const double near = std::cos(9 * std::numbers::pi / 180);
  size_t least = 0;
  for (const auto& [up, high] : all) {
    if (std::any_of(all.begin(), all.end(), [&, up = up, high = high](const auto& each) {
          return each.first.dot(up) > near && each.second < high;
        }))
      continue;
    ++least;
    EXPECT_TRUE(std::any_of(rests.ways.begin(), rests.ways.end(), [&, up = up](const Rest& each) {
      return (each.turn.conjugate() * Vec3d::UnitZ()).dot(up) > near;
    })) << up.transpose();
  }
  EXPECT_GE(least, 4u);
  for (const Rest& each : rests.ways) {
    const Vec3d up = each.turn.conjugate() * Vec3d::UnitZ();
    for (const auto& [other, high] : all)
      if (other.dot(up) > std::cos(4 * std::numbers::pi / 180)) {
        EXPECT_GT(high, height(up) - 0.1);
      }
  }
}

// Base

TEST(Base, IsUprightInTheWorldAndHoldsThePiece) {
  const Document before = holding(clay::makeSphere(clay::Store::make(), grid(), {3, 1, -2}, 10), askew(1.3));
  const double low = boxOf(before.pieces[0]).min().z();
  for (const bool square : {false, true}) {
    const Document after = done(before, "base", [&](PieceArguments& a) {
      a.change<BaseValues>() = {.square = square, .heightMm = 6, .marginMm = 4, .sunkMm = 2};
    });
    const Eigen::AlignedBox3d box = boxOf(after.pieces[0]);
    EXPECT_NEAR(box.min().z(), low - 4, 0.1);
    EXPECT_NEAR(box.sizes().x(), 28, 0.2);
    EXPECT_NEAR(box.sizes().y(), 28, 0.2);
    // Flat below: everything of its underside within the rim stands at one height.
    const Vec3d centre = box.center();
    size_t below = 0;
    for (const Vec3d& each : placesOf(after.pieces[0]))
      if (std::hypot(each.x() - centre.x(), each.y() - centre.y()) < 12 && each.z() < low - 3) {
        EXPECT_NEAR(each.z(), low - 4, 0.06);
        ++below;
      }
    EXPECT_GT(below, 1000u);
    // The corners of a square one are there, those of a round one are not.
    clay::Sampler clay(after.pieces[0].version);
    const Vec3d corner(centre.x() + 12.5, centre.y() + 12.5, low - 1);
    EXPECT_EQ(clay.trilinear(grid().toVoxel(after.pieces[0].pose.applyInverse(corner))) < 0, square);
  }
}

TEST(Base, HasAsManyDotsAsAskedForAndSaysWhatIsOutOfRange) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), grid(0.25), Vec3d::Zero(), 10);
  for (const int dots : {1, 4, 9}) {
    const clay::Version based = withBase(ball, {}, {.heightMm = 4, .dots = dots}, nullptr);
    // Bodies of air in a layer just above the underside.
    clay::Sampler clay(based);
    const double z = -10 + 1 - 4 + 0.5;
    std::vector<Eigen::Vector2d> found;
    for (double x = -11; x < 11; x += 0.25)
      for (double y = -11; y < 11; y += 0.25) {
        if (std::hypot(x, y) > 11 || clay.trilinear(grid(0.25).toVoxel({x, y, z})) < 0) continue;
        if (std::none_of(found.begin(), found.end(),
                         [&](const Eigen::Vector2d& each) { return (each - Eigen::Vector2d(x, y)).norm() < 2.6; }))
          found.emplace_back(x, y);
      }
    EXPECT_EQ(found.size(), size_t(dots));
  }
  const auto refuses = [&](const BaseOptions& options) {
    EXPECT_THROW((void)withBase(ball, {}, options, nullptr), Error);
  };
  refuses({.heightMm = 0.5});
  refuses({.heightMm = NAN});
  refuses({.marginMm = -1});
  refuses({.heightMm = 5, .sunkMm = 5});
  refuses({.dots = 10});
  refuses({.heightMm = 60, .dots = 9});  // as large as the base
}

// Nest

std::vector<Vec2d> rectangle(double width, double depth) {
  std::vector<Vec2d> places;
  for (double x = 0; x <= width; x += 0.25)
    for (double y = 0; y <= depth; y += 0.25) places.emplace_back(x, y);
  return places;
}
std::vector<Vec2d> ring(double inner, double outer) {
  std::vector<Vec2d> places;
  for (double x = -outer; x <= outer; x += 0.25)
    for (double y = -outer; y <= outer; y += 0.25)
      if (const double r = std::hypot(x, y); r >= inner && r <= outer) places.emplace_back(x, y);
  return places;
}
std::vector<Vec2d> laid(const std::vector<Vec2d>& footprint, const Nested& at) {
  std::vector<Vec2d> places;
  for (const Vec2d& each : footprint) places.emplace_back(Eigen::Rotation2Dd(at.turn) * each + at.moveMm);
  return places;
}
double nearestOf(const std::vector<Vec2d>& a, const std::vector<Vec2d>& b) {
  double least = INFINITY;
  for (size_t i = 0; i < a.size(); i += 3)
    for (size_t j = 0; j < b.size(); j += 3) least = std::min(least, (a[i] - b[j]).norm());
  return least;
}

TEST(Nest, KeepsTheGapAndTheBedAndTakesAnotherBedWhereOneIsFull) {
  std::vector<std::vector<Vec2d>> footprints;
  for (int i = 0; i < 14; ++i) footprints.push_back(i % 3 == 0 ? ring(0, 6 + i / 2.0) : rectangle(8 + i, 20 - i));
  NestOptions options{.bedMm = {60, 50}, .gapMm = 2};
  const std::vector<Nested> nested = nest(footprints, options, clay::WorkPart(nullptr));
  int beds = 0;
  std::vector<std::vector<Vec2d>> places;
  for (size_t i = 0; i < footprints.size(); ++i) {
    places.push_back(laid(footprints[i], nested[i]));
    beds = std::max(beds, nested[i].bed + 1);
    for (const Vec2d& each : places[i]) {
      EXPECT_GE(each.minCoeff(), -1e-9);
      EXPECT_LE(each.x(), 60 + 1e-9);
      EXPECT_LE(each.y(), 50 + 1e-9);
    }
    for (size_t j = 0; j < i; ++j)
      if (nested[i].bed == nested[j].bed) {
        EXPECT_GE(nearestOf(places[i], places[j]), 2 - 0.5) << i << " " << j;
      }
  }
  EXPECT_GE(beds, 2);
}

TEST(Nest, IsAsCloseAsCanBe) {
  const auto onFirst = [](const std::vector<Vec2d>& footprint, size_t count, const NestOptions& options) {
    const std::vector<std::vector<Vec2d>> many(count, footprint);
    size_t first = 0;
    for (const Nested& each : nest(many, options, clay::WorkPart(nullptr))) first += each.bed == 0;
    return first;
  };
  // Rows and columns of squares; disks in hexagons, of which rows and columns would have 20; one within another.
  EXPECT_EQ(onFirst(rectangle(20, 20), 40, {.bedMm = {111, 88}, .gapMm = 2, .turns = 1}), 20u);
  EXPECT_GE(onFirst(ring(0, 20), 40, {.bedMm = {250, 210}, .gapMm = 3, .turns = 1}), 23u);
  const std::vector<std::vector<Vec2d>> two{ring(12, 20), ring(0, 8)};
  const std::vector<Nested> nested = nest(two, {.bedMm = {41, 41}, .gapMm = 2}, clay::WorkPart(nullptr));
  EXPECT_EQ(nested[0].bed, nested[1].bed);
  // Of all turns the one that lies lowest.
  const std::vector<std::vector<Vec2d>> bar{rectangle(8, 40)};
  for (const Vec2d& each : laid(bar[0], nest(bar, {.bedMm = {60, 60}, .turns = 4}, clay::WorkPart(nullptr))[0]))
    EXPECT_LT(each.y(), 8.6);
  // A turn finds room where there is none without.
  EXPECT_EQ(onFirst(rectangle(50, 8), 1, {.bedMm = {10, 60}, .turns = 4}), 1u);
  EXPECT_THROW((void)onFirst(rectangle(50, 8), 1, {.bedMm = {10, 60}, .turns = 1}), LargerThanBed);
  for (const NestOptions& wrong :
       {NestOptions{.bedMm = {0, 60}}, NestOptions{.gapMm = -1}, NestOptions{.gapMm = NAN}, NestOptions{.turns = 0}})
    EXPECT_THROW((void)onFirst(rectangle(5, 8), 1, wrong), Error);
}

TEST(Nest, LaysTheVisiblePiecesOfADocumentOnOneGround) {
  Document before = holding(block({40, 30, 12}), askew(0.5));
  for (int i = 0; i < 5; ++i) {
    Piece piece;
    piece.version =
        i % 2 == 0 ? block({20, 20, 20}, 1) : clay::makeSphere(clay::Store::make(), grid(1), Vec3d::Zero(), 9);
    piece.pose = askew(0.3 * i);
    piece.visible = i != 3;
    piece.locked = i == 4;
    before.add(piece);
  }
  std::vector<std::string> notes;
  const Document after = done(
      before, "nest", [](PieceArguments& a) { a.change<NestValues>().gapMm = 4; }, &notes);
  EXPECT_EQ(notes.at(0), "4 pieces on 1 bed.");
  std::vector<Eigen::AlignedBox3d> boxes;
  for (size_t i = 0; i < before.pieces.size(); ++i) {
    const Piece &was = before.pieces[i], &is = after.pieces[i];
    EXPECT_EQ(is.version, was.version);
    if (!was.visible || was.locked) {
      EXPECT_EQ(is.pose.translation, was.pose.translation);
      continue;
    }
    boxes.push_back(boxOf(is));
    EXPECT_NEAR(boxes.back().min().z(), boxes.front().min().z(), 1e-6);
    // Turned about the vertical alone.
    EXPECT_NEAR((is.pose.rotation * was.pose.rotation.conjugate() * Vec3d::UnitZ()).z(), 1, 1e-9);
  }
  for (size_t i = 0; i < before.pieces.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const Piece &a = after.pieces[i], &b = after.pieces[j];
      if (!a.visible || a.locked || !b.visible || b.locked) continue;
      std::vector<Vec2d> one, other;
      for (const Vec3d& each : placesOf(a)) one.emplace_back(each.head<2>());
      for (const Vec3d& each : placesOf(b)) other.emplace_back(each.head<2>());
      EXPECT_GE(nearestOf(one, other), 4 - 1.6);
    }
  EXPECT_THROW((void)done(before, "nest", [](PieceArguments& a) { a.change<NestValues>().widthMm = 20; }), Error);
}

// MouldJob

TEST(MouldJob, HalvesLieOnTheirBacksBesideThePieceAndTellWhatIsUndercut) {
  const clay::Version ball = clay::makeSphere(clay::Store::make(), grid(), {3, 1, -2}, 12);
  const clay::Version bored = clay::combine(
      ball, clay::makeRod(clay::Store::make(), grid(), {3, -20, -2}, {3, 20, -2}, 4), clay::Combination::cut);
  const Document before = holding(bored, askew(0.9));
  std::vector<std::string> notes;
  // Along the world's z the bore is askew; along the best way it is not.
  const Document across = done(
      before, "mould", [](PieceArguments& a) { a.change<MouldValues>().pull = 3; }, &notes);
  ASSERT_EQ(across.pieces.size(), 3u);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_THAT(notes[0], HasSubstr("pulled along 0.00, 0.00, 1.00; 4 keys, 1 sprue"));
  EXPECT_THAT(notes[1], HasSubstr("are undercut"));
  EXPECT_EQ(across.pieces[0].version, before.pieces[0].version);
  EXPECT_EQ(across.pieces[1].name, "Thing, mould below");
  EXPECT_EQ(across.pieces[2].name, "Thing, mould above");
  const clay::BoxMm box = boundsOf(before);
  for (size_t i = 1; i < 3; ++i) {
    // On its back: what is below is the block's flat face.
    const Eigen::AlignedBox3d half = boxOf(across.pieces[i]);
    EXPECT_GT(half.min().x(), box.high.x());
    EXPECT_NEAR(half.sizes().x(), 40, 1.5);
    size_t low = 0;
    for (const Vec3d& each : placesOf(across.pieces[i])) low += each.z() < half.min().z() + 0.1;
    EXPECT_GT(double(low) * 0.25, 0.8 * 39 * 39);
  }
  const Document along = done(before, "mould", kAsItIs, &notes);
  const Vec3d bore = before.pieces[0].pose.rotation * Vec3d::UnitY();
  Vec3d pulled;
  ASSERT_EQ(std::sscanf(notes[0].c_str(), "Thing: pulled along %lf, %lf, %lf;", &pulled.x(), &pulled.y(), &pulled.z()),
            3);
  EXPECT_GT(std::abs(pulled.dot(bore)), 0.995);
  EXPECT_EQ(notes.size(), 1u) << notes.back();
}

TEST(PullCheck, ListsUndercutsTheLargestFirst) {
  clay::Version clay = block({60, 30, 30});
  for (const auto& [x, radius] : {std::pair{-15.0, 3.0}, {15.0, 6.0}})
    clay = clay::combine(clay, clay::makeRod(clay::Store::make(), grid(), {x, -30, -2}, {x, 5, -2}, radius),
                         clay::Combination::cut);
  clay::Surface surface(false);
  (void)surface.update(clay, 2);
  const clay::TriangleMesh mesh = surface.toMesh();
  const PullReport down = checkPull(mesh, 0.05, Vec3d::UnitZ(), 2, nullptr);
  ASSERT_EQ(down.undercuts.size(), 2u);
  EXPECT_GT(down.undercuts[0].areaMm2, 1.5 * down.undercuts[1].areaMm2);
  EXPECT_NEAR(down.undercuts[0].atMm.x(), 15, 7);
  EXPECT_NEAR(down.undercuts[1].atMm.x(), -15, 4);
  EXPECT_NEAR(down.undercuts[0].areaMm2 + down.undercuts[1].areaMm2, down.undercutMm2, 0.02 * down.undercutMm2);
  // What is small beside the unevenness is not listed.
  EXPECT_EQ(checkPull(mesh, 2.4, Vec3d::UnitZ(), 2, nullptr).undercuts.size(), 1u);
  // Along the bores nothing is, and the best pull finds that.
  const PullReport best = checkPull(mesh, 0.05, std::nullopt, 2, nullptr);
  EXPECT_GT(std::abs(best.pull.y()), 0.99);
  EXPECT_LT(best.undercutMm2, 0.002 * best.areaMm2);
  EXPECT_GT(best.steepMm2, 0.4 * best.areaMm2);  // its walls stand upright
  EXPECT_THROW((void)checkPull({}, 0.05, std::nullopt, 2, nullptr), Error);
  EXPECT_THROW((void)checkPull(mesh, 0.05, std::nullopt, NAN, nullptr), Error);
}

}  // namespace
}  // namespace argil::engine
