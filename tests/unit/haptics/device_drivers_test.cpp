// What is peculiar to a driver: bytes, units, settings; what all must do is in device_conformance_test.cpp.

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "../../support/haply_emulator.h"
#include "clay/error.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/pointer.h"
#include "haptics/devices/recorded.h"
#include "haptics/devices/registry.h"

namespace argil::haptics {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(Haply, speaksNewtonsInLittleEndianFloats) {
  const auto packet = haplyForcePacket({1, -2, 0.5});
  const uint8_t wanted[] = {0x2A, 0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0, 0, 0, 0, 0x3F};
  EXPECT_EQ(std::memcmp(packet.data(), wanted, sizeof wanted), 0);
  const auto zero = haplyForcePacket(Vec3d::Zero());
  ASSERT_EQ(haplyZeroPacket().size(), zero.size());
  EXPECT_EQ(std::memcmp(haplyZeroPacket().data(), zero.data(), zero.size()), 0);
}

TEST(Haply, turnsWithItsGripAndComesBack) {
  testing::HaplyArmEmulator arm(HaplyOptions().centreMm);
  testing::HaplyGripEmulator grip;
  arm.plug();
  grip.plug();
  HaplyOptions options;
  options.port = arm.path();
  options.grip = grip.path();
  auto device = openHaply(options);
  grip.hand({0, 0, 0}, 1);
  DeviceState state;
  for (int i = 0; i < 2000 && state.buttons == 0; ++i) {
    device->read(0, state);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(state.buttons, 1u);
  EXPECT_LT(state.pose.rotation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()))), 1e-6);
  // The grip lost: the arm goes on, no button stays held.
  grip.unplug();
  for (int i = 0; i < 2000 && state.buttons != 0; ++i) {
    device->read(0, state);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(state.buttons, 0u);
  bool fresh = false;
  for (int i = 0; i < 2000 && !(fresh = device->read(0, state)); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(fresh) << device->status();
  EXPECT_LT(state.pose.rotation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()))), 1e-6);
  arm.unplug();
  for (int i = 0; i < 2000 && device->read(0, state); ++i) std::this_thread::sleep_for(1ms);
  arm.plug();
  for (int i = 0; i < 2000 && !(fresh = device->read(0, state)); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(fresh) << device->status();
  device.reset();
  EXPECT_THROW((void)openHaply({.port = ""}), Error);
  EXPECT_THROW((void)openHaply({.port = "/dev/ttyACM0", .grip = "/dev/ttyACM0"}), Error);
}

TEST(Haply, saysWhatIsWrongWithALineThatIsNone) {
  const auto notALine = openHaply({.port = "/dev/null"});
  const auto absent = openHaply({.port = "/dev/ttyNeverThere"});
  std::this_thread::sleep_for(50ms);
  EXPECT_NE(notALine->status().find("no serial line"), std::string::npos) << notALine->status();
  EXPECT_NE(absent->status().find("not plugged in"), std::string::npos) << absent->status();
}

PointerSample at(double x, double surface) {
  PointerSample s;
  s.origin = {x, 0, 100};
  s.direction = {0, 0, -2};
  s.surfaceMm = surface;
  return s;
}

TEST(Pointer, goesToTheSurfaceAndByWheelAndPressureBeyond) {
  PointerDevice pointer({.wheelStepMm = 0.5, .penDepthMm = 4, .smoothSeconds = 0});
  DeviceState state;
  EXPECT_FALSE(pointer.read(0, state));
  EXPECT_NE(pointer.status().find("waiting"), std::string::npos);
  PointerSample s = at(1, 90);
  ASSERT_TRUE(pointer.feed(s));
  ASSERT_TRUE(pointer.read(0.001, state));
  EXPECT_LT((state.pose.translation - Vec3d(1, 0, 10)).norm(), 1e-12);
  EXPECT_TRUE(pointer.read(0.002, state)) << "a mouse at rest sends nothing";
  s.wheel = 3;
  s.pressure = 0.5f;
  s.surfaceMm = std::nan("");  // Nothing under it: the last depth stays.
  ASSERT_TRUE(pointer.feed(s));
  pointer.read(0.05, state);
  EXPECT_LT((state.pose.translation - Vec3d(1, 0, 10 - 1.5 - 2)).norm(), 1e-12);
  EXPECT_EQ(state.pressure, 0.5f);
  EXPECT_LT((state.pose.rotation * Vec3d::UnitZ() - Vec3d::UnitZ()).norm(), 1e-12) << "upright";
  s.tiltX = 0.5;
  pointer.feed(s);
  pointer.read(0.1, state);
  EXPECT_NEAR((state.pose.rotation * Vec3d::UnitZ()).x(), std::sin(0.5), 1e-12) << "leans to the right";
  s.pressure = -1;
  s.buttons = 1;
  pointer.feed(s);
  pointer.read(0.15, state);
  EXPECT_EQ(state.pressure, 1) << "held is pressed where the thing cannot tell";
  pointer.leave();
  EXPECT_FALSE(pointer.read(0.2, state));
}

