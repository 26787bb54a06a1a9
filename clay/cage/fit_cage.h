#pragma once
// A smooth surface fitted to a clay, and how far it lies off.

#include "clay/base/work_part.h"
#include "clay/cage/coarse_cage.h"
#include "clay/cage/patch_net.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// Distances one way, mm, at `points` places.
struct OneWay {
  double rms = 0, p99 = 0, max = 0;
  size_t points = 0;
  Vec3d worstMm = Vec3d::Zero();  ///< Where the largest is.
};
struct PatchDeviation {
  OneWay fromPatches, fromClay;  ///< From the patches to the clay's surface; and the other way.
  /// Of the patches: no place of them lies farther off than this, as long as neither surface bends by more between two
  /// places that were looked at than it does at these.
  double boundMm = 0;
};

struct FittedPatches {
  PatchSurface surface;
  CoarseCage cage;
  size_t irregular = 0;  ///< Vertices of the cage where other than four quads meet.
  PatchDeviation deviation;
};

/// A cage of at most `most` quads, and one patch for each, as near to the clay as they come: least squares of the
/// patches themselves, without a conversion behind them, to nearest places of the clay's surface that are looked for
/// again and again. Throws as coarseCage(). Cost: about 40 ms a quad.
[[nodiscard]] FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part);

/// Both ways, at `perSpan`² places a span and at every vertex of the clay's mesh.
[[nodiscard]] PatchDeviation deviationOf(const PatchSurface& surface, const TriangleMesh& clay, int perSpan,
                                         int threads, const WorkPart& part);

/// Triangles between `perSpan`² places a span, counter-clockwise seen from outside, closed.
[[nodiscard]] TriangleMesh meshOf(const PatchSurface& surface, int perSpan);

}  // namespace argil::clay
