#pragma once
// A workbench without a window: what its tests share.

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "engine/session/workbench.h"

namespace argil::engine {

using namespace std::chrono_literals;

/// Waits for what comes with the next turns, a minute at most: the machine may be busy.
[[nodiscard]] inline bool until(const std::function<bool()>& what) {
  for (int i = 0; i < 150'000; ++i) {
    if (what()) return true;
    std::this_thread::sleep_for(2ms);
  }
  return false;
}

inline Workbench::Options withoutJournal() {
  Workbench::Options given;
  given.journal = false;
  given.realtime = false;
  return given;
}

/// All that is said but what is merely done.
inline std::string problemsOf(Workbench& bench) {
  std::string all;
  for (const Message& message : bench.takeMessages()) {
    if (message.level != Message::Level::done) all += message.text + "\n";
  }
  return all;
}

/// A pointer that looks straight down on a block whose top is at z = 10.
class Finger {
 public:
  explicit Finger(Workbench& bench) : bench_(bench) {
    sample_.direction = {0, 0, -1};
    sample_.surfaceMm = 50;
  }
  /// The tip `depthMm` below the top, or above it where that is negative.
  void feed(double x, uint32_t buttons, double depthMm) {
    sample_.origin = {x, 0, 60 - depthMm};
    sample_.buttons = buttons;
    bench_.feedPointer(sample_);
    std::this_thread::sleep_for(4ms);
  }

 private:
  Workbench& bench_;
  haptics::PointerSample sample_;
};

class WorkbenchTest : public ::testing::Test {
 protected:
  [[nodiscard]] bool rest() {
    return until([&] { return bench.idle(); });
  }
  DocumentPtr document() { return bench.snapshot()->document; }
  void block() {
    bench.addBlock({40, 40, 20}, 2, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  }
  // Along x, with the button down.
  void drag(double depthMm) {
    for (int i = 0; i < 30; ++i) finger.feed(-10, 0, -8);
    for (int i = 0; i < 30; ++i) finger.feed(-10, 1, depthMm);
    for (int i = 0; i <= 40; ++i) finger.feed(-10 + 0.5 * i, 1, depthMm);
    for (int i = 0; i < 30; ++i) finger.feed(10, 0, -8);
  }
  std::string problems() { return problemsOf(bench); }

  Workbench bench{withoutJournal()};
  Finger finger{bench};
};

}  // namespace argil::engine
