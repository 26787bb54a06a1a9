// Devices of plugins: read and driven as any other, and whatever they do wrong is no state and no force.

#include "engine/plugins/plugin_device.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include "engine/plugins/check_plugin.h"
#include "engine/plugins/plugins.h"
#include "haptics/base/clock.h"
#include "haptics/devices/registry.h"
#include "io/sandbox/sandbox.h"
#include "tests/support/plugins/plugin_folders.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kNode = "/dev/argil-test";

const fs::path& deviceFolder() {
  static const fs::path made = [] {
    const fs::path folder = fs::temp_directory_path() / "device-plugins" / "device.argil-plugin";
    fs::remove_all(folder);
    fs::create_directories(folder / kPluginMachine);
    fs::copy_file(fs::path(ARGIL_BAD_PLUGINS) / "device.so", folder / kPluginMachine / "device.so");
    std::ofstream file(folder / kPluginFile);
    file << R"({"format": 1, "id": "test.device", "name": "Devices", "version": "1.0.0", "licence": "CC0-1.0",
      "help": "For tests.", "library": "device.so", "devices": [)";
    for (const char* id : {"echo", "nan-place", "far-away", "nan-turn", "pressure", "gone", "crash", "hang", "busy"})
      file << R"({"id": ")" << id << R"(", "name": "Trial", "help": "For tests.", "measures": 3, "drives": 3,
        "workspace_mm": [200, 200, 200], "resolution_mm": 0.01, "rate_hz": 1000, "buttons": 3, "peak_n": 3,
        "continuous_n": 1, "stiffness_n_mm": 1, "damping_ns_mm": 0.002},)";
    file << R"({"id": "behind", "name": "Trial", "help": "For tests.", "measures": 3, "drives": 0,
        "workspace_mm": [300, 300, 300], "resolution_mm": 1, "rate_hz": 100, "buttons": 3,
        "nodes": ["/dev/argil-tes*"]}]})";
    return folder;
  }();
  return made;
}

std::unique_ptr<haptics::ThreadedDevice> opened(const std::string& id) {
  const Plugin plugin = readPlugin(deviceFolder());
  for (const Plugin::Device& device : plugin.devices)
    if (device.id == "test.device." + id) {
      auto made = openPluginDevice(device, libraryOf(plugin, deviceFolder(), {}));
      return std::unique_ptr<haptics::ThreadedDevice>(dynamic_cast<haptics::ThreadedDevice*>(made.release()));
    }
  return nullptr;
}

