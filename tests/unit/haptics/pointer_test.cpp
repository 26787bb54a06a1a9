// A pointer whose window or servo is late: what the user did arrives whole and in order.

#include "haptics/devices/pointer.h"

#include <gtest/gtest.h>

#include <vector>

namespace argil::haptics {
namespace {

PointerSample at(double x, double y, uint32_t buttons) {
  PointerSample sample;
  sample.origin = {x, y, 100};
  sample.surfaceMm = 90;
  sample.buttons = buttons;
  return sample;
}

std::vector<DeviceState> readAll(PointerDevice& pointer, int ticks, double fromS = 0) {
  std::vector<DeviceState> states;
  DeviceState state;
  for (int i = 0; i < ticks; ++i)
    if (pointer.read(fromS + 1e-3 * i, state)) states.push_back(state);
  return states;
}

// How near the tip came to a point while the button was held.
double nearest(const std::vector<DeviceState>& states, const Vec3d& point) {
  double best = 1e9;
  for (const DeviceState& state : states)
    if (state.buttons) best = std::min(best, (state.pose.translation - point).norm());
  return best;
}

TEST(LatePointer, AStrokeThatComesAllAtOnceIsFollowedPointByPoint) {
  PointerDevice pointer;
  pointer.feed(at(-30, 0, 0));
  readAll(pointer, 20);
  // A zigzag of 12 corners, pressed and let go between two looks of the servo.
  pointer.feed(at(0, 0, 0));
  std::vector<Vec3d> corners;
  for (int i = 0; i < 12; ++i) {
    corners.emplace_back(0.5 * i, i % 2 ? 1.5 : 0, 10);
    pointer.feed(at(corners.back().x(), corners.back().y(), 1));
  }
  pointer.feed(at(20, 20, 0));
  const std::vector<DeviceState> states = readAll(pointer, 400, 0.02);
  for (const Vec3d& corner : corners) EXPECT_LT(nearest(states, corner), 0.2) << corner.transpose();
  int changes = 0;
  for (size_t i = 1; i < states.size(); ++i) changes += states[i].buttons != states[i - 1].buttons;
  EXPECT_EQ(changes, 2);
  EXPECT_EQ(states.back().buttons, 0u);
  EXPECT_NEAR(states.back().pose.translation.x(), 20, 0.01);
  // Nothing was pressed on the way to the first corner, nor on the way from the last.
  for (const DeviceState& state : states)
    if (state.buttons) {
      EXPECT_GT(state.pose.translation.x(), -0.3);
      EXPECT_LT(state.pose.translation.x(), 5.8);
    }
}

TEST(LatePointer, AClickBetweenTwoTicksIsAClick) {
  PointerDevice pointer;
  pointer.feed(at(0, 0, 0));
  readAll(pointer, 5);
  for (int i = 0; i < 3; ++i) {
    pointer.feed(at(0, 0, 1));
    pointer.feed(at(0, 0, 0));
  }
  int presses = 0;
  uint32_t before = 0;
  for (const DeviceState& state : readAll(pointer, 30, 0.01)) {
    presses += state.buttons && !before;
    before = state.buttons;
  }
  EXPECT_EQ(presses, 3);
}

TEST(LatePointer, NoChangeOfTheButtonsIsLostHoweverLongNobodyReads) {
  PointerDevice pointer;
  pointer.feed(at(0, 0, 0));
  readAll(pointer, 5);
  pointer.feed(at(0, 0, 1));
  for (int i = 0; i < 20000; ++i) pointer.feed(at(0.001 * i, 0, 1));
  pointer.feed(at(20, 0, 0));
  for (int i = 0; i < 20000; ++i) pointer.feed(at(20 + 0.001 * i, 0, 0));
  std::vector<DeviceState> states = readAll(pointer, 3000, 0.01);
  pointer.feed(at(40, 0, 0));  // What had to wait goes out with the next motion.
  const std::vector<DeviceState> rest = readAll(pointer, 1000, 3.1);
  states.insert(states.end(), rest.begin(), rest.end());
  int presses = 0;
  uint32_t before = 0;
  for (const DeviceState& state : states) {
    presses += state.buttons && !before;
    before = state.buttons;
  }
  EXPECT_EQ(presses, 1);
  EXPECT_EQ(states.back().buttons, 0u);
  EXPECT_NEAR(states.back().pose.translation.x(), 40, 0.01);
}

// The press itself comes when nothing more is taken.
TEST(LatePointer, AClickBehindAFullQueueIsAClick) {
  PointerDevice pointer;
  pointer.feed(at(0, 0, 0));
  readAll(pointer, 5);
  for (int i = 0; i < 3000; ++i) pointer.feed(at(0.001 * i, 0, 0));
  pointer.feed(at(5, 0, 1));
  pointer.feed(at(6, 0, 1));
  pointer.feed(at(6, 0, 0));
  std::vector<DeviceState> states = readAll(pointer, 3000, 0.01);
  pointer.feed(at(7, 0, 0));
  const std::vector<DeviceState> rest = readAll(pointer, 1000, 3.1);
  states.insert(states.end(), rest.begin(), rest.end());
  int presses = 0;
  uint32_t before = 0;
  double pressedAt = 0;
  for (const DeviceState& state : states) {
    if (state.buttons && !before) pressedAt = state.pose.translation.x();
    presses += state.buttons && !before;
    before = state.buttons;
  }
  EXPECT_EQ(presses, 1);
  EXPECT_GE(pressedAt, 4.9) << "where the hand pressed";
  EXPECT_LE(pressedAt, 6.1);
}

TEST(LatePointer, LeavingTheWindowComesAfterWhatWasDone) {
  PointerDevice pointer;
  DeviceState state;
  pointer.feed(at(0, 0, 0));
  readAll(pointer, 5);
  pointer.feed(at(0, 0, 1));
  pointer.feed(at(0, 0, 0));
  pointer.leave();
  bool pressed = false;
  int present = 0;
  for (int i = 0; i < 20; ++i)
    if (pointer.read(0.01 + 1e-3 * i, state)) {
      pressed |= state.buttons != 0;
      ++present;
    }
  EXPECT_TRUE(pressed);
  EXPECT_LT(present, 10);
  EXPECT_FALSE(pointer.read(0.05, state));
  pointer.feed(at(3, 0, 0));
  EXPECT_TRUE(pointer.read(0.06, state));
  EXPECT_NEAR(state.pose.translation.x(), 3, 1e-9) << "where it came back is where it is";
}

}  // namespace
}  // namespace argil::haptics
