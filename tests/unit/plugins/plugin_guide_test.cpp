// Guides of plugins in the servo: felt as they say, within the device's limits, and whatever they do wrong fades.

#include "engine/plugins/plugin_guide.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "engine/plugins/felt_guides.h"
#include "haptics/servo/servo_tick.h"
#include "tests/support/plugins/plugin_folders.h"
#include "tests/support/tier.h"
#include "tests/unit/haptics/realtime_trap.h"

namespace argil::engine {
namespace {

using haptics::LocalModel;

// A device that stands where it is put and keeps what it is told.
class Still : public haptics::Device {
 public:
  Still() {
    sheet_.name = "still";
    sheet_.dofOut = 3;
    sheet_.peakForceN = 3;
    sheet_.continuousForceN = 3;
    sheet_.topStiffnessNmm = 1;
    sheet_.topDampingNsmm = 0.004;
    sheet_.workspaceMm = Vec3d::Constant(200);
  }
  [[nodiscard]] const haptics::DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double, haptics::DeviceState& state) ARGIL_REALTIME override {
    state.pose.translation = at;
    return true;
  }
  void write(double, const Vec3d& force) ARGIL_REALTIME override { told = force; }
  Vec3d at = Vec3d::Zero(), told = Vec3d::Zero();

 private:
  haptics::DeviceSheet sheet_;
};

std::filesystem::path filesFolder() {
  namespace fs = std::filesystem;
  const fs::path made = fs::temp_directory_path() / "guide-plugins" / "files.argil-plugin";
  if (fs::exists(made)) return made;
  fs::create_directories(made / kPluginMachine);
  fs::copy_file(fs::path(ARGIL_BAD_PLUGINS) / "files.so", made / kPluginMachine / "files.so");
  std::ofstream(made / kPluginFile) << R"({"format": 1, "id": "test.files", "name": "Files", "version": "1.0.0",
    "licence": "CC0-1.0", "help": "For tests.", "library": "files.so",
    "guides": [{"id": "plane", "name": "Plane", "help": "For tests.", "numbers": [{"id": "how", "name": "How",
                "help": "What goes wrong.", "low": 0, "high": 9, "standard": 0}]}]})";
  return made;
}

std::shared_ptr<PluginGuide> guideOf(float how) {
  const auto made = filesFolder();
  return std::make_shared<PluginGuide>(std::make_shared<PluginProcesses>(libraryOf(readPlugin(made), made, {})),
                                       "test.files.plane", std::vector<std::string>{"how"}, std::array{how});
}

// A servo in virtual time beside a plugin in real time.
struct Servo {
  explicit Servo(std::shared_ptr<haptics::LocalModelSource> source) {
    auto next = std::make_unique<haptics::Scene>();
    next->guides.push_back({1, haptics::FollowModel{std::move(source), 2}});
    next->check();
    scene.publish(std::move(next));
  }
  // A tick; the force on the hand.
  Vec3d run() {
    flags = tick.run(timeS += 0.001, false);
    return tick.last().forceN;
  }
  Still device;
  haptics::Published<haptics::Scene> scene;
  haptics::SampleRing samples{1 << 14};
  haptics::ServoTick tick{device, scene, samples, 0.001};
  double timeS = 0;
  uint32_t flags = 0;
};

