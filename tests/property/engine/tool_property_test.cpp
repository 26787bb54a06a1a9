// What every tool of the table promises.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/store/tree_view.h"
#include "clay/surface/surface.h"
#include "clay/whole/mask_work.h"
#include "engine/document/random.h"
#include "engine/models/prepare_clay.h"
#include "engine/saving/session.h"
#include "engine/session/run.h"
#include "engine/tools/tool_table.h"
#include "tests/support/tier.h"
#include "tests/support/tool_files.h"

namespace argil::engine {
namespace {

using clay::Brick;
using clay::Slot;
using clay::Version;

constexpr uint64_t kSeed = 20261120;

clay::Grid gridOf(double voxelMm) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}

Tool toolOf(const ToolRow& row, double radiusMm) {
  Tool tool = standardTool(row);
  tool.radiusMm = radiusMm;
  tool.heightMm = radiusMm / 4;
  tool.blendMm = radiusMm / 4;
  tests::giveFile(tool);
  return tool;
}

bool shapes(const ToolRow& row) {
  return std::any_of(row.operations.begin(), row.operations.end(),
                     [](const clay::Operation& each) { return each.property == clay::Property::distance; });
}

class EveryTool : public ::testing::TestWithParam<size_t> {
 protected:
  void SetUp() override { RecordProperty("seed", std::to_string(kSeed)); }
  [[nodiscard]] const ToolRow& row() const { return toolTable()[GetParam()]; }
};

// A circle of 15 mm on a ball, at 200 mm/s.
Version drawnAt(const ToolRow& row, double hz) {
  constexpr double kSeconds = 0.4, kSpeed = 200, kCircle = 15;
  Session session(Document::of(clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 25)));
  session.beginStroke(toolOf(row, 3));
  const int count = int(std::lround(kSeconds * hz));
  for (int i = 0; i <= count; ++i) {
    const double s = i / hz, angle = kSpeed * s / kCircle;
    session.addPoint(s, {kCircle * std::cos(angle), kCircle * std::sin(angle), 20});
  }
  return session.endStroke();
}

TEST_P(EveryTool, DoesTheSameHoweverOftenTheHandWasLookedAt) {
  if (!shapes(row())) return;
  const Version finest = drawnAt(row(), 1000);
  for (const double hz : {60.0, 250.0}) {
    const Version other = drawnAt(row(), hz);
    // Where the surface of one lies in the other.
    double worst = 0;
    clay::Surface surface(false);
    surface.update(finest);
    clay::Sampler here(finest), there(other);
    surface.forEach([&](const clay::BrickMesh& mesh) {
      for (const Vec3f& position : mesh.positions) {
        const Vec3d p = (mesh.brick * 8).toVec3d() + position.cast<double>();
        worst = std::max(worst, double(std::abs(there.trilinear(p) - here.trilinear(p))));
      }
    });
    std::printf("%s at %g Hz: %.4f voxels\n", row().id.data(), hz, worst);
    EXPECT_LE(worst, 0.05) << row().id << " at " << hz << " Hz";
  }
}

// Whether all normals around a place of the surface agree with one another: at it, and `voxels` away along 26 ways in
// its tangent plane.
constexpr double kCosine20 = 0.9397, kCosine10 = 0.9848;
bool normalsAgree(clay::Sampler& sampler, const Vec3d& place, const Vec3d& normal, double cosine,
                  std::initializer_list<double> voxels) {
  std::vector<Vec3d> normals{normal};
  for (const double away : voxels)
    for (int k = 0; k < 26; ++k) {
      const int c = k < 13 ? k : k + 1;
      const Vec3d step = away * Vec3d(c / 9 - 1, c / 3 % 3 - 1, c % 3 - 1).normalized();
      Vec3f g;
      (void)sampler.tricubic(place + step - step.dot(normal) * normal, g);
      if (!(g.squaredNorm() > 0.25f)) return false;
      const Vec3d other = g.cast<double>().normalized();
      if (std::any_of(normals.begin(), normals.end(), [&](const Vec3d& each) { return each.dot(other) < cosine; }))
        return false;
      normals.push_back(other);
    }
  return true;
}

