// A tick allocates nothing, locks nothing, calls no system, faults no page: 10^6 of them while clay is carved. And the
// trap that says so catches each of these when it is planted.

#include "realtime_trap.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <mutex>
#include <shared_mutex>

#include "haptics/analysis/touch_bench.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/scene/texture.h"
#include "haptics/servo/servo.h"
#include "painted_clay.h"
#include "tests/support/tier.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

using testing::RealtimeTrap;
using testing::VirtualSession;

TEST(RealtimeTrap, CatchesWhatIsPlanted) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer touches pages of its own and delivers signals late: nothing can be trapped under it";
#endif
  RealtimeTrap trap;
  const auto breach = [&](auto&& what) {
    trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
    trap.enter();
    what();
    trap.leave();
  };
  breach([] {});
  EXPECT_EQ(trap.allocations + trap.locks + trap.systemCalls + trap.pageFaults, 0u);
  if (RealtimeTrap::seesAllocationsAndLocks()) {
    int* volatile kept = nullptr;
    breach([&] { kept = new int(3); });
    EXPECT_EQ(trap.allocations, 1u);
    breach([&] { delete kept; });
    EXPECT_EQ(trap.allocations, 1u);
    void* volatile raw = nullptr;
    breach([&] { raw = std::malloc(100); });
    EXPECT_EQ(trap.allocations, 1u);
    std::free(raw);
    std::mutex mutex;
    breach([&] { const std::lock_guard lock(mutex); });
    EXPECT_GE(trap.locks, 1u);
    std::shared_mutex shared;
    breach([&] { const std::shared_lock lock(shared); });
    EXPECT_GE(trap.locks, 1u);
  }
  if (trap.seesSystemCalls()) {
    breach([] { (void)getppid(); });
    EXPECT_EQ(trap.systemCalls, 1u);
    breach([] { usleep(1); });
    EXPECT_EQ(trap.systemCalls, 1u);
    breach([] {
      timespec t{};
      clock_gettime(CLOCK_MONOTONIC, &t);
    });
    EXPECT_EQ(trap.systemCalls, 0u) << "the clock of this machine is a system call: statistics of a tick cost one";
  } else {
    std::printf("this kernel has no system call user dispatch: system calls are not trapped\n");
  }
  auto* page = static_cast<char*>(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  breach([&] { *static_cast<volatile char*>(page) = 1; });
  EXPECT_GE(trap.pageFaults, 1u);
  munmap(page, 4096);
}

// A million ticks in the long tier.
TEST(ServoTick, KeepsToTheRulesOfRealTimeWhileItSculpts) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr uint64_t kTicks = 20'000;
#else
  const uint64_t kTicks = tests::byTier(100'000, 1'000'000);
#endif
  Tool tool;
  tool.radiusMm = 3;
  tool.work = haptics::Work::cut;
  VirtualSession session(0.5, tool);
  // All that contact can do: friction, texture, wells, a keep-out, a part beside the clay, clay of two materials.
  Scene& scene = session.scene();
  scene.materials[0].staticFriction = 0.4;
  scene.materials[0].dynamicFriction = 0.3;
  scene.textures.push_back(std::make_shared<const Texture>(Bumps{0.8, 0.02}));
  scene.materials[0].texture = 0;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].stiffnessNmm = 0.6;
  MaterialRows rows{};
  rows[1] = 1;
  scene.pieces[0].rows = std::make_shared<const MaterialRows>(rows);
  scene.pieces[0].version = testing::painted(scene.pieces[0].version, clay::Channel::material,
                                             [](Coord v) { return static_cast<uint8_t>((v.x >> 4) & 1); });
  scene.guides.resize(3);
  scene.guides[0] = {1, WellAtPlane{{0, 5, 0}, Vec3d::UnitY(), {3, 0.2}}, 0};
  scene.guides[1] = {2, KeepOutBall{{20, 0, 2}, 4, false}, 0};
  scene.guides[2] = {3, Gravity{{0, 0, -0.05}}, 0};
  scene.parts.push_back({std::make_shared<const PartMesh>(icosphere(5, 4)), Pose{{-15, 0, 2}}, 0});
  scene.check();
  session.publish();
  SimulatedDevice device(deviceSheet("touch"), testing::scribble(double(kTicks) * 1e-3, tool.radiusMm, 1.2));
  SampleRing ring(1000);
  ServoTick tick(device, session.published(), ring, 1e-3);
  // As the paced servo does: code that is first needed late must not be read then. Refused: what comes in is counted,
  // not judged.
  const bool locked = lockMemory();
  RealtimeTrap trap;
  uint64_t touching = 0, cutting = 0, stopped = 0;
  double peak = 0;
  for (uint64_t i = 0; i < kTicks; ++i) {
    session.step(ring, i);
    const double timeS = double(i) * 1e-3;
    trap.enter();
    const uint32_t flags = tick.run(timeS, false);
    trap.leave();
    // Its stack and code come in.
    if (i == 0) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
    touching += (flags & kTouching) != 0;
    cutting += (flags & kCutting) != 0;
    stopped += (flags & kStopped) != 0;
    peak = std::max(peak, tick.last().forceN.norm());
  }
  std::printf(
      "%llu ticks, %llu touching, %llu cutting, %llu strokes, %llu stamps, peak force %.2f N: %llu allocations, %llu "
      "locks, %llu system "
      "calls, %llu page faults\n",
      static_cast<unsigned long long>(kTicks), static_cast<unsigned long long>(touching),
      static_cast<unsigned long long>(cutting), static_cast<unsigned long long>(session.strokes),
      static_cast<unsigned long long>(session.stamps), peak, static_cast<unsigned long long>(trap.allocations),
      static_cast<unsigned long long>(trap.locks), static_cast<unsigned long long>(trap.systemCalls),
      static_cast<unsigned long long>(trap.pageFaults));
  EXPECT_GT(touching, kTicks / 3);
  EXPECT_GT(cutting, kTicks / 3);
  EXPECT_EQ(stopped, 0u);
  EXPECT_LE(peak, device.sheet().peakForceN);
  EXPECT_EQ(ring.dropped(), 0u);
  EXPECT_EQ(trap.allocations, 0u);
  EXPECT_EQ(trap.locks, 0u);
  EXPECT_EQ(trap.systemCalls, 0u);
  if (locked) unlockMemory();
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // Locked memory of ours is there. A kernel that watches or moves pages takes one away now and then all the same.
  if (locked) {
    EXPECT_LE(trap.pageFaults, 4u);
  }
