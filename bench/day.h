#pragma once
// What the parts of `argil bench day` share.

#include <cstdint>

#include "bench/bench.h"
#include "clay/store/store.h"

namespace argil::bench {

/// Limits that a day must keep; a figure beyond one is marked in the table and counted.
struct DayLimits {
  double growth = 1.2;              ///< Cost of a second of hand in a longer stroke ÷ that in one of 10 s.
  double handTime = 0.5;            ///< Time of the processor ÷ time of the hand.
  double pictureMs = 33;            ///< From one version with its surface to the next.
  double memory = 2;                ///< Bytes beyond the clay ÷ bytes that the stroke changed,
  uint64_t spareBytes = 64u << 20;  ///< beside this.
  double pieces = 1.5;              ///< A stroke among 1 000 pieces ÷ the same with one.
  uint64_t pieceBytes = 100'000;    ///< Of a piece, beside its clay.
  double hours = 1.2;               ///< Last quarter of the day ÷ the first.
};

/// Bytes in use: of malloc, and of bricks and nodes of one store. What the process holds free for later does not count,
/// so a cell of the table does not profit from what the one before it has left.
[[nodiscard]] uint64_t bytesInUse(const clay::Store* store = nullptr);

/// (a) Every tool with tips of 2 to 200 voxels through strokes of 1 to `longestS` seconds.
void benchDayStrokes(BenchReport& report, const BenchOptions& options);
/// (b) 1, 64 and 1 000 pieces.
void benchDayPieces(BenchReport& report, const BenchOptions& options);
/// (c) Hours of mixed work from a seed.
void benchDayHours(BenchReport& report, const BenchOptions& options);
/// (d) A scan of many triangles becomes clay.
void benchDayImport(BenchReport& report, const BenchOptions& options);

}  // namespace argil::bench
