#pragma once
// A workbench without a window: what its tests share.

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "engine/workbench.h"

namespace argil::engine {

using namespace std::chrono_literals;

class WorkbenchTest : public ::testing::Test {
 protected:
  static Workbench::Options options() {
    Workbench::Options given;
    given.journal = false;
    given.realtime = false;
    return given;
  }
  // Waits for what comes with the next turns.
  [[nodiscard]] bool until(const std::function<bool()>& what) {
    for (int i = 0; i < 5000; ++i) {
      if (what()) return true;
      std::this_thread::sleep_for(2ms);
    }
    return false;
  }
  [[nodiscard]] bool rest() {
    return until([&] { return bench.idle(); });
  }
  DocumentPtr document() { return bench.snapshot()->document; }
  void block() {
    bench.addBlock({40, 40, 20}, 2, {.voxelMm = 0.5});
    ASSERT_TRUE(until([&] { return document()->pieces.size() == 1; }));
  }
  // From above, along x, with the button down; the tip `depthMm` below the block's top at z = 10.
  void drag(double depthMm) {
    haptics::PointerSample sample;
    sample.direction = {0, 0, -1};
    sample.surfaceMm = 50;
    const auto feed = [&](double x, uint32_t buttons, double depth) {
      sample.origin = {x, 0, 60 - depth};
      sample.buttons = buttons;
      bench.feedPointer(sample);
      std::this_thread::sleep_for(4ms);
    };
    for (int i = 0; i < 30; ++i) feed(-10, 0, -8);
    for (int i = 0; i < 30; ++i) feed(-10, 1, depthMm);
    for (int i = 0; i <= 40; ++i) feed(-10 + 0.5 * i, 1, depthMm);
    for (int i = 0; i < 30; ++i) feed(10, 0, -8);
  }
  std::string problems() {
    std::string all;
    for (const Message& message : bench.takeMessages()) {
      if (message.level != Message::Level::done) all += message.text + "\n";
    }
    return all;
  }

  Workbench bench{options()};
};

}  // namespace argil::engine
