// What frames cost and how they are counted, by simulated times.

#include "ui3d/studio/view/frame_log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace argil::studio {
namespace {

constexpr int64_t kMs = 1'000'000;

FrameDone frame(int64_t atMs, int64_t tookMs, int64_t waitedMs, double passesMs) {
  FrameDone f;
  f.shown = true;
  f.beganNs = atMs * kMs;
  f.endedNs = (atMs + tookMs) * kMs;
  f.waitedNs = waitedMs * kMs;
  if (passesMs > 0) f.passes = {{"clay", 600 * passesMs}, {"shade", 400 * passesMs}};
  return f;
}

TEST(PictureCost, AWaitForTheScreenIsNoWork) {
  PictureCost cost;
  EXPECT_GT(cost.ms(), 500) << "unknown: the first picture in motion is the cheap one";
  // 50 Hz: each frame ends with the screen, 20 ms after the one before, whatever it cost.
  for (int i = 0; i < 100; ++i) cost.add(frame(20 * i, 21, 17, 3));
  EXPECT_NEAR(cost.ms(), 4, 1e-9);
  // 24 Hz, and a device without a clock.
  cost.add(frame(3000, 42, 30, 0));
  EXPECT_NEAR(cost.ms(), 12, 1e-9);
}

TEST(PictureCost, WorkCountsWhetherTheProcessorOrTheDeviceDoesIt) {
  PictureCost cost;
  cost.add(frame(0, 60, 0, 5));
  EXPECT_NEAR(cost.ms(), 60, 1e-9);
  cost.add(frame(100, 40, 38, 35));  // The wait was for the device itself.
  EXPECT_NEAR(cost.ms(), 35, 1e-9);
}

TEST(PictureCost, OnlyFullPicturesOfClayTell) {
  PictureCost cost;
  cost.add(frame(0, 50, 0, 45));
  FrameDone panels = frame(100, 3, 0, 45);
  panels.clay = false;
  cost.add(panels);
  FrameDone thinned = frame(200, 9, 0, 8);
  thinned.still = false;
  cost.add(thinned);
  FrameDone hidden = frame(300, 1, 0, 0);
  hidden.shown = false;
  cost.add(hidden);
  EXPECT_NEAR(cost.ms(), 50, 1e-9);
}

TEST(FrameLog, FramesOfPanelsAloneAreCounted) {
  FrameLog log;
  const engine::Snapshot now;
  log.add(frame(0, 30, 0, 20));
  for (int i = 1; i <= 7; ++i) {
    FrameDone panels = frame(100 * i, 3, 0, 0);
    panels.clay = false;
    log.add(panels);
  }
  auto json = nlohmann::json::parse(log.report({}, now));
  EXPECT_EQ(json["frames"], 8);
  EXPECT_EQ(json["clay_frames"], 1);
  EXPECT_EQ(json["frames_since_clay"], 7);
  log.add(frame(1000, 30, 0, 20));
  json = nlohmann::json::parse(log.report({}, now));
  EXPECT_EQ(json["clay_frames"], 2);
  EXPECT_EQ(json["frames_since_clay"], 0);
}

TEST(FrameLog, GapsBetweenPicturesInMotionAreKeptHoweverLong) {
  FrameLog log;
  const auto moving = [](int64_t atMs) {
    FrameDone f = frame(atMs, 10, 0, 0);
    f.moving = true;
    return f;
  };
  for (const int64_t at : {1000, 1020, 1040}) log.add(moving(at));
  log.add(frame(5000, 10, 0, 0));  // It rested.
  for (const int64_t at : {9000, 9600, 9620}) log.add(moving(at));
  const auto json = nlohmann::json::parse(log.report({}, engine::Snapshot()));
  EXPECT_EQ(json["moving_gap_ms"]["n"], 4);
  EXPECT_NEAR(json["moving_gap_ms"]["max"].get<double>(), 600, 1e-9);
  EXPECT_EQ(json["stroke_gap_ms"]["n"], 0);
}

TEST(FrameLog, GapsWithinStrokesAreKeptApart) {
  FrameLog log;
  const auto at = [&](int64_t ms, bool stroke) {
    FrameDone f = frame(ms, 10, 0, 0);
    f.moving = true;
    f.stroke = stroke;
    log.add(f);
  };
  at(1000, false), at(1300, false), at(1310, true), at(1350, true), at(1420, true), at(1900, false);
  const auto json = nlohmann::json::parse(log.report({}, engine::Snapshot()));
  EXPECT_EQ(json["moving_gap_ms"]["n"], 5);
  EXPECT_EQ(json["stroke_gap_ms"]["n"], 2);
  EXPECT_NEAR(json["stroke_gap_ms"]["max"].get<double>(), 70, 1e-9);
}

TEST(FrameLog, TurnsThatAPersonNoticesAreCounted) {
  FrameLog log;
  for (int i = 0; i < 1000; ++i) log.turned(2'000'000, 1'000'000);
  log.turned(100'000'000, 1'000'000);
  log.turned(130'000'000, 100'000'001);
  const auto json = nlohmann::json::parse(log.report({}, engine::Snapshot()));
  EXPECT_EQ(json["turn_ms"]["n"], 1002);
  EXPECT_EQ(json["turn_ms"]["over_100_ms"], 1);
  EXPECT_EQ(json["turn_core_ms"]["over_100_ms"], 1);
  EXPECT_NEAR(json["turn_ms"]["max"].get<double>(), 130, 1e-6);
  EXPECT_NEAR(json["turn_ms"]["median"].get<double>(), 2, 0.1);
  EXPECT_NEAR(json["turn_core_ms"]["median"].get<double>(), 1, 0.1);
}

}  // namespace
}  // namespace argil::studio