// Mirror images of a stroke that runs along the plane and across it.
void strokeAcross(Session& session, const Tool& tool, const StrokeImages& images) {
  Random random(kSeed);
  for (int n = 0; n < 3; ++n) {
    session.beginStroke(tool, images);
    Vec3d at = Vec3d(0.1 + 0.4 * n, -0.3 * n, 1).normalized() * 20;
    for (int i = 0; i < 10; ++i) {
      session.addPoint(0.01 * i, at);
      at = (at + 1.5 * random.inBall()).normalized() * 20;
    }
    session.endStroke();
  }
}

TEST_P(EveryTool, MirrorsToTheBitInAPlaneBetweenBricks) {
  const double voxel = 0.5;
  Session session(Document::of(clay::makeSphere(clay::Store::make(), gridOf(voxel), Vec3d(-0.5 * voxel, 0, 0), 20)));
  StrokeImages images;
  images.mirrors.push_back({Vec3d(-0.5 * voxel, 0, 0), Vec3d::UnitX()});
  strokeAcross(session, toolOf(row(), 3), images);
  const Version version = session.version();
  uint64_t different = 0, channels = 0;
  float most = 0;
  version.forEachBrick([&](const Brick& brick) {
    const Coord there{-1 - brick.coord.x, brick.coord.y, brick.coord.z};
    const Slot image = version.find(there);
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      const int mirrored = (7 - (i >> 6)) << 6 | (i & 63);
      different += std::bit_cast<uint32_t>(brick.phi(i)) != std::bit_cast<uint32_t>(image.phi(mirrored, 3));
      most = std::max(most, std::abs(brick.phi(i) - image.phi(mirrored, 3)));
      for (const clay::Channel channel : clay::kAllChannels)
        channels += version.find(channel, brick.coord).value(i) != version.find(channel, there).value(mirrored);
    }
  });
  EXPECT_EQ(different, 0u) << row().id << ", by " << most;
  EXPECT_EQ(channels, 0u) << row().id;
}

TEST_P(EveryTool, MirrorsInAnyPlane) {
  if (!shapes(row())) return;
  Session session(Document::of(clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 20)));
  const Vec3d normal = Vec3d(1, 0.3, -0.2).normalized();
  StrokeImages images;
  images.mirrors.push_back({Vec3d::Zero(), normal});
  strokeAcross(session, toolOf(row(), 3), images);
  const Version version = session.version();
  // Where normals within three voxels agree to 10°. A crease is read beside where it lies, by where the voxels happen
  // to be: an exact one of 10° by up to 0.033 voxel, one of 20° by 0.065.
  clay::Sampler sampler(version);
  Random random(7);
  double worst = 0;
  size_t looked = 0;
  for (int i = 0; i < 400000 && looked < 20000; ++i) {
    Vec3d p = Vec3d(0.1, -0.3, 1).normalized() * 40 + 14 * random.inBall();
    Vec3f g, h;
    if (std::abs(sampler.tricubic(p, g)) > 1) continue;
    for (int k = 0; k < 3; ++k)
      p -= double(sampler.tricubic(p, g)) * g.cast<double>() / std::max(double(g.squaredNorm()), 0.25);
    if (std::abs(sampler.tricubic(p, g)) > 1e-3) continue;
    const Vec3d q = p - 2 * p.dot(normal) * normal;
    const double there = std::abs(sampler.tricubic(q, h));
    if (!normalsAgree(sampler, p, g.cast<double>().normalized(), kCosine10, {2, 3}) ||
        !normalsAgree(sampler, q, h.cast<double>().normalized(), kCosine10, {2, 3}))
      continue;
    ++looked;
    worst = std::max(worst, there);
  }
  std::printf("%s: %.4f voxels at %zu places\n", row().id.data(), worst, looked);
  EXPECT_GT(looked, 500u);
  // Thirty stamps on one spot pinch it to a fiftieth, and what is finer than a voxel then comes out as it falls on the
  // grid.
  EXPECT_LE(worst, row().id == "pinch" ? 0.04 : 0.02) << row().id;
}

