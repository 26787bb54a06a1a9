#pragma once
// A script from beginning to end: what `argil sculpt` and the demo do.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "clay/base/job.h"
#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/text/script.h"
#include "haptics/base/histogram.h"

namespace argil::engine {

/// Microseconds of something that happened n times; all zero when it never did.
struct Timing {
  uint64_t n = 0;
  double median = 0, p99 = 0, p999 = 0, max = 0;
  static Timing of(const haptics::Histogram& histogram);
};

/// What a servo did in a run; hand-driven strokes only.
struct ServoReport {
  uint64_t ticks = 0, cutting = 0, touching = 0;
  uint64_t overrun = 0, missed = 0, dropped = 0, clamped = 0, slewed = 0, stopped = 0;
  uint64_t waiting = 0;  ///< Ticks in which forces waited to begin and tools rested.
  Timing compute;
  /// From a sample to the tick that feels the clay as it changed it, the oldest of each edit; whole ticks.
  Timing editToFeel;
  /// Live only; a loop that only sleeps ran beside it in the same seconds.
  std::optional<Timing> lateness, bareLateness;
  double peakForceN = 0, forceLimitN = 0;  ///< On the hand, and the device's own limit.
  std::string grant;                       ///< Live: what the system granted, in plain words.
  uint64_t stalls = 0;  ///< Live: how often the machine stalled so long that the watchdog cut the force.
  std::string fault;    ///< Why forces were stopped; empty when they were not.
};

struct RunReport {
  uint64_t strokes = 0, points = 0, stamps = 0, versions = 0;
  uint64_t idle = 0;  ///< Strokes of the script that changed nothing; each has a sentence in `notes`.
  clay::Editor::Counts clay;
  Timing edit;  ///< From a sample (tip: a point) to its changed triangles being ready.
  std::optional<ServoReport> servo;
  /// Strokes, as they were cut, and operations alone: after the same clay a tip-driven script of equal bits (where
  /// pieces are moved or turned, equal to rounding).
  Script recorded;
  std::vector<std::string>
      notes;           ///< What the operations found out and which strokes changed nothing, a sentence each.
  double seconds = 0;  ///< Wall time.
};

struct RunOptions {
  bool live = false;             ///< Hand-driven strokes through a servo in real time, else in virtual time.
  std::string device = "touch";  ///< Sheet of the simulated device (haptics/devices/sheets.h).
  double rateHz = 1000;          ///< Where the script has no quality.
  double publishDelayS = 0.004;  ///< Virtual time: from the last sample of a version to the servo reading it.
  size_t pointsPerVersion = 8;   ///< Tip-driven strokes: the result does not depend on it.
  int surfaceThreads = 1;
  std::function<void(const clay::SurfaceDelta&)> onSurface = {};
  Job* job = nullptr;  ///< Progress; cancel ends the run within a stroke.
};

/// Runs strokes and operations on the session and keeps `surface` at the newest version of the piece that is worked on.
/// Tip-driven strokes and hand-driven ones in virtual time give the same clay in every run. Neighbouring hand-driven
/// strokes are one walk of the hand: it travels from the end of a path to the beginning of the next with the button
/// released; an operation or another piece in between ends the walk. Throws Error, which names the step (kind work when
/// a live servo stopped the force for good), Cancelled; then the strokes and operations so far are in the session, each
/// whole.
RunReport runScript(Session& session, clay::Surface& surface, const Script& script, const RunOptions& options = {});

}  // namespace argil::engine
