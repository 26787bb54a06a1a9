// A tool that is slower than the hand: what is shown, what is answered, what is left of the stroke.

#include <gtest/gtest.h>

#include <cmath>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/session/edit_loop.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

using haptics::StylusSample;

const Tool kCarve{"carve", 3};
constexpr double kBallMm = 15;

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kBallMm);
}

// A hand that cuts along a circle on the ball, a sample a millisecond: `count` of them, then ten without the button.
std::vector<StylusSample> circle(size_t count, double mmASample, uint64_t from = 0) {
  std::vector<StylusSample> samples;
  for (size_t i = 0; i < count + 10; ++i) {
    StylusSample sample;
    sample.index = from + i;
    sample.timeS = 0.001 * double(from + i);
    sample.buttons = i < count ? 1 : 0;
    sample.flags = i < count ? haptics::kCutting | haptics::kTouching : 0;
    const double angle = mmASample / kBallMm * double(i);
    sample.cutPoint = sample.proxy = {kBallMm * std::cos(angle), kBallMm * std::sin(angle), 0};
    sample.tool = 1;
    samples.push_back(sample);
  }
  return samples;
}

class EditPace : public ::testing::Test {
 protected:
  struct Shown {
    uint64_t applied;
    uint64_t stamps;  // of the session when it was published
    uint64_t editedFrom;
  };
  void SetUp() override { session.record(); }
  EditLoop& loop(int stamps, int64_t ns = 0) {
    EditLoop::Options options;
    options.budgetStamps = stamps;
    options.budgetNs = ns;
    made = std::make_unique<EditLoop>(
        session, haptics::Scene(),
        [this](std::unique_ptr<const haptics::Scene> scene) {
          scene->check();
          shown.push_back({scene->samplesApplied, session.counts().stamps, scene->editedFrom});
        },
        options);
    made->setTool(kCarve);
    return *made;
  }
  void push(const std::vector<StylusSample>& samples) {
    for (const StylusSample& sample : samples) ASSERT_TRUE(ring.push(sample));
  }
  // The clay of the same points given one after the other.
  uint64_t replayed() {
    Session again(ball());
    for (const ScriptStroke& stroke : session.recording().strokes) {
      again.beginStroke(stroke.tool);
      for (const PathPoint& point : stroke.path) again.addPoint(point);
      again.endStroke();
    }
    return again.version().hash();
  }

  Session session{ball()};
  haptics::SampleRing ring{1000};
  std::vector<Shown> shown;
  std::unique_ptr<EditLoop> made;
};

// A budget of 8: steps of 3 fill it, and none that likely takes more than 12 is begun beside what is worth showing.
TEST(TurnTime, EndsWithItsBudgetOrBeforeALongStep) {
  TurnTime turn(8);
  const auto stepsOf = [&](std::initializer_list<int64_t> lengths) {
    int64_t now = 1000;
    turn.begin(now);
    size_t done = 0;
    for (const int64_t length : lengths) {
      turn.step(now += length);
      ++done;
      if (turn.over()) break;
    }
    return done;
  };
  EXPECT_EQ(stepsOf({3, 3, 3, 3}), 3u);
  EXPECT_EQ(stepsOf({1, 1, 1, 1, 1, 1, 1, 1, 1, 1}), 8u);
  EXPECT_EQ(stepsOf({40, 1}), 1u);
  EXPECT_EQ(stepsOf({1, 1, 1, 1}), 2u) << "after one of 40 another may come";
  EXPECT_EQ(stepsOf({1, 1, 1, 1, 1, 1, 1, 1, 1}), 8u) << "it is forgotten in time";
  TurnTime free(0);
  free.begin(0);
  free.step(1'000'000);
  EXPECT_FALSE(free.over());
}

TEST_F(EditPace, ATurnEndsWithItsBudgetAndTheClayIsShownMeanwhile) {
  EditLoop& edit = loop(5);
  push(circle(400, 0.3));
  size_t turns = 0;
  uint64_t before = 0;
  do {
    edit.turn(ring);
    ASSERT_LE(session.counts().stamps - before, 7u) << "the end of a path has two stamps more at most";
    before = session.counts().stamps;
    ++turns;
    ASSERT_LT(turns, 1000u);
  } while (edit.behind());
  EXPECT_GT(turns, 40u);
  EXPECT_GE(shown.size(), turns - 1) << "every turn shows what it did";
  for (size_t i = 1; i < shown.size(); ++i) EXPECT_GE(shown[i].applied, shown[i - 1].applied);
  edit.finish();
  EXPECT_EQ(session.undoSteps(), 1u);
  // The same clay as of a loop that does all at once, and as of what was recorded.
  EXPECT_EQ(replayed(), session.version().hash());
  Session other(ball());
  EditLoop all(other, haptics::Scene(), [](auto) {}, {});
  all.setTool(kCarve);
  push(circle(400, 0.3));
  all.turn(ring);
  EXPECT_FALSE(all.behind());
  all.finish();
  EXPECT_EQ(other.version().hash(), session.version().hash());
}

