// Guides and masks of a document as wishes for quads, and what is said of them.

#include "engine/models/quad_wishes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "clay/field/primitives.h"
#include "clay/store/store.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;

class QuadWishesTest : public testing::Test {
 protected:
  QuadWishesTest() {
    Piece piece;
    clay::Grid grid;
    grid.voxelMm = 0.5;
    piece.version = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 10);
    piece.name = "Ball";
    piece.pose.translation = {30, -4, 5};
    piece.pose.rotation = Eigen::AngleAxisd(0.6, Vec3d(1, 0, 1).normalized());
    document_.add(std::move(piece));
    what_.alongGuides = true;
  }
  // A great circle of the ball where it lies.
  Guide circle() const {
    Guide guide;
    guide.kind = Guide::Kind::curve;
    guide.closed = true;
    for (int i = 0; i < 24; ++i) {
      const double turn = 2 * std::numbers::pi * i / 24;
      guide.pointsMm.push_back(Vec3d(30, -4, 5) + 10 * Vec3d(std::cos(turn), 0, std::sin(turn)));
    }
    return guide;
  }
  std::string wordsOf(const clay::WishesMet& met) const {
    std::string all;
    for (const std::string& each : wishWords(document_, document_.pieces[0], what_, met)) all += each + "|";
    return all;
  }
  Document document_;
  ModelExport what_;
};

TEST_F(QuadWishesTest, CurvesComeToThePiece) {
  document_.add(circle());
  const clay::CageWishes wishes = wishesFor(document_, document_.pieces[0], what_);
  ASSERT_EQ(wishes.guides.size(), 1u);
  EXPECT_GE(wishes.guides[0].size(), 120u);
  for (const Vec3d& p : wishes.guides[0]) EXPECT_NEAR(p.norm(), 10, 0.02);
  // Hidden, open or unasked ones do not.
  document_.guides[0].visible = false;
  EXPECT_TRUE(wishesFor(document_, document_.pieces[0], what_).guides.empty());
  document_.guides[0].visible = true;
  document_.guides[0].closed = false;
  EXPECT_TRUE(wishesFor(document_, document_.pieces[0], what_).guides.empty());
  document_.guides[0].closed = true;
  what_.alongGuides = false;
  EXPECT_TRUE(wishesFor(document_, document_.pieces[0], what_).guides.empty());
}

TEST_F(QuadWishesTest, WhatBecameOfThemIsSaid) {
  EXPECT_EQ(wordsOf({}),
            "Ball: there is no closed curve on its surface, among the guides that are shown, to be "
            "followed.|");
  document_.add(circle());
  EXPECT_EQ(wordsOf({.guides = 1, .guidesMm = 62.8, .onGuidesMm = 61}),
            "Ball: edges follow 97 % of 1 closed curve, 62.8 mm.|");
  document_.add(circle());
  Guide open = circle();
  open.closed = false;
  document_.add(std::move(open));
  EXPECT_EQ(wordsOf({.guides = 1, .guidesMm = 62.8, .onGuidesMm = 61}),
            "Ball: edges follow 97 % of 1 closed curve, 62.8 mm; 1 open curve is not: close it; 1 curve lies off its "
            "surface.|");
  what_.alongGuides = false;
  EXPECT_EQ(wordsOf({}), "");
  what_.maskDensity = 4;
  EXPECT_EQ(wordsOf({.maskDensity = 3.2}), "Ball: where it is masked lie 3.2 times as many quads a mm².|");
  EXPECT_THAT(wordsOf({}), HasSubstr("no part of it is masked"));
}

}  // namespace
}  // namespace argil::engine
