// Mouse and pen as a hand: what reaches the pointer, and when.

#include "ui3d/studio/input/hand.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "engine/tools/tool_table.h"

namespace argil::studio {
namespace {

using namespace std::chrono_literals;

// A block 60 x 60 x 40 mm, seen from above; the pointer is felt in real time.
class HandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    bench_.addBlock({60, 60, 40}, 2, {.voxelMm = 1});
    ASSERT_TRUE(until([&] { return bench_.snapshot()->document->pieces.size() == 1 && bench_.idle(); })) << "no block";
    document_ = bench_.snapshot()->document;
    render::View view;
    view.position = {0, 0, 200};
    view.target = Vec3d::Zero();
    view.up = Vec3d::UnitY();
    camera_.set(view);
  }
  template <class Condition>
  bool until(const Condition& condition) {
    for (int i = 0; i < 24000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }
  Hand::Stroke stroke() {
    Hand::Stroke s;
    s.clay = PinnedClay(*document_, [](engine::Id) {
      render::Box box;
      box.add(Vec3d(-30, -30, -20));
      box.add(Vec3d(30, 30, 20));
      return box;
    });
    s.camera = camera_;
    s.width = 1000;
    s.height = 1000;
    s.radiusMm = 5;
    s.cuts = true;
    s.depthPart = 0.5;
    return s;
  }
  static Event at(float x, float y, double timeS, float pressure = -1) {
    Event e;
    e.x = x;
    e.y = y;
    e.timeS = timeS;
    e.pressure = pressure;
    return e;
  }

  static engine::Workbench::Options options() {
    engine::Workbench::Options o;
    o.realtime = false;
    return o;
  }
  engine::Workbench bench_{options()};
  engine::DocumentPtr document_;
  Camera camera_;
  Hand hand_{bench_};
};

TEST_F(HandTest, TheTipGoesUnderTheSurfaceAsItWasByAPartOfTheRadius) {
  hand_.begin(stroke(), at(500, 500, 10), 10);
  hand_.pump(11);
  EXPECT_NEAR(hand_.place().z(), 20 - 2.5, 0.1);
  EXPECT_NEAR(hand_.place().x(), 0, 0.1);
  hand_.move(at(600, 500, 10.5));
  hand_.pump(12);
  EXPECT_NEAR(hand_.place().z(), 20 - 2.5, 0.1) << "not deeper with each motion";
  EXPECT_GT(hand_.place().x(), 5);
}

TEST_F(HandTest, APensDepthGoesWithItsPressure) {
  // From the ball on the clay to as deep as a mouse goes. What the pointer itself adds for pressure is taken off.
  for (const float pressure : {0.0f, 0.5f, 1.0f}) {
    hand_.begin(stroke(), at(500, 500, 10, pressure), 10);
    const double add = haptics::PointerOptions().penDepthMm * pressure;
    EXPECT_NEAR(hand_.place().z() - add, 25, 0.1) << "nothing is cut on the way";
    hand_.pump(11);
    EXPECT_NEAR(hand_.place().z() - add, 25 - 7.5 * pressure, 0.1);
  }
  Hand::Stroke lays = stroke();
  lays.cuts = false;
  lays.depthPart = 0;
  hand_.begin(lays, at(500, 500, 10, 0.5f), 10);
  hand_.pump(11);
  EXPECT_NEAR(hand_.place().z() - haptics::PointerOptions().penDepthMm * 0.5, 20, 0.1)
      << "what does not cut stays on the clay";
}

TEST_F(HandTest, MotionsAreHandedOnAtTheirOwnTimesWithOneLag) {
  // The press was made at 10, but handled at 10.05 only, as a picture was being drawn.
  hand_.begin(stroke(), at(500, 500, 10), 10.05);
  const double first = hand_.pump(10.05);
  const double lag = first - 10;
  EXPECT_GT(lag, 0.05);
  EXPECT_LT(lag, 0.3);
  for (int i = 1; i <= 5; ++i) hand_.move(at(500 + 10 * float(i), 500, 10 + 0.01 * i));
  EXPECT_NEAR(hand_.pump(first), 10.01 + lag, 1e-9);
  EXPECT_NEAR(hand_.pump(10.03 + lag), 10.04 + lag, 1e-9);
  const double x = hand_.place().x();
  hand_.end(at(550, 500, 10.06));
  EXPECT_TRUE(hand_.active());
  EXPECT_FALSE(hand_.pressed());
  hand_.move(at(900, 500, 10.07));  // Does not belong to it any more.
  EXPECT_TRUE(std::isinf(hand_.pump(11)));
  EXPECT_FALSE(hand_.active());
  EXPECT_GT(hand_.place().x(), x);
  EXPECT_LT(hand_.place().x(), 10);
}

TEST_F(HandTest, BesideTheClayTheLastDepthIsKept) {
  hand_.begin(stroke(), at(500, 500, 10), 10);
  hand_.move(at(999, 500, 10.1));  // 54 mm to the right: beyond the block.
  hand_.pump(12);
  EXPECT_TRUE(hand_.place().allFinite());
  EXPECT_NEAR(hand_.place().norm(), 50, 12);
}

TEST_F(HandTest, AStrokeCutsTheClayAndIsOneStep) {
  bench_.setTool({"carve", 5, 1});
  const size_t before = bench_.snapshot()->done;
  const auto begin = std::chrono::steady_clock::now();
  const auto now = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  const auto run = [&](double seconds) {
    for (const double end = now() + seconds; now() < end;) {
      hand_.pump(now());
      std::this_thread::sleep_for(2ms);
    }
  };
  camera_.set(camera_.view());
  hand_.hover(camera_.ray(450, 500, 1000, 1000), 180, at(450, 500, now()));
  run(0.1);
  hand_.begin(stroke(), at(450, 500, now()), now());
  for (int i = 0; i < 20; ++i) {
    hand_.move(at(450 + 5 * float(i), 500, now()));
    run(0.01);
  }
  hand_.end(at(550, 500, now()));
  run(0.2);
  ASSERT_TRUE(until([&] { return bench_.idle() && bench_.snapshot()->done == before + 1; })) << bench_.snapshot()->done;
  EXPECT_NE(bench_.snapshot()->document->pieces[0].version.hash(), document_->pieces[0].version.hash());
}

TEST_F(HandTest, StoppedForcesDoNotStopAMouse) {
  bench_.stopForces();
  ASSERT_TRUE(until([&] { return bench_.idle(); }));
  const engine::TouchState touch = bench_.touch(false);
  EXPECT_NE(touch.state, haptics::ServoState::stopped) << touch.sentence;
  const uint64_t before = bench_.latest().index;
  EXPECT_TRUE(until([&] { return bench_.latest().index > before + 10; })) << "its servo stands still";
}

// Between two places of the window, a motion each hundredth of a second.
class ToolsInHandTest : public HandTest {
 protected:
  double now() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
  void run(double seconds) {
    for (const double end = now() + seconds; now() < end;) {
      hand_.pump(now());
      std::this_thread::sleep_for(2ms);
    }
  }
  void take(const engine::Tool& tool) {
    bench_.setTool(tool);
    engine::Tool held = tool;
    held.quality = bench_.snapshot()->document->quality;
    ASSERT_TRUE(until([&] { return bench_.snapshot()->tool == held; })) << tool.id << " is not held";
  }
  void drag(const engine::Tool& tool, float fromX, float toX, float y, double depthPart) {
    take(tool);
    Hand::Stroke s = stroke();
    s.clay = PinnedClay(*bench_.snapshot()->document, [](engine::Id) {
      render::Box box;
      box.add(Vec3d(-40, -40, -30));
      box.add(Vec3d(40, 40, 30));
      return box;
    });
    s.radiusMm = tool.radiusMm;
    s.cuts = depthPart > 0;
    s.depthPart = depthPart;
    hand_.hover(camera_.ray(fromX, y, 1000, 1000), 180, at(fromX, y, now()));
    run(0.03);
    hand_.begin(std::move(s), at(fromX, y, now()), now());
    for (int i = 1; i <= 8; ++i) {
      hand_.move(at(fromX + (toX - fromX) * float(i) / 8, y, now()));
      run(0.01);
    }
    hand_.end(at(toX, y, now()));
    while (hand_.active()) run(0.01);
    run(0.03);
    ASSERT_TRUE(until([&] { return bench_.idle() && !bench_.snapshot()->inStroke; })) << tool.id;
  }
  uint64_t hash() const { return bench_.snapshot()->document->pieces[0].version.hash(); }
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

TEST_F(ToolsInHandTest, EveryToolChangesTheClayAndIsOneStep) {
  // Something for every tool to work on: a step in the clay, a rim between two colours and a sharp one of a mask that
  // covers none of the rest.
  const auto lay = [&](const char* id, double y, uint32_t colour = 0xc8402e) {
    engine::Tool tool = engine::standardTool(*engine::findTool(id));
    tool.colour = colour;
    tool.falloff = clay::Falloff::constant;
    take(tool);
    const size_t before = bench_.snapshot()->done;
    bench_.strokeAlong({Vec3d(-14, y, 20), Vec3d(14, y, 20)});
    ASSERT_TRUE(until([&] { return bench_.snapshot()->done == before + 1 && bench_.idle(); })) << id;
  };
  lay("carve", 2);
  lay("paint", 2);
  lay("paint", 9, 0x20a040);
  lay("mask", 22);
  for (const engine::ToolRow& row : engine::toolTable()) {
    if (row.file != engine::ToolFile::none) continue;
    SCOPED_TRACE(row.id);
    const size_t steps = bench_.snapshot()->done;
    const uint64_t before = hash();
    const bool mask = row.operations.front().property == clay::Property::mask;
    const bool cuts = row.work == haptics::Work::cut;
    // What blurs has something to do at a rim only.
    const bool rim = row.operations.front().method == clay::Method::blur;
    drag(engine::standardTool(row), 430, 560, mask ? (rim ? 325.0f : 290.0f) : rim ? 430.0f : 480.0f, cuts ? 0.5 : 0);
    ASSERT_TRUE(until([&] { return bench_.snapshot()->done != steps && bench_.idle(); })) << "no stroke arrived";
    EXPECT_EQ(bench_.snapshot()->done, steps + 1);
    EXPECT_NE(hash(), before);
    bench_.undo();
    ASSERT_TRUE(until([&] { return bench_.snapshot()->done == steps && bench_.idle(); }));
    EXPECT_EQ(hash(), before) << "undone";
  }
}

TEST_F(HandTest, AStraightLineLiesOnTheClayAndEndsWhereItEnds) {
  const Hand::Stroke s = stroke();
  const auto on = Hand::placesUnder(s, at(450, 500, 0), at(550, 500, 0), false);
  ASSERT_GE(on.size(), 40u);
  for (const Vec3d& place : on) EXPECT_NEAR(place.z(), 20, 0.05);
  EXPECT_LT(on.front().x(), -3);
  EXPECT_GT(on.back().x(), 3);
  const auto deep = Hand::placesUnder(s, at(450, 500, 0), at(550, 500, 0), true);
  ASSERT_EQ(deep.size(), on.size());
  EXPECT_NEAR((deep[3] - on[3]).norm(), 2.5, 1e-9);
  const auto beyond = Hand::placesUnder(s, at(500, 500, 0), at(1000, 500, 0), false);
  ASSERT_FALSE(beyond.empty());
  EXPECT_NEAR(beyond.back().x(), 30, 2.5) << "the rim of the block";
}

}  // namespace
}  // namespace argil::studio