// The servo learns which of its samples changed the clay that it feels now.
TEST_F(EditPace, EachSceneNamesTheOldestSampleThatIsNewInIt) {
  EditLoop& edit = loop(0);
  const std::vector<StylusSample> hand = circle(100, 0.3);
  push({hand.begin(), hand.begin() + 40});
  edit.turn(ring);
  push({hand.begin() + 40, hand.end()});
  edit.turn(ring);
  std::vector<uint64_t> from;
  for (const Shown& each : shown) from.push_back(each.editedFrom);
  ASSERT_GE(from.size(), 2u);
  EXPECT_LT(from[from.size() - 2], 40u);
  EXPECT_GE(from.back(), 39u);
  EXPECT_LT(from.back(), 100u);
  // A scene that shows no other clay, as of another tool, names what it named.
  edit.setTool({"add", 2});
  edit.turn(ring);
  EXPECT_EQ(shown.back().editedFrom, from.back());
}

TEST_F(EditPace, ATurnOfSpentTimeStillDoesAStamp) {
  EditLoop& edit = loop(0, 1);
  push(circle(60, 0.3));
  size_t turns = 0;
  do edit.turn(ring);
  while (edit.behind() && ++turns < 5000);
  EXPECT_GT(turns, 50u);
  edit.finish();
  EXPECT_EQ(replayed(), session.version().hash());
  EXPECT_EQ(edit.strokes().samplesApplied(), 70u);
}

TEST_F(EditPace, AStrokeThatIsCutShortIsWhatWasRecorded) {
  EditLoop& edit = loop(4);
  const std::vector<StylusSample> hand = circle(500, 0.3);
  push({hand.begin(), hand.begin() + 450});  // the button is still down
  for (int i = 0; i < 6; ++i) edit.turn(ring);
  ASSERT_TRUE(edit.behind());
  EXPECT_GT(edit.behindS(), 0.3);
  const uint64_t stamps = session.counts().stamps;
  EXPECT_GT(edit.cutShort(), 0.3);
  EXPECT_LE(session.counts().stamps, stamps + 4);
  EXPECT_FALSE(edit.behind());
  EXPECT_FALSE(session.inStroke());
  ASSERT_EQ(session.undoSteps(), 1u);
  EXPECT_EQ(replayed(), session.version().hash());
  const uint64_t left = session.version().hash();
  EXPECT_NE(left, ball().hash());
  // The hand that still holds the button does not begin another stroke: the user would see what was just undone done
  // again.
  push({hand.begin() + 450, hand.end()});
  edit.turn(ring);
  EXPECT_EQ(session.version().hash(), left);
  EXPECT_EQ(session.undoSteps(), 1u);
  push(circle(40, 0.3, 600));
  while (edit.turn(ring) || edit.behind()) {
  }
  EXPECT_EQ(session.undoSteps(), 2u);
  EXPECT_EQ(replayed(), session.version().hash());
}