// The skin is three voxels thick, the tool reaches twelve deep and as far into the air.
TEST_P(EveryTool, DoesNothingToAPieceThatIsMaskedWhole) {
  const Version ball = clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 20);
  const Version masked = clay::invertMask(ball);
  Session session(Document::of(masked));
  Tool tool = toolOf(row(), 6);
  tool.heightMm = 4;
  strokeAcross(session, tool, {});
  const Version version = session.version();
  uint64_t changed = 0;
  Version::forEachDifference(masked, version, [&](Coord coord, Slot a, Slot b) {
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      changed += std::bit_cast<uint32_t>(a.phi(i, 3)) != std::bit_cast<uint32_t>(b.phi(i, 3));
    if (changed) ADD_FAILURE() << row().id << " changed brick " << coord.x << " " << coord.y << " " << coord.z;
  });
  EXPECT_EQ(changed, 0u) << row().id;
}

// Half of the ball is masked; what is below the masked half stays as deep as the tool is wide, and no roof is laid over
// it.
TEST_P(EveryTool, KeepsWhatIsBelowAndAboveAMask) {
  if (!shapes(row())) return;
  const Version ball = clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 20);
  clay::Editor editor(ball);
  std::array<uint8_t, clay::kBrickVoxels> mask;
  ball.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      mask[size_t(i)] = std::abs(brick.phi(i)) < 3 && brick.coord.x * 8 + (i >> 6) >= 0 ? 255 : 0;
    editor.setChannel(clay::Channel::mask, brick.coord, mask);
  });
  const Version masked = editor.commit();
  Session session(Document::of(masked));
  Tool tool = toolOf(row(), 5);
  tool.heightMm = 3;
  session.beginStroke(tool);
  for (int i = 0; i <= 20; ++i)
    session.addPoint(0.01 * i, Vec3d(-6 + 0.6 * i, 0.3, std::sqrt(400 - std::pow(-6 + 0.6 * i, 2))));
  session.endStroke();
  const Version version = session.version();
  double moved = 0;
  for (int x = 6; x <= 16; x += 2)
    for (int z = 24; z <= 56; ++z) {
      const Coord voxel{x, 0, z};
      const auto at = [&](const Version& v) {
        return double(v.find(voxel >> 3).phi(Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7), 3));
      };
      moved = std::max(moved, std::abs(at(version) - at(masked)));
    }
  // Redistancing beside the wall is felt a little.
  EXPECT_LT(moved, 0.5) << row().id;
  clay::Surface surface(false);
  surface.update(version);
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed()) << row().id;
}

TEST_P(EveryTool, LeavesMaskedVoxelsToTheBit) {
  const Version ball = clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 20);
  // Half the ball is covered, with a soft rim.
  clay::Editor editor(ball);
  std::array<uint8_t, clay::kBrickVoxels> mask;
  ball.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < clay::kBrickVoxels; ++i)
      mask[size_t(i)] =
          std::abs(brick.phi(i)) < 3 ? uint8_t(std::clamp((brick.coord.x * 8 + (i >> 6) + 4) * 40, 0, 255)) : 0;
    editor.setChannel(clay::Channel::mask, brick.coord, mask);
  });
  const Version masked = editor.commit();
  Session session(Document::of(masked));
  strokeAcross(session, toolOf(row(), 4), {});
  const Version version = session.version();
  uint64_t covered = 0, moved = 0;
  masked.forEachBrick([&](const Brick& brick) {
    const clay::ChannelSlot cover = masked.find(clay::Channel::mask, brick.coord);
    const Slot now = version.find(brick.coord);
    for (int i = 0; i < clay::kBrickVoxels; ++i) {
      if (cover.value(i) != 255) continue;
      ++covered;
      moved += std::bit_cast<uint32_t>(brick.phi(i)) != std::bit_cast<uint32_t>(now.phi(i, 3));
    }
  });
  EXPECT_GT(covered, 10000u);
  EXPECT_EQ(moved, 0u) << row().id;
  const bool does = shapes(row()) && row().id != "morph";
  EXPECT_TRUE(!does || version.hash() != masked.hash()) << row().id << " did nothing beside the mask";
}

