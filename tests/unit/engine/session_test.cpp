#include "engine/saving/session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "clay/base/error.h"
#include "clay/field/primitives.h"

namespace argil::engine {
namespace {

clay::Version ball(double radiusMm = 15) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm);
}

const Tool kCarve{"carve", 3};

void cut(Session& session, const Vec3d& from, const Vec3d& to, const Tool& tool = kCarve) {
  session.beginStroke(tool);
  for (int i = 0; i <= 10; ++i) session.addPoint(0.001 * i, from + (to - from) * (i / 10.0));
  session.endStroke();
}

TEST(Session, AStrokeIsOneUndoStep) {
  Session session(ball());
  const uint64_t first = session.version().hash();
  cut(session, {15, 0, 0}, {0, 15, 0});
  const uint64_t second = session.version().hash();
  cut(session, {-15, 0, 0}, {0, 0, 15}, {"add", 2, 1});
  const uint64_t third = session.version().hash();
  EXPECT_NE(first, second);
  EXPECT_NE(second, third);
  EXPECT_EQ(session.undoSteps(), 2u);

  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.version().hash(), second);
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.version().hash(), first);
  EXPECT_FALSE(session.undo());
  EXPECT_TRUE(session.redo());
  EXPECT_TRUE(session.redo());
  EXPECT_FALSE(session.redo());
  EXPECT_EQ(session.version().hash(), third);
}

TEST(Session, ANewStrokeEndsTheRedoBranch) {
  Session session(ball());
  cut(session, {15, 0, 0}, {0, 15, 0});
  cut(session, {15, 0, 0}, {0, 0, 15});
  session.undo();
  EXPECT_EQ(session.redoSteps(), 1u);
  cut(session, {-15, 0, 0}, {0, -15, 0});
  EXPECT_EQ(session.redoSteps(), 0u);
  EXPECT_EQ(session.undoSteps(), 2u);
}

TEST(Session, AStrokeThroughAirLeavesNoStep) {
  Session session(ball());
  EXPECT_EQ(session.counts().idle, 0u);
  const clay::Version before = session.version();
  cut(session, {40, 0, 0}, {40, 15, 0});
  EXPECT_EQ(session.version(), before);
  EXPECT_EQ(session.undoSteps(), 0u);
  session.beginStroke(kCarve);
  session.endStroke();
  EXPECT_EQ(session.undoSteps(), 0u);
}

TEST(Session, PublishShowsTheStrokeBeforeItEnds) {
  Session session(ball());
  const uint64_t before = session.version().hash();
  session.beginStroke(kCarve);
  session.addPoint(0, {15, 0, 0});
  EXPECT_EQ(session.version().hash(), before);
  const clay::Version shown = session.publish();
  EXPECT_NE(shown.hash(), before);
  EXPECT_EQ(session.version(), shown);
  EXPECT_EQ(session.coveredPoints(), 1u);
  EXPECT_EQ(session.undoSteps(), 0u);
  session.endStroke();
  EXPECT_EQ(session.undoSteps(), 1u);
}

TEST(Session, LiftingTheToolLeavesAGap) {
  Session session(ball());
  session.record();
  session.beginStroke(kCarve);
  session.addPoint(0, {15, 0, 0});
  session.liftTool();
  session.addPoint(1, {-15, 0, 0});
  EXPECT_EQ(session.coveredPoints(), 2u);
  session.endStroke();
  // Two dabs, and the clay between them stands.
  EXPECT_EQ(session.version().find(Coord{0, 0, 0}), clay::Slot(clay::Tile::inside));
  EXPECT_EQ(session.undoSteps(), 1u);
  EXPECT_EQ(session.recording().strokes.size(), 2u);
  session.undo();
  EXPECT_EQ(session.version().hash(), ball().hash());
}

TEST(Session, ARefusedPointLeavesTheStrokeAsItWas) {
  Session clean(ball()), dirty(ball());
  for (Session* session : {&clean, &dirty}) {
    session->beginStroke(kCarve);
    const auto bad = [&] {
      if (session == &clean) return;
      EXPECT_THROW(session->addPoint(0, {NAN, 0, 0}), Error);
      EXPECT_THROW(session->addPoint(0, {0, 0, 1e300}), Error);
      EXPECT_THROW(session->addPoint(NAN, {0, 0, 0}), Error);
    };
    bad();
    session->addPoint(0, {15, 0, 0});
    bad();
    session->addPoint(1, {10, 10, 0});
    bad();
    session->endStroke();
  }
  EXPECT_EQ(clean.version().hash(), dirty.version().hash());
}

