#include "ui3d/studio/view/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "clay/base/error.h"

namespace argil::studio {
namespace {

using render::Box;
using render::Projection;
using render::View;

constexpr float kWidth = 1280, kHeight = 720;
constexpr double kWindow = 1e-9;  // Of the window's height.

Vec3d at(const Camera& camera, const Vec3d& p) {
  return camera.view().project(p, int(kWidth), int(kHeight)) / kHeight;
}

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) { testing::Test::RecordProperty("seed", int(seed)); }
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  Vec3d vector() { return {between(-1, 1), between(-1, 1), between(-1, 1)}; }
  Camera camera(const Vec3d& origin = Vec3d::Zero(), double size = 100) {
    View view;
    view.projection = between(0, 1) < 0.5 ? Projection::perspective : Projection::orthographic;
    view.target = origin + size * vector();
    view.position = view.target + size * (vector() + Vec3d(0, -2, 0.1));
    view.openingDegrees = between(5, 90);
    Camera camera;
    camera.set(view);
    return camera;
  }
  /// A point that is seen.
  Vec3d seen(const Camera& camera) {
    const Camera::Ray ray = camera.ray(float(between(100, 1100)), float(between(50, 650)), kWidth, kHeight);
    const double depth = camera.view().distance() * between(0.3, 2);
    const double start = (ray.origin - camera.view().position).dot(camera.view().axes().forward);
    return ray.origin + (depth - start) / ray.direction.dot(camera.view().axes().forward) * ray.direction;
  }

 private:
  std::mt19937 engine_;
};

TEST(Camera, WhatIsUnderTheCursorStaysThereInZoomPanAndOrbit) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    Camera camera = random.camera();
    const Vec3d point = random.seen(camera);
    const Vec3d before = at(camera, point);
    camera.zoom(float(random.between(-8, 8)), point);
    EXPECT_LT((at(camera, point) - before).head<2>().norm(), kWindow);

    camera.orbit(float(random.between(-300, 300)), float(random.between(-300, 300)), kHeight, point);
    EXPECT_LT((at(camera, point) - before).head<2>().norm(), kWindow);

    const float dx = float(random.between(-200, 200)), dy = float(random.between(-200, 200));
    camera.pan(dx, dy, kHeight, (point - camera.view().position).dot(camera.view().axes().forward));
    EXPECT_LT((at(camera, point) - before - Vec3d(dx, dy, 0) / kHeight).head<2>().norm(), kWindow);
  }
}

TEST(Camera, RaysMeetWhatIsProjectedThere) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const Camera camera = random.camera();
    const float x = float(random.between(0, 1280)), y = float(random.between(0, 720));
    const Camera::Ray ray = camera.ray(x, y, kWidth, kHeight);
    EXPECT_NEAR(ray.direction.norm(), 1, 1e-14);
    const double depth = (camera.view().target - ray.origin).norm();
    EXPECT_LT((at(camera, ray.origin + depth * ray.direction) - Vec3d(x, y, 0) / kHeight).head<2>().norm(), kWindow);
  }
}

TEST(Camera, OrthographicRaysBeginBehindWhatIsSeen) {
  Camera camera;
  camera.set(View::named("front", {}, 16.0 / 9, Projection::orthographic));
  const Camera::Ray ray = camera.ray(640, 360, kWidth, kHeight);
  EXPECT_LT((ray.origin - camera.view().position).dot(camera.view().axes().forward), -1000);
}

TEST(Camera, InverseDragsComeBack) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Camera camera = random.camera();
    const View before = camera.view();
    const Vec3d pivot = random.seen(camera);
    const float dx = float(random.between(-100, 100)), dy = float(random.between(-30, 30));
    const double elevation = std::asin(before.axes().forward.z());
    if (std::abs(elevation) + 40 * std::numbers::pi / kHeight > 0.5 * std::numbers::pi) continue;
    camera.orbit(dx, dy, kHeight, pivot);
    camera.zoom(3, pivot);
    camera.pan(dx, dy, kHeight, before.distance());
    camera.pan(-dx, -dy, kHeight, before.distance());
    camera.zoom(-3, pivot);
    camera.orbit(-dx, -dy, kHeight, pivot);
    EXPECT_LT((camera.view().position - before.position).norm(), 1e-10 * (1 + before.position.norm()));
    EXPECT_LT((camera.view().axes().up - before.axes().up).norm(), 1e-10);
  }
}

TEST(Camera, HalfOfTheWindowTurnsByAQuarter) {
  Camera camera;
  camera.set(View::named("front", {}, 1));
  camera.orbit(0.5f * kHeight, 0, kHeight, camera.view().target);
  EXPECT_TRUE(camera.view().axes().forward.isApprox(Vec3d::UnitX(), 1e-12)) << "the model's front goes to the right";
}

