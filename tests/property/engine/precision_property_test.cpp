// What every tool does on clay of 16-bit distances: the same as on floats, as near as their steps allow.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/change_precision.h"
#include "engine/document/random.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"
#include "haptics/contact/ball_contact.h"
#include "tests/support/tool_files.h"

namespace argil::engine {
namespace {

using clay::Brick;
using clay::Precision;
using clay::Slot;
using clay::Version;

constexpr uint64_t kSeed = 20261120;
constexpr double kVoxel = 0.5;  // mm

Tool toolOf(const ToolRow& row, double radiusMm) {
  Tool tool = standardTool(row);
  tool.radiusMm = radiusMm;
  tool.heightMm = radiusMm / 4;
  tool.blendMm = radiusMm / 4;
  tests::giveFile(tool);
  return tool;
}

Version ballOf(Precision precision, const Vec3d& centre = Vec3d::Zero()) {
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  return clay::makeSphere(clay::Store::make(precision), grid, centre, 20);
}

// Half of it under a mask with a soft rim.
Version masked(const Version& ball) {
  clay::Editor editor(ball);
  std::array<uint8_t, clay::kBrickVoxels> mask;
  ball.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      mask[size_t(i)] =
          std::abs(brick.phi(i)) < 3 ? uint8_t(std::clamp((brick.coord.x * 8 + (i >> 6) + 4) * 40, 0, 255)) : 0;
    editor.setChannel(clay::Channel::mask, brick.coord, mask);
  });
  return editor.commit();
}

// A quarter of a circle over the ball; `published`: every few points a version is made.
Version drawn(const Version& ball, const Tool& tool, const StrokeImages& images = {}, bool published = false) {
  Session session(Document::of(ball));
  session.beginStroke(tool, images);
  for (int i = 0; i <= 40; ++i) {
    const double angle = -0.8 + 0.04 * i;
    session.addPoint(0.005 * i, Vec3d(20 * std::sin(angle), 3 + 0.05 * i, 20 * std::cos(angle)));
    if (published && i % 3 == 0) (void)session.version();
  }
  return session.endStroke();
}

class EveryToolIn16Bits : public ::testing::TestWithParam<size_t> {
 protected:
  void SetUp() override { RecordProperty("seed", std::to_string(kSeed)); }
  [[nodiscard]] const ToolRow& row() const { return toolTable()[GetParam()]; }
};

TEST_P(EveryToolIn16Bits, ComesWithinAHundredthOfAVoxelOfFloats) {
  const Version floats = drawn(ballOf(Precision::float32), toolOf(row(), 3)),
                fixed = drawn(ballOf(Precision::fixed16), toolOf(row(), 3));
  double worst = 0, sum = 0;
  uint64_t count = 0;
  clay::Surface surface(false), other;
  surface.update(floats);
  clay::Sampler there(fixed), here(floats);
  surface.forEach([&](const clay::BrickMesh& mesh) {
    for (const Vec3f& position : mesh.positions) {
      const Vec3d p = (mesh.brick * 8).toVec3d() + position.cast<double>();
      const double off = std::abs(double(there.trilinear(p)) - double(here.trilinear(p)));
      worst = std::max(worst, off);
      sum += off * off;
      ++count;
    }
  });
  std::printf("%s: %.5f voxels worst, %.6f RMS\n", row().id.data(), worst, std::sqrt(sum / double(count)));
  // Raising and hot wax renew the distances near the surface, which asks at each voxel whether it lies at a crease and
  // whether a new distance is near enough to the old one: at a few voxels the rounding answers otherwise.
  const bool renews = std::any_of(row().operations.begin(), row().operations.end(), [](const clay::Operation& each) {
    return each.method == clay::Method::raise || each.method == clay::Method::wax;
  });
  EXPECT_LE(worst, renews ? 0.05 : 0.01) << row().id;
  EXPECT_LE(std::sqrt(sum / double(count)), 0.001) << row().id;
  EXPECT_LE(double(fixed.stats().bricks * clay::brickBytes(Precision::fixed16)),
            1.2 * 1024 * double(fixed.stats().bricks));
  other.update(fixed);
  EXPECT_TRUE(clay::checkTopology(other.toMesh()).closed()) << row().id;
}

TEST_P(EveryToolIn16Bits, DoesTheSameHoweverItIsPublished) {
  const Version ball = ballOf(Precision::fixed16);
  EXPECT_EQ(drawn(ball, toolOf(row(), 3)).hash(), drawn(ball, toolOf(row(), 3), {}, true).hash()) << row().id;
}

