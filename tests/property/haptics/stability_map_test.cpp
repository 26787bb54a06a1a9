// The closed loop over delays and rates: at what it is coupled at it stays stable in every cell, through the device's
// thread too.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "haptics/analysis/stability_bench.h"
#include "haptics/devices/sheets.h"

namespace argil::haptics {
namespace {

struct Cell {
  StabilityCase what;
  std::string name;
  StabilityFigures figures;
};

void runAll(std::vector<Cell>& cells) {
  std::atomic<size_t> next{0};
  const auto work = [&] {
    for (size_t i = next++; i < cells.size(); i = next++) cells[i].figures = runStability(cells[i].what);
  };
  std::thread other(work);
  work();
  other.join();
}

// Every device, task and hand that holds it; at each, what `of` makes of a delay and a rate.
template <class Of>
std::vector<Cell> map(std::initializer_list<double> rates, std::initializer_list<double> delays, Of&& of,
                      double heldBelowHz = 0) {
  std::vector<Cell> cells;
  for (const DeviceSheet& sheet : deviceSheets())
    for (const double rate : rates)
      for (const double delay : delays)
        for (const StabilityTask task : kStabilityTasks)
          for (const StabilityHand& hand : stabilityHands()) {
            // Pushed along by nobody's hand, friction does not hold it across the clay:
            // haptics/servo/stability.md says how far that goes.
            if (task == StabilityTask::glide && !(hand.model.stiffnessNmm > 0)) continue;
            // An arm that answers so rarely and that nobody holds bounces on what is then so soft:
            // haptics/servo/stability.md.
            if (heldBelowHz > rate && !(hand.model.stiffnessNmm > 0)) continue;
            Cell cell;
            cell.what.sheet = sheet;
            cell.what.hand = hand.model;
            cell.what.task = task;
            of(cell.what, rate, delay);
            char text[120];
            std::snprintf(text, sizeof text, "%s, %.0f Hz, %.1f ms, %s hand, %s", sheet.name.c_str(), rate, 1e3 * delay,
                          hand.name, name(task));
            cell.name = text;
            cells.push_back(cell);
          }
  return cells;
}

int judge(const std::vector<Cell>& cells) {
  int wild = 0;
  double softest = 1e9, stiffest = 0;
  for (const Cell& cell : cells) {
    softest = std::min(softest, cell.figures.stiffnessNmm);
    stiffest = std::max(stiffest, cell.figures.stiffnessNmm);
    if (cell.figures.stable()) continue;
    ++wild;
    ADD_FAILURE() << cell.name << " at " << cell.figures.stiffnessNmm << " N/mm (loop " << 1e3 * cell.figures.delayS
                  << " ms): swings by " << cell.figures.startCycleMm << " mm, then by " << cell.figures.endCycleMm
                  << (cell.figures.stopped ? " mm, stopped" : " mm");
  }
  std::printf("%zu cells, coupled at %.2f to %.2f N/mm, %d not stable\n", cells.size(), softest, stiffest, wild);
  return wild;
}

TEST(StabilityMap, StaysStableAtItsCouplingOverDelaysAndRates) {
  auto cells = map({125, 500, 1000, 8000}, {0, 0.001, 0.005}, [](StabilityCase& c, double rate, double delay) {
    c.rateHz = c.sheet.rateHz = rate;
    c.delayS = delay;
    c.coupling = coupleTo(c.sheet, 1 / rate, delay);
  });
  runAll(cells);
  EXPECT_EQ(judge(cells), 0);
}

// What ignores the delay does not: what this map is there for.
TEST(StabilityMap, SwingsWhereTheDelayIsIgnored) {
  auto cells = map({1000}, {0.003, 0.005}, [](StabilityCase& c, double rate, double delay) {
    c.rateHz = c.sheet.rateHz = rate;
    c.delayS = delay;
    c.coupling = coupleTo(c.sheet, 1 / rate, 0);
  });
  runAll(cells);
  const auto wild = std::count_if(cells.begin(), cells.end(), [](const Cell& cell) { return !cell.figures.stable(); });
  std::printf("%ld of %zu cells swing\n", static_cast<long>(wild), cells.size());
  EXPECT_GT(wild, static_cast<long>(cells.size() / 10));
}

// The servo at 1 kHz, the device's own thread beside it, whose exchanges drift against the servo's ticks: the servo
// measures the delay and couples by itself.
TEST(StabilityMap, StaysStableThroughTheDevicesThread) {
  auto cells = map(
      {125, 500, 1000, 8000}, {0.0001, 0.001, 0.002},
      [](StabilityCase& c, double rate, double delay) {
        c.exchangesHz = c.sheet.rateHz = rate;
        c.delayS = std::min(delay, 1 / rate);
      },
      333);
  runAll(cells);
  EXPECT_EQ(judge(cells), 0);
  for (const Cell& cell : cells) {
    // An exchange, and what servo and device wait for each other: up to a tick, and up to a period of the device.
    EXPECT_GT(cell.figures.delayS, 0.9 * cell.what.delayS) << cell.name;
    EXPECT_LT(cell.figures.delayS, cell.what.delayS + 1e-3 + std::max(1e-3, 1 / cell.what.exchangesHz) + 1e-4)
        << cell.name;
  }
}

}  // namespace
}  // namespace argil::haptics
