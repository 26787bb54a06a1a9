#include "render/view/view.h"

#include <gtest/gtest.h>

#include <limits>

#include "clay/base/error.h"
#include "render/view/lettering.h"
#include "render/view/scale.h"

namespace argil::render {
namespace {

Box box(const Vec3d& min, const Vec3d& max) {
  Box result;
  result.add(min);
  result.add(max);
  return result;
}

TEST(View, FitShowsTheWholeBoxAndFillsThePicture) {
  const Box bounds = box({1e6 - 30, -20, 5}, {1e6 + 30, 25, 90});
  for (const std::string& name : View::names()) {
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      for (const double aspect : {16.0 / 9, 1.0, 0.5}) {
        const int height = 1000, width = int(height * aspect);
        const View view = View::named(name, bounds, aspect, projection);
        double most = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3d p((corner & 1) ? bounds.max.x() : bounds.min.x(), (corner & 2) ? bounds.max.y() : bounds.min.y(),
                        (corner & 4) ? bounds.max.z() : bounds.min.z());
          const Vec3d at = view.project(p, width, height);
          EXPECT_TRUE(projection == Projection::orthographic || at.z() > 0);
          most = std::max({most, std::abs(2 * at.x() / width - 1), std::abs(2 * at.y() / height - 1)});
        }
        EXPECT_NEAR(most, 0.9, 1e-6) << name << " " << aspect;
      }
    }
  }
}

TEST(View, NamedViewsLookWhereTheyShould) {
  const Box bounds = box({-10, -10, -10}, {10, 10, 10});
  const auto axes = [&](const char* name) { return View::named(name, bounds, 1).axes(); };
  EXPECT_TRUE(axes("front").forward.isApprox(Vec3d::UnitY()));
  EXPECT_TRUE(axes("front").right.isApprox(Vec3d::UnitX()));
  EXPECT_TRUE(axes("back").right.isApprox(-Vec3d::UnitX()));
  EXPECT_TRUE(axes("left").forward.isApprox(Vec3d::UnitX()));
  EXPECT_TRUE(axes("right").forward.isApprox(-Vec3d::UnitX()));
  EXPECT_TRUE(axes("top").forward.isApprox(-Vec3d::UnitZ()));
  EXPECT_TRUE(axes("top").right.isApprox(Vec3d::UnitX()));
  EXPECT_TRUE(axes("bottom").right.isApprox(Vec3d::UnitX()));
  EXPECT_GT(axes("iso").forward.y(), 0);
  EXPECT_LT(axes("iso").forward.z(), 0);
}

TEST(View, RevolvesAboutTheUprightAxisThroughItsTarget) {
  const Box bounds = box({-10, 5, -10}, {10, 25, 10});
  const View front = View::named("front", bounds, 1);
  const View quarter = front.revolved(90), whole = front.revolved(360);
  EXPECT_TRUE(quarter.axes().forward.isApprox(-Vec3d::UnitX()));  // from the right
  EXPECT_TRUE(quarter.axes().up.isApprox(Vec3d::UnitZ()));
  EXPECT_NEAR(quarter.distance(), front.distance(), 1e-9);
  EXPECT_EQ(quarter.target, front.target);
  EXPECT_TRUE(whole.position.isApprox(front.position));
  const View top = View::named("top", bounds, 1).revolved(90);
  EXPECT_TRUE(top.axes().right.isApprox(Vec3d::UnitY()));
}

TEST(View, BadViewsAreRefusedWithASentence) {
  EXPECT_THROW((void)View::named("sideways", {}, 1), Error);
  View view;
  view.position = view.target;
  EXPECT_THROW(view.check(), Error);
  view = {};
  view.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(view.check(), Error);
  view = {};
  view.openingDegrees = 0;
  EXPECT_THROW(view.check(), Error);
  view = {};
  EXPECT_NO_THROW(view.check());
  View::named("top", {}, 1).check();
}

TEST(View, UpAlongTheViewIsReplaced) {
  View view = View::named("top", box({-1, -1, -1}, {1, 1, 1}), 1);
  view.up = Vec3d::UnitZ();
  const View::Axes a = view.axes();
  EXPECT_NEAR(a.right.norm(), 1, 1e-12);
  EXPECT_NEAR(a.right.dot(a.forward), 0, 1e-12);
}

TEST(Scale, RoundLengths) {
  EXPECT_DOUBLE_EQ(roundLengthUp(1.01), 2);
  EXPECT_DOUBLE_EQ(roundLengthUp(10), 10);
  EXPECT_DOUBLE_EQ(roundLengthUp(0.0011), 0.002);
  EXPECT_DOUBLE_EQ(roundLengthUp(6), 10);
  EXPECT_DOUBLE_EQ(roundLengthDown(9.99), 5);
  EXPECT_DOUBLE_EQ(roundLengthDown(10), 10);
  EXPECT_DOUBLE_EQ(roundLengthDown(0.019), 0.01);
  EXPECT_EQ(lengthLabel(10), "10 mm");
  EXPECT_EQ(lengthLabel(0.2), "200 µm");
  EXPECT_EQ(lengthLabel(5000), "5 m");
  EXPECT_EQ(lengthLabel(1), "1 mm");
}

TEST(Scale, GridLinesAreNeverTooClose) {
  for (double size = 1e-3; size < 1e7; size *= 1.7) {
    const View view = View::named("front", box(Vec3d::Constant(-size), Vec3d::Constant(size)), 16.0 / 9);
    const GridSpacing grid = gridSpacing(view, 720);
    const double pixels = grid.minor * 720 / view.heightAtTarget();
    EXPECT_GE(pixels, 15.999);
    EXPECT_LE(pixels, 40.001);
    EXPECT_GE(grid.major / grid.minor, 5 - 1e-9);
    const ScaleBar bar = scaleBar(view, 1280, 720);
    EXPECT_LE(bar.pixels, 256.001);
    EXPECT_GE(bar.pixels, 102);
  }
}

TEST(Lettering, EveryLabelHasStrokesForEachCharacter) {
  for (const char c : std::string("0123456789.mgrid")) {
    EXPECT_FALSE(letter(std::string(1, c), 0, 0, 12).empty()) << c;
  }
  EXPECT_FALSE(letter("µ", 0, 0, 12).empty());
  EXPECT_TRUE(letter(" ", 0, 0, 12).empty());
  const float width = letterWidth("200 µm", 12);
  for (const Stroke2& s : letter("200 µm", 5, 7, 12)) {
    for (const float x : {s.ax, s.bx}) {
      EXPECT_GE(x, 5);
      EXPECT_LE(x, 5 + width + 1e-3f);
    }
    for (const float y : {s.ay, s.by}) {
      EXPECT_GE(y, 7);
      EXPECT_LE(y, 7 + 16.001f);
    }
  }
}

}  // namespace
}  // namespace argil::render
