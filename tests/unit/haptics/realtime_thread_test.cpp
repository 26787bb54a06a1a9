// What a real-time thread asks of the system, and what it leaves to others.

#include "haptics/threads/realtime_thread.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "haptics/devices/hand_path.h"
#include "haptics/devices/sheets.h"
#include "haptics/servo/servo.h"
#include "tests/support/virtual_session.h"

namespace argil::haptics {
namespace {

// Of all that is mapped and would stay once it is there, kB.
long lockedKb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmLck:")) return std::stol(line.substr(6));
  return -1;
}

// A number without a normal exponent, halved: zero where such numbers are flushed.
double halved() {
  volatile double tiny = std::numeric_limits<double>::min();
  tiny = tiny * 0.5;
  return tiny;
}

/// Says what arithmetic gives in the thread that ticks.
class CountingDevice final : public Device {
 public:
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return deviceSheet("touch"); }
  bool read(double, DeviceState& state) ARGIL_REALTIME override {
    state.pose.translation = {0, 0, 20};
    return true;
  }
  void write(double, const Vec3d&) ARGIL_REALTIME override {
    if (halved() == 0)
      ++flushed;
    else
      ++kept;
  }
  std::atomic<uint64_t> flushed{0}, kept{0};
};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LOCKS_UNDER_NO_SANITIZER() GTEST_SKIP() << "sanitizers lock no memory, and say that they did"
#else
#define LOCKS_UNDER_NO_SANITIZER() (void)0
#endif

TEST(RealtimeThread, AReservationIsNotMadeResidentByTheLock) {
  LOCKS_UNDER_NO_SANITIZER();
  if (!lockMemory()) GTEST_SKIP() << "this system locks no memory";
  constexpr size_t kArena = 66u << 20, kPage = 4096;
  void* arena = mmap(nullptr, kArena, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  ASSERT_NE(arena, MAP_FAILED);
  static_cast<volatile char*>(arena)[5 * kPage] = 1;
  std::vector<unsigned char> there(kArena / kPage);
  ASSERT_EQ(mincore(arena, kArena, there.data()), 0);
  size_t resident = 0;
  for (const unsigned char page : there) resident += page & 1;
  EXPECT_LE(resident, 512u) << "pages; one was used (a huge page at most)";
  EXPECT_GE(lockedKb(), long(kArena >> 10)) << "what comes in stays";
  munmap(arena, kArena);
  unlockMemory();
}

TEST(RealtimeThread, TheLockLastsUntilTheLastUserIsGone) {
  LOCKS_UNDER_NO_SANITIZER();
  testing::VirtualSession session(0.5, Tool());
  CountingDevice left, right;
  Servo first(left, session.published()), second(right, session.published());
  if (!first.start().locked) GTEST_SKIP() << "this system locks no memory";
  ASSERT_TRUE(second.start().locked);
  EXPECT_GT(lockedKb(), 0);
  first.stop();
  EXPECT_GT(lockedKb(), 0) << "the second still ticks";
  second.stop();
  EXPECT_EQ(lockedKb(), 0);
}

TEST(RealtimeThread, OnlyThePacedServoTakesDenormalsForZero) {
  testing::VirtualSession session(0.5, Tool());
  CountingDevice device;
  Servo servo(device, session.published());
  servo.runVirtual(10);
  EXPECT_EQ(device.flushed, 0u) << "virtual time has equal bits everywhere";
  EXPECT_EQ(device.kept, 10u);
  (void)servo.start();
  while (device.flushed + device.kept < 60) std::this_thread::yield();
  EXPECT_GT(halved(), 0) << "whoever started it keeps them";
  double other = 0;
  std::thread([&] { other = halved(); }).join();
  EXPECT_GT(other, 0) << "so do other threads";
  servo.stop();
#if defined(__SSE2__) || defined(__aarch64__)
  EXPECT_GE(device.flushed, 49u);
  EXPECT_LE(device.kept, 11u) << "the ten of virtual time, and the last zero on the way out";
#endif
}

}  // namespace
}  // namespace argil::haptics
