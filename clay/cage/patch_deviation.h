#pragma once
// How far smooth patches lie off a clay.

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/base/work_part.h"
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
  /// Bound of the patches' distance from the clay, never below mostMm(), as long as neither surface bends by more
  /// between two places that were looked at than it does at these.
  double boundMm = 0;
  /// The farthest places of either way, the farthest first, a fiftieth of the size apart: those beyond a limit, at most
  /// kMostFarPlaces.
  struct Place {
    Vec3d mm = Vec3d::Zero();
    double offMm = 0;
  };
  std::vector<Place> far;
  /// Where the patches fold over themselves, as far apart; at most kMostFarPlaces.
  std::vector<Vec3d> foldsMm;
  [[nodiscard]] double mostMm() const { return std::max(fromPatches.max, fromClay.max); }
};
inline constexpr size_t kMostFarPlaces = 10;

/// Both ways, at `perSpan`² places a span and at every vertex of the clay's mesh. `limitMm`: what counts as far.
[[nodiscard]] PatchDeviation deviationOf(const PatchSurface& surface, const TriangleMesh& clay, int perSpan,
                                         int threads, const WorkPart& part, double limitMm = HUGE_VAL);

/// Places of a mesh where a triangle faces against what is around it: where it folds. By vertices, each once.
[[nodiscard]] std::vector<uint32_t> foldsOf(const TriangleMesh& mesh);
/// The same of meshOf(surface, perSpan), each side of its creases for itself.
[[nodiscard]] std::vector<uint32_t> foldsOf(const PatchSurface& surface, const TriangleMesh& mesh, int perSpan);

/// Triangles between `perSpan`² places a span, counter-clockwise seen from outside, closed.
[[nodiscard]] TriangleMesh meshOf(const PatchSurface& surface, int perSpan);

}  // namespace argil::clay
