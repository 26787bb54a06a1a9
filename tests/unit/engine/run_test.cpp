#include "engine/session/run.h"

#include <gmock/gmock.h>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "engine/models/prepare_clay.h"

namespace argil::engine {
namespace {

using ::testing::HasSubstr;

constexpr const char* kSetup = R"("setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [40, 40, 20], "round_mm": 2}}], )";

Script script(const std::string& strokes) {
  return parseScript(R"({"argil": 1, "units": "mm", )" + std::string(kSetup) + "\"strokes\": [" + strokes + "]}",
                     "test");
}

// A ball of 3 mm pressed 2 mm into the top of the block (z = 10) and drawn along x; a lump added; the edge smoothed.
const std::string kCarve =
    R"({"tool": "carve", "radius_mm": 3, "drive": "hand", "path": [[0,-12,0,16],[0.3,-12,0,11],[0.8,12,0,11],[1.0,12,0,16]]})";
const std::string kAdd = R"({"tool": "add", "radius_mm": 2, "drive": "hand", "path": [[0,0,12,10],[0.3,6,12,10]]})";
const std::string kSmooth =
    R"({"tool": "smooth", "radius_mm": 4, "drive": "hand", "path": [[0,-12,8,16],[0.2,-12,4,10],[0.6,12,4,10],[0.8,12,4,16]]})";
const std::string kTip = R"({"tool": "carve", "radius_mm": 2, "path": [[0,-15,-15,10],[1,15,-15,10]]})";

struct Ran {
  explicit Ran(const Script& what, const RunOptions& options = {})
      : session(prepareClay(clay::Store::make(), what).version), report(runScript(session, surface, what, options)) {}
  Session session;
  clay::Surface surface;
  RunReport report;
};

// Where the surface lies below a point of the top, mm: marching down the field.
double topAt(const clay::Version& version, double x, double y) {
  clay::Sampler sampler(version);
  for (double z = 14; z > -10; z -= 0.05) {
    if (sampler.trilinear(version.grid().toVoxel({x, y, z})) < 0) return z;
  }
  return -10;
}

TEST(PrepareClay, MakesTheScriptsShape) {
  const PreparedClay block = prepareClay(clay::Store::make(), script(""));
  EXPECT_EQ(block.version.grid().voxelMm, 0.5);
  EXPECT_NEAR(topAt(block.version, 0, 0), 10, 0.06);
  EXPECT_EQ(prepareClay(clay::Store::make(), script(""), {.voxelMm = 1.0}).version.grid().voxelMm, 1);
}

// The voxels lie about the shape's middle: it is the same clay wherever it stands.
TEST(PrepareClay, AShapeIsTheSameClayWhereverItStands) {
  for (const std::string shape :
       {R"("block": {"size_mm": [21, 13, 8], "round_mm": 2)", R"("sphere": {"radius_mm": 7)"}) {
    const auto at = [&](const std::string& centre) {
      return prepareClay(clay::Store::make(),
                         parseScript(R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.5}, {)" + shape +
                                         ", \"centre_mm\": " + centre + R"(}}], "strokes": []})",
                                     "test"))
          .version;
    };
    const clay::Version here = at("[0, 0, 0]"), there = at("[3.3, -1000.1, 0.17]");
    EXPECT_EQ(there.grid().originMm, Vec3d(3.3, -1000.1, 0.17)) << shape;
    EXPECT_EQ(there.stats().bricks, here.stats().bricks);
    clay::Surface of[2];
    of[0].update(here);
    of[1].update(there);
    EXPECT_EQ(of[1].hash(), of[0].hash()) << shape;
  }
}

TEST(PrepareClay, RefusesAScriptWithoutClay) {
  try {
    (void)prepareClay(clay::Store::make(), Script());
    FAIL() << "nothing was wrong";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("sets up no clay"));
  }
}

TEST(RunScript, TipStrokesGiveTheSameClayHoweverTheyArePublished) {
  const Script tip = script(kTip + "," + kTip);
  const Ran once(tip), often(tip, {.pointsPerVersion = 1});
  EXPECT_EQ(once.session.version().hash(), often.session.version().hash());
  EXPECT_EQ(once.surface.hash(), often.surface.hash());
  EXPECT_EQ(once.report.strokes, 2u);
  EXPECT_EQ(once.report.points, 4u);
  EXPECT_GT(once.report.stamps, 100u);
  EXPECT_GT(once.report.edit.n, 0u);
  // Each publishing is a version whose surface is followed and told.
  EXPECT_EQ(often.report.versions, 6u) << "two points and an end, twice";
  EXPECT_EQ(often.report.edit.n, 6u);
  EXPECT_GT(once.report.edit.median, 0);
  EXPECT_FALSE(once.report.servo);
  EXPECT_NEAR(topAt(once.session.version(), 0, -15), 8, 0.1);
}

