// Clay whose voxels are of different materials: each place feels like a piece of its own material.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/contact/cutting.h"
#include "haptics/threads/sample_ring.h"
#include "tests/unit/haptics/painted_clay.h"

namespace argil::haptics {
namespace {

constexpr double kRadius = 3;
constexpr uint8_t kSoft = 3, kNoRow = 9;

Contact::Input inputAt(const Vec3d& hand, bool operate = false, uint64_t index = 0) {
  Contact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = 2;
  in.peakForceN = 1e3;
  in.operate = operate;
  in.sampleIndex = index;
  return in;
}

clay::Version block() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeBlock(clay::Store::make(), grid, {0, 0, -10}, {60, 40, 20}, 0);
}

// From x = 0 on it is of row `row`.
clay::Version halfOf(const clay::Version& version, uint8_t row) {
  return testing::painted(version, clay::Channel::material, [row](Coord v) { return v.x >= 0 ? row : uint8_t{0}; });
}

// materials[0] is hard, [1] soft, sticky and tough; what no row names is the piece's own.
Scene sceneOf(const clay::Version& version, uint32_t own, bool rows, const Pose& pose = {}) {
  Scene scene;
  scene.materials.resize(2);
  scene.materials[0] = {1.5, 0.05, 0.02, 0.001, 0.2, 0.15, 0, -1};
  scene.materials[1] = {0.5, 0.02, 0.05, 0.004, 0.7, 0.6, 0.001, -1};
  Piece piece{version, pose, own};
  if (rows) {
    MaterialRows table;
    table.fill(static_cast<uint16_t>(own));
    table[kSoft] = 1;
    piece.rows = std::make_shared<const MaterialRows>(table);
  }
  scene.pieces.push_back(std::move(piece));
  scene.tool.radiusMm = kRadius;
  scene.check();
  return scene;
}

// Pressed 1 mm deep and drawn along x at 50 mm/s.
std::vector<Contact::Output> drawn(const Scene& scene, double fromX, double toX) {
  auto contact = std::make_unique<BallContact>();
  std::vector<Contact::Output> all;
  const Pose& pose = scene.pieces[0].pose;
  for (int i = 0; i < 100; ++i) contact->tick(scene, inputAt(pose.apply(Vec3d(fromX, 0.3, kRadius + 0.5 - 0.015 * i))));
  const double step = toX > fromX ? 0.05 : -0.05;
  for (double x = fromX; (toX - x) * step > 0; x += step)
    all.push_back(contact->tick(scene, inputAt(pose.apply(Vec3d(x, 0.3, kRadius - 1)))));
  return all;
}

double across(const Vec3d& force, const Vec3d& up) {
  return (force - up * force.dot(up)).norm();
}

TEST(MixedClay, EachPlaceFeelsLikeAPieceOfItsMaterial) {
  const clay::Version mixed = halfOf(block(), kSoft);
  for (const uint32_t seed : {1u, 2u, 3u}) {
    std::printf("seed %u\n", seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    Pose pose;
    pose.translation = {20 * any(random), 20 * any(random), 20 * any(random)};
    pose.rotation = Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
    const Vec3d up = pose.rotation * Vec3d::UnitZ();
    const auto both = drawn(sceneOf(mixed, 0, true, pose), -10, 10);
    const auto hard = drawn(sceneOf(block(), 0, false, pose), -10, 10),
               soft = drawn(sceneOf(block(), 1, false, pose), -10, 10);
    double jump = 0;
    for (size_t i = 1; i < both.size(); ++i) jump = std::max(jump, (both[i].force - both[i - 1].force).norm());
    const auto at = [&](double x) { return static_cast<size_t>((x + 10) / 0.05); };
    for (const double x : {-6.0, -3.0}) EXPECT_EQ(both[at(x)].force, hard[at(x)].force) << x;
    for (const double x : {5.0, 8.0}) {
      EXPECT_LT((both[at(x)].force - soft[at(x)].force).norm(), 0.02 * soft[at(x)].force.norm()) << x;
      EXPECT_NEAR(both[at(x)].force.dot(up), 0.5, 0.01);
      EXPECT_NEAR(across(both[at(x)].force, up) / both[at(x)].force.dot(up), 0.6, 0.15) << x;
    }
    std::printf("largest step of the force from one to the other: %.4f N\n", jump);
    // Stiffness is eased (0.05 N a tick here), and where friction grows the ball sticks while the hand goes on: its way
    // in a tick, 0.05 mm at 1.5 N/mm.
    EXPECT_LE(jump, 0.1);
  }
}

TEST(MixedClay, ARowThatIsNotThereFeelsLikeThePieceItself) {
  const auto plain = drawn(sceneOf(block(), 0, false), -4, 4),
             unknown = drawn(sceneOf(halfOf(block(), kNoRow), 0, true), -4, 4),
             unseen = drawn(sceneOf(halfOf(block(), 255), 0, true), -4, 4),
             noChannel = drawn(sceneOf(block(), 0, true), -4, 4);
  for (size_t i = 0; i < plain.size(); ++i)
    for (const auto* other : {&unknown, &unseen, &noChannel}) ASSERT_EQ((*other)[i].force, plain[i].force) << i;
}

TEST(MixedClay, ClayWithoutTheChannelIsNotRead) {
  TouchableClay clay;
  const Scene plain = sceneOf(block(), 1, true), mixed = sceneOf(halfOf(block(), kSoft), 0, true);
  clay.reset(plain.pieces[0]);
  EXPECT_FALSE(clay.mixed());
  EXPECT_EQ(clay.material(Vec3d(5, 0, 0)), 1u);
  clay.reset(mixed.pieces[0]);
  EXPECT_TRUE(clay.mixed());
  EXPECT_EQ(clay.material(Vec3d(5, 0, 0)), 1u);
  EXPECT_EQ(clay.material(Vec3d(-5, 0, 0)), 0u);
}

// The edit never comes: what is cut is known from the band that the ball went through.
TEST(MixedClay, CutsYieldAsTheirMaterialSays) {
  const clay::Version mixed = halfOf(block(), kSoft);
  const auto pressed = [](Scene scene, double x) {
    scene.tool.work = Work::cut;
    auto contact = std::make_unique<BallContact>();
    Contact::Output out;
    for (uint64_t i = 0; i < 1500; ++i)
      out = contact->tick(scene, inputAt({x, 0.3, kRadius + 0.1 - std::min(2.0, 0.004 * double(i))}, true, i));
    return out;
  };
  for (const double x : {-8.0, 8.0}) {
    // The spring of a cut is the piece's own everywhere; what yields is the voxels'.
    const auto got = pressed(sceneOf(mixed, 0, true), x);
    const double rests = restingDepth(kRadius, x < 0 ? 0.05 : 0.02, got.force.z());
    std::printf("x %.0f: rests at %.3f mm under %.3f N, predicted %.3f mm\n", x, kRadius - got.proxy.z(), got.force.z(),
                rests);
    EXPECT_GT(got.force.z(), 0.1);
    EXPECT_NEAR(kRadius - got.proxy.z(), rests, 0.05 * rests);
  }
}

}  // namespace
}  // namespace argil::haptics
