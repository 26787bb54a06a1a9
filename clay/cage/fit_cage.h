#pragma once
// A smooth surface fitted to a clay.

#include "clay/base/work_part.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/patch_deviation.h"
#include "clay/cage/patch_net.h"

namespace argil::clay {

struct FittedPatches {
  PatchSurface surface;
  CoarseCage cage;
  size_t irregular = 0;  ///< Vertices of the cage where other than four quads meet.
  PatchDeviation deviation;
};

/// A cage of at most `most` quads, and one patch for each, as near to the clay as they come. The cage is made three
/// times, each finer where the fit before lay off, and the best is fitted to the end. The same for any count of
/// threads. Throws as coarseCage(). Cost: 30 to 50 ms a quad.
[[nodiscard]] FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part);

}  // namespace argil::clay
