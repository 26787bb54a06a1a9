// What the Falcon's driver does on a USB bus beyond the conformance suite: being found, loaded, shared, taken over by a
// guard.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "../../support/devices/emulated_usb.h"
#include "haptics/base/clock.h"
#include "haptics/devices/falcon.h"

namespace argil::haptics {
namespace {

using testing::EmulatedUsb;
using testing::FalconEmulator;
using testing::FalconFault;
using ::testing::HasSubstr;

std::unique_ptr<Device> openAt(const std::string& where, const std::string& firmware = "") {
  FalconOptions options;
  options.where = where;
  options.firmware = firmware;
  options.realtime = false;
  return openFalcon(options);
}

/// Turns of a servo, a millisecond each, until `done`: the emulated bus has no time of its own (60 s: it is broken).
bool until(Device& device, const Vec3d& force, const std::function<bool(bool fresh)>& done, double seconds = 60) {
  const int64_t end = nowNs() + int64_t(seconds * 1e9);
  while (nowNs() < end) {
    DeviceState state;
    const double now = double(nowNs()) * 1e-9;
    const bool fresh = device.read(now, state);
    device.write(now, fresh ? force : Vec3d(0, 0, 0));
    if (done(fresh)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}
/// Seconds of 100 exchanges on the bus as it is now.
double hundredExchanges(Device& device) {
  const int64_t begin = nowNs();
  int count = 0;
  EXPECT_TRUE(until(device, Vec3d::Zero(), [&](bool fresh) { return (count += fresh) == 20; }));
  return 5e-9 * double(nowNs() - begin);
}
bool ready(Device& device) {
  return until(device, Vec3d::Zero(), [](bool fresh) { return fresh; });
}

TEST(FalconUsb, FindsNothingWhereNothingIs) {
  EmulatedUsb usb;
  EXPECT_TRUE(findFalcons().empty());
  EXPECT_EQ(zeroFalcons(), 0);
  const auto device = openAt("");
  EXPECT_TRUE(until(*device, Vec3d::Zero(), [&](bool) {
    return device->status().find("not plugged in") != std::string::npos;
  })) << device->status();
}

TEST(FalconUsb, FindsEachByItsSocket) {
  FalconEmulator one({}), two({});
  EmulatedUsb usb;
  usb.plug(one, "1");
  usb.plug(two, "4");
  const auto found = findFalcons();
  ASSERT_EQ(found.size(), 2u);
  std::vector<std::string> places = {found[0].where, found[1].where};
  EXPECT_THAT(places, ::testing::UnorderedElementsAre("1-1", "1-4"));
  EXPECT_TRUE(found[0].usable) << found[0].sentence;
  one.hand({10, 0, 0}, 0);
  two.hand({0, 10, 0}, 0);
  const auto device = openAt("1-4");
  DeviceState state;
  EXPECT_TRUE(until(*device, Vec3d::Zero(), [&](bool) {
    return device->read(0, state) && (state.pose.translation - Vec3d(0, 10, 0)).norm() < 0.1;
  }));
  EXPECT_THAT(device->status(), HasSubstr("1-4"));
}

TEST(FalconUsb, TwoDriversTakeTwoFalconsAndAThirdIsToldWhy) {
  FalconEmulator one({}), two({});
  EmulatedUsb usb;
  usb.plug(one, "1");
  usb.plug(two, "2");
  const auto first = openAt("");
  ASSERT_TRUE(ready(*first)) << first->status();
  const auto second = openAt("");
  ASSERT_TRUE(ready(*second)) << second->status();
  EXPECT_GT(one.packets(), 0u);
  EXPECT_GT(two.packets(), 0u);
  const auto third = openAt("");
  EXPECT_TRUE(until(*third, Vec3d::Zero(), [&](bool) {
    return third->status().find("another program uses it") != std::string::npos;
  })) << third->status();
}

TEST(FalconUsb, LoadsFirmwareOverTheBusAlsoAfterAWrongEcho) {
  std::vector<uint8_t> firmware(500);
  for (size_t i = 0; i < firmware.size(); ++i) firmware[i] = static_cast<uint8_t>(7 * i + i / 100);
  const auto path = std::filesystem::temp_directory_path() / ("argil-falcon-usb-" + std::to_string(::getpid()));
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(firmware.data()), std::streamsize(firmware.size()));
  FalconEmulator falcon(firmware);
  falcon.powerCycle();
  falcon.setHomed(true);
  falcon.wrongEchoes(1);
  EmulatedUsb usb;
  usb.plug(falcon, "2");
  const auto device = openAt("", path.string());
  EXPECT_TRUE(ready(*device)) << device->status();
  std::filesystem::remove(path);
}

TEST(FalconUsb, IsAtZeroOnceCut) {
  FalconEmulator falcon({});
  EmulatedUsb usb;
  usb.plug(falcon, "2");
  const auto device = openAt("");
  const Vec3d push(0, 0, 4);
  ASSERT_TRUE(ready(*device)) << device->status();
  const double bus = hundredExchanges(*device);
  ASSERT_TRUE(until(*device, push, [&](bool) { return falcon.forceN().norm() > 3; })) << device->status();
  const ForceGate::Generation stop = device->gate().stop(StopOwner::user);
  EXPECT_TRUE(until(
      *device, push, [&](bool) { return falcon.forceN().norm() == 0; }, std::max(0.5, bus)));
  EXPECT_FALSE(until(
      *device, push, [&](bool) { return falcon.forceN().norm() > 0; }, 0.05))
      << "whatever write() says";
  ASSERT_TRUE(device->gate().resume(StopOwner::user, stop));
  EXPECT_TRUE(until(*device, push, [&](bool) { return falcon.forceN().norm() > 3; })) << device->status();
}

TEST(FalconUsb, CopesWithSplitAndLitteredAnswers) {
  FalconEmulator falcon({});
  EmulatedUsb usb;
  usb.plug(falcon, "2");
  const auto device = openAt("");
  for (const FalconFault fault : {FalconFault::split, FalconFault::littered}) {
    falcon.misbehave(fault);
    int count = 0;
    EXPECT_TRUE(until(*device, Vec3d::Zero(), [&](bool fresh) { return (count += fresh) == 100; })) << device->status();
  }
}

TEST(FalconUsb, IsAtZeroAfterAStallAndGoesOn) {
  FalconEmulator falcon({});
  EmulatedUsb usb;
  usb.plug(falcon, "2");
  const auto device = openAt("");
  const Vec3d push(0, 0, 4);
  ASSERT_TRUE(ready(*device)) << device->status();
  const double bus = hundredExchanges(*device);
  ASSERT_TRUE(until(*device, push, [&](bool) { return falcon.forceN().norm() > 3; })) << device->status();
  falcon.misbehave(FalconFault::stall);
  EXPECT_TRUE(until(*device, push, [](bool fresh) { return !fresh; }));
  falcon.misbehave(FalconFault::none);
  EXPECT_TRUE(until(
      *device, Vec3d::Zero(), [&](bool fresh) { return fresh && falcon.forceN().norm() == 0; }, std::max(1.0, bus)))
      << device->status();
}

TEST(FalconUsb, AGuardFindsItAndPutsItToZero) {
  FalconEmulator falcon({});
  EmulatedUsb usb;
  usb.plug(falcon, "2");
  {
    UsbTransport held(0x0403, 0xcb48, "");  // A driver that dies: its last word was a force.
    ASSERT_EQ(held.open(), ByteTransport::Opening::opened) << held.sentence();
    EXPECT_GE(held.file(), 0) << "for a guard";
    const std::string packet = "<BBAABBAABBAAAA>";
    ASSERT_EQ(held.write({reinterpret_cast<const uint8_t*>(packet.data()), packet.size()}, 100'000'000), Transfer::ok);
    EXPECT_GT(falcon.forceN().norm(), 0);
    EXPECT_EQ(zeroFalcons(), 0) << "held by a program that lives";
    EXPECT_GT(falcon.forceN().norm(), 0);
  }
  const int64_t begin = nowNs();
  EXPECT_EQ(zeroFalcons(), 1);
  std::printf("zeroed in %.1f ms\n", double(nowNs() - begin) * 1e-6);
  EXPECT_EQ(falcon.forceN().norm(), 0);
}

}  // namespace
}  // namespace argil::haptics