// Reads and commands a force a thousand times a second, until it is as asked; seconds at most.
template <class Is>
bool comesTo(haptics::Device& device, const Vec3d& force, Is&& is, int most = 10000) {
  haptics::DeviceState state;
  for (int i = 0; i < most; ++i) {
    const double timeS = 1e-9 * static_cast<double>(haptics::nowNs());
    if (is(device.read(timeS, state), state)) return true;
    device.write(timeS, force);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(PluginDevice, IsReadAndDriven) {
  const auto device = opened("echo");
  EXPECT_TRUE(comesTo(*device, {1, -2, 0.5}, [](bool there, const haptics::DeviceState& s) {
    return there && (s.pose.translation - Vec3d(10, -20, 5)).norm() < 1e-9;
  }));
  haptics::DeviceState state;
  EXPECT_TRUE(comesTo(*device, {1, -2, 0.5}, [&](bool there, const auto& s) { return state = s, there; }));
  EXPECT_EQ(state.buttons, 5u);
  EXPECT_EQ(state.pressure, 0.5f);
  EXPECT_NEAR(state.pose.rotation.angularDistance(Eigen::Quaterniond::Identity()), 0, 1e-9);
  EXPECT_THAT(device->status(), HasSubstr("Trial"));
  // More than its sheet allows is never told.
  EXPECT_FALSE(comesTo(
      *device, {50, 0, 0}, [](bool there, const auto& s) { return there && s.pose.translation.norm() > 30.01; }, 300));
  // While its gate is shut nothing is.
  device->gate().stop(haptics::StopOwner::user);
  EXPECT_TRUE(
      comesTo(*device, {1, 0, 0}, [](bool there, const auto& s) { return there && s.pose.translation.norm() == 0; }));
}

// Nothing that is nonsense is ever a state; what cannot go on is closed, and tried again while that makes sense.
TEST(PluginDevice, WhateverGoesWrongIsNoState) {
  for (const char* how : {"nan-place", "far-away", "nan-turn", "pressure", "gone", "crash", "hang", "busy"}) {
    SCOPED_TRACE(how);
    const auto device = opened(how);
    bool good = false, sane = true;
    EXPECT_TRUE(comesTo(*device, {1, 0, 0}, [&](bool there, const haptics::DeviceState& s) {
      if (there) {
        sane = sane && s.pose.translation.allFinite() && s.pose.translation.norm() < 300 &&
               s.pose.rotation.coeffs().allFinite() && s.pressure == 0.5f;
        good = good || s.pose.translation.x() == 10;
      }
      return good && !there;
    })) << device->status();
    EXPECT_TRUE(sane);
    const bool again = comesTo(*device, {1, 0, 0}, [](bool there, const auto&) { return there; });
    EXPECT_TRUE(again) << "it is begun anew: " << device->status();
  }
}

TEST(PluginDevice, TheCheckerFindsTheBadOnes) {
  int bad = 0;
  for (const PluginCheck& check : checkPlugin(deviceFolder())) {
    const bool good = check.name.find("test.device.") == std::string::npos ||
                      check.name.starts_with("test.device.echo") || check.name.starts_with("test.device.behind");
    EXPECT_EQ(check.problem.empty(), good) << check.name << ": " << check.problem;
    bad += !good;
  }
  EXPECT_EQ(bad, 8);
}

TEST(PluginDevice, AfterThreeCrashesItIsLeftAlone) {
  const auto device = opened("crash");
  EXPECT_TRUE(comesTo(*device, Vec3d::Zero(), [&](bool, const auto&) {
    return device->status().find("not used again") != std::string::npos;
  })) << device->status();
  EXPECT_THAT(device->status(), HasSubstr("Devices crashed"));
}

TEST(PluginDevice, AnyBytesAreAStateOrNone) {
  std::mt19937_64 random(1);
  haptics::DeviceSheet sheet;
  int good = 0;
  for (int i = 0; i < 200000; ++i) {
    argil_device_state said{};
    auto* bytes = reinterpret_cast<uint8_t*>(&said);
    if (i % 2 == 0)
      for (size_t k = 0; k < sizeof said; ++k) bytes[k] = static_cast<uint8_t>(random());
    else
      said.rotation[3] = 1, bytes[random() % sizeof said] = static_cast<uint8_t>(random());
    haptics::DeviceState state;
    if (!checkedState(said, sheet, state)) continue;
    ++good;
    ASSERT_LE(state.pose.translation.norm(), 2 * sheet.workspaceMm.norm());
    ASSERT_NEAR(state.pose.rotation.norm(), 1, 1e-9);
    ASSERT_TRUE(state.pressure >= 0 && state.pressure <= 1);
  }
  EXPECT_GT(good, 50000);
}

// It opens the node that it asked for, in init() alone, and no other; the other end of it is this test.
TEST(PluginDevice, OpensItsNodeAndNoOther) {
  const auto device = opened("behind");
  EXPECT_TRUE(comesTo(*device, Vec3d::Zero(), [&](bool there, const auto&) {
    EXPECT_FALSE(there);
    return device->status().find("not plugged in") != std::string::npos;
  })) << device->status();
  const int other = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(other >= 0 && ::grantpt(other) == 0 && ::unlockpt(other) == 0);
  ::unlink(kNode);
  if (::symlink(::ptsname(other), kNode) != 0) GTEST_SKIP() << "needs the right to make " << kNode;
  termios raw{};
  ::tcgetattr(other, &raw);
  ::cfmakeraw(&raw);
  ::tcsetattr(other, TCSANOW, &raw);
  std::jthread answers([other] {
    for (char byte; ::read(other, &byte, 1) == 1;)
      if (const char back = 42; ::write(other, &back, 1) != 1) return;
  });
  haptics::DeviceState state;
  EXPECT_TRUE(comesTo(*device, Vec3d::Zero(), [&](bool there, const auto& s) {
    state = s;
    return there;
  })) << device->status();
  EXPECT_EQ(state.pose.translation.x(), 42);
  if (!io::kConfinesNothing) {
    EXPECT_EQ(state.buttons, 0u) << "1: another node, 2: after init(), 4: no ioctl()";
  }
  // Pulled out, and put in again.
  ::unlink(kNode);
  ::close(other);
  EXPECT_TRUE(comesTo(*device, Vec3d::Zero(), [&](bool there, const auto&) { return !there; }));
}

TEST(PluginDevice, WhatItMayIsSaidBeforeItIsEnabled) {
  EXPECT_THAT(mayOf(readPlugin(deviceFolder())), HasSubstr("reads and writes /dev/argil-tes*, and opens no other"));
  for (const char* node : {"/dev/sda", "/dev/mem", "/etc/passwd", "/dev/hidraw0/../mem", "/dev/hidraw?", ""}) {
    const std::string text = fmt::format(
        R"({{"format": 1, "id": "a.b", "name": "A", "version": "1", "licence": "CC0-1.0", "help": "A.",
        "library": "a.so", "devices": [{{"id": "a", "name": "A", "help": "A.", "measures": 3, "drives": 0,
        "workspace_mm": [1, 1, 1], "resolution_mm": 1, "rate_hz": 100, "buttons": 1, "nodes": ["{}"]}}]}})",
        node);
    EXPECT_THROW((void)parsePlugin(text, "plugin.json"), Error) << node;
  }
}

// The example, by the door that users have: it swings, and gives way to a force.
TEST(PluginDevice, TheExampleIsADeviceLikeAllOthers) {
  const fs::path root = fs::temp_directory_path() / "pendulum-settings";
  fs::create_directories(root);
  Plugins plugins({fs::path(ARGIL_PLUGINS)}, root / "settings.json");
  plugins.enable("org.argil.pendulum");
  plugins.load();
  const std::string name = "org.argil.pendulum.hand";
  bool listed = false;
  for (const haptics::FoundDevice& found : haptics::findDevices()) listed = listed || found.name == name;
  EXPECT_TRUE(listed);
  EXPECT_TRUE(haptics::isHardware(name));
  EXPECT_EQ(haptics::sheetOfDevice(name).peakForceN, 4);
  const auto device = haptics::openDevice(name);
  // Against its 0.1 N/mm, 2 N are 20 mm.
  EXPECT_TRUE(
      comesTo(*device, {0, 0, 2}, [](bool there, const auto& s) { return there && s.pose.translation.z() > 15; }));
  EXPECT_TRUE(
      comesTo(*device, {0, 0, 0}, [](bool there, const auto& s) { return there && s.pose.translation.z() < 8; }));
}

}  // namespace
}  // namespace argil::engine