TEST(Pointer, neverMovesFasterThanItsSheet) {
  PointerDevice pointer;
  pointer.feed(at(0, 100));
  DeviceState state;
  pointer.read(0, state);
  Vec3d last = state.pose.translation;
  pointer.feed(at(300, 20));
  double farthest = 0;
  for (int i = 1; i < 500; ++i) {
    ASSERT_TRUE(pointer.read(i * 1e-3, state));
    farthest = std::max(farthest, (state.pose.translation - last).norm());
    last = state.pose.translation;
  }
  EXPECT_LE(farthest, pointer.sheet().topSpeedMms * 1e-3);
  EXPECT_GT(farthest, 1);
  EXPECT_LT((last - Vec3d(300, 0, 80)).norm(), 1e-6) << "and gets there";
}

TEST(Pointer, refusesNumbersThatAreNone) {
  PointerDevice pointer;
  EXPECT_TRUE(pointer.feed(at(0, 100)));
  std::vector<PointerSample> bad(6, at(0, 100));
  bad[0].origin.x() = std::nan("");
  bad[1].direction.setZero();
  bad[2].pressure = std::nanf("");
  bad[3].tiltY = 7;
  bad[4].wheel = INFINITY;
  bad[5].direction.y() = INFINITY;
  for (size_t i = 0; i < bad.size(); ++i) EXPECT_FALSE(pointer.feed(bad[i])) << i;
  EXPECT_THROW(PointerDevice({.penDepthMm = -1}), Error);
  EXPECT_THROW(PointerDevice({.smoothSeconds = std::nan("")}), Error);
}

TEST(Recorded, playsInServoTimeToItsEndOrOverAgain) {
  const HandPath path = HandPath::line({0, 0, 0}, {10, 0, 0}, 1.0, 3);
  RecordedDevice once(path, {}), again(path, {.loop = true});
  DeviceState state;
  for (double start : {100.0}) {
    ASSERT_TRUE(once.read(start, state));
    EXPECT_EQ(state.pose.translation.x(), 0);
    ASSERT_TRUE(once.read(start + 0.5, state));
    EXPECT_NEAR(state.pose.translation.x(), 5, 1e-9);
    EXPECT_EQ(state.buttons, 3u);
    EXPECT_TRUE(once.read(start + 1.0, state));
    EXPECT_FALSE(once.read(start + 1.001, state));
    EXPECT_NE(once.status().find("end"), std::string::npos) << once.status();
  }
  ASSERT_TRUE(again.read(7, state));
  EXPECT_FALSE(again.read(8.001, state)) << "a tick of nothing, where the path jumps back";
  EXPECT_TRUE(again.read(8.002, state));
  EXPECT_EQ(state.pose.translation.x(), 0);
  EXPECT_THROW(RecordedDevice(HandPath(), {}), Error);
}

/// A sysfs of our own.
class Sysfs : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "argil-sysfs-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }
  void plant(const fs::path& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  void serial(const std::string& tty, const std::string& usb, const std::string& vendor, const std::string& product, const std::string& name) {
    plant("sys/devices/" + usb + "/idVendor", vendor + "\n");
    plant("sys/devices/" + usb + "/idProduct", product + "\n");
    plant("sys/devices/" + usb + "/product", name + "\n");
    fs::create_directories(root_ / "sys/devices" / usb / (usb + ":1.0"));
    fs::create_directories(root_ / "sys/class/tty" / tty);
    fs::create_symlink(root_ / "sys/devices" / usb / (usb + ":1.0"), root_ / "sys/class/tty" / tty / "device");
    plant("dev/" + tty, "");
  }
  [[nodiscard]] std::vector<FoundDevice> found() const { return findDevices((root_ / "sys").string(), (root_ / "dev").string()); }
  [[nodiscard]] std::string dev(const std::string& name) const { return (root_ / "dev" / name).string(); }

  fs::path root_;
};

