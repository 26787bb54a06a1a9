#include "render/renderer/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/view/scale.h"

namespace argil::render {
namespace {

Subject ball(const Vec3d& centre, double radius) {
  Subject subject;
  subject.bounds.add(centre - Vec3d::Constant(radius));
  subject.bounds.add(centre + Vec3d::Constant(radius));
  return subject;
}

Vec3d xyz(const FrameUniforms::Vec4& v) {
  return {v[0], v[1], v[2]};
}

/// Clip coordinates as shaders/frame.glsl computes them.
Eigen::Vector4d clip(const FrameUniforms& u, const Vec3d& rel, int index = 0) {
  const FrameUniforms::Eye& eye = u.eyes[size_t(index)];
  const Vec3d p = rel - xyz(eye.place);
  const double x = xyz(eye.right).dot(p), y = xyz(eye.up).dot(p), z = xyz(eye.forward).dot(p);
  const double w = u.depth[2] * z + u.depth[3];
  return {x * u.scale[0] + eye.place[3] * w, -y * u.scale[1], u.depth[0] * z + u.depth[1], w};
}

TEST(Frame, ShadersProjectLikeTheView) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-8, 8);
  const Vec3d centre(1e6, -1e6, 5e5);
  const Subject subject = ball(centre, 8);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const View view = View::named("iso", subject.bounds, 1.5, projection);
    const FramePlan plan = planFrame(Shot{view, {}, {}, {}}, subject, {}, 900, 600);
    for (int i = 0; i < 200; ++i) {
      const Vec3d p = centre + Vec3d(place(random), place(random), place(random));
      const Eigen::Vector4d c = clip(plan.uniforms, p - plan.eye);
      const Vec3d at = view.project(p, 900, 600);
      EXPECT_NEAR((c.x() / c.w() * 0.5 + 0.5) * 900, at.x(), 0.01) << "seed " << kSeed;
      EXPECT_NEAR((c.y() / c.w() * 0.5 + 0.5) * 600, at.y(), 0.01);
      EXPECT_GT(c.z(), 0);  // reversed: nearer is greater, within 0 … 1
      EXPECT_LT(c.z(), c.w());
    }
  }
}

TEST(Frame, SidesBoundExactlyWhatIsSeen) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-60, 60);
  const Subject subject = ball({3, 4, 5}, 10);
  int inside = 0, outside = 0;
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const View view = View::named("iso", subject.bounds, 1.5, projection);
    const FramePlan plan = planFrame(Shot{view, {}, {}, {}}, subject, {}, 900, 600);
    for (int i = 0; i < 2000; ++i) {
      const Vec3d p = Vec3d(3, 4, 5) + Vec3d(place(random), place(random), place(random));
      const Vec3d at = view.project(p, 900, 600);
      const bool seen = at.x() >= 0 && at.x() <= 900 && at.y() >= 0 && at.y() <= 600 &&
                        (projection == Projection::orthographic || at.z() > 0);
      const bool kept = std::all_of(plan.sides.begin(), plan.sides.end(), [&](const FramePlan::Side& side) {
        return side.normal.dot(p - plan.eye) <= side.offset;
      });
      EXPECT_EQ(seen, kept) << "seed " << kSeed << " at " << at.transpose();
      ++(seen ? inside : outside);
    }
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(Frame, ShadowMapHoldsTheClay) {
  const Subject subject = ball({-3, 40, 7}, 10);
  for (const std::string& name : View::names()) {
    const FramePlan plan = planFrame(Shot{View::named(name, subject.bounds, 1), {}, {}, {}}, subject, {}, 100, 100);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p((corner & 1) ? 7 : -13, (corner & 2) ? 50 : 30, (corner & 4) ? 17 : -3);
      const Vec3d rel = p - plan.eye;
      const auto row = [&](const FrameUniforms::Vec4& v) { return xyz(v).dot(rel) + v[3]; };
      EXPECT_LE(std::abs(row(plan.uniforms.shadowX)), 1) << name;
      EXPECT_LE(std::abs(row(plan.uniforms.shadowY)), 1) << name;
      EXPECT_GE(row(plan.uniforms.shadowZ), 0) << name;
      EXPECT_LE(row(plan.uniforms.shadowZ), 1) << name;
    }
  }
}

TEST(Frame, GridLinesCrossAtWholeMillimetres) {
  const Subject subject = ball({123.4, -56.7, 8.9}, 10);
  for (const std::string& name : View::names()) {
    const View view = View::named(name, subject.bounds, 1, Projection::orthographic);
    const FramePlan plan = planFrame(Shot{view, {}, {}, {}}, subject, {}, 720, 720);
    const FrameUniforms& u = plan.uniforms;
    const Vec3d crossing = xyz(u.ground) + plan.eye;
    const double major = gridSpacing(view, 720).major;
    for (const Vec3d& axis : {xyz(u.gridU), xyz(u.gridV)}) {
      const double lines = crossing.dot(axis) / major;
      EXPECT_NEAR(lines, std::round(lines), 1e-4) << name;
    }
    const bool facing = name != "top" && name != "bottom" && name != "iso";
    EXPECT_EQ(u.ground[3], facing ? 2 : 1) << name;
    if (!facing) {
      EXPECT_NEAR(crossing.z(), subject.bounds.min.z(), 0.01) << name;
    }
  }
}

TEST(Frame, BeamEndsOnTheClayAndIsAbsentWithin) {
  Subject subject = ball({0, 0, 0}, 10);
  const View view = View::named("front", subject.bounds, 1);
  Shot shot{view, {}, {}, {}};
  shot.overlays.cursor.emplace();
  shot.overlays.cursor->positionMm = {0, 0, 18};
  subject.beamLengthMm = 8;
  FramePlan plan = planFrame(shot, subject, {}, 720, 720);
  ASSERT_EQ(plan.worldLines[size_t(Depth::hidden)].size(), 2u);  // glow and core
  for (const LineInstance& line : plan.worldLines[size_t(Depth::hidden)]) {
    EXPECT_NEAR(line.a[2] + plan.eye.z(), 17, 1e-4);
    EXPECT_NEAR(line.b[2] + plan.eye.z(), 10, 1e-4);
  }
  subject.beamLengthMm.reset();
  plan = planFrame(shot, subject, {}, 720, 720);
  EXPECT_TRUE(plan.worldLines[size_t(Depth::hidden)].empty());
  EXPECT_EQ(plan.uniforms.drop[3], 0);
}

}  // namespace
}  // namespace argil::render