#endif
}

/// Traps the servo's own thread from the device's reading to its writing: all of a tick but the sample's hand-over.
class TrappedDevice final : public Device {
 public:
  explicit TrappedDevice(Device& device) : device_(device) {}
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return device_.sheet(); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override {
    if (!trap) trap = std::make_unique<RealtimeTrap>();  // For the thread that ticks.
    trap->enter();
    return device_.read(timeS, state);
  }
  void write(double timeS, const Vec3d& force) ARGIL_REALTIME override {
    device_.write(timeS, force);
    if (!trap) return;
    trap->leave();
    // Its code came in.
    if (++ticks == 100) trap->allocations = trap->locks = trap->systemCalls = trap->pageFaults = 0;
  }
  ForceGate& gate() const noexcept override { return device_.gate(); }
  std::unique_ptr<RealtimeTrap> trap;
  uint64_t ticks = 0;

 private:
  Device& device_;
};

TEST(Servo, KeepsToTheRulesOfRealTimeWhenPaced) {
  const char* wanted = std::getenv("ARGIL_PACED_SECONDS");
  const double seconds = wanted ? std::max(1.0, std::atof(wanted)) : 2.0;
  Tool tool;
  tool.radiusMm = 3;
  tool.work = haptics::Work::cut;
  VirtualSession session(0.5, tool, 0, 1);
  SimulatedDevice device(deviceSheet("touch"), testing::scribble(seconds + 1, 3, 1.2));
  TrappedDevice trapped(device);
  Servo servo(trapped, session.published());
  const PacedFigures figures = measurePaced(
      servo, seconds, [&](double elapsed) { session.step(servo.samples(), static_cast<uint64_t>(elapsed * 1000)); });
  const RealtimeTrap& trap = *trapped.trap;
  std::printf(
      "%llu paced ticks, %llu touching: %llu allocations, %llu locks, %llu system calls, %llu page faults (%s)\n",
      static_cast<unsigned long long>(servo.statistics().ticks),
      static_cast<unsigned long long>(servo.statistics().touching), static_cast<unsigned long long>(trap.allocations),
      static_cast<unsigned long long>(trap.locks), static_cast<unsigned long long>(trap.systemCalls),
      static_cast<unsigned long long>(trap.pageFaults), figures.grant.sentence.c_str());
  EXPECT_GT(servo.statistics().touching, servo.statistics().ticks / 4);
  EXPECT_EQ(trap.allocations, 0u);
  EXPECT_EQ(trap.locks, 0u);
  EXPECT_EQ(trap.systemCalls, 0u);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  if (figures.grant.locked) {
    EXPECT_LE(trap.pageFaults, 4u);
  }
#endif
}

}  // namespace
}  // namespace argil::haptics