// Twenty seconds of a hand of which the tool can follow a tenth.
TEST_F(EditPace, SamplesFarBehindBecomeOneAndNoPartOfTheWayIsLost) {
  EditLoop& edit = loop(1);
  const double mmASample = 0.02;
  const std::vector<StylusSample> hand = circle(20'000, mmASample);
  size_t most = 0;
  for (size_t i = 0; i < hand.size(); ++i) {
    ASSERT_TRUE(ring.push(hand[i])) << "the ring is emptied in every turn";
    if (i % 100 == 99) edit.turn(ring);
    most = std::max(most, edit.waiting());
  }
  EXPECT_GT(edit.behindS(), 5);
  EXPECT_GT(edit.coalesced(), 1000u);
  EXPECT_LT(most, 6000u);
  EXPECT_EQ(edit.lost(), 0u);
  edit.gather(ring);
  edit.finish();
  EXPECT_EQ(edit.strokes().samplesApplied(), hand.size());
  EXPECT_EQ(session.undoSteps(), 1u);
  EXPECT_EQ(session.recording().strokes.size(), 1u) << "the tool was never lifted";
  EXPECT_EQ(replayed(), session.version().hash());
  // Where the hand went the clay is gone as if all samples had been followed: to the error of half a stamp's way in a
  // curve of 15 mm.
  Session exact(ball());
  EditLoop all(exact, haptics::Scene(), [](auto) {}, {});
  all.setTool(kCarve);
  for (const StylusSample& sample : hand) {
    ring.push(sample);
    if (sample.index % 1000 == 0) all.turn(ring);
  }
  all.turn(ring);
  all.finish();
  size_t compared = 0;
  float worst = 0;
  const clay::Version a = exact.version(), b = session.version();
  a.forEachBrick([&](const clay::Brick& brick) {
    const clay::Slot other = b.find(brick.coord);
    for (int v = 0; v < clay::kBrickVoxels; ++v) {
      const float phi = brick.phi(v);
      if (std::abs(phi) > 1) continue;
      worst = std::max(worst, std::abs(phi - other.phi(v, a.grid().band)));
      ++compared;
    }
  });
  EXPECT_GT(compared, 1000u);
  EXPECT_LT(worst, 0.05f);
}

TEST_F(EditPace, WhatTheRingHadNoRoomForIsCounted) {
  EditLoop& edit = loop(0);
  edit.turn(ring);
  const size_t room = ring.capacity();
  for (const StylusSample& sample : circle(room + 90, 0.02)) ring.push(sample);
  edit.turn(ring);
  EXPECT_EQ(edit.lost(), 100u);
}

// A mouse that jumps: the way to it is worked off in parts, without a gap.
TEST_F(EditPace, AJumpIsReachedInPieces) {
  std::vector<StylusSample> hand = circle(20, 0.1);
  for (size_t i = 10; i < hand.size(); ++i) hand[i].cutPoint = {-kBallMm, 0.1 * double(i), 0};
  EditLoop& edit = loop(3);
  push(hand);
  size_t turns = 0;
  uint64_t before = 0, most = 0;
  do {
    edit.turn(ring);
    most = std::max(most, session.counts().stamps - before);
    before = session.counts().stamps;
  } while (edit.behind() && ++turns < 1000);
  EXPECT_GT(turns, 20u);
  EXPECT_LE(most, 25u) << "a piece of the way ends the stroke at most";
  // The pieces are of one length, from where the hand was to where it is.
  const std::vector<PathPoint> path = session.recording().strokes.at(0).path;
  double longest = 0;
  for (size_t i = 1; i < path.size(); ++i) longest = std::max(longest, (path[i].mm - path[i - 1].mm).norm());
  EXPECT_LT(longest, 2.5 * kCarve.radiusMm);
  edit.finish();
  EXPECT_EQ(replayed(), session.version().hash());
  const float middle = session.version().find(Coord{0, 0, 0}).phi(clay::Brick::offset(0, 2, 0), 3);
  EXPECT_GT(middle, 2) << "the way goes through the middle of the ball";
}

class BusyWorkbench : public ::testing::Test {
 protected:
  static Workbench::Options options() {
    Workbench::Options given = withoutJournal();
    given.stampsATurn = 1;
    return given;
  }
  void SetUp() override {
    bench.addBlock({40, 40, 20}, 2, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1 && bench.idle(); }));
    Tool tool;
    tool.radiusMm = 0.5;
    bench.setTool(tool);
  }
  // To and fro over the block, fast, with the button down at the end: every stamp of the smallest tool takes a turn.
  void scribble() {
    for (int i = 0; i < 40; ++i) finger.feed(-15, 0, -8);
    for (int i = 0; i < 60; ++i) finger.feed(-15, 1, 1);
    for (int i = 0; i < 400; ++i) finger.feed(-15 + std::abs(i % 40 - 20) * 1.5, 1, 1);
  }
  std::string said() {
    for (const Message& message : bench.takeMessages()) all += message.text + "\n";
    return all;
  }
  std::string all;
  Workbench bench{options()};
  Finger finger{bench};
};

TEST_F(BusyWorkbench, UndoAnswersWhileTheToolIsBehindTheHand) {
  const clay::Version before = bench.snapshot()->document->pieces[0].version;
  scribble();
  ASSERT_TRUE(until([&] { return said().find("cannot keep up") != std::string::npos; })) << all;
  EXPECT_TRUE(bench.snapshot()->inStroke);
  // The button is still down. Undo does not wait for it, nor for the seconds of scribbling that the clay does not show
  // yet.
  bench.undo();
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces[0].version == before; }));
  EXPECT_NE(said().find("the stroke ends where the clay was"), std::string::npos) << all;
  EXPECT_FALSE(bench.snapshot()->inStroke);
  finger.feed(-15, 0, 1);
  ASSERT_TRUE(until([&] { return bench.idle(); }));
  EXPECT_EQ(bench.snapshot()->document->pieces[0].version, before);
}

TEST_F(BusyWorkbench, AToolThatIsBehindAgainIsToldAgain) {
  for (size_t times = 1; times <= 2; ++times) {
    scribble();
    const auto told = [&] {
      size_t count = 0;
      for (size_t at = said().find("cannot keep up"); at != std::string::npos; at = all.find("cannot keep up", at + 1))
        ++count;
      return count;
    };
    ASSERT_TRUE(until([&] { return told() == times; })) << all;
    finger.feed(-15, 0, 1);
    ASSERT_TRUE(until([&] { return bench.idle(); }));
    EXPECT_EQ(told(), times) << "once for each stroke: " << all;
  }
}

TEST_F(BusyWorkbench, StopEndsTheStrokeWhereTheClayIs) {
  scribble();
  ASSERT_TRUE(until([&] { return said().find("cannot keep up") != std::string::npos; })) << all;
  bench.stopForces();
  ASSERT_TRUE(until([&] { return bench.idle(); })) << "nothing is left to be done";
  EXPECT_NE(said().find("Stopped: the stroke ends where the clay was"), std::string::npos) << all;
  EXPECT_EQ(bench.snapshot()->done, 2u);
}

}  // namespace
}  // namespace argil::engine
