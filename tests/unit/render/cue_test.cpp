// Cues for depth: each is there when it is asked for, where it must be, and not otherwise. Tolerances are in levels of
// 255.

#include <numbers>

#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using namespace test;

class Cues : public Picture {
 protected:
  /// A flat slab, ±10 mm wide, its top at z = 2 mm.
  void slab() {
    load([](const Vec3d& p) { return (p.cwiseAbs() - Vec3d(20, 20, 4)).maxCoeff(); });
  }
  static Overlays over(const Vec3d& at) {
    Overlays overlays;
    Cursor& cursor = overlays.cursor.emplace();
    cursor.positionMm = at;
    cursor.radiusMm = 1.5;
    cursor.shaft = Vec3d::UnitZ();
    return overlays;
  }
  static Vec3d at(const View& from, const Vec3d& p) { return from.project(p, kWidth, kHeight); }
  static double green(const Image& image, const View& from, const Vec3d& p) {
    const Vec3d c = colourAround(image, at(from, p), 0);
    return c.y() - 0.5 * (c.x() + c.z());
  }
};

TEST_F(Cues, TheCursorsShadowAndBeamCanBeLeftOut) {
  slab();
  const View top = view("top");
  const View::Axes a = top.axes();
  const Vec3d toKey = (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
  const Vec3d ball(-1, 1, 6), shadow = ball - toKey * ((ball.z() - 2) / toKey.z());
  Look look = kBare;
  const double plain = brightnessAround(draw(top, look), at(top, shadow));
  EXPECT_LT(brightnessAround(draw(top, look, over(ball)), at(top, shadow)), 0.75 * plain);
  look.cursorShadow = false;
  EXPECT_NEAR(brightnessAround(draw(top, look, over(ball)), at(top, shadow)), plain, 2);

  const View front = view("front");
  const auto blue = [&](const Image& image) {
    const Vec3d c = colourAround(image, at(front, {2, 0, 4.2}), 0);
    return c.z() - c.x();
  };
  EXPECT_GT(blue(draw(front, look, over({2, 0, 8}))), 40);
  look.beam = false;
  EXPECT_LT(blue(draw(front, look, over({2, 0, 8}))), 25);
}

TEST_F(Cues, TheBallIsTrueToScale) {
  slab();
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const View from = view("front", projection);
    for (const double y : {-9.0, 9.0}) {
      Overlays overlays = over({0, y, 6});
      overlays.cursor->shaft = Vec3d::UnitZ();
      overlays.cursor->tint = {0.1f, 1.0f, 0.1f, 1};
      Look look = kBare;
      look.beam = look.cursorShadow = false;
      const Image with = draw(from, look, overlays), without = draw(from, look);
      const Vec3d centre = at(from, {0, y, 6});
      int wide = 0;
      for (int x = 0; x < kWidth; ++x)
        wide += std::abs(brightness(with, x, centre.y()) - brightness(without, x, centre.y())) > 6;
      const double distance = (Vec3d(0, y, 6) - from.position).norm();
      const double expected = projection == Projection::perspective
                                  ? 2 * 1.5 / std::sqrt(distance * distance - 1.5 * 1.5) * kHeight /
                                        (from.heightAtTarget() / from.distance())
                                  : 2 * 1.5 * kHeight / from.heightAtTarget();
      EXPECT_NEAR(wide, expected, 1.6) << "at y " << y;
    }
  }
}

TEST_F(Cues, TheFootprintsRingLiesInThePlaneOfItsNormal) {
  slab();
  const View top = view("top");
  Overlays overlays = over({0, 0, 3.5});
  overlays.cursor->radiusMm = 4;
  overlays.cursor->positionMm.z() = 30;  // aside of the ring's picture, and far
  overlays.cursor->shaft = {1, 1, 0.1};
  overlays.cursor->positionMm.x() = -40;
  overlays.cursor->tint = {0.1f, 1.0f, 0.1f, 1};
  Look look = kBare;
  look.beam = look.cursorShadow = false;
  const auto ring = [&](const std::optional<Cursor::Footprint>& print) {
    overlays.cursor->footprint = print;
    const Image image = draw(top, look, overlays);
    int hits = 0;
    for (int i = 0; i < 12; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.3) / 12;
      double most = -255;
      const Vec3d p = at(top, Vec3d(1 + 4 * std::cos(angle), -1 + 4 * std::sin(angle), 2.1));
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Vec3d c = colourAround(image, p + Vec3d(dx, dy, 0), 0);
          most = std::max(most, c.y() - 0.5 * (c.x() + c.z()));
        }
      }
      hits += most > 40;
    }
    return hits;
  };
  EXPECT_EQ(ring(Cursor::Footprint{{1, -1, 2.1}, {0, 0, 5}}), 12);
  EXPECT_LE(ring(Cursor::Footprint{{1, -1, 2.1}, {1, 0, 0}}), 4) << "seen from its edge";
  EXPECT_EQ(ring(std::nullopt), 0);
}

