// A ball on mesh parts: it never gets through, whatever the mesh is like, and facets are not felt.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string_view>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/analysis/touch_bench.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/threads/sample_ring.h"
#include "tests/support/tier.h"

namespace argil::haptics {
namespace {

constexpr uint32_t kSeed = 31;
constexpr double kRadius = 3;

Scene sceneOf(const clay::TriangleMesh& mesh, double radiusMm) {
  Scene scene;
  scene.parts.push_back({std::make_shared<const PartMesh>(mesh), Pose(), 0});
  scene.tool.radiusMm = radiusMm;
  scene.check();
  return scene;
}

// A plate about z = 0 of strips along y: triangles of all sizes that share no vertex with their neighbours' corners
// (T-junctions), a few flipped or doubled, slots between the strips of 0 to 0.9 of the ball's diameter, and every
// vertex a little off the plane.
struct Plate {
  static constexpr double kHalf = 70;  // Of its sides, mm.
  clay::TriangleMesh mesh;
  std::vector<Vec3d> targets;  // Vertices, middles of edges and of slots, T-junctions.
};

Plate makePlate(std::mt19937& random) {
  Plate plate;
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto height = [&] { return 0.2 * (uniform(random) - 0.5); };
  double x = -Plate::kHalf;
  for (int strip = 0; x < Plate::kHalf; ++strip) {
    const double width = 3 + 7 * uniform(random);
    // Rows of their own for the left and the right side: what meets on the middle line does so in T-junctions.
    const double middle = x + width * (0.3 + 0.4 * uniform(random));
    for (const auto& [from, to] : {std::pair(x, middle), std::pair(middle, x + width)}) {
      double y = -Plate::kHalf;
      while (y < Plate::kHalf) {
        const double next = y + 1 + 9 * uniform(random);
        const auto first = static_cast<uint32_t>(plate.mesh.positions.size());
        // Borders on the middle line keep z = 0: sides meet there without a slit in depth.
        const double left = from == middle ? 0 : height(), right = to == middle ? 0 : height();
        plate.mesh.positions.insert(plate.mesh.positions.end(),
                                    {{from, y, left}, {to, y, right}, {to, next, right}, {from, next, left}});
        plate.mesh.triangles.push_back({first, first + 1, first + 2});
        plate.mesh.triangles.push_back({first, first + 2, first + 3});
        if (random() % 4 == 0) std::swap(plate.mesh.triangles.back()[0], plate.mesh.triangles.back()[1]);
        if (random() % 16 == 0) plate.mesh.triangles.push_back({first, first + 1, first + 1});
        if (random() % 16 == 0) plate.mesh.triangles.push_back(plate.mesh.triangles.back());
        for (size_t i = first; i < first + 4; ++i) plate.targets.push_back(plate.mesh.positions[i]);
        plate.targets.push_back(0.5 * (plate.mesh.positions[first] + plate.mesh.positions[first + 1]));
        plate.targets.push_back(0.5 * (plate.mesh.positions[first] + plate.mesh.positions[first + 2]));
        y = next;
      }
    }
    x += width;
    const double gap = strip % 3 == 0 ? 0 : strip % 3 == 1 ? 1.8 * kRadius : 1.8 * kRadius * uniform(random);
    // Gaps are aimed at as often as all the rest.
    for (size_t i = plate.targets.size() / 4; gap > 0 && i > 0; i -= std::min<size_t>(i, 8))
      plate.targets.push_back({x + 0.5 * gap, Plate::kHalf * (2 * uniform(random) - 1), 0});
    x += gap;
  }
  return plate;
}

// 10^5 approaches in the long tier, else a tenth of them.
TEST(PartContact, NothingGetsThroughAPlateOfTrianglesAndGaps) {
  const int approaches = tests::longTier() ? 100000 : 10000, perPlate = 1000;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::printf("seed %u, %d approaches\n", kSeed, approaches);
  int leaks = 0, inGaps = 0;
  uint64_t ticks = 0, incomplete = 0;
  double overlap = 0;
  BallContact contact;
  for (int n = 0; n < approaches; n += perPlate) {
    const Plate plate = makePlate(random);
    const Scene scene = sceneOf(plate.mesh, kRadius);
    const PartMesh& part = *scene.parts[0].mesh;
    const double tolerance = 0.025 * std::min(part.resolutionMm(), kRadius / 8);
    for (int i = 0; i < perPlate; ++i) {
      Vec3d target;
      do target = plate.targets[random() % plate.targets.size()];
      while (target.head<2>().cwiseAbs().maxCoeff() > 35);
      if (random() % 2) target.head<2>() += 0.3 * kRadius * Vec3d(uniform(random), uniform(random), 0).head<2>();
      const double side = random() % 2 ? 1 : -1;
      Vec3d way(0.8 * uniform(random), 0.8 * uniform(random), -side);
      way.normalize();
      const double speed = random() % 4 ? 500.0 : 50 + 450 * std::abs(uniform(random));
      const double pressed = 1 + 9 * std::abs(uniform(random));
      // Down to the target, deep in, then along the plate, still deep.
      const Vec3d start = target - way * (kRadius + 2) / std::abs(way.z()), deep = target + way * pressed;
      const Vec3d drag(uniform(random), uniform(random), 0.2 * uniform(random));
      const int down = 1 + static_cast<int>((deep - start).norm() / (speed * 1e-3)), along = 12;
      contact.reset();
      BallContact::Input input;
      for (int k = 0; k <= down + along; ++k) {
        input.hand = k <= down ? Vec3d(start + (deep - start) * (double(k) / down))
                               : Vec3d(deep + drag * (speed * 1e-3 * (k - down)));
        const BallContact::Output out = contact.tick(scene, input);
        ++ticks;
        incomplete += (out.flags & kIncomplete) != 0;
        const double distance = part.nearest(out.proxy, kRadius, PartMesh::kNone).distance;
        overlap = std::max(overlap, (kRadius - distance) / tolerance);
        if (side * out.proxy.z() < 0) {
          ++leaks;
          break;
        }
        if (k == down) inGaps += side * out.proxy.z() < 0.9 * kRadius;
        ASSERT_TRUE(out.force.allFinite());
      }
      ASSERT_LT(leaks, 10) << "approach " << n + i;
    }
  }
  std::printf(
      "%llu ticks, %d approaches ended in a gap, %llu ticks incomplete, deepest overlap %.2f of the tolerance\n",
      static_cast<unsigned long long>(ticks), inGaps, static_cast<unsigned long long>(incomplete), overlap);
  EXPECT_EQ(leaks, 0);
  EXPECT_GT(inGaps, approaches / 10) << "the test does not reach gaps";
  EXPECT_LT(overlap, 1.0);
}

struct Jumps {
  double rmsDeg = 0, maxDeg = 0, maxSize = 0;  // From tick to tick; of the force's size as a part of it.
};

Jumps glide(const Scene& scene, double ball) {
  BallContact contact;
  BallContact::Input input;
  const double r = ball + scene.tool.radiusMm - 1, turn = 0.08 / r;  // 80 mm/s, 1 mm deep.
  Jumps jumps;
  Vec3d before = Vec3d::Zero();
  int count = 0;
  constexpr int kTicks = 6000;
  for (int i = -1000; i < kTicks; ++i) {
    const double a = turn * i, tilt = 0.4 * std::sin(0.37 * a + 1);
    const double out = i < 0 ? r + 3 * std::min(1.0, -i / 800.0) : r;
    input.hand = out * Vec3d(std::cos(a) * std::cos(tilt), std::sin(a) * std::cos(tilt), std::sin(tilt));
    const Vec3d force = contact.tick(scene, input).force;
    if (i > 0) {
      EXPECT_GT(force.norm(), 0.1);
      const double degrees = std::atan2(force.cross(before).norm(), force.dot(before)) * 180 / M_PI;
      jumps.rmsDeg += degrees * degrees;
      jumps.maxDeg = std::max(jumps.maxDeg, degrees);
      jumps.maxSize = std::max(jumps.maxSize, std::abs(force.norm() - before.norm()) / before.norm());
      ++count;
    }
    before = force;
  }
  jumps.rmsDeg = std::sqrt(jumps.rmsDeg / count);
  return jumps;
}

TEST(PartContact, FacetsAreNotFelt) {
  Scene scene = sceneOf(icosphere(40, 4), kRadius);
  scene.quality.smoothNormals = false;
  const Jumps flat = glide(scene, 40);
  scene.quality.smoothNormals = true;
  const Jumps smooth = glide(scene, 40);
  // The path itself turns by this much a tick.
  const double path = 0.08 / 42 * 180 / M_PI;
  for (const auto& [name, j] : {std::pair("facets", flat), std::pair("shaded", smooth)})
    std::printf(
        "5120 triangles, %s: direction %.3f° RMS, %.2f° at most from tick to tick (the path: %.3f°); size %.2f %% at "
        "most\n",
        name, j.rmsDeg, j.maxDeg, path, 100 * j.maxSize);
  EXPECT_LT(smooth.rmsDeg, 1.5 * path);
  EXPECT_LT(smooth.maxDeg, 0.3 * flat.maxDeg);
  EXPECT_GT(flat.maxDeg, 1.0) << "the test's sphere is too fine";
}

TEST(PartContact, ClayAndPartsHoldTheBallTogether) {
  // Clay below, a wall of two triangles at x = 4: in the corner both hold.
  Scene scene;
  clay::Grid grid;
  grid.voxelMm = 0.5;
  scene.pieces.push_back(
      {clay::makeBlock(clay::Store::make(), grid, Vec3d(0, 0, -10), Vec3d(60, 60, 20), 0), Pose(), 0});
  clay::TriangleMesh wall;
  wall.positions = {{0, -20, -5}, {0, 20, -5}, {0, 20, 20}, {0, -20, 20}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  Part part{std::make_shared<const PartMesh>(wall), Pose(), 0};
  part.pose.translation.x() = 4;
  scene.parts.push_back(part);
  scene.tool.radiusMm = kRadius;
  scene.check();
  BallContact contact;
  BallContact::Input input;
  BallContact::Output out;
  for (int i = 0; i <= 100; ++i) {
    input.hand = Vec3d(-2, 0, 6) + (Vec3d(3, 0.5, 2) - Vec3d(-2, 0, 6)) * (i / 100.0);
    out = contact.tick(scene, input);
  }
  EXPECT_EQ(out.planes, 2);
  EXPECT_NEAR(out.proxy.x(), 1, 0.02);
  EXPECT_NEAR(out.proxy.z(), 3, 0.02);
  EXPECT_NEAR(out.proxy.y(), 0.5, 0.02);
  EXPECT_NEAR(out.force.x(), -2, 0.05);
  EXPECT_NEAR(out.force.z(), 1, 0.05);
}

TEST(PartContact, TheOtherFaceHoldsToo) {
  const Scene scene = sceneOf(icosphere(20, 4), kRadius);
  BallContact contact;
  BallContact::Input input;
  input.peakForceN = 10;
  // Inside of the ball, pressed outwards.
  for (int i = 0; i <= 200; ++i) {
    input.hand = Vec3d(0.12 * i, 0, 0);
    const BallContact::Output out = contact.tick(scene, input);
    ASSERT_LT(out.proxy.norm(), 17.01) << i;
    if (i > 160) {
      EXPECT_LT(out.force.x(), -0.9 * (input.hand.x() - 17.1));
    }
  }
}

// The part is rebuilt and moved under the ball: out at a bounded speed, never through.
TEST(PartContact, APartThatMovesUnderTheBallPushesItOutGently) {
  Scene scene = sceneOf(icosphere(40, 4), kRadius);
  BallContact contact;
  BallContact::Input input;
  input.hand = {0, 0, 42};
  double before = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i == 500) scene.parts[0].pose.translation.z() = 1.5;
    if (i == 1500) scene.parts[0].mesh = std::make_shared<const PartMesh>(icosphere(39, 5));
    const BallContact::Output out = contact.tick(scene, input);
    if (i > 10) {
      EXPECT_LE(out.force.norm() - before, 0.007 * input.peakForceN) << i;
    }
    before = out.force.norm();
    if (i == 1499) {
      EXPECT_NEAR(out.proxy.z(), 44.5, 0.05);
    }
  }
}

}  // namespace
}  // namespace argil::haptics
