// What is peculiar to a driver: bytes, units, settings; what all must do is in device_conformance_test.cpp.

#include <gtest/gtest.h>

#include <fcntl.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "../../support/devices/haply_emulator.h"
#include "../../support/devices/spacemouse_emulator.h"
#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/pointer.h"
#include "haptics/devices/recorded.h"
#include "haptics/devices/registry.h"
#include "haptics/devices/serial_port.h"

namespace argil::haptics {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(Haply, SpeaksNewtonsInLittleEndianFloats) {
  const auto packet = haplyForcePacket({1, -2, 0.5});
  const uint8_t wanted[] = {0x2A, 0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0, 0, 0, 0, 0x3F};
  EXPECT_EQ(std::memcmp(packet.data(), wanted, sizeof wanted), 0);
  const auto zero = haplyForcePacket(Vec3d::Zero());
  ASSERT_EQ(haplyZeroPacket().size(), zero.size());
  EXPECT_EQ(std::memcmp(haplyZeroPacket().data(), zero.data(), zero.size()), 0);
}

TEST(Haply, TurnsWithItsGripAndComesBack) {
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
  EXPECT_LT(
      state.pose.rotation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()))),
      1e-6);
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
  EXPECT_LT(
      state.pose.rotation.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()))),
      1e-6);
  arm.unplug();
  for (int i = 0; i < 2000 && device->read(0, state); ++i) std::this_thread::sleep_for(1ms);
  arm.plug();
  for (int i = 0; i < 2000 && !(fresh = device->read(0, state)); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(fresh) << device->status();
  device.reset();
  EXPECT_THROW((void)openHaply({.port = ""}), Error);
  EXPECT_THROW((void)openHaply({.port = "/dev/ttyACM0", .grip = "/dev/ttyACM0"}), Error);
}

TEST(Haply, OfStatesOfTheGripThatComeTogetherTheLastCounts) {
  testing::HaplyArmEmulator arm(HaplyOptions().centreMm);
  testing::HaplyGripEmulator grip;
  arm.plug();
  grip.plug();
  HaplyOptions options;
  options.port = arm.path();
  options.grip = grip.path();
  grip.lateButtons(8);
  auto device = openHaply(options);
  for (const uint32_t held : {1u, 0u, 2u}) {
    grip.hand({0, 0, 0}, held);
    DeviceState state;
    state.buttons = 4;
    for (int i = 0; i < 2000 && state.buttons != held; ++i) {
      device->read(0, state);
      std::this_thread::sleep_for(1ms);
    }
    int late = 0;
    for (int i = 0; i < 60; ++i) {
      device->read(0, state);
      late += state.buttons != held ? 1 : 0;
      std::this_thread::sleep_for(1ms);
    }
    EXPECT_LE(late, 5) << "but where a line is read between the two";
  }
}

/// Something else than a Haply at the end of a line: says the same whatever it is asked, or talks without being asked.
class OtherThing final : public testing::PtyEmulator {
 public:
  explicit OtherThing(std::vector<uint8_t> says) : says_(std::move(says)) {}
  ~OtherThing() override { stop(); }

 protected:
  size_t answer(std::span<const uint8_t> in, const Hand&, std::vector<uint8_t>& out) override {
    out = says_;
    return in.size();
  }
  void spoil(testing::Misbehaviour, std::vector<uint8_t>&) override {}

 private:
  std::vector<uint8_t> says_;
};

