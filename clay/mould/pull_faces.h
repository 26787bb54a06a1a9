#pragma once
// What of a surface a pull along one direction leaves behind: undercuts, and too little draft.

#include <cstdint>
#include <vector>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// Which half of a mould a face comes out of.
enum class PullSide : uint8_t {
  upper,     ///< It looks along the pull or stands upright, and nothing lies above it.
  lower,     ///< It looks against the pull or stands upright, and nothing lies below it.
  undercut,  ///< Something is in the way: neither half can be taken off.
};

struct PullFaces {
  std::vector<PullSide> sides;  ///< One for each triangle.
  /// The draft of each triangle, degrees: of its face, as corners may lie off the face by the slack.
  std::vector<float> drafts;
  double upperMm2 = 0, lowerMm2 = 0, undercutMm2 = 0;
  double steepMm2 = 0;  ///< Of what comes out: less than the draft that was asked for.
};

/// The angle between a face and the pull, degrees: 90 where it looks along it, 0 for a wall that stands upright,
/// negative where it looks against it. `normal` and `pull` of any length but zero.
[[nodiscard]] double draftDegrees(const Vec3d& normal, const Vec3d& pull);

/// Each face by a line from its middle along the pull, or against it where it looks that way; of one that stands
/// upright within a degree either will do. The line begins `slackMm` before the face, so that a wall which stands
/// upright does not cover itself for being uneven by less; draft allows for the same unevenness. Exact but for that: no
/// picture of heights stands between. The same for any `threads`. `pull`: a unit vector. Cost: about 0.5 s for a
/// million triangles on two threads.
[[nodiscard]] PullFaces pullFaces(const TriangleMesh& mesh, const Vec3d& pull, double slackMm, double draftDegrees,
                                  int threads);

}  // namespace argil::clay