TEST_P(EveryTool, DoesSomethingAndLeavesASolidClosed) {
  Session session(Document::of(clay::makeBlock(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), {40, 40, 20}, 2)));
  const uint64_t first = session.version().hash();
  if (row().id == "morph" || row().id == "blend" || row().id == "blur_mask") {
    // There has to be something to go back to, or to soften.
    Tool before = toolOf(*findTool(row().id == "morph" ? "carve" : row().id == "blend" ? "paint" : "mask"), 4);
    session.beginStroke(before);
    session.addPoint(0, {0, 0, 10});
    session.endStroke();
  }
  const uint64_t before = session.version().hash();
  session.beginStroke(toolOf(row(), 4));
  // Over an edge: there every tool finds something to do.
  for (int i = 0; i <= 20; ++i) session.addPoint(0.01 * i, {-2.0 + 1.2 * i, 1 + 0.1 * i, 10.5});
  session.endStroke();
  EXPECT_NE(session.version().hash(), before) << row().id;
  clay::Surface surface;
  surface.update(session.version());
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed()) << row().id;
  while (session.undo()) {
  }
  EXPECT_EQ(session.version().hash(), first);
}

// Clay painted in every channel, in stripes held by a mask with soft rims.
Version paintedAndHeld(const Version& clay) {
  clay::Editor editor(clay);
  std::array<uint8_t, clay::kBrickVoxels> values;
  clay.forEachBrick([&](const Brick& brick) {
    const auto fill = [&](clay::Channel channel, auto&& at) {
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        const Vec3d place = (brick.coord * clay::kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
        values[size_t(i)] = std::abs(brick.phi(i)) < 3 ? uint8_t(std::clamp(at(place), 0.0, 255.0)) : 0;
      }
      editor.setChannel(channel, brick.coord, values);
    };
    for (const clay::Channel channel : clay::kColourChannels)
      fill(channel, [&](const Vec3d& p) { return 40.0 * int(channel) + 2 * p.x() + p.y(); });
    fill(clay::Channel::mask, [](const Vec3d& p) { return 127 + 800 * std::sin(0.1 * p.x()); });
  });
  return editor.commit();
}

// Stamps so large that several threads share their bricks.
TEST_P(EveryTool, DoesTheSameOnAnyCountOfThreads) {
  const Version plain = clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 22);
  for (const Version& ball : {plain, paintedAndHeld(plain)}) {
    const int stamps = ball == plain ? 8 : 4;
    uint64_t hashes[2];
    for (int i = 0; i < 2; ++i) {
      Tool tool = toolOf(row(), 12);
      tool.heightMm = 1;
      clay::BrushStroke stroke(ball, brushOf(tool, ball.grid(), ball), {}, i == 0 ? 1 : 3);
      unsigned times = 0;  // that bricks were computed
      for (int k = 0; k < stamps; ++k) {
        clay::Stamp stamp{Vec3d(2.0 * k, 3, 43), Vec3d(2.0 * k + 2, 3, 43), 32, static_cast<float>(tool.strength)};
        const uint64_t before = stroke.touched();
        stroke.apply(stamp);
        times += stroke.touched() > before;
      }
      EXPECT_TRUE(!shapes(row()) || times > 0);
      hashes[i] = stroke.finish().hash();
      EXPECT_TRUE(!shapes(row()) || stroke.touched() > 75u * times)
          << stroke.touched() << " bricks: too few to be shared";
    }
    EXPECT_EQ(hashes[0], hashes[1]) << row().id << (ball == plain ? "" : " on painted clay, part of it held");
  }
}