// Waits until the device says so, on however slow a machine.
bool says(const Device& device, const std::string& what) {
  for (int i = 0; i < 10000; ++i) {
    if (device.status().find(what) != std::string::npos) return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

TEST(Haply, RefusesAnotherDeviceThatAnswers) {
  OtherThing arduino({'H', 'e', 'l', 'l', 'o', '\n'});
  arduino.plug();
  auto device = openHaply({.port = arduino.path()});
  EXPECT_TRUE(says(*device, "answers as another device")) << device->status();
  DeviceState state;
  EXPECT_FALSE(device->read(0, state));
  device.reset();
  EXPECT_EQ(arduino.told(), 0u);

  testing::HaplyGripEmulator grip;
  grip.plug();
  device = openHaply({.port = grip.path()});
  EXPECT_TRUE(says(*device, "is the grip of a Haply, not its arm")) << device->status();
}

TEST(Haply, LeavesADeviceThatTalksWithoutEnd) {
  for (const bool identifies : {false, true}) {
    OtherThing talker(identifies ? std::vector<uint8_t>{0x0B, 1, 2, 3} : std::vector<uint8_t>{'x'});
    talker.plug();
    talker.talkWithoutEnd(true);
    auto device = openHaply({.port = talker.path()});
    EXPECT_TRUE(says(*device, "talks without end")) << device->status();
    // Its thread is not lost in reading: closing comes back.
    device.reset();
  }
}

// One that begins to talk without end while it is driven is a fault, and its force is zero.
TEST(Haply, AnArmThatBeginsToTalkWithoutEndIsAFault) {
  testing::HaplyArmEmulator arm(HaplyOptions().centreMm);
  arm.plug();
  auto device = openHaply({.port = arm.path()});
  ASSERT_TRUE(says(*device, "ready")) << device->status();
  arm.talkWithoutEnd(true);
  for (const char* word : {"ready"})
    for (int i = 0; i < 10000 && device->status().find(word) != std::string::npos; ++i)
      std::this_thread::sleep_for(1ms);
  EXPECT_EQ(device->status().find("ready"), std::string::npos) << device->status();
  arm.talkWithoutEnd(false);
  EXPECT_TRUE(says(*device, "ready")) << device->status();
}

// A terminal whose other end is gone answers every poll() at once.
TEST(SerialPort, IsGoneWhenItIsHungUpAndDoesNotSpin) {
  for (const bool leftover : {false, true}) {
    const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    ASSERT_GE(master, 0);
    ASSERT_EQ(grantpt(master), 0);
    ASSERT_EQ(unlockpt(master), 0);
    SerialPort port;
    std::string sentence;
    ASSERT_EQ(port.open(ptsname(master), sentence), SerialPort::Opened::ready) << sentence;
    if (leftover) {
      ASSERT_EQ(write(master, "abc", 3), 3);
    }
    close(master);
    uint8_t bytes[16];
    const int64_t far = nowNs() + 20'000'000'000;
    timespec before{}, after{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
    int n = 0;
    do n = port.read(bytes, far);
    while (n > 0);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
    EXPECT_EQ(n, -1) << "gone, and long before the deadline";
    EXPECT_LT(nowNs(), far);
    EXPECT_LT(double(after.tv_sec - before.tv_sec) + 1e-9 * double(after.tv_nsec - before.tv_nsec), 1.0)
        << "processor time";
  }
}

TEST(Haply, SaysWhatIsWrongWithALineThatIsNone) {
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

TEST(Pointer, GoesToTheSurfaceAndByWheelAndPressureBeyond) {
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

TEST(Pointer, IsSmoothlyWhereTheCursorJumpedHoweverFarThatIs) {
  PointerDevice pointer;
  pointer.feed(at(0, 100));
  DeviceState state;
  pointer.read(0, state);
  Vec3d last = state.pose.translation;
  pointer.feed(at(300, 20));
  const Vec3d wanted(300, 0, 80);
  double away = (last - wanted).norm();
  for (int i = 1; i <= 60; ++i) {
    ASSERT_TRUE(pointer.read(i * 1e-3, state));
    last = state.pose.translation;
    const double now = (last - wanted).norm();
    if (i < 40) {
      EXPECT_LT(now, away) << "it never goes beyond";
    }
    if (i == 1) {
      EXPECT_GT(now, 0.5 * away) << "smoothly";
    }
    away = now;
  }
  EXPECT_LT(away, 1e-3);
}

TEST(Pointer, RefusesNumbersThatAreNone) {
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

// It looks for its device ten times a second, and is woken to end.
TEST(DeviceThread, EndsAtOnceWhileItsDeviceIsNotThere) {
  constexpr int kDevices = 40;
  const int64_t begin = nowNs();
  for (int i = 0; i < kDevices; ++i) {
    const auto absent = openHaply({.port = "/dev/ttyNeverThere"});
    ASSERT_TRUE(says(*absent, "not plugged in"));
  }
  EXPECT_LT(double(nowNs() - begin) * 1e-9, 0.5 * kDevices * ThreadedDevice::kRetrySeconds);
}

TEST(Recorded, PlaysInServoTimeToItsEndOrOverAgain) {
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
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.5, Vec3d(1, 2, 2) / 3));
  RecordedDevice turns(HandPath::unchecked({{.timeS = 0, .rotation = turned, .pressure = 0.25f},
                                            {.timeS = 1, .rotation = turned, .pressure = 0.25f}}),
                       {});
  ASSERT_TRUE(turns.read(0, state));
  EXPECT_LT(state.pose.rotation.angularDistance(turned), 1e-9);
  EXPECT_EQ(state.pressure, 0.25f);
  EXPECT_EQ(once.sheet().resolutionMm, 1e-3);
  EXPECT_EQ(once.sheet().dofOut, 0) << "it pushes nobody";
  EXPECT_GE(once.sheet().workspaceMm.x(), 20) << "about its middle, to the farthest point";
  EXPECT_GE(once.sheet().topSpeedMms, 15) << "what the hand did";
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
  void serial(const std::string& tty, const std::string& usb, const std::string& vendor, const std::string& product,
              const std::string& name) {
    plant("sys/devices/" + usb + "/idVendor", vendor + "\n");
    plant("sys/devices/" + usb + "/idProduct", product + "\n");
    plant("sys/devices/" + usb + "/product", name + "\n");
    fs::create_directories(root_ / "sys/devices" / usb / (usb + ":1.0"));
    fs::create_directories(root_ / "sys/class/tty" / tty);
    fs::create_symlink(root_ / "sys/devices" / usb / (usb + ":1.0"), root_ / "sys/class/tty" / tty / "device");
    plant("dev/" + tty, "");
  }
  [[nodiscard]] std::vector<FoundDevice> found() const {
    return findDevices((root_ / "sys").string(), (root_ / "dev").string());
  }
  [[nodiscard]] std::string dev(const std::string& name) const { return (root_ / "dev" / name).string(); }

  fs::path root_;
};

TEST_F(Sysfs, ListsWhatIsPluggedIn) {
  EXPECT_TRUE(found().empty());
  plant("sys/class/hidraw/hidraw0/device/uevent", "HID_ID=0003:0000046D:0000C077\nHID_NAME=Logitech Mouse\n");
  plant("sys/class/hidraw/hidraw3/device/uevent",
        "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C652\nHID_NAME=3Dconnexion Universal Receiver\n");
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

TEST_F(Sysfs, ListsAReceiverOnceAndNoOrdinaryMouse) {
  const auto puck = testing::SpaceMouseEmulator::descriptor(testing::SpaceMouseEmulator::Layout::oneReport);
  const std::string axes(reinterpret_cast<const char*>(puck.data()), puck.size());
  const std::string mouse("\x05\x01\x09\x02\xA1\x01\x09\x30\x09\x31\x15\x81\x25\x7F\x75\x08\x95\x02\x81\x06\xC0", 21);
  for (int i = 0; i < 5; ++i) {
    const std::string folder = "sys/class/hidraw/hidraw" + std::to_string(i) + "/device/";
    plant(folder + "uevent",
          "HID_ID=0003:0000256F:0000C652\nHID_NAME=3Dconnexion Universal Receiver\nHID_PHYS=usb-0000:00:14.0-4/input" +
              std::to_string(i) + "\nHID_UNIQ=\n");
    plant(folder + "report_descriptor", i == 0 ? mouse : axes);
    plant("dev/hidraw" + std::to_string(i), "");
  }
  plant("sys/class/hidraw/hidraw7/device/uevent",
        "HID_ID=0003:0000256F:0000C650\nHID_NAME=3Dconnexion CadMouse\nHID_PHYS=usb-0000:00:14.0-5/input0\n");
  plant("sys/class/hidraw/hidraw7/device/report_descriptor", mouse);
  plant("sys/class/hidraw/hidraw8/device/uevent",
        "HID_ID=0005:0000256F:0000C63A\nHID_NAME=SpaceMouse Wireless "
        "BT\nHID_PHYS=aa:bb:cc:dd:ee:ff\nHID_UNIQ=11:22:33:44:55:66\n");
  plant("dev/hidraw8", "");
  const auto devices = found();
  ASSERT_EQ(devices.size(), 2u);
  EXPECT_EQ(devices[0].name, "spacemouse:" + dev("hidraw1")) << "once, at the first node that has axes";
  EXPECT_EQ(devices[1].name, "spacemouse:" + dev("hidraw8"));
  EXPECT_EQ(devices[1].what, "SpaceMouse Wireless BT");
}

// The rules as udev reads them: every key of a line must match.
TEST(UdevRules, OpenEverySpaceMouseByCableAndByRadio) {
  std::ifstream in(ARGIL_SOURCE_DIR "/installer/99-argil.rules");
  ASSERT_TRUE(in);
  std::vector<std::map<std::string, std::string>> rules;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::map<std::string, std::string> keys;
    // KEY=="value", of which there are some in a line.
    for (size_t at = line.find("==\""), end = 0; at != std::string::npos; at = line.find("==\"", end)) {
      const size_t begin = line.find_last_of(" ,", at) + 1;
      end = line.find('"', at + 3);
      ASSERT_NE(end, std::string::npos) << line;
      keys[line.substr(begin, at - begin)] = line.substr(at + 3, end - at - 3);
    }
    EXPECT_NE(line.find("uaccess"), std::string::npos) << line;
    rules.push_back(keys);
  }
  const auto opens = [&](const std::map<std::string, std::string>& device) {
    return std::any_of(rules.begin(), rules.end(), [&](const auto& rule) {
      return std::all_of(rule.begin(), rule.end(), [&](const auto& key) {
        const auto has = device.find(key.first);
        if (has == device.end()) return false;
        std::stringstream ways(key.second);
        for (std::string way; std::getline(ways, way, '|');)
          if (fnmatch(way.c_str(), has->second.c_str(), 0) == 0) return true;
        return false;
      });
    });
  };
  const auto hex = [](int n) {
    char text[8];
    std::snprintf(text, sizeof text, "%04x", n);
    return std::string(text);
  };
  int known = 0;
  for (const int vendor : {0x046D, 0x256F})
    for (int product = 0xC600; product < 0xC700; ++product) {
      const bool ours = isSpaceMouse(static_cast<uint16_t>(vendor), static_cast<uint16_t>(product));
      known += ours;
      EXPECT_EQ(opens({{"KERNEL", "hidraw3"},
                       {"SUBSYSTEM", "hidraw"},
                       {"ATTRS{idVendor}", hex(vendor)},
                       {"ATTRS{idProduct}", hex(product)}}),
                ours)
          << hex(vendor) << ":" << hex(product);
    }
  EXPECT_GE(known, 0x100 + 12);
  EXPECT_TRUE(opens({{"KERNEL", "hidraw3"}, {"SUBSYSTEM", "hidraw"}, {"KERNELS", "0005:256F:C63A.0007"}}))
      << "by Bluetooth";
  EXPECT_FALSE(opens({{"KERNEL", "hidraw3"}, {"SUBSYSTEM", "hidraw"}, {"KERNELS", "0005:046D:B019.0007"}}))
      << "not a mouse of another maker";
}

TEST_F(Sysfs, ListsFalconsByTheirSockets) {
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

TEST(Registry, OpensByNameAndNamesWhatThereIs) {
  for (const char* name :
       {"touch", "falcon", "falcon:9-9", "simulated:falcon", "spacemouse", "haply", "haply:/dev/ttyNeverThere"}) {
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
    for (const char* known : {"teapot", "haply", "spacemouse", "recorded", "omega3"})
      EXPECT_NE(std::string(e.what()).find(known), std::string::npos) << e.what();
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
