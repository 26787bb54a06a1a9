#include "engine/session/stylus_strokes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/random.h"
#include "engine/session/edit_loop.h"

namespace argil::engine {
namespace {

using haptics::StylusSample;

const Tool kCarve{"carve", 3};

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 15);
}

// Samples of a millisecond each; a letter each: c cuts along a circle on the ball, t touches with the button down, . is
// free.
std::vector<StylusSample> samples(const std::string& what, uint32_t tool = 1) {
  std::vector<StylusSample> result;
  for (size_t i = 0; i < what.size(); ++i) {
    StylusSample sample;
    sample.index = i;
    sample.timeS = 0.001 * double(i);
    sample.buttons = what[i] == '.' ? 0 : 1;
    sample.flags = what[i] == 'c' ? haptics::kCutting | haptics::kTouching : 0;
    sample.cutPoint = {15 * std::cos(0.01 * double(i)), 15 * std::sin(0.01 * double(i)), 0};
    sample.tool = tool;
    result.push_back(sample);
  }
  return result;
}

struct Taken {
  explicit Taken(const std::vector<StylusSample>& all) : session(ball()), strokes(session) {
    session.record();
    strokes.setTool(1, kCarve);
    strokes.setTool(2, {"add", 2, 1});
    for (const StylusSample& sample : all) strokes.take(sample);
    strokes.finish();
  }
  Session session;
  StylusStrokes strokes;
};

std::string repeat(const std::string& what, size_t times) {
  std::string all;
  for (size_t i = 0; i < times; ++i) all += what;
  return all;
}

TEST(StylusStrokes, AButtonPressIsAStroke) {
  const Taken taken(samples("..cccccccccc...cccccccc.."));
  EXPECT_EQ(taken.session.undoSteps(), 2u);
  EXPECT_EQ(taken.session.recording().strokes.size(), 2u);
  EXPECT_EQ(taken.strokes.samplesApplied(), 25u);
}

TEST(StylusStrokes, APieceThatStandsElsewhereIsCutWhereItStands) {
  const Vec3d to(40, -7, 3);
  Document document;
  Piece piece;
  piece.version = ball();
  piece.pose.translation = to;
  document.add(piece);
  Session session(document);
  StylusStrokes strokes(session);
  strokes.setTool(1, kCarve);
  std::vector<StylusSample> there = samples("..cccccccccc..");
  for (StylusSample& sample : there) {
    sample.cutPoint += to;
    strokes.take(sample);
  }
  strokes.finish();
  EXPECT_EQ(strokes.refused(), 0u);
  EXPECT_EQ(session.version().hash(), Taken(samples("..cccccccccc..")).session.version().hash());
}

TEST(StylusStrokes, TouchingWithoutCuttingLeavesTheClayAlone) {
  const Taken taken(samples("..tttttt..ttt"));
  EXPECT_EQ(taken.session.undoSteps(), 0u);
  EXPECT_EQ(taken.session.version().hash(), ball().hash());
  EXPECT_EQ(taken.strokes.samplesApplied(), 13u);
}

TEST(StylusStrokes, ALightPressThatFlickersIsOnePath) {
  const Taken taken(samples(repeat("cct", 40)));
  EXPECT_EQ(taken.session.recording().strokes.size(), 1u);
}

TEST(StylusStrokes, APauseLiftsTheTool) {
  const Taken taken(samples(repeat("c", 20) + repeat("t", 30) + repeat("c", 20)));
  EXPECT_EQ(taken.session.undoSteps(), 1u);
  EXPECT_EQ(taken.session.recording().strokes.size(), 2u);
}

TEST(StylusStrokes, AJumpInAPauseLiftsTheTool) {
  auto all = samples("cccccttccccc");
  for (size_t i = 7; i < all.size(); ++i) all[i].cutPoint = {0, 0, 15.0};
  const Taken taken(all);
  EXPECT_EQ(taken.session.recording().strokes.size(), 2u);
  // nothing was cut on the way
  EXPECT_EQ(taken.session.version().find(Coord{1, 0, 1}), clay::Slot(clay::Tile::inside));
}

TEST(StylusStrokes, AnotherToolIsAnotherStroke) {
  auto all = samples("cccccccccc");
  for (size_t i = 5; i < all.size(); ++i) all[i].tool = 2;
  const Taken taken(all);
  EXPECT_EQ(taken.session.undoSteps(), 2u);
  ASSERT_EQ(taken.session.recording().strokes.size(), 2u);
  EXPECT_EQ(taken.session.recording().strokes[1].tool.radiusMm, 2);
}

