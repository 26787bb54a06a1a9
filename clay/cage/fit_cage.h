#pragma once
// A smooth surface fitted to a clay.

#include "clay/base/work_part.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/patch_deviation.h"
#include "clay/cage/patch_net.h"

namespace argil::clay {

/// Seconds on the clock that went into drawing cages, fitting patches to the clay and measuring how far they lie off,
/// of all tries together.
struct FitTimes {
  double cages = 0, fits = 0, measuring = 0;
};

struct FittedPatches {
  PatchSurface surface;
  CoarseCage cage;
  size_t irregular = 0;  ///< Vertices of the cage where other than four quads meet.
  PatchDeviation deviation;
  WishesMet met;
  FitTimes times;
};

/// A cage of at most `most` quads, and one patch for each, as near to the clay as they come. The cage is made three
/// times, each finer where the fit before lay off, and the best is fitted to the end. The same for any count of
/// threads. Throws as coarseCage(). Cost: 30 to 50 ms a quad.
[[nodiscard]] FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part,
                                       const CageWishes& wishes = {});

/// A count of quads that was tried.
struct PatchTry {
  size_t quads = 0;
  double mostMm = 0;   ///< The farthest place of either way,
  double boundMm = 0;  ///< and what none lies beyond.
};
/// Patches that lie within `errorMm` of the clay everywhere, both ways, with their bound: as few as a handful of tries
/// finds, `most` at most. Where that many do not reach it, those that come nearest, with `deviation.far`. `tries`: in
/// the order in which they were made. Throws as fitPatches(). Cost: that of each try.
[[nodiscard]] FittedPatches fitPatchesWithin(const Version& version, double errorMm, size_t most, int threads,
                                             const WorkPart& part, std::vector<PatchTry>& tries,
                                             const CageWishes& wishes = {});

}  // namespace argil::clay