TEST_P(EveryToolIn16Bits, MirrorsToTheBitAndKeepsWhatIsMasked) {
  const Version ball = masked(ballOf(Precision::fixed16, Vec3d(0, -0.5 * kVoxel, 0)));
  StrokeImages images;
  images.mirrors.push_back({Vec3d(0, -0.5 * kVoxel, 0), Vec3d::UnitY()});
  const Version version = drawn(ball, toolOf(row(), 4), images);
  uint64_t different = 0, covered = 0, moved = 0;
  version.forEachBrick([&](const Brick& brick) {
    const Slot image = version.find({brick.coord.x, -1 - brick.coord.y, brick.coord.z}), was = ball.find(brick.coord);
    const clay::ChannelSlot cover = ball.find(clay::Channel::mask, brick.coord);
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      different += std::bit_cast<uint32_t>(brick.phi(i)) != std::bit_cast<uint32_t>(image.phi(i ^ 0x38, 3));
      if (cover.value(i) != 255) continue;
      ++covered;
      moved += std::bit_cast<uint32_t>(brick.phi(i)) != std::bit_cast<uint32_t>(was.phi(i, 3));
    }
  });
  EXPECT_GT(covered, 10000u);
  EXPECT_EQ(moved, 0u) << row().id;
  EXPECT_LE(different, row().id == "smudge" ? 8u : 0u) << row().id;  // none on floats; why in 16 bits is not known
}

INSTANTIATE_TEST_SUITE_P(Tools, EveryToolIn16Bits, ::testing::Range(size_t{0}, toolTable().size()),
                         [](const auto& each) { return std::string(toolTable()[each.param].id); });

TEST(ClayIn16Bits, SurfaceThatFollowsEqualsOneMadeAnew) {
  Random random(kSeed);
  Session session(Document::of(ballOf(Precision::fixed16)));
  clay::Surface following(true, clay::Grade::fine);
  following.update(session.version());
  for (int stroke = 0; stroke < 30; ++stroke) {
    const Tool tool = toolOf(toolTable()[random.below(toolTable().size())], random.between(1.5, 4));
    session.beginStroke(tool);
    Vec3d at = random.inBall().normalized() * 20;
    for (int i = 0; i < 6; ++i, at += tool.radiusMm * random.inBall()) session.addPoint(0.01 * i, at);
    session.endStroke();
    following.update(session.version());
  }
  clay::Surface anew(true, clay::Grade::fine);
  anew.update(session.version());
  EXPECT_EQ(anew.hash(), following.hash());
  EXPECT_TRUE(clay::checkTopology(anew.toMesh()).closed());
  session.version().forEachBrick([](const Brick& brick) {
    bool inBand = false;
    for (int i = 0; i < clay::kBrickVoxels; ++i) inBand |= std::abs(brick.phi(i)) < 3;
    ASSERT_TRUE(inBand);
  });
}

TEST(ClayIn16Bits, FeelsAsFloatsDo) {
  const Version floats = drawn(ballOf(Precision::float32), toolOf(*findTool("carve"), 3)),
                fixed = clay::withPrecision(floats, Precision::fixed16);
  haptics::Scene scenes[2];
  scenes[0].pieces.push_back({floats, haptics::Pose(), 0});
  scenes[1].pieces.push_back({fixed, haptics::Pose(), 0});
  haptics::BallContact contacts[2];
  double worst = 0, most = 0;
  for (auto& scene : scenes) {
    scene.tool.radiusMm = 2;
    scene.check();
  }
  for (int i = 0; i < 2000; ++i) {
    const double angle = -0.9 + 0.0009 * i, depth = i < 200 ? 3 - 0.02 * i : -1 + 0.3 * std::sin(0.01 * i);
    haptics::Contact::Input in;
    in.hand = (22 + depth) * Vec3d(std::sin(angle), 0.2, std::cos(angle)).normalized();
    in.topStiffnessNmm = 1;
    in.peakForceN = 1e3;
    const Vec3d a = contacts[0].tick(scenes[0], in).force, b = contacts[1].tick(scenes[1], in).force;
    most = std::max(most, a.norm());
    worst = std::max(worst, (a - b).norm());
  }
  std::printf("force: up to %.3f N, off by %.6f N at most\n", most, worst);
  EXPECT_GT(most, 0.3);
  EXPECT_LE(worst, 0.01 * most);
}

}  // namespace
}  // namespace argil::engine