// Ticks, a millisecond each by the clock, until the force is as asked; seconds at most.
template <class Is>
bool comesTo(Servo& servo, Is&& is, int most = 20000) {
  for (int i = 0; i < most; ++i) {
    if (is(servo.run())) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(PluginGuide, IsFeltAsItSays) {
  const auto guide = guideOf(0);
  Servo servo(guide);
  servo.device.at = {0, 0, -2};
  // 2 mm behind a plane of 0.2 N/mm.
  EXPECT_TRUE(comesTo(servo, [](const Vec3d& f) { return (f - Vec3d(0, 0, 0.4)).norm() < 0.01; }));
  servo.device.at = {0, 0, 2};
  EXPECT_TRUE(comesTo(servo, [](const Vec3d& f) { return f.norm() < 0.001; })) << "before it nothing is felt";
}

// Each of them ends in no force, without a leap on the way; others say nonsense, which is not believed.
TEST(PluginGuide, WhateverGoesWrongFades) {
  for (const int how : {1, 2, 3, 4, 5, 6, 7, 9}) {
    SCOPED_TRACE(how);
    const auto guide = guideOf(static_cast<float>(how));
    Servo servo(guide);
    servo.device.at = {0, 0, -2};
    Vec3d before = Vec3d::Zero();
    double leap = 0, most = 0;
    bool finite = true;
    const bool faded = comesTo(servo, [&, felt = false](const Vec3d& f) mutable {
      finite = finite && f.allFinite();
      leap = std::max(leap, (f - before).norm());
      most = std::max(most, f.norm());
      before = f;
      felt = felt || f.norm() > 0.1;
      return felt && f.norm() < 1e-6;
    });
    EXPECT_TRUE(faded);
    EXPECT_TRUE(finite);
    EXPECT_LE(most, 2.01) << "N: its own limit";
    EXPECT_LE(leap, 0.06) << "N from tick to tick";
    EXPECT_EQ(servo.flags & haptics::kStopped, 0u);
  }
}

TEST(PluginGuide, OneThatLeapsDoesNotShake) {
  const auto guide = guideOf(8);
  Servo servo(guide);
  servo.device.at = {0, 0, -2};
  Vec3d before = Vec3d::Zero();
  double leap = 0, most = 0;
  (void)comesTo(
      servo,
      [&](const Vec3d& f) {
        leap = std::max(leap, (f - before).norm());
        most = std::max(most, f.norm());
        before = f;
        return false;
      },
      500);
  EXPECT_LE(leap, 0.06);
  EXPECT_LE(most, 2.01);
}

TEST(PluginGuide, AProcessThatEndsIsTold) {
  const auto made = filesFolder();
  const auto processes = std::make_shared<PluginProcesses>(libraryOf(readPlugin(made), made, {}));
  PluginGuide guide(processes, "test.files.plane", {"how"}, std::array{0.0f});
  EXPECT_NO_THROW(guide.look());
  ::kill(processes->newest(), SIGKILL);
  for (int i = 0; i < 1000; ++i) {
    try {
      guide.look();
    } catch (const PluginError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("Files crashed"));
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  FAIL() << "nobody noticed";
}

TEST(PluginGuide, TheServoNeitherAllocatesNorWaits) {
  const auto guide = guideOf(8);
  Servo servo(guide);
  servo.device.at = {0, 0, -2};
  for (int i = 0; i < 100; ++i) (void)servo.run();
  haptics::testing::RealtimeTrap trap;
  if (!haptics::testing::RealtimeTrap::seesAllocationsAndLocks()) GTEST_SKIP() << "sanitizers allocate by themselves";
  trap.enter();
  for (int i = 0; i < 20000; ++i) (void)servo.run();
  trap.leave();
  EXPECT_EQ(trap.allocations, 0u);
  EXPECT_EQ(trap.locks, 0u);
  EXPECT_EQ(trap.systemCalls, 0u);
  EXPECT_EQ(trap.pageFaults, 0u);
}

// Killed at any moment, or nonsense: each tick is done, costs no more than any other, and says a force within limits.
TEST(PluginGuide, NoTickIsLost) {
  if (!haptics::testing::RealtimeTrap::seesAllocationsAndLocks()) GTEST_SKIP() << "sanitizers allocate by themselves";
  const char* const asked = std::getenv("ARGIL_FAULTS");
  const int rounds = asked != nullptr ? std::atoi(asked) : tests::longTier() ? 300 : 30;
  std::mt19937 random(3);
  const auto made = filesFolder();
  int felt = 0;
  for (int round = 0; round < rounds; ++round) {
    const auto processes = std::make_shared<PluginProcesses>(libraryOf(readPlugin(made), made, {}));
    const auto guide = std::make_shared<PluginGuide>(processes, "test.files.plane", std::vector<std::string>{"how"},
                                                     std::array{round % 2 == 0 ? 0.0f : float(random() % 10)});
    Servo servo(guide);
    servo.device.at = {0, 0, -2};
    std::jthread killer([pid = processes->newest(), after = random() % 20000] {
      std::this_thread::sleep_for(std::chrono::microseconds(after));
      ::kill(pid, SIGKILL);
    });
    for (int i = 0; i < 100; ++i) (void)servo.run();
    haptics::testing::RealtimeTrap trap;
    double most = 0, leap = 0;
    Vec3d before = servo.device.told;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(25);
    while (std::chrono::steady_clock::now() < end) {
      trap.enter();
      const Vec3d force = servo.run();
      trap.leave();
      most = std::max(most, force.norm());
      leap = std::max(leap, (force - before).norm());
      before = force;
      if (!force.allFinite()) most = 1e9;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    ASSERT_EQ(trap.allocations + trap.locks + trap.systemCalls + trap.pageFaults, 0u) << round;
    ASSERT_LE(most, 2.01) << round;
    ASSERT_LE(leap, 0.06) << round;
    ASSERT_EQ(servo.flags & haptics::kStopped, 0u) << round;
    felt += most > 0.1;
  }
  EXPECT_GT(felt, rounds / 10);
}

TEST(PluginGuide, AnyBytesAreAModelOrNone) {
  std::mt19937_64 random(1);
  int good = 0;
  for (int i = 0; i < 200000; ++i) {
    argil_local_model said{};
    auto* bytes = reinterpret_cast<uint8_t*>(&said);
    if (i % 2 == 0) {
      for (size_t k = 0; k < sizeof said; ++k) bytes[k] = static_cast<uint8_t>(random());
    } else {
      said.count = random() % 9;
      said.radius_mm = 10;
      for (auto& element : said.elements) element = {uint32_t(random() % 2), 0.1f, {1, 2, 3}, {0, 0, 1}, 5};
      bytes[random() % sizeof said] = static_cast<uint8_t>(random());
    }
    LocalModel model;
    if (!checkedModel(said, model)) continue;
    ++good;
    ASSERT_LE(model.count, LocalModel::kMost);
    for (int k = 0; k < model.count; ++k) {
      const LocalModel::Element& e = model.elements[static_cast<size_t>(k)];
      ASSERT_TRUE(e.place.allFinite() && e.normal.allFinite());
      ASSERT_TRUE(std::isfinite(e.stiffnessNmm) && e.stiffnessNmm >= 0);
      ASSERT_GT(e.rangeMm, 0);
      ASSERT_NEAR(e.normal.norm(), 1, 1e-9);
    }
  }
  EXPECT_GT(good, 50000);
}

// The example: the hand beside the rail is drawn to it.
TEST(PluginGuide, TheRailDrawsTheHand) {
  const auto made = tests::examplePlugin("rail");
  const Plugin plugin = readPlugin(made);
  std::vector<std::string> names;
  std::vector<float> values;
  for (const auto& number : plugin.guides.at(0).numbers) {
    names.push_back(number.id);
    values.push_back(static_cast<float>(number.standard));
  }
  const auto guide = std::make_shared<PluginGuide>(std::make_shared<PluginProcesses>(libraryOf(plugin, made, {})),
                                                   "org.argil.rail.rail", names, values);
  Servo servo(guide);
  servo.device.at = {27, 0, 1};  // the rail is at (25, 0, 0)
  EXPECT_TRUE(comesTo(servo, [](const Vec3d& f) { return f.x() < -0.2 && f.z() < -0.1 && std::abs(f.y()) < 0.01; }));
}

}  // namespace
}  // namespace argil::engine