TEST(Camera, OrbitsStopAtThePolesAndNeverFlip) {
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    Camera camera = random.camera();
    const Vec3d target = camera.view().target;
    for (int step = 0; step < 400; ++step) {
      const Vec3d right = camera.view().axes().right, up = camera.view().axes().up;
      camera.orbit(float(random.between(-20, 20)), float(random.between(-120, 120)), kHeight, target);
      const View::Axes after = camera.view().axes();
      EXPECT_NEAR(after.right.z(), 0, 1e-9);
      EXPECT_GE(after.up.z(), -1e-9) << "never upside down";
      EXPECT_GT(after.right.dot(right), 0.9);
      EXPECT_GT(after.up.dot(up), 0.7);
    }
    EXPECT_LT((camera.view().target - target).norm(), 1e-8);
  }
  Camera camera;
  camera.orbit(0, 10000, kHeight, Vec3d::Zero());
  EXPECT_NEAR(camera.view().axes().forward.z(), -1, 1e-12);
  const Vec3d right = camera.view().axes().right;
  camera.orbit(360, 0, kHeight, Vec3d::Zero());
  EXPECT_NEAR(camera.view().axes().right.dot(right), 0, 1e-12) << "at the pole it still turns";
}

TEST(Camera, ALeaningViewComesUprightInAnOrbitWithoutALeap) {
  Camera camera;
  View view = View::named("front", {}, 1);
  view.up = {0.5, 0, 1};
  camera.set(view);
  const double lean = std::abs(camera.view().axes().right.z());
  camera.orbit(1, 0, kHeight, view.target);
  const double after = std::abs(camera.view().axes().right.z());
  EXPECT_LT(after, lean);
  EXPECT_GT(after, 0.95 * lean);
  for (int i = 0; i < 40; ++i) camera.orbit(20, 0, kHeight, view.target);
  EXPECT_NEAR(camera.view().axes().right.z(), 0, 1e-3);
}

TEST(Camera, NamedViewsAreExactAndKeepTheSize) {
  for (const std::string& name : View::names()) {
    Random random(5);
    Camera camera = random.camera();
    const double height = camera.view().heightAtTarget();
    const Vec3d target = camera.view().target;
    camera.look(name, target);
    int steps = 0;
    while (camera.tick(0.01) && steps < 1000) ++steps;
    EXPECT_GE(steps, 15);
    EXPECT_LE(steps, 25);
    const View named = View::named(name, {}, 1.5);
    EXPECT_TRUE(camera.view().axes().forward.isApprox(named.axes().forward, 1e-12)) << name;
    EXPECT_TRUE(camera.view().axes().up.isApprox(named.axes().up, 1e-12)) << name;
    EXPECT_NEAR(camera.view().heightAtTarget(), height, 1e-9 * height);
    EXPECT_LT((camera.view().target - target).norm(), 1e-9);
  }
  Camera camera;
  EXPECT_THROW(camera.look("sideways", Vec3d::Zero()), Error);
}

// Whatever the hand did before: the point keeps its place in the picture and its distance.
TEST(Camera, NamedViewsTurnAboutAPointThatKeepsItsPlace) {
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    Camera camera = random.camera();
    const Vec3d point = random.seen(camera);
    camera.zoom(float(random.between(-6, 6)), point);
    camera.orbit(float(random.between(-300, 300)), float(random.between(-300, 300)), kHeight, point);
    const Vec3d before = at(camera, point);
    const double size = camera.view().heightAtTarget();
    camera.look(View::names()[size_t(i) % View::names().size()], point);
    while (camera.tick(0.05)) {
    }
    EXPECT_LT((at(camera, point) - before).head<2>().norm(), kWindow);
    EXPECT_NEAR(camera.view().heightAtTarget(), size, 1e-9 * size);
  }
}

TEST(Camera, AFocusFitsABox) {
  Box box;
  box.add(Vec3d(40, 50, 60));
  box.add(Vec3d(60, 70, 90));
  Camera camera;
  camera.openingDegrees(50);
  camera.look("left", Vec3d::Zero());
  while (camera.tick(0.05)) {
  }
  camera.focus(box, 1.5);
  while (camera.tick(0.05)) {
  }
  EXPECT_TRUE(camera.view().target.isApprox(box.centre()));
  EXPECT_EQ(camera.view().openingDegrees, 50);
  const Vec3d forward = camera.view().axes().forward;
  camera.pan(500, 0, kHeight, 100);
  camera.zoom(-20, Vec3d::Zero());
  camera.focus(box, 1.5);
  while (camera.tick(0.05)) {
  }
  EXPECT_TRUE(camera.view().target.isApprox(box.centre()));
  EXPECT_TRUE(camera.view().axes().forward.isApprox(forward));
  EXPECT_LT(camera.view().heightAtTarget(), 100);
}

TEST(Camera, AGlideGoesStraightAndTheHandEndsIt) {
  Camera camera;
  camera.set(View::named("front", {}, 1));
  camera.look("back", camera.view().target);
  EXPECT_TRUE(camera.tick(0.1));
  EXPECT_NEAR(camera.view().axes().up.z(), 1, 1e-9) << "about the vertical, not over the top";
  EXPECT_NEAR(std::abs(camera.view().axes().forward.x()), 1, 1e-9) << "half way after half of the time";
  camera.zoom(1, camera.view().target);
  const Vec3d position = camera.view().position;
  EXPECT_FALSE(camera.tick(0.1));
  EXPECT_EQ(camera.view().position, position);
  EXPECT_NEAR(camera.view().axes().forward.y(), -1, 1e-9) << "the wheel leaves no view half turned";
}