TEST(RunScript, AReportCountsItsOwnRunAlone) {
  Session session(prepareClay(clay::Store::make(), script(kTip)).version);
  clay::Surface surface;
  const RunReport first = runScript(session, surface, script(kTip + "," + kTip), {});
  const RunReport second = runScript(session, surface, script(kTip), {});
  EXPECT_EQ(first.strokes, 2u);
  EXPECT_EQ(second.strokes, 1u);
  EXPECT_EQ(second.points, 2u);
  EXPECT_LT(second.stamps, first.stamps);
}

TEST(RunScript, WhatIsSeenFollowsEveryOperation) {
  const Script turned = script(kTip + R"(, {"operation": "smooth-all", "passes": 2})");
  int told = 0;
  clay::Surface followed;
  RunOptions options;
  options.onSurface = [&](const clay::SurfaceDelta&) { ++told; };
  const Ran ran(turned, options);
  followed.update(ran.session.version());
  EXPECT_EQ(ran.surface.hash(), followed.hash()) << "the operation is not in the picture";
  const Ran without(script(kTip), {});
  EXPECT_NE(without.surface.hash(), ran.surface.hash());
  EXPECT_EQ(told, int(ran.report.versions) + 1) << "and it is told";
}

TEST(RunScript, HandStrokesInVirtualTimeAreRepeatable) {
  const Script hand = script(kCarve + "," + kTip + "," + kSmooth + "," + kAdd);
  const Ran first(hand), second(hand), threads(hand, {.surfaceThreads = 2});
  EXPECT_EQ(first.session.version().hash(), second.session.version().hash());
  EXPECT_EQ(first.surface.hash(), threads.surface.hash());
  EXPECT_EQ(first.session.undoSteps(), 4u);
  EXPECT_EQ(first.report.strokes, 4u);
  ASSERT_TRUE(first.report.servo);
  EXPECT_EQ(first.report.servo->ticks, second.report.servo->ticks);
  EXPECT_EQ(first.report.servo->peakForceN, second.report.servo->peakForceN);
  EXPECT_EQ(first.report.servo->dropped, 0u);
  EXPECT_EQ(first.report.servo->fault, "");
  EXPECT_FALSE(first.report.servo->lateness);

  // Each tool did its work: a groove less deep than the hand asked for (2 mm below the top), a lump.
  EXPECT_LT(topAt(first.session.version(), 0, 0), 9.9);
  EXPECT_GT(topAt(first.session.version(), 0, 0), 7.9);
  EXPECT_GT(topAt(first.session.version(), 3, 12), 11);
  EXPECT_GT(first.report.servo->peakForceN, 0.3);
  EXPECT_LE(first.report.servo->peakForceN, first.report.servo->forceLimitN);
}

TEST(RunScript, ARunByHandReplaysFromItsRecording) {
  const Script hand = script(kCarve + "," + kAdd);
  Ran ran(hand);
  Script recording = ran.session.recording();
  recording.clay = hand.clay;
  const Ran replayed(parseScript(formatScript(recording), "recording"));
  EXPECT_EQ(replayed.session.version().hash(), ran.session.version().hash());
  EXPECT_EQ(replayed.surface.hash(), ran.surface.hash());
}

TEST(RunScript, TheDelayOfPublishingChangesLittleOfWhatIsCut) {
  const Script hand = script(kCarve);
  const Ran soon(hand, {.publishDelayS = 0}), late(hand, {.publishDelayS = 0.03});
  EXPECT_NE(soon.session.version().hash(), late.session.version().hash());
  for (double x = -10; x <= 10; x += 2) {
    EXPECT_NEAR(topAt(soon.session.version(), x, 0), topAt(late.session.version(), x, 0), 0.3) << x;
  }
}

