// What a stroke leaves depends on its points alone.

#include <gtest/gtest.h>

#include "clay/field/primitives.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/saving/session.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

constexpr uint64_t kSeed = 20261120;
const size_t kStrokes = tests::byTier<size_t>(500, 1000);

class SessionProperty : public ::testing::Test {
 protected:
  void SetUp() override { RecordProperty("seed", std::to_string(kSeed)); }

  static clay::Version ball() {
    clay::Grid grid;
    grid.voxelMm = 1;
    return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 25);
  }
  static Script scene(size_t strokes) {
    return randomScript(kSeed, {.strokes = strokes, .reachMm = 28, .maxRadiusMm = 5});
  }

  static void run(Session& session, const Script& script) {
    for (const ScriptStroke& stroke : script.strokes) {
      session.beginStroke(stroke.tool);
      for (const PathPoint& point : stroke.path) session.addPoint(point.timeS, point.mm);
      session.endStroke();
    }
  }
};

TEST_F(SessionProperty, UndoingAllGivesBackTheFirstAndRedoingAllTheLast) {
  Session session(ball());
  std::vector<uint64_t> hashes = {session.version().hash()};
  for (const ScriptStroke& stroke : scene(kStrokes).strokes) {
    Script one;
    one.strokes = {stroke};
    const size_t steps = session.undoSteps();
    run(session, one);
    if (session.undoSteps() > steps) hashes.push_back(session.version().hash());
  }
  ASSERT_GT(hashes.size(), 8 * kStrokes / 10);
  for (size_t i = hashes.size() - 1; i-- > 0;) {
    ASSERT_TRUE(session.undo());
    ASSERT_EQ(session.version().hash(), hashes[i]) << i;
  }
  ASSERT_FALSE(session.undo());
  for (size_t i = 1; i < hashes.size(); ++i) {
    ASSERT_TRUE(session.redo());
    ASSERT_EQ(session.version().hash(), hashes[i]) << i;
  }
  ASSERT_FALSE(session.redo());
}

TEST_F(SessionProperty, TheIncrementalSurfaceEqualsTheWholeOne) {
  Session session(ball());
  clay::Surface following[3];
  constexpr int kThreads[3] = {1, 2, 4};
  const auto compare = [&](size_t stroke) {
    clay::Surface whole;
    whole.update(session.version());
    for (int i = 0; i < 3; ++i)
      ASSERT_EQ(following[i].hash(), whole.hash()) << kThreads[i] << " threads, stroke " << stroke;
  };
  const Script script = scene(kStrokes);
  for (size_t i = 0; i < script.strokes.size(); ++i) {
    Script one;
    one.strokes = {script.strokes[i]};
    run(session, one);
    for (int k = 0; k < 3; ++k) following[k].update(session.version(), kThreads[k]);
    if (i % 100 == 99) {
      ASSERT_NO_FATAL_FAILURE(compare(i));
    }
  }
  while (session.undo()) following[0].update(session.version());
  clay::Surface first;
  first.update(ball());
  EXPECT_EQ(following[0].hash(), first.hash());
}

TEST_F(SessionProperty, TheResultDoesNotDependOnWhenVersionsArePublished) {
  const Script script = scene(150);
  Session plain(ball());
  run(plain, script);
  for (const size_t every : {1, 2, 7, 0}) {  // 0: at random
    Session session(ball());
    Random random(kSeed);
    std::vector<clay::Version> pinned;  // also by whether somebody holds them
    size_t count = 0;
    for (const ScriptStroke& stroke : script.strokes) {
      session.beginStroke(stroke.tool);
      for (const PathPoint& point : stroke.path) {
        session.addPoint(point.timeS, point.mm);
        ++count;
        if (every == 0 ? random.below(3) == 0 : count % every == 0) {
          const clay::Version version = session.publish();
          if (random.below(2) == 0) pinned.push_back(version);
        }
      }
      session.endStroke();
    }
    ASSERT_EQ(session.version().hash(), plain.version().hash()) << "published every " << every;
  }
}

TEST_F(SessionProperty, TheRecordingReplaysToTheSameBits) {
  Session session(ball());
  session.record();
  Random random(kSeed);
  for (const ScriptStroke& stroke : scene(120).strokes) {
    session.beginStroke(stroke.tool);
    for (const PathPoint& point : stroke.path) {
      if (random.below(6) == 0) session.liftTool();
      session.addPoint(point.timeS, point.mm);
      if (random.below(2) == 0) session.publish();
    }
    session.endStroke();
    if (random.below(5) == 0) session.undo();
  }
  Session replayed(ball());
  run(replayed, parseScript(formatScript(session.recording()), "recording"));
  EXPECT_EQ(replayed.version().hash(), session.version().hash());
  EXPECT_NE(replayed.version().hash(), ball().hash());
}

// An hour of work in small: strokes, all undone, other strokes, again and again.
TEST(LongSession, MemoryDoesNotGrowWithWhatWasUndone) {
  clay::Grid grid;
  grid.voxelMm = 1;
  const auto store = clay::Store::make();
  Session session(clay::makeSphere(store, grid, Vec3d::Zero(), 25));
  const uint64_t first = session.version().hash();
  uint64_t most = 0;
  for (uint64_t round = 0; round < 40; ++round) {
    for (const ScriptStroke& stroke :
         randomScript(kSeed + round, {.strokes = 300, .reachMm = 28, .maxRadiusMm = 5}).strokes) {
      session.beginStroke(stroke.tool);
      for (const PathPoint& point : stroke.path) {
        session.addPoint(point.timeS, point.mm);
        session.publish();
      }
      session.endStroke();
      // Not left to the thread that frees: how far it trails on a busy machine is no growth.
      while (store->collect()) {
      }
    }
    while (session.undo()) {
    }
    ASSERT_EQ(session.version().hash(), first);
    while (store->collect()) {
    }
    if (round < 5) most = std::max(most, store->usage().slabBytes);
  }
  EXPECT_LE(store->usage().slabBytes, most + most / 2);
}

}  // namespace
}  // namespace argil::engine