TEST_F(Cues, TheForcesArrowIsAsLongAsTheForceIsGreat) {
  slab();
  const View front = view("front");
  Look look = kBare;
  look.beam = look.cursorShadow = false;
  Overlays overlays = over({0, -12, 5});
  overlays.cursor->shaft = Vec3d::UnitZ();
  const auto reach = [&](double newton) {
    overlays.cursor->forceN = {newton, 0, 0};
    const Image image = draw(front, look, overlays);
    const int y = int(at(front, {0, -12, 5}).y());
    int last = 0;
    for (int x = 0; x < kWidth; ++x) {
      const uint8_t* p = image.pixel(x, y);
      if (p[0] > p[2] + 60 && p[1] > p[2] + 30) last = x;
    }
    return last == 0 ? 0.0 : last - at(front, {1.5, -12, 5}).x();
  };
  EXPECT_EQ(reach(0), 0);
  const double more = reach(1), less = reach(0.5);
  EXPECT_GT(more, 30);
  EXPECT_NEAR(less, 0.5 * more, 2);
}

TEST_F(Cues, ClayShadesItself) {
  // A ball over a slab.
  load([](const Vec3d& p) {
    return std::min(((p - Vec3d(0, 0, -6)).cwiseAbs() - Vec3d(18, 18, 3)).maxCoeff(), (p - Vec3d(-8, 8, 5)).norm() - 5);
  });
  const View top = view("top");
  const View::Axes a = top.axes();
  const Vec3d toKey = (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
  const Vec3d ball = Vec3d(-8, 8, 5) * kVoxel;
  const Vec3d shadow = ball - toKey * ((ball.z() + 3 * kVoxel) / toKey.z());
  Look look = kBare;
  const Image with = draw(top, look);
  look.keyShadow = false;
  const Image without = draw(top, look);
  EXPECT_LT(brightnessAround(with, at(top, shadow)), 0.8 * brightnessAround(without, at(top, shadow)));
  const Vec3d lit = at(top, Vec3d(-14, -10, -3) * kVoxel);
  EXPECT_NEAR(brightnessAround(with, lit), brightnessAround(without, lit), 3);
}

TEST_F(Cues, DepthFadeTakesTheFarTowardsTheBackgroundAndLeavesTheNear) {
  slab();
  View from = view("front", Projection::orthographic);
  from.position += Vec3d(0, 0, 40);  // looking down onto the slab
  from.target.z() = 0;
  Look look = kBare;
  look.keyShadow = false;
  const Image plain = draw(from, look);
  look.depthFade = true;
  look.depthFadeStrength = 0.8;
  const Image faded = draw(from, look);
  look.depthFadeStrength = 0;
  EXPECT_EQ(draw(from, look), plain);
  const View::Axes a = from.axes();
  const auto depth = [&](const Vec3d& p) { return a.forward.dot(p); };
  double nearest = 1e9, farthest = -1e9;
  const Box box = renderer_->bounds();
  for (int corner = 0; corner < 8; ++corner) {
    const double z = depth({(corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                            (corner & 4) ? box.max.z() : box.min.z()});
    nearest = std::min(nearest, z);
    farthest = std::max(farthest, z);
  }
  for (const double y : {-8.0, -4.0, 0.0, 4.0, 8.0}) {
    const Vec3d p(1, y, 2), place = at(from, p);
    const double part = 0.8 * (depth(p) - nearest) / (farthest - nearest);
    // The background at the same height of the picture, where it is bare.
    const Vec3d back = displayLinear(colourAround(plain, {6, place.y(), 0})),
                before = displayLinear(colourAround(plain, place));
    const Vec3d expected = (1 - part) * before + part * back, seen = displayLinear(colourAround(faded, place));
    EXPECT_LT((seen - expected).cwiseAbs().maxCoeff(), 0.015)
        << "at y " << y << ": " << seen.transpose() << ", expected " << expected.transpose();
  }
}

TEST_F(Cues, GuidesShowThroughClayAsTheyAreAskedTo) {
  slab();
  const View front = view("front");
  const Vec3d open(11.5, 12, 0), behind(0.1, 12, -0.8);  // beside the slab and behind it
  Look look = kBare;
  look.keyShadow = false;
  for (const bool filled : {false, true}) {
    const auto drawn = [&](Depth depth, bool xray) {
      Overlays overlays;
      if (filled) {
        overlays.fills.push_back({{{-14, 12, -3}, {14, 12, -3}, {14, 12, 3}, {-14, 12, -3}, {14, 12, 3}, {-14, 12, 3}},
                                  {0, 1, 0, 1},
                                  depth});
      } else {
        overlays.polylines.push_back({{{-14, 12, -0.8}, {14, 12, -0.8}}, {0, 1, 0, 1}, 4, depth});
      }
      look.xray = xray;
      const Image image = draw(front, look, overlays);
      const Vec3d beside = filled ? open : Vec3d(11.5, 12, -0.8);
      EXPECT_GT(green(image, front, beside), 150) << "in full beside the clay";
      return green(image, front, behind);
    };
    const double none = green(draw(front, look), front, behind);
    EXPECT_NEAR(drawn(Depth::hidden, true), none, 3);
    const double faint = drawn(Depth::xray, true);
    EXPECT_GT(faint, none + 20);
    EXPECT_LT(faint, none + 110);
    EXPECT_NEAR(drawn(Depth::xray, false), none, 3);
    EXPECT_GT(drawn(Depth::onTop, true), 150);
  }
}

TEST_F(Cues, ASectionShowsAFlatCapInThePlaneItself) {
  load(sphere());
  const double radius = kRadius * kVoxel, cutAt = -3;
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    const View from = view("front", projection);
    Look look = kBare;
    look.section = Section{{1, cutAt, 2}, {0, -7, 0}};
    Overlays overlays;
    // Before the plane, within the ball that was; behind the plane, within what is left.
    overlays.polylines.push_back({{{-2, cutAt - 1, 2}, {2, cutAt - 1, 2}}, {0, 1, 0, 1}, 4, Depth::hidden});
    overlays.polylines.push_back({{{-2, cutAt + 1, -2}, {2, cutAt + 1, -2}}, {0, 1, 0, 1}, 4, Depth::hidden});
    const Image image = draw(from, look, overlays);
    EXPECT_GT(green(image, from, {0.1, cutAt - 1, 2}), 150);
    EXPECT_LT(green(image, from, {0.1, cutAt + 1, -2}), 20);
    // Flat: one colour wherever it is looked at, up to the cap's rim.
    const double rim = std::sqrt(radius * radius - cutAt * cutAt);
    const Vec3d cap = colourAround(image, at(from, {0, cutAt, 0}));
    for (const double x : {-0.95, -0.5, 0.5, 0.95}) {
      EXPECT_LT((colourAround(image, at(from, {x * rim, cutAt, 0}), 0) - cap).cwiseAbs().maxCoeff(), 3) << x;
    }
    if (projection == Projection::orthographic) {
      EXPECT_GT((colourAround(image, at(from, {1.06 * rim, cutAt, 0}), 0) - cap).norm(), 20)
          << "beyond the rim is the ball";
    }
    look.section->normal = {0, 7, 0};  // the other half: its cap faces away
    const Image other = draw(from, look);
    EXPECT_GT((colourAround(other, at(from, {0, cutAt, 0})) - cap).norm(), 20);
    look.section.reset();
    EXPECT_NEAR(brightnessAround(other, at(from, {0, -radius, 0})),
                brightnessAround(draw(from, look), at(from, {0, -radius, 0})), 3);
  }
}

TEST_F(Cues, WhatASectionCutsAwayThrowsNoShadow) {
  // A roof over a floor.
  load([](const Vec3d& p) {
    return std::min((p.cwiseAbs() - Vec3d(18, 18, 2)).maxCoeff(),
                    ((p - Vec3d(-4, 4, 10)).cwiseAbs() - Vec3d(8, 8, 2)).maxCoeff());
  });
  const View top = view("top");
  Look look = kBare;
  const View::Axes a = top.axes();
  const Vec3d toKey = (-0.50 * a.right + 0.66 * a.up - 0.56 * a.forward).normalized();
  const Vec3d middle = Vec3d(-4, 4, 10) * kVoxel, shadow = middle - toKey * ((middle.z() - 1) / toKey.z());
  const Vec3d open = Vec3d(-15, -15, 2) * kVoxel;
  const Image shaded = draw(top, look);
  EXPECT_LT(brightnessAround(shaded, at(top, shadow)), 0.8 * brightnessAround(shaded, at(top, open)));
  look.section = Section{{0, 0, 3}, {0, 0, 1}};
  const Image cut = draw(top, look);
  EXPECT_NEAR(brightnessAround(cut, at(top, shadow)), brightnessAround(cut, at(top, open)), 6);
}

TEST_F(Cues, CavityFollowsItsStrength) {
  load([](const Vec3d& p) {
    return std::max((p.cwiseAbs() - Vec3d(15, 12, 15)).maxCoeff(), 2.0 - std::hypot(p.y() + 12, p.z()));
  });
  const View from = view("front");
  Look look = kBare;
  look.cavity = true;
  const auto groove = [&](double strength) {
    look.cavityStrength = strength;
    return brightnessAround(draw(from, look), at(from, {2, -5.2, 0}), 1);
  };
  const double none = groove(0), one = groove(1), two = groove(2);
  EXPECT_LT(one, none - 12);
  EXPECT_LT(two, one - 5);
  look.cavity = false;
  EXPECT_NEAR(groove(1), none, 0.5);
}

}  // namespace
}  // namespace argil::render