TEST(Camera, ProjectionAndOpeningKeepTheSizeAtTheTarget) {
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    Camera camera = random.camera();
    const Vec3d aside = camera.view().target + 7 * camera.view().axes().up;
    const Vec3d before = at(camera, aside);
    camera.toggleProjection();
    EXPECT_LT((at(camera, aside) - before).head<2>().norm(), kWindow);
    camera.openingDegrees(random.between(1, 150));
    EXPECT_LT((at(camera, aside) - before).head<2>().norm(), kWindow);
  }
}

TEST(Camera, ZoomStopsAtAMicrometreAndTenKilometres) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    Camera camera;
    View view = View::named("iso", {}, 1, projection);
    camera.set(view);
    const Vec3d under = view.target + Vec3d(3, 2, 1);
    const Vec3d before = at(camera, under);
    for (int i = 0; i < 300; ++i) camera.zoom(3, under);
    EXPECT_NEAR(camera.view().heightAtTarget(), Camera::kLeastHeightMm, 1e-3 * Camera::kLeastHeightMm);
    EXPECT_LT((at(camera, under) - before).head<2>().norm(), 1e-6);
    EXPECT_NO_THROW(camera.view().check());
    for (int i = 0; i < 300; ++i) camera.zoom(-3, under);
    EXPECT_NEAR(camera.view().heightAtTarget(), Camera::kMostHeightMm, 1e-6 * Camera::kMostHeightMm);
    EXPECT_NO_THROW(camera.view().check());
  }
}

TEST(Camera, ExtremesHold) {
  // A micrometre part at the far end of what a document may hold: a picture 40 µm high, resolved to a 1e-5th.
  Random random(7);
  const Vec3d origin(1e6, -1e6, 1e6);
  for (int i = 0; i < 100; ++i) {
    Camera camera = random.camera(origin, 0.02);
    const Vec3d point = random.seen(camera), before = at(camera, point);
    camera.orbit(50, 20, kHeight, point);
    camera.zoom(2, point);
    EXPECT_LT((at(camera, point) - before).head<2>().norm(), 1e-5);
    EXPECT_NO_THROW(camera.view().check());
  }
  Camera camera;
  camera.orbit(1e9f, -1e9f, kHeight, origin);
  camera.zoom(1e5f, camera.view().target);
  camera.zoom(-1e5f, camera.view().target);
  camera.pan(10, 10, 0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_NO_THROW(camera.view().check());
  EXPECT_THROW(camera.set(View{.position = Vec3d::Zero(), .target = Vec3d::Zero()}), Error);
}

TEST(Camera, A3DMouseMovesTheModelByTimeNotByEvents) {
  Camera once, often;
  once.set(View::named("front", {}, 1));
  often.set(once.view());
  for (int axis = 0; axis < 6; ++axis) {
    std::array<float, 6> push{};
    push[size_t(axis)] = 0.7f;
    once.motion(push, 0.08);
    for (int i = 0; i < 8; ++i) often.motion(push, 0.01);
    EXPECT_LT((once.view().position - often.view().position).norm(), 1e-9 * once.view().distance()) << axis;
    EXPECT_LT((once.view().axes().up - often.view().axes().up).norm(), 1e-9) << axis;
  }
  Camera still;
  const Vec3d before = still.view().position;
  still.motion({0.05f, -0.05f, 0.05f, 0, 0, -0.05f}, 0.1);
  EXPECT_EQ(still.view().position, before) << "a hand that rests on the cap";
}

TEST(Camera, ThePushedCapTakesTheModelWithIt) {
  const auto moved = [](std::array<float, 6> axes, const Vec3d& point) {
    Camera camera;
    camera.set(View::named("front", {}, 1));
    const Vec3d before = at(camera, point);
    camera.motion(axes, 0.05);
    return Vec3d(at(camera, point) - before);
  };
  EXPECT_GT(moved({1, 0, 0, 0, 0, 0}, Vec3d::Zero()).x(), 0);
  EXPECT_LT(moved({0, 1, 0, 0, 0, 0}, Vec3d::Zero()).y(), 0) << "up";
  EXPECT_LT(moved({0, 0, 1, 0, 0, 0}, Vec3d::Zero()).z(), 0) << "nearer";
  EXPECT_LT(moved({0, 0, 0, 1, 0, 0}, Vec3d(0, 0, 30)).z(), 0) << "its top comes towards the person";
  EXPECT_GT(moved({0, 0, 0, 0, 1, 0}, Vec3d(0, -30, 0)).x(), 0) << "its front goes to the right";
  EXPECT_LT(moved({0, 0, 0, 0, 0, 1}, Vec3d(0, 0, 30)).x(), 0) << "its top goes to the left: counter-clockwise";
}

}  // namespace
}  // namespace argil::studio
