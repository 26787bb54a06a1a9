// Report descriptors, and what a SpaceMouse makes of its reports.

#include "haptics/devices/spacemouse.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "../../support/devices/spacemouse_emulator.h"
#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/hid_descriptor.h"

namespace argil::haptics {
namespace {

using testing::SpaceMouseEmulator;
using Layout = SpaceMouseEmulator::Layout;
using namespace std::chrono_literals;

TEST(HidDescriptor, TellsWhereEachAxisAndButtonLies) {
  for (Layout layout : {Layout::twoReports, Layout::oneReport}) {
    std::string sentence;
    const auto inputs = parseHidDescriptor(SpaceMouseEmulator::descriptor(layout), sentence);
    ASSERT_TRUE(inputs) << sentence;
    EXPECT_TRUE(inputs->numbered);
    int axes = 0, buttons = 0;
    for (const HidField& f : inputs->fields) {
      if (f.page == 1) {
        const int axis = f.usage - 0x30;
        EXPECT_EQ(f.report, layout == Layout::twoReports && axis >= 3 ? 2 : 1);
        EXPECT_EQ(f.bit, 16u * static_cast<unsigned>(layout == Layout::twoReports ? axis % 3 : axis));
        EXPECT_EQ(f.bits, 16);
        EXPECT_EQ(f.least, -350);
        EXPECT_EQ(f.most, 350);
        ++axes;
      }
      if (f.page == 9) {
        EXPECT_EQ(f.report, 3);
        EXPECT_EQ(f.bit, f.usage - 1u);
        EXPECT_EQ(f.bits, 1);
        ++buttons;
      }
    }
    EXPECT_EQ(axes, 6);
    EXPECT_EQ(buttons, 2) << "padding is no button";
  }
}

TEST(HidDescriptor, ReadsValuesOfAnyWidthAtAnyBit) {
  const uint8_t payload[] = {0b10110100, 0xFF, 0x7F, 0x80};
  EXPECT_EQ(hidValue({0, 2, 3, 1, 1, 0, 7}, payload), 5);
  EXPECT_EQ(hidValue({0, 2, 3, 1, 1, -4, 3}, payload), -3) << "signed where the range is";
  EXPECT_EQ(hidValue({0, 8, 16, 1, 1, -32768, 32767}, payload), 32767);
  EXPECT_EQ(hidValue({0, 16, 16, 1, 1, -32768, 32767}, payload), -32641);
  EXPECT_EQ(hidValue({0, 0, 32, 1, 1, -1, 1}, payload), static_cast<int32_t>(0x807FFFB4));
  EXPECT_FALSE(hidValue({0, 17, 16, 1, 1, -1, 1}, payload)) << "beyond the end";
}

TEST(HidDescriptor, WhatWasPushedComesBack) {
  // An axis of 16 bits between a push and a pop; before and after it those of 8 bits.
  const uint8_t descriptor[] = {0x05, 0x01, 0x15, 0x00, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01, 0x09,
                                0x30, 0x81, 0x02, 0xA4, 0x05, 0x0C, 0x26, 0xFF, 0x0F, 0x75, 0x10,
                                0x09, 0x31, 0x81, 0x02, 0xB4, 0x09, 0x32, 0x81, 0x02};
  std::string sentence;
  const auto inputs = parseHidDescriptor(descriptor, sentence);
  ASSERT_TRUE(inputs) << sentence;
  ASSERT_EQ(inputs->fields.size(), 3u);
  const HidField &inside = inputs->fields[1], &after = inputs->fields[2];
  EXPECT_EQ(inside.page, 12);
  EXPECT_EQ(inside.bits, 16);
  EXPECT_EQ(inside.most, 4095);
  EXPECT_EQ(after.page, 1);
  EXPECT_EQ(after.usage, 0x32);
  EXPECT_EQ(after.bit, 24u);
  EXPECT_EQ(after.bits, 8);
  EXPECT_EQ(after.most, 127);
}

TEST(HidDescriptor, SurvivesWhateverItIsGiven) {
  std::string sentence;
  const auto whole = SpaceMouseEmulator::descriptor(Layout::twoReports);
  for (size_t n = 0; n < whole.size(); ++n) (void)parseHidDescriptor(whole.first(n), sentence);
  EXPECT_FALSE(parseHidDescriptor({}, sentence));
  EXPECT_FALSE(sentence.empty());
  const uint32_t seed = 20261120;
  std::mt19937 random(seed);
  int parsed = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<uint8_t> bytes(whole.begin(), whole.end());
    for (unsigned i = 0; i < 1 + random() % 4; ++i) bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
    const auto inputs = parseHidDescriptor(bytes, sentence);
    if (!inputs) continue;
    ++parsed;
    for (const HidField& f : inputs->fields) {
      ASSERT_GE(f.bits, 1) << seed;
      ASSERT_LE(f.bits, 32) << seed;
      ASSERT_LE(f.bit + f.bits, 8u * 4096) << seed;
      (void)hidValue(f, std::span<const uint8_t>(bytes).first(7));
    }
  }
  EXPECT_GT(parsed, 1000);
}

/// Reads until `seconds` have gone.
DeviceState after(Device& device, double seconds) {
  DeviceState state;
  const int64_t end = nowNs() + static_cast<int64_t>(seconds * 1e9);
  while (nowNs() < end) {
    device.read(0, state);
    std::this_thread::sleep_for(1ms);
  }
  return state;
}

TEST(SpaceMouse, GoesWhereItIsPushedAndTurned) {
  for (Layout layout : {Layout::twoReports, Layout::oneReport}) {
    for (int axis = 0; axis < 6; ++axis) {
      SpaceMouseEmulator puck(layout);
      const auto device = openSpaceMouse({}, puck.source());
      after(*device, 0.02);
      std::array<int, 6> counts{};
      counts[static_cast<size_t>(axis)] = 350;
      puck.deflect(counts);
      const DeviceState state = after(*device, 0.12);
      puck.deflect({});
      const double sign = axis % 3 == 0 ? 1 : -1;  // Its y is towards the person, its z down.
      const Vec3d moved = state.pose.translation;
      const Eigen::AngleAxisd turned(state.pose.rotation);
      if (axis < 3) {
        EXPECT_NEAR(moved.norm(), 120 * 0.12, 8) << "full deflection is top speed";
        EXPECT_GT(sign * moved[axis], 0.999 * moved.norm()) << axis;
        EXPECT_LT(turned.angle(), 1e-9);
      } else {
        EXPECT_LT(moved.norm(), 1e-9);
        EXPECT_NEAR(turned.angle(), 1.5 * 0.12, 0.1);
        EXPECT_GT(sign * turned.axis()[axis - 3], 0.999) << axis;
      }
      const DeviceState rest = after(*device, 0.03), later = after(*device, 0.02);
      EXPECT_EQ((rest.pose.translation - later.pose.translation).norm(), 0) << "let go, it stays";
    }
  }
}

TEST(SpaceMouse, StaysInItsBoxAndTellsItsButtons) {
  SpaceMouseEmulator puck(Layout::twoReports);
  SpaceMouseOptions options;
  options.boxMm = {20, 20, 20};
  const auto device = openSpaceMouse(options, puck.source());
  after(*device, 0.02);
  puck.deflect({350, 0, 0, 0, 0, 0});
  puck.buttons(2);
  const DeviceState state = after(*device, 0.3);
  EXPECT_EQ(state.pose.translation, Vec3d(10, 0, 0));
  EXPECT_EQ(state.buttons, 2u);
  EXPECT_EQ(state.pressure, 1);
}

TEST(SpaceMouse, DoesNotDriftInItsDeadZoneNorWhenItsReportsStop) {
  SpaceMouseEmulator puck(Layout::oneReport);
  const auto device = openSpaceMouse({}, puck.source());
  after(*device, 0.02);
  puck.deflect({10, -10, 5, 0, 10, 0});
  EXPECT_EQ(after(*device, 0.1).pose.translation.norm(), 0);
  puck.deflect({350, 0, 0, 0, 0, 0});
  EXPECT_GT(after(*device, 0.1).pose.translation.x(), 1);
  puck.misbehave(testing::Misbehaviour::silent);  // Deflected, and never heard of again.
  const DeviceState stopped = after(*device, 0.2), later = after(*device, 0.05);
  EXPECT_LT(stopped.pose.translation.x(), 120 * 0.35);
  EXPECT_EQ(stopped.pose.translation, later.pose.translation);
  EXPECT_TRUE(device->read(0, *std::make_unique<DeviceState>())) << "a puck at rest is no fault";
}

// It moves and turns together: how far it turned for a way says whether one went on without the other.
TEST(SpaceMouse, ReportsThatMakeNoSenseStopItsTurnAsTheyStopItsWay) {
  SpaceMouseEmulator puck(Layout::oneReport);
  const SpaceMouseOptions options;
  const auto device = openSpaceMouse(options, puck.source());
  after(*device, 0.02);
  puck.deflect({350, 0, 0, 350, 0, 0});
  DeviceState state;
  const int64_t end = nowNs() + 10'000'000'000;
  do state = after(*device, 0.005);
  while (state.pose.translation.x() < 1 && nowNs() < end);
  puck.misbehave(testing::Misbehaviour::garbage);
  while (device->read(0, state) && nowNs() < end) std::this_thread::sleep_for(1ms);
  puck.deflect({});
  after(*device, 0.15);
  puck.misbehave(testing::Misbehaviour::none);
  while (!device->read(0, state) && nowNs() < end) std::this_thread::sleep_for(1ms);
  const double way = state.pose.translation.x(), angle = Eigen::AngleAxisd(state.pose.rotation).angle();
  EXPECT_GT(way, 1);
  EXPECT_NEAR(angle, way * options.topTurnRads / options.topSpeedMms, 0.01) << way << " mm";
}

TEST(SpaceMouse, RefusesSettingsAndThingsThatAreNone) {
  for (SpaceMouseOptions bad : {SpaceMouseOptions{.topSpeedMms = 0}, SpaceMouseOptions{.topTurnRads = -1},
                                SpaceMouseOptions{.deadZone = 0.9}, SpaceMouseOptions{.boxMm = {0, 1, 1}}})
    EXPECT_THROW((void)openSpaceMouse(bad), Error);
  const auto device = openSpaceMouse({.node = "/dev/null"});
  std::this_thread::sleep_for(50ms);
  DeviceState state;
  EXPECT_FALSE(device->read(0, state));
  EXPECT_NE(device->status().find("report descriptor"), std::string::npos) << device->status();
  EXPECT_TRUE(isSpaceMouse(0x046D, 0xC626));
  EXPECT_TRUE(isSpaceMouse(0x256F, 0xC652));
  EXPECT_FALSE(isSpaceMouse(0x046D, 0xC077)) << "a mouse of the same maker";
  for (const int product : {0xC603, 0xC605, 0xC606, 0xC621, 0xC623, 0xC625, 0xC627, 0xC628, 0xC629, 0xC62B, 0xC640})
    EXPECT_TRUE(isSpaceMouse(0x046D, static_cast<uint16_t>(product))) << std::hex << product;
  for (const int product : {0xC62E, 0xC632, 0xC636, 0xC63A, 0xC641, 0xC652, 0xC658, 0xFFFF})
    EXPECT_TRUE(isSpaceMouse(0x256F, static_cast<uint16_t>(product))) << std::hex << product << ": all of that vendor";
}

TEST(HidDescriptor, ReadsArraysThatNameWhatIsHeld) {
  std::string sentence;
  const auto inputs = parseHidDescriptor(SpaceMouseEmulator::descriptor(Layout::buttonArray), sentence);
  ASSERT_TRUE(inputs) << sentence;
  ASSERT_EQ(inputs->arrays.size(), 1u);
  const HidArray& a = inputs->arrays[0];
  EXPECT_EQ(a.report, 3);
  EXPECT_EQ(a.count, 4u);
  EXPECT_EQ(a.usages.size(), 32u);
  std::vector<uint32_t> held;
  const auto read = [&](std::vector<uint8_t> payload) {
    held.clear();
    return hidHeld(a, payload, [&](uint32_t usage) { held.push_back(usage); });
  };
  EXPECT_TRUE(read({0, 0, 0, 0}));
  EXPECT_TRUE(held.empty());
  EXPECT_TRUE(read({2, 32, 33, 0}));
  EXPECT_EQ(held, (std::vector<uint32_t>{0x90002, 0x90020})) << "33 is out of the range: it names nothing";
  EXPECT_FALSE(read({1, 2, 3})) << "too short";
}

TEST(SpaceMouse, TellsButtonsThatComeAsAList) {
  SpaceMouseEmulator puck(Layout::buttonArray);
  const auto device = openSpaceMouse({}, puck.source());
  after(*device, 0.02);
  for (const uint32_t held : {uint32_t{0x80000001}, uint32_t{0x6}, uint32_t{0}}) {
    puck.buttons(held);
    DeviceState state;
    const int64_t end = nowNs() + 5'000'000'000;
    do state = after(*device, 0.005);
    while (state.buttons != held && nowNs() < end);
    EXPECT_EQ(state.buttons, held);
  }
}

TEST(SpaceMouse, HearsAReceiverOnWhicheverOfItsInterfacesThePuckSpeaks) {
  for (const size_t interface : {size_t{0}, size_t{2}, size_t{4}}) {
    SpaceMouseEmulator puck(Layout::receiver);
    puck.speaks(interface);
    const auto device = openSpaceMouse({}, puck.source());
    after(*device, 0.02);
    puck.deflect({350, 0, 0, 0, 0, 0});
    DeviceState state;
    const int64_t end = nowNs() + 5'000'000'000;
    do state = after(*device, 0.01);
    while (state.pose.translation.x() < 2 && nowNs() < end);
    EXPECT_GT(state.pose.translation.x(), 1) << interface;
    puck.unplug();
    while (device->read(0, state) && nowNs() < end) std::this_thread::sleep_for(1ms);
    EXPECT_FALSE(device->read(0, state)) << "unplugged is noticed: " << device->status();
    EXPECT_NE(device->status().find("unplugged"), std::string::npos) << device->status();
  }
}

TEST(SpaceMouse, OfTwoPucksTheOneThatSpeaksIsHeldUntilItIsSilent) {
  SpaceMouseEmulator pucks(Layout::receiver);
  pucks.speaks(1);
  const auto device = openSpaceMouse({}, pucks.source());
  after(*device, 0.02);
  pucks.deflect({350, 0, 0, 0, 0, 0});
  DeviceState state;
  const int64_t end = nowNs() + 10'000'000'000;
  do state = after(*device, 0.01);
  while (state.pose.translation.x() < 2 && nowNs() < end);
  pucks.second({-350, 0, 0, 0, 0, 0});
  for (int i = 0; i < 20; ++i) {
    const double before = state.pose.translation.x();
    state = after(*device, 0.01);
    EXPECT_GE(state.pose.translation.x(), before);
  }
  pucks.deflect({});
  const double before = state.pose.translation.x();
  do state = after(*device, 0.01);
  while (state.pose.translation.x() > before - 2 && nowNs() < end);
  EXPECT_LT(state.pose.translation.x(), before - 1) << "the other one's turn";
}

TEST(SpaceMouse, GoesOnWhileItsReportsComeWithoutEnd) {
  SpaceMouseEmulator puck(Layout::oneReport);
  const auto device = openSpaceMouse({}, puck.source());
  auto* threaded = dynamic_cast<ThreadedDevice*>(device.get());
  ASSERT_NE(threaded, nullptr);
  after(*device, 0.02);
  puck.talksWithoutEnd(true);
  const uint64_t before = threaded->exchanges();
  const int64_t end = nowNs() + 10'000'000'000;
  while (threaded->exchanges() < before + 100 && nowNs() < end) std::this_thread::sleep_for(1ms);
  EXPECT_GE(threaded->exchanges(), before + 100) << "its thread came back from reading";
}

}  // namespace
}  // namespace argil::haptics