TEST_F(Sysfs, listsWhatIsPluggedIn) {
  EXPECT_TRUE(found().empty());
  plant("sys/class/hidraw/hidraw0/device/uevent", "HID_ID=0003:0000046D:0000C077\nHID_NAME=Logitech Mouse\n");
  plant("sys/class/hidraw/hidraw3/device/uevent", "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C652\nHID_NAME=3Dconnexion Universal Receiver\n");
  plant("sys/class/hidraw/hidraw4/device/uevent", "HID_ID=nonsense\n");
  plant("dev/hidraw3", "");
  fs::create_directories(root_ / "sys/class/tty/tty0");
  serial("ttyACM0", "1-4", "2341", "0043", "Arduino Uno");
  serial("ttyACM1", "1-5", "16c0", "0483", "USB Serial");
  serial("ttyACM2", "1-6", "2fe3", "0100", "Haply USB Transceiver");
  const auto devices = found();
  ASSERT_EQ(devices.size(), 2u);
  EXPECT_EQ(devices[0].name, "haply:" + dev("ttyACM1") + "," + dev("ttyACM2"));
  EXPECT_EQ(devices[0].problem, "");
  EXPECT_EQ(devices[1].name, "spacemouse:" + dev("hidraw3"));
  EXPECT_EQ(devices[1].what, "3Dconnexion Universal Receiver");
  fs::remove(root_ / "dev/hidraw3");
  EXPECT_NE(found()[1].problem.find("99-argil.rules"), std::string::npos);
}

TEST_F(Sysfs, listsFalconsByTheirSockets) {
  const auto usb = [&](const std::string& place, const std::string& vendor, const std::string& product, int address) {
    plant("sys/bus/usb/devices/" + place + "/idVendor", vendor + "\n");
    plant("sys/bus/usb/devices/" + place + "/idProduct", product + "\n");
    plant("sys/bus/usb/devices/" + place + "/busnum", "1\n");
    plant("sys/bus/usb/devices/" + place + "/devnum", std::to_string(address) + "\n");
  };
  usb("1-1", "0403", "6001", 2);  // Another chip of the same maker.
  usb("1-2.3", "0403", "cb48", 17);
  usb("1-4", "0403", "cb48", 5);
  plant("dev/bus/usb/001/017", "");
  const auto devices = found();
  ASSERT_EQ(devices.size(), 2u);
  EXPECT_EQ(devices[0].name, "falcon:1-2.3");
  EXPECT_EQ(devices[0].node, dev("bus/usb/001/017"));
  EXPECT_EQ(devices[0].problem, "");
  EXPECT_EQ(devices[1].name, "falcon:1-4");
  EXPECT_NE(devices[1].problem.find("99-argil.rules"), std::string::npos);
}

TEST(Registry, opensByNameAndNamesWhatThereIs) {
  for (const char* name : {"touch", "falcon", "falcon:9-9", "simulated:falcon", "spacemouse", "haply", "haply:/dev/ttyNeverThere"}) {
    const auto device = openDevice(name);
    ASSERT_NE(device, nullptr);
    EXPECT_EQ(device->sheet().name, sheetOfDevice(name).name);
  }
  EXPECT_TRUE(isHardware("haply:/dev/ttyACM3"));
  EXPECT_TRUE(isHardware("falcon"));
  EXPECT_FALSE(isHardware("simulated:falcon"));
  EXPECT_FALSE(isHardware("omega3"));
  DeviceState state;
  EXPECT_TRUE(openDevice("omega3")->read(0, state));
  for (const char* name : {"teapot", "simulated:teapot", "", "recorded:", "recorded:/never/there.csv", "hap"}) {
    EXPECT_THROW((void)openDevice(name), Error) << name;
    EXPECT_THROW((void)sheetOfDevice(name), Error) << name;
  }
  try {
    (void)openDevice("teapot");
  } catch (const Error& e) {
    for (const char* known : {"teapot", "haply", "spacemouse", "recorded", "omega3"}) EXPECT_NE(std::string(e.what()).find(known), std::string::npos) << e.what();
  }
  const fs::path file = fs::temp_directory_path() / "argil-registry-path.csv";
  std::ofstream(file) << "time,x,y,z\n5,0.1,0,0\n6,0.2,0,0\n";
  OpenDeviceOptions options;
  EXPECT_THROW((void)openDevice("recorded:" + file.string(), options), Error) << "not the house's layout, and no units";
  options.layout.units = "m";
  ASSERT_TRUE(openDevice("recorded:" + file.string(), options)->read(0, state));
  EXPECT_NEAR(state.pose.translation.x(), 100, 1e-9);
  fs::remove(file);
}

}  // namespace
}  // namespace argil::haptics