// A simulated hand presses the tool into a block and draws it along: the servo answers with a force that stays within
// the device's, and the clay changes.
TEST_P(EveryTool, IsFeltByAHand) {
  Script script;
  script.voxelMm = 0.5;
  script.clay = BlockSetup{{40, 40, 20}, 2, Vec3d::Zero()};
  ScriptStroke stroke;
  stroke.tool = toolOf(row(), 3);
  stroke.drive = Drive::hand;
  // 2 mm into the top at z = 10, over the edge at x = 20 at last.
  const double top = 10 + 3 - 2;
  stroke.path = {{0, {-12, 0, 16}}, {0.3, {-12, 0, top}}, {0.7, {6, 1, top}}, {1.0, {19, 2, top}}, {1.2, {19, 2, 18}}};
  script.strokes = {stroke};
  Session session(prepareClay(clay::Store::make(), script).version);
  if (row().id == "morph" || row().id == "blend" || row().id == "blur_mask") {
    session.beginStroke(toolOf(*findTool(row().id == "morph" ? "carve" : row().id == "blend" ? "paint" : "mask"), 4));
    session.addPoint(0, {0, 0, 10});
    session.endStroke();
  }
  const uint64_t before = session.version().hash();
  clay::Surface surface;
  const RunReport report = runScript(session, surface, script);
  ASSERT_TRUE(report.servo);
  EXPECT_EQ(report.servo->fault, "");
  EXPECT_EQ(report.servo->stopped, 0u);
  EXPECT_GT(report.servo->cutting, 200u) << row().id;
  EXPECT_LE(report.servo->peakForceN, report.servo->forceLimitN);
  EXPECT_TRUE(row().work == haptics::Work::lay || report.servo->peakForceN > 0.05) << row().id << " is not felt";
  EXPECT_NE(session.version().hash(), before) << row().id;
}

std::string nameOf(const ::testing::TestParamInfo<size_t>& info) {
  return std::string(toolTable()[info.param].id);
}
INSTANTIATE_TEST_SUITE_P(Tools, EveryTool, ::testing::Range(size_t{0}, toolTable().size()), nameOf);

uint64_t nodesOf(const clay::TreePlace& place) {
  if (!place.isNode()) return 0;
  uint64_t count = 1;
  for (int i = 0; place.level() > 1 && i < 512; ++i) count += nodesOf(place.child(i));
  return count;
}

