// Mouse and pen as a hand: what reaches the pointer, and when.

#include "ui3d/studio/hand.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

namespace argil::studio {
namespace {

using namespace std::chrono_literals;

// A block 60 x 60 x 40 mm, seen from above; the pointer is felt in real time.
class HandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    bench_.addBlock({60, 60, 40}, 2, 1);
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
    for (int i = 0; i < 2000; ++i) {
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

TEST_F(HandTest, theTipGoesUnderTheSurfaceAsItWasByAPartOfTheRadius) {
  hand_.begin(stroke(), at(500, 500, 10), 10);
  hand_.pump(11);
  EXPECT_NEAR(hand_.place().z(), 20 - 2.5, 0.1);
  EXPECT_NEAR(hand_.place().x(), 0, 0.1);
  hand_.move(at(600, 500, 10.5));
  hand_.pump(12);
  EXPECT_NEAR(hand_.place().z(), 20 - 2.5, 0.1) << "not deeper with each motion";
  EXPECT_GT(hand_.place().x(), 5);
}

TEST_F(HandTest, aPensDepthGoesWithItsPressure) {
  // What the pointer itself adds for pressure is taken off: only the part of the radius remains.
  hand_.begin(stroke(), at(500, 500, 10, 0.5f), 10);
  hand_.pump(11);
  const double device = hand_.place().z() - haptics::PointerOptions().penDepthMm * 0.5;
  EXPECT_NEAR(device, 20 - 1.25, 0.1);
}

TEST_F(HandTest, motionsAreHandedOnAtTheirOwnTimesWithOneLag) {
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

TEST_F(HandTest, besideTheClayTheLastDepthIsKept) {
  hand_.begin(stroke(), at(500, 500, 10), 10);
  hand_.move(at(999, 500, 10.1));  // 54 mm to the right: beyond the block.
  hand_.pump(12);
  EXPECT_TRUE(hand_.place().allFinite());
  EXPECT_NEAR(hand_.place().norm(), 50, 12);
}

TEST_F(HandTest, aStrokeCutsTheClayAndIsOneStep) {
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

}  // namespace
}  // namespace argil::studio