TEST(Session, RefusesWhatDoesNotFitTheMoment) {
  Session session(ball());
  session.record();
  EXPECT_THROW(session.addPoint(0, Vec3d::Zero()), Error);
  EXPECT_THROW(session.endStroke(), Error);
  EXPECT_THROW(session.beginStroke({"carve", 0.01, 1}), Error);
  EXPECT_FALSE(session.inStroke());
  session.beginStroke(kCarve);
  EXPECT_THROW(session.beginStroke(kCarve), Error);
  EXPECT_THROW(session.undo(), Error);
  EXPECT_THROW(session.redo(), Error);
  EXPECT_THROW((void)session.recording(), Error);
}

TEST(Session, AStrokeThatIsLeftOutLeavesNothing) {
  struct Watch : SessionWatch {
    void strokeBegan(const Tool&, const StrokeImages&) override { ++open; }
    void strokePoint(const PathPoint&) override {}
    void toolLifted() override {}
    void strokeEnded() override { --open; }
    void stepped(const std::string&, const DocumentPtr&, bool) override { ++steps; }
    void went(size_t) override {}
    int open = 0, steps = 0;
  } watch;
  const uint64_t before = ball().hash();
  Session session(ball());
  session.setWatch(&watch);
  Tool onAString = kCarve;
  onAString.stabiliseMm = 2;
  session.beginStroke(onAString);
  for (int i = 0; i < 100; ++i) session.addPoint(0.01 * i, {15, 0.1 * i, 0});
  (void)session.publish();
  EXPECT_NE(session.version().hash(), before);
  session.abandonStroke();
  EXPECT_FALSE(session.inStroke());
  EXPECT_EQ(session.version().hash(), before);
  EXPECT_EQ(session.undoSteps(), 0u);
  EXPECT_EQ(watch.open, 0) << "who watches knows that it has ended";
  EXPECT_EQ(watch.steps, 0);
  // The next one begins where it begins: no line from the one before, and the same bits as without it.
  const auto strokeOn = [&](Session& on) {
    on.beginStroke(onAString);
    for (int i = 0; i < 50; ++i) on.addPoint(0.01 * i, {-15, 0.1 * i, 0});
    return on.endStroke().hash();
  };
  Session fresh(ball());
  EXPECT_EQ(strokeOn(session), strokeOn(fresh));
  session.setWatch(nullptr);
}

TEST(Session, TheCollectorFreesTheVersionsOfAStroke) {
  Session session(ball());
  const auto store = session.version().store();
  session.beginStroke(kCarve);
  for (int i = 0; i <= 200; ++i) {
    session.addPoint(0.001 * i, {15 * std::cos(0.03 * i), 15 * std::sin(0.03 * i), 0});
    session.publish();
  }
  session.endStroke();
  // Kept: the version before the stroke and the one after it, which share most of their bricks.
  const uint64_t kept = ball().stats().bricks + session.version().stats().bricks;
  for (int wait = 0; wait < 500 && store->usage().versions > 2; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_LE(store->usage().bricks, kept);
  EXPECT_LE(store->usage().versions, 2u);
}

TEST(Session, VersionMayBeReadWhileAStrokeIsOn) {
  Session session(ball());
  std::atomic<bool> stop{false};
  uint64_t seen = 0, last = 0;
  bool ordered = true;
  std::thread reader([&] {
    do {
      const clay::Version version = session.version();
      ordered = ordered && version.id() >= last;
      seen += version.id() != last;
      last = version.id();
      (void)version.find({1, 2, 3});
      std::this_thread::yield();
    } while (!stop);
  });
  session.beginStroke(kCarve);
  for (int i = 0; i <= 100; ++i) {
    session.addPoint(0.001 * i, {15 * std::cos(0.03 * i), 15 * std::sin(0.03 * i), 0});
    session.publish();
  }
  session.endStroke();
  stop = true;
  reader.join();
  EXPECT_TRUE(ordered);
  EXPECT_GE(seen, 1u);
}

}  // namespace
}  // namespace argil::engine