// Random strokes of every tool on a ball. Ten thousand in the long tier, as in the project's figures.
TEST(ToolProperty, AfterRandomStrokesTheFieldIsADistanceAndTheSurfaceClosed) {
  const int strokes = tests::byTier(200, 10000);
  constexpr int kCheckEvery = 200;
  Random random(kSeed);
  Version version = clay::makeSphere(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), 22);
  clay::Surface following(true, clay::Grade::fine), live(true, clay::Grade::crisp);
  double sum = 0, worst = 0, outerSum = 0, outerWorst = 0;
  uint64_t count = 0, beyond = 0, outer = 0;
  int done = 0;
  while (done < strokes) {
    Session session(Document::of(version));
    for (int i = 0; i < 50; ++i, ++done) {
      const ToolRow& row = toolTable()[random.below(toolTable().size())];
      Tool tool = toolOf(row, random.between(1.5, 4));
      tool.strength = random.between(0.2, 1);
      tool.inverted = row.opposite == row.id && random.below(2) == 0;
      session.beginStroke(tool);
      // From somewhere on the surface: along a ray from outside.
      Vec3d direction = random.inBall().normalized(), at = direction * 40;
      clay::Sampler sampler(session.version());
      while (at.norm() > 1 && sampler.trilinear(at / 0.5) > 0) at -= 0.25 * direction;
      const size_t points = 1 + random.below(8);
      for (size_t k = 0; k < points; ++k) {
        session.addPoint(0.01 * double(k), at);
        at += tool.radiusMm * random.inBall();
      }
      session.endStroke();
      following.update(session.version());
      live.update(session.version());
    }
    version = session.version();
    if (done % kCheckEvery != 0) continue;
    ASSERT_GT(version.stats().bricks, 100u) << "all was cut away; choose tools that balance";
    clay::Surface anew(true, clay::Grade::fine);
    anew.update(version, 2);
    ASSERT_EQ(anew.hash(), following.hash()) << "after " << done;
    clay::Surface liveAnew(true, clay::Grade::crisp);
    liveAnew.update(version, 2);
    ASSERT_EQ(liveAnew.hash(), live.hash()) << "after " << done;
    ASSERT_TRUE(clay::checkTopology(liveAnew.toMesh()).closed()) << "after " << done;
    const clay::TriangleMesh mesh = anew.toMesh();
    ASSERT_TRUE(clay::checkTopology(mesh).closed()) << "after " << done;
    // Of the distances: channels are paid for by whom uses them.
    const uint64_t nodes = nodesOf(clay::TreePlace::root(version));
    EXPECT_LE(double(version.stats().bricks * sizeof(clay::FloatBrick) + nodes * (512 * 8 + 64)),
              2.3 * 1024 * double(version.stats().bricks));
    // Distances beside the surface, away from creases.
    const clay::NearestTriangle nearest(mesh);
    clay::Sampler sampler(version);
    version.forEachBrick([&](const Brick& brick) {
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        ASSERT_TRUE(std::isfinite(brick.phi(i)));
        const double phi = std::abs(double(brick.phi(i)));
        if (phi >= 2.9 || (i * 7 + brick.coord.x) % 5 != 0) continue;
        const Vec3d p = (brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
        Vec3f g;
        (void)sampler.tricubic(p, g);
        const Vec3d normal = g.cast<double>().normalized(), foot = p - double(brick.phi(i)) * normal;
        if (!(g.squaredNorm() > 0.25f) || !normalsAgree(sampler, foot, normal, kCosine20, {2})) continue;
        const double exact = std::sqrt(nearest.nearest(p * 0.5).squared) / 0.5, error = std::abs(phi - exact);
        if (phi >= 1) {
          // Farther out the distance may be to a part of the surface that lies around a crease: a foot whose normals
          // agree as far as the voxel is away from it is the nearest one.
          if (!normalsAgree(sampler, foot, normal, kCosine20, {4})) continue;
          outerSum += error * error;
          outerWorst = std::max(outerWorst, error);
          ++outer;
          continue;
        }
        sum += error * error;
        worst = std::max(worst, error);
        beyond += error > 0.25;
        ++count;
      }
    });
  }
  std::printf(
      "%d strokes: |phi| against the distance to the surface %.4f voxels RMS, %.3f worst, %.5f %% beyond 0.25, at %llu "
      "voxels\n",
      done, std::sqrt(sum / double(count)), worst, 100.0 * double(beyond) / double(count),
      static_cast<unsigned long long>(count));
  std::printf("the band from 1 to 2.9 voxels: %.4f RMS, %.3f worst, at %llu voxels\n",
              std::sqrt(outerSum / double(outer)), outerWorst, static_cast<unsigned long long>(outer));
  EXPECT_GT(outer, 1000u);
  EXPECT_LE(std::sqrt(outerSum / double(outer)), 0.1);
  EXPECT_LE(outerWorst, 0.5);
  EXPECT_GT(count, 1000u);
  EXPECT_LE(std::sqrt(sum / double(count)), 0.05);
  EXPECT_LE(worst, 0.25);
}

TEST(ToolProperty, AFlickLeavesNoGap) {
  // 2 m/s looked at 60 times a second: 33 mm from point to point.
  Session session(Document::of(clay::makeBlock(clay::Store::make(), gridOf(0.5), Vec3d::Zero(), {200, 30, 20}, 2)));
  session.beginStroke(toolOf(*findTool("carve"), 3));
  for (int i = 0; i <= 5; ++i) session.addPoint(i / 60.0, {-83.0 + 33.3 * i, 0, 10});
  const Version version = session.endStroke();
  clay::Sampler sampler(version);
  for (double x = -83; x <= 83; x += 0.25) EXPECT_NEAR(sampler.trilinear(Vec3d(x, 0, 7) / 0.5), 0, 0.05) << x;
}

}  // namespace
}  // namespace argil::engine