TEST(StylusStrokes, RefusesSamplesThatCannotCut) {
  auto all = samples("cccccccccc");
  all[3].cutPoint.x() = NAN;
  all[4].cutPoint.y() = 1e300;
  all[9].tool = 7;
  const Taken taken(all);
  EXPECT_EQ(taken.strokes.refused(), 3u);
  EXPECT_EQ(taken.session.undoSteps(), 1u);
  EXPECT_THROW(StylusStrokes(*std::make_unique<Session>(ball())).setTool(1, {"carve", 1e9, 1}), Error);
}

TEST(StylusStrokes, SamplesAreAppliedInOrderAndAllInTheEnd) {
  Session session(ball());
  StylusStrokes strokes(session);
  strokes.setTool(1, kCarve);
  uint64_t before = 0;
  for (const StylusSample& sample : samples(repeat("c", 300) + repeat("t", 5) + repeat("c", 50) + "..")) {
    strokes.take(sample);
    EXPECT_GE(strokes.samplesApplied(), before);
    EXPECT_LE(strokes.samplesApplied(), sample.index + 1);
    // 0.15 mm a sample and stamps of 0.3 mm: they trail by a few samples at most.
    EXPECT_GE(strokes.samplesApplied() + 12, sample.index);
    before = strokes.samplesApplied();
  }
  EXPECT_EQ(before, 357u);
}

class EditLoopTest : public ::testing::Test {
 protected:
  // What comes out when `batch` samples wait at a time (0: at random).
  struct Result {
    uint64_t clay, surface;
    std::vector<uint64_t> applied;
    size_t scenes;
  };
  static Result run(const std::vector<StylusSample>& all, size_t batch) {
    Session session(ball());
    clay::Surface surface;
    surface.update(session.version());
    haptics::SampleRing ring(1000);
    Result result{};
    EditLoop::Options options;
    options.onDocument = [&](const DocumentPtr& document, int64_t) { surface.update(document->pieces[0].version); };
    EditLoop loop(
        session, haptics::Scene(),
        [&](std::unique_ptr<const haptics::Scene> scene) {
          scene->check();
          result.applied.push_back(scene->samplesApplied);
          ++result.scenes;
        },
        options);
    loop.setTool(kCarve);
    Random random(5);
    size_t count = 0;
    for (const StylusSample& sample : all) {
      ring.push(sample);
      if (batch ? ++count % batch == 0 : random.below(9) == 0) loop.turn(ring);
    }
    loop.turn(ring);
    loop.finish();
    clay::Surface whole;
    whole.update(session.version());
    EXPECT_EQ(surface.hash(), whole.hash());
    EXPECT_EQ(loop.versions(), result.scenes);
    result.clay = session.version().hash();
    result.surface = surface.hash();
    return result;
  }
};

TEST_F(EditLoopTest, TheResultDoesNotDependOnHowSamplesWereBatched) {
  const auto all =
      samples(repeat(repeat("c", 40) + "ttt" + repeat("c", 10) + repeat("t", 25) + repeat("c", 20) + "....", 5));
  const Result one = run(all, 1);
  for (const size_t batch : {size_t{0}, size_t{2}, size_t{7}, size_t{100}, all.size()}) {
    const Result other = run(all, batch);
    EXPECT_EQ(other.clay, one.clay) << batch;
    EXPECT_EQ(other.surface, one.surface) << batch;
    EXPECT_LE(other.scenes, one.scenes);
    EXPECT_TRUE(std::is_sorted(other.applied.begin(), other.applied.end()));
    EXPECT_GE(other.applied.back() + 4, all.size());
  }
  EXPECT_NE(one.clay, ball().hash());
}

TEST_F(EditLoopTest, SaysThatAStrokeIsInTheClayEvenWhenItChangedNothing) {
  auto all = samples(repeat("c", 30) + "...");
  for (StylusSample& sample : all) sample.cutPoint += Vec3d(100, 0, 0);
  const Result result = run(all, 4);
  EXPECT_EQ(result.clay, ball().hash());
  EXPECT_GE(result.applied.back(), 30u);
}

TEST_F(EditLoopTest, AnIdleHandPublishesNothing) {
  EXPECT_EQ(run(samples(repeat("..tt", 100)), 3).scenes, 1u);
}

TEST(EditThread, CarriesAFailureToItsOwner) {
  Session session(ball());
  haptics::SampleRing ring(1000);
  EditLoop::Options options;
  options.onSample = [](const StylusSample&) { throw Error("the pen ran dry"); };
  EditLoop loop(
      session, haptics::Scene(), [](auto) {}, options);
  EditThread thread(loop, ring);
  ring.push(samples("c")[0]);
  EXPECT_THROW(
      {
        for (int wait = 0; wait < 1000 && !thread.failed(); ++wait)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        thread.stop();
      },
      Error);
}

}  // namespace
}  // namespace argil::engine