// What a run had told of its progress whenever the picture changed, and at the end.
std::vector<double> progressOf(const Script& what) {
  Session session(prepareClay(clay::Store::make(), what).version);
  clay::Surface surface;
  Job job;
  RunOptions options;
  options.job = &job;
  std::vector<double> told;
  options.onSurface = [&](const clay::SurfaceDelta&) { told.push_back(job.fraction()); };
  (void)runScript(session, surface, what, options);
  told.push_back(job.fraction());
  return told;
}

TEST(RunScript, ProgressGrowsFromNothingToAll) {
  const std::string operation = R"({"operation": "smooth-all", "passes": 1})";
  std::vector<double> told = progressOf(script(kTip + "," + operation + "," + kTip + "," + operation + "," + kTip));
  EXPECT_EQ(told.back(), 1);
  std::erase(told, 1);  // An operation tells of itself, from 0 to 1.
  ASSERT_GE(told.size(), 3u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << ::testing::PrintToString(told);
  EXPECT_GE(told.front(), 0);
  EXPECT_NEAR(told.back(), 0.8, 1e-9) << "two strokes and two operations of five came before";
}

TEST(RunScript, ProgressGrowsAlongAStrokeOfAHand) {
  const std::vector<double> told = progressOf(script(kCarve + "," + kSmooth));
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << ::testing::PrintToString(told);
  const auto between = std::count_if(told.begin(), told.end(), [](double f) { return f > 0.1 && f < 0.9; });
  EXPECT_GT(between, 4) << ::testing::PrintToString(told);
  EXPECT_EQ(told.back(), 1);
}

TEST(RunScript, ACancelledRunLeavesNoStrokeOpen) {
  for (const std::string& strokes : {kCarve, kTip}) {
    const Script what = script(strokes + "," + strokes);
    Session session(prepareClay(clay::Store::make(), what).version);
    clay::Surface surface;
    Job job;
    RunOptions options;
    options.job = &job;
    options.onSurface = [&](const clay::SurfaceDelta& delta) {
      if (!delta.changed.empty()) job.cancel();
    };
    EXPECT_THROW(runScript(session, surface, what, options), Cancelled);
    EXPECT_FALSE(session.inStroke());
    EXPECT_LE(session.undoSteps(), 1u);
  }
}

TEST(RunScript, LiveStrokesGoThroughTheServoInRealTime) {
  const Ran live(script(kCarve), {.live = true});
  ASSERT_TRUE(live.report.servo);
  const ServoReport& servo = *live.report.servo;
  EXPECT_GT(live.report.seconds, 1.0);
  EXPECT_LT(live.report.seconds, 10);
  EXPECT_NEAR(double(servo.ticks + servo.missed), 1200, 150);
  ASSERT_TRUE(servo.lateness);
  ASSERT_TRUE(servo.bareLateness);
  EXPECT_GT(servo.lateness->n, 500u);
  EXPECT_GT(servo.bareLateness->n, 500u);
  EXPECT_NE(servo.grant, "");
  EXPECT_EQ(servo.dropped, 0u);
  EXPECT_GT(live.report.edit.n, 10u);
  EXPECT_LE(servo.peakForceN, servo.forceLimitN);
  EXPECT_LT(topAt(live.session.version(), 0, 0), 9.9);
  clay::Surface whole;
  whole.update(live.session.version());
  EXPECT_EQ(live.surface.hash(), whole.hash());
}

// The servo rests while a stroke of the tip is done; the hand is left, and goes on, deep in the clay.
TEST(RunScript, LiveStrokesGoOnWhereTheHandWasLeftPressed) {
  const std::string first =
      R"({"tool": "carve", "radius_mm": 3, "drive": "hand", "path": [[0,-12,0,16],[0.3,-12,0,8],[0.8,-4,0,8]]})";
  const std::string then = R"({"tool": "carve", "radius_mm": 3, "drive": "hand", "path": [[0,-4,0,8],[0.6,8,0,8]]})";
  const Ran live(script(first + ", " + kTip + ", " + then), {.live = true});
  ASSERT_TRUE(live.report.servo);
  EXPECT_LT(topAt(live.session.version(), -8, 0), 9.5);
  EXPECT_LT(topAt(live.session.version(), 4, 0), 9.5);
}

TEST(RunScript, RefusesADeviceThatIsNotThere) {
  EXPECT_THROW(Ran(script(kCarve), {.device = "broom"}), Error);
}

}  // namespace
}  // namespace argil::engine
