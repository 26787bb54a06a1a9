// Clay, parts and keep-outs in one scene: one set of planes holds the ball, and a tool that cuts clay stops at what is
// none.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kRadius = 3;

Contact::Input inputAt(const Vec3d& hand, bool operate = false, uint64_t index = 0) {
  Contact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = 1;
  in.peakForceN = 1e3;
  in.operate = operate;
  in.sampleIndex = index;
  return in;
}

// Two triangles across the world, at a height or standing at an x.
std::shared_ptr<const PartMesh> plate(const Vec3d& at, const Vec3d& u, const Vec3d& v) {
  clay::TriangleMesh mesh;
  for (const auto& [a, b] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    mesh.positions.push_back(at + 40 * a * u + 40 * b * v);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return std::make_shared<const PartMesh>(mesh);
}

Scene blockScene() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  Scene scene;
  scene.pieces.push_back({clay::makeBlock(clay::Store::make(), grid, {0, 0, -10}, {40, 40, 20}, 0), Pose(), 0});
  scene.tool.radiusMm = kRadius;
  return scene;
}

TEST(MixedScene, ABallRestsBetweenClayAndAPart) {
  Scene scene = blockScene();
  scene.parts.push_back({plate({5, 0, 0}, Vec3d::UnitY(), Vec3d::UnitZ()), Pose(), 0});
  scene.check();
  auto contact = std::make_unique<BallContact>();
  Contact::Output out;
  for (int i = 0; i <= 400; ++i)
    out = contact->tick(scene, inputAt({0.02 * std::min(i, 200), 0.3, 4 - 0.015 * std::min(i, 200)}));
  EXPECT_EQ(out.planes, 2);
  EXPECT_NEAR(out.proxy.x(), 5 - kRadius, 0.02);
  EXPECT_NEAR(out.proxy.z(), kRadius, 0.02);
  EXPECT_NEAR(out.force.x(), (5 - kRadius) - 4, 0.03);
  EXPECT_NEAR(out.force.z(), kRadius - 1, 0.03);
}

// The published clay never changes here, so clay alone would let the ball through all of the block.
TEST(MixedScene, ACutStopsAtWhatIsNoClay) {
  for (const bool keepOut : {false, true}) {
    Scene scene = blockScene();
    scene.tool.work = haptics::Work::cut;
    if (keepOut)
      scene.guides.push_back({7, KeepOutPlane{{0, 0, -6}, Vec3d::UnitZ()}, 0});
    else
      scene.parts.push_back({plate({0, 0, -6}, Vec3d::UnitX(), Vec3d::UnitY()), Pose(), 0});
    scene.check();
    auto contact = std::make_unique<BallContact>();
    double lowest = 1e9;
    uint64_t cutting = 0;
    Contact::Output out;
    for (uint64_t i = 0; i < 3000; ++i) {
      const double t = double(i) / 3000;
      out = contact->tick(scene, inputAt({6 * t, 0.4, 5 - 25 * t}, i > 50, i));
      cutting += (out.flags & kCutting) != 0;
      if (out.flags & kCutting) lowest = std::min(lowest, out.cutPoint.z());
    }
    EXPECT_GT(cutting, 2900u);
    EXPECT_NEAR(lowest, -6 + kRadius, 0.05) << (keepOut ? "keep-out" : "part");
    EXPECT_TRUE(out.flags & kTouching);
    EXPECT_GT(out.force.z(), 10);
  }
}

// From hard to soft clay under the same depth: the stiffness is eased, the force has no step.
TEST(MixedScene, TheForceHasNoStepWhereTwoMaterialsMeet) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  auto store = clay::Store::make();
  Scene scene;
  scene.materials.resize(2);
  scene.materials[0].stiffnessNmm = 1;
  scene.materials[1].stiffnessNmm = 0.4;
  scene.pieces.push_back({clay::makeBlock(store, grid, {-20, 0, -10}, {40, 40, 20}, 0), Pose(), 0});
  scene.pieces.push_back({clay::makeBlock(store, grid, {20, 0, -10}, {40, 40, 20}, 0), Pose(), 1});
  scene.tool.radiusMm = kRadius;
  scene.check();
  auto contact = std::make_unique<BallContact>();
  double before = 0, jump = 0, first = 0, last = 0;
  for (int i = 0; i < 1200; ++i) {
    const double depth = std::min(2.0, 0.01 * i);
    const auto out = contact->tick(scene, inputAt({-10 + 20.0 * i / 1200, 0.3, kRadius - depth}));
    const double f = out.force.norm();
    if (i > 250) jump = std::max(jump, std::abs(f - before));
    if (i == 300) first = f;
    last = before = f;
  }
  EXPECT_NEAR(first, 2, 0.02);
  EXPECT_NEAR(last, 0.8, 0.02);
  EXPECT_LE(jump, 0.066);  // 2 % of the smallest device's peak.
}

}  // namespace
}  // namespace argil::haptics
